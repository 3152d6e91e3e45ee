"""Repair of rough geometry on request, with a report of every change.

This room imports `geometry`, `contact` (to find overlaps), `io` and `spec` (to read a file), `system` (old names)
and the root.
"""
