"""A mechanism as a linkage: its parts, its exact pose, the path that it follows, the events on it, and jumps.

This room imports `large_displacement.displaced`, `large_displacement.overlap`, `large_displacement.statics`,
`analysis`, `geometry`, `program` and the root.
"""
