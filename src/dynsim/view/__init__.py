"""Runs as files: animated GLB, NPZ, film strips.

This room imports `judge` and `blockstat.view`.
"""
