"""The command `blockstat`.

This room imports `analysis`, `app`, `chance`, `contact`, `geometry_repair`, `imperfection`, `io`, `loading`, `proof`,
`sequence`, `spec`, `studies` and `view`, each inside the command that needs it, and the root.
"""
