"""A second opinion on answers that take many verdicts: brackets, capacity curves, settlements, sequences and props.

It shares no code with what it checks; balance, cones and joint laws are those of `evidence.checks`.
"""
