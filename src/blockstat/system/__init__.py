"""What is asked of the operating system: files read with care and written whole, locks, and processes that end.

This room imports the root.
"""
