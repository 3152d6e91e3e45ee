"""The tab "Capacity" of the live page: a capacity curve, and the blocks at each of its states.

This room imports `app`, `large_displacement`, `analysis`, `view`, `view.three_d` and the root.
"""
