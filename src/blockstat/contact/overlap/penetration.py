"""Find blocks that run into each other: rigid blocks cannot, and statics would not notice.

Two convex blocks are apart when a face plane of one has the other outside. Pairs that fail this test are
measured by the largest ball that fits into both. Blocks with notches are cut into convex pieces first.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.tolerance import allowed_gap, mean_thickness
from blockstat.errors import InputError, known_options
from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.common_ball import convex_depths, lies_inside, piece_depths
from blockstat.geometry.convexity import protrusions, surface_stays_out
from blockstat.geometry.polyhedron import FacePlanes
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: An overlap deeper than this fraction of the smaller block is an error; between the joint tolerance and
#: this it is a warning, as in meshes from curved surfaces whose corners do not quite meet.
DEEP = 0.1
#: Blocks whose corners agree to this fraction of their size are copies at one place.
SAME = 1e-6
#: Blocks that only touch have fewer near pairs than this for each block. Where there are more, the pairs with the
#: nearest centroids are measured first, as many as there are blocks: one deep overlap is enough to refuse.
CROWDED = 50
#: Rows (face of one block, corner of the other) that are held in memory at once.
CHUNK = 2_000_000


def check_overlaps(assembly: Assembly, *, gap: float | str, near: Ints | None = None) -> tuple[Ints, list[str]]:
    """Refuse deep overlaps of blocks and warn of shallow ones.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str
        Overlaps up to what a joint may be open do not count: a share of the size of the smaller block or a length such
        as "2 mm", and at most a quarter of the thickness of a plate.
    near : array of int, shape (n, 2), optional
        Pairs of blocks among which to look; None for all.

    Returns
    -------
    pairs : array of int, shape (n, 2)
        The two blocks of each shallow overlap.
    warnings : list of str
        One about them, if there are any.

    Raises
    ------
    InputError
        Naming the two blocks that overlap most, when the overlap is deeper than a tenth of the smaller one.
    """
    if near is not None and len(near) > CROWDED * assembly.n_blocks:
        apart = np.linalg.norm(assembly.centroid[near[:, 0]] - assembly.centroid[near[:, 1]], axis=1)
        nearest = np.argpartition(apart / assembly.size[near].min(axis=1), assembly.n_blocks)[: assembly.n_blocks]
        _refuse_deep(assembly, *overlaps(assembly, gap=gap, near=near[nearest]))
    pairs, depth = overlaps(assembly, gap=gap, near=near)
    _refuse_deep(assembly, pairs, depth)
    return pairs, [tell(assembly, pairs, depth)] if len(pairs) else []


def _refuse_deep(assembly: Assembly, pairs: Ints, depth: Floats) -> None:
    """Raise InputError when the overlap that is deepest for its blocks is deeper than `DEEP`."""
    relative = _relative(assembly, pairs, depth)
    if not len(pairs) or relative.max() <= DEEP:
        return
    worst = int(relative.argmax())
    inner, outer = sorted(map(int, pairs[worst]), key=lambda block: assembly.volume[block])
    a, b = (assembly.names[i] for i in pairs[worst])
    what = f'blocks "{a}" and "{b}" overlap by {depth[worst]:.3g} m'
    if lies_inside(assembly, inner, outer):
        what = f'block "{assembly.names[inner]}" lies inside block "{assembly.names[outer]}"'
    raise InputError(f"{what}; rigid blocks may touch but not overlap")


def _relative(assembly: Assembly, pairs: Ints, depth: Floats) -> Floats:
    """How deep overlaps are for the smaller of their blocks; a plate is smaller than the cube root of its volume."""
    # Of a cube the mean thickness is a third of its size.
    extent = np.minimum(assembly.size, 3 * mean_thickness(assembly))
    return np.asarray(depth / extent[pairs].min(axis=1))


def check_copies(assembly: Assembly) -> None:
    """Refuse copies of a block at one place, without a look at all pairs of them.

    Parameters
    ----------
    assembly : Assembly
        The blocks. Two supports may overlap.

    Raises
    ------
    InputError
        Naming two blocks at one place, and how many blocks are copies.
    """
    first = _originals(assembly)
    extra = np.flatnonzero(first != np.arange(assembly.n_blocks))
    extra = extra[~(assembly.support[extra] & assembly.support[first[extra]])]
    if len(extra):
        a, b = (assembly.names[i] for i in (first[extra[0]], extra[0]))
        more = f" ({len(extra)} blocks are copies of others)" if len(extra) > 1 else ""
        raise InputError(
            f'blocks "{a}" and "{b}" are copies at one place{more}; rigid blocks may touch but not overlap'
        )


def _originals(assembly: Assembly) -> Ints:
    """For each block the first one with the same corners, which is mostly itself."""
    # Copies agree in any number; other blocks seldom agree in one with irrational weights.
    local = assembly.centroid - assembly.centroid.mean(axis=0)
    key = local @ np.sqrt([2.0, 3.0, 5.0]) + np.sqrt(7.0) * assembly.size
    order = np.argsort(key, kind="stable")
    first = np.arange(assembly.n_blocks)
    for i in np.flatnonzero(np.diff(key[order]) <= SAME * assembly.size[order[1:]]):
        a, b = int(first[order[i]]), int(order[i + 1])
        one, two = assembly.block_vertices(a), assembly.block_vertices(b)
        if one.shape == two.shape and _same_corners(one, two, SAME * float(assembly.size[b])):
            first[b] = a
    lowest = np.arange(assembly.n_blocks)
    np.minimum.at(lowest, first, np.arange(assembly.n_blocks))
    return lowest[first]


def _same_corners(one: Floats, two: Floats, tolerance: float) -> bool:
    """Whether each of two sets of corners has all corners of the other, in whatever order."""
    if np.abs(one - two).max() <= tolerance:
        return True
    from scipy.spatial import KDTree

    near = KDTree(one).query(two)[0].max(), KDTree(two).query(one)[0].max()
    return bool(max(near) <= tolerance)


def tell(assembly: Assembly, pairs: Ints, depth: Floats) -> str:
    """Say how many pairs overlap, and which is the worst for its size.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pairs : array of int, shape (n, 2)
        Pairs that overlap, at least one.
    depth : array, shape (n,)
        Depths [m].

    Returns
    -------
    str
        One sentence without a period.
    """
    worst = int(_relative(assembly, pairs, depth).argmax())
    a, b = (assembly.names[i] for i in pairs[worst])
    return f'{len(pairs)} pairs of blocks overlap, the worst "{a}" and "{b}" by {depth[worst]:.2g} m'


@known_options
def overlaps(assembly: Assembly, *, gap: float | str, near: Ints | None = None) -> tuple[Ints, Floats]:
    """Find pairs of blocks that overlap.

    Parameters
    ----------
    assembly : Assembly
        The blocks. Two supports may overlap.
    gap : float or str
        Overlaps up to what a joint may be open do not count: a share of the size of the smaller block or a length such
        as "2 mm", and at most a quarter of the thickness of a plate.
    near : array of int, shape (n, 2), optional
        Pairs among which to look, as `blockstat.contact.interfaces.near_blocks` gives them; None for all.

    Returns
    -------
    pairs : array of int, shape (n, 2)
        The two blocks of each overlap.
    depth : array of float, shape (n,)
        Diameter of the largest ball inside both blocks [m]. A block that is not convex is cut into convex pieces, and
        the ball lies inside one of them.

    Notes
    -----
    Of several copies of a block at one place, each makes a pair with the first one only, unless `near` is given.

    Examples
    --------
    >>> from blockstat import Assembly, box, overlaps
    >>> blocks = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 0.9), (1, 1, 2))]
    >>> pairs, depth = overlaps(Assembly.from_blocks(blocks, supports=[0]), gap=0.01)
    >>> pairs.tolist(), depth.round(6).tolist()
    ([[0, 1]], [0.1])
    """
    pairs = _near_pairs(assembly) if near is None else near
    pairs = pairs[~assembly.support[pairs].all(axis=1)]
    lower, upper = assembly.bounds
    lengths = allowed_gap(assembly, gap)
    limit = lengths[pairs].min(axis=1)
    deep = np.minimum(upper[pairs[:, 0]], upper[pairs[:, 1]]) - np.maximum(lower[pairs[:, 0]], lower[pairs[:, 1]])
    pairs = pairs[(deep > limit[:, None]).all(axis=1)]
    if not len(pairs):
        return pairs, np.empty(0)
    limit = lengths[pairs].min(axis=1)
    outside = protrusions(assembly)
    notch = np.maximum.reduceat(outside, np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks)))
    simple = (notch[pairs] <= limit[:, None]).all(axis=1)
    depth = np.zeros(len(pairs))
    depth[simple] = _convex_overlaps(assembly, pairs[simple], limit[simple], None)
    rest = np.flatnonzero(~simple)
    for both in (pairs, pairs[:, ::-1]):
        rest = rest[~surface_stays_out(assembly, both[rest], outside, limit[rest] / 2)]
    # A ball in both blocks is also behind their planes when these are moved out to the last corner.
    rest = rest[_convex_overlaps(assembly, pairs[rest], limit[rest], outside) > limit[rest]]
    depth[rest] = piece_depths(assembly, pairs[rest], limit[rest], outside)
    return pairs[depth > limit], depth[depth > limit]


def _near_pairs(assembly: Assembly) -> Ints:
    """Pairs of blocks whose boxes meet; a copy of a block meets only the block that it is a copy of."""
    lower, upper = assembly.bounds
    first = _originals(assembly)
    own = first == np.arange(assembly.n_blocks)
    kept, copies = np.flatnonzero(own), np.flatnonzero(~own)
    pairs = kept[near_pairs(lower[kept], upper[kept], np.zeros(len(kept)))]
    return np.concatenate([pairs, np.column_stack([first[copies], copies])]) if len(copies) else pairs


def _convex_overlaps(assembly: Assembly, pairs: Ints, limit: Floats, outward: Floats | None) -> Floats:
    """Depth of the overlap of convex blocks, 0 where a face plane separates them but for the limit [m]."""
    planes = assembly.planes
    if outward is not None:
        planes = replace(planes, centre=planes.centre + outward[:, None] * planes.normal)
    depth = np.zeros(len(pairs))
    apart = np.full(len(pairs), -np.inf)
    for both in (pairs, pairs[:, ::-1]):
        own = face_separation(assembly.vertices, assembly.vertex_start, planes, assembly.face_block, both)
        apart = np.maximum(apart, own)
    met = np.flatnonzero(apart < -limit)
    depth[met] = convex_depths(assembly, pairs[met], limit[met], outward)
    return depth


def convex_blocks(assembly: Assembly, *, tolerance: float = 1e-6) -> np.ndarray:
    """Return which blocks are convex.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    tolerance : float or array of float, shape (n_blocks,), optional
        A vertex may lie outside a face plane by this fraction of the size of its block.

    Returns
    -------
    array of bool, shape (n_blocks,)
        True for a convex block.
    """
    outside = np.maximum.reduceat(
        protrusions(assembly), np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks))
    )
    return outside <= tolerance * assembly.size


def face_separation(
    vertices: Floats,
    vertex_start: Ints,
    planes: FacePlanes,
    face_block: Ints,
    pairs: Ints,
    faces: np.ndarray | None = None,
) -> Floats:
    """Return how far each second block lies wholly beyond one face of the first.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices of all blocks, one block after the other [m].
    vertex_start : array of int, shape (n_blocks + 1,)
        Where the vertices of each block begin.
    planes : FacePlanes
        Planes of all faces.
    face_block : array of int, shape (n_faces,)
        The block of each face, ascending.
    pairs : array of int, shape (n_pairs, 2)
        The first and the second block of each pair.
    faces : array of bool, shape (n_faces,), optional
        Which faces may separate; all when None.

    Returns
    -------
    array of float, shape (n_pairs,)
        Distance of the nearest corner in front of the face that separates best [m]. It is negative when the second
        block reaches behind every face, and -inf when the first has no face that may separate.
    """
    if not len(pairs):
        return np.empty(0)
    first_face = np.searchsorted(face_block, np.arange(len(vertex_start)))
    work = np.cumsum(np.diff(first_face)[pairs[:, 0]] * np.diff(vertex_start)[pairs[:, 1]])
    chunks = np.split(np.arange(len(pairs)), np.searchsorted(work, np.arange(CHUNK, work[-1], CHUNK)))
    allowed = np.asarray(planes.normal.any(axis=1))  # a face without a plane separates nothing
    allowed = allowed if faces is None else allowed & faces
    return np.concatenate(
        [_chunk(vertices, vertex_start, planes, first_face, pairs[rows], allowed) for rows in chunks if len(rows)]
    )


def _chunk(
    vertices: Floats,
    vertex_start: Ints,
    planes: FacePlanes,
    first_face: Ints,
    pairs: Ints,
    allowed: np.ndarray,
) -> Floats:
    n_faces = np.diff(first_face)[pairs[:, 0]]
    row_start = np.cumsum(n_faces) - n_faces
    row = np.repeat(np.arange(len(pairs)), n_faces)
    face = np.arange(len(row)) - row_start[row] + first_face[pairs[row, 0]]
    n_vertices = np.diff(vertex_start)[pairs[row, 1]]
    start = np.cumsum(n_vertices) - n_vertices
    vertex = np.arange(n_vertices.sum()) - np.repeat(start - vertex_start[pairs[row, 1]], n_vertices)
    plane = np.repeat(face, n_vertices)
    height = np.einsum("ij,ij->i", vertices[vertex] - planes.centre[plane], planes.normal[plane])
    lowest = np.where(allowed[face], np.minimum.reduceat(height, start), -np.inf)
    return np.maximum.reduceat(lowest, row_start)
