"""Rotational stiffness in two readings: a scale of the inertia, and angular springs at the joints.

The **inertia scale** is what animation packages make of it: rotations are slower, in the end by the square root of the
scale, and nothing else changes. A scale below 1 makes them faster. Statics do not see inertia, so it has no static
counterpart. What falls with true inertia falls with any, later or sooner.

An **angular spring** turns two neighbours back by k times their relative rotation. In the shape that was built its
moment is zero, so limit analysis does not see it either. It cannot keep a mechanism from starting. It stops one at a
finite rotation if k exceeds what the weight gains (W h / 2 for a block on a hinge). With a capacity M the moment is
bounded and the twin is a bond of no force and of moment M (`blockstat.glued(assembly, 0.0, moment=M)`). Statics with
that bond are an upper bound for any k, and what they call unstable does not rest near the shape that was built.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from blockstat.errors import InputError, check_number, is_number
from dynsim.bonds.glue import CentreBonds
from dynsim.bonds.springs import Springs, spring_set
from dynsim.bonds.ties import TieForces
from dynsim.engine.world import Action, World


@dataclass(frozen=True)
class InertiaScale:
    """Scale the inertia tensor of every block.

    Parameters
    ----------
    scale : float
        Factor on the moments of inertia; the masses stay. Below 1 not with ties, angular springs and bonds that have a
        moment capacity: those are as stiff as the time step allows with true inertia.

    Raises
    ------
    InputError
        For anything but a positive number.

    Examples
    --------
    >>> from dynsim import InertiaScale
    >>> InertiaScale(0.0)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: inertia scale is 0.0; it must be a positive number
    """

    scale: float

    each_step = False

    def __post_init__(self) -> None:
        _check("inertia scale", self.scale)

    @property
    def caveat(self) -> str:
        """What a verdict that was reached with the scale must say."""
        if self.scale < 1:
            effect = f"rotations are up to {1 / np.sqrt(self.scale):.3g} times as fast"
        else:
            effect = (
                f"rotations take up to {np.sqrt(self.scale):.3g} times as long, so a fall may not show in the "
                "simulated time"
            )
        return f"the inertia of every block is scaled by {self.scale:g}: {effect}; statics know nothing of it"

    def begin(self, world: World) -> None:
        """Scale the inertia of all blocks.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For a scale below 1 where springs or ties hold blocks.
        """
        if self.scale < 1 and any(
            isinstance(action, (AngularSprings, CentreBonds, TieForces)) for action in world.actions
        ):
            raise InputError(
                f"inertia scale is {self.scale:g}; it must be at least 1 with ties, angular springs or bonds with "
                "a moment capacity: less inertia makes them unstable"
            )
        world.scale_inertia(self.scale)

    def act(self, world: World, time: float) -> None:
        """Do nothing: the scale stays.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        pass


@dataclass(frozen=True)
class AngularSprings:
    """Put a spring against relative rotation into the centre of every joint that has an area.

    Parameters
    ----------
    stiffness : float
        Moment over relative rotation [N m/rad].
    moment : float, optional
        Capacity in bending and in torsion [N m]; None for no bound.
    damping : float
        Share of the critical damping of two neighbours.

    Raises
    ------
    InputError
        For a stiffness or a moment that is not positive, and a damping outside 0 to 1.
    """

    stiffness: float
    moment: float | None = None
    damping: float = 0.1
    _springs: list[Springs] = field(default_factory=list, init=False, repr=False, compare=False)

    each_step = True

    def __post_init__(self) -> None:
        _check("angular stiffness", self.stiffness)
        if self.moment is not None:
            _check("moment of an angular spring", self.moment)
        check_number("damping of an angular spring", self.damping, least=0, most=1)

    @property
    def caveat(self) -> str:
        """What a verdict must say; after a run also which springs the time step made softer."""
        bound = "of any moment, which statics know nothing of" if self.moment is None else f"up to {self.moment:g} N m"
        text = f"angular springs of {self.stiffness:g} N m/rad at the joints, {bound}"
        used = min((float(springs.angular.min()) for springs in self._springs), default=self.stiffness)
        return text + (f"; some only {used:.3g} N m/rad, the most at this time step" if used < self.stiffness else "")

    def begin(self, world: World) -> None:
        """Put a spring into every joint that has an area.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        interfaces = world.interfaces
        rows = np.flatnonzero(interfaces.area > 0)  # where blocks touch on an edge or a corner nothing holds a moment
        n = len(rows)
        self._springs[:] = [] if not n else [
            spring_set(
                world, interfaces, rows, stiffness=0.0, angular=self.stiffness, force=np.zeros(n),
                moment=np.full(n, np.inf if self.moment is None else self.moment), damping=self.damping, breaks=False,
            )
        ]  # fmt: skip

    def act(self, world: World, time: float) -> None:
        """Apply the moments of the springs for the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        for springs in self._springs:
            springs.act(world, time)


def caveats(actions: Iterable[Action]) -> list[str]:
    """Return what a verdict must say of the rotational stiffness with which it was reached.

    Parameters
    ----------
    actions : iterable of Action
        Actions of the run.

    Returns
    -------
    list of str
        One sentence an action.
    """
    return [action.caveat for action in actions if isinstance(action, (InertiaScale, AngularSprings))]


def _check(name: str, value: float) -> None:
    if not is_number(value) or not 0 < value < float("inf"):
        raise InputError(f"{name} is {value!r}; it must be a positive number")
