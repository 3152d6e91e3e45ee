"""What all elements of a composition have in common: where they are put, and how often."""

from __future__ import annotations

import msgspec

from blockstat.model.quantities import Count, Ends, Length, Point


class Repeat(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Copies in a row or round a vertical axis: copy k is turned by k x turn about a point, and moved by k x by."""

    number: Count  #: of copies, the first included
    by: Point = (0.0, 0.0, 0.0)  #: step from one to the next [m]
    turn: float = 0.0  #: from one to the next, counter-clockwise seen from above [degrees]
    about: Ends = (0.0, 0.0)  #: x and y of the axis of turning [m]


class Element(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True, tag_field="kind"):
    """Keys that every element has."""

    present: bool = True  #: true, false or "search"; an element that is not there makes no block
    at: Point = (0.0, 0.0, 0.0)  #: where the element's origin goes: x, y, z [m]
    turn: float = 0.0  #: about the vertical through its origin, counter-clockwise seen from above [degrees]
    repeat: Repeat | tuple[Repeat, ...] = ()  #: copies; of several, each repeats what the one before made
    density: Length | None = None  #: [kg/m3], by default that of the file or the material's
    prefix: str | None = None  #: of the names and groups of its blocks, by default the element's name; "" for none


def repeats_of(element: Element) -> tuple[Repeat, ...]:
    """The repetitions of an element, none or several.

    Parameters
    ----------
    element : Element
        Any.

    Returns
    -------
    tuple of Repeat
        In the order in which they multiply.
    """
    return (element.repeat,) if isinstance(element.repeat, Repeat) else element.repeat
