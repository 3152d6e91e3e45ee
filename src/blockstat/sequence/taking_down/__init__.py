"""Single blocks taken out of an assembly, and what falls with each.

This room imports `sequence`, `analysis`, `contact` and the root.
"""
