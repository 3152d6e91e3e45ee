"""Pictures, animations, attributes and reports of what the statics say.

This room imports `analysis`, `design_search`, `sensitivity`, `sequence`, `studies`, `spec`, `io`, `contact`, `geometry`
and the root.
"""
