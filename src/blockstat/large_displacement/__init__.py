"""Beyond the first motion: load multiplier against displacement, with a bracket at each step.

This room imports `analysis`, `certificate`, `contact`, `geometry`, `program`, `solve` and the root.
"""
