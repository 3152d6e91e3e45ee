"""Solvers of the conic programs: the interior-point method, Clarabel, and the literal program in cvxpy.

This room imports `program` and `certificate` (to end a solve early).
"""
