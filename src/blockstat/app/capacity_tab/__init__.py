"""The tab "Capacity" of the live page: a capacity curve, and the blocks at each of its states.

This room imports `app`, `large_displacement`, `large_displacement.linkage`,
`large_displacement.finite_steps`, `analysis`, `view`, `view.three_d` and the root.
"""
