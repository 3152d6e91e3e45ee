"""Joints that statics count as closed are closed in Bullet too.

Statics take faces for one joint that are apart, or overlap, by up to a tolerance (`blockstat.contact.interfaces.GAP`).
Bullet takes the shapes as they are: blocks fall until they touch, and sixty courses with gaps of 2 mm fall by 120 mm.
One rule serves both: Bullet gets the blocks with the corners of their joints moved into common planes, as
`blockstat.repair` moves them. Each joint is closed in its own place, halfway between its faces, where the contact
points of the statics lie. So nothing adds up from course to course, and a corner moves by about half a gap.

Joints of faces that do not match, such as those of curved vaults that were cut differently on their two sides, cannot
be closed so. Where each block is still held by some chain of joints that does close, the blocks are simulated as drawn,
and the verdict says so. Elsewhere the motion would be that of the gaps, and the run is refused.

Blocks that overlap by more than such a tolerance have no joint in statics, and Bullet would throw them apart. They are
cut by the plane halfway through the overlap, and the verdict says so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.contact.overlap.penetration import overlaps
from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.geometry_repair.repair import close_joints
from blockstat.geometry_repair.trimming import trim_overlaps
from blockstat.loads import up_of
from blockstat.program.given_joints import check_given
from blockstat.typing import Floats
from dynsim.judge.criteria import default_threshold
from dynsim.judge.stages import joints_to_furthest_block

#: Sound assemblies settle by less than this part of the default threshold: gaps that move blocks by less do not matter.
SHARE = 0.1
#: Gaps and cosines below this, relative to the size of the block, are rounding.
ROUNDING = 1e-9
#: A block that is cut becomes convex, and may then overlap another one: cut again, at most this many times in all.
PASSES = 4


@dataclass(frozen=True)
class ClosedScene:
    """The blocks as Bullet gets them."""

    assembly: Assembly  #: the given one where nothing had to move; masses are as given
    interfaces: Interfaces  #: those of the statics; gaps that were closed are 0
    closed: int = 0  #: joints that were closed
    moved: float = 0.0  #: the furthest that a corner was moved [m]
    left: int = 0  #: joints that are simulated as drawn although their faces do not meet
    misfit: float = 0.0  #: the largest gap or overlap of those [m]
    trimmed: int = 0  #: blocks that were cut where they overlap others
    cut: float = 0.0  #: the furthest that one was cut back [m]

    @property
    def warnings(self) -> list[str]:
        """What a verdict must say."""
        told = []
        if self.trimmed:
            told.append(
                f"{self.trimmed} blocks overlapped others by more than a joint; for Bullet they were cut back by up to "
                f"{1e3 * self.cut:.2g} mm, to the plane halfway through each overlap"
            )
        if self.closed:
            told.append(
                f"{self.closed} joints that statics count as closed were open or overlapped; they were closed for "
                f"Bullet by moving corners by up to {1e3 * self.moved:.2g} mm, as `blockstat repair` does"
            )
        if self.left:
            told.append(
                f"{self.left} joints that statics count as closed were simulated as drawn: their faces are off by up "
                f"to {1e3 * self.misfit:.2g} mm and do not match"
            )
        return told


def closed_scene(assembly: Assembly, interfaces: Interfaces) -> ClosedScene:
    """Return the blocks with the joints closed that statics count as closed.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    ClosedScene
        The assembly itself where no gap matters.

    Raises
    ------
    InputError
        Naming two blocks, where blocks would fall by a tenth of the threshold or more until they touch, and moving
        corners does not prevent it, or where blocks overlap by so much that cutting them would make others of them.
        Also where blocks overlap and the interfaces have a friction of their own, and for interfaces that cannot be
        those of the blocks (`blockstat.program.given_joints`).

    Notes
    -----
    Gaps matter when a block falls by `SHARE` of the default threshold until joints hold it, or when one joint is open
    by that much. Then all are closed of which a chain, from a support to the furthest block, would move it so far.
    """
    check_given(assembly, interfaces)
    trimmed, cut = assembly, np.zeros(assembly.n_blocks)
    for _ in range(PASSES):
        pairs, _ = overlaps(trimmed, gap=interfaces.searched)
        if not len(pairs):
            break
        trimmed, further = trim_overlaps(trimmed, pairs, gap=interfaces.searched)
        cut = np.maximum(cut, further)
    else:
        if len(pairs := overlaps(trimmed, gap=interfaces.searched)[0]):
            one, two = (assembly.names[block] for block in pairs[0])
            raise InputError(
                f'"{assembly.name}": blocks "{one}" and "{two}" still overlap after {PASSES} rounds of cuts for '
                "Bullet; draw blocks that only touch"
            )
    if not cut.any():
        return _joined(assembly, interfaces)
    if interfaces.friction is not None:
        raise InputError(
            f'"{assembly.name}": blocks overlap by more than a joint and are cut for Bullet, so the friction of its '
            "interfaces is lost; give it by joint laws, or draw blocks that only touch"
        )
    scene = _joined(trimmed, find_interfaces(trimmed, gap=interfaces.searched))
    return replace(scene, trimmed=int((cut > 0).sum()), cut=float(cut.max()), moved=max(scene.moved, float(cut.max())))


def _joined(assembly: Assembly, interfaces: Interfaces) -> ClosedScene:
    """The blocks with closed joints where none overlap by more than a joint."""
    least = SHARE * default_threshold(assembly)
    opening = _openings(interfaces)
    own = opening.max(initial=0.0)
    drawn = _drop(assembly, interfaces, opening).max()
    if max(drawn, own) <= least:
        return ClosedScene(assembly, interfaces)
    tolerance = least / max(joints_to_furthest_block(assembly, interfaces), 1)
    # A joint of the chain that lets a block fall so far lets it fall by no more than that.
    fall = opening / np.maximum(_cosine(assembly, interfaces), ROUNDING)
    loose = (opening > tolerance) | ((fall > tolerance) & (fall <= drawn))
    closed = _closed(assembly, interfaces)
    moved = float(np.linalg.norm(closed.vertices - assembly.vertices, axis=1).max())
    # A patch that is narrower than the corners moved may vanish: the sliver of a brick on the next but one.
    gap, lost = _gaps_after(closed, interfaces)
    open_still = (opening > 0) & (gap > tolerance) & ~(lost & (_width(interfaces) <= 2 * moved))
    drop = _drop(assembly, interfaces, gap, thrust=True)
    falls = bool(drop.max() > least)
    # All or nothing: blocks of which some were moved and some were not meet worse than blocks as drawn.
    if (open_still.any() or falls) and _drop(assembly, interfaces, opening, thrust=True).max() <= least:
        return ClosedScene(assembly, interfaces, left=int(loose.sum()), misfit=float(own))
    if falls:
        raise InputError(_refusal(assembly, interfaces, open_still if open_still.any() else lost, drop))
    mended = loose & ~open_still
    return ClosedScene(
        closed.with_(density=assembly.density * assembly.volume / closed.volume),
        replace(interfaces, gap=np.where(mended, 0.0, interfaces.gap)),
        closed=int(mended.sum()),
        moved=moved,
        left=int(open_still.sum()),
        misfit=float(interfaces.gap[open_still].max(initial=0.0)),
    )


def _closed(assembly: Assembly, interfaces: Interfaces) -> Assembly:
    """The assembly with closed joints: those up to the widest that was taken, as a share of the smaller block.

    Where the default gap was asked for, these are all up to the default.
    """
    size = assembly.size[interfaces.pair].min(axis=1)
    least = GAP if interfaces.searched == GAP else 0.0
    return close_joints(assembly, max(least, float((interfaces.gap / size).max(initial=0.0))))[0]


def _gaps_after(closed: Assembly, interfaces: Interfaces) -> tuple[Floats, np.ndarray]:
    """Gap of each joint on the moved blocks [m]; inf, and True, where its two blocks have no joint any more."""
    found = find_interfaces(closed)
    pairs, row = np.unique(np.concatenate([interfaces.pair, found.pair]), axis=0, return_inverse=True)
    row = row.reshape(-1)
    worst = np.full(len(pairs), -1.0)
    np.maximum.at(worst, row[interfaces.n_interfaces :], found.gap)
    gap = worst[row[: interfaces.n_interfaces]]
    return np.where(gap < 0, np.inf, gap), gap < 0


def _openings(interfaces: Interfaces) -> Floats:
    """Gap of each joint [m]; 0 for edges and corners of blocks that have a face in common, which holds them apart."""
    if interfaces.kind is None:
        return interfaces.gap
    face = interfaces.area > 0
    code = interfaces.pair @ (int(interfaces.pair.max(initial=0)) + 1, 1)
    return np.where(face | ~np.isin(code, code[face]), interfaces.gap, 0.0)


def _width(interfaces: Interfaces) -> Floats:
    """Area of each joint over its longest extent along an axis [m]; 0 for edges and corners."""
    first = interfaces.start[:-1]
    low, high = np.minimum.reduceat(interfaces.point, first), np.maximum.reduceat(interfaces.point, first)
    return interfaces.area / np.maximum((high - low).max(axis=1), np.sqrt(interfaces.area) + 1e-300)


def _drop(assembly: Assembly, interfaces: Interfaces, gap: Floats, *, thrust: bool = False) -> Floats:
    """How far each block falls at least until a chain of joints holds it, shape (n_blocks,) [m].

    A block falls by gap / cos(angle between normal and gravity) until a joint closes, so joints along gravity hold
    nothing. With thrust they do, and a block falls by no less than the gap. Blocks that no such joint reaches have 0,
    and those that only lost joints reach, whose gap is infinite, have inf.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import dijkstra

    cosine = np.ones(len(gap)) if thrust else _cosine(assembly, interfaces)
    rounding = ROUNDING * assembly.size[interfaces.pair].min(axis=1)
    fall = np.where(gap > rounding, gap, 0.0) / np.maximum(cosine, ROUNDING) + rounding * 1e-3
    rows = np.flatnonzero(cosine > ROUNDING)
    rows = rows[np.argsort(fall[rows], kind="stable")]
    pair, first = np.unique(interfaces.pair[rows], axis=0, return_index=True)
    n = assembly.n_blocks
    graph = sparse.coo_array((fall[rows][first], (pair[:, 0], pair[:, 1])), shape=(n, n)).tocsr()
    far = dijkstra(graph, directed=False, indices=np.flatnonzero(assembly.support), min_only=True)
    _, part = connected_components(n, pair)
    return np.where(np.isin(part, part[assembly.support]), far, 0.0)


def _cosine(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Cosine of the angle between each joint's normal and gravity, shape (n_interfaces,)."""
    return np.abs(interfaces.frame[:, 0] @ up_of(assembly))


def _refusal(assembly: Assembly, interfaces: Interfaces, at_fault: np.ndarray, drop: Floats) -> str:
    worst = int(np.argmax(np.where(at_fault, interfaces.gap, -1.0)))
    a, b = (assembly.names[block] for block in interfaces.pair[worst])
    first = int(np.argmax(drop))
    far = f"blocks would fall by {1e3 * drop[first]:.2g} mm until they touch"
    if np.isinf(drop[first]):
        far = f'nothing would hold "{assembly.names[first]}"'
    return (
        f'blocks "{a}" and "{b}" do not meet at their joint: faces are off by {1e3 * interfaces.gap[worst]:.2g} mm, '
        f"statics count it as closed, and moving corners does not close it. In Bullet {far}; draw them so that they "
        "touch (`blockstat repair` says what it leaves open)"
    )
