"""The contact points of the first joints as pairs of material points, each on the face of the other block.

At rest the two points of a pair are in one place. A point belongs to the block that has a corner there, or to both. A
corner of block a keeps clear of the face of block b, and a corner of b of the face of a:

    gap = n_b . (p_b - p_a)  for a corner of a,      gap = n_a . (p_b - p_a)  for a corner of b,

with n_a and n_b the joint's normal, which points from a to b, as it turns with each block. Where sides of the two faces
cross, neither has a corner; the normal is then perpendicular to both sides, and the contact is where they cross.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.contact.point_law import joint_friction
from blockstat.large_displacement.pose import Pose, origins, places
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A contact point this near to a corner of a block, relative to the block's size, is that corner: rounding.
CORNER = 1e-6
#: Directions whose sine is below this are one, and sides that lean out of a joint by less lie in it.
FLAT = 1e-4
#: Blocks that are turned by less than this against each other keep their joint: rounding [rad].
UNTURNED = 1e-9


@dataclass(frozen=True, eq=False)
class Contacts:
    """Pairs of material points of the first joints."""

    joint: Ints  #: number of the interface, shape (n,)
    pair: Ints  #: blocks a and b, shape (n, 2)
    anchor: Floats  #: where the points of a and b are at rest, shape (n, 2, 3) [m]
    corner: np.ndarray  #: whether it is a corner of a, and of b, shape (n, 2) bool
    normal: Floats  #: of the joint at rest, from a to b, shape (n, 3)
    friction: Floats  #: shape (n,)
    #: displacement of each side besides that of its block, per unit of the movement of supports, shape (n, 2, 3)
    drive: Floats
    #: directions at rest of the sides of a and b that cross where neither has a corner, zero elsewhere, shape (n, 2, 3)
    edge: Floats

    @property
    def number(self) -> int:
        """The number of contact points."""
        return len(self.joint)


def first_contacts(assembly: Assembly, interfaces: Interfaces) -> Contacts:
    """Return the contact points of an assembly at rest.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.

    Returns
    -------
    Contacts
        In the order of the points of the joints.
    """
    joint = interfaces.point_interface
    pair = interfaces.pair[joint]
    corner = np.stack([is_corner(assembly, side, interfaces.point) for side in pair.T], axis=1)
    normal, edge = interfaces.frame[joint, 0], np.zeros((len(joint), 2, 3))
    for row in np.flatnonzero(~corner.any(axis=1)):
        for side in (0, 1):
            edge[row, side] = _side(assembly, int(pair[row, side]), interfaces.point[row], normal[row])
    return Contacts(
        joint=joint,
        pair=pair,
        anchor=np.repeat(interfaces.point[:, None], 2, axis=1),
        corner=corner,
        edge=edge,
        normal=normal,
        friction=joint_friction(assembly, interfaces)[joint],
        drive=np.zeros((len(joint), 2, 3)),
    )


def is_corner(assembly: Assembly, block: Ints, point: Floats) -> np.ndarray:
    """Return whether points are corners of blocks.

    Parameters
    ----------
    assembly
        The blocks.
    block
        One for each point, shape (n,).
    point
        Shape (n, 3) [m].

    Returns
    -------
    array of bool, shape (n,)
        True where a corner of the block is there.
    """
    found = np.zeros(len(block), dtype=bool)
    for index in np.unique(block):
        own = np.flatnonzero(block == index)
        distance = np.linalg.norm(point[own, None] - assembly.block_vertices(int(index)), axis=2).min(axis=1)
        found[own] = distance <= CORNER * assembly.size[index]
    return found


def _side(assembly: Assembly, block: int, point: Floats, normal: Floats) -> Floats:
    """Direction of the edge of a block that a point lies on, in the plane across a normal; zero where there is none."""
    corners = assembly.block_vertices(block)
    room = CORNER * float(assembly.size[block])
    for face in assembly.faces_of(block):
        tail, line = corners[face], corners[np.roll(face, -1)] - corners[face]
        length = np.linalg.norm(line, axis=1)
        unit = line / length[:, None]
        along = np.einsum("ij,ij->i", point - tail, unit)
        off = np.linalg.norm(point - tail - along[:, None] * unit, axis=1)
        fits = (off <= room) & (along >= -room) & (along <= length + room) & (np.abs(unit @ normal) <= FLAT)
        if fits.any():
            found: Floats = unit[np.argmax(fits)]
            return found
    return np.zeros(3)


def crossings(contacts: Contacts, pose: Pose, both: Floats) -> tuple[Floats, Floats]:
    """Return where crossing sides are nearest to each other, and the direction across both.

    Parameters
    ----------
    contacts
        The pairs.
    pose
        The pose.
    both
        Points of the two sides, shape (n, 2, 3) [m], as `sides` gives them.

    Returns
    -------
    place : Floats
        The points of the two sides, shape (n, 2, 3) [m]; those given where no sides cross.
    across : Floats
        Unit vector from a to b, shape (n, 3); not a number where no sides cross.
    """
    one, two = (np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, k]], contacts.edge[:, k]) for k in (0, 1))
    across = np.cross(one, two)
    size = np.linalg.norm(across, axis=1)
    crossing = size > FLAT
    across[~crossing] = np.nan
    across /= np.where(crossing, size, 1.0)[:, None]
    of_a = np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, 0]], contacts.normal)
    across *= np.where(np.einsum("ni,ni->n", across, of_a) < 0, -1.0, 1.0)[:, None]
    place, apart = both.copy(), both[:, 1] - both[:, 0]
    for k in np.flatnonzero(crossing):
        step = np.linalg.lstsq(np.stack([one[k], -two[k]], axis=1), apart[k], rcond=None)[0]
        place[k, 0] += step[0] * one[k]
        place[k, 1] += step[1] * two[k]
    return place, across


def sides(assembly: Assembly, contacts: Contacts, pose: Pose, parameter: float) -> Floats:
    """Return where the two points of each pair are.

    Parameters
    ----------
    assembly
        The blocks at rest.
    contacts
        The pairs.
    pose
        The pose.
    parameter
        The movement of the supports.

    Returns
    -------
    Floats
        Shape (n, 2, 3) [m].
    """
    own = [places(assembly, pose, contacts.pair[:, side], contacts.anchor[:, side]) for side in (0, 1)]
    both: Floats = np.stack(own, axis=1) + parameter * contacts.drive
    return both


def roles(contacts: Contacts, pose: Pose, both: Floats) -> tuple[Floats, np.ndarray]:
    """Return the normals that the gap of each pair is measured along.

    Parameters
    ----------
    contacts
        The pairs.
    pose
        The pose.
    both
        Where the points of the pairs are, shape (n, 2, 3) [m].

    Returns
    -------
    normal : Floats
        That of b, that of a and that across crossing sides, shape (n, 3, 3).
    valid : array of bool, shape (n, 3)
        Which of them count.
    """
    of_a, of_b = (np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, k]], contacts.normal) for k in (0, 1))
    none = ~contacts.corner.any(axis=1)
    third = of_a.copy()
    if none.any():
        mean = of_a + of_b
        third = mean / np.linalg.norm(mean, axis=1)[:, None]
        _, across = crossings(contacts, pose, both)
        third = np.where(np.isnan(across), third, across)
    return np.stack([of_b, of_a, third], axis=1), np.column_stack([contacts.corner, none])


def gaps(assembly: Assembly, contacts: Contacts, pose: Pose, parameter: float) -> Floats:
    """Return the gap of each pair, the smaller one where both blocks have a corner.

    Parameters
    ----------
    assembly, contacts, pose, parameter
        As in `sides`.

    Returns
    -------
    Floats
        Shape (n,) [m], negative where the blocks overlap.
    """
    both = sides(assembly, contacts, pose, parameter)
    normal, valid = roles(contacts, pose, both)
    gap = np.einsum("nij,nj->ni", normal, both[:, 1] - both[:, 0])
    least: Floats = np.where(valid, gap, np.inf).min(axis=1)
    return least


def closed_again(assembly: Assembly, contacts: Contacts, rows: Ints, pose: Pose, parameter: float) -> Contacts:
    """Return the contacts with the points of some pairs brought to one place again, where they have met.

    Parameters
    ----------
    assembly, contacts, pose, parameter
        As in `sides`.
    rows
        The pairs, shape (k,).

    Returns
    -------
    Contacts
        The point of the block that has a corner there stays; that of the other is where it is.
    """
    both = sides(assembly, contacts, pose, parameter)[rows]
    own = contacts.corner[rows]
    meeting = np.where(own[:, :1] & ~own[:, 1:], both[:, 0], np.where(own[:, 1:] & ~own[:, :1], both[:, 1], 0.0))
    alike = own[:, 0] == own[:, 1]
    meeting[alike] = both[alike].mean(axis=1)
    anchor = contacts.anchor.copy()
    for side in (0, 1):
        place = meeting - parameter * contacts.drive[rows, side]
        anchor[rows, side] = origins(assembly, pose, contacts.pair[rows, side], place)
    return replace(contacts, anchor=anchor)


def displaced_interfaces(
    assembly: Assembly,
    interfaces: Interfaces,
    contacts: Contacts,
    closed: np.ndarray,
    pose: Pose,
    parameter: float,
) -> tuple[Interfaces, Ints]:
    """Return the joints at a pose: the contact points that are closed, each with the normals that are its own.

    Parameters
    ----------
    assembly
        The blocks at rest.
    interfaces
        Their joints at rest.
    contacts
        The pairs of points.
    closed
        Which of them touch, shape (n,) bool.
    pose, parameter
        As in `sides`.

    Returns
    -------
    interfaces : Interfaces
        A joint that has stayed shut is one interface with its area. One that has opened has none, and gives one
        interface for the corners of each block that still touch the other.
    contact : Ints
        The pair that each of their points stands for, shape (n_points,).
    """
    both = sides(assembly, contacts, pose, parameter)
    middle = crossings(contacts, pose, both)[0].mean(axis=1)
    a, b = interfaces.pair.T
    turn = np.abs(pose.rotation[a] - pose.rotation[b]).max(axis=(1, 2))
    count = np.bincount(contacts.joint, minlength=interfaces.n_interfaces)
    still = np.bincount(contacts.joint[closed], minlength=interfaces.n_interfaces)
    shut = (still == count) & (turn <= UNTURNED)
    normal, valid = roles(contacts, pose, both)
    # 0: that of b, for corners of a. 1: that of a, for corners of b. 2: across sides. 3: that of a, of shut joints.
    normal = np.concatenate([normal, normal[:, 1:2]], axis=1)
    wanted = np.column_stack([valid & ~shut[contacts.joint][:, None], shut[contacts.joint]]) & closed[:, None]
    point, role = np.nonzero(wanted)
    alone = np.where(role == 2, point, -1)  # crossings have normals of their own
    order = np.lexsort((alone, role, contacts.joint[point]))
    point, role, alone = point[order], role[order], alone[order]
    key = np.column_stack([contacts.joint[point], role, alone])
    start = np.flatnonzero(np.append(True, (np.diff(key, axis=0) != 0).any(axis=1))) if len(point) else np.empty(0, int)
    first = point[start]
    joint, whole = contacts.joint[first], role[start] == 3
    along = np.einsum("nij,nj->ni", pose.rotation[interfaces.pair[joint, 0]], interfaces.frame[joint, 1])
    share = None
    if interfaces.share is not None and whole.all():
        share = interfaces.share[point]
    return Interfaces(
        pair=interfaces.pair[joint],
        frame=_frames(normal[first, role[start]], along),
        area=np.where(whole, interfaces.area[joint], 0.0),
        gap=np.zeros(len(joint)),
        point=np.where((role < 2)[:, None], both[point, np.minimum(role, 1)], middle[point]),
        start=np.append(start, len(point)),
        share=share,
    ), point


def _frames(n: Floats, along: Floats) -> Floats:
    """Right-handed frames with normals n and first tangents near the given ones."""
    t: Floats = along - np.einsum("ni,ni->n", along, n)[:, None] * n
    t = t / np.linalg.norm(t, axis=1)[:, None]
    frame: Floats = np.stack([n, t, np.cross(n, t)], axis=1)
    return frame
