"""Files of blocks in and out, and scene files.

This room imports the root, `geometry` and `system`.
"""
