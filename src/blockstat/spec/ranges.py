"""Numbers that a search may move."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

import msgspec
import numpy as np

#: A range with more values than this is a slip of the pen.
MOST_STEPS = 10_000


class Range(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A parameter that may move: its present value, its bounds (both included) and its step."""

    value: float  #: now
    min: float  #: smallest
    max: float  #: largest
    step: Annotated[float, msgspec.Meta(gt=0)]  #: between the values that a search tries

    def __post_init__(self) -> None:
        if not np.isfinite([self.value, self.min, self.max, self.step]).all():
            raise ValueError("value, min, max and step must be finite")
        if (self.max - self.min) / self.step > MOST_STEPS:
            raise ValueError(f"a step of {self.step:g} makes more than {MOST_STEPS} values")
        if not self.min <= self.value <= self.max:
            raise ValueError(f"value {self.value:.12g} must lie between min {self.min:.12g} and max {self.max:.12g}")

    def steps(self) -> list[float]:
        """Values from the largest down to the smallest.

        Returns
        -------
        list of float
            The smallest is always among them.
        """
        count = int(np.floor((self.max - self.min) / self.step + 1e-9))
        values = [min(max(round(self.max - i * self.step, 12), self.min), self.max) for i in range(count + 1)]
        if values[-1] > self.min + 1e-9 * self.step:
            values.append(self.min)
        return [value + 0.0 for value in values]  # of the two zeros the one without a sign


Length = Annotated[float, msgspec.Meta(gt=0)] | Range
Height = Annotated[float, msgspec.Meta(ge=0)] | Range
Count = Annotated[int, msgspec.Meta(ge=0)] | Range
#: Whether an element is there. "search" stands for a range of 1 (there, as it is built) and 0 (not there).
Presence = bool | Literal["search"] | Range
SEARCHED = {"value": 1, "min": 0, "max": 1, "step": 1}

PRESENCE = (
    r"(elements\.[^.]+(\.runs\..+|\.(openings|buttresses)\.\d+)?|(doors|windows|buttresses)\.[^.]+|vault)\.present"
)


def value_of(parameter: float | Range) -> float:
    """The number a parameter stands for now.

    Parameters
    ----------
    parameter : float or Range
        As a scene has it.

    Returns
    -------
    float
        The value of a range, or the number itself.
    """
    return parameter.value if isinstance(parameter, Range) else parameter


def is_present(presence: Presence) -> bool:
    """Whether an element is there now.

    Parameters
    ----------
    presence : bool or Range
        As a scene has it.

    Returns
    -------
    bool
        True where the element is built.
    """
    return bool(presence.value) if isinstance(presence, Range) else bool(presence)


def is_range(node: Any) -> bool:
    """Whether plain data say a range.

    Parameters
    ----------
    node : object
        A value of a scene.

    Returns
    -------
    bool
        True for a table of value, min, max and step.
    """
    return meant_as_range(node) and set(node) == set(SEARCHED)


def meant_as_range(node: Any) -> bool:
    """Whether plain data say a range, or nearly: one whose keys are to be told what is wrong with them.

    Parameters
    ----------
    node : object
        A value of a scene.

    Returns
    -------
    bool
        True for a table with a value, or with two of the keys of a range, none of them a table: a table of tables has
        names that a user chose.
    """
    if not isinstance(node, dict) or any(isinstance(child, (dict, list, tuple)) for child in node.values()):
        return False
    return "value" in node or len(set(SEARCHED) & set(node)) > 1


def is_presence(path: str) -> bool:
    """Whether a key says that something is there; others may be named "present" by the user.

    Parameters
    ----------
    path : str
        Of the key, with dots.

    Returns
    -------
    bool
        True for those of elements, runs, openings, buttresses and the vault of the short form.
    """
    return re.fullmatch(PRESENCE, path) is not None
