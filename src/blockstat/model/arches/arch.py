"""Arches of straight-sided voussoirs."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, with_article
from blockstat.model.arches.profile import at_least, half_joints, number_of, positive, profile, whole_joints
from blockstat.model.quantities import Count, Length, Size
from blockstat.model.solids import prism
from blockstat.typing import Floats

BATTER = 0.5  #: of the outer faces of springers, width over height: a springer is wider at its foot


def arch(
    shape: str = "semicircular",
    *,
    span: Length,
    rise: Length | None = None,
    thickness: Length,
    depth: Length,
    voussoirs: int | None = None,
    voussoir: Length | None = None,
    joints: str = "radial",
    springers: Size = 0.0,
) -> list[Block]:
    """An arch of straight-sided voussoirs in the plane x, z, springing at z = 0, centred on its origin.

    Neighbouring voussoirs share the corners of their joint. Their straight intrados is inside the curve's arc by the
    sagitta of one voussoir. See `jack_arch` for a flat arch.

    Parameters
    ----------
    shape : str
        Of the intrados: semicircular, segmental, horseshoe, pointed or elliptic.
    span : float
        Clear, at the intrados [m].
    rise : float, optional
        At the intrados [m]; not for semicircular.
    thickness : float
        Normal to the intrados [m].
    depth : float
        Along y [m].
    voussoirs : int, optional
        Their number.
    voussoir : float, optional
        Or their length along the intrados [m]; voussoirs are of equal length there.
    joints : str
        Radial (normal to the intrados) or vertical; the beds at the springings are normal in both.
    springers : float
        Height of the blocks under the springings, 0 for none [m].

    Returns
    -------
    list of Block
        Group "arch" from left to right, then "springer.left" and "springer.right".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.

    Examples
    --------
    >>> from blockstat.model import arch
    >>> [block.name for block in arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=3)]
    ['arch.0', 'arch.1', 'arch.2']
    """
    half = profile(shape, span, rise)
    number = number_of(voussoirs, voussoir, 2 * half.length, even=half.crown_joint)
    right = half_joints(shape, span, rise, thickness, number, joints)
    return _ring(whole_joints(right, number), depth, springers)


def jack_arch(
    *, span: Length, thickness: Length, depth: Length, voussoirs: Count, skew: float = 20.0, springers: Size = 0.0
) -> list[Block]:
    """A flat (jack) arch in the plane x, z, its intrados at z = 0, centred on its origin.

    Intrados and extrados are horizontal. The joints point to one place below.

    Parameters
    ----------
    span : float
        Clear, at the intrados [m].
    thickness : float
        Its height [m].
    depth : float
        Along y [m].
    voussoirs : int
        Their number; they are of equal length at the intrados.
    skew : float
        Of the skewbacks against the vertical, 0 for vertical joints [degrees].
    springers : float
        Height of the blocks with the skewbacks, below the intrados, 0 for none [m].

    Returns
    -------
    list of Block
        Groups as those of `arch`.

    Raises
    ------
    InputError
        Naming the option that cannot be built.
    """
    positive(span=span, thickness=thickness)
    at_least(1, voussoirs=voussoirs)
    if not 0 <= skew < 80:
        raise InputError(f"skew is {skew!r}; it must be an angle from 0 to below 80 degrees")
    inner = span / 2 * (2 * np.arange(voussoirs + 1) / voussoirs - 1)
    outer = inner * (1 + thickness * np.tan(np.deg2rad(skew)) / (span / 2))
    low, high = np.zeros_like(inner), np.full_like(inner, thickness)
    return _ring(np.stack([np.column_stack([inner, low]), np.column_stack([outer, high])], axis=1), depth, springers)


def rib(
    shape: str = "semicircular",
    *,
    span: Length,
    rise: Length | None = None,
    thickness: Length,
    depth: Length,
    voussoirs: int | None = None,
    voussoir: Length | None = None,
    springers: Size = 0.0,
) -> list[Block]:
    """A transverse rib under a barrel vault that spans x, in the plane x, z, springing at z = 0, centred on its origin.

    The corners of its extrados are the corners of the vault's intrados, so that each of its voussoirs carries one
    course.

    Parameters
    ----------
    shape : str
        Of the vault above, as of an arch.
    span : float
        Of the vault above [m].
    rise : float, optional
        Of the vault above [m].
    thickness : float
        Inwards from the vault's intrados [m].
    depth : float
        Along y [m].
    voussoirs : int, optional
        Of the vault above.
    voussoir : float, optional
        Or their length along the vault's intrados [m].
    springers : float
        Height of the blocks under the springings, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "rib", "springer.left" and "springer.right".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    positive(thickness=thickness)
    half = profile(shape, span, rise)
    number = number_of(voussoirs, voussoir, 2 * half.length, even=half.crown_joint)
    if half.crown_joint and number % 2:
        raise InputError(
            f"voussoirs is {number}; {with_article(shape)} profile has a joint at the crown and needs an even number"
        )
    joints = half.joints(2 * np.arange(number // 2 + 1) / number, -thickness)[:, ::-1]
    if not ((np.diff(joints[:, 0, 0]) < 0).all() and (np.diff(joints[:, 0, 1]) > 0).all() and joints[0, 0, 0] > 0):
        raise InputError(f"thickness is {thickness!r}; a rib under a curve of {span:g} m must be thinner [m]")
    blocks = _ring(whole_joints(joints, number), depth, springers)
    return [Block(b.vertices, b.faces, b.name.replace("arch", "rib"), b.group.replace("arch", "rib")) for b in blocks]


def _ring(joints: Floats, depth: float, springers: float) -> list[Block]:
    """Voussoirs between joints from left to right, shape (n + 1, 2, 2), and springers under the first and the last."""
    positive(depth=depth)
    blocks = []
    for i, (a, b) in enumerate(zip(joints[:-1], joints[1:], strict=True)):
        blocks.append(_slice([*a, *b[::-1]], depth, f"arch.{i}", "arch"))
    if springers:
        positive(springers=springers)
        for side, joint, sign in (("left", joints[0], -1), ("right", joints[-1], 1)):
            inner, outer = joint
            foot = joint[:, 1].min() - springers
            toe = (outer[0] + sign * BATTER * springers, foot)
            blocks.append(_slice([inner, outer, toe, (inner[0], foot)], depth, f"springer.{side}", f"springer.{side}"))
    return blocks


def _slice(outline: list, depth: float, name: str, group: str) -> Block:
    """A block with an outline in the plane x, z, `depth` deep and centred at y = 0."""
    x, z = np.array(outline).T
    near, far = (np.column_stack([x, np.full(len(x), y), z]) for y in (-depth / 2, depth / 2))
    return prism(near, far, name=name, group=group)
