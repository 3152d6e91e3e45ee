"""Surfaces of solids: faces that lie in one plane, faces folded on others, and how far apart surfaces are.

This room imports `geometry` and the root.
"""
