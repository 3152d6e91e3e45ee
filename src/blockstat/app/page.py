"""The page: one thread owns everything that is drawn, and runs what is posted to it, one call after another."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic, process_time
from typing import TYPE_CHECKING, Any, Protocol

from blockstat.app.background import Crashed, Ended, Limits, Refused, Worker
from blockstat.app.controls import Controls, refused, taken
from blockstat.app.design import Failed, Judged, Model, Pushed, Scored, Slipped, Stopped
from blockstat.app.files import send_report, send_upload
from blockstat.app.follow import Follower
from blockstat.app.layout import Layout
from blockstat.app.view import View
from blockstat.app.words import Known, headline, numbers, refusal, trouble, waiting
from blockstat.errors import InputError, NoSupportError
from blockstat.result import Result
from blockstat.typing import Floats
from blockstat.view.three_d.canvas import Canvas
from blockstat.view.three_d.player import Player

if TYPE_CHECKING:
    import viser

LOG = logging.getLogger("blockstat.app")
#: The thread looks after its workers and films this often when nothing is posted [s].
BEAT, FILM_BEAT = 0.1, 0.02
#: A number that is not taken as it is, is told when it has stood for so long; until then it may be half typed [s].
TYPING = 0.8
#: A verdict that takes longer than this is announced [s].
SLOW = 0.7
LAST_GOOD = " (the picture shows the last design that could be judged)"


class Panel(Protocol):
    """What another package adds to the page; all is called in the page's thread."""

    def attach(self, page: Page) -> None:
        """Add controls, to tabs of its own.

        Parameters
        ----------
        page : Page
            The live page.
        """
        ...

    def opened(self) -> None:
        """Forget what is known of the model before; another one was opened."""
        ...

    def judged(self, known: Known) -> None:
        """Take in the design that is now on show.

        Parameters
        ----------
        known : Known
            What is known of it, with its static verdict.
        """
        ...


class Page:
    """A model, its values, what is known of the design on show, and the parts that show it.

    Methods are called in the page's thread; from elsewhere through `post`.

    Parameters
    ----------
    server : viser.ViserServer
        Draws the page.
    model : Model
        The scene or the assembly to show first.
    panels : sequence of Panel, optional
        What other packages add to the page.
    folder : Path, optional
        Where the files are that an uploaded scene may name.
    limits : Limits, optional
        What work for the page may use before it is stopped.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        model: Model,
        *,
        panels: Sequence[Panel] = (),
        folder: Path | None = None,
        limits: Limits | None = None,
    ) -> None:
        self.server, self.model = server, model
        self.values: dict[str, float] = {}
        self.known: Known | None = None
        self._calls: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._asked_at = 0.0
        self._asked: dict[int, dict[str, float]] = {}  # values of the open questions about this model, by number
        self._refused: tuple[str, float, float] | None = None  # a number not taken as it is: path, value and when
        self._fresh = True  # the next design is the first of its model
        self._workers: list[Worker] = []
        self._folder, self._limits = folder, limits or Limits()
        self._reader: Worker | None = None
        self._reporter: Worker | None = None
        self.follower = Follower(self.post, self._told, limits=self._limits)
        self.layout = Layout(server, self)
        self.view = View(Canvas(server), self.layout)
        self.player = Player(self.view.pose)
        self.controls: Controls | None = None
        self._panels = list(panels)
        for panel in self._panels:
            panel.attach(self)
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)
        self.post(lambda: self.open(model))
        self._thread.start()

    @property
    def tabs(self) -> viser.GuiTabGroupHandle:
        """Where panels add their tabs."""
        return self.layout.tabs

    def post(self, call: Callable[[], None]) -> None:
        """Run a call in the page's thread, soon; from any thread.

        Parameters
        ----------
        call : callable
            Takes no arguments.
        """
        self._calls.put(call)

    def close(self) -> None:
        """Finish what was posted and end the workers and the thread."""
        self._calls.put(None)
        self._thread.join(timeout=10)

    def open(self, model: Model) -> None:
        """Show another model in place of the present one.

        Parameters
        ----------
        model : Model
            The scene or the assembly to show.
        """
        self.model, self.values, self._fresh = model, model.start, True
        self._forget()
        self.layout.name(model.name)
        self._refused, self.layout.note.content = None, ""
        self.layout.saving("")
        if self.controls is not None:
            self.controls.remove()
        with self.layout.design:
            self.controls = Controls(self.server.gui, model.ranges, lambda path: self.post(lambda: self._moved(path)))
        for panel in self._panels:
            panel.opened()
        self.ask()

    def _forget(self) -> None:
        """Take away all that is known of the model before; answers about it that are on their way are ignored."""
        self.known, self._asked = None, {}
        self.stop_film()
        self.view.forget()
        self.layout.headline.content, self.layout.numbers.content = waiting("Assessing …"), ""
        self.say("")

    def upload(
        self, name: str, content: bytes, supports: str, units: str | None, up: str | None, gap: str | None
    ) -> None:
        """Read a file that a browser sent, in a process of its own, and show it.

        Parameters
        ----------
        name : str
            Name of the file; its suffix says the format.
        content : bytes
            What is in the file.
        supports : str
            Names of blocks that cannot move, separated by commas; a mesh needs them.
        units, up : str or None
            Of the coordinates in the file; None for what the file says.
        gap : str or None
            Largest gap of a joint, as a user types it; None for the default.
        """
        if self._reader is not None:
            self._reader.stop()
        reading = (send_upload, name, content, supports, units, up, gap, self._folder)
        chosen = {"units": units, "up": up, "gap": gap}
        self._reader = self.start(*reading, report=lambda found: self._read(name, content, chosen, found), timed=True)

    def _read(self, name: str, content: bytes, chosen: dict[str, str | None], found: Any) -> None:
        if isinstance(found, Model):
            self.open(found)
        elif isinstance(found, NoSupportError):
            self.layout.ask_supports(name, content, str(found), **chosen)
        elif isinstance(found, InputError):
            self._refuse(str(found))
        elif isinstance(found, Crashed):
            self._refuse(f"{name}: cannot be read here: {found.message}")

    def _refuse(self, message: str) -> None:
        """Say why a file was not opened, where the verdict stands until the next one."""
        self.say("")
        self.layout.headline.content = refusal(message, self.known, self.model.name)

    def change(self, path: str, value: float) -> None:
        """Move one parameter; a value that it has already asks for nothing.

        Parameters
        ----------
        path : str
            Dotted path of the parameter. A path that the model does not have is ignored.
        value : float
            New value, in the unit of the parameter.
        """
        if path in self.values and self.values[path] != value:
            self.values = {**self.values, path: value}
            self.ask()

    def _moved(self, path: str) -> None:
        value = self.controls.value(path) if self.controls is not None else None
        if value is None:
            return
        limits, told = self.model.ranges[path], self._refused
        between = told is not None and told[0] == path and limits.min <= told[1] <= limits.max
        if between and value == self.values[path]:
            return  # the box now has the value that the note says is used
        inside = limits.min <= value <= limits.max
        used = taken(value, limits) if inside and value != self.values[path] else value
        if inside and used == value:
            # A browser puts a number outside its range to the bound when the box is left; the note stays.
            if told is None or told[0] != path or value not in (limits.min, limits.max):
                self._refused, self.layout.note.content = None, ""
        elif told is None or told[:2] != (path, value):
            self._refused = path, value, monotonic()
        if inside:
            self.change(path, used)

    def _tell_refused(self) -> None:
        """Say that a number is not taken as it is, once it is clear that no further digit follows."""
        if self._refused is None or monotonic() - self._refused[2] < TYPING:
            return
        path, value, _ = self._refused
        limits, used = self.model.ranges[path], self.values[path]
        text = refused(path, value, limits, used)
        if self.layout.note.content != text:
            self.layout.note.content = text
            if self.controls is not None and limits.min <= value <= limits.max:
                self.controls.set({path: used})

    def set_values(self, values: dict[str, float]) -> None:
        """Move several parameters at once, the controls with them.

        Parameters
        ----------
        values : dict of str to float
            New values by dotted path. Paths that the model does not have are ignored.
        """
        found = {path: value for path, value in values.items() if path in self.values}
        if self.controls is not None:
            self.controls.set(found)
        if any(self.values[path] != value for path, value in found.items()):
            self.values = {**self.values, **found}
            self.ask()

    def ask(self) -> None:
        """Ask for the verdict on the present values; a mechanism in motion waits for it where it is."""
        self._asked_at = monotonic()
        if self.view.moved is None:
            self.player.stop()
        self._asked[self.follower.ask(self.model, self.values)] = self.values

    def repaint(self) -> None:
        """Draw the same design after a control of the picture was moved."""
        self.view.again()
        self.animate()

    def animate(self) -> None:
        """Show the mechanism as its controls say."""
        self.view.animate(self.player)

    def click(self, origin: Any, direction: Any) -> None:
        """Choose the block that a ray hits.

        Parameters
        ----------
        origin : sequence of float, shape (3,)
            Where the ray begins, in the coordinates of the page's scene [m].
        direction : sequence of float, shape (3,)
            Where the ray goes.
        """
        self.view.click(origin, direction)

    def choose(self, name: str) -> None:
        """Choose a block by its name.

        Parameters
        ----------
        name : str
            Of the block; one that is not there leaves none chosen.
        """
        self.view.choose(name)

    def report(self, deliver: Callable[[str, bytes], None]) -> None:
        """Make the report of the design on show in a process of its own; a newer one ends that of before.

        Parameters
        ----------
        deliver : callable
            Called with the name of the file and what is in it, once it is made.
        """
        if self.known is None:
            self.say("there is no verdict to save yet")
            return
        if self._reporter is not None:
            self._reporter.stop()

        def told(message: Any) -> None:
            if isinstance(message, tuple):
                deliver(*message)
            said = f"no report: {message.message}" if isinstance(message, Crashed) else ""
            if not isinstance(message, Ended) or said:
                self.layout.saving(message.message if isinstance(message, Refused) else said)

        self.layout.saving("The report of the design on show is being made; the file comes when it is ready …")
        self._reporter = self.start(send_report, self.known, report=told, timed=True)

    def simulated(self, verdict: Result) -> None:
        """Take in what a simulation says of the design on show, for its report.

        Parameters
        ----------
        verdict : Result
            The verdict of the simulation.
        """
        if self.known is not None:
            self.known = replace(self.known, simulated=verdict)

    def say(self, message: str) -> None:
        """Show what went wrong.

        Parameters
        ----------
        message : str
            Plain text; empty for nothing.
        """
        self.layout.trouble.content = trouble(message)

    def start(
        self, work: Callable[..., None], *arguments: Any, report: Callable[[Any], None], timed: bool = False
    ) -> Worker:
        """Run a function of a channel in another process.

        Parameters
        ----------
        work : callable
            A function of a module. It is called in the process as ``work(channel, *arguments)``.
        *arguments : object
            Further arguments of `work`; they can be pickled.
        report : callable
            Called with each message of the worker, and at last with an `Ended`, in the page's thread.
        timed : bool, optional
            Whether it is stopped when it has said nothing for as long as the limits of the page allow.

        Returns
        -------
        Worker
            It is stopped when the page closes.
        """
        worker = Worker(
            work,
            *arguments,
            report=lambda _, message: self.post(lambda: self._reported(message, report)),
            limits=self._limits,
            timed=timed,
        )
        self._workers = [*(known for known in self._workers if known.running), worker]
        return worker

    def _reported(self, message: Any, report: Callable[[Any], None]) -> None:
        if isinstance(message, Ended):  # what a worker that is gone was given is kept no longer
            self._workers = [worker for worker in self._workers if worker.running]
        report(message)

    def play(self, film: Callable[[float], Floats], seconds: float) -> None:
        """Show the blocks in motion.

        Parameters
        ----------
        film : callable
            Returns the vertices, shape (n_vertices, 3) [m], at a time since the film began [s].
        seconds : float
            Length of the film [s].
        """
        self.player.play(film, seconds)

    def stop_film(self) -> None:
        """Stop what moves; the next drawing shows the blocks where they are built."""
        self.player.stop()
        self.view.moved, self.view.followed = None, False

    def _told(self, message: Any) -> None:
        if not isinstance(message, (Judged, Failed)):
            if self.known is not None:
                self._learn(message)
            return
        values = self._asked.get(message.number)
        self._asked = {number: asked for number, asked in self._asked.items() if number > message.number}
        if values is None:
            return  # about a model that was open before
        if isinstance(message, Judged):
            self._show(message, values)
            return
        if message.is_internal:
            LOG.error(message.message)
        self.say(message.message + (LAST_GOOD if self.known is not None else ""))
        if self.known is None:
            self.layout.headline.content = waiting("No verdict")

    def _show(self, judged: Judged, values: dict[str, float]) -> None:
        """A new verdict: its words first, then the picture, then what the picture cost."""
        begin = process_time()
        self.known = known = Known(judged.verdict, judged.seconds, values=values)
        self.layout.headline.content = headline(known)
        self.layout.busy("")  # a busy browser shows what comes after the picture much later
        self.say("")
        self.server.flush()
        if self.view.moved is not None:
            self.stop_film()
        if self._fresh:
            self.view.canvas.recentre(judged.verdict.assembly)
            self._fresh = False
        self.view.show(known)
        self.animate()
        self.known = replace(known, seconds={**known.seconds, "draw": process_time() - begin})
        self.layout.numbers.content = numbers(self.known)
        for panel in self._panels:
            panel.judged(self.known)

    def _learn(self, message: Any) -> None:
        """One of the slower results of the design on show."""
        assert self.known is not None
        if isinstance(message, Scored):
            self.known = replace(self.known, verdict=message.verdict)
            self._show_motion(self.known)
        elif isinstance(message, Pushed):
            self.known = replace(self.known, pushed={**self.known.pushed, message.push: message})
            self.view.learned(self.known, self.player)
        elif isinstance(message, Slipped):
            self.known = replace(self.known, slipped=message)
        elif isinstance(message, Stopped):
            scored, self.known = self.known.is_scored, replace(self.known, stopped=True)
            if not scored:
                self._show_motion(self.known)
            self.say(message.message)
        self.layout.numbers.content = numbers(self.known)

    def _show_motion(self, known: Known) -> None:
        """The words and the picture of how the blocks move first, which come after the verdict."""
        self.layout.headline.content = headline(known)
        self.view.show(known)
        self.animate()

    def _run(self) -> None:
        while True:
            try:
                call = self._calls.get(timeout=FILM_BEAT if self.player.playing else BEAT)
            except queue.Empty:
                call = self._tick
            if call is None:
                break
            try:
                call()
                self._tick()
            except Exception as error:
                LOG.exception("the page failed")
                self.say(f"internal error ({type(error).__name__}: {error})")
        for worker in self._workers:
            worker.stop()
        self.follower.stop()

    def _tick(self) -> None:
        self.follower.tick()
        self.player.tick()
        self._tell_refused()
        late = monotonic() - self._asked_at if self.follower.pending else 0.0
        self.layout.busy(f"judging the newest change, {late:.0f} s" if late > SLOW else "")
