"""What may act on an assembly while it is simulated: tilting or shaking ground, settlements, removals, pushes.

This room imports `engine` and the root.
"""
