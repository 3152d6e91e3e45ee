"""The tab "Fall": Bullet's verdict on the design on show, next to the static one, and the film of it."""

from __future__ import annotations

from html import escape
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.app.background import Crashed, Refused, Worker
from blockstat.app.words import MARGIN, SMALL, small
from blockstat.result import millimetres
from blockstat.view.three_d.player import HOLD, trajectory
from dynsim.panel.work import Fallen, Film, let_fall

if TYPE_CHECKING:
    from blockstat.app.page import Page
    from blockstat.app.words import Known
    from dynsim.judge.verdict import DynamicVerdict

TONES = {"stands": "#0072B2", "falls": "#D55E00", "creeps": "#CC79A7"}
#: A film shorter than this is played slower, so that it can be followed [s].
SHORT = 2.5


class FallPanel:
    """The tab "Fall", which runs Bullet in another process.

    A change of the design ends the run. A browser that is closed does not.
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
        self._fallen: Fallen | None = None
        self._film: Film | None = None
        self._began = 0.0
        gui = page.server.gui
        with page.tabs.add_tab("Fall"):
            self._go = gui.add_button("Let it fall", hint="simulate the blocks in Bullet")
            self._stop = gui.add_button("Stop Bullet", disabled=True)
            self._replay = gui.add_button("Play again", disabled=True)
            self._text = gui.add_html("")
        for button, call in ((self._go, self.start), (self._stop, self.cancel), (self._replay, self.play)):
            button.on_click(lambda _, call=call: page.post(call))
        self._say("Bullet has not been asked about this design.")

    def opened(self) -> None:
        """Forget what is known of the scene before."""
        self._known = None
        self._forget("Bullet has not been asked about this design.")

    def judged(self, known: Known) -> None:
        """Take in the design on show, and end the run of another one.

        Parameters
        ----------
        known : Known
            The design and its static verdict.
        """
        self._known = known
        self._forget("Bullet has not been asked about this design.")

    def start(self) -> None:
        """Simulate the design on show."""
        if self._known is None or (self._worker is not None and self._worker.running):
            return
        self._forget("Bullet is simulating …")
        self._began = monotonic()
        self._stop.disabled, self._go.disabled = False, True
        self._worker = worker = self._page.start(
            let_fall, self._known.verdict, report=lambda message: self._told(worker, message)
        )

    def cancel(self) -> None:
        """End a run; what is known already stays."""
        if self._worker is not None and self._worker.running:
            self._end()
            self._ended("Bullet was stopped.")

    def play(self) -> None:
        """Show the film."""
        if self._film is None or self._known is None or self._fallen is None:
            return
        film, page = self._film, self._page
        seconds = float(film.times[-1])
        slower = min(1.0, seconds / SHORT) if seconds > 0 else 1.0
        move = trajectory(self._known.verdict.assembly, film.times, film.displacement, film.rotation)
        page.view.moved = np.linalg.norm(film.displacement[-1] - film.displacement[0], axis=1).astype(float)
        page.view.again()
        page.play(lambda time: move(time * slower), seconds / slower + HOLD)

    def _told(self, worker: Worker, message: Any) -> None:
        if worker is not self._worker:
            return
        if isinstance(message, Fallen):
            self._fallen = message
            self._page.simulated(message.verdict)
            self._show(f"after {monotonic() - self._began:.0f} s; the film is being made …")
        elif isinstance(message, Film):
            self._film = message
            self._replay.disabled = False
            self._show("")
            self._end()
            self.play()
        elif isinstance(message, Refused):
            self._say(message.message)
            self._end()
        elif isinstance(message, Crashed):
            answer = "an answer" if self._fallen is None else "a film"
            self._ended(f"Bullet ended without {answer}: {message.message}")
            self._end()

    def _ended(self, text: str) -> None:
        """Say how a run ended, below the verdict where it is known."""
        if self._fallen is None:
            self._say(text)
        else:
            self._show(text)

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.stop()
            self._worker = None
        self._stop.disabled, self._go.disabled = True, False

    def _forget(self, text: str) -> None:
        if self._worker is not None and self._worker.running:
            text += " The run of another design was ended."
        self._end()
        self._fallen = self._film = None
        self._replay.disabled = True
        self._say(text)

    def _show(self, note: str) -> None:
        if self._fallen is not None and self._known is not None:
            self._text.content = side_by_side(self._known, self._fallen) + small(escape(note))

    def _say(self, text: str) -> None:
        self._text.content = small(escape(text))


def side_by_side(known: Known, fallen: Fallen) -> str:
    """Return static and dynamic verdicts next to each other, and the criteria against their thresholds.

    Parameters
    ----------
    known : Known
        The design and its static verdict.
    fallen : Fallen
        Bullet's verdict.

    Returns
    -------
    str
        HTML.
    """
    verdict = fallen.verdict
    word = verdict.outcome.word
    moved = (
        f"<tr><td>statics</td><td><b>{escape(known.verdict.outcome.word.replace('_', ' '))}</b></td></tr>"
        f'<tr><td>Bullet</td><td><b style="color:{TONES.get(word, "#6b6b6b")}">{escape(word)}</b></td></tr>'
    )
    rows = "".join(
        f"<tr><td>{name}</td><td><b>{millimetres(value)}</b></td><td>{millimetres(limit)}</td>"
        f"<td>{'passes' if value < limit else 'fails'}</td></tr>"
        for name, value, limit in criteria(verdict)
    )
    head = "<tr style='color:#666'><td>mm</td><td>moved</td><td>threshold</td><td></td></tr>"
    first = f"First to move: {verdict.first_block}." if verdict.first_block else ""
    notes = "".join(small(escape(text)) for text in (first, fallen.reason, *verdict.warnings) if text)
    return (
        f'<table style="width:94%;{MARGIN};{SMALL}">{moved}</table>'
        f'<table style="width:94%;{MARGIN};{SMALL}">{head}{rows}</table>'
        f"{small(escape(verdict.outcome.value))}{notes}"
    )


def criteria(verdict: DynamicVerdict) -> list[tuple[str, float, float]]:
    """Return the criteria of a verdict.

    Parameters
    ----------
    verdict : DynamicVerdict
        Bullet's verdict.

    Returns
    -------
    list of (str, float, float)
        Name, displacement and threshold [m] of Eq. 1, Eq. 2, the length of the displacement, and the way of a point at
        half the size of its block from the centroid by its rotation.
    """
    roof = escape(verdict.group or "whole assembly")
    return [
        (f"Eq. 1, {roof} down", verdict.group_drop, verdict.roof_threshold),
        ("Eq. 2, a block down", verdict.max_drop, verdict.brick_threshold),
        ("a block, any way", verdict.max_displacement, verdict.brick_threshold),
        ("a block, by turning", verdict.max_turn, verdict.turn_threshold),
    ]
