"""Closed polyhedra, convex polygons and boxes as plain arrays.

This room knows nothing of masonry. It imports `typing` and `errors`.
"""
