"""Closed polyhedra, convex polygons and boxes as plain arrays.

This room knows nothing of masonry. This room imports `typing` and `errors` of the root.
"""
