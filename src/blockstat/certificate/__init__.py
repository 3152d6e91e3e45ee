"""The independent check of forces and mechanisms, in plain numpy.

This room imports `program`. It trusts nothing that a solver says.
"""
