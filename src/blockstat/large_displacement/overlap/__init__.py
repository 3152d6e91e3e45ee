"""Contact points of joints that slide: where the faces, edges and corners of two blocks are above each other at a pose.

This room imports `large_displacement.displaced`, `contact`, `geometry` and the root.
"""
