"""Faces that lie back to back: both blocks are between them, so they are no joint though they are near each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.tolerance import ROUNDING
from blockstat.geometry import clipping as clip
from blockstat.geometry.broad_phase import row_pairs
from blockstat.geometry.polyhedron import members, next_in_face
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def back_to_back(
    assembly: Assembly, faces: tuple[Ints, Ints], frame: Floats, point: Floats, overlap: Floats
) -> np.ndarray:
    """Say which pairs of opposed faces lie back to back.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    faces : tuple of two arrays of int, shape (n,)
        A face of the first and one of the second block of each pair.
    frame : array, shape (n, 3, 3)
        Rows are the normal from the first block to the second, and two tangents.
    point : array, shape (n, 3)
        A point of the patch that both faces have in common, seen along the normal [m].
    overlap : array, shape (n,)
        How far the first face lies beyond the second along the normal [m]; zero or less for faces that do not overlap.

    Returns
    -------
    array of bool, shape (n,)
        True for those that are no joint.

    Notes
    -----
    Two faces may overlap because the geometry is not exact: moving the second block along the normal by the overlap
    brings them back. Moving it the other way, until the far sides of the two blocks meet, takes the thickness of both
    there less the overlap. Where that is shorter, the blocks meet at those far sides. The tips of two blocks that hook
    into each other do: a joint through both tips would hold them from behind.
    """
    lost = np.zeros(len(overlap), dtype=bool)
    rows = np.flatnonzero(overlap > 0)
    if len(rows):
        thickness = [
            _thickness(assembly, face[rows], sign * frame[rows], point[rows], 2 * overlap[rows])
            for face, sign in zip(faces, (1.0, -1.0), strict=True)
        ]
        lost[rows] = thickness[0] + thickness[1] < 2 * overlap[rows]
    return lost


def centres(polygon: Floats, count: Ints, filling: Mapping[int, Sequence[Floats]]) -> Floats:
    """Return a point of each patch in its plane.

    Parameters
    ----------
    polygon : array, shape (n, k, 2)
        Corners of the patches [m].
    count : array of int, shape (n,)
        How many of them each patch has.
    filling : mapping of int to sequence of array, shape (m, 2)
        Convex pieces of the patches that do not fill their polygon.

    Returns
    -------
    array, shape (n, 2)
        The mean corner, of the largest piece where there are several [m].
    """
    live = np.arange(polygon.shape[1]) < count[:, None]
    centre: Floats = np.where(live[..., None], polygon, 0.0).sum(axis=1) / np.maximum(count, 1)[:, None]
    for row, pieces in filling.items():
        centre[row] = max(pieces, key=lambda piece: clip.area(piece[None], np.array([len(piece)]))[0]).mean(axis=0)
    return centre


def _thickness(assembly: Assembly, face: Ints, frame: Floats, point: Floats, most: Floats) -> Floats:
    """Thickness of blocks behind their faces along the line through a point, or `most` where it is not less.

    frame : rows are the direction out of the face, and two across it
    """
    planes, out = assembly.planes, frame[:, 0]

    def heights(row: Ints, face: Ints, slope: Floats) -> Floats:
        """Where the line meets the planes of faces."""
        return np.einsum("ij,ij->i", planes.centre[face] - point[row], planes.normal[face]) / slope

    top = heights(np.arange(len(face)), face, np.einsum("ij,ij->i", planes.normal[face], out))
    row, other = _faces_behind(assembly, face, point + top[:, None] * out, most[:, None] * out)
    slope = np.einsum("ij,ij->i", planes.normal[other], out[row])
    behind = slope < 0
    row, other = row[behind], other[behind]
    depth = top[row] - heights(row, other, slope[behind])
    near = (depth >= 0) & (depth < most[row])
    row, other, depth = row[near], other[near], depth[near]
    # The line leaves the block through a face if it crosses an odd number of its sides on the way to infinity.
    side, corner = members(assembly.face_start[other], np.diff(assembly.face_start)[other])
    ends = np.stack([corner, next_in_face(assembly.face_start)[corner]], axis=1)
    across = assembly.vertices[assembly.face_vertices[ends]] - point[row[side], None]
    u, v = (np.einsum("nkj,nj->nk", across, frame[row[side], k]) for k in (1, 2))
    passes = (v[:, 0] > 0) != (v[:, 1] > 0)
    right = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) * np.where(v[:, 1] > v[:, 0], 1.0, -1.0) > 0
    leaves = np.bincount(side, weights=passes & right, minlength=len(other)) % 2 == 1
    thickness = most.copy()
    np.minimum.at(thickness, row[leaves], depth[leaves])
    return thickness


def _faces_behind(assembly: Assembly, face: Ints, begin: Floats, inwards: Floats) -> tuple[Ints, Ints]:
    """Faces of the blocks of some faces whose boxes a way inwards from a point of each of these may meet."""
    end = begin - inwards
    # A face that is not flat lies off its plane, which the way meets.
    first = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks))
    reach = np.maximum.reduceat(assembly.planes.warp, first) + ROUNDING * assembly.size
    block = assembly.face_block[face]
    order = np.argsort(block, kind="stable")
    box = np.minimum(begin, end)[order], np.maximum(begin, end)[order]
    some = np.flatnonzero(np.isin(assembly.face_block, block))
    lower, upper = assembly.face_bounds
    row, other = row_pairs(block[order], box, assembly.face_block[some], (lower[some], upper[some]), reach)
    return order[row], some[other]
