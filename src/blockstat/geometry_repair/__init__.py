"""Repair of rough geometry on request, with a report of every change.

This room imports `geometry`, `contact` (to find overlaps), `io` and `model` (to read a file).
"""
