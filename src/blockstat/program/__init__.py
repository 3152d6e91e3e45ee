"""The equilibrium of an assembly, its penalty program and the one conic program of all solvers, as plain arrays.

This room imports `contact`, `geometry`, `system` (old names) and the root. It knows no solver and no option of one.
"""

from blockstat.system.old_names import old_names

__getattr__ = old_names(__name__)
