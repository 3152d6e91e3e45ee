"""Files as they stand: names and orders that trimesh changes, what it would leave out, and solids in one list of faces.

This room imports `contact`, `geometry` and the root.
"""
