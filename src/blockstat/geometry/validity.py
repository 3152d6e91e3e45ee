"""Refuse blocks that are not closed, outward-facing solids, and say which block and face is wrong."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from blockstat.errors import InputError, InputWarning
from blockstat.geometry.components import connected_components
from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.polyhedron import Polyhedra, integrals, merged_vertices, next_in_face
from blockstat.geometry.self_overlap.depth import SelfOverlap, self_overlaps
from blockstat.geometry.triangulation import fans

#: A block whose mean thickness, volume over half its surface, is below this fraction of its box diagonal has no volume:
#: rounding of coordinates given to seven digits makes about 1e-7.
FLAT = 1e-7
#: Faces at an edge between which there is a smaller angle than this lie on each other [rad].
THIN = 1e-4
#: So many corners of a surface are asked whether they lie in another one.
PROBES = 9
#: How messages end about what a repair may do.
ADVICE = ", or let `blockstat repair` "
#: A corner this close to an edge, relative to the diagonal of its block's box, is on it: a repair puts it there.
ON_EDGE = 1e-4


def check_geometry(blocks: Polyhedra, names: Sequence[str]) -> None:
    """Check that every block is a closed solid whose faces look outwards and that does not overlap itself.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks. Vertices with exactly equal coordinates count as one.
    names : sequence of str
        Their names, for the message.

    Raises
    ------
    InputError
        For each block that is open, has an inverted face, has no volume, or overlaps itself by more than a hundredth of
        its size (see `blockstat.geometry.self_overlap.depth.self_overlaps`).

    Warns
    -----
    InputWarning
        For a block that is several solids, apart or touching.
    """
    merged = merged_vertices(blocks)
    _check_surface(blocks, names, merged)
    surface_of = _warn_of_several_solids(blocks, names, merged)
    lower, upper = blocks.bounds
    diagonal = np.linalg.norm(upper - lower, axis=1)
    surface = np.bincount(blocks.face_block, blocks.planes.area, blocks.n_blocks)
    flat = np.abs(blocks.volume) <= FLAT * diagonal * surface / 2
    wrong = [
        f'block "{names[block]}": its volume is {blocks.volume[block]:.3g} m3 over {diagonal[block]:.3g} m; it is flat'
        for block in np.flatnonzero(flat).tolist()
    ]
    wrong += [
        f'block "{names[block]}": all its faces point inwards; list their corners counter-clockwise seen from '
        f"outside{ADVICE}turn them"
        for block in np.flatnonzero(~flat & (blocks.volume < 0)).tolist()
    ]
    turned = [
        block
        for block, label in surface_of.items()
        if blocks.volume[block] > 0 and _has_solid_inside_out(blocks, block, label)
    ]
    wrong += [
        f'block "{names[block]}": one of its surfaces looks the wrong way; list corners counter-clockwise seen from '
        f"outside the stone{ADVICE}turn them"
        for block in turned
    ]
    tested = np.setdiff1d(np.flatnonzero(~flat & (blocks.volume > 0)), turned)
    wrong += [
        f'block "{names[own.block]}": {_self_overlap_fault(own, own.block in surface_of)}'
        for own in self_overlaps(blocks, merged, tested)
    ]
    if wrong:
        raise InputError(*wrong)


def without_advice(error: InputError) -> InputError:
    """Return an error of geometry as a repair itself tells it, without the advice to repair.

    Parameters
    ----------
    error : InputError
        Of `check_geometry`, perhaps among others.

    Returns
    -------
    InputError
        Of the same class.

    Examples
    --------
    >>> error = InputError("face 0 is inverted; turn it, or let `blockstat repair` turn it", "it is flat")
    >>> print(without_advice(error))
    face 0 is inverted; turn it
    it is flat
    """
    return type(error)(*(str(text).partition(ADVICE)[0] for text in error.args))


def _self_overlap_fault(found: SelfOverlap, several: bool) -> str:
    """What is wrong with a block that overlaps itself, where, and what to do."""
    where = "near ({:.6g}, {:.6g}, {:.6g})".format(*(found.centre + 0.0))
    if found.times < 0:
        return (
            f"its surface passes through itself and is inside out by {found.depth:.3g} m {where}; "
            "draw it without the crossing"
        )
    if several:
        return (
            f"its solids overlap by {found.depth:.3g} m {where}; "
            "join them with a boolean union, or give each a name of its own"
        )
    return (
        f"it overlaps itself by {found.depth:.3g} m {where}, where its surface goes round {found.times} times; "
        "draw it without the crossing"
    )


def _has_solid_inside_out(blocks: Polyhedra, block: int, label: np.ndarray) -> bool:
    """Whether a surface of a block looks inwards although it is no cavity, or outwards although it is one.

    `label` is the surface of each face. A cavity lies inside an odd number of other surfaces.
    """
    surfaces = _surfaces(blocks, block, label)

    def looks_the_wrong_way(k: int) -> bool:
        around = [own for number, (own, _, _) in enumerate(surfaces) if number != k]
        inside = [sum(contains(own, point) for own in around) % 2 for point in surfaces[k][1]]
        # Some corners of a cavity may lie on another surface, and solids of one block may overlap in part.
        return 2 * sum(inside) < len(inside) if surfaces[k][2] else sum(inside) == len(inside)

    return any(looks_the_wrong_way(k) for k in range(len(surfaces)))


def _surfaces(blocks: Polyhedra, block: int, label: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, bool]]:
    """Triangles of each surface of a block that has a volume, some of its corners, and whether it looks inwards."""
    faces = np.arange(*np.searchsorted(blocks.face_block, [block, block + 1]))
    surfaces = []
    for own in (faces[label == one] for one in np.unique(label)):
        corners = np.concatenate([blocks.face_vertices[slice(*blocks.face_start[f : f + 2])] for f in own])
        start = np.concatenate([[0], np.cumsum(blocks.face_start[own + 1] - blocks.face_start[own])])
        place = blocks.vertices[corners]
        volume = float(integrals(place, start, np.zeros(len(own), dtype=np.int64), 1).volume[0])
        if abs(volume) > FLAT * float(blocks.volume[block]):
            outwards = fans(place, start)[:, ::-1] if volume < 0 else fans(place, start)
            surfaces.append((outwards, place[:PROBES], volume < 0))
    return surfaces


def _check_surface(blocks: Polyhedra, names: Sequence[str], merged: np.ndarray) -> None:
    """Each edge must be walked as often one way as the other: twice one way is an inverted face, once alone a hole."""
    start = merged[blocks.face_vertices]
    end = start[next_in_face(blocks.face_start)]
    n = len(blocks.vertices)
    forward, backward = start * n + end, end * n + start
    values, _first, count = np.unique(forward, return_index=True, return_counts=True)
    corner_face = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))

    position = np.minimum(np.searchsorted(values, backward), len(values) - 1)
    balance = np.where(values[position] == backward, count[position], 0)
    own = np.where(start == end, 1, count[np.searchsorted(values, forward)])  # an edge between equal corners is none
    wrong = np.flatnonzero((own != balance) & (start != end))
    if not len(wrong):
        return
    at = blocks.face_block[corner_face[wrong]]
    found = (_surface_fault(int(block), names, blocks, merged, wrong[at == block], own) for block in np.unique(at))
    raise InputError(*found)


def _surface_fault(
    block: int, names: Sequence[str], blocks: Polyhedra, merged: np.ndarray, wrong: np.ndarray, own: np.ndarray
) -> str:
    """What is wrong with the surface of a block: the edges at fault, and how often each is walked."""
    first = np.searchsorted(blocks.face_block, block)
    corner_face = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))
    if (own[wrong] > 1).any():
        votes = np.bincount(corner_face[wrong] - first)
        return (
            f'block "{names[block]}": face {votes.argmax()} is inverted against its neighbours; '
            f"list its corners counter-clockwise seen from outside{ADVICE}turn it"
        )
    told = f"({len(wrong)} edges without a neighbour, the first at face {corner_face[wrong[0]] - first})"
    following = next_in_face(blocks.face_start)[wrong]
    edges = merged[blocks.face_vertices[np.column_stack([wrong, following])]]
    reach = ON_EDGE * float(np.linalg.norm(np.ptp(blocks.vertices[blocks.vertex_block == block], axis=0)))
    if _lie_along_each_other(blocks.vertices, edges, reach):
        return (
            f'block "{names[block]}": corners of some faces lie on edges of others, which lack them {told}; '
            f"list them in both{ADVICE}put them there"
        )
    return f'block "{names[block]}": its surface is open {told}; blocks must be closed solids'


def _lie_along_each_other(vertices: np.ndarray, edges: np.ndarray, reach: float) -> bool:
    """Whether open edges leave nothing open once each has the corners that lie on it."""
    on = corners_on_edges(vertices, edges, reach)
    rows = [np.array([a, *between, b]) for (a, b), between in zip(edges, on, strict=True)]
    pieces = np.sort(np.concatenate([np.column_stack([row[:-1], row[1:]]) for row in rows]), axis=1)
    return bool((np.unique(pieces, axis=0, return_counts=True)[1] % 2 == 0).all())


def corners_on_edges(vertices: np.ndarray, edges: np.ndarray, distance: float) -> list[np.ndarray]:
    """Find the corners of other edges that lie on an edge.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices [m].
    edges : array of int, shape (n_edges, 2)
        The two vertices of each edge, at different places.
    distance : float
        A corner that is no further from the edge than this lies on it [m].

    Returns
    -------
    list of array of int
        For each edge the corners between its ends, from the first to the second.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [3, 0, 0], [2, 0, 0], [1, 0, 0]])
    >>> [own.tolist() for own in corners_on_edges(corners, np.array([[0, 1], [0, 3], [3, 2], [2, 1]]), 0.0)]
    [[3, 2], [], [], []]
    """
    from scipy.spatial import KDTree

    used = np.unique(edges)
    start, line = vertices[edges[:, 0]], vertices[edges[:, 1]] - vertices[edges[:, 0]]
    reach = np.linalg.norm(line, axis=1) / 2 * (1 + 1e-9) + distance
    found = []
    for k, near in enumerate(KDTree(vertices[used]).query_ball_point(start + line / 2, reach)):
        own = np.setdiff1d(used[near], edges[k])
        along = (vertices[own] - start[k]) @ line[k] / (line[k] @ line[k])
        off = np.linalg.norm(vertices[own] - start[k] - along[:, None] * line[k], axis=1)
        on = (along > 0) & (along < 1) & (off <= distance)
        found.append(own[on][np.argsort(along[on])])
    return found


def _warn_of_several_solids(blocks: Polyhedra, names: Sequence[str], merged: np.ndarray) -> dict[int, np.ndarray]:
    """A block of separate solids moves as one rigid body, which is seldom what a mesh file means.

    Returns for each block of several closed surfaces the one of each of its faces.
    """
    # Solids that touch share corners, so corners are told apart by their index where that closes the surface.
    tail = blocks.face_vertices
    head = tail[next_in_face(blocks.face_start)]
    n = len(blocks.vertices)
    block = np.repeat(blocks.face_block, np.diff(blocks.face_start))
    loose = np.zeros(blocks.n_blocks, dtype=bool)
    forward, backward = tail * n + head, head * n + tail
    if not np.array_equal(np.sort(forward), np.sort(backward)):
        loose[block[~np.isin(backward, forward)]] = True
    tail, head = np.where(loose[block], merged[tail], tail), np.where(loose[block], merged[head], head)
    of_face = _face_connected(blocks, tail, head)
    walked = np.unique(np.repeat(of_face, np.diff(blocks.face_start))[tail != head])  # not of faces folded to a point
    _, first = np.unique(of_face, return_index=True)
    apart = np.bincount(blocks.face_block[first[walked]], minlength=blocks.n_blocks) > 1
    found = {block: of_face[blocks.face_block == block] for block in np.flatnonzero(apart).tolist()}
    hollow = [block for block, own in found.items() if _is_hollow(blocks, block, own)]
    several = [block for block in found if block not in hollow]
    for blocks_so, what in ((several, "hold separate solids that move as one"), (hollow, "have cavities")):
        if blocks_so:
            text = f'{len(blocks_so)} blocks {what} (the first is "{names[blocks_so[0]]}")'
            warnings.warn(InputWarning(text), stacklevel=4)
    return found


def _face_connected(blocks: Polyhedra, tail: np.ndarray, head: np.ndarray) -> np.ndarray:
    """The surface of each face: faces of one are connected over edges, whatever corners they share.

    At an edge of four faces and more, solids touch, or one touches itself: those two belong together there that bound
    the same wedge of material.
    """
    face = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))
    real = np.flatnonzero(tail != head)
    key = (np.minimum(tail, head) * len(blocks.vertices) + np.maximum(tail, head))[real]
    order = real[np.argsort(key, kind="stable")]
    _, first, count = np.unique(np.sort(key), return_index=True, return_counts=True)
    plain = first[count == 2]
    pairs = [np.column_stack([face[order[plain]], face[order[plain + 1]]])]
    for begin, many in zip(first[count != 2].tolist(), count[count != 2].tolist(), strict=True):
        at = order[begin : begin + many]
        pairs.append(face[at[_wedges(blocks, face[at], tail[at], head[at])]])
    return connected_components(len(blocks.face_block), np.concatenate(pairs))[1]


def _wedges(blocks: Polyhedra, face: np.ndarray, tail: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Pairs of the faces around an edge that bound the same wedge of material, shape (n, 2)."""
    opens = tail > head  # looking along the edge, material begins at a face that walks it backwards
    if 2 * opens.sum() != len(face):
        return np.column_stack([np.zeros(len(face), dtype=np.int64), np.arange(len(face))])
    line = blocks.vertices[max(tail[0], head[0])] - blocks.vertices[min(tail[0], head[0])]
    inward = np.cross(blocks.planes.normal[face], line) * np.where(opens, -1.0, 1.0)[:, None]
    base = inward[np.linalg.norm(inward, axis=1).argmax()]  # a face without area has none
    across = np.cross(line / np.linalg.norm(line), base)
    angle = np.arctan2(inward @ across, inward @ base) % (2 * np.pi)
    angle[angle > 2 * np.pi - THIN] = 0.0
    around = np.argsort(angle, kind="stable")
    step = np.empty(len(face), dtype=np.int64)
    step[around] = np.cumsum(np.diff(angle[around], prepend=0.0) > THIN)
    # Two solids that touch with a face have no room between their walls: one ends there before the other begins.
    around = np.lexsort((np.arange(len(face)), opens, step))
    depth = np.cumsum(np.where(opens[around], 1, -1))
    around = np.roll(around, -int(depth.argmin()) - 1)
    return np.column_stack([around[opens[around]], around[~opens[around]]])


def _is_hollow(blocks: Polyhedra, block: int, label: np.ndarray) -> bool:
    """Whether all surfaces of a block but one look inwards."""
    inwards = [cavity for _, _, cavity in _surfaces(blocks, block, label)]
    return len(inwards) > 1 and inwards.count(False) == 1
