"""GLB, STL and PLY files as they stand: names and orders that trimesh changes, and what it would leave out.

This room imports `geometry` and the root.
"""
