"""The tab "Capacity": a curve that another process follows, a slider along it, and the blocks where they are there."""

from __future__ import annotations

from html import escape
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.app.background import Crashed, Refused, Worker
from blockstat.app.capacity_tab.figure import figure
from blockstat.app.capacity_tab.following import follow_curve
from blockstat.app.capacity_tab.trace import CLICKED, MOST, Event, Finished, Seen, Trace, controls
from blockstat.app.design import PUSHES
from blockstat.app.words import small
from blockstat.view.settling import film_times
from blockstat.view.three_d.dress import AT_REST, CAPACITY

if TYPE_CHECKING:
    from blockstat.app.page import Page
    from blockstat.app.words import Known

NOTHING = "No curve has been followed for this design."
CHANGED = "The scene has changed: this is the curve of another design."


class CapacityPanel:
    """The tab "Capacity", which follows a capacity curve in another process.

    A change of the design ends the work; the curve stays, in grey, until another one is followed.
    """

    def attach(self, page: Page) -> None:
        """Add the tab to a page.

        Parameters
        ----------
        page : Page
            The live page.
        """
        self._page = page
        self._worker: Worker | None = None
        self._known: Known | None = None
        self._trace: Trace | None = None
        self._old = False  # the curve is of another design than the one on show
        self._at, self._playing = 0, False
        self._began = 0.0
        gui = page.server.gui
        with page.tabs.add_tab(CAPACITY):
            self._push = gui.add_dropdown("load", tuple(PUSHES), hint="direction of the growing acceleration")
            self._control = gui.add_dropdown(
                "control", (MOST, CLICKED), hint="whose displacement along the load the curve is drawn against"
            )
            self._go = gui.add_button("Follow", hint="the mechanism of the limit load, to large displacements")
            self._stop = gui.add_button("Stop following", disabled=True)
            self._bar = gui.add_progress_bar(100.0, animated=True, visible=False)
            self._text = gui.add_html("")
            self._figure = gui.add_html("")
            self._slider = gui.add_slider("state", 0, 1, 1, 0, visible=False, hint="along the curve")
            self._words = gui.add_html("")
            self._play = gui.add_button("Play", visible=False, hint="the blocks along the curve, in true scale")
            self._notes = gui.add_html("")
        with page.layout.results:
            self._rest = gui.add_button(AT_REST, visible=False, order=page.layout.numbers.order - 0.5)
        calls = ((self._go, self.start), (self._stop, self.cancel), (self._play, self.play), (self._rest, self.rest))
        for button, call in calls:
            button.on_click(lambda _, call=call: page.post(call))
        self._slider.on_update(lambda _: page.post(self._slid))
        self._say(NOTHING)

    def opened(self) -> None:
        """Forget what is known of the scene before."""
        self._known = None
        self._end()
        self._clear(NOTHING)

    def judged(self, known: Known) -> None:
        """Take in the design on show: end the work on another one, and leave its curve in grey.

        Parameters
        ----------
        known : Known
            The design and its static verdict.
        """
        ended = self._worker is not None
        self._end()
        self._known, offered = known, controls(known.verdict.assembly)
        if offered != self._control.options:
            self._control.options = offered
        self._still()
        if self._trace is None or not self._trace.states:
            self._clear(NOTHING + (" The work on another design was ended." if ended else ""))
            return
        self._old, self._at = True, 0
        self._slider.value = 0
        self._slider.visible = self._play.visible = False
        self._words.content = self._notes.content = ""
        self._say(CHANGED)
        self._draw()

    def start(self) -> None:
        """Follow the curve of the design on show."""
        if self._known is None or (self._worker is not None and self._worker.running):
            return
        control: str | None = self._control.value
        if control == CLICKED:
            control = self._page.layout.chosen.value
            if not control:
                self._say("No block is chosen: click one, or type its name under Block.")
                return
        self.rest()
        self._clear("Looking for the limit load and how motion begins …")
        self._trace, self._began = Trace(self._push.value), monotonic()
        self._stop.disabled, self._go.disabled, self._bar.visible = False, True, True
        self._worker = worker = self._page.start(
            follow_curve,
            self._known.verdict,
            self._push.value,
            None if control == MOST else control,
            report=lambda message: self._told(worker, message),
            timed=True,
        )

    def cancel(self) -> None:
        """End the work; what was followed until then stays."""
        if self._worker is not None and self._worker.running:
            self._end()
            self._say(f"Stopped. {self._kept()}")

    def play(self) -> None:
        """Show the blocks along the curve from the present state on, or from rest at its end; or pause."""
        trace, page = self._trace, self._page
        if self._playing:
            page.player.stop()
            self._still()
        elif trace is not None and len(trace.states) > 1 and not self._old:
            times = film_times(np.array([state.displacement for state in trace.states]))
            last = len(times) - 1
            begin = float(times[self._at]) if self._at < last else 0.0
            seconds, assembly = float(times[last]) - begin, page.view.canvas.assembly

            def film(time: float) -> Any:
                done = time >= seconds
                at = last if done else int(np.searchsorted(times, begin + time, side="right")) - 1
                if at != self._at:
                    self._put(at)
                if done:
                    self._still()
                return trace.vertices(assembly, at)

            self._put(0 if self._at == last else self._at)
            self._playing, self._play.label = True, "Pause"
            page.play(film, seconds)

    def rest(self) -> None:
        """Show the blocks where they are built, as before the slider was moved."""
        if self._page.view.followed:
            self._page.stop_film()
            self._page.repaint()
        self._still()
        self._at, self._slider.value = 0, 0
        self._tell_state()

    def _slid(self) -> None:
        """The slider was moved, by a user or along with the film."""
        at = int(self._slider.value)
        if self._trace is None or self._old or at == self._at or at >= len(self._trace.states):
            return
        self._page.player.stop()
        self._put(at)
        self._playing, self._play.label = False, "Play"

    def _put(self, at: int) -> None:
        """Show the blocks in a state of the curve."""
        assert self._trace is not None
        view, trace = self._page.view, self._trace
        if not view.followed:
            self._page.player.stop()  # a mechanism to and fro
        self._at, self._slider.value = at, at
        view.followed = True
        view.moved = np.linalg.norm(trace.states[at].moved, axis=1).astype(float)
        view.pose(trace.vertices(view.canvas.assembly, at))
        view.again()
        self._rest.visible = True
        self._tell_state()

    def _told(self, worker: Worker, message: Any) -> None:
        trace = self._trace
        if worker is not self._worker or trace is None:
            return
        if isinstance(message, (Seen, Event)):
            trace.take(message)
            self._say(f"Following: {trace.states[-1].words}." if trace.states else "Following …")
            self._draw()
        elif isinstance(message, Finished):
            trace.take(message)
            self._end()
            self._say(message.sentence, f"Displacement: {message.control}.", self._kept())
            self._draw()
        elif isinstance(message, (Refused, Crashed)):
            self._end()
            self._say(message.message, self._kept() if trace.states else "")

    def _kept(self) -> str:
        states = 0 if self._trace is None else len(self._trace.states)
        return f"{states} state{'' if states == 1 else 's'} in {monotonic() - self._began:.0f} s."

    def _draw(self) -> None:
        """The figure, and the slider as long as the curve."""
        trace = self._trace
        if trace is None or not trace.states:
            return
        last = len(trace.states) - 1
        if last > 0 and not self._old:
            self._slider.max = last
            self._slider.visible = self._play.visible = True
        self._tell_state()

    def _tell_state(self) -> None:
        """The mark in the figure, and displacement and multiplier of the state."""
        trace = self._trace
        if trace is None or not trace.states:
            return
        self._figure.content = figure(trace, self._at, old=self._old)
        if not self._old:
            self._words.content = small(f"<b>{escape(trace.states[self._at].words)}</b>")
            self._notes.content = small(trace.notes())

    def _still(self) -> None:
        """No film of the curve runs; the button of rest is there while blocks are displaced."""
        self._playing, self._play.label = False, "Play"
        self._rest.visible = self._page.view.followed

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.stop()
            self._worker = None
        self._stop.disabled, self._go.disabled, self._bar.visible = True, False, False

    def _clear(self, text: str) -> None:
        self._trace, self._old, self._at = None, False, 0
        self._slider.value = 0
        self._slider.visible = self._play.visible = False
        self._figure.content = self._words.content = self._notes.content = ""
        self._still()
        self._say(text)

    def _say(self, *lines: str) -> None:
        self._text.content = small("".join(f"<div>{escape(line)}</div>" for line in lines if line))
