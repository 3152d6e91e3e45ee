"""The runs behind one verdict: one that is fine enough to believe a stand, a coarser and a finer one for falls."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from dynsim.engine.guards import iterations_for, joints_to_support
from dynsim.settings import Settings

#: Iterations of the contact solver for each joint between a block and the nearest support: the solver carries a force
#: from joint to joint, and a ring of a hundred voussoirs creeps at what is ample for ten.
MIDDLE, FINE = 2, 4
#: Two runs see the same fall when their times until it differ by no more than this factor. What falls by itself does so
#: in its own time; what falls by the error of a time step takes the longer the shorter the step.
SAME_FALL = 1.3


@dataclass(frozen=True)
class Stages:
    """Settings of the runs; where they do not differ in time step, the first is the only one."""

    first: Settings  #: accepted where blocks stand, or clearly fall
    check: Settings | None = None  #: a coarser one: where it sees the same fall, both are accepted
    fine: Settings | None = None  #: the last word


def stages(assembly: Assembly, settings: Settings, interfaces: Interfaces) -> Stages:
    """Return the runs of a verdict where nothing acts but weight.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    settings : Settings
        What was asked for.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    Stages
        Settings of each run.
    """
    if settings.fine_step >= settings.time_step:
        return Stages(settings)
    depth = joints_to_furthest_block(assembly, interfaces)
    coarse = settings.quick_step > settings.time_step
    settle = settings.settle_step or (settings.quick_step if coarse else None)
    middle = max(settings.iterations, MIDDLE * depth, iterations_for(assembly, interfaces))
    last = max(settings.fine_iterations, FINE * depth, iterations_for(assembly, interfaces, careful=True))
    first = replace(settings, iterations=middle, settle_step=settle)
    fine = replace(first, time_step=settings.fine_step, iterations=last)
    check = replace(first, time_step=settings.quick_step, settle_step=None) if coarse else None
    return Stages(first, check, fine)


def joints_to_furthest_block(assembly: Assembly, interfaces: Interfaces) -> int:
    """Return the number of joints between a support and the block furthest from any.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    int
        Number of joints on the shortest way.
    """
    return int(joints_to_support(assembly, interfaces).max(initial=0.0))
