"""Runs as files: animated GLB, NPZ, film strips.

This room imports `judge`, `loads`, `engine`, and of `blockstat` the root, `io`, `spec`, `view` and `system`.
"""
