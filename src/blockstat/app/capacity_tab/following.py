"""What a process of the page does to follow a capacity curve: each state is sent as soon as it is known."""

from __future__ import annotations

from blockstat.analysis.verdict import Verdict
from blockstat.app.background import Channel, Refused
from blockstat.app.capacity_tab.trace import Event, Finished, told
from blockstat.app.design import PUSHES
from blockstat.errors import InputError
from blockstat.large_displacement.capacity_analysis import capacity


def follow_curve(channel: Channel, verdict: Verdict, push: str, control: str | None) -> None:
    """Follow the mechanism of a limit load to large displacements.

    Parameters
    ----------
    channel : Channel
        `Seen` and `Event` and then `Finished`, or `Refused`, are sent through it.
    verdict : Verdict
        The static verdict on the design on show.
    push : str
        Direction of the load, a key of `PUSHES`.
    control : str or None
        Whose displacement is followed, as in `blockstat.capacity`; None for the corner that moves most.
    """
    names = verdict.assembly.names
    try:
        curve = capacity(
            verdict.assembly,
            PUSHES[push],
            control=control,
            interfaces=verdict.interfaces,
            each=lambda item: channel.send(told(item, names)),
        )
    except InputError as error:
        channel.send(Refused(str(error)))
        return
    events = tuple(event for event in (told(item, names) for item in curve.events) if isinstance(event, Event))
    channel.send(Finished(curve.outcome.value, curve.control, events, curve.warnings))
