"""The command `blockstat`.

This room imports every other room, each inside the command that needs it.
"""
