"""The steps of a plan on a page, with a slider from the first to the last."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.errors import InputError
from blockstat.result import listed
from blockstat.typing import Floats
from blockstat.view.building.steps import FALLS, HELD
from blockstat.view.plot import STONE, SUPPORT
from blockstat.view.three_d.canvas import Canvas
from blockstat.view.three_d.colouring import Colouring

if TYPE_CHECKING:
    import viser

    from blockstat.assembly import Assembly
    from blockstat.sequence.plan import PlanVerdict

#: Colours by number: supports, blocks, held blocks, blocks that move.
PALETTE = np.round(255 * np.array([SUPPORT, STONE, HELD, FALLS])).astype(np.int64)
#: Blocks that the words of a step name.
FEW = 6


class StepSlider:
    """A slider over the steps of a plan: what is there, what is held, and what falls.

    Parameters
    ----------
    server : viser.ViserServer
        Where it is drawn.
    assembly : Assembly
        All blocks.
    found : PlanVerdict
        What `blockstat.assess_plan` returns.

    Examples
    --------
    It needs the extra ui:

    >>> from blockstat.view.building.slider import StepSlider
    >>> from blockstat.view.three_d.page import start_viser
    >>> page = StepSlider(start_viser()[0], assembly, found)  # doctest: +SKIP
    >>> page.to(5)  # doctest: +SKIP
    """

    def __init__(self, server: viser.ViserServer, assembly: Assembly, found: PlanVerdict) -> None:
        if not found.verdicts:
            raise InputError("the plan has no steps to draw")
        self._assembly, self._found = assembly, found
        self._canvas = Canvas(server)
        self._canvas.recentre(assembly)
        self._canvas.draw(assembly, self._colours(0), self._vertices(0))
        last = max(len(found.verdicts) - 1, 1)
        self.slider = server.gui.add_slider("step", min=0, max=last, step=1, initial_value=0)
        self.words = server.gui.add_html(self._words(0))
        self.slider.on_update(lambda _: self.to(int(self.slider.value)))

    def to(self, step: int) -> None:
        """Show a step.

        Parameters
        ----------
        step : int
            Its number, from 0.
        """
        step = min(step, len(self._found.verdicts) - 1)
        self._canvas.paint(self._colours(step), self._vertices(step))
        self.words.content = self._words(step)

    def _vertices(self, step: int) -> Floats:
        """Vertices of the blocks that are there; those of others are drawn together in one point."""
        assembly = self._assembly
        present = np.isin(assembly.names, self._found.plan.states()[step][0]) | assembly.support
        there = present[assembly.vertex_block]
        return np.where(there[:, None], assembly.vertices, assembly.centroid[assembly.vertex_block])

    def _colours(self, step: int) -> Colouring:
        assembly, verdict = self._assembly, self._found.verdicts[step]
        index = np.ones(assembly.n_blocks, dtype=np.int64)
        index[np.isin(assembly.names, self._found.plan.steps[step].hold)] = 2
        if self._found.outcomes[step] is not Outcome.STABLE:
            index[verdict.moving] = 3
        index[assembly.support | np.isin(assembly.names, self._found.plan.boundary)] = 0
        return Colouring(PALETTE, index, "")

    def _words(self, step: int) -> str:
        """The verdict on a step, and what is put in, held and moving."""
        plan, outcome = self._found.plan.steps[step], self._found.outcomes[step]
        moves = [] if outcome is Outcome.STABLE else self._found.verdicts[step].moving
        moving, props = [self._assembly.names[k] for k in moves], self._found.plan.standing_props()[step]
        rows = (("put in", plan.install), ("held", plan.hold), ("props", props), ("first to move", moving))
        parts = [f"<b>step {step}: {outcome.word}</b>"]
        for what, names in rows:
            if names:
                parts.append(f"{what}: {escape(listed(names, FEW))}")
        return "<br>".join(parts)
