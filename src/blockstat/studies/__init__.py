"""Studies that put several analyses together: the limit load over the horizon, and supports that settle.

This room imports `analysis`, `certificate`, `contact`, `large_displacement`, `program` and the root.
"""
