"""A plan as an animated GLB: blocks appear step by step, and what falls shows its mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.errors import InputError, known_options
from blockstat.view.animation import write_motion

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.sequence.plan import PlanVerdict

#: Of a step, when its mechanism begins, is largest and has ended.
BEGINS, LARGEST, ENDS = 0.3, 0.8, 0.9
#: Of the median size of a block, how far the fastest corner is shown to move.
SHOWN = 0.3


@known_options
def write_plan_film(assembly: Assembly, found: PlanVerdict, path: str | Path, *, seconds: float = 1.0) -> Path:
    """Write the steps of a plan as an animated GLB.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : PlanVerdict
        What `blockstat.assess_plan` returns.
    path : str or Path
        A .glb in a directory that exists.
    seconds : float, optional
        How long each step is shown.

    Returns
    -------
    Path
        The file. Blocks appear with their step. In a step that falls blocks move along its mechanism, by a third of a
        block at most, and are put back. Colours tell in how many steps a block is held or moves.

    Raises
    ------
    InputError
        For a path that is no .glb in a directory that exists, and a time that is not positive.

    Examples
    --------
    >>> from blockstat import Assembly, Plan, Step, assess_plan, box, write_plan_film
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.6, 0, 0), (0.4, 1, 1), name="low")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> write_plan_film(assembly, assess_plan(assembly, Plan((Step(("low",)),))), "film.glb").name
    'film.glb'
    """
    if not 0 < seconds < np.inf:
        raise InputError(f"write_plan_film: seconds is {seconds!r}; it must be a positive number")
    n, steps = assembly.n_blocks, len(found.plan.steps)
    number = {name: k for k, name in enumerate(assembly.names)}
    come, busy = np.where(assembly.support, 0.0, np.inf), np.zeros(n)
    come[[number[name] for name in found.plan.boundary]] = 0.0
    keys, moved, turned = [0.0], [np.zeros((n, 3))], [np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))]

    def key(time: float, scale: float, twist: np.ndarray) -> None:
        keys.append(seconds * time)
        moved.append(scale * twist[:, :3])
        half = np.linalg.norm(scale * twist[:, 3:], axis=1, keepdims=True) / 2
        axis = scale * twist[:, 3:] * np.sinc(half / np.pi) / 2
        turned.append(np.hstack([axis, np.cos(half)]))

    for k, (step, verdict) in enumerate(zip(found.plan.steps, found.verdicts, strict=True)):
        put = [number[name] for name in step.install]
        come[put] = np.minimum(come[put], seconds * k)
        busy[[number[name] for name in step.hold]] += 1
        if found.outcomes[k] is Outcome.UNSTABLE:
            busy[verdict.moving] += 1
            scale = SHOWN * float(np.median(assembly.size[assembly.free]))  # the fastest corner moves by 1 m
            for part, share in ((BEGINS, 0.0), (LARGEST, scale), (ENDS, 0.0)):
                key(k + part, share, verdict.mechanism)
    key(float(steps), 0.0, np.zeros((n, 6)))
    return write_motion(
        assembly, path, times=np.array(keys), displacement=np.array(moved), quaternion=np.array(turned), values=busy,
        come=come, name="plan",
    )  # fmt: skip
