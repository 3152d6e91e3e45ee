"""Contact points of the joints at rest as pairs of material points, one on each block.

At rest the two points of a pair coincide. One of the blocks has a corner there, or both have. A corner of block a
stays above the face of block b, and a corner of b above the face of a:

    gap = n_b . (p_b - p_a)  for a corner of a,      gap = n_a . (p_b - p_a)  for a corner of b.

Here p_a and p_b are the displaced points, and n_a and n_b are the joint's normal, which points from a to b, rotated
with block a and with block b. Where edges of the two faces cross, neither block has a corner. The normal is then
perpendicular to both edges, and the contact point is where they cross.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.contact.point_law import joint_friction
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, points_at_rest, side_sizes
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A contact point within this distance of a corner of a block is that corner. Relative to the block's size, and for a
#: support to that of the block on it. Chosen: far above the rounding of coordinates and far below any dimension of a
#: block.
CORNER_TOLERANCE = 1e-6
#: Two directions are parallel when the sine of their angle is below this. An edge lies in a joint when the sine of its
#: angle with the joint's plane is below this. Chosen: below it a crossing of two edges is ill-conditioned.
PARALLEL_SINE = 1e-4
#: Corners that a joint keeps at least, and a number that stands in for a length of zero where it is divided by.
LEAST_CORNERS, TINY = 3, 1e-300
#: A gap below this is zero. Relative to the largest free block. Chosen: a thousand times the residual of a pose.
ZERO_GAP = 1e-9
#: A contact whose gap is below this has closed at a pose that was located by root finding. Relative to the largest
#: free block. Chosen: ten times `ZERO_GAP`, so that contacts that close together are found together.
JUST_CLOSED_GAP = 10 * ZERO_GAP


@dataclass(frozen=True, eq=False)
class ContactPairs:
    """Pairs of material points, one pair for each contact point of the joints."""

    joint: Ints  #: number of the interface, shape (n,)
    pair: Ints  #: blocks a and b, shape (n, 2)
    anchor: Floats  #: positions at rest of the points of a and b, shape (n, 2, 3) [m]
    corner: np.ndarray  #: whether the point is a corner of a, and of b, shape (n, 2) bool
    normal: Floats  #: unit normal of the joint at rest, from a to b, shape (n, 3)
    friction: Floats  #: coefficient of friction, shape (n,)
    area: Floats  #: part of the contact area of the joint that the point stands for, shape (n,) [m2]
    #: displacement of the points of a and b by a unit movement of the supports, beside that of their blocks; zero where
    #: the block is not a moving support, shape (n, 2, 3)
    drive: Floats
    #: unit vectors at rest along the crossing edges of a and b where neither has a corner, zero elsewhere,
    #: shape (n, 2, 3)
    edge: Floats

    @property
    def number(self) -> int:
        """The number of contact points."""
        return len(self.joint)

    def select(self, rows: Ints) -> ContactPairs:
        """Return some of the pairs.

        Parameters
        ----------
        rows
            Numbers of the pairs, shape (k,).

        Returns
        -------
        ContactPairs
            In the order of `rows`.
        """
        return ContactPairs(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def concatenate(parts: Sequence[ContactPairs]) -> ContactPairs:
    """Return several sets of pairs as one.

    Parameters
    ----------
    parts
        The sets.

    Returns
    -------
    ContactPairs
        In the order of `parts`.
    """
    names = [field.name for field in fields(ContactPairs)]
    return ContactPairs(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


def pairs_at_rest(assembly: Assembly, interfaces: Interfaces, *, straight: float = 0.0) -> ContactPairs:
    """Return the contact points of an assembly at rest as pairs.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    straight
        A corner of a joint that is this near to the line between its neighbours is none, and a point this near to a
        corner of a block is that corner [m]. Where two faces whose corners are slightly off are clipped against each
        other, an edge of the joint has several corners, and they are not quite those of the blocks.

    Returns
    -------
    ContactPairs
        In the order of `interfaces.point`. The area of a corner that is none goes to its neighbours, so that its
        centroid stays.
    """
    joint = interfaces.point_interface
    pair = interfaces.pair[joint]
    within = CORNER_TOLERANCE * side_sizes(assembly, pair) + straight
    normal, edge = interfaces.frame[joint, 0], np.zeros((len(joint), 2, 3))
    shapes = [_Near(within[:, side], interfaces.gap[joint], normal) for side in (0, 1)]
    corner = np.stack([_is_corner(assembly, pair[:, k], interfaces.point, shapes[k]) for k in (0, 1)], axis=1)
    for row in np.flatnonzero(~corner.any(axis=1)):
        for side in (0, 1):
            edge[row, side] = _edge_through(
                assembly, int(pair[row, side]), interfaces.point[row], shapes[side].of(np.array([row]))
            )
    kept, share = _straightened(interfaces, straight)
    pairs = ContactPairs(
        joint=joint,
        pair=pair,
        anchor=np.repeat(interfaces.point[:, None], 2, axis=1),
        corner=corner,
        edge=edge,
        normal=normal,
        friction=joint_friction(assembly, interfaces)[joint],
        area=share * interfaces.area[joint],
        drive=np.zeros((len(joint), 2, 3)),
    )
    return pairs if kept.all() else pairs.select(np.flatnonzero(kept))


def _straightened(interfaces: Interfaces, straight: float) -> tuple[np.ndarray, Floats]:
    """Which points of joints are corners to a tolerance, and the part of the area that each stands for, (n_points,)."""
    kept, share = np.ones(interfaces.n_points, dtype=bool), interfaces.point_share.copy()
    if interfaces.outlines is not None:  # the points are not the corners
        return kept, share
    for joint in np.flatnonzero(np.diff(interfaces.start) > LEAST_CORNERS):
        own = np.arange(interfaces.start[joint], interfaces.start[joint + 1])
        while len(own) > LEAST_CORNERS:
            before, here, after = (np.roll(interfaces.point[own], shift, axis=0) for shift in (1, 0, -1))
            line = after - before
            along = ((here - before) * line).sum(axis=1) / np.maximum((line**2).sum(axis=1), TINY)
            along = np.clip(along, 0.0, 1.0)
            off = np.linalg.norm(here - before - along[:, None] * line, axis=1)
            least = int(off.argmin())
            if off[least] > straight:
                break
            gone, neighbours = own[least], (own[least - 1], own[(least + 1) % len(own)])
            for neighbour, part in zip(neighbours, (1.0 - along[least], along[least]), strict=True):
                share[neighbour] += part * share[gone]
            kept[gone], own = False, np.delete(own, least)
    return kept, share


class _Near(NamedTuple):
    """How near to points of joints what they are on is.

    A point is in the middle of the gap of its joint, so that along the normal what touches there is away from it.
    """

    within: Floats  #: shape (n,) [m]
    gap: Floats  #: of the joints at rest, shape (n,) [m]
    normal: Floats  #: of the joints, shape (n, 3)

    def of(self, rows: Ints) -> _Near:
        """Return what is near to some of the points."""
        return _Near(self.within[rows], self.gap[rows], self.normal[rows])

    def holds(self, arm: Floats) -> np.ndarray:
        """Whether arms from the points are short enough, shape (n, k, 3) [m]."""
        height = np.einsum("nki,ni->nk", arm, self.normal)
        beside = np.linalg.norm(arm - height[..., None] * self.normal[:, None], axis=2)
        above = np.maximum(np.abs(height) - self.gap[:, None], 0.0)
        short: np.ndarray = np.hypot(beside, above) <= self.within[:, None]
        return short


def _is_corner(assembly: Assembly, block: Ints, point: Floats, near: _Near) -> np.ndarray:
    """Whether points are corners of their blocks; block (n,), point (n, 3) [m]."""
    found = np.zeros(len(block), dtype=bool)
    for index in np.unique(block):
        own = np.flatnonzero(block == index)
        arm = point[own, None] - assembly.block_vertices(int(index))
        found[own] = near.of(own).holds(arm).any(axis=1)
    return found


def _edge_through(assembly: Assembly, block: int, point: Floats, near: _Near) -> Floats:
    """Unit vector along the edge of a block through a point, in the plane of the joint; zero where there is none."""
    corners, normal, tolerance = assembly.block_vertices(block), near.normal[0], float(near.within[0])
    for face in assembly.faces_of(block):
        tail, line = corners[face], corners[np.roll(face, -1)] - corners[face]
        length = np.linalg.norm(line, axis=1)
        unit = line / length[:, None]
        along = np.einsum("ij,ij->i", point - tail, unit)
        off = near.holds((point - tail - along[:, None] * unit)[None])[0]
        # Over its length an edge may come as near to one face as it is far from it elsewhere.
        in_plane = np.abs(unit @ normal) <= PARALLEL_SINE + 2.0 * near.gap[0] / length
        fits = off & (along >= -tolerance) & (along <= length + tolerance) & in_plane
        if fits.any():
            found: Floats = unit[np.argmax(fits)]
            return found
    return np.zeros(3)


def pair_points(assembly: Assembly, contacts: ContactPairs, pose: Pose, parameter: float) -> Floats:
    """Return the displaced positions of the two points of each pair.

    Parameters
    ----------
    assembly
        The blocks at rest.
    contacts
        The pairs.
    pose
        The pose.
    parameter
        Movement of the supports [m]; it counts where `contacts.drive` is not zero.

    Returns
    -------
    Floats
        Shape (n, 2, 3) [m].
    """
    own = displaced_points(assembly, pose, contacts.pair.reshape(-1), contacts.anchor.reshape(-1, 3))
    return own.reshape(-1, 2, 3) + parameter * contacts.drive


def edge_crossings(contacts: ContactPairs, pose: Pose, points: Floats) -> tuple[Floats, Floats]:
    """Return the nearest points of crossing edges, and the direction perpendicular to both edges.

    Parameters
    ----------
    contacts
        The pairs.
    pose
        The pose.
    points
        Displaced points of the pairs, shape (n, 2, 3) [m], as `pair_points` gives them.

    Returns
    -------
    nearest : Floats
        A point on each of the two edges, shape (n, 2, 3) [m]; the given points where no edges cross.
    across : Floats
        Unit vector from a to b, shape (n, 3); nan where no edges cross.
    """
    one, two = (np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, k]], contacts.edge[:, k]) for k in (0, 1))
    normal = np.cross(one, two)
    across, sine = normal.copy(), np.linalg.norm(normal, axis=1)
    crossing = sine > PARALLEL_SINE
    across[~crossing] = np.nan
    across /= np.where(crossing, sine, 1.0)[:, None]
    normal_of_a = np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, 0]], contacts.normal)
    across *= np.where(np.einsum("ni,ni->n", across, normal_of_a) < 0, -1.0, 1.0)[:, None]
    nearest, apart = points.copy(), points[:, 1] - points[:, 0]
    # Moved along their edges, the two points are apart along `across` alone.
    for side, (own, other) in enumerate(((one, two), (two, one))):
        step = np.einsum("ni,ni->n", np.cross(apart, other), normal) / np.where(crossing, sine, 1.0) ** 2
        nearest[:, side] += np.where(crossing, step, 0.0)[:, None] * own
    return nearest, across


def gap_normals(contacts: ContactPairs, pose: Pose, points: Floats) -> tuple[Floats, np.ndarray]:
    """Return the normals along which the gaps of each pair are measured.

    Parameters
    ----------
    contacts
        The pairs.
    pose
        The pose.
    points
        Displaced points of the pairs, shape (n, 2, 3) [m].

    Returns
    -------
    normal : Floats
        Unit normal of b (for corners of a), of a (for corners of b) and across crossing edges, shape (n, 3, 3).
    valid : array of bool, shape (n, 3)
        Which of the three define a gap.
    """
    of_a, of_b = (np.einsum("nij,nj->ni", pose.rotation[contacts.pair[:, k]], contacts.normal) for k in (0, 1))
    no_corner = ~contacts.corner.any(axis=1)
    third = of_a.copy()
    if no_corner.any():
        mean = of_a + of_b
        third = mean / np.linalg.norm(mean, axis=1)[:, None]
        _, across = edge_crossings(contacts, pose, points)
        third = np.where(np.isnan(across), third, across)
    return np.stack([of_b, of_a, third], axis=1), np.column_stack([contacts.corner, no_corner])


def gaps(assembly: Assembly, contacts: ContactPairs, pose: Pose, parameter: float) -> Floats:
    """Return the gap of each pair; the smaller one where both blocks have a corner.

    Parameters
    ----------
    assembly, contacts, pose, parameter
        As in `pair_points`.

    Returns
    -------
    Floats
        Shape (n,) [m]; negative where the blocks overlap.
    """
    points = pair_points(assembly, contacts, pose, parameter)
    normal, valid = gap_normals(contacts, pose, points)
    gap = np.einsum("nij,nj->ni", normal, points[:, 1] - points[:, 0])
    least: Floats = np.where(valid, gap, np.inf).min(axis=1)
    return least


def rejoined(assembly: Assembly, contacts: ContactPairs, rows: Ints, pose: Pose, parameter: float) -> ContactPairs:
    """Return the contacts with new material points in pairs that have closed, so that both points coincide again.

    Parameters
    ----------
    assembly, contacts, pose, parameter
        As in `pair_points`.
    rows
        The pairs that have closed, shape (k,).

    Returns
    -------
    ContactPairs
        Where only one block has a corner, its point stays and the other block takes the same place for its point.
        Where both have one, both take the middle, and where edges cross, the place where they do.
    """
    points = pair_points(assembly, contacts, pose, parameter)
    points = edge_crossings(contacts, pose, points)[0][rows]
    own = contacts.corner[rows]
    meeting = np.where(own[:, :1] & ~own[:, 1:], points[:, 0], np.where(own[:, 1:] & ~own[:, :1], points[:, 1], 0.0))
    alike = own[:, 0] == own[:, 1]
    meeting[alike] = points[alike].mean(axis=1)
    anchor = contacts.anchor.copy()
    for side in (0, 1):
        place = meeting - parameter * contacts.drive[rows, side]
        anchor[rows, side] = points_at_rest(assembly, pose, contacts.pair[rows, side], place)
    return replace(contacts, anchor=anchor)
