"""Blocks whose surface passes through itself, and how much stone it counts more than once.

This room imports `geometry` and the root.
"""
