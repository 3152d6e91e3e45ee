"""The live page: a building, its parameters as sliders, and the verdict that follows them.

This room imports `analysis`, `view`, `io`, `model`, `spec` and the root. Nothing imports it but the command line.
"""
