"""The independent check of forces and mechanisms, in plain numpy.

This room imports `program`, `linear_algebra`, `geometry`, `contact` (for types) and the root. It trusts nothing
that a solver says.
"""
