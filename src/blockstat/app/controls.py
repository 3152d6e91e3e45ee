"""One slider or checkbox for each parameter, made from its bounds."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from blockstat.app.words import TROUBLE

if TYPE_CHECKING:
    import viser

    from blockstat.spec import Range

#: Units by the last name of a path; all others are lengths, but those that a scene names itself: they may be anything.
UNITS = {
    "density": "kg/m³", "rounded_edges": "mm", **dict.fromkeys(("skew", "start", "end", "turn"), "°"),
    **dict.fromkeys(("friction", "present", "number", "courses", "voussoirs", "rings", "leaves", "segment"), ""),
}  # fmt: skip
LENGTH = "m"
NAMED_BY_SCENE = "parameters."  #: how the paths of those begin
#: Decimals that a box takes: a number between two steps reaches the page, which says what it takes instead.
DECIMALS = 9


class Controls:
    """The sliders and checkboxes of a model in a part of the page.

    Parameters
    ----------
    gui : viser.GuiApi
        Where the controls are added.
    ranges : dict of str to Range
        Bounds, step and value of each parameter, by dotted path. A parameter that cannot move gets no control.
    changed : callable
        Called with the path of a control that was moved, from any thread and in any order. `value` says where the
        control stands by then.
    """

    def __init__(self, gui: viser.GuiApi, ranges: dict[str, Range], changed: Callable[[str], None]) -> None:
        self._handles: dict[str, Any] = {}
        self._folders: dict[str, Any] = {}
        for path, found in ranges.items():
            if found.max <= found.min:
                continue
            folder, label = named(path)
            if folder not in self._folders:
                self._folders[folder] = gui.add_folder(folder)
            with self._folders[folder]:
                handle = self._handles[path] = _control(gui, label, path, found)
            handle.on_update(lambda _, path=path: changed(path))
        self._note = None if self._handles else gui.add_html("<div>This model has no parameters to move.</div>")

    def value(self, path: str) -> float | None:
        """Return where a control stands now.

        Parameters
        ----------
        path : str
            Dotted path of the parameter.

        Returns
        -------
        float or None
            In the unit of the parameter; None if there is no such control.
        """
        handle = self._handles.get(path)
        return None if handle is None else round(float(handle.value), 9)

    def set(self, values: dict[str, float]) -> None:
        """Put the controls to some values.

        Parameters
        ----------
        values : dict of str to float
            New values by dotted path. Paths without a control are ignored.
        """
        for path, value in values.items():
            handle = self._handles.get(path)
            if handle is not None and float(handle.value) != value:
                handle.value = type(handle.value)(value)

    def remove(self) -> None:
        """Take all controls off the page."""
        for part in (*self._folders.values(), self._note):
            if part is not None:
                part.remove()


def named(path: str) -> tuple[str, str]:
    """Return the heading and the label of a parameter.

    Parameters
    ----------
    path : str
        Dotted path of the parameter.

    Returns
    -------
    heading : str
        What the parameter belongs to; "material" for a path without a dot.
    label : str
        Its own name.

    Examples
    --------
    >>> from blockstat.app.controls import named
    >>> named("buttresses.south.number")
    ('buttresses south', 'number')
    """
    *parents, label = path.split(".")
    return " ".join(parents) or "material", label.replace("_", " ")


def taken(value: float, found: Range) -> float:
    """Return the value of a slider that is nearest to a number within its range.

    Parameters
    ----------
    value : float
        The number that was typed.
    found : Range
        Bounds and step.

    Returns
    -------
    float
        A whole number of steps from the lower bound, or the upper bound.

    Examples
    --------
    >>> from blockstat.app.controls import taken
    >>> from blockstat.spec import Range
    >>> [taken(value, Range(0.6, 0.3, 0.8, 0.1)) for value in (0.449, 0.56, 0.8)]
    [0.4, 0.6, 0.8]
    """
    steps = round((value - found.min) / found.step)
    return round(min(found.min + steps * found.step, found.max), DECIMALS)


def refused(path: str, value: float, found: Range, used: float) -> str:
    """Return why a number is not taken as it was typed, and what is used instead.

    Parameters
    ----------
    path : str
        Dotted path of the parameter.
    value : float
        The number that was typed.
    found : Range
        Its bounds and step.
    used : float
        The value of the design on show.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> from blockstat.app.controls import refused
    >>> from blockstat.spec import Range
    >>> thickness = Range(0.6, 0.3, 0.8, 0.1)
    >>> print(refused("wall.thickness", 5.0, thickness, 0.6).partition(">")[2])
    wall.thickness: 5 m is outside 0.3 to 0.8 m; 0.6 m is used</div>
    >>> print(refused("wall.thickness", 0.449, thickness, 0.4).partition(">")[2])
    wall.thickness: 0.449 m is between steps of 0.1 m from 0.3 m; 0.4 m is used</div>
    """
    unit = _unit(path)
    why = f"is outside {found.min:g} to {found.max:g}{unit}"
    if found.min <= value <= found.max:
        why = f"is between steps of {found.step:g}{unit} from {found.min:g}{unit}"
    words = f"{path}: {value:.9g}{unit} {why}; {used:g}{unit} is used"
    box = f"{TROUBLE};margin:0 10px .6em;font-size:.85em"
    return f'<div role="alert" style="{box}">{escape(words)}</div>'


def _unit(path: str) -> str:
    """The unit of a parameter with a space before it, empty for a pure number."""
    unit = "" if path.startswith(NAMED_BY_SCENE) else UNITS.get(path.rpartition(".")[2], LENGTH)
    return f" {unit}" if unit not in ("", "°") else unit


def _control(gui: viser.GuiApi, label: str, path: str, found: Range) -> Any:
    unit = _unit(path)
    hint = f"{path}, {found.min:g} to {found.max:g}{unit}"
    label = f"{label} [{unit.strip()}]" if unit else label
    if (found.min, found.max, found.step) == (0, 1, 1):
        return gui.add_checkbox(label, bool(found.value), hint=hint)
    step = min(found.step, found.max - found.min)
    slider = gui.add_slider(label, float(found.min), float(found.max), float(step), float(found.value), hint=hint)
    slider.precision = DECIMALS
    return slider
