"""Derivatives of limit loads and scores, from the dual of a solved program.

This room imports `analysis`, `program`, `imperfection`, `contact`, `geometry`, `system` (old names) and the root.
"""

from blockstat.system.old_names import old_names

__getattr__ = old_names(__name__)
