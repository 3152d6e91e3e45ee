"""The tab "Optimise": a search over chosen parameters, its history as a plot, and each of its designs at a click."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.app.background import Crashed, Refused, Worker
from blockstat.app.controls import named
from blockstat.app.words import MARGIN, SMALL
from blockstat.errors import InputError
from dynsim.panel.work import Found, Step, optimise

if TYPE_CHECKING:
    from blockstat.app.page import Page
    from blockstat.app.words import Known
    from blockstat.design_search.search import Candidate

#: What became of a design, and its colour in the plot and on its row.
KINDS = {"stands": (0, 114, 178), "falls": (213, 94, 0), "creeps": (204, 121, 167), "pruned": (150, 150, 150)}
#: Rows that stay on the page; the newest ones.
MOST_ROWS = 60
OFF = -1e9  #: a dot that is not seen: the plot takes no value for missing


class OptimisePanel:
    """The tab "Optimise", which searches in another process.

    Cancelling ends the search at once and keeps its history.
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
        self._rows: list[Any] = []
        self._history: list[Candidate] = []
        self._started: dict[str, float] = {}  # values with which the search began
        self._choices: dict[str, Any] = {}
        self._plot: Any = None
        self._top = 0.0  # of the plot [m3]
        gui = page.server.gui
        self._tab = page.tabs.add_tab("Optimise")
        with self._tab:
            self._go = gui.add_button(
                "Optimise", hint="the smallest values of the chosen parameters at which the building stands"
            )
            self._cancel = gui.add_button("Cancel", disabled=True)
            self._choice = gui.add_folder("Parameters to move")
            self._bar = gui.add_progress_bar(0.0, visible=False)
            self._text = gui.add_html("")
            self._chart = gui.add_folder("Volume of each design [m³]", visible=False)
            self._list = gui.add_folder("Designs, newest first", visible=False)
        self._go.on_click(lambda _: page.post(self.start))
        self._cancel.on_click(lambda _: page.post(self.cancel))

    def opened(self) -> None:
        """Show the parameters of the scene that was opened."""
        self._end()
        self._clear()
        for choice in self._choices.values():
            choice.remove()
        self._choices = {}
        try:
            own = self._page.model.own_ranges
        except InputError as error:
            self._say(str(error))
            own = {}
        with self._choice:
            for path in own:
                self._choices[path] = self._page.server.gui.add_checkbox(" ".join(named(path)), True)
        self._go.disabled = not own
        if own:
            self._say("Statics prune, Bullet confirms; parameters that are not chosen stay as they are.")

    def judged(self, known: Known) -> None:
        """Do nothing: a search goes on while the design on show changes.

        Parameters
        ----------
        known : Known
            The design and its static verdict.
        """
        pass

    def start(self) -> None:
        """Search the chosen parameters, one after the other in the order of the page."""
        names = [path for path, choice in self._choices.items() if choice.value]
        if not names:
            self._say("Choose a parameter to move.")
            return
        if self._worker is not None and self._worker.running:
            return
        self._clear()
        self._say("Searching …")
        self._bar.visible, self._bar.value = True, 0.0
        self._cancel.disabled, self._go.disabled = False, True
        page = self._page
        self._started = dict(page.values)
        self._worker = worker = page.start(
            optimise, page.model, self._started, names, report=lambda message: self._told(worker, message)
        )

    def cancel(self) -> None:
        """End the search; its history stays."""
        if self._worker is not None and self._worker.running:
            self._end()
            self._say(f"Cancelled after {len(self._history)} designs.")

    def _told(self, worker: Worker, message: Any) -> None:
        if worker is not self._worker:
            return
        if isinstance(message, Step):
            self._history.append(message.candidate)
            self._bar.value = 100.0 * min(message.done / max(message.expected, 1), 1.0)
            self._say(f"{message.done} of about {message.expected} designs")
            self._add_row(len(self._history), message.candidate)
            self._draw()
        elif isinstance(message, Found):
            self._finish(message.best)
        elif isinstance(message, (Refused, Crashed)):
            self._say(message.message)
            self._end()

    def _finish(self, best: dict[str, float] | None) -> None:
        self._bar.value = 100.0
        self._end()
        if best is None:
            self._say(f"{len(self._history)} designs; none stood.")
            return
        words = ", ".join(f"{' '.join(named(path))} {value:g}" for path, value in best.items())
        self._say(f"{len(self._history)} designs. Best: {words}. It is on show.")
        self._page.set_values({**self._started, **best})

    def _add_row(self, number: int, candidate: Candidate) -> None:
        """Add a row: a button that puts the design on show."""
        gui, page = self._page.server.gui, self._page
        values = " / ".join(f"{value:g}" for value in candidate.parameters.values())
        volume = "" if candidate.volume is None else f", {candidate.volume:.2f} m³"
        word = candidate.dynamic or candidate.static
        with self._list:
            row = gui.add_button(
                f"{number}: {values} {word}{volume}", color=KINDS.get(candidate.dynamic, KINDS["pruned"]), order=-number
            )
        searched = {**self._started, **candidate.parameters}
        row.on_click(lambda _: page.post(lambda: page.set_values(searched)))
        self._rows.append(row)
        self._list.visible = True
        if len(self._rows) > MOST_ROWS:
            self._rows.pop(0).remove()

    def _draw(self) -> None:
        data = plotted(self._history)
        largest = float(max(column.max() for column in data[1:]))
        if self._plot is not None and largest <= self._top:
            self._plot.data = data
            return
        from viser import uplot

        if self._plot is not None:
            self._plot.remove()
        self._top = 1.15 * max(largest, 1e-9)
        series = []
        for kind, colour in KINDS.items():
            dots = uplot.Series_Points(show=True, size=8, fill=_css(colour))
            series.append(uplot.Series(label=kind, stroke=_css(colour), width=0, points=dots))
        scales = {"x": uplot.Scale(time=False), "y": uplot.Scale(auto=False, range=(0.0, self._top))}
        with self._chart:
            self._plot = self._page.server.gui.add_uplot(
                data, (uplot.Series(label="design"), *series), scales=scales, aspect=1.6,
                legend=uplot.Legend(live=False),
            )  # fmt: skip
        self._chart.visible = True

    def _clear(self) -> None:
        for part in (*self._rows, self._plot):
            if part is not None:
                part.remove()
        self._rows, self._plot, self._history = [], None, []
        self._chart.visible = self._list.visible = self._bar.visible = False

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.stop()
            self._worker = None
        self._cancel.disabled, self._go.disabled = True, not self._choices

    def _say(self, text: str) -> None:
        self._text.content = f'<div style="{MARGIN};{SMALL}">{escape(text)}</div>'


def plotted(history: list[Candidate]) -> tuple[np.ndarray, ...]:
    """Return what the plot of a history shows.

    Parameters
    ----------
    history : list of Candidate
        Designs in the order in which they were evaluated.

    Returns
    -------
    tuple of arrays of float, each of shape (n_designs + 2,)
        Number of each design, and its volume [m3] under its kind, far off the plot under the others. There is an empty
        place at either end, so that no dot lies on the frame.
    """
    volume = np.array([OFF, *(OFF if c.volume is None else c.volume for c in history), OFF])
    kinds = np.array(["", *(c.dynamic for c in history), ""])
    columns = (np.where(kinds == kind, volume, OFF) for kind in KINDS)
    return np.arange(len(volume), dtype=float), *columns


def _css(colour: tuple[int, int, int]) -> str:
    return "rgb({},{},{})".format(*colour)
