"""Mechanisms that are no linkage, followed by finite steps: limit analysis, step and projection, or implicit steps.

This room imports `large_displacement.linkage`, `large_displacement.statics`, `large_displacement.overlap`,
`large_displacement.displaced`, `analysis`, `linear_algebra`, `program`, `contact`, `solve` and the root.
"""
