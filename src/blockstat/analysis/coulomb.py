"""Force fields that real friction reaches: without dilatancy and without self-stress.

In limit analysis a sliding joint opens at the rate mu, but stone slides without opening. And any thrust can hold a
block between fixed ones, although no load causes it. Both errors vanish if every loaded joint has to close by the same
small amount: a thrust then exists only where the motion of the blocks causes it.

De Saxce's bipotential turns Coulomb's law into a fixed point (De Saxce & Feng 1998; Acary, Cadoux, Lemarechal
& Malick 2011). Given slips s at the points, solve the conic program::

    minimise (1 + s)' f_n + c/2 |f|^2   subject to   A f + w = 0,   f in K.

Its cone multipliers are z = g + (1 + s) n + c f with g the relative motion, so a loaded point has
`g_n = mu |z_t| - s - 1`. At `s = mu |z_t|` every loaded point closes by one unit, however far it slides: there is no
dilatancy, and no thrust between blocks that do not approach each other. Where such a state exists the slips converge.
Where the assembly stands only by self-stress they grow without bound. The small compliance c makes the forces unique.

Friction depends on history: which of many equilibria the blocks reach depends on how tight each joint was. Unequal
closings describe joints of unequal tightness. Where the answer changes with them, it depends on history.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats

MOST_SOLVES = 40
COMPLIANCE = 1e-3
#: Slips that change by less than this, in units of the closing, have settled.
SETTLED = 1e-3
#: The change of the slips shrinks or grows by a steady factor: below 1 by more than this they will settle. The factor
#: crosses 1 at the limit, and assemblies that stand on self-stress alone have it at 1 or above.
CLEAR = 1e-3
#: The factor is steady when it moves by less than this over a stretch of so many solves.
STEADY, STRETCH = 8e-3, 4
#: Slips that grow by more than this over the second half of the solves grow without bound (steady growth doubles them);
#: those that grow by less have a bound, even where they alternate between equivalent states.
GROWTH = 1.25
#: What comes to rest does so ever more slowly, so its slips at most double; those that grow by more over the second
#: half of the solves grow ever faster.
DIVERGENCE = 4.0
#: Solves before growth, with and without a steady factor, is accepted.
EARLY, PATIENCE = 12, 24
#: Slips beyond this are without bound.
UNBOUNDED = 1e7


@dataclass(frozen=True, eq=False)
class CoulombState:
    """Where the fixed point went."""

    settles: bool | None  #: True: a state without dilatancy and self-stress exists; False: not; None: too close to tell
    force: Floats  #: forces of the last program, scaled, shape (m, 3)
    slip: Floats  #: `mu |z_t|` at each point, in units of the closing, shape (m,)
    changes: tuple[float, ...]  #: largest change of a slip at each solve
    factor: float  #: by which the changes shrink or grow; nan if they settled at once

    @property
    def solves(self) -> int:
        """The number of programs that were solved."""
        return len(self.changes)


def coulomb_state(
    program: PenaltyProgram,
    *,
    compliance: float = COMPLIANCE,
    closing: Floats | float = 1.0,
    solver: str = "auto",
) -> CoulombState:
    """Run the fixed point until the slips have settled, will settle, or will not.

    Parameters
    ----------
    program
        The penalty program of a statically stable assembly. Points without friction or with infinite friction have no
        slip law and are not allowed here.
    compliance
        c, a trifle that makes the forces unique.
    closing
        By how much each loaded point closes, about one, shape (m,).
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    CoulombState
        Whether the slips settle, and the last forces.

    References
    ----------
    De Saxce & Feng: The bipotential method, 1998. Acary, Cadoux, Lemarechal & Malick: A formulation of the linear
    discrete Coulomb friction problem via convex optimization, 2011.
    """
    slip = np.zeros(len(program.friction))
    touching = np.arange(len(slip)) < program.n_points  # bonds neither close nor slip
    changes: list[float] = []
    factors: list[float] = []
    sizes: list[float] = []
    force = np.zeros((len(slip), 3))
    settles: bool | None = None
    while len(changes) < MOST_SOLVES and settles is None:
        answer, unit = _solve_pressure(program, touching * (closing + slip), compliance, solver)
        force = answer.force
        if answer.status.is_infeasible:
            settles = False if changes and slip.max() > 1.0 / SETTLED else None
            break
        rates = unit * answer.rates
        new = touching * program.friction * np.hypot(rates[:, 1], rates[:, 2])
        changes.append(float(np.abs(new - slip).max(initial=0.0)))
        if len(changes) > 1:
            factors.append(changes[-1] / max(changes[-2], 1e-300))
        slip = new
        sizes.append(float(slip.max(initial=0.0)))
        settles = _trend(changes, factors, sizes)
    return CoulombState(settles, force, slip, tuple(changes), factors[-1] if factors else float("nan"))


def settling_share(program: PenaltyProgram, *, tries: int = 12, seed: int = 0) -> float:
    """Return the share of random tightnesses of the joints at which the slips settle.

    At 0 or 1 history plays no part.

    Parameters
    ----------
    program
        As in `coulomb_state`.
    tries
        In each of them every point closes by another random amount, from a tenth of the usual one to ten times it.
    seed
        Of the random numbers.

    Returns
    -------
    float
        From 0 to 1.
    """
    random, m = np.random.default_rng(seed), len(program.friction)
    states = (coulomb_state(program, closing=10.0 ** random.uniform(-1.0, 1.0, m)) for _ in range(tries))
    return float(np.mean([state.settles is True for state in states]))


def _solve_pressure(program: PenaltyProgram, cost: Floats, compliance: float, solver: str) -> tuple[Answer, float]:
    """Minimise cost'f_n + c/2 |f|^2 subject to A f + w = 0, f in K, for positive finite friction.

    cost : of the normal force at each point, shape (m,). Also returns the unit of the answer's rates, which are z.
    """
    unit = max(float(cost.max()), 1.0)
    offset = np.zeros((len(cost), 3))
    offset[:, 0] = cost / unit
    conic = conic_program(program, -program.load, offset=offset.reshape(-1), compliance=compliance / unit)
    return solve(conic, solver=solver), unit


def _trend(changes: list[float], factors: list[float], sizes: list[float]) -> bool | None:
    if changes[-1] <= SETTLED:
        return True
    if sizes[-1] > UNBOUNDED:
        return False
    solves = len(changes)
    grows = sizes[-1] > GROWTH * sizes[solves // 2]
    if solves >= EARLY and sizes[-1] > DIVERGENCE * sizes[solves // 2]:
        return False
    recent = factors[-STRETCH:]
    if len(recent) == STRETCH and max(recent) - min(recent) <= STEADY:
        mean = float(np.mean(recent))
        if mean < 1.0 - CLEAR and (changes[-1] < 0.9 * changes[0] or solves >= PATIENCE):
            return True
        if mean < 1.0 - CLEAR / 4 and solves >= PATIENCE:
            return None
        if mean > 1.0 - CLEAR / 4 and grows and solves >= EARLY:
            return False
    if solves < PATIENCE:
        return None
    return not grows if solves == MOST_SOLVES or not grows else None
