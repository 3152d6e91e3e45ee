"""Pictures of a building that goes up or comes down: the steps of a plan, and what falls with each block.

This room imports `sequence`, `sequence.taking_down`, `view`, `view.three_d`, `analysis` and the root.
"""
