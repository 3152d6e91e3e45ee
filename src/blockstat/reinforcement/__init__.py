"""Ties and tendons of an assembly: the forces they may have, where they help most, and what a tendon does to blocks.

This room imports `analysis`, `sensitivity`, `program`, `model` (for the box of a plate), `contact` (for types) and the
root.
"""
