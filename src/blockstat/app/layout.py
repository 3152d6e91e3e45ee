"""Where everything is on the page: what is known on the left, what can be changed on the right."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Protocol

from blockstat.app.design import ALWAYS, FALLING, LEAST, NEVER, PUSHES, SUFFIXES, Model
from blockstat.app.files import REPORT, SAVES, SCENE, Saved, left_out, scene_file
from blockstat.app.words import NO_BLOCK, Known, small, waiting
from blockstat.errors import InputError
from blockstat.io.parts import UNITS, UP, own_up
from blockstat.view.three_d.colouring import CHOICES
from blockstat.view.three_d.dress import ON_NARROW, ON_WIDE, named

if TYPE_CHECKING:
    import viser

LEFT, RIGHT = 300, 330  #: widths [px]
MESHES = (".obj", ".glb")  #: files that do not say which blocks are supports, nor their units


class Host(Protocol):
    """What the layout asks of the page that it is part of.

    Attributes
    ----------
    model : Model
        The scene or the assembly on the page.
    values : dict of str to float
        Present values of its parameters, by dotted path.
    known : Known or None
        What is known of the design on show; None before the first verdict.
    """

    model: Model
    values: dict[str, float]
    known: Known | None

    def post(self, call: Callable[[], None]) -> None:
        """Run a call in the page's thread.

        Parameters
        ----------
        call : callable
            Takes no arguments.
        """
        ...

    def open(self, model: Model) -> None:
        """Show another model.

        Parameters
        ----------
        model : Model
            The scene or the assembly to show.
        """
        ...

    def upload(
        self, name: str, content: bytes, supports: str, units: str | None, up: str | None, gap: str | None
    ) -> None:
        """Show what is in a file that a browser sent.

        Parameters
        ----------
        name : str
            Name of the file; its suffix says the format.
        content : bytes
            What is in the file.
        supports : str
            Names of blocks that cannot move, separated by commas.
        units, up : str or None
            Of the coordinates in the file; None for what the file says.
        gap : str or None
            Largest gap of a joint, as a user types it; None for the default.
        """
        ...

    def report(self, deliver: Callable[[str, bytes], None]) -> None:
        """Make the report of the design on show.

        Parameters
        ----------
        deliver : callable
            Called with the name of the file and what is in it, once it is made.
        """
        ...

    def say(self, message: str) -> None:
        """Show what went wrong.

        Parameters
        ----------
        message : str
            Plain text; empty for nothing.
        """
        ...

    def repaint(self) -> None:
        """Draw the same design after a control of the picture was moved."""
        ...

    def animate(self) -> None:
        """Show the mechanism as its controls say."""
        ...

    def click(self, origin: Any, direction: Any) -> None:
        """Choose the block that a ray hits.

        Parameters
        ----------
        origin : sequence of float, shape (3,)
            Where the ray begins, in the coordinates of the page's scene [m].
        direction : sequence of float, shape (3,)
            Where the ray goes.
        """
        ...

    def choose(self, name: str) -> None:
        """Choose a block by its name.

        Parameters
        ----------
        name : str
            Of the block.
        """
        ...


class _Told:
    """A text that stands beside the picture on a wide screen, and above all controls on a narrow one."""

    def __init__(self, beside: viser.GuiHtmlHandle, above: viser.GuiHtmlHandle) -> None:
        self._beside, self._above = beside, above

    @property
    def content(self) -> str:
        """The text as HTML."""
        return self._content

    @content.setter
    def content(self, text: str) -> None:
        self._content = text
        self._beside.content = f'<div class="{ON_WIDE}">{text}</div>' if text else ""
        self._above.content = f'<div class="{ON_NARROW}">{text}</div>' if text else ""


class Layout:
    """The parts of the page that text is put into, and the controls that every model has.

    Parameters
    ----------
    server : viser.ViserServer
        Draws the page.
    page : Host
        The page that the layout is part of.
    """

    def __init__(self, server: viser.ViserServer, page: Host) -> None:
        self._page, gui = page, server.gui
        self._gui = gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0, 114, 178))
        above = [gui.add_html("") for _ in range(4)]
        left = gui.add_panel()
        self.results = left.add_tab("Verdict")
        with self.results:
            beside = [gui.add_html("") for _ in range(4)]
            self.title, self.headline, self.trouble, self._busy = map(_Told, beside, above)
            self.headline.content = waiting("Assessing …")
            self.numbers = gui.add_html("")
            with gui.add_folder("Colours"):
                self.legend = gui.add_html("")
            with gui.add_folder("Block"):
                self.chosen = gui.add_text("name", "", hint="of a block to look at; or click on it")
                self.block = gui.add_html(NO_BLOCK)
        self.chosen.on_update(lambda _: page.post(lambda: page.choose(self.chosen.value)))
        left.dock_left()
        left.set_width(LEFT)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT)
        self.tabs = gui.add_tab_group()
        self.design = self.tabs.add_tab("Design")
        with self.design:
            self.note = gui.add_html("")
        with self.tabs.add_tab("View"):
            self._view_controls(gui)
        with self.tabs.add_tab("File"):
            self._file_controls(gui)
        server.scene.on_click()(self._clicked)

    @property
    def push(self) -> str:
        """The direction of the limit load whose mechanism is shown, a key of `PUSHES` or `LEAST`."""
        return self._push.value

    def name(self, text: str) -> None:
        """Show the model's name over the verdict.

        Parameters
        ----------
        text : str
            The name.
        """
        self._gui.set_panel_label(text)
        self.title.content = named(text)

    def busy(self, text: str) -> None:
        """Show what the page is waiting for.

        Parameters
        ----------
        text : str
            Plain text; empty for nothing.
        """
        if text != getattr(self, "_said", ""):
            self._said = text
            self._busy.content = (
                f'<div style="margin:0 10px;color:#5c5f66;font-size:.85em">{escape(text)}</div>' if text else ""
            )

    def _view_controls(self, gui: viser.GuiApi) -> None:
        page = self._page
        self.colours = gui.add_dropdown("colours", CHOICES, hint="what the colours of the blocks stand for")
        self.forces = gui.add_checkbox("joint forces", False, hint="resultant of each joint at its centre of pressure")
        self.thrust = gui.add_checkbox("thrust", False, hint="what presses on the supports")
        for control in (self.colours, self.forces, self.thrust):
            control.on_update(lambda _: page.post(page.repaint))
        with gui.add_folder("Mechanism"):
            self.mechanism = gui.add_html("")
            self.amplitude = gui.add_slider(
                "amplitude", 0.0, 0.25, 0.005, 0.0, hint="way of the fastest corner, relative to the building's extent"
            )
            self.swing = gui.add_dropdown(
                "animate", (FALLING, ALWAYS, NEVER), hint="to and fro; what falls rests while arrows are shown"
            )
            self._push = gui.add_dropdown(
                "limit load", (LEAST, *PUSHES), hint="direction of the one whose mechanism is shown when nothing falls"
            )
        for control in (self.amplitude, self.swing, self._push):
            control.on_update(lambda _: page.post(page.animate))

    def _file_controls(self, gui: viser.GuiApi) -> None:
        page = self._page
        upload = gui.add_upload_button("Open …", hint=f"a file: {', '.join(SUFFIXES)}")

        @upload.on_upload
        def _(event: viser.GuiEvent) -> None:
            given = event.target.value
            if PurePath(given.name).suffix.lower() in MESHES:
                page.post(lambda: self.ask_supports(given.name, given.content))
            else:
                page.post(lambda: page.upload(given.name, given.content, "", None, None, None))

        present = gui.add_button(SCENE)
        present.on_click(lambda event: self._save(event, self._scene))
        report = gui.add_button(REPORT, hint="verdicts, limit loads, pictures and sources, as of blockstat report")
        report.on_click(lambda event: page.post(lambda: page.report(lambda *saved: _deliver(event, saved))))
        for label, make in SAVES.items():
            gui.add_button(label).on_click(lambda event, make=make: self._save(event, lambda: make(self._shown())))
        self._saving = gui.add_html("")

    def saving(self, text: str) -> None:
        """Say below the buttons what becomes of a file.

        Parameters
        ----------
        text : str
            Plain text; empty for nothing.
        """
        self._saving.content = small(escape(text))

    def ask_supports(
        self,
        name: str,
        content: bytes,
        why: str = "",
        *,
        units: str | None = None,
        up: str | None = None,
        gap: str | None = None,
    ) -> None:
        """Ask what a file of blocks does not say, and open it.

        Parameters
        ----------
        name : str
            Name of the file.
        content : bytes
            What is in it.
        why : str, optional
            What was missing, in plain text.
        units, up, gap : str, optional
            What was chosen before, as in `Page.upload`.
        """
        gui, page = self._gui, self._page
        dialogue = gui.add_modal(f"Open {name}")
        with dialogue:
            text = why or "A mesh does not say which blocks cannot move. Leave the names empty if this one does."
            gui.add_html(f'<div style="margin:0 10px .6em">{escape(text)}</div>')
            supports = gui.add_text("supports", "", hint="names of blocks that cannot move, or lowest")
            unit = gui.add_dropdown("units", tuple(UNITS), initial_value=units, hint="of the coordinates")
            first = up or own_up(PurePath(name).suffix)
            axis = gui.add_dropdown("up", UP, initial_value=first, hint="what points up; y in GLB, unless said")
            largest = gui.add_text(
                "gap", gap or "", hint='largest gap of a joint: a share of the block size, or "2 mm"; or nothing'
            )
            go, leave = gui.add_button("Open"), gui.add_button("Cancel", color="gray")

        def given() -> tuple[str, bytes, str, str, str, str | None]:
            return name, content, supports.value, unit.value, axis.value, largest.value.strip() or None

        @go.on_click
        def _(_: viser.GuiEvent) -> None:
            dialogue.close()
            page.post(lambda: page.upload(*given()))

        leave.on_click(lambda _: dialogue.close())

    def _scene(self) -> Saved:
        """The scene on the page, and a word below the buttons on what does not go into it."""
        page = self._page
        saved, unsaid = scene_file(page.model, page.values), left_out(page.model, page.values)
        page.post(lambda: self.saving(unsaid))
        return saved

    def _shown(self) -> Known:
        """What is known of the design on show, to be saved."""
        known = self._page.known
        if known is None:
            raise InputError("there is no verdict to save yet")
        if not known.is_scored and not known.stopped:
            raise InputError("how the blocks move first is not known yet; save again when it is told")
        return known

    def _save(self, event: Any, make: Callable[[], Saved]) -> None:
        """Make a file and hand it to the page that asked for it."""
        page = self._page
        try:
            name, content = make()
        except InputError as error:
            text = str(error)
            page.post(lambda: page.say(text))
            return
        _deliver(event, (name, content))

    def _clicked(self, event: Any) -> None:
        page, origin, direction = self._page, event.ray_origin, event.ray_direction
        page.post(lambda: page.click(origin, direction))


def _deliver(event: Any, saved: Saved) -> None:
    """Hand a file to the browser that asked for it, if it is still there."""
    if event.client is not None:
        event.client.send_file_download(*saved, save_immediately=True)
