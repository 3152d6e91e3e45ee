"""What a 3D view needs of an assembly: triangles, edges that are seen, contacts, and the block that a ray meets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.faces import convex_faces
from blockstat.geometry.polyhedron import next_in_face
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints
from blockstat.view.painter import sharp_edges

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact.interfaces import Interfaces

#: A ray within this (sine) of a triangle's plane, relative to its edges, passes it by.
GRAZING = 1e-12


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles and sharp edges of all blocks, block after block, as indices into the assembly's vertices."""

    triangles: Ints  #: shape (n_triangles, 3)
    triangle_block: Ints  #: shape (n_triangles,), ascending
    edges: Ints  #: shape (n_edges, 2), each once
    edge_block: Ints  #: shape (n_edges,), ascending


def surface(assembly: Assembly) -> Surface:
    """Return the surface of an assembly; convex faces are cut into fans, the others into ears.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Returns
    -------
    Surface
        Triangles and sharp edges.
    """
    count = np.diff(assembly.face_start)
    convex = convex_faces(assembly)
    fan = np.flatnonzero(convex)
    face = np.repeat(fan, count[fan] - 2)
    first = assembly.face_start[face]
    step = np.arange(len(face)) - np.repeat(np.cumsum(count[fan] - 2) - (count[fan] - 2), count[fan] - 2)
    corner = np.column_stack([first, first + step + 1, first + step + 2])
    triangles = assembly.face_vertices[corner]
    owner = assembly.face_block[face]
    for odd in np.flatnonzero(~convex):
        own = assembly.face_vertices[assembly.face_start[odd] : assembly.face_start[odd + 1]]
        ears = triangulate(assembly.vertices, [own])
        triangles = np.concatenate([triangles, ears])
        owner = np.concatenate([owner, np.full(len(ears), assembly.face_block[odd])])
    order = np.argsort(owner, kind="stable")
    edges = _edges(assembly)
    return Surface(triangles[order], owner[order], edges, assembly.vertex_block[edges[:, 0]])


def _edges(assembly: Assembly) -> Ints:
    tail = assembly.face_vertices
    head = tail[next_in_face(assembly.face_start)]
    seen = sharp_edges(assembly, assembly.planes)
    ends = np.sort(np.column_stack([tail, head])[seen], axis=1)
    code = np.unique(ends[:, 0] * len(assembly.vertices) + ends[:, 1])
    return np.column_stack(np.divmod(code, len(assembly.vertices)))


def contacts_without_area(interfaces: Interfaces) -> tuple[Floats, Floats]:
    """Return the contacts that are drawn as lines and as dots.

    Parameters
    ----------
    interfaces : Interfaces
        The joints.

    Returns
    -------
    lines : array of float, shape (n, 2, 3)
        Ends of the edges on faces [m].
    dots : array of float, shape (m, 3)
        Corners on faces, and crossings of edges [m].
    """
    outlines = [interfaces.outline(k) for k in np.flatnonzero(interfaces.kinds).tolist()]
    lines = [points for points in outlines if len(points) == 2]
    dots = [points for points in outlines if len(points) == 1]
    return np.array(lines).reshape(-1, 2, 3), np.array(dots).reshape(-1, 3)


def block_at(shape: Surface, vertices: Floats, origin: Floats, direction: Floats) -> int | None:
    """Return the first block that a ray meets.

    Parameters
    ----------
    shape : Surface
        Triangles of the blocks.
    vertices : array of float, shape (n_vertices, 3)
        Vertices of the blocks as they are drawn [m].
    origin : array of float, shape (3,)
        Where the ray begins [m].
    direction : array of float, shape (3,)
        Where it goes, of any length.

    Returns
    -------
    int or None
        Number of the block, None if the ray meets none.

    References
    ----------
    Moeller & Trumbore: Fast, minimum storage ray/triangle intersection, 1997; here for all triangles at once.
    """
    a, b, c = (vertices[shape.triangles[:, k]] for k in range(3))
    one, two = b - a, c - a
    across = np.cross(direction, two)
    slope = np.einsum("ij,ij->i", one, across)
    scale = np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1) * np.linalg.norm(direction)
    met = np.abs(slope) > GRAZING * scale
    inverse = 1.0 / np.where(met, slope, 1.0)
    arm = origin - a
    u = np.einsum("ij,ij->i", arm, across) * inverse
    other = np.cross(arm, one)
    v = other @ direction * inverse
    distance = np.einsum("ij,ij->i", two, other) * inverse
    met &= (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    if not met.any():
        return None
    return int(shape.triangle_block[np.argmin(np.where(met, distance, np.inf))])
