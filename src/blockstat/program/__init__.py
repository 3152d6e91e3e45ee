"""The equilibrium of an assembly and its conic programs, as plain data.

This room imports `contact` and the root. It knows no solver.
"""
