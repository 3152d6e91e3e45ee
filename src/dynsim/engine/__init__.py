"""One Bullet client with the blocks of an assembly in it.

This room alone imports `pybullet`. It imports the root, and of `blockstat` the root, `geometry` and `contact`.
"""
