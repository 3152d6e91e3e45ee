"""Arches of voussoirs, the profiles that cut them, and the piers and columns that carry them.

This room imports `model.solids`, `model.quantities` and the root.
"""
