"""Sparse factorisations and the normal equations of programs whose rows each touch two blocks.

This room imports the root. The certificate balances forces with it, and the solvers step with it.
"""
