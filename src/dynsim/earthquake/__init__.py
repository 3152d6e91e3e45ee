"""Incremental dynamic analysis: records scaled until a block falls, and the fragility over a set of them.

This room imports the root, `engine`, `loads`, `judge`, `parallel`, and of `blockstat` the root, `contact` and `system`.
"""
