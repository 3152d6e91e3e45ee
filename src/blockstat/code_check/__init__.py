"""Code checks of collapse mechanisms: NTC 2018 with Circolare 7/2019.

This room imports `analysis`, `geometry`, `large_displacement` and the root.
"""
