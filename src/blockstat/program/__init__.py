"""The equilibrium of an assembly, its penalty program and the one conic program of all solvers, as plain arrays.

This room imports `contact`, `geometry` and the root. It knows no solver and no option of one.
"""
