"""The engines: the blocks of an assembly in a Bullet client or in LMGC90, and the protocol of what acts on them.

This room imports the root, and of `blockstat` the root, `geometry` and `contact`. No other room imports Bullet or
LMGC90.
"""
