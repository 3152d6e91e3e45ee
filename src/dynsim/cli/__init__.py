"""The command `dynsim`.

This room imports the root, `bonds`, `comparison`, `design_search`, `earthquake`, `engine`, `judge`, `loads`, `panel`,
`parallel` and `view`, each inside the command that needs it, and of `blockstat` the root, `app`, `cli`,
`design_search`, `loading`, `sequence`, `spec`, `system` and `view`.
"""
