"""Runs as files (animated GLB, NPZ, film strips), and curves of incremental dynamic analysis.

This room imports `earthquake`, `judge`, `loads`, `engine`, and of `blockstat` the root, `contact`, `io`, `spec`, `view`
and `system`.
"""
