"""Many runs side by side, each in a process that may die without harm to the others.

This room imports the root, `engine`, `loads`, `judge`, and of `blockstat` the root, `contact` and `system`.
"""
