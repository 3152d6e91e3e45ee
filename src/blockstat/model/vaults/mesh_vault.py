"""Vaults from a mesh: its faces as voussoirs, or points of its surface for bonded courses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, check_choice
from blockstat.model.arches.profile import positive
from blockstat.model.quantities import Count, Ends, Length, Size, Two
from blockstat.model.solids import polyhedron
from blockstat.model.vaults.freeform import split_face
from blockstat.typing import Floats

SUPPORTS = ("lowest", "all")
#: An edge of the boundary is at the foot when both its ends are as near to the lowest corner as this, relative to the
#: height of the surface.
FOOT = 1e-3
#: A polygon is plane when its corners are off its plane by less than this, relative to its size.
PLANE = 1e-9


def mesh_vault(
    vertices: Any,
    faces: Sequence[Sequence[int]],
    *,
    thickness: Length,
    supports: Literal["lowest", "all"] = "lowest",
    springers: Size = 0.0,
) -> list[Block]:
    """A vault whose voussoirs are the faces of a mesh, its middle surface, with joints normal to it.

    Each edge is thickened along the normals at its ends, the area-weighted means of those of the faces there.
    Neighbours share all corners of their joint; a joint that is not plane is two triangles, the same on both sides.

    Parameters
    ----------
    vertices : array_like
        Corners of the mesh, shape (n, 3) [m].
    faces : sequence of sequences of int
        Indices of the corners of each face, all faces turned the same way.
    thickness : float
        Normal to the surface [m].
    supports : str
        Edges of the boundary that have springers: the lowest, or all.
    springers : float
        Length of the blocks that carry on the surface beyond these edges, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "vault" and "springer".

    Raises
    ------
    InputError
        For a mesh that is folded, or without a boundary at its lowest level where springers are asked for.
    """
    corners = np.array(vertices, dtype=float)
    positive(thickness=thickness)
    check_choice("supports", supports, SUPPORTS)
    boundary = _boundary(faces)
    normal = _normals(corners, faces)
    if normal[:, 2].sum() < 0:
        faces, boundary, normal = [list(f)[::-1] for f in faces], [(b, a) for a, b in boundary], -normal
    sides = np.concatenate([corners - thickness / 2 * normal, corners + thickness / 2 * normal])
    n = len(corners)
    blocks = []
    for i, face in enumerate(faces):
        joints = [(a, b, b + n, a + n) for a, b in zip(face, [*face[1:], face[0]], strict=True)]
        outline = [[*list(face)[::-1]], [k + n for k in face]]
        blocks.append(_solid(sides, outline, joints, f"vault.{i}", "vault"))
    if springers:
        positive(springers=springers)
        if not boundary:
            raise InputError("the mesh has no boundary; there is nowhere for springers")
        blocks += _springers(corners, sides, normal, boundary, supports, springers)
    return blocks


def surface_points(
    vertices: Any,
    faces: Sequence[Sequence[int]],
    *,
    x: Ends | None = None,
    y: Ends | None = None,
    courses: Two,
    voussoirs: Count,
) -> Floats:
    """Points of a mesh for `freeform`: its height over a grid, as `height_field` has it.

    Polygons are cut into triangles from their first corner; where the surface is over itself the highest counts.

    Parameters
    ----------
    vertices : array_like
        Corners of the mesh, shape (n, 3) [m].
    faces : sequence of sequences of int
        Indices of the corners of each face.
    x : tuple of float, optional
        Ends of the rectangle along x [m]; by default those of the mesh.
    y : tuple of float, optional
        Ends of the rectangle along y [m]; by default those of the mesh.
    courses : int
        Their number along y.
    voussoirs : int
        In each course, along x.

    Returns
    -------
    ndarray
        Shape (courses + 1, 2 voussoirs + 1, 3) [m].

    Raises
    ------
    InputError
        Where there is no surface.
    """
    from blockstat.model.vaults.freeform import height_field

    corners = np.array(vertices, dtype=float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = x or (float(low[0]), float(high[0])), y or (float(low[1]), float(high[1]))
    triangles = corners[[(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]]
    return height_field(lambda u, v: _heights(triangles, u, v), x=x, y=y, courses=courses, voussoirs=voussoirs)


def _heights(triangles: Floats, x: Floats, y: Floats) -> Floats:
    """Height of the highest triangle over each point, nan where there is none."""
    a, b, c = triangles.swapaxes(0, 1)
    e, f = (b - a)[:, :2], (c - a)[:, :2]
    area = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    flat = np.abs(area) <= 1e-12 * np.abs(area).max()
    a, b, c, e, f, area = (item[~flat] for item in (a, b, c, e, f, area))
    found = np.full(x.size, np.nan)
    for i, point in enumerate(np.column_stack([x.ravel(), y.ravel()])):
        d = point - a[:, :2]
        s = (d[:, 0] * f[:, 1] - d[:, 1] * f[:, 0]) / area
        t = (e[:, 0] * d[:, 1] - e[:, 1] * d[:, 0]) / area
        inside = (s >= -1e-6) & (t >= -1e-6) & (s + t <= 1 + 1e-6)
        if inside.any():
            height = a[:, 2] + s * (b - a)[:, 2] + t * (c - a)[:, 2]
            found[i] = height[inside].max()
    return found.reshape(x.shape)


def _boundary(faces: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Edges of one face only, as that face walks them."""
    walked: set[tuple[int, int]] = set()
    for i, face in enumerate(faces):
        for edge in zip(face, [*face[1:], face[0]], strict=True):
            if edge in walked:
                raise InputError(f"face {i} of the mesh is turned against its neighbour, or lies on another")
            walked.add(edge)
    return [(a, b) for a, b in walked if (b, a) not in walked]


def _normals(corners: Floats, faces: Sequence[Sequence[int]]) -> Floats:
    """Unit normals at the corners, shape (n, 3)."""
    normal = np.zeros_like(corners)
    for face in faces:
        ring = corners[list(face)] - corners[face[0]]
        normal[list(face)] += np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) / 2
    length = np.linalg.norm(normal, axis=1)
    used = np.zeros(len(corners), dtype=bool)
    used[[k for face in faces for k in face]] = True
    if not (length[used] > 0).all():
        raise InputError(f"corner {np.flatnonzero(used & ~(length > 0))[0]} of the mesh has no normal; it is folded")
    return normal / np.where(length > 0, length, 1.0)[:, None]


def _solid(
    points: Floats, outline: Sequence[Sequence[int]], joints: Sequence[Sequence[int]], name: str, group: str
) -> Block:
    """A block with polygons for intrados and extrados, and quadrilaterals for joints."""
    used = sorted({k for face in (*outline, *joints) for k in face})
    place = {k: i for i, k in enumerate(used)}
    vertices, rank = points[used], np.arange(len(used))
    parts = [part for face in outline for part in _plane_parts(vertices, [place[k] for k in face])]
    parts += [part for face in joints for part in split_face(vertices, [place[k] for k in face], rank)]
    return polyhedron(vertices, parts, name=name, group=group)


def _plane_parts(vertices: Floats, face: list[int]) -> list[list[int]]:
    """A plane polygon as it is, another one as triangles from its first corner."""
    ring = vertices[face] - vertices[face[0]]
    spread = np.linalg.svd(ring - ring.mean(axis=0), compute_uv=False)
    if len(face) == 3 or spread[2] <= PLANE * spread[0]:
        return [face]
    return [[face[0], face[k], face[k + 1]] for k in range(1, len(face) - 1)]


def _springers(
    corners: Floats, sides: Floats, normal: Floats, boundary: Sequence[tuple[int, int]], supports: str, length: float
) -> list[Block]:
    step = np.zeros_like(corners)
    for a, b in boundary:  # the face is to the left of its edge, outwards is to the right
        along = corners[b] - corners[a]
        for k in (a, b):
            step[k] += np.cross(along, normal[k])
    used = np.linalg.norm(step, axis=1)
    step = length * step / np.where(used > 0, used, 1.0)[:, None]
    reach = corners[:, 2] - corners[:, 2].min() <= FOOT * np.ptp(corners[:, 2])
    chosen = [edge for edge in sorted(boundary) if supports == "all" or reach[list(edge)].all()]
    if not chosen:
        raise InputError('no edge of the mesh\'s boundary is at its lowest level; use supports = "all"')
    n = len(corners)
    points = np.concatenate([sides, sides + np.tile(step, (2, 1))])
    blocks = []
    for i, (a, b) in enumerate(chosen):
        near, far = [a, b, b + n, a + n], [k + 2 * n for k in (a, b, b + n, a + n)]
        joints = [tuple(near), tuple(far)[::-1]]
        joints += [(near[j], far[j], far[(j + 1) % 4], near[(j + 1) % 4]) for j in range(4)]
        blocks.append(_solid(points, [], joints, f"springer.{i}", "springer"))
    return blocks
