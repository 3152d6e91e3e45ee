"""One slider or checkbox for each parameter, made from its bounds."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from blockstat.app.words import TROUBLE

if TYPE_CHECKING:
    import viser

    from blockstat.spec import Range

#: Units by the last name of a path; all others are lengths.
UNITS = {
    "density": "kg/m³", "rounded_edges": "mm", **dict.fromkeys(("skew", "start", "end", "turn"), "°"),
    **dict.fromkeys(("friction", "present", "number", "courses", "voussoirs", "rings", "leaves", "segment"), ""),
}  # fmt: skip
LENGTH = "m"


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


def outside(path: str, value: float, found: Range, used: float) -> str:
    """Return that a number lies outside its range, and what is used instead.

    Parameters
    ----------
    path : str
        Dotted path of the parameter.
    value : float
        The number that was typed.
    found : Range
        Its bounds.
    used : float
        The value of the design on show.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> from blockstat.app.controls import outside
    >>> from blockstat.spec import Range
    >>> print(outside("wall.thickness", 5.0, Range(0.6, 0.3, 0.8, 0.1), 0.6).partition(">")[2])
    wall.thickness: 5 m is outside 0.3 to 0.8 m; 0.6 m is used</div>
    """
    unit = _unit(path)
    words = f"{path}: {value:g}{unit} is outside {found.min:g} to {found.max:g}{unit}; {used:g}{unit} is used"
    box = f"{TROUBLE};margin:0 10px .6em;font-size:.85em"
    return f'<div role="alert" style="{box}">{escape(words)}</div>'


def _unit(path: str) -> str:
    """The unit of a parameter with a space before it, empty for a pure number."""
    unit = UNITS.get(path.rpartition(".")[2], LENGTH)
    return f" {unit}" if unit not in ("", "°") else unit


def _control(gui: viser.GuiApi, label: str, path: str, found: Range) -> Any:
    unit = _unit(path)
    hint = f"{path}, {found.min:g} to {found.max:g}{unit}"
    label = f"{label} [{unit.strip()}]" if unit else label
    if (found.min, found.max, found.step) == (0, 1, 1):
        return gui.add_checkbox(label, bool(found.value), hint=hint)
    whole = all(float(value).is_integer() for value in (found.min, found.max, found.step, found.value))
    kind = int if whole else float
    low, high, value = kind(found.min), kind(found.max), kind(found.value)
    return gui.add_slider(label, low, high, kind(min(found.step, found.max - found.min)), value, hint=hint)
