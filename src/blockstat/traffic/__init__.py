"""Axle trains that move over an assembly: the limit load at each place, and the worst of them.

This room imports `analysis`, `solve`, `certificate`, `program`, `loading`, `contact` and the root.
"""
