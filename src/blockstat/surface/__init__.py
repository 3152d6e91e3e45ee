"""Surfaces of solids: faces that lie in one plane, folded faces, cones at corners, and how far apart surfaces are.

This room imports `geometry` and the root.
"""
