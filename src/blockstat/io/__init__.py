"""Files of blocks in and out, and scene files.

This room imports the root, `contact`, `geometry` and `system`.
"""
