"""Find blocks that run into each other: rigid blocks cannot, and statics would not notice.

Two convex blocks are apart when a face plane of one has the other outside. Pairs that fail this test are
measured by the largest ball that fits into both. Blocks with concave faces or notches are not examined.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.polyhedron import FacePlanes, members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: An overlap deeper than this fraction of the smaller block is an error; between the joint tolerance and
#: this it is a warning, as in meshes from curved surfaces whose corners do not quite meet.
DEEP = 0.1
#: Rows (face of one block, corner of the other) that are held in memory at once.
CHUNK = 2_000_000


def check_overlaps(assembly: Assembly, *, gap: float, near: Ints | None = None) -> list[str]:
    """Refuse deep overlaps of blocks and warn of shallow ones.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float
        Overlaps up to this fraction of the size of the smaller block are joints.
    near : array of int, shape (n, 2), optional
        Pairs of blocks among which to look; None for all.

    Returns
    -------
    list of str
        A warning about shallow overlaps, if there are any.

    Raises
    ------
    InputError
        Naming the two blocks that overlap most, when the overlap is deeper than a tenth of the smaller one.
    """
    pairs, depth = overlaps(assembly, gap=gap, near=near)
    if not len(pairs):
        return []
    relative = depth / assembly.size[pairs].min(axis=1)
    worst = int(relative.argmax())
    if relative[worst] > DEEP:
        a, b = (assembly.names[i] for i in pairs[worst])
        raise InputError(
            f'blocks "{a}" and "{b}" overlap by {depth[worst]:.3g} m; rigid blocks may touch but not overlap'
        )
    return [tell(assembly, pairs, depth)]


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
    worst = int((depth / assembly.size[pairs].min(axis=1)).argmax())
    a, b = (assembly.names[i] for i in pairs[worst])
    return f'{len(pairs)} pairs of blocks overlap, the worst "{a}" and "{b}" by {depth[worst]:.2g} m'


def overlaps(assembly: Assembly, *, gap: float, near: Ints | None = None) -> tuple[Ints, Floats]:
    """Find pairs of convex blocks that overlap.

    Parameters
    ----------
    assembly : Assembly
        The blocks. Two supports may overlap.
    gap : float
        Overlaps up to this fraction of the size of the smaller block do not count.
    near : array of int, shape (n, 2), optional
        Pairs among which to look, as `blockstat.contact.interfaces.near_blocks` gives them; None for all.

    Returns
    -------
    pairs : array of int, shape (n, 2)
        The two blocks of each overlap.
    depth : array of float, shape (n,)
        Diameter of the largest ball inside both blocks [m].

    Examples
    --------
    >>> from blockstat import Assembly, box, overlaps
    >>> blocks = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 0.9), (1, 1, 2))]
    >>> pairs, depth = overlaps(Assembly.from_blocks(blocks, supports=[0]), gap=0.01)
    >>> pairs.tolist(), depth.round(6).tolist()
    ([[0, 1]], [0.1])
    """
    lower, upper = assembly.bounds
    pairs = near_pairs(lower, upper, np.zeros(assembly.n_blocks)) if near is None else near
    pairs = pairs[~assembly.support[pairs].all(axis=1)]
    limit = gap * assembly.size[pairs].min(axis=1)
    deep = np.minimum(upper[pairs[:, 0]], upper[pairs[:, 1]]) - np.maximum(lower[pairs[:, 0]], lower[pairs[:, 1]])
    pairs = pairs[(deep > limit[:, None]).all(axis=1)]
    pairs = pairs[convex_blocks(assembly, tolerance=gap)[pairs].all(axis=1)]
    limit = gap * assembly.size[pairs].min(axis=1)
    separated = np.maximum(_separation(assembly, pairs), _separation(assembly, pairs[:, ::-1])) >= -limit
    pairs, limit = pairs[~separated], limit[~separated]
    depth = np.array([_ball(assembly, a, b) for a, b in pairs])
    return pairs[depth > limit], depth[depth > limit]


def convex_blocks(assembly: Assembly, *, tolerance: float = 1e-6) -> np.ndarray:
    """Return which blocks are convex.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    tolerance : float, optional
        A vertex may lie outside a face plane by this fraction of the size of its block.

    Returns
    -------
    array of bool, shape (n_blocks,)
        True for a convex block.
    """
    planes = assembly.planes
    block = assembly.face_block
    face, vertex = members(assembly.vertex_start[block], np.diff(assembly.vertex_start)[block])
    height = np.einsum("ij,ij->i", assembly.vertices[vertex] - planes.centre[face], planes.normal[face])
    owner = assembly.face_block[face]  # ascending
    outside = np.maximum.reduceat(height, np.searchsorted(owner, np.arange(assembly.n_blocks)))
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
    allowed = np.ones(len(face_block), dtype=bool) if faces is None else faces
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


def _separation(assembly: Assembly, pairs: Ints) -> Floats:
    return face_separation(assembly.vertices, assembly.vertex_start, assembly.planes, assembly.face_block, pairs)


def _ball(assembly: Assembly, a: int, b: int) -> float:
    """Diameter of the largest ball inside two convex blocks, 0 when they have no common interior."""
    from scipy.optimize import linprog

    faces = np.flatnonzero((assembly.face_block == a) | (assembly.face_block == b))
    normal = assembly.planes.normal[faces]
    origin = assembly.centroid[a]
    offset = np.einsum("ij,ij->i", normal, assembly.planes.centre[faces] - origin)
    answer = linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([normal, np.ones(len(faces))]), b_ub=offset,
        bounds=[(None, None)] * 3 + [(0, None)],
    )  # fmt: skip
    return 2.0 * float(answer.x[3]) if answer.status == 0 else 0.0
