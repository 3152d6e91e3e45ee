"""Views in three dimensions, drawn with viser.

This room imports `view` and what `view` may import.
"""
