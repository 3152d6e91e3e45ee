"""How a dynamic check is run. The defaults are a measured set: see docs/dynamics.md."""

from __future__ import annotations

from dataclasses import dataclass

from blockstat.errors import InputError


@dataclass(frozen=True)
class Settings:
    """Time stepping, protocol and thresholds.

    Times are for blocks of 0.3 m under 9.81 m/s2; a scene is simulated at that scale whatever its units, and
    times and lengths are reported in the scene's own.
    """

    time_step: float = 1e-3  #: [s]
    iterations: int = 50  #: of the contact solver, a step
    look_every: float = 0.02  #: [s] between looks at the blocks
    settle: float = 0.5  #: [s] under full damping before the free run
    rest_after: float = 1.0  #: [s] a free run may end as a rest from here on
    end: float = 3.0  #: [s] a free run ends here at the latest
    rest: float = 0.1  #: displacement, in thresholds, below which blocks count as resting
    group: str | None = None  #: group of Eq. 1; None: "vault" if there is one, else the whole assembly
    roof_threshold: float | None = None  #: [m] of Eq. 1; None: relative to block size
    brick_threshold: float | None = None  #: [m] of Eq. 2 and of the displacement; None: relative to block size

    def __post_init__(self) -> None:
        for name in (
            "time_step",
            "look_every",
            "settle",
            "rest_after",
            "end",
            "rest",
            "roof_threshold",
            "brick_threshold",
        ):
            value = getattr(self, name)
            if value is not None and not 0 < value < float("inf"):
                raise InputError(f"settings: {name} is {value!r}; it must be a positive number")
        if self.iterations < 1:
            raise InputError(f"settings: iterations is {self.iterations!r}; it must be at least 1")
        if not self.time_step <= self.look_every <= self.rest_after <= self.end:
            raise InputError("settings: time_step <= look_every <= rest_after <= end is needed")

    @property
    def substeps(self) -> int:
        """Time steps between two looks."""
        return max(round(self.look_every / self.time_step), 1)
