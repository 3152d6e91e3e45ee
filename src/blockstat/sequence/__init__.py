"""Building an assembly and taking it down: states of some blocks with some held, plans, orders and falsework.

This room imports `analysis`, `studies`, `program`, `contact`, `solve`, `certificate`, `geometry`, `system` and the
root.
"""
