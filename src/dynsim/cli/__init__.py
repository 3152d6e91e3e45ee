"""The command `dynsim`.

This room imports every other room, each inside the command that needs it.
"""
