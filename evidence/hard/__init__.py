"""Scenes that break solvers, the truth about each, and what becomes of it."""
