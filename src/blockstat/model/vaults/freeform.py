"""Vaults of any form: a surface cut into staggered voussoirs with joints normal to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, check_choice
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.quantities import Bond, Count, Edge, Ends, Size, Two
from blockstat.model.solids import FACES, fuse, polyhedron
from blockstat.model.vaults.dome import BONDS
from blockstat.typing import Floats

#: Edges of a grid of points, by axis and end: south is the first row, west the first column.
EDGES = {"south": (0, 0), "north": (0, -1), "west": (1, 0), "east": (1, -1)}
#: A quadrilateral with this volume between its corners, relative to its longest side cubed, is plane.
PLANE = 1e-12


def height_field(
    height: Callable[[Floats, Floats], Any], *, x: Ends, y: Ends, courses: Two, voussoirs: Count
) -> Floats:
    """Points of a surface z = height(x, y) for `freeform`.

    Parameters
    ----------
    height : callable
        Takes arrays x and y [m] and returns z [m].
    x : tuple of float
        Ends of the rectangle along x [m].
    y : tuple of float
        Ends of the rectangle along y [m].
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
        For an empty rectangle, or a height that is not finite.
    """
    at_least(2, courses=courses)
    at_least(1, voussoirs=voussoirs)
    for name, (low, high) in (("x", x), ("y", y)):
        if not (np.isfinite([low, high]).all() and low < high):
            raise InputError(f"{name} is {(low, high)!r}; it must be two lengths, the smaller first [m]")
    across, along = np.meshgrid(np.linspace(*y, courses + 1), np.linspace(*x, 2 * voussoirs + 1), indexing="ij")
    z = np.broadcast_to(np.asarray(height(along, across), dtype=float), along.shape)
    if not np.isfinite(z).all():
        i = np.argwhere(~np.isfinite(z))[0]
        raise InputError(
            f"height is {z[tuple(i)]} at x = {along[tuple(i)]:g} m, y = {across[tuple(i)]:g} m; it must be finite"
        )
    return np.stack([along, across, z], axis=2)


def freeform(
    points: Any,
    *,
    thickness: Any,
    supports: Sequence[Edge] = ("south", "north"),
    springers: Size = 0.0,
    bond: Bond = "running",
) -> list[Block]:
    """A vault in bonded courses whose middle surface is a grid of points.

    The normals come from differences between neighbouring points. A voussoir is two cells of the grid long, so that in
    running bond its neighbours above and below meet half of it each and every corner is shared by all that meet
    there. The joint of two cells is plane where the surface allows it; elsewhere it is two triangles, the same on both
    sides.

    Parameters
    ----------
    points : array_like
        Shape (courses + 1, 2 voussoirs + 1, 3) [m]: a course lies between two rows and runs along them.
    thickness : float, ndarray or callable
        Normal to the surface [m]: a number, one for each point, or a function of x and y.
    supports : sequence of str
        Edges that have springers: south (the first row), north (the last), west (the first column) and east.
    springers : float
        Length of the blocks that carry on the surface beyond these edges, 0 for none [m].
    bond : str
        Courses that begin with a whole and a half voussoir in turn ("running"), or continuous joints ("stack").

    Returns
    -------
    list of Block
        Groups "vault.0" (the first course), "vault.1", ..., and "springer.south", ...

    Raises
    ------
    InputError
        For points without a normal, where the vault is thicker than its surface is curved, and for an edge that is not
        known or given twice.

    Examples
    --------
    >>> from blockstat.model import freeform, height_field
    >>> points = height_field(lambda x, y: 2.0 - y**2 / 4, x=(-1, 1), y=(-2, 2), courses=4, voussoirs=2)
    >>> [block.name for block in freeform(points, thickness=0.2)][:3]
    ['vault.0.0', 'vault.0.1', 'vault.1.0']
    """
    points = _checked(points, supports, bond)
    along, across = (np.gradient(points, axis=axis, edge_order=2) for axis in (1, 0))
    normal = np.cross(along, across)
    length = np.linalg.norm(normal, axis=2)
    if not length.min() > 0:
        raise InputError("points coincide, or lie on a line, and leave the surface without a normal")
    normal /= length[..., None]
    thick = np.asarray(thickness(points[..., 0], points[..., 1]) if callable(thickness) else thickness, dtype=float)
    if not (np.isfinite(thick).all() and (thick > 0).all()):
        raise InputError("thickness must be above 0 everywhere [m]")
    if thick.ndim not in (0, 2) or (thick.ndim == 2 and thick.shape != points.shape[:2]):
        raise InputError(f"thickness has shape {thick.shape}; it must be one number or one for each point")
    half = np.broadcast_to(thick, points.shape[:2])[..., None] / 2 * normal
    sides = np.stack([points - half, points + half])
    _check_edges(sides, points)
    if springers:
        positive(springers=springers)
    # One row and column more on each side holds the far ends of the springers.
    cells = Cells(np.pad(sides, ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge"))
    for axis, tangent in ((0, across), (1, along)):
        unit = tangent / np.linalg.norm(tangent, axis=2)[..., None]
        cells.extend(axis, springers * unit)

    courses, columns = points.shape[0] - 1, points.shape[1] - 1
    blocks = []
    for course in range(courses):
        for i, (a, b) in enumerate(stones(columns, course if bond == "running" else 0)):
            blocks.append(cells.block(course, range(a, b), f"vault.{course}.{i}", f"vault.{course}"))
    for edge in supports if springers else ():
        axis, end = EDGES[edge]
        if axis == 0:
            course = courses - 1 if end else 0
            spans = [
                (courses if end else -1, range(a, b)) for a, b in stones(columns, course if bond == "running" else 0)
            ]
        else:
            spans = [(course, range(columns, columns + 1) if end else range(-1, 0)) for course in range(courses)]
        blocks += [cells.block(*s, f"springer.{edge}.{i}", f"springer.{edge}") for i, s in enumerate(spans)]
    return blocks


def _checked(points: Any, supports: Sequence[str], bond: str) -> Floats:
    points = np.array(points, dtype=float)
    if (
        points.ndim != 3
        or points.shape[2] != 3
        or points.shape[0] < 3
        or points.shape[1] < 3
        or points.shape[1] % 2 == 0
    ):
        raise InputError(
            f"points have shape {points.shape}; it must be (courses + 1, 2 voussoirs + 1, 3) with two courses or more"
        )
    if not np.isfinite(points).all():
        raise InputError("points must be finite")
    check_choice("bond", bond, BONDS)
    for edge in supports:
        if edge not in EDGES:
            raise InputError(f"supports: no edge {edge!r}; edges are: {', '.join(EDGES)}")
        if list(supports).count(edge) > 1:
            raise InputError(f"supports: the edge {edge!r} is given twice; give each of {', '.join(EDGES)} once")
    return points


def _check_edges(sides: Floats, points: Floats) -> None:
    """Raise InputError where a vault is thicker than its surface is curved, so that joints cross inside it."""
    for side in sides:
        for axis in (0, 1):
            bad = np.argwhere((np.diff(side, axis=axis) * np.diff(points, axis=axis)).sum(axis=2) <= 0)
            if len(bad):
                x, y, z = points[tuple(bad[0])]
                raise InputError(
                    f"thickness: joints cross near ({x:.3g}, {y:.3g}, {z:.3g}), where the surface is curved too "
                    "sharply for it"
                )


def stones(columns: int, course: int) -> list[tuple[int, int]]:
    """Columns of a grid between which the stones of a course lie.

    Parameters
    ----------
    columns : int
        Cells of the grid along the course, an even number.
    course : int
        An even course begins with a whole stone, an odd one with half a stone.

    Returns
    -------
    list of tuple
        First and last column of each stone.
    """
    cuts = list(range(0, columns + 1, 2)) if course % 2 == 0 else [0, *range(1, columns, 2), columns]
    return list(zip(cuts[:-1], cuts[1:], strict=True))


class Cells:
    """Hexahedra between two grids of corners, one row and one column larger than the vault on each side.

    Parameters
    ----------
    corners : ndarray
        Shape (2, rows, columns, 3), of the intrados and the extrados [m].
    """

    def __init__(self, corners: Floats) -> None:
        self.corners = corners  #: shape (2, rows, columns, 3): intrados and extrados

    def extend(self, axis: int, step: Floats) -> None:
        """Put the outermost rows or columns a step beyond the edge.

        Parameters
        ----------
        axis : int
            0 for rows, 1 for columns.
        step : ndarray
            Shape (rows - 2, columns - 2, 3) [m].
        """
        inner = self.corners[:, 1:-1, 1:-1]
        ends = (0, -1)
        for end, sign in zip(ends, (-1, 1), strict=True):
            place = (slice(None), end, slice(1, -1)) if axis == 0 else (slice(None), slice(1, -1), end)
            self.corners[place] = inner.take(end, axis=1 + axis) + sign * step.take(end, axis=axis)

    def block(self, course: int, columns: range, name: str, group: str) -> Block:
        """One stone of some cells of a course.

        Parameters
        ----------
        course : int
            Row of the cells.
        columns : range
            Columns of the cells.
        name : str
            Of the block.
        group : str
            Of the block.

        Returns
        -------
        Block
            The cells fused.
        """
        return fuse([self._cell(course + 1, column + 1) for column in columns], name=name, group=group)

    def _cell(self, i: int, j: int) -> Block:
        plan = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
        index = [np.ravel_multi_index((side, *p), self.corners.shape[:3]) for side in (0, 1) for p in plan]
        order = np.argsort(index)
        vertices = self.corners.reshape(-1, 3)[index]
        rank = np.empty(8, dtype=int)
        rank[order] = np.arange(8)
        return polyhedron(vertices, [part for face in FACES for part in split_face(vertices, face, rank)])


def split_face(vertices: Floats, face: Sequence[int], rank: Any) -> list[list[int]]:
    """A plane quadrilateral as it is, another one as two triangles.

    It is judged and split by the order of its corners in the grid, so that both blocks that share it do the same.

    Parameters
    ----------
    vertices : ndarray
        Corners of the block, shape (n, 3) [m].
    face : sequence of int
        Its four corners.
    rank : array_like
        Place of each corner in the order of the grid, shape (n,).

    Returns
    -------
    list of list of int
        One face or two.
    """
    first = min(range(4), key=lambda k: rank[face[k]])
    a, b, c, d = (face[(first + k) % 4] for k in range(4))
    p, *others = vertices[sorted(face, key=lambda k: rank[k])]
    edges = np.array(others) - p
    if abs(np.linalg.det(edges)) <= PLANE * np.linalg.norm(edges, axis=1).max() ** 3:
        return [[a, b, c, d]]
    return [[a, b, c], [a, c, d]]
