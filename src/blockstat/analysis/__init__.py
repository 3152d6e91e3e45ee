"""What an engineer asks of the statics: verdicts, limit loads, tilt, friction, thrust and settlement.

This room imports `solve`, `certificate`, `program`, `contact`, `imperfection`, `surface`, `geometry` and the root.
"""
