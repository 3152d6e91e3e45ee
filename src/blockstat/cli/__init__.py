"""The command `blockstat`.

This room imports `analysis`, `app`, `chance`, `contact`, `geometry_repair`, `imperfection`, `io`, `large_displacement`,
`loading`, `model`, `proof`, `reinforcement`, `sensitivity`, `sequence`, `spec`, `studies`, `system` and `view`, each
inside the command that needs it, and the root.
"""
