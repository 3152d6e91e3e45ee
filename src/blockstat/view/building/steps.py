"""The steps of a plan side by side: what is there, what is held, what falls."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.errors import InputError, known_options
from blockstat.typing import Floats, Ints
from blockstat.view.painter import AZIMUTH, ELEVATION, posed, view_of, visible
from blockstat.view.plot import STONE, SUPPORT, fresh_figure, save_figure

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.sequence.plan import PlanVerdict

#: Colours of held blocks and of those that move, told apart by colour-blind readers, too.
HELD, FALLS = (0.0, 0.447, 0.698), (0.835, 0.369, 0.0)


@known_options
def plot_plan(
    assembly: Assembly,
    found: PlanVerdict,
    path: str | Path,
    *,
    frames: int = 8,
    azimuth: float = AZIMUTH,
    elevation: float = ELEVATION,
) -> Path:
    """Draw steps of a plan side by side; the first that does not stand is among them.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : PlanVerdict
        What `blockstat.assess_plan` returns.
    path : str or Path
        A PNG, or any format that matplotlib writes.
    frames : int, optional
        How many steps, evenly spread.
    azimuth, elevation : float, optional
        From where one looks [degrees].

    Returns
    -------
    Path
        The file. Held blocks are blue, and those that move where a step falls are orange.

    Raises
    ------
    InputError
        For a file that cannot be written, or fewer than one frame.

    Examples
    --------
    >>> from blockstat import Assembly, Plan, Step, assess_plan, box, plot_plan
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.6, 0, 0), (0.4, 1, 1), name="low")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plan = Plan((Step(("low",), ("low",)), Step()))
    >>> plot_plan(assembly, assess_plan(assembly, plan), "plan.png").name
    'plan.png'
    """
    from matplotlib.collections import PolyCollection

    if frames < 1:
        raise InputError(f"plot_plan: frames is {frames!r}; it must be at least 1")
    path = Path(path)
    chosen = _chosen(found, frames)
    figure = fresh_figure(path)
    figure.set_size_inches(3.0 * len(chosen), 3.4)
    view = view_of(azimuth, elevation)
    vertices = posed(assembly, None, None)
    flat = vertices @ view[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    for axes, step in zip(figure.subplots(1, len(chosen), squeeze=False)[0], chosen.tolist(), strict=True):
        polygons, paint, outline = visible(assembly, vertices, view, _colours(assembly, found, step))
        axes.add_collection(PolyCollection(polygons, facecolors=paint, edgecolors=outline, linewidths=0.3))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.axis("off")
        axes.set_title(f"step {step}: {found.outcomes[step].word}", fontsize=9)
    save_figure(figure, path)
    return path


def _chosen(found: PlanVerdict, frames: int) -> Ints:
    """The numbers of the steps to draw."""
    if not found.verdicts:
        raise InputError("the plan has no steps to draw")
    steps = np.linspace(0, len(found.verdicts) - 1, frames).round().astype(np.int64)
    fall = [] if found.first_fall is None else [found.first_fall]
    return np.unique(np.append(steps, fall).astype(np.int64))


def _colours(assembly: Assembly, found: PlanVerdict, step: int) -> Floats:
    """Red, green, blue and opacity of each block after a step; what is not there is clear."""
    present, held = (np.isin(assembly.names, names) for names in found.plan.states()[step])
    verdict = found.verdicts[step]
    colour = np.column_stack([np.tile(STONE, (assembly.n_blocks, 1)), (present | assembly.support).astype(float)])
    boundary = assembly.support | np.isin(assembly.names, found.plan.boundary)
    colour[held & ~boundary, :3] = HELD
    if found.outcomes[step] is not Outcome.STABLE:
        colour[verdict.moving, :3] = FALLS
    colour[boundary, :3] = SUPPORT
    return colour
