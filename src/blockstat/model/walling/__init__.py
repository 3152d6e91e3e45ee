"""Walls of bonded bricks: runs, courses, openings and gables.

This room imports `model.solids`, `geometry` and `model.arches.profile`.
"""
