"""What the picture shows of the design: colours, arrows, motion, the block that was clicked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.app.design import ALWAYS, FALLING, LEAST, Pushed
from blockstat.app.words import NO_BLOCK, Known, block_card
from blockstat.result import plain
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

MOTIONS = ("verdict", "displacement")  #: colours that show the mechanism of a design that falls
GENTLE = 1 / 24  #: way of the fastest corner when no amplitude is chosen, relative to the extent


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
        self.moved: Floats | None = None  #: how far a run or a state on show moved the blocks, shape (n_blocks,) [m]
        self.followed = (
            False  #: whether `moved` is a state of a capacity curve, in which the demand at rest says nothing
        )
        self._chosen = ""
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

    def forget(self) -> None:
        """Take the design and the words about it off the page."""
        self.known = self._pose = None
        self.canvas.clear()
        self._layout.legend.content, self._layout.block.content = "", NO_BLOCK
        self._describe_mechanism()

    def again(self) -> None:
        """Draw the same design after a control of the picture was moved."""
        if self.known is not None:
            self.canvas.paint(self._colours(), self._pose, opacity=self._opacity)
            self._rest()

    def pose(self, vertices: Floats) -> None:
        """Move the blocks; the arrows go, for they belong to the blocks at rest.

        Parameters
        ----------
        vertices : array of float, shape (n_vertices, 3)
            Where the vertices go [m].
        """
        if self._pose is None:
            self.canvas.hide_arrows()
        self._pose = vertices
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
        if not player.playing or self._mechanism() is not known.verdict:
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
        self._describe_mechanism()
        result = self._mechanism()
        if result is not None and self._swings(result):
            share = self._layout.amplitude.value or GENTLE
            player.play(swing(result, share * extent(self.known.verdict.assembly)))
            return
        player.stop()
        still = self._still()
        if still is None and self._pose is not None:
            self.canvas.pose(self.known.verdict.assembly.vertices)
            self._pose = None
            self._rest()
        elif still is not None:
            self.pose(still)

    def _swings(self, result: Any) -> bool:
        """Whether a mechanism is shown to and fro: that of a design that falls at once, another when asked for."""
        wanted = self._layout.swing.value
        falls = self.known is not None and result is self.known.verdict
        return wanted == ALWAYS or (wanted == FALLING and falls and self._opacity == 1.0)

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
        self.choose("" if block is None else self.known.verdict.assembly.names[block])

    def choose(self, name: str) -> None:
        """Say what is known of a block, and mark it.

        Parameters
        ----------
        name : str
            Name of the block; one that is not there leaves none chosen.
        """
        self._chosen = name
        if self._layout.chosen.value != name:
            self._layout.chosen.value = name
        if self.known is not None:
            self._mark()

    def _mark(self) -> None:
        """Mark the chosen block and describe it; a design without a block of that name has none chosen."""
        assert self.known is not None
        names = self.known.verdict.assembly.names
        block = names.index(self._chosen) if self._chosen in names else None
        self.canvas.choose(block)
        known = self.known
        card = NO_BLOCK
        if block is not None:
            card = block_card(known.verdict, block, self.moved, shows_motion=known.shows_motion)
        self._layout.block.content = card

    def _rest(self) -> None:
        """Arrows, the mark and the words about the mechanism."""
        assert self.known is not None
        verdict = self.known.verdict
        at_rest, found = self._pose is None, {}
        if self._layout.forces.value and at_rest:
            found = {arrows.name: arrows for arrows in force_arrows(verdict)}
        if self._layout.thrust.value and at_rest:
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
            words = [
                f"longest arrow of {name}: {plain(a.longest / 1e3)} kN" for name, a in found.items() if len(a.tail)
            ]
            self._layout.legend.content += "".join(
                f'<div style="font-size:.85em;margin:0 8px">{text}</div>' for text in words
            )
        self._mark()
        self._describe_mechanism()

    def _colours(self) -> Any:
        assert self.known is not None
        choice = self._layout.colours.value
        choice = "displacement" if choice == "verdict" and self.followed else choice
        if self.moved is None and not self.known.is_scored and not self.known.stopped and choice in MOTIONS:
            choice = "tension"  # whose legend says that it is not known yet
        found = colouring(choice, self.known.verdict, self.moved)
        self._layout.legend.content = f'<div style="font-size:.85em;margin:0 8px">{found.legend}</div>'
        return found

    @property
    def _opacity(self) -> float:
        return GLASS if self._layout.forces.value or self._layout.thrust.value else 1.0

    def _mechanism(self) -> Any:
        """The result whose mechanism there is to show: of the verdict, else of the limit load."""
        if self.known is None or self.known.verdict.mechanism.any():
            return self.known.verdict if self.known is not None and self.known.shows_motion else None
        pushed = self._pushed()
        return pushed.limit if pushed is not None and pushed.limit is not None else None

    def _pushed(self) -> Pushed | None:
        """The limit load whose mechanism was asked for, if it has one."""
        assert self.known is not None
        push = self._layout.push
        found = self.known.weakest if push == LEAST else self.known.pushed.get(push)
        has_one = found is not None and found.limit is not None and found.limit.mechanism.any()
        return found if has_one else None

    def _describe_mechanism(self) -> None:
        known, text = self.known, "none known"
        if known is not None and known.verdict.mechanism.any():
            text = "how the blocks move first" if known.shows_motion else "not known yet"
        elif known is not None and (pushed := self._pushed()) is not None:
            text = f"of the limit load along {pushed.push}"
        self._layout.mechanism.content = f'<div style="font-size:.85em;color:#5c5f66;margin:0 8px">{text}</div>'

    def _still(self) -> Floats | None:
        """Vertices at the amplitude of the slider, None for where they are built."""
        result, share = self._mechanism(), self._layout.amplitude.value
        if result is None or not share or self.moved is not None:
            return None
        return mechanism_vertices(result, 1.0, amplitude=share * extent(result.assembly))
