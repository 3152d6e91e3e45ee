"""Loads beside the weight: on faces, of fluids, earth and fill, along a path, and cases that combine them.

This room imports `contact` and the root.
"""
