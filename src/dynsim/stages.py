"""The runs behind one verdict, from quick to fine: coarse time steps fell what stands, hardly ever the other way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from blockstat.assembly import Assembly
from blockstat.contact import find_interfaces
from dynsim.settings import Settings

#: A quick run that has not come to rest by now leaves the answer to a finer one [s].
SHORT = 1.5
#: Iterations of the contact solver for each joint between a block and the nearest support: the solver carries a force
#: from joint to joint, and a ring of a hundred voussoirs creeps at what is ample for ten.
MIDDLE, FINE = 2, 4


def stages(assembly: Assembly, settings: Settings) -> list[Settings]:
    """Settings of the runs, each asked only if the one before is not believed; equal time steps are one run."""
    quick = replace(settings, time_step=settings.quick_step)
    if settings.fine_step == settings.quick_step:
        return [quick]
    depth = chain(assembly)
    middle = replace(settings, iterations=max(settings.iterations, MIDDLE * depth))
    fine = replace(
        settings, time_step=settings.fine_step, iterations=max(settings.fine_iterations, FINE * depth)
    )  # fmt: skip
    first = replace(quick, end=min(settings.end, max(SHORT, 2 * settings.rest_after)))
    return [first, middle, fine] if settings.quick_step > settings.time_step > settings.fine_step else [first, fine]


def chain(assembly: Assembly) -> int:
    """Joints between a support and the block furthest from any."""
    pair = find_interfaces(assembly).pair
    n = assembly.n_blocks
    graph = sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(n, n)).tocsr()
    far = dijkstra(graph, directed=False, indices=np.flatnonzero(assembly.support), unweighted=True, min_only=True)
    return int(far[np.isfinite(far)].max(initial=0.0))
