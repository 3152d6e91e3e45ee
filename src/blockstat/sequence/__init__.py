"""Building an assembly and taking it down: states of some blocks with some held, plans, orders and falsework.

This room imports `analysis`, `program`, `contact`, `solve`, `certificate`, `geometry`, `spec`, `system`
and the root.
"""
