"""Code checks of collapse mechanisms: NTC 2018 with Circolare 7/2019.

This room imports `analysis`, `contact`, `geometry`, `large_displacement`, `program`, `solve` and the root.
"""
