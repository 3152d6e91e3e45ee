"""Acceleration of the ground in time: ramps, pulses and records.

Simulated in the frame that moves with the ground: each block gets a body force, minus its mass times the ground's
acceleration, on top of gravity, and displacements are relative to the ground. Nothing acts before release.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from blockstat.errors import InputError, check_choice, check_number, check_positive, check_vector
from blockstat.loads import numbers
from blockstat.typing import Floats
from dynsim.engine.world import World

#: Shapes of a pulse over its duration, x from 0 to 1.
SHAPES = {
    "rectangle": lambda x: 1.0,
    "half-sine": lambda x: np.sin(np.pi * x),
    "sine": lambda x: np.sin(2 * np.pi * x),
    "triangle": lambda x: 1 - abs(2 * x - 1),
}
#: Their integrals from 0 to x.
INTEGRALS = {
    "rectangle": lambda x: x,
    "half-sine": lambda x: (1 - np.cos(np.pi * x)) / np.pi,
    "sine": lambda x: (1 - np.cos(2 * np.pi * x)) / (2 * np.pi),
    "triangle": lambda x: x**2 - 2 * max(x - 0.5, 0.0) ** 2,
}


class Ground:
    """The common part of all motions of the ground."""

    each_step = True
    travel = 0.0

    def at(self, time: float) -> Floats:
        """Return the acceleration of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Acceleration [m/s2].
        """
        raise NotImplementedError

    def velocity(self, time: float) -> Floats:
        """Return the velocity of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Velocity [m/s]; 0 before the motion.
        """
        raise NotImplementedError

    def begin(self, world: World) -> None:
        """Do nothing: the ground is at rest until release.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        pass

    def act(self, world: World, time: float) -> None:
        """Accelerate all blocks against the mean acceleration of the ground over the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        if time >= 0:
            # By the velocities, so that nothing between two steps is lost: a pulse may be shorter than one.
            step = world.time_step
            world.drive(self, (self.velocity(time) - self.velocity(time + step)) / step)


@dataclass(frozen=True, eq=False)
class Ramp(Ground):
    """The acceleration of the ground grows at a constant rate to a value, and stays there.

    Examples
    --------
    >>> from dynsim import Ramp
    >>> Ramp(to=(2.0, 0, 0), duration=4.0).at(1.0).tolist()
    [0.5, 0.0, 0.0]
    """

    to: Any  #: shape (3,) [m/s2]
    duration: float  #: [s]

    def __post_init__(self) -> None:
        check_vector("ramp: to", self.to)
        check_positive("ramp: duration", self.duration)

    @property
    def end(self) -> float:
        """Time at which the acceleration has its last value [s]."""
        return self.duration

    def at(self, time: float) -> Floats:
        """Return the acceleration of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Acceleration [m/s2].
        """
        return min(time / self.duration, 1.0) * np.asarray(self.to, dtype=float)

    def velocity(self, time: float) -> Floats:
        """Return the velocity of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Velocity [m/s]; 0 at release.
        """
        growing = min(time, self.duration)
        return (growing**2 / (2 * self.duration) + time - growing) * np.asarray(self.to, dtype=float)


@dataclass(frozen=True, eq=False)
class Pulse(Ground):
    """One pulse of the ground's acceleration: "rectangle", "half-sine", "sine" (a whole period) or "triangle".

    Examples
    --------
    >>> from dynsim import Pulse
    >>> Pulse((2.0, 0, 0), duration=1.0, shape="half-sine").at(0.5).round(6).tolist()
    [2.0, 0.0, 0.0]
    """

    peak: Any  #: shape (3,) [m/s2]
    duration: float  #: [s]
    shape: str = "rectangle"
    start: float = 0.0  #: [s]

    def __post_init__(self) -> None:
        check_vector("pulse: peak", self.peak)
        check_positive("pulse: duration", self.duration)
        check_number("pulse: start", self.start, least=0)
        check_choice("pulse: shape", self.shape, SHAPES)

    @property
    def end(self) -> float:
        """Time at which the pulse is over [s]."""
        return self.start + self.duration

    def at(self, time: float) -> Floats:
        """Return the acceleration of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Acceleration [m/s2].
        """
        share = (time - self.start) / self.duration
        inside = 0 <= share < 1
        return (SHAPES[self.shape](share) if inside else 0.0) * np.asarray(self.peak, dtype=float)

    def velocity(self, time: float) -> Floats:
        """Return the velocity of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Velocity [m/s]; 0 before the pulse.
        """
        share = min(max((time - self.start) / self.duration, 0.0), 1.0)
        return self.duration * INTEGRALS[self.shape](share) * np.asarray(self.peak, dtype=float)


@dataclass(frozen=True, eq=False)
class Record(Ground):
    """Accelerations of the ground at points in time, with straight lines between them and zero before and after.

    Examples
    --------
    >>> import numpy as np
    >>> from dynsim import Record
    >>> shake = Record(np.array([0.0, 1.0, 2.0]), np.array([[0.0, 0, 0], [2.0, 0, 0], [0.0, 0, 0]]))
    >>> shake.end, shake.at(0.5).tolist()
    (2.0, [1.0, 0.0, 0.0])
    """

    times: Floats  #: shape (k,) [s], ascending
    acceleration: Floats  #: shape (k, 3) [m/s2]

    def __post_init__(self) -> None:
        times, values = numbers(self.times), numbers(self.acceleration)
        if times.ndim != 1 or len(times) < 2 or values.shape != (len(times), 3):
            raise InputError(f"record: times have shape {times.shape} and accelerations {values.shape}; "
                             "(k,) and (k, 3) are needed, k at least 2")  # fmt: skip
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise InputError("record: a time or an acceleration is not a finite number")
        if (np.diff(times) <= 0).any() or times[0] < 0:
            raise InputError("record: times must grow from one point to the next, from 0 or later")
        if not values.any():
            raise InputError("record: the acceleration is 0 throughout")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "acceleration", values)

    @property
    def end(self) -> float:
        """Time of the last point of the record [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> Floats:
        """Return the acceleration of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Acceleration [m/s2].
        """
        if not self.times[0] <= time <= self.times[-1]:
            return np.zeros(3)
        return np.array([np.interp(time, self.times, self.acceleration[:, k]) for k in range(3)])

    def velocity(self, time: float) -> Floats:
        """Return the velocity of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Velocity [m/s]; 0 before the record.
        """
        within = min(max(time, self.times[0]), self.times[-1])
        k = min(int(np.searchsorted(self.times, within, side="right")), len(self.times) - 1) - 1
        return self._velocities[k] + (within - self.times[k]) * (self.acceleration[k] + self.at(within)) / 2

    @cached_property
    def _velocities(self) -> Floats:
        """At the points of the record, shape (k, 3) [m/s]."""
        gained = np.diff(self.times)[:, None] * (self.acceleration[1:] + self.acceleration[:-1]) / 2
        return np.vstack([np.zeros(3), np.cumsum(gained, axis=0)])
