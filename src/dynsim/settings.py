"""Settings of a simulation. The defaults were chosen by measurement: see docs/dynamics.md."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import sqrt
from typing import Any

from blockstat.errors import InputError

#: What distinguishes the presets; docs/dynamics.md has their measured errors and costs.
PRESETS: dict[str, dict[str, Any]] = {
    "fast": {"time_step": 2e-3, "fine_step": 2e-3, "iterations": 30},
    "default": {},
    "careful": {"time_step": 5e-4, "quick_step": 1e-3, "fine_step": 2.5e-4, "resolution": 1e-4},
}
#: Beyond this, blocks pass through each other within one step.
LONGEST_STEP = 1 / 60
#: An imbalance of `Settings.resolution` moves a block by this share of the default threshold (10 mm for blocks of
#: 0.3 m) within `Settings.window`. Contact noise moves blocks of a sound chapel by less than a tenth of that.
SHOWN = 1 / 8
#: Default threshold of blocks of 0.3 m [m]: a thirtieth of their size.
THRESHOLD = 0.01
#: A free run is at least this many windows long, so that a rest has some time to show.
WINDOWS = 1.5
#: Looks from which a rest may show: a parabola then has an error of five degrees of freedom.
LOOKS = 8


@dataclass(frozen=True)
class Settings:
    """Time stepping, protocol and thresholds.

    Times are for blocks of 0.3 m under 9.81 m/s2; a scene is simulated at that scale whatever its units, and
    times and lengths are reported in the scene's own.
    """

    time_step: float = 1e-3  #: [s] of a simulation, accepted where blocks stand or clearly fall
    quick_step: float = 2e-3  #: [s] of the run that checks another fall, of settling in a verdict, and of LMGC90
    fine_step: float = 5e-4  #: [s] of the run that has the last word; if it is no finer, there is one run only
    iterations: int = 50  #: of the contact solver, a step
    fine_iterations: int = 100  #: in the run that has the last word
    look_every: float = 0.02  #: [s] between looks at the blocks
    settle: float = 0.15  #: [s] under full damping before the free run, and a little longer where joints are glued
    settle_step: float | None = None  #: [s] of most of that time; None: as in the free run
    resolution: float = 1e-3  #: imbalance, as a share of the weight, that a run must be able to see
    clear_fall: float = 0.3  #: [s] after release before which passing the threshold needs no other run
    end: float = 3.0  #: [s] a free run ends here, or after `WINDOWS` windows (three times that after loads change)
    group: str | None = None  #: group of Eq. 1; None: "vault" if there is one, else the whole assembly
    roof_threshold: float | None = None  #: [m] of Eq. 1; None: relative to block size
    brick_threshold: float | None = None  #: [m] of Eq. 2 and of the displacement; None: relative to block size
    crack_threshold: float | None = None  #: [m] from which a joint is cracked; None: relative to block size

    @classmethod
    def named(cls, preset: str, **changes: Any) -> Settings:
        """Return the settings of a preset with some of them changed.

        Parameters
        ----------
        preset : str
            "fast", "default" or "careful"; see `PRESETS`.
        **changes
            Fields of `Settings` and their values.

        Returns
        -------
        Settings
            The settings.

        Raises
        ------
        InputError
            For a preset or a setting that does not exist, and for a value that is out of range.

        Examples
        --------
        >>> from dynsim import Settings
        >>> Settings.named("fast", end=1.0).time_step
        0.002
        """
        if preset not in PRESETS:
            raise InputError(f"no preset {preset!r}; presets are: {', '.join(PRESETS)}")
        known = [field.name for field in fields(cls)]
        unknown = [name for name in changes if name not in known]
        if unknown:
            raise InputError(f"no setting {unknown[0]!r}; settings are: {', '.join(known)}")
        return cls(**{**PRESETS[preset], **changes})

    @classmethod
    def of(cls, given: Settings | None) -> Settings:
        """Return the settings of a call.

        Parameters
        ----------
        given : Settings or None
            What was given; None for the default settings.

        Returns
        -------
        Settings
            The settings.

        Raises
        ------
        InputError
            For anything else, such as the name of a preset.
        """
        if given is None:
            return cls()
        if not isinstance(given, cls):
            preset = f"Settings.named({given!r})" if isinstance(given, str) and given in PRESETS else "dynsim.Settings"
            raise InputError(f"settings are {given!r}; they must be {preset}")
        return given

    def __post_init__(self) -> None:
        for name in (
            "time_step", "quick_step", "fine_step", "look_every", "settle", "settle_step", "resolution", "clear_fall",
            "end", "roof_threshold", "brick_threshold", "crack_threshold",
        ):  # fmt: skip
            value = getattr(self, name)
            if value is None and name.endswith(("threshold", "settle_step")):
                continue
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < float("inf"):
                raise InputError(f"settings: {name} is {value!r}; it must be a positive number")
        if not isinstance(self.group, str | None):
            raise InputError(f"settings: group is {self.group!r}; it must be the name of a group")
        for name in ("iterations", "fine_iterations"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise InputError(f"settings: {name} is {value!r}; it must be a whole number of at least 1")
        settle_step = self.settle_step or self.time_step
        longest = max(self.time_step, self.quick_step, self.fine_step, settle_step)
        if longest > LONGEST_STEP:
            raise InputError(
                f"settings: a time step of {longest!r} s; it must be at most 1/60 s, or blocks pass through each other"
            )
        coarsest = max(self.time_step, self.quick_step, settle_step)
        if not coarsest <= self.look_every <= self.end:
            raise InputError("settings: time_step, quick_step, settle_step <= look_every <= end is needed")
        if self.fine_step > self.quick_step:
            raise InputError("settings: fine_step <= quick_step is needed")

    @property
    def substeps(self) -> int:
        """Number of time steps between two looks."""
        return max(round(self.look_every / self.time_step), 1)

    @property
    def window(self) -> float:
        """Time in which the smallest imbalance that is to be seen moves a block visibly [s].

        Weight that is out of balance by a share e of it moves some block by at least e g t^2 / 2 in a time t. The power
        of the weight along the mechanism is `e sum(m g |u|)`, and its inertia is `sum(m u^2)`. So the block that moves
        most has an acceleration of `e g sum(m |u|) max|u| / sum(m u^2) >= e g`. The window solves
        `e g t^2 / 2 = SHOWN` times the threshold of blocks of 0.3 m: half a second for 1e-3, 1.6 s for 1e-4. Where
        blocks lie still a run ends after half of it (see `dynsim.judge.rest`).
        """
        return sqrt(2 * SHOWN * THRESHOLD / (9.81 * self.resolution))

    @property
    def longest(self) -> float:
        """Time after which a free run ends at the latest [s]; it has `LOOKS` looks at least."""
        return max(self.end, WINDOWS * self.window, (LOOKS - 1) * self.substeps * self.time_step)
