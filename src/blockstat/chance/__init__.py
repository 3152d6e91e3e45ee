"""The probability that an assembly falls when friction, joints, corners, weights and loads are random.

This room imports `analysis`, `sensitivity`, `solve` and `program` (for the multiples of a load that are carried where
the dead load is not), `imperfection`, `contact`, `spec`, `system` and the root.
"""
