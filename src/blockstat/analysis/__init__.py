"""What an engineer asks of the statics: verdicts, limit loads, tilt, friction, thrust and settlement.

This room imports `contact`, `program`, `solve` and `certificate`.
"""
