"""Solvers of the one conic program: the interior-point method, Clarabel and cvxpy; and the programs of a verdict.

This room imports `certificate` (to end a solve early), `program` and `linear_algebra`. Nothing it answers is trusted.
"""
