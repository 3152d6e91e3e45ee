"""Views in three dimensions, drawn with viser.

This room imports `view`, `analysis`, `contact`, `geometry` and the root.
"""
