"""A buttress by itself, and flying buttresses; those of a wall are made with the wall.

This room imports `model.walling`, `model.arches`, `model.placing`, `model.solids`, `model.quantities`, `geometry` and
the root.
"""
