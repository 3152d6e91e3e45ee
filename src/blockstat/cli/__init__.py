"""The command `blockstat`.

This room imports `analysis`, `app`, `contact`, `geometry_repair`, `io`, `large_displacement`, `loading`, `sequence`,
`spec`, `studies` and `view`, each inside the command that needs it, and the root.
"""
