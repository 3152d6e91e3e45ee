"""What real masonry lacks of the drawing: joints that lost their edges, less friction, other weights and loads.

This room imports `contact`, `geometry` and the root.
"""
