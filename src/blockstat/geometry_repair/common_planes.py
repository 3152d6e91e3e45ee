"""Bring faces into common planes and put each vertex where its faces' planes meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.broad_phase import near_pairs
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

PARALLEL = np.cos(np.deg2rad(5.0))  #: faces further from parallel than this have no common plane
FITS = 1e-9  #: joints open by less than this share of the smaller block close but for rounding
STEPS = 200  #: of fitting planes to vertices and vertices to planes in turn
EXACT = 1e-14  #: a vertex this close to a plane, relative to the assembly's extent, is on it
WEAK = 1e-5  #: planes that meet at less than about the root of this do not fix where along them a vertex lies


@dataclass
class _Plane:
    """Faces that shall lie in one plane, and the moments of their corners."""

    faces: list[int]
    weight: float
    first: Floats
    second: Floats
    looks: dict[int, float]  #: for each block +1 or -1, how its faces look along the normal of the first face
    normal: Floats

    def fit(self) -> tuple[Floats, Floats]:
        """Centre and unit normal of the plane of least squares."""
        centre = self.first / self.weight
        return centre, np.linalg.eigh(self.second / self.weight - np.outer(centre, centre))[1][:, 0]


def common_planes(assembly: Assembly, gap: float, candidates: Ints) -> Ints:
    """Find the faces that lie in one plane but for small errors.

    Faces of blocks that touch, nearly parallel and nearly coplanar, share a plane as long as every corner stays within
    gap times the size of its block, and no block is squeezed to nothing between two of its faces. The faces of blocks
    whose joints all close stay as they are.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float
        How far a corner may move, relative to the size of its block.
    candidates : array of int
        Numbers of the faces that may share a plane.

    Returns
    -------
    array of int, shape (n_faces,)
        Number of the plane of each face, -1 for faces that are no candidates.
    """
    planes = {int(f): _single(assembly, int(f)) for f in candidates}
    of = {f: f for f in planes}
    for f, g in _alike(assembly, gap, candidates) if gap > 0 else ():
        a, b = planes[of[f]], planes[of[g]]
        if a is not b:
            joined = _joined(assembly, a, b, gap)
            if joined is not None:
                planes[of[f]] = joined
                keep = of[f]
                del planes[of[g]]
                of.update(dict.fromkeys(b.faces, keep))
    label = np.full(len(assembly.face_block), -1)
    for number, plane in enumerate(planes.values()):
        label[plane.faces] = number
    return label


def _corners(assembly: Assembly, face: int) -> Floats:
    return assembly.vertices[assembly.face_vertices[assembly.face_start[face] : assembly.face_start[face + 1]]]


def _single(assembly: Assembly, face: int) -> _Plane:
    corners = _corners(assembly, face) - assembly.vertices[0]
    weight = float(assembly.planes.area[face]) / len(corners)
    normal, block = assembly.planes.normal[face], int(assembly.face_block[face])
    return _Plane(
        [face], weight * len(corners), weight * corners.sum(axis=0), weight * corners.T @ corners, {block: 1.0}, normal
    )


def _joined(assembly: Assembly, a: _Plane, b: _Plane, gap: float) -> _Plane | None:
    """Both as one plane, unless a corner would be too far from it or a block be squeezed."""
    sign = 1.0 if a.normal @ b.normal > 0 else -1.0
    looks = {block: sign * way for block, way in b.looks.items()}
    if any(a.looks.get(block, way) != way for block, way in looks.items()):
        return None
    joined = _Plane(
        a.faces + b.faces, a.weight + b.weight, a.first + b.first, a.second + b.second, a.looks | looks, a.normal
    )
    centre, normal = joined.fit()
    for face in joined.faces:
        far = np.abs((_corners(assembly, face) - assembly.vertices[0] - centre) @ normal).max()
        if far > gap * assembly.size[assembly.face_block[face]]:
            return None
    return joined


def _alike(assembly: Assembly, gap: float, candidates: Ints) -> list[tuple[int, int]]:
    """Pairs of faces that are nearly parallel, nearly coplanar and near each other, the closest first.

    The smaller face of a pair is measured from the plane of the larger. Faces of different blocks that look at each
    other make a joint. Faces that look the same way count where a joint of one of their blocks is open, those of one
    block if both are in joints: facets of blocks that fit, and of a free curved face, are meant to be as they are.
    """
    lower, upper = assembly.bounds
    pairs = near_pairs(lower, upper, gap * assembly.size)
    pairs = np.concatenate([pairs, np.repeat(np.arange(assembly.n_blocks)[:, None], 2, axis=1)])
    allowed = np.zeros(len(assembly.face_block), dtype=bool)
    allowed[candidates] = True
    first = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    own = [np.arange(a, b)[allowed[a:b]] for a, b in zip(first[:-1], first[1:], strict=True)]
    corners, start = assembly.vertices[assembly.face_vertices], assembly.face_start[:-1]
    low, high = np.minimum.reduceat(corners, start), np.maximum.reduceat(corners, start)
    normal, centre, area = assembly.planes.normal, assembly.planes.centre, assembly.planes.area
    facing, alike = [], []
    for a, b in pairs.tolist():
        reach = gap * min(assembly.size[a], assembly.size[b])
        f, g = (grid.ravel() for grid in np.meshgrid(own[a], own[b], indexing="ij"))
        cosine = np.einsum("ij,ij->i", normal[f], normal[g])
        good = (cosine > PARALLEL) & (f < g) if a == b else np.abs(cosine) > PARALLEL
        good &= ((low[f] <= high[g] + reach) & (high[f] >= low[g] - reach)).all(axis=1)
        for i, j in zip(f[good].tolist(), g[good].tolist(), strict=True):
            large, small = (i, j) if area[i] >= area[j] else (j, i)
            far = float(np.abs((_corners(assembly, small) - centre[large]) @ normal[large]).max())
            if far <= reach:
                (facing if normal[i] @ normal[j] < 0 else alike).append((far, i, j))
    open_joint, in_joint = np.zeros(assembly.n_blocks, dtype=bool), np.zeros_like(allowed)
    block = assembly.face_block
    for far, i, j in facing:
        two = block[[i, j]]
        in_joint[[i, j]] = True
        open_joint[two] |= far > FITS * assembly.size[two].min()
    found = [
        (far, i, j)
        for far, i, j in alike
        if open_joint[block[[i, j]]].any() and (block[i] != block[j] or in_joint[[i, j]].all())
    ]
    return [(i, j) for _, i, j in sorted([*facing, *found])]


def meet(assembly: Assembly, label: Ints, corner: Ints) -> Floats:
    """Move vertices as little as may be into the planes of their faces.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    label : array of int, shape (n_faces,)
        Number of the plane of each face, -1 for none.
    corner : array of int, shape (n_vertices,)
        Number of the corner of each vertex; vertices of one corner go to one place.

    Returns
    -------
    array of float, shape (n_vertices, 3)
        The moved vertices [m].

    Notes
    -----
    Planes are fitted to the corners that share their label (least squares, weighted by area) and vertices moved onto
    them, in turn, until nothing moves: at once where three faces meet at every vertex.
    """
    face = np.repeat(np.arange(len(label)), np.diff(assembly.face_start))
    live = (label[face] >= 0) & (assembly.planes.area[face] > 0)
    plane, vertex = label[face][live], corner[assembly.face_vertices[live]]
    weight = (assembly.planes.area / np.diff(assembly.face_start))[face][live]
    origin = assembly.vertices.mean(axis=0)
    n = int(corner.max()) + 1
    points = _sums(corner, assembly.vertices - origin, n) / np.bincount(corner)[:, None]
    extent = float(np.abs(points).max())
    count = int(label.max()) + 1
    total = np.bincount(plane, weight, count)
    total[total == 0] = 1.0  # of planes that only faces without area have
    for _ in range(STEPS):
        reached = points[vertex]
        centre = _sums(plane, weight[:, None] * reached, count) / total[:, None]
        local = reached - centre[plane]
        spread = _sums(plane, weight[:, None, None] * local[:, :, None] * local[:, None, :], count)
        normal = np.linalg.eigh(spread)[1][:, :, 0][plane]
        off = -np.einsum("ij,ij->i", local, normal)
        if np.abs(off).max(initial=0.0) <= EXACT * extent:
            break
        matrix = _sums(vertex, normal[:, :, None] * normal[:, None, :], n)
        size, axes = np.linalg.eigh(matrix)
        strong = size > WEAK * size[:, -1:]
        inverse = np.where(strong, 1.0 / np.where(strong, size, 1.0), 0.0)
        wanted = _sums(vertex, normal * off[:, None], n)
        points = points + np.einsum("nij,nj,nkj,nk->ni", axes, inverse, axes, wanted)
    return points[corner] + origin


def _sums(index: Ints, values: Floats, count: int) -> Floats:
    result = np.zeros((count, *values.shape[1:]))
    np.add.at(result, index, values)
    return result
