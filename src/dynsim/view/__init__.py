"""Runs as files: animated GLB, NPZ, film strips.

This room imports `judge`, and of `blockstat` the root, `io`, `spec`, `view` and `system`.
"""
