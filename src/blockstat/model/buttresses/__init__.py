"""Buttresses against a wall, and flying buttresses.

This room imports `model.walling`, `model.arches` and `geometry`.
"""
