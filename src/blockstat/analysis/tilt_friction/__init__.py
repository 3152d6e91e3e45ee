"""How far an assembly is from falling: the tilt it bears and the least friction it needs.

This room imports `analysis`, `contact`, `imperfection`, `solve` and the root.
"""
