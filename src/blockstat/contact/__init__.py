"""Where blocks touch: interfaces, their contact points, and the joint law of each point.

This room imports `geometry`, `surface` and the root.
"""
