"""Barrel, groin, pavilion, sail, fan and freeform vaults, domes, and vaults from a mesh.

A new vault type is a function here, in a module of its own where none fits, and a line of `blockstat.model.kinds`.

This room imports `model.walling` (bonds), `model.arches` (profiles), `model.solids`, `model.quantities` and the root.
"""
