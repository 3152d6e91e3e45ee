"""Studies that put several analyses together: limit loads over the horizon and of two loads, settlements.

This room imports `analysis`, `certificate`, `contact`, `large_displacement`, `program` and the root.
"""
