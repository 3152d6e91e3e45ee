"""Closed polyhedra, convex polygons and boxes as plain arrays.

It knows nothing of masonry. This room imports the root.
"""
