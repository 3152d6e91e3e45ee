"""Objects of COMPAS in and out: assemblies, models and problems of compas_assembly, compas_model and compas_dem.

It works on the objects in memory and imports the COMPAS packages only inside functions. This room imports `analysis`,
`contact`, `io` and the root.
"""

from blockstat.compas.objects import from_compas
from blockstat.compas.solvers import cra_penalty_solve, rbe_solve, solve

__all__ = ["cra_penalty_solve", "from_compas", "rbe_solve", "solve"]
