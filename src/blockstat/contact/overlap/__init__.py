"""What blocks that overlap touch, and how far they run into each other.

This room imports `contact`, `geometry`, `surface` and the root.
"""
