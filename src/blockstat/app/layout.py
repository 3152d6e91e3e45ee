"""Where everything is on the page: what is known on the left, what can be changed on the right."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any, Protocol

from blockstat.app.design import PUSHES, SUFFIXES, Model
from blockstat.app.files import SAVES
from blockstat.app.words import NO_BLOCK, Known, waiting
from blockstat.errors import InputError
from blockstat.view.three_d.colouring import CHOICES

if TYPE_CHECKING:
    import viser

LEFT, RIGHT = 300, 330  #: widths [px]


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

    def upload(self, name: str, content: bytes, supports: str) -> None:
        """Show what is in a file that a browser sent.

        Parameters
        ----------
        name : str
            Name of the file; its suffix says the format.
        content : bytes
            What is in the file.
        supports : str
            Names of blocks that cannot move, separated by commas.
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

    def push_changed(self) -> None:
        """Ask for the limit load in another direction."""
        ...


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
        left = gui.add_panel()
        with left.add_tab("Verdict"):
            self.title = gui.add_html("")
            self.headline = gui.add_html(waiting("Assessing …"))
            self.trouble = gui.add_html("")
            self._busy = gui.add_html("")
            self.numbers = gui.add_html("")
            with gui.add_folder("Colours"):
                self.legend = gui.add_html("")
            with gui.add_folder("Block"):
                self.block = gui.add_html(NO_BLOCK)
        left.dock_left()
        left.set_width(LEFT)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT)
        self.tabs = gui.add_tab_group()
        self.design = self.tabs.add_tab("Design")
        with self.tabs.add_tab("View"):
            self._view_controls(gui)
        with self.tabs.add_tab("File"):
            self._file_controls(gui)
        server.scene.on_click()(self._clicked)

    @property
    def push(self) -> str:
        """The direction of the limit load, a key of `PUSHES`."""
        return self._push.value

    def name(self, text: str) -> None:
        """Show the model's name over the verdict.

        Parameters
        ----------
        text : str
            The name.
        """
        self._gui.set_panel_label(text)
        self.title.content = f'<div style="margin:.3em 10px 0;color:#666">{escape(text)}</div>'

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
                f'<div style="margin:0 10px;color:#666;font-size:.85em">{escape(text)}</div>' if text else ""
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
            self.swing = gui.add_checkbox("animate", False, hint="to and fro")
        for control in (self.amplitude, self.swing):
            control.on_update(lambda _: page.post(page.animate))
        self._push = gui.add_dropdown("limit load along", tuple(PUSHES), initial_value="+y")
        self._push.on_update(lambda _: page.post(page.push_changed))

    def _file_controls(self, gui: viser.GuiApi) -> None:
        page = self._page
        supports = gui.add_text("supports", "", hint="blocks of a mesh that cannot move, separated by commas")
        upload = gui.add_upload_button("Open …", hint=f"a file: {', '.join(SUFFIXES)}")

        @upload.on_upload
        def _(event: viser.GuiEvent) -> None:
            given = event.target.value
            page.post(lambda: page.upload(given.name, given.content, supports.value))

        for label, make in SAVES.items():
            gui.add_button(label).on_click(lambda event, make=make: self._save(event, make))

    def _save(self, event: Any, make: Any) -> None:
        """Make a file and hand it to the page that asked for it."""
        page = self._page
        try:
            if page.known is None:
                raise InputError("there is no verdict to save yet")
            name, content = make(page.model, page.values, page.known)
        except InputError as error:
            text = str(error)
            page.post(lambda: page.say(text))
            return
        if event.client is not None:
            event.client.send_file_download(name, content, save_immediately=True)

    def _clicked(self, event: Any) -> None:
        page, origin, direction = self._page, event.ray_origin, event.ray_direction
        page.post(lambda: page.click(origin, direction))
