"""The probability that an assembly falls when friction, joints, corners, weights and loads are random.

This room imports `analysis`, `sensitivity`, `solve` (for the type of an answer), `imperfection`, `contact`, `spec`,
`system` and the root.
"""
