"""The independent check of forces and mechanisms, in plain numpy.

This room imports `program` and `linear_algebra`. It trusts nothing that a solver says.
"""
