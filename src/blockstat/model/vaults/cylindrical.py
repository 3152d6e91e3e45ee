"""Barrel, groin and pavilion vaults of bonded courses.

The last two are two barrels over one bay, of one rise. A groin (cross) vault is open on its sides and keeps the higher
intrados at each place; a pavilion (cloister) vault closes in on four walls and keeps the lower. The two barrels meet in
the diagonal planes of the bay, and the courses turn there at one level.

Over a rectangular bay the profile along y is that along x stretched to the other span, so that the courses of both
meet corner for corner: a circle becomes an ellipse, and the thickness at the springing and the slope of the joints
stretch with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, check_choice
from blockstat.model.arches.profile import at_least, half_joints, number_of, positive, profile, whole_joints
from blockstat.model.quantities import Groins, Length, Lengths, Size, Three
from blockstat.model.solids import below, fuse, hexahedron, prism
from blockstat.model.walling.brickwork import SLIVER
from blockstat.model.walling.pattern import plain_row
from blockstat.typing import Floats

SIDES = {(0, 1): "east", (0, -1): "west", (1, 1): "north", (1, -1): "south"}  #: by axis and sign
GROINS = ("solid", "mitred")


def barrel_vault(
    shape: str = "semicircular",
    *,
    span: Length,
    rise: Length | None = None,
    length: Length,
    thickness: Length,
    brick: Length,
    voussoirs: int | None = None,
    voussoir: Length | None = None,
    springers: Size = 0.0,
) -> list[Block]:
    """A barrel along x, springing at z = 0 from its sides y = -span/2 and y = span/2, centred on its origin.

    Each course from springing to springing is a row of running bond along x.

    Parameters
    ----------
    shape : str
        Of the intrados, as of an arch.
    span : float
        Clear, along y [m].
    rise : float, optional
        At the intrados [m]; not for semicircular.
    length : float
        Along x [m].
    thickness : float
        Normal to the intrados [m].
    brick : float
        Nominal length of a voussoir along x [m].
    voussoirs : int, optional
        Number of courses round the arch.
    voussoir : float, optional
        Or their length along the intrados [m].
    springers : float
        Height of the blocks under the springings, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "vault", "springer.south" and "springer.north".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    positive(length=length, brick=brick)
    half = profile(shape, span, rise)
    number = number_of(voussoirs, voussoir, 2 * half.length, even=half.crown_joint)
    joints = whole_joints(half_joints(shape, span, rise, thickness, number, "radial"), number)
    rows = plain_row(length, brick)

    def across(outline: Floats, x: float) -> Floats:
        return np.column_stack([np.full(len(outline), x - length / 2), outline])

    blocks = []
    for course, (a, b) in enumerate(zip(joints[:-1], joints[1:], strict=True)):
        outline = np.array([a[0], b[0], b[1], a[1]])
        cuts = [across(outline, x) for x in rows[course % 2].tolist()]
        for i, ends in enumerate(zip(cuts, cuts[1:], strict=False)):
            blocks.append(hexahedron(*ends, name=f"vault.{course}.{i}", group="vault"))
    if springers:
        positive(springers=springers)
        for side, bed in (("south", joints[0]), ("north", joints[-1])):
            face = np.concatenate([across(bed, 0.0), across(bed, length)[::-1]])
            blocks.append(below(face, springers, name=f"springer.{side}", group=f"springer.{side}"))
    return blocks


@dataclass(frozen=True)
class _Bay:
    """A bay and the profile of its vault."""

    reach: tuple[float, float]  #: half the span along x and y [m]
    joints: Floats  #: shape (m + 1, 2, 2), (intrados, extrados) as fraction of the half span and height [m]
    brick: float  #: nominal length of a voussoir along its course [m]
    mitred: bool
    keyed: bool  #: whether a keystone closes the crown

    @property
    def courses(self) -> int:
        """Courses from springing to crown, without the crown's own."""
        return len(self.joints) - 1

    def section(self, course: int) -> Floats:
        """Section of a course, shape (4, 2): two corners of its lower bed, then two of its upper one."""
        return np.concatenate([self.joints[course], self.joints[course + 1, ::-1]])

    def face(self, outline: Floats, along: int, sign: Sequence[float], place: Floats | float) -> Floats:
        """Where a section cuts a plane across its course, shape (n, 3).

        outline : as `section`; along : axis of the course; sign : of x and y, to mirror the quarter x, y > 0;
        place : along the course, one for each corner [m].
        """
        points = np.empty((len(outline), 3))
        points[:, along] = sign[along] * place
        points[:, 1 - along] = sign[1 - along] * self.reach[1 - along] * outline[:, 0]
        points[:, 2] = outline[:, 1]
        return points

    def piece(self, outline: Floats, along: int, sign: Sequence[float], ends: tuple[Floats | float, Floats | float]):
        """A stretch of a course between two places along it."""
        return prism(*(self.face(outline, along, sign, place) for place in ends))

    def groin(self, outline: Floats, along: int) -> Floats:
        """Where a section meets the groin, along its course in the quarter x, y > 0, shape (n,) [m]."""
        return self.reach[along] * outline[:, 0]

    def corner(self, arms: Sequence[Block], name: str, group: str) -> Iterator[Block]:
        """The two arms at a groin as one block, or as two with a joint in the diagonal plane."""
        if not self.mitred:
            yield fuse(arms, name=name, group=group)
            return
        for axis, arm in zip("yx", arms, strict=True):
            yield Block(arm.vertices, arm.faces, name=f"{name}.{axis}", group=group)

    def key(self) -> Block:
        """The keystone between the upper beds of the last courses."""
        bottom, top = (
            np.array(
                [(x * p * self.reach[0], y * p * self.reach[1], z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            )
            for p, z in self.joints[-1]
        )
        return prism(bottom, top, name="vault.key", group="vault.key")


def _bay(
    shape: str, spans: tuple[float, float], rise: float | None, thickness: float, number: int, brick: float, groins: str
) -> _Bay:
    if not (isinstance(spans, Sequence) and len(spans) == 2):
        raise InputError(f"spans is {spans!r}; it must be the two clear spans along x and y [m]")
    positive(**{"spans[0]": spans[0], "spans[1]": spans[1]}, thickness=thickness, brick=brick)
    if shape == "horseshoe":
        raise InputError("shape is 'horseshoe'; a bay needs a profile that does not draw in at the springing")
    check_choice("groins", groins, GROINS)
    at_least(3, voussoirs=number)
    joints = half_joints(shape, spans[0], rise, thickness, number, "radial") / (spans[0] / 2, 1.0)
    return _Bay((spans[0] / 2, spans[1] / 2), joints, brick, groins == "mitred", bool(number % 2))


def groin_vault(
    shape: str = "semicircular",
    *,
    spans: Lengths,
    rise: Length | None = None,
    thickness: Length,
    voussoirs: Three,
    brick: Length,
    groins: Groins = "solid",
    springers: Size = 0.0,
) -> list[Block]:
    """A groin (cross) vault over a bay, springing at z = 0 from its corners, centred on its origin.

    It reaches beyond the clear spans by its thickness at the springing, so that each corner rests on a rectangle.

    Parameters
    ----------
    shape : str
        Of the profile along x, as of an arch; not horseshoe.
    spans : tuple of float
        Clear, along x and y [m].
    rise : float, optional
        At the intrados [m]; not for semicircular.
    thickness : float
        Normal to the intrados, where the profile is that along x [m].
    voussoirs : int
        Number of courses of a whole barrel; an odd number has a keystone and a crown course.
    brick : float
        Nominal length of a voussoir along its course [m].
    groins : str
        Stones of both webs in one ("solid"), or a joint in the diagonal plane ("mitred").
    springers : float
        Height of the blocks under the corners, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "vault.north" (the web at y > 0), "vault.east", ..., "vault.groin.ne", ..., "vault.key" and
        "springer.ne", ...

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    bay = _bay(shape, spans, rise, thickness, voussoirs, brick, groins)
    blocks = []
    for sign in product((1, -1), repeat=2):
        corner = SIDES[1, sign[1]][0] + SIDES[0, sign[0]][0]
        beds = []
        for course in range(bay.courses):
            outline, arms = bay.section(course), []
            for along in (1, 0):
                groin = bay.groin(outline, along)
                cuts = [groin, *_heads(bay, along, course, groin.max())]
                first, *others = (bay.piece(outline, along, sign, ends) for ends in zip(cuts, cuts[1:], strict=False))
                web, flank = SIDES[along, sign[along]], SIDES[1 - along, sign[1 - along]][0]
                arms.append(first)
                for i, block in enumerate(others, 1):
                    name = f"vault.{web}.{course}.{flank}{i}"
                    blocks.append(Block(block.vertices, block.faces, name, f"vault.{web}"))
                if course == 0:
                    beds.append(_bed(bay, along, sign, cuts[-1]))
            blocks += bay.corner(arms, f"vault.groin.{corner}.{course}", f"vault.groin.{corner}")
        if springers:
            positive(springers=springers)
            parts = [below(bed, springers) for bed in beds]
            blocks.append(fuse(parts, name=f"springer.{corner}", group=f"springer.{corner}"))
    return [*blocks, *_crown(bay)] if bay.keyed else blocks


def _edge(bay: _Bay, along: int) -> float:
    """Where the webs end, beyond the clear span by the thickness at the springing [m]."""
    return bay.reach[along] * float(bay.joints[0, 1, 0])


def _heads(bay: _Bay, along: int, course: int, groin: float) -> list[float]:
    """Head joints of one arm of a groin vault's course from the groin outwards, the free edge last."""
    edge = _edge(bay, along)
    inwards = np.arange(0.0 if course % 2 == 0 else 0.5, edge / bay.brick + 1) * bay.brick
    inwards = inwards[(inwards > 0) & (edge - inwards >= groin + SLIVER * bay.brick)]
    return [*(edge - inwards[::-1]), edge]


def _bed(bay: _Bay, along: int, sign: Sequence[float], edge: float) -> Floats:
    """Bed of one arm at the springing, from groin to edge, shape (4, 3)."""
    joint = bay.joints[0]
    inner, outer = bay.face(joint, along, sign, bay.groin(joint, along)), bay.face(joint, along, sign, edge)
    return np.concatenate([inner, outer[::-1]])


def _crown(bay: _Bay) -> Iterator[Block]:
    """The keystone of a groin vault and its four crown courses."""
    yield bay.key()
    joint = bay.joints[-1]
    outline = np.concatenate([joint, joint[::-1] * (-1, 1)])
    for (along, sign), web in SIDES.items():
        start = bay.reach[along] * np.abs(outline[:, 0])
        cuts = [start, *_heads(bay, along, bay.courses, start.max())]
        signs = (sign, 1) if along == 0 else (1, sign)
        for i, ends in enumerate(zip(cuts, cuts[1:], strict=False)):
            block = bay.piece(outline, along, signs, ends)
            yield Block(block.vertices, block.faces, f"vault.{web}.{bay.courses}.{i}", f"vault.{web}")


def pavilion_vault(
    shape: str = "semicircular",
    *,
    spans: Lengths,
    rise: Length | None = None,
    thickness: Length,
    voussoirs: Three,
    brick: Length,
    groins: Groins = "solid",
    springers: Size = 0.0,
) -> list[Block]:
    """A pavilion (cloister) vault over a bay, springing at z = 0 from its sides, centred on its origin.

    Each course is a closed ring of four sides.

    Parameters
    ----------
    shape : str
        Of the profile along x, as of an arch; not horseshoe.
    spans : tuple of float
        Clear, along x and y [m].
    rise : float, optional
        At the intrados [m]; not for semicircular.
    thickness : float
        Normal to the intrados, where the profile is that along x [m].
    voussoirs : int
        Number of courses of a whole barrel; an odd number has a keystone, an even one comes to a point.
    brick : float
        Nominal length of a voussoir along its course [m].
    groins : str
        Stones of both webs in one ("solid"), or a joint in the diagonal plane ("mitred").
    springers : float
        Height of the blocks under the sides, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "vault.north", ..., "vault.groin.ne", ..., "vault.key" and "springer.north", ...

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    bay = _bay(shape, spans, rise, thickness, voussoirs, brick, groins)
    blocks = [bay.key()] if bay.keyed else []
    for course in range(bay.courses):
        outline = bay.section(course)
        heads = [_centred(bay, course, bay.groin(outline, along).min()) for along in (0, 1)]
        for sign in product((1, -1), repeat=2):
            corner = SIDES[1, sign[1]][0] + SIDES[0, sign[0]][0]
            arms = [bay.piece(outline, a, sign, (heads[a][-1], bay.groin(outline, a))) for a in (1, 0)]
            blocks += bay.corner(arms, f"vault.groin.{corner}.{course}", f"vault.groin.{corner}")
        for (across, sign), side in SIDES.items():
            along = 1 - across
            signs = (sign, 1) if along == 1 else (1, sign)
            for i, ends in enumerate(zip(heads[along], heads[along][1:], strict=False)):
                block = bay.piece(outline, along, signs, ends)
                blocks.append(Block(block.vertices, block.faces, f"vault.{side}.{course}.{i}", f"vault.{side}"))
    if springers:
        positive(springers=springers)
        joint = bay.joints[0]
        for (across, sign), side in SIDES.items():
            along = 1 - across
            signs, end = ((sign, 1) if along == 1 else (1, sign)), bay.groin(joint, along)
            bed = np.concatenate([bay.face(joint, along, signs, -end), bay.face(joint, along, signs, end)[::-1]])
            blocks.append(below(bed, springers, name=f"springer.{side}", group=f"springer.{side}"))
    return blocks


def _centred(bay: _Bay, course: int, groin: float) -> list[float]:
    """Head joints along one side of a ring, symmetric about the middle; at least one."""
    reach = max(groin - SLIVER * bay.brick, 0.0)
    number = int(reach / bay.brick - course % 2 / 2) if reach >= course % 2 / 2 * bay.brick else -1
    half = (np.arange(number + 1) + course % 2 / 2) * bay.brick
    return sorted({*(-half).tolist(), *half.tolist()} or {0.0})
