"""Barrel, groin, pavilion, sail, fan and freeform vaults, domes, and vaults from a mesh.

A new vault type is a module here; `blockstat.model` says how it becomes an element of scene files.

This room imports `model.walling` (bonds), `model.arches` (profiles), `model.solids`, `model.quantities` and the root.
"""
