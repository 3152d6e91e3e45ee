"""Walls of bonded bricks: runs, courses, openings, gables, and the buttresses of a wall.

`walls` cuts runs into strips, finds where they meet (`junction`), and lays each course of a strip (`row`) in its bond
(`pattern`) between openings (`heads`).

This room imports `model.arches` (profiles), `model.solids`, `model.quantities`, `geometry` and the root.
"""
