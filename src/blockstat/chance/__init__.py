"""The probability that an assembly falls when friction, joints, weights and loads are random.

This room imports `analysis`, `imperfection`, `contact` and the root.
"""
