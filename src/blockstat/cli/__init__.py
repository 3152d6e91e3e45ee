"""The command `blockstat`.

This room imports `analysis`, `app`, `chance`, `contact`, `geometry_repair`, `imperfection`, `io`, `large_displacement`,
`loading`, `proof`, `sequence`, `spec`, `studies` and `view`, each inside the command that needs it, and the root.
"""
