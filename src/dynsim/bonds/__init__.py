"""Joint laws, glue and rotational stiffness at the joints of a simulated assembly, and its ties.

This room imports `engine`, `loads`, and of `blockstat` the root, `contact` and `program`.
"""
