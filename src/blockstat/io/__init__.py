"""Files of blocks in and out, and scene files.

This room imports the root and `geometry`.
"""
