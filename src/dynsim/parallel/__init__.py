"""Many runs side by side, each in a process that may die without harm to the others.

This room imports `judge`.
"""
