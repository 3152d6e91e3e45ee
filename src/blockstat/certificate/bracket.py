"""Both bounds on a multiplier from the iterates of a solve, proven as it runs.

With A f + w + lambda l = 0 and f in K a field carries lambda. With A'u in K* and l'u > 0 a mechanism bounds every
multiplier by -w'u / l'u. Iterates that lie strictly inside their cones are such a pair but for what they leave of
equilibrium. A part of that is a multiple of l, and only changes lambda. The rest is corrected (`balance`). Where that
leads out of a cone, the field is mixed with one that has slack: the slack of a point is concave in its force, so with
slack s0 > 0 of that field and s1 < 0 of the corrected one

    slack((1 - t) f0 + t f1) >= (1 - t) s0 + t s1 >= 0    for    t <= s0 / (s0 - s1),

and the mixture carries t lambda.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from blockstat.certificate.check import FORCE_TOLERANCE, balance, check, opening_slack, point_slack, power
from blockstat.certificate.interior_motions import Motions, with_interior_motion
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats

#: Told the iterate, the multiplier that its forces would carry if they were balanced, and the proven upper bound.
Progress = Callable[[int, float, float], None]
#: Widths of brackets below this, for a load as strong as the weight, are rounding: each end is proven to
#: `FORCE_TOLERANCE` of the loads.
ROUNDING = 2.0 * FORCE_TOLERANCE


def is_closed(lower: float, upper: float, tolerance: float) -> bool:
    """Return whether a bracket in units of a load as strong as the weight tells the limit.

    Parameters
    ----------
    lower, upper
        Its ends.
    tolerance
        Largest width relative to the upper end; below `ROUNDING` every width will do.

    Returns
    -------
    bool
        True where it does.
    """
    return bool(np.isfinite(upper)) and upper - lower <= max(tolerance * abs(upper), ROUNDING)


def without_rounding(load: Floats, dead: Floats, *multipliers: float) -> list[float]:
    """Return multipliers, zero where they are rounding of it.

    Parameters
    ----------
    load
        What is multiplied, shape (6 n,).
    dead
        What acts on the blocks besides, shape (6 n,).
    *multipliers
        Ends of a bracket.

    Returns
    -------
    list of float
        Zero for each that adds no more than `ROUNDING` to what acts on any block, however light it is: no proof tells
        that from nothing.
    """
    added, own = (np.linalg.norm(wrench.reshape(-1, 6), axis=1) for wrench in (load, dead))
    loaded = added > 0
    none = ROUNDING * float((own[loaded] / added[loaded]).min(initial=np.inf))
    return [0.0 if abs(multiplier) <= none and np.isfinite(multiplier) else multiplier for multiplier in multipliers]


def in_units(progress: Progress | None, unit: float) -> Progress | None:
    """Return what is told of a bracket with its ends in other units.

    Parameters
    ----------
    progress
        Who is told.
    unit
        What one of these units is in those of the bracket.

    Returns
    -------
    callable or None
        Tells `progress`; None where nobody is told.
    """
    return progress and (lambda k, lower, upper: progress(k, lower / unit, upper / unit))


class Bracket:
    """The narrowest bracket that the iterates so far prove."""

    def __init__(
        self,
        program: PenaltyProgram,
        load: Floats,
        inside: Floats,
        tolerance: float,
        motions: Motions,
        progress: Progress | None = None,
    ) -> None:
        """Begin with the dead load alone, carried by the forces `inside`, which have slack.

        The load l has shape (6 n,), forces have shape (m, 3); motions may open every joint, shape (6 n,) each.
        """
        self._program, self._load, self._inside, self._tolerance = program, load, inside, tolerance
        self._motions, self._progress = motions, progress
        self._slack = np.maximum(point_slack(program, inside), 0.0)
        self._open: tuple[Floats, ...] = ()
        self._last: tuple[Floats, float] | None = None
        self._asked = np.inf
        # A value and its evidence change together, whenever the user interrupts.
        self._low: tuple[float, Floats] = (0.0, inside)
        self._high: tuple[float, Floats] = (np.inf, np.zeros_like(load))
        self.iterates = 0

    @property
    def lower(self) -> float:
        """The multiplier that `force` carries."""
        return self._low[0]

    @property
    def force(self) -> Floats:
        """The field of the lower bound, shape (m, 3)."""
        return self._low[1]

    @property
    def upper(self) -> float:
        """The multiplier at which `twist` moves."""
        return self._high[0]

    @property
    def twist(self) -> Floats:
        """The mechanism of the upper bound, on which the load does unit work, shape (6 n,)."""
        return self._high[1]

    @property
    def watched(self) -> bool:
        """Whether somebody is told of the iterates."""
        return self._progress is not None

    @property
    def closed(self) -> bool:
        """Whether the bounds are as close as asked for."""
        return is_closed(self.lower, self.upper, self._tolerance)

    def narrow(self, twist: Floats, force: Floats, multiplier: float) -> bool:
        """Take an iterate; forces are balanced only where that may close the bracket.

        Parameters
        ----------
        twist
            Shape (6 n,).
        force
            Shape (m, 3).
        multiplier
            That of the iterate.

        Returns
        -------
        bool
            Whether the bracket is closed.
        """
        self.iterates += 1
        self._above(twist)
        rest = self._program.matrix @ force.reshape(-1) + self._program.load
        guess = -float(rest @ self._load) / float(self._load @ self._load)
        self._last = force, guess
        if self._progress is not None:
            self._progress(self.iterates, guess, self.upper)
        width = self.upper - guess
        # An attempt costs half an iteration, so that the next is made when there is hope for more.
        if guess > 0 and is_closed(guess, self.upper, self._tolerance) and width < 0.9 * self._asked:
            self._asked = max(width, 0.0)
            self.carry(force, guess)
        return self.closed

    def close(self) -> None:
        """Prove what the last iterate carries."""
        if self._last is not None and 0 < self._last[1]:
            self.carry(*self._last)

    def _above(self, twist: Floats) -> None:
        """The upper bound of a twist with as much of a motion that opens every joint as it needs."""
        slack = opening_slack((self._program.matrix.T @ twist).reshape(-1, 3), self._program.friction)
        if slack.min(initial=np.inf) > 0:
            self._open = (twist,)
        else:
            twist = with_interior_motion(self._program, twist, (*self._open, *self._motions()))
        work = float(self._load @ twist)
        done, closing = power(self._program, twist)
        if work > 0 and closing == 0.0 and -done / work < self.upper:
            self._high = -done / work, twist / work

    def carry(self, force: Floats, multiplier: float) -> None:
        """Prove what forces near equilibrium carry.

        Parameters
        ----------
        force
            Shape (m, 3).
        multiplier
            The one with which they nearly balance.
        """
        program, load = self._program, self._program.load
        field = balance(replace(program, load=load + multiplier * self._load), force)
        slack = point_slack(program, field)
        out = slack < 0
        share = float((self._slack[out] / (self._slack[out] - slack[out])).min(initial=1.0))
        field = (1.0 - share) * self._inside + share * field
        carried = replace(program, load=load + share * multiplier * self._load)
        if share * multiplier > self.lower and check(carried, field, np.zeros_like(load)).proves_stable:
            self._low = share * multiplier, field
