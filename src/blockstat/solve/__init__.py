"""Solvers of the penalty program, and the certificates that a verdict rests on."""
