"""The intensities at which one record is run: up by steps until a block falls, then bisection."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from blockstat.errors import InputError, check_positive

#: Steps up to the greatest intensity: more means a factor that was mistyped, for each is a simulation.
MOST_STEPS = 200


@dataclass(frozen=True)
class Hunt:
    """Hunt and bracket after Vamvatsikos and Cornell (2002), a function of the runs that are there.

    The next intensity depends on nothing else, so a hunt that was interrupted goes on as if it had not been. One by
    shorter steps than before first takes those below the lowest fall.

    Examples
    --------
    >>> hunt = Hunt(start=0.1, factor=2.0, up_to=1.0, resolution=0.2, beyond=2)
    >>> known = {}
    >>> while (intensity := hunt.following(known)) is not None:
    ...     known[intensity] = intensity > 0.5
    >>> [round(intensity, 3) for intensity in known]
    [0.1, 0.2, 0.4, 0.8, 0.6, 0.5, 1.0]
    """

    start: float  #: the first intensity
    factor: float  #: from one step to the next
    up_to: float  #: the greatest intensity
    resolution: float  #: width of the bracket relative to its upper end, or to `start` if that is more
    beyond: int  #: of the steps above the collapse intensity, so many are run, too

    def __post_init__(self) -> None:
        for name in ("start", "up_to"):
            check_positive(f"incremental: {name}", getattr(self, name))
        if self.up_to < self.start:
            raise InputError(f"incremental: up_to is {self.up_to!r}; it must be at least start, {self.start!r}")
        if not 1 < self.factor < math.inf:
            raise InputError(f"incremental: factor is {self.factor!r}; it must be above 1")
        if math.log(self.up_to / self.start) > MOST_STEPS * math.log(self.factor):
            raise InputError(
                f"incremental: factor is {self.factor!r}; from {self.start:g} to {self.up_to:g} that is more than "
                f"{MOST_STEPS} steps"
            )
        if not 1e-3 <= self.resolution < 1:
            raise InputError(f"incremental: resolution is {self.resolution!r}; it must be from 0.001 to below 1")
        if not isinstance(self.beyond, int) or self.beyond < 0:
            raise InputError(f"incremental: beyond is {self.beyond!r}; it must be a whole number of at least 0")

    @property
    def steps(self) -> list[float]:
        """The intensities of the way up, the greatest last."""
        steps = []
        while (step := self.start * self.factor ** len(steps)) < self.up_to:
            steps.append(step)
        return [*steps, self.up_to]

    def following(self, fell: Mapping[float, bool]) -> float | None:
        """Return the intensity of the next run.

        Parameters
        ----------
        fell : mapping of float to bool
            Whether a block fell, by intensity, of the runs that are there.

        Returns
        -------
        float or None
            None when the hunt is over.
        """
        low, high = bracket(fell)
        unasked = [step for step in self.steps if step not in fell]
        # Runs of a hunt by longer steps may have passed over a fall.
        if unasked and unasked[0] <= high:
            return unasked[0]
        if math.isinf(high):
            return None
        if high - low > self.resolution * max(high, self.start):
            return (low + high) / 2
        above = [step for step in self.steps if step > high][: self.beyond]
        return next((step for step in above if step not in fell), None)


def bracket(fell: Mapping[float, bool]) -> tuple[float, float]:
    """Return the bounds of the collapse intensity, which is the lowest at which a block fell.

    Parameters
    ----------
    fell : mapping of float to bool
        Whether a block fell, by intensity.

    Returns
    -------
    lower : float
        The largest intensity below it at which none did; 0 where there is none.
    upper : float
        The lowest intensity at which one fell; inf where none ever did.

    Examples
    --------
    >>> bracket({0.2: False, 0.4: True, 0.3: False, 0.8: False})
    (0.3, 0.4)
    """
    upper = min((intensity for intensity, down in fell.items() if down), default=math.inf)
    return max((intensity for intensity in fell if intensity < upper), default=0.0), upper
