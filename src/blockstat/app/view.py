"""What the picture shows of the design: colours, arrows, motion, the block that was clicked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.app.words import NO_BLOCK, Known, block_card
from blockstat.typing import Floats
from blockstat.view.plot import extent
from blockstat.view.three_d.arrows import force_arrows, thrust_arrows
from blockstat.view.three_d.canvas import Canvas
from blockstat.view.three_d.colouring import colouring
from blockstat.view.three_d.geometry import contacts_without_area
from blockstat.view.three_d.page import DOT, GLASS, mechanism_vertices
from blockstat.view.three_d.player import Player, swing

if TYPE_CHECKING:
    from blockstat.app.layout import Layout


class View:
    """Draws what is known on a canvas, as the controls of the layout say.

    Parameters
    ----------
    canvas : Canvas
        What is drawn on.
    layout : Layout
        The controls, and the places for text about the picture.
    """

    def __init__(self, canvas: Canvas, layout: Layout) -> None:
        self.canvas, self._layout = canvas, layout
        self.known: Known | None = None
        self.moved: Floats | None = None  #: distances of a dynamic run on show, shape (n_blocks,) [m]
        self._chosen: str | None = None
        self._pose: Floats | None = None

    def show(self, known: Known) -> None:
        """Draw a design, moved along its mechanism as far as the slider says.

        Parameters
        ----------
        known : Known
            What is known of the design.
        """
        self.known = known
        self._pose = self._still()
        self.canvas.draw(known.verdict.assembly, self._colours(), self._pose, opacity=self._opacity)
        self._rest()

    def again(self) -> None:
        """Draw the same design after a control of the picture was moved."""
        if self.known is not None:
            self.canvas.paint(self._colours(), self._pose, opacity=self._opacity)
            self._rest()

    def pose(self, vertices: Floats) -> None:
        """Move the blocks; the arrows stay where they were drawn, and the mark of the chosen block goes.

        Parameters
        ----------
        vertices : array of float, shape (n_vertices, 3)
            Where the vertices go [m].
        """
        self._pose = vertices
        self.canvas.choose(None)
        self.canvas.pose(vertices)

    def learned(self, known: Known, player: Player) -> None:
        """Take in what more is known of the design on show, such as the mechanism of its limit load.

        Parameters
        ----------
        known : Known
            All that is known of the design.
        player : Player
            Moves the blocks.
        """
        self.known = known
        self._describe_mechanism()
        if self._layout.amplitude.value or self._layout.swing.value:
            self.animate(player)

    def animate(self, player: Player) -> None:
        """Show the mechanism as its controls say: still, at rest, or to and fro.

        Parameters
        ----------
        player : Player
            Moves the blocks.
        """
        if self.known is None or self.moved is not None:
            return
        result = self._mechanism()
        if self._layout.swing.value and result is not None:
            share = self._layout.amplitude.value or 1 / 12
            player.play(swing(result, share * extent(self.known.verdict.assembly)))
            return
        player.stop()
        still = self._still()
        if still is not self._pose:
            self.pose(self.known.verdict.assembly.vertices if still is None else still)
            self._pose = still

    def click(self, origin: Any, direction: Any) -> None:
        """Say what is known of the block that a ray hits, and mark it.

        Parameters
        ----------
        origin : sequence of float, shape (3,)
            Where the ray begins, in the coordinates of the page's scene [m].
        direction : sequence of float, shape (3,)
            Where the ray goes.
        """
        from blockstat.view.three_d.geometry import block_at

        if self.known is None:
            return
        block = block_at(self.canvas.shape, self.canvas.vertices, *self.canvas.ray(origin, direction))
        self._chosen = None if block is None else self.known.verdict.assembly.names[block]
        self._mark()

    def _mark(self) -> None:
        """Mark the chosen block and describe it; a design without a block of that name has none chosen."""
        assert self.known is not None
        names = self.known.verdict.assembly.names
        block = names.index(self._chosen) if self._chosen in names else None
        self.canvas.choose(block)
        card = NO_BLOCK if block is None else block_card(self.known.verdict, block, self.moved)
        self._layout.block.content = card

    def _rest(self) -> None:
        """Arrows, the mark and the words about the mechanism."""
        assert self.known is not None
        verdict = self.known.verdict
        found = {arrows.name: arrows for arrows in force_arrows(verdict)} if self._layout.forces.value else {}
        if self._layout.thrust.value:
            found["thrust"] = thrust_arrows(verdict)
        for name in ("forces", "tension", "thrust"):
            arrows = found.get(name)
            if arrows is None:
                self.canvas.arrows(name, verdict.assembly.vertices[:0], verdict.assembly.vertices[:0], (0, 0, 0), 1.0)
            else:
                self.canvas.arrows(name, arrows.tail, arrows.head, arrows.colour, arrows.radius)
        shown = verdict.interfaces if found else verdict.interfaces.subset(np.empty(0, dtype=np.int64))
        self.canvas.contacts(*contacts_without_area(shown), DOT * extent(verdict.assembly))
        if found:
            words = [f"longest arrow of {name}: {a.longest / 1e3:.3g} kN" for name, a in found.items() if len(a.tail)]
            self._layout.legend.content += "".join(
                f'<div style="font-size:.85em;margin:0 8px">{text}</div>' for text in words
            )
        self._mark()
        self._describe_mechanism()

    def _colours(self) -> Any:
        assert self.known is not None
        found = colouring(self._layout.colours.value, self.known.verdict, self.moved)
        self._layout.legend.content = f'<div style="font-size:.85em;margin:0 8px">{found.legend}</div>'
        return found

    @property
    def _opacity(self) -> float:
        return GLASS if self._layout.forces.value or self._layout.thrust.value else 1.0

    def _mechanism(self) -> Any:
        """The result whose mechanism there is to show: of the verdict, else of the limit load."""
        known = self.known
        if known is None:
            return None
        if known.verdict.mechanism.any():
            return known.verdict
        limit = known.pushed.limit if known.pushed is not None else None
        return limit if limit is not None and limit.mechanism.any() else None

    def _describe_mechanism(self) -> None:
        known, result = self.known, self._mechanism()
        text = "none known"
        if known is not None and result is known.verdict:
            text = "how the blocks move first"
        elif known is not None and result is not None:
            text = f"of the limit load along {known.push}"
        self._layout.mechanism.content = f'<div style="font-size:.85em;color:#666;margin:0 8px">{text}</div>'

    def _still(self) -> Floats | None:
        """Vertices at the amplitude of the slider, None for where they are built."""
        result, share = self._mechanism(), self._layout.amplitude.value
        if result is None or not share or self.moved is not None:
            return None
        return mechanism_vertices(result, 1.0, amplitude=share * extent(result.assembly))
