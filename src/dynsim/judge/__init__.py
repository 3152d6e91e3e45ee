"""Runs of a simulation and the verdict on them: settling, rest, displacement criteria, cracks, limits, plans.

This room imports the root, `engine`, `loads`, `bonds`, and of `blockstat` the root, `geometry`, `contact`,
`geometry_repair`, `program`, `analysis` and `sequence`.
"""
