"""The engine: one Bullet client with the blocks of an assembly in it, and the protocol of what acts on them.

This room imports the root, and of `blockstat` the root, `geometry` and `contact`. No other room imports Bullet.
"""
