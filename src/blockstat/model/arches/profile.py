"""Profiles of arches and vaults: the intrados from springing to crown, and the joints that cut it into voussoirs.

A profile is symmetric; its right half is described here, the springing at z = 0 and the crown at x = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from blockstat.errors import InputError, check_choice, check_count, is_number, with_article
from blockstat.typing import Floats

Shape = Literal["semicircular", "segmental", "horseshoe", "pointed", "elliptic"]
SHAPES = ("semicircular", "segmental", "horseshoe", "pointed", "elliptic")
JOINTS = ("radial", "vertical")


@dataclass(frozen=True)
class Profile:
    """Half an intrados and its joints, over s from 0 (springing) to 1 (crown) in equal lengths of the intrados."""

    curve: Callable[[Floats], Floats]  #: s to points x, z of the intrados, shape (n, 2) [m]
    normal: Callable[[Floats], Floats]  #: s to unit normals out of the arch, shape (n, 2)
    extrados: Callable[[Floats, float], Floats]  #: x and thickness to the height of the extrados there [m]
    length: float  #: of the half intrados [m]
    crown_joint: bool = False  #: whether the crown is an edge, which needs a joint there

    def joints(self, s: Floats, thickness: float, kind: str = "radial") -> Floats:
        """The joints at places of the intrados.

        Vertical joints cut the same extrados; the bed at the springing stays normal to the intrados, and a joint at the
        crown is vertical in either case.

        Parameters
        ----------
        s : ndarray
            Places from 0 (springing) to 1 (crown), shape (n,).
        thickness : float
            Normal to the intrados [m].
        kind : str
            "radial" or "vertical".

        Returns
        -------
        ndarray
            Points x, z on the intrados and on the extrados, shape (n, 2, 2) [m].

        Raises
        ------
        InputError
            For another kind.
        """
        check_choice("joints", kind, JOINTS)
        inner = self.curve(s)
        outer = inner + thickness * self.normal(s)
        upright = (s > 0) if kind == "vertical" else (s == 1)
        inner[s == 1, 0] = 0.0
        outer[upright, 0] = inner[upright, 0]
        outer[upright, 1] = self.extrados(inner[upright, 0], thickness)
        return np.stack([inner, outer], axis=1)

    def where(self, x: float) -> float:
        """The place s at which the intrados is at a distance from the axis, above its widest place.

        Parameters
        ----------
        x : float
            Distance from the axis [m].

        Returns
        -------
        float
            s, from 0 (springing) to 1 (crown).
        """
        low, high = float(self.curve(np.linspace(0, 1, 257))[:, 0].argmax()) / 256, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if self.curve(np.array([middle]))[0, 0] > x else (low, middle)
        return (low + high) / 2


def profile(shape: str, span: float, rise: float | None = None) -> Profile:
    """The profile of a clear span and rise at the intrados.

    Semicircular: the rise is span / 2. Segmental: an arc of less than half a circle. Horseshoe: an arc of more, with
    the span at the springing. Pointed: two arcs with centres on the springing line. Elliptic: half an ellipse.

    Parameters
    ----------
    shape : str
        One of `SHAPES`.
    span : float
        Clear, at the springing [m].
    rise : float, optional
        At the crown [m]; a semicircular profile needs none.

    Returns
    -------
    Profile
        The right half of the intrados.

    Raises
    ------
    InputError
        For an unknown shape, or a rise that the shape cannot have over this span.
    """
    positive(span=span)
    check_choice("shape", shape, SHAPES)
    half = span / 2
    if shape == "semicircular":
        if rise is not None and not math.isclose(rise, half):
            raise InputError(f"rise is {rise!r}; that of a semicircular profile is span / 2 = {half:g} m")
        return _arc((0.0, 0.0), half, 0.0, math.pi / 2)
    if rise is None:
        raise InputError(f"rise is missing; {with_article(shape)} profile needs one [m]")
    positive(rise=rise)
    low, high = {"segmental": (0.0, half), "elliptic": (0.0, math.inf)}.get(shape, (half, math.inf))
    if not low < rise < high:
        allowed = f"between {low:g} and {high:g} m" if math.isfinite(high) else f"above {low:g} m"
        raise InputError(f"rise is {rise!r}; over {span:g} m {with_article(shape)} profile has one {allowed}")
    if shape == "elliptic":
        return _ellipse(half, rise)
    if shape == "pointed":
        centre = (half**2 - rise**2) / span  # (radius = half - centre)^2 = centre^2 + rise^2
        return _arc((centre, 0.0), half - centre, 0.0, math.atan2(rise, -centre))
    radius = (half**2 + rise**2) / (2 * rise)
    return _arc((0.0, rise - radius), radius, math.atan2(radius - rise, half), math.pi / 2)


def _arc(centre: tuple[float, float], radius: float, first: float, last: float) -> Profile:
    """An arc of a circle from the angle `first` to `last` [rad]."""

    def normal(s: Floats) -> Floats:
        angle = first + (last - first) * s
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def extrados(x: Floats, thickness: float) -> Floats:
        return centre[1] + np.sqrt((radius + thickness) ** 2 - (x - centre[0]) ** 2)

    return Profile(
        curve=lambda s: np.array(centre) + radius * normal(s),
        normal=normal,
        extrados=extrados,
        length=radius * (last - first),
        crown_joint=centre[0] < 0,
    )


def _ellipse(half: float, rise: float) -> Profile:
    """Half an ellipse, its eccentric angle found from a fine table of lengths."""
    table = np.linspace(0, math.pi / 2, 4097)
    speed = np.hypot(half * np.sin(table), rise * np.cos(table))
    length = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(table))])

    def angle(s: Floats) -> Floats:
        return np.interp(s * length[-1], length, table)

    def points(angle: Floats) -> Floats:
        return np.stack([half * np.cos(angle), rise * np.sin(angle)], axis=1)

    def normals(angle: Floats) -> Floats:
        across = np.stack([rise * np.cos(angle), half * np.sin(angle)], axis=1)
        return across / np.linalg.norm(across, axis=1)[:, None]

    def extrados(x: Floats, thickness: float) -> Floats:
        low, high = np.zeros_like(x), np.full_like(x, math.pi / 2)
        for _ in range(60):  # the extrados is parallel to the ellipse: no formula for its height
            middle = (low + high) / 2
            beyond = (points(middle) + thickness * normals(middle))[:, 0] > x
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        return (points(high) + thickness * normals(high))[:, 1]

    return Profile(
        curve=lambda s: points(angle(s)),
        normal=lambda s: normals(angle(s)),
        extrados=extrados,
        length=float(length[-1]),
    )


def half_joints(shape: str, span: float, rise: float | None, thickness: float, voussoirs: int, kind: str) -> Floats:
    """Joints of the right half of an arch of equal voussoirs, springing first.

    The last is the crown joint of an even number, the nearer side of the keystone of an odd one.

    Parameters
    ----------
    shape : str
        Of the intrados, see `profile`.
    span : float
        Clear [m].
    rise : float or None
        At the intrados [m].
    thickness : float
        Normal to the intrados [m].
    voussoirs : int
        Their number in the whole arch.
    kind : str
        "radial" or "vertical".

    Returns
    -------
    ndarray
        Points x, z on the intrados and on the extrados, shape (n, 2, 2) [m].

    Raises
    ------
    InputError
        For a number of voussoirs or a kind of joints that the shape cannot have.
    """
    positive(thickness=thickness)
    half = profile(shape, span, rise)
    if half.crown_joint and voussoirs % 2:
        raise InputError(
            f"voussoirs is {voussoirs}; {with_article(shape)} profile has a joint at the crown and needs an even number"
        )
    if shape == "horseshoe" and kind == "vertical":
        raise InputError("joints is 'vertical'; a horseshoe profile has radial joints only")
    return half.joints(2 * np.arange(voussoirs // 2 + 1) / voussoirs, thickness, kind)


def whole_joints(half: Floats, voussoirs: int) -> Floats:
    """All joints of an arch from left to right, from those of its right half.

    Parameters
    ----------
    half : ndarray
        As `half_joints` gives them, shape (n, 2, 2) [m].
    voussoirs : int
        Their number in the whole arch.

    Returns
    -------
    ndarray
        Shape (voussoirs + 1, 2, 2) [m].
    """
    left = half * (-1.0, 1.0)
    return np.concatenate([left if voussoirs % 2 else left[:-1], half[::-1]])


def positive(**lengths: float) -> None:
    """Check that lengths are finite numbers above 0.

    Parameters
    ----------
    **lengths : float
        By the name that a message gives them [m].

    Raises
    ------
    InputError
        Naming the first that is not.
    """
    for name, value in lengths.items():
        if not is_number(value) or not 0 < value < math.inf:
            raise InputError(f"{name} is {value!r}; it must be a length above 0 [m]")


def at_least(least: int, **numbers: int) -> None:
    """Check that numbers are whole and not too small.

    Parameters
    ----------
    least : int
        The smallest allowed.
    **numbers : int
        By the name that a message gives them.

    Raises
    ------
    InputError
        Naming the first that is not.
    """
    for name, value in numbers.items():
        check_count(name, value, least=least)


def number_of(voussoirs: int | None, voussoir: float | None, length: float, *, even: bool = False) -> int:
    """The number of voussoirs given, or the one nearest to a size along an intrados.

    Parameters
    ----------
    voussoirs : int or None
        Their number.
    voussoir : float or None
        Or their length along the intrados [m].
    length : float
        Of the intrados [m].
    even : bool
        Whether a size makes an even number of them.

    Returns
    -------
    int
        The number of voussoirs.

    Raises
    ------
    InputError
        Unless one of both is given.
    """
    if (voussoirs is None) == (voussoir is None):
        raise InputError("give either voussoirs (their number) or voussoir (their length along the intrados [m])")
    if voussoir is None:
        assert voussoirs is not None
        at_least(2, voussoirs=voussoirs)
        return voussoirs
    positive(voussoir=voussoir)
    return max(2 * round(length / voussoir / 2), 2) if even else max(round(length / voussoir), 3)
