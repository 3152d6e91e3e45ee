"""Domes of rings of voussoirs, and the drums they stand on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, check_choice
from blockstat.model.arches.profile import at_least, positive, profile
from blockstat.model.quantities import Bond, Count, Length, Size, Three
from blockstat.model.solids import below, fuse, prism
from blockstat.typing import Floats

BONDS = ("running", "stack")


def dome(
    shape: str = "semicircular",
    *,
    span: Length,
    rise: Length | None = None,
    thickness: Length,
    rings: Count,
    voussoirs: Three,
    oculus: Size = 0.0,
    bond: Bond = "running",
    springers: Size = 0.0,
) -> list[Block]:
    """A dome about its origin, springing at z = 0.

    Its plan is a polygon of 2 x `voussoirs` sides on the circle of the span. Each voussoir has two of them, so that in
    running bond its neighbours above and below meet half of it each. All joints are planar: beds are trapezia that lie
    on the cones normal to the intrados, head joints are in meridian planes.

    Parameters
    ----------
    shape : str
        Of a meridian section, as of an arch.
    span : float
        Clear diameter [m].
    rise : float, optional
        At the intrados [m]; not for semicircular.
    thickness : float
        Normal to the intrados [m].
    rings : int
        Their number, of equal height along the intrados.
    voussoirs : int
        In each ring.
    oculus : float
        Clear diameter of the opening at the crown, 0 for a keystone half a ring high [m].
    bond : str
        Head joints over the middle of the voussoir below ("running"), or continuous along meridians ("stack").
    springers : float
        Height of the blocks under the first ring, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "dome.0" (the lowest ring), "dome.1", ..., "dome.key" and "springer".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.

    Examples
    --------
    >>> from blockstat.model import dome
    >>> len(dome(span=4.0, thickness=0.3, rings=3, voussoirs=8))  # and a keystone
    25
    """
    positive(span=span, thickness=thickness)
    at_least(1, rings=rings)
    at_least(3, voussoirs=voussoirs)
    check_choice("bond", bond, BONDS)
    if oculus != 0 and not 0 < oculus < span:
        raise InputError(f"oculus is {oculus!r}; it must be a diameter from 0 to the span, {span:g} m")
    half = profile(shape, span, rise)
    last = half.where(oculus / 2) if oculus else rings / (rings + 0.5)
    joints = half.joints(last * np.arange(rings + 1) / rings, thickness)
    corners = _on_meridians(joints, voussoirs)
    blocks = list(_rings(corners, bond, "dome"))
    if not oculus:
        bottom, top = corners[-1].swapaxes(0, 1)
        blocks.append(prism(bottom, top, name="dome.key", group="dome.key"))
    if springers:
        positive(springers=springers)
        for i in range(voussoirs):
            parts = [below(_bed(corners[0], 2 * i + k), springers) for k in (0, 1)]
            blocks.append(fuse(parts, name=f"springer.{i}", group="springer"))
    return blocks


def drum(
    *, span: Length, thickness: Length, height: Length, courses: Count, voussoirs: Three, bond: Bond = "running"
) -> list[Block]:
    """The round wall under a dome of the same span and voussoirs, from z = 0 up, about its origin.

    Its plan is the polygon of the dome's, and so are its stones.

    Parameters
    ----------
    span : float
        Clear diameter [m].
    thickness : float
        Radial, at least that of the dome [m].
    height : float
        Of all courses together [m].
    courses : int
        Their number.
    voussoirs : int
        Stones in each course.
    bond : str
        Staggered head joints ("running"), or continuous ones ("stack").

    Returns
    -------
    list of Block
        Groups "drum.0" (the lowest course), "drum.1", ...

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    positive(span=span, thickness=thickness, height=height)
    at_least(1, courses=courses)
    at_least(3, voussoirs=voussoirs)
    check_choice("bond", bond, BONDS)
    radii = np.array([span / 2, span / 2 + thickness])
    levels = height * np.arange(courses + 1) / courses
    joints = np.stack(np.broadcast_arrays(radii, levels[:, None]), axis=2)
    corners = _on_meridians(joints, voussoirs)
    return list(_rings(corners, bond, "drum"))


def _on_meridians(joints: Floats, voussoirs: int) -> Floats:
    """Corners by joint, half meridian and side (intrados, extrados), shape (n, 2 voussoirs, 2, 3)."""
    angle = np.pi * np.arange(2 * voussoirs) / voussoirs
    meridian = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    plan = joints[:, None, :, :1] * meridian[None, :, None, :]
    return np.concatenate([plan, np.broadcast_to(joints[:, None, :, 1:], (*plan.shape[:3], 1))], axis=3)


def _rings(corners: Floats, bond: str, group: str) -> Iterator[Block]:
    """The voussoirs between joints, ring after ring."""
    for ring in range(len(corners) - 1):
        shift = ring % 2 if bond == "running" else 0
        for i in range(corners.shape[1] // 2):
            parts = [_wedge(corners[ring : ring + 2], 2 * i + shift + k) for k in (0, 1)]
            yield fuse(parts, name=f"{group}.{ring}.{i}", group=f"{group}.{ring}")


def _bed(joint: Floats, meridian: int) -> Floats:
    """Bed between a half meridian and the next, shape (4, 3)."""
    a, b = joint[meridian % len(joint)], joint[(meridian + 1) % len(joint)]
    return np.concatenate([a, b[::-1]])


def _wedge(joints: Floats, meridian: int) -> Block:
    """Half a voussoir: between two joints and between a half meridian and the next."""
    return prism(_bed(joints[0], meridian), _bed(joints[1], meridian))
