"""Solvers of the one conic program: the interior-point method, Clarabel and cvxpy; and the programs of a verdict.

This room imports `certificate` (to end a solve early), `program`, `linear_algebra`, `geometry` and the root. Nothing it
answers is trusted.
"""
