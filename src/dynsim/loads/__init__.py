"""Loads: what acts on an assembly while it is simulated, and comes to an end.

This room imports `engine`, and of `blockstat` the root and `system`.
"""
