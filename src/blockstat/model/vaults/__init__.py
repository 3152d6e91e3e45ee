"""Barrel, groin, pavilion, sail, fan and freeform vaults, domes, and vaults from a mesh.

This room imports `model.arches.profile`, `model.solids` and `geometry`.
"""
