"""Pictures, animations, attributes and reports of what the statics say.

This room imports `analysis`, `code_check`, `compas`, `large_displacement`, `design_search`, `sensitivity`, `sequence`,
`studies`, `spec`, `loading`, `io`, `imperfection`, `contact`, `geometry`, `system` and the root.
"""
