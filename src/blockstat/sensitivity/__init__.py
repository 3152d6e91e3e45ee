"""Derivatives of limit loads and scores, from the dual of a solved program.

This room imports `analysis`, `program`, `imperfection`, `contact`, `geometry` and the root.
"""
