"""Repair of rough geometry on request, with a report of every change.

This room imports `geometry`, `contact` (to find overlaps), `io` and `spec` (to read a file), and the root.
"""
