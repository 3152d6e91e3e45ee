"""The way of the thrust through the blocks, from joint to joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import Verdict
from blockstat.loads import up_of
from blockstat.result import plain
from blockstat.typing import Floats
from blockstat.view.painter import looked_at
from blockstat.view.plot import Place, balanced, joint_resultants, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

THRUST = "#b2182b"
#: Widest line [pt]; thinner than the least one says nothing.
WIDEST, THINNEST = 4.0, 0.15


def plot_thrust(verdict: Verdict, place: Place, **options: Any) -> Place:
    """Draw the thrust: lines through the centres of pressure, from the joints that load a block to those that carry it.

    In an arch they are its thrust line. The width goes with the force.

    Parameters
    ----------
    verdict : Verdict
        Best with an admissible force field; the title says where there is none.
    place : str, Path or matplotlib Axes
        A file or axes, as in `blockstat.plot`.
    **options
        Options of `blockstat.plot` without `overlay`.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For a file that cannot be written, or an unknown option.

    Examples
    --------
    >>> from blockstat import assess, plot_thrust
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> plot_thrust(assess(ring), "thrust.png")
    'thrust.png'
    """
    from matplotlib.collections import LineCollection

    look, view = looked_at(options)
    lines, carried = thrust_lines(verdict)
    width = WIDEST * np.sqrt(carried / max(float(carried.max(initial=0.0)), 1e-300))

    def draw(axes: Axes) -> None:
        shown = width > THINNEST
        axes.add_collection(LineCollection(list(lines[shown] @ view[:2].T), colors=THRUST, linewidths=width[shown]))

    what = "thrust" if balanced(verdict) else "not in equilibrium, thrust of least residual tension"
    title = f"{verdict.assembly.name}: {what}, widest {plain(carried.max(initial=0.0) / 1e3)} kN"
    drawn = {"title": title, "opacity": 0.35}
    return plot(verdict.assembly, place, **drawn | look, overlay=draw)


def thrust_lines(verdict: Verdict) -> tuple[Floats, Floats]:
    """Return the lines of thrust through the free blocks.

    Parameters
    ----------
    verdict : Verdict
        A verdict with an admissible force field.

    Returns
    -------
    lines : array of float, shape (n, 2, 3)
        From where the thrust enters a block to where it leaves it [m]. What a block without a load on it carries enters
        at its centroid.
    force : array of float, shape (n,)
        What goes that way [N]: the force that enters, divided like the forces that leave.
    """
    assembly, faces = verdict.assembly, verdict.interfaces
    joint, point, force, _ = joint_resultants(verdict)
    down = -up_of(assembly)
    size = np.linalg.norm(force, axis=1)
    entering: dict[int, list[tuple[Floats, float]]] = {}
    leaving: dict[int, list[tuple[Floats, float]]] = {}
    for k, middle, push, amount in zip(joint, point, force @ down, size, strict=True):
        for block, sign in zip(faces.pair[k], (-1.0, 1.0), strict=True):
            side = entering if sign * push > 0 else leaving  # a force downwards on the block loads it
            side.setdefault(int(block), []).append((middle, float(amount)))
    lines, carried = [], []
    for block, below in leaving.items():
        if assembly.support[block]:
            continue
        total = sum(amount for _, amount in below)
        centroid = assembly.centroid[block]
        for start, amount in entering.get(block, [(centroid, total)]):
            for end, share in below:
                lines.append([start, end])
                carried.append(amount * share / total)
    return np.array(lines).reshape(-1, 2, 3), np.array(carried)
