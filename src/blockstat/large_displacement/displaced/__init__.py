"""A displaced structure: where its blocks and contact points are, what touches, and the loads on it.

This room imports `analysis`, `contact`, `geometry`, `loading`, `program` and the root.
"""
