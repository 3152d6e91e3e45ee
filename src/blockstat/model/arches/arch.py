"""Arches of straight-sided voussoirs."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.profile import at_least, half_joints, number_of, positive, profile, whole_joints
from blockstat.model.solids import prism
from blockstat.typing import Floats

BATTER = 0.5  #: of the outer faces of springers, width over height: a springer is wider at its foot


def arch(
    shape: str = "semicircular",
    *,
    span: float,
    rise: float | None = None,
    thickness: float,
    depth: float,
    voussoirs: int | None = None,
    voussoir: float | None = None,
    joints: str = "radial",
    springers: float = 0.0,
) -> list[Block]:
    """An arch in the plane x, z over -span/2 <= x <= span/2, springing at z = 0, centred at y = 0.

    Neighbouring voussoirs share the corners of their joint. Their straight intrados is inside the curve's arc by
    the sagitta of one voussoir.

    Parameters
    ----------
    shape : "semicircular", "segmental", "horseshoe", "pointed" or "elliptic"; see `jack_arch` for a flat one.
    span, rise : clear, at the intrados [m]. thickness : normal to the intrados [m]. depth : along y [m].
    voussoirs, voussoir : their number, or their length along the intrados [m]; of equal length there.
    joints : "radial" (normal to the intrados) or "vertical"; the beds at the springings are normal in both.
    springers : height of the two fixed blocks under the springings [m], 0 for none.

    Returns
    -------
    Blocks of group "arch" from left to right, then "springer.left" and "springer.right".
    """
    half = profile(shape, span, rise)
    number = number_of(voussoirs, voussoir, 2 * half.length, even=half.crown_joint)
    right = half_joints(shape, span, rise, thickness, number, joints)
    return _ring(whole_joints(right, number), depth, springers)


def jack_arch(
    *, span: float, thickness: float, depth: float, voussoirs: int, skew: float = 20.0, springers: float = 0.0
) -> list[Block]:
    """A flat (jack) arch: horizontal intrados and extrados, joints towards one point below.

    span : clear, at the intrados [m]. thickness : its height [m]. depth : along y [m]. voussoirs : their number, of
    equal length at the intrados. skew : inclination of the skewbacks against the vertical [degrees], 0 for vertical
    joints. springers : height of the fixed blocks with the skewbacks below the intrados [m], 0 for none.
    Groups as those of `arch`.
    """
    positive(span=span, thickness=thickness)
    at_least(1, voussoirs=voussoirs)
    if not 0 <= skew < 80:
        raise InputError(f"skew is {skew!r}; it must be an angle from 0 to 80 degrees")
    inner = span / 2 * (2 * np.arange(voussoirs + 1) / voussoirs - 1)
    outer = inner * (1 + thickness * np.tan(np.deg2rad(skew)) / (span / 2))
    low, high = np.zeros_like(inner), np.full_like(inner, thickness)
    return _ring(np.stack([np.column_stack([inner, low]), np.column_stack([outer, high])], axis=1), depth, springers)


def rib(
    shape: str = "semicircular",
    *,
    span: float,
    rise: float | None = None,
    thickness: float,
    depth: float,
    voussoirs: int | None = None,
    voussoir: float | None = None,
    springers: float = 0.0,
) -> list[Block]:
    """A transverse rib under a barrel vault, in the plane x, z, springing at z = 0, centred at y = 0.

    shape, span, rise, voussoirs, voussoir : of the vault above. The corners of the rib's extrados are those of the
    vault's intrados, so that each of its voussoirs carries one course. thickness : inwards from there [m]; depth :
    along y [m]. The rest as in `arch`; groups "rib", "springer.left" and "springer.right".
    """
    positive(thickness=thickness)
    half = profile(shape, span, rise)
    number = number_of(voussoirs, voussoir, 2 * half.length, even=half.crown_joint)
    if half.crown_joint and number % 2:
        raise InputError(f"voussoirs is {number}; a {shape} profile has a joint at the crown and needs an even number")
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
