"""Pictures, animations, attributes and reports of what the statics say.

This room imports `analysis`, `large_displacement`, `design_search`, `sensitivity`, `sequence`, `studies`, `spec`, `io`,
`contact`, `geometry`, `system` and the root.
"""
