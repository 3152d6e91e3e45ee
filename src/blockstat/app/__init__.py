"""The live page: a building, its parameters as sliders, and the verdict that follows them.

This room imports `analysis`, `imperfection`, `large_displacement`, `view`, `io`, `spec`, `contact`, `system` and the
root. The command line opens it, and the panel of the dynamics adds to it.
"""
