"""Proof files: verdicts and limit loads as exact rationals that anyone can check without this package.

This room imports `analysis`, `certificate`, `contact`, `geometry`, `program`, `solve`, `system` and the root.
"""
