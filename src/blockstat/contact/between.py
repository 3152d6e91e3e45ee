"""Joints that other blocks hold open: a sheet, pads or a membrane between two blocks.

A joint whose faces are some millimetres apart counts as closed, because real meshes close no better. It is no joint
where another block stands in the gap: then the gap is real, and the force goes through that block. The rule is one of
load paths. A chain of blocks leads from one face to the other if each touches the next along the normal of the joint,
within the outline of the patch and within the height of the gap. A neighbour beside the joint is not in the gap: where
it touches both blocks, it does so across another normal, or beside the patch. Two rigid blocks that are held apart at
one place are so all over the plane of the gap, wherever it is about as wide: however their faces are divided.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.coplanar import Patches
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Gaps up to this fraction of the smaller block are rounding of coordinates, into which no block fits.
ROUNDING = 1e-9
#: What reaches over a patch by less than this fraction of the smaller block lies beside it.
BESIDE = 1e-6
#: So does a joint whose strip over the patch is narrower than this and the smaller part of both: the feather edge of a
#: neighbour that is drawn some micrometres too long carries nothing. A wire in the gap is no such strip, however thin:
#: all of its joint lies there.
STRIP = 1e-3
#: Blocks that are held apart do meet where they are less open than this fraction of the gap: an order of magnitude
#: tells a gap that closes from one that is as wide as what stands in it.
CLOSING = 0.1


def held_apart(assembly: Assembly, joints: Patches, asked: Patches, angle: float) -> np.ndarray:
    """Return which patches are held open by other blocks in their gap.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    joints : Patches
        All joints of the blocks; those that are asked about may be among them.
    asked : Patches
        The patches to look at. Segments of two corners and points are patches, too.
    angle : float
        Normals that differ by less are along one another [rad].

    Returns
    -------
    array of bool, shape (n_asked,)
        True where a chain of joints leads from one side of the gap to the other through other blocks in it, and for
        what is as open in the plane of such a gap.
    """
    held = np.zeros(len(asked.pair), dtype=bool)
    open_ = np.flatnonzero(asked.gap > rounded_gap(assembly, asked.pair))
    if len(open_) and len(joints.pair):
        graph = _graph(assembly, joints)
        for k in _candidates(graph, asked, open_, np.cos(angle)):
            held[k] = _leads_across(graph, asked, int(k), np.cos(angle))
    if held.any() and not held[open_].all():
        rest = open_[~held[open_]]
        held[rest] = in_gaps(assembly, asked.take(rest), asked.take(np.flatnonzero(held)), angle)
    return held


def in_gaps(assembly: Assembly, asked: Patches, held: Patches, angle: float) -> np.ndarray:
    """Return which patches are part of a gap that is held open elsewhere between the same two blocks.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    asked : Patches
        The patches to look at; also edges and corners.
    held : Patches
        Patches that other blocks hold open.
    angle : float
        Normals that differ by less are along one another [rad].

    Returns
    -------
    array of bool, shape (n_asked,)
        True for those in the plane of a patch that is held open which are about as open as it is.
    """
    own, theirs = (patches.pair @ [assembly.n_blocks, 1] for patches in (asked, held))
    order = np.argsort(theirs, kind="stable")
    first, last = (np.searchsorted(theirs[order], own, side=side) for side in ("left", "right"))
    row, place = members(first, last - first)
    k = order[place]
    normal = held.frame[k, 0]
    along = np.einsum("ij,ij->i", asked.frame[row, 0], normal) > np.cos(angle)
    # Both lie in the middle of their gap, so in one plane their heights differ by no more than the gaps.
    height = np.abs(np.einsum("ij,ij->i", asked.origin[row] - held.origin[k], normal))
    level = height <= asked.gap[row] + held.gap[k]
    open_ = asked.gap[row] > np.maximum(rounded_gap(assembly, asked.pair[row]), CLOSING * held.gap[k])
    found = np.zeros(len(own), dtype=bool)
    found[row[along & level & open_]] = True
    return found


def rounded_gap(assembly: Assembly, pair: Ints) -> Floats:
    """Return the largest gap of each pair of blocks that is rounding of coordinates.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pair : array of int, shape (n, 2)
        The pairs.

    Returns
    -------
    array of float, shape (n,)
        Lengths [m].
    """
    far = np.abs(assembly.vertices).max(initial=0.0)
    return np.maximum(ROUNDING * assembly.size[pair].min(axis=1), 8 * np.finfo(float).eps * far)


@dataclass(frozen=True)
class _Graph:
    """The joints of each block: block b has the places start[b] to start[b + 1]."""

    assembly: Assembly
    joints: Patches
    start: Ints
    joint: Ints  #: joint of each place
    other: Ints  #: the block on its other side
    normal: Floats  #: the normal of the joint, outwards from the block
    first: Ints  #: first corner of each joint


def _graph(assembly: Assembly, joints: Patches) -> _Graph:
    n = len(joints.pair)
    block = joints.pair.T.reshape(-1)
    order = np.argsort(block, kind="stable")
    joint = order % n
    return _Graph(
        assembly, joints,
        start=np.searchsorted(block[order], np.arange(assembly.n_blocks + 1)),
        joint=joint,
        other=joints.pair[:, ::-1].T.reshape(-1)[order],
        normal=joints.frame[joint, 0] * np.where(order < n, 1.0, -1.0)[:, None],
        first=np.cumsum(joints.count) - joints.count,
    )  # fmt: skip


def _sides(graph: _Graph, asked: Patches, rows: Ints) -> tuple[Ints, Ints, Floats]:
    """Where to begin, where to arrive, and the normal between them.

    Supports have no joints with each other, so a walk begins at a free block; of two, at that with fewer joints.
    """
    pair = asked.pair[rows]
    cost = np.diff(graph.start)[pair] + np.where(graph.assembly.support[pair], len(graph.joint) + 1, 0)
    side = (cost[:, 1] < cost[:, 0]).astype(int)
    k = np.arange(len(rows))
    return pair[k, side], pair[k, 1 - side], asked.frame[rows, 0] * np.where(side == 0, 1.0, -1.0)[:, None]


def _candidates(graph: _Graph, asked: Patches, rows: Ints, along: float) -> Ints:
    """The patches over which the block to begin at has another joint with the same normal."""
    begin, end, normal = _sides(graph, asked, rows)
    row, place = members(graph.start[begin], np.diff(graph.start)[begin])
    same = (np.einsum("ij,ij->i", graph.normal[place], normal[row]) > along) & (graph.other[place] != end[row])
    row, joint = row[same], graph.joint[place[same]]
    if not len(row):
        return rows[:0]
    reach = _reach(asked, rows[row], graph, joint)
    size = graph.assembly.size[asked.pair[rows[row]]].min(axis=1)
    area = np.minimum(asked.count[rows[row]], graph.joints.count[joint]) > 2
    return rows[np.unique(row[reach > np.where(area, BESIDE, -BESIDE) * size])]


def _reach(asked: Patches, k: Ints, graph: _Graph, joint: Ints) -> Floats:
    """How far the boxes of patches and of joints reach over each other in the planes of the patches [m]."""
    low, high = np.full((len(k), 2), -np.inf), np.full((len(k), 2), np.inf)
    for patches, number, first in (
        (asked, k, np.cumsum(asked.count) - asked.count),
        (graph.joints, joint, graph.first),
    ):
        count = patches.count[number]
        row, corner = members(first[number], count)
        space = np.einsum("nk,nkj->nj", patches.corner[corner], patches.frame[number[row], 1:])
        space += (patches.origin[number] - asked.origin[k])[row]
        flat = np.einsum("nij,nj->ni", asked.frame[k[row], 1:], space)
        start = np.cumsum(count) - count
        low = np.maximum(low, np.minimum.reduceat(flat, start))
        high = np.minimum(high, np.maximum.reduceat(flat, start))
    return (high - low).min(axis=1)


def _leads_across(graph: _Graph, asked: Patches, k: int, along: float) -> bool:
    """Whether a chain of joints leads through the gap of one patch."""
    begin, end, normal = (side[0] for side in _sides(graph, asked, np.array([k])))
    support = graph.assembly.support
    seen, waiting = {int(begin)}, [int(begin)]
    while waiting:
        block = waiting.pop()
        for place in range(graph.start[block], graph.start[block + 1]):
            joint, other = graph.joint[place], int(graph.other[place])
            if other in seen or (block == begin and other == end) or graph.normal[place] @ normal <= along:
                continue
            if not _in_gap(graph, asked, k, joint):
                continue
            # A sheet that cannot move needs no joint with the support below it.
            if other == end or (support[other] and support[end] and _thin(graph, asked, k, other)):
                return True
            seen.add(other)
            waiting.append(other)
    return False


def _in_gap(graph: _Graph, asked: Patches, k: int, joint: int) -> bool:
    """Whether a joint lies over a patch and at the height of its gap."""
    import shapely

    frame, joints = asked.frame[k], graph.joints
    first = int(asked.count[:k].sum())
    patch = _hull(asked.corner[first : first + asked.count[k]])
    first = graph.first[joint]
    corner = joints.corner[first : first + joints.count[joint]] @ joints.frame[joint, 1:]
    offset = joints.origin[joint] - asked.origin[k]
    other = _hull((corner + offset) @ frame[1:].T)
    size = graph.assembly.size[asked.pair[k]].min()
    common = shapely.intersection(patch, other)
    if min(asked.count[k], joints.count[joint]) > 2:
        if common.area <= BESIDE * size * np.sqrt(min(patch.area, other.area)):
            return False
        # Half the perimeter is the length of a strip.
        if common.area <= STRIP * size * common.length / 2 and 2 * common.area < min(patch.area, other.area):
            return False
    elif shapely.distance(patch, other) > BESIDE * size:
        return False
    middle = (patch if common.is_empty else common).centroid
    place = np.array([middle.x, middle.y]) @ frame[1:]
    normal = joints.frame[joint, 0]
    height = normal @ (offset - place) / (normal @ frame[0])
    return bool(abs(height) <= asked.gap[k] + joints.gap[joint])


def _thin(graph: _Graph, asked: Patches, k: int, block: int) -> bool:
    """Whether a block lies wholly at the height of the gap of a patch."""
    height = (graph.assembly.block_vertices(block) - asked.origin[k]) @ asked.frame[k, 0]
    return bool(np.abs(height).max() <= asked.gap[k])


def _hull(corners: Floats) -> Any:
    import shapely

    return shapely.MultiPoint(corners).convex_hull
