"""Limit analysis of a displaced structure: forces in equilibrium, limit multipliers, mechanisms, and implicit steps.

This room imports `large_displacement.displaced`, `analysis`, `certificate`, `program`, `solve` and the root.
"""
