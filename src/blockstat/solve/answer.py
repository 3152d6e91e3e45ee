"""What is asked of a solver and what it returns, before our own code has checked anything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from blockstat.program.penalty import PenaltyProgram
from blockstat.program.planar import Plane
from blockstat.typing import Floats


@dataclass(frozen=True)
class Enough:
    """What may end a solve before its optimum; nothing does unless asked for."""

    forces: Callable[[Floats], bool] | None = None  #: told forces on the way, shape (m, 3); ends with "Accepted"
    twist: Callable[[Floats], bool] | None = None  #: told twists on the way, shape (6 n,); ends with "Mechanism"
    approach: bool = False  #: whether such forces are looked for first (see `blockstat.solve.phase_one`)
    brief: bool = False  #: whether they are looked for no further once it is not easy
    optimise: bool = True  #: whether the structured method goes on to the optimum where they are not found


OPTIMUM = Enough()
#: Status of an answer that was ended so: its forces, or its twist, have passed our own check.
ACCEPTED, MECHANISM = "Accepted", "Mechanism"


@dataclass(frozen=True)
class RawSolution:
    """A candidate answer in the units of the program; nothing in it is trusted."""

    force: Floats  #: f, shape (m, 3)
    adhesion: Floats  #: s, shape (n_points,); nan where the solve ended with a mechanism before its optimum
    twist: Floats  #: u, shape (6 n,)
    bounded: bool  #: False when no adhesion is enough; then `twist` is a ray along which the work grows
    status: str  #: the solver's own word, for the record only
    iterations: int
    solver: str  #: which one answered
    inside: Floats | None = None  #: a twist met on the way that opens every joint, shape (6 n,)


@dataclass(frozen=True, eq=False)
class DualProgram:
    """Minimise 1/2 u' P u + cost' u subject to A' u + offset in K*, capped' u <= 1 and pinned' u = 1.

    P is that of Whiting's penalty, E E' in the rates A' u (at points with a cap on g_n + y), the identity, or zero.
    """

    program: PenaltyProgram
    cost: Floats  #: shape (6 n,)
    penalty: bool = False
    least_norm: bool = False
    offset: Floats | None = None  #: shape (3 m,)
    capped: Floats | None = None  #: shape (6 n,)
    pinned: Floats | None = None  #: shape (6 n,)
    #: Closing at the caps of contact points that counts in `capped` and earns as much in the cost, each so many times.
    crushing: float = 0.0
    compliance: float = 0.0  #: c, with c/2 |f|^2 (shear counting 1/mu^2) added to the cost of forces

    @cached_property
    def earned(self) -> Floats:
        """What each y and then each z adds to `capped` and takes off the cost."""
        program = self.program
        earned = np.zeros(len(program.capped) + len(program.floored))
        earned[: len(program.capped)] = self.crushing * (program.capped < program.n_points)
        return earned

    @cached_property
    def price(self) -> Floats:
        """The cost of each y and then of each z."""
        program = self.program
        return np.concatenate([program.cap[program.capped], -program.floor[program.floored]]) - self.earned

    @cached_property
    def plane(self) -> Plane | None:
        """The plane in which the program may be solved, if there is one."""
        plane = self.program.plane
        if plane is None or self.compliance or not np.isfinite(self.program.friction).all():
            return None
        in_plane = plane.holds(self.cost, self.capped, self.pinned)
        return plane if in_plane and (self.offset is None or plane.mirrors(self.offset)) else None


@dataclass(frozen=True, eq=False)
class DualAnswer:
    """An answer to one of the dual programs; nothing in it is trusted."""

    twist: Floats  #: u, shape (6 n,)
    force: Floats  #: multipliers of the cones as forces, shape (m, 3)
    multiplier: float  #: lambda of A f + w + lambda l = 0 when a load was pinned, else 0
    status: str  #: "Solved", "AlmostSolved", "PrimalInfeasible", "DualInfeasible", of `Enough`, or the solver's own
    iterations: int
    crushing: Floats  #: y, the closing that caps allow, shape (m,)
    solver: str
