"""How far a simulation is, while a command waits for it."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from dynsim.settings import PRESETS, Settings

#: From this on, a wait is worth a word on how to make it shorter [s].
LONG = 60.0


def shown(say: Callable[[str], None], blocks: int, settings: Settings) -> Callable[[float, float, float], None]:
    """Say how much of a run has been simulated, and how long it takes until the loads no longer change.

    Parameters
    ----------
    say : callable
        Takes what is being done (see `blockstat.cli.progress.at_work`).
    blocks : int
        How many.
    settings : Settings
        Those of the run.

    Returns
    -------
    callable
        As `progress` of `dynsim.verify`.

    Examples
    --------
    >>> show = shown(print, 509, Settings())
    >>> show(0.0, 10.0, 25.0)
    simulating 509 blocks: 0 s of 10 s under changing loads
    >>> show(12.0, 10.0, 25.0)
    simulating 509 blocks: 12 s, at rest by 25 s or not at all
    """
    begin: list[float] = []
    quicker = "; --preset fast is quicker" if settings.time_step < PRESETS["fast"]["time_step"] else ""

    def show(passed: float, change: float, latest: float) -> None:
        now = monotonic()
        if not passed:
            begin[:] = [now]
        text = f"simulating {blocks:,} blocks: {passed:.2g} s"
        if passed < change:
            left = (now - begin[0]) * (change / passed - 1) if passed else 0.0
            text += f" of {change:.3g} s under changing loads"
            text += (f", about {left:,.0f} s to go" if passed else "") + (quicker if left > LONG else "")
        else:
            text += f", at rest by {latest:.3g} s or not at all"
        say(text)

    return show
