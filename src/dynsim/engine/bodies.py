"""The shape of each block as the engines need it: a box, a convex hull, or convex pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import near_blocks
from blockstat.contact.tolerance import GAP, allowed_gap
from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints
from dynsim.engine.decompose import FLUSH, Cut, convex_pieces
from dynsim.engine.filling import fills, prisms

#: A block whose hull is larger by more than this fraction is not convex.
CONVEX = 1e-6
#: Right angles and equal edges to this fraction of the block's size make a box.
SQUARE = 1e-7

#: Where diagonals across bent faces change the volume of a block by more than this fraction, they make another block of
#: it, and these faces are split about their middle, as statics split them.
BENT = 1e-2
#: A support of more triangles than the first number is cut into prisms where it can be, before other cuts are tried.
#: CoACD moves the faces of such a relief, and takes minutes for a support of more than the second: they are refused.
MANY, TOO_MANY = 1000, 2000
#: So many of the largest faces of a support are tried as the plane that it rises from, before a level one.
PLANES = 6
#: A block has to stand this far within one prism, relative to its size. Where one of its faces is in line with the side
#: of another prism, Bullet may find a normal across that side, and the block does not slide at any angle.
WITHIN = 0.1
#: Steps in which Bullet's convex hulls measure a block (btConvexHullComputer).
GRID = 10216


@dataclass(frozen=True)
class Shape:
    """Geometry of one block in the frame of its principal axes, with the centroid at the origin."""

    rotation: Floats  #: shape (3, 3), columns are the axes in world coordinates
    half_extents: Floats | None  #: shape (3,) for a box, else None
    pieces: tuple[Floats, ...]  #: vertices of the convex pieces, shape (k, 3) each
    inertia: Floats  #: shape (3,), principal moments [kg m2]
    filled: bool = False  #: whether the pieces fill recesses deeper than statics bridge in a joint


def shapes(assembly: Assembly, *, exact: bool = False) -> list[Shape]:
    """Return the shapes of all blocks as the engines need them.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    exact : bool
        Keep warped faces in their places, by more pieces. Bullet cannot use such pieces (see
        `dynsim.engine.decompose`).

    Returns
    -------
    list of Shape
        One a block.
    """
    bridged = allowed_gap(assembly, GAP)
    depth = bridged.copy()
    one, two = near_blocks(assembly).T
    np.minimum.at(depth, one, bridged[two])
    np.minimum.at(depth, two, bridged[one])
    return [_shape(assembly, block, float(depth[block]), exact) for block in range(assembly.n_blocks)]


def filled_blocks(assembly: Assembly, found: Sequence[Shape]) -> tuple[str, ...]:
    """Return the names of blocks whose pieces fill recesses deeper than statics bridge in a joint.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    found : sequence of Shape
        Their shapes.

    Returns
    -------
    tuple of str
        What stands over such a recess would stand on the filling.
    """
    return tuple(name for name, shape in zip(assembly.names, found, strict=True) if shape.filled)


def likeness(shape: Shape, step: float) -> bytes:
    """Return a key that blocks of the same shape have in common.

    Parameters
    ----------
    shape : Shape
        Shape of a block.
    step : float
        Corners are rounded to multiples of this length [m].

    Returns
    -------
    bytes
        The number of corners of each piece, and the corners.
    """
    counts = np.array([len(shape.pieces), *map(len, shape.pieces)], dtype=np.int64)
    return counts.tobytes() + np.rint(np.concatenate(shape.pieces) / step).astype(np.int64).tobytes()


def _shape(assembly: Assembly, block: int, depth: float, exact: bool) -> Shape:
    local = assembly.block_vertices(block) - assembly.centroid[block]
    faces = assembly.faces_of(block)
    box = _as_box(local, faces, assembly.size[block])
    if box is not None:
        rotation, half = box
        moments = assembly.mass[block] / 3 * (half @ half - half**2)
        return Shape(rotation, half, (local @ rotation,), moments)
    moments, rotation = _axes(assembly.inertia[block], bool(assembly.support[block]))
    local = local @ rotation
    hull, volume = _hull(local), float(assembly.volume[block])
    # A recess that is narrow beside the block is little of its volume; one that is not needs no closer look.
    hollow = hull.volume > (1 + CONVEX) * volume
    if not hollow and not fills(local[triangulate(local, faces)], [hull], min(FLUSH * assembly.size[block], depth)):
        return Shape(rotation, None, (local[hull.vertices],), moments)
    relief = _Relief(assembly, block, rotation) if assembly.support[block] else None
    cut = _cut(local, faces, float(assembly.size[block]), depth, volume, relief, exact=exact)
    return Shape(rotation, None, cut.pieces, moments, cut.filled)


class _Relief:
    """A support that may be a relief above one of its largest faces, or above a level plane."""

    def __init__(self, assembly: Assembly, block: int, rotation: Floats) -> None:
        place, middle = assembly.block_vertices(block), assembly.centroid[block]
        faces = assembly.faces_of(block)
        outward = np.array(
            [np.cross(place[face] - middle, place[np.roll(face, -1)] - middle).sum(axis=0) for face in faces]
        )
        largest = np.argsort(-np.linalg.norm(outward, axis=1), kind="stable")[:PLANES]
        ups = np.vstack([-outward[largest], -np.asarray(assembly.gravity)]) @ rotation
        self._ups = ups / np.linalg.norm(ups, axis=1)[:, None]
        free = np.flatnonzero(~assembly.support).tolist()
        self._others = [(assembly.block_vertices(other) - middle) @ rotation for other in free]
        self._margin = WITHIN * assembly.size[free]
        self._size = float(assembly.size[block])
        self._label = f'support "{assembly.names[block]}" is not convex and has {len(faces)} faces'

    def prisms(self, surface: Floats) -> list[Floats]:
        """The prisms of a solid; none where it is no relief, or where a block is near several of them."""
        found = self._prisms(surface)
        return found if found and _each_on_one(found, self._others, self._margin) else []

    def _prisms(self, surface: Floats) -> list[Floats]:
        return prisms(surface, self._size, FLUSH, self._ups, np.concatenate([np.empty((0, 3)), *self._others]))

    def check(self, surface: Floats) -> None:
        """Raise InputError for a solid that takes minutes to cut, and whose pieces would be others than the solid."""
        if len(surface) > TOO_MANY or (len(surface) > MANY and self._prisms(surface)):
            raise InputError(
                f"{self._label}, and no cut into convex pieces was found that keeps them. Put boxes in its place, one "
                "below each plane part that blocks stand on, and make these the supports (`--supports`); or draw it "
                "as a relief above one plane, in which each block stands on one plane part that reaches "
                f"{WITHIN:g} of the block's size beyond it"
            )


def _each_on_one(pieces: Sequence[Floats], others: Sequence[Floats], margin: Floats) -> bool:
    """Whether no block is near more than one of the pieces, by their bounding boxes."""
    lower, upper = (np.array([end(piece, axis=0) for piece in pieces]) for end in (np.min, np.max))
    near = [
        ((lower < corners.max(axis=0) + own) & (upper > corners.min(axis=0) - own)).all(axis=1).sum()
        for corners, own in zip(others, margin, strict=True)
    ]
    return max(near, default=0) <= 1


def _axes(inertia: Floats, fixed: bool) -> tuple[Floats, Floats]:
    """Principal moments and axes (columns, right-handed); the axes of the scene where those do as well.

    A fixed block needs no principal axes, and faces square to the axes of its frame are exact in Bullet (`on_grid`).
    """
    own = np.diag(inertia)
    if fixed or np.abs(inertia - np.diag(own)).max() <= SQUARE * own.max():
        return own.copy(), np.eye(3)
    moments, rotation = np.linalg.eigh(inertia)
    if np.linalg.det(rotation) < 0:
        rotation[:, 0] *= -1
    return moments, rotation


def _as_box(local: Floats, faces: Sequence[np.ndarray], size: float) -> tuple[Floats, Floats] | None:
    """Axes (columns, right-handed) and half extents if the block is a rectangular box."""
    if len(local) != 8 or len(faces) != 6 or any(len(face) != 4 for face in faces):
        return None
    neighbours = {int(f[(i + step) % 4]) for f in faces for i in range(4) if f[i] == 0 for step in (1, 3)}
    if len(neighbours) != 3:
        return None
    edges = np.array([local[k] - local[0] for k in sorted(neighbours)])
    length = np.linalg.norm(edges, axis=1)
    axes = edges / length[:, None]
    if np.abs(axes @ axes.T - np.eye(3)).max() > SQUARE:
        return None
    corners = (np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T * length) @ axes
    distance = np.linalg.norm(local[:, None] - corners[None], axis=2).min(axis=1)
    if distance.max() > SQUARE * size:
        return None
    if np.linalg.det(axes) < 0:
        axes[2] *= -1
    return axes.T, length / 2


def _hull(points: Floats):
    from scipy.spatial import ConvexHull

    return ConvexHull(points)


def _cut(
    local: Floats,
    faces: Sequence[np.ndarray],
    size: float,
    depth: float,
    volume: float,
    relief: _Relief | None,
    *,
    exact: bool,
) -> Cut:
    """Convex pieces of a concave block, of each of its separate solids by itself."""
    solids = _solids(local, faces, size)
    if len(solids) == 1:
        return _cut_solid(local, faces, size, depth, volume, relief, exact=exact)
    found = []
    for corners, own in solids:
        own_volume = _volume(_split_alike(corners, own, size))
        hull = _hull(corners)
        if hull.volume <= (1 + CONVEX) * own_volume and not fills(corners[triangulate(corners, own)], [hull], depth):
            found.append(Cut((corners[hull.vertices],), False))
        else:
            found.append(_cut_solid(corners, own, size, depth, own_volume, relief, exact=exact))
    return Cut(tuple(piece for cut in found for piece in cut.pieces), any(cut.filled for cut in found))


def _solids(local: Floats, faces: Sequence[np.ndarray], size: float) -> list[tuple[Floats, list[Ints]]]:
    """Corners and faces of each of the separate solids of a block; the whole block where one is a hollow in another."""
    keys = np.round(local / (FLUSH * size)).astype(np.int64)
    place = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    sides = np.concatenate([place[np.stack([face, np.roll(face, -1)], axis=1)] for face in faces])
    label = connected_components(int(place.max()) + 1, sides)[1][place]
    owner = label[[face[0] for face in faces]]
    found = []
    for part in np.unique(owner):
        own = [face for face, its in zip(faces, owner, strict=True) if its == part]
        kept, renumbered = np.unique(np.concatenate(own), return_inverse=True)
        ends = np.cumsum([len(face) for face in own])[:-1]
        found.append((local[kept], np.split(renumbered.reshape(-1), ends)))
    if any(_volume(_split_alike(corners, own, size)) <= 0 for corners, own in found):
        return [(local, list(faces))]
    return found


def _cut_solid(
    local: Floats,
    faces: Sequence[np.ndarray],
    size: float,
    depth: float,
    volume: float,
    relief: _Relief | None,
    *,
    exact: bool,
) -> Cut:
    """Convex pieces of a concave block: exact cuts, or CoACD (Wei et al. 2022) where those fail."""
    if exact and (found := convex_pieces(_split_alike(local, faces, size), size, depth, exact=True)):
        if not found.filled:
            return found
    triangles = triangulate(local, faces)
    surfaces = [local[triangles], _split_alike(local, faces, size)]
    if abs(_volume(surfaces[0]) / volume - 1.0) > BENT:
        surfaces.reverse()
    if np.array_equal(surfaces[0], surfaces[1]):
        surfaces.pop()
    if relief and len(surfaces[0]) > MANY and (found := relief.prisms(surfaces[0])):
        return Cut(tuple(found), False)
    planes = not relief or len(surfaces[0]) <= TOO_MANY
    first = None
    for surface in surfaces:
        if (found := convex_pieces(surface, size, depth, planes=planes)) and not found.filled:
            return found
        first = first or found
    if relief and (found := relief.prisms(surfaces[0])):
        return Cut(tuple(found), False)
    if first:
        return first
    if relief:
        relief.check(surfaces[0])
    try:
        import coacd
    except ImportError as error:
        raise InputError(
            "a block is not convex, and no exact cut into convex pieces was found; cutting it all the same needs the "
            'package coacd: pip install "blockstat[dynamics]"'
        ) from error
    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(local, triangles.astype(np.int32)), threshold=0.02, seed=0)
    hulls = [_hull(np.asarray(vertices)) for vertices, _ in parts]
    return Cut(tuple(hull.points[hull.vertices] for hull in hulls), fills(local[triangles], hulls, depth))


def _volume(surface: Floats) -> float:
    """Volume within the triangles of a closed surface [m3]."""
    return float(np.einsum("ij,ij->i", surface[:, 0], np.cross(surface[:, 1], surface[:, 2])).sum()) / 6


def _split_alike(local: Floats, faces: Sequence[np.ndarray], size: float) -> Floats:
    """Corners of the triangles of a surface, shape (k, 3, 3).

    A warped face is split about the mean of its corners, as for the volume: both blocks at a joint have the same
    triangles then, whatever their frames.
    """
    found = []
    for face in faces:
        corners = local[face]
        mean = corners.mean(axis=0)
        if len(face) > 3 and np.linalg.svd(corners - mean, compute_uv=False)[2] > FLUSH * size:
            following = np.roll(corners, -1, axis=0)
            found.append(np.stack([np.broadcast_to(mean, corners.shape), corners, following], axis=1))
        else:
            found.append(local[triangulate(local, [face])])
    return np.concatenate(found)


def on_grid(points: Floats) -> Floats:
    """Return corners moved to the nearest that Bullet can keep.

    Parameters
    ----------
    points : array of float, shape (k, 3)
        Corners of a convex hull [m].

    Returns
    -------
    array of float, shape (k, 3)
        The corners on the grid [m].

    Notes
    -----
    Bullet makes hulls in whole numbers: it divides each axis of the bounding box into `GRID` steps and cuts coordinates
    off towards its centre. Corners are put on the nearest step, and a quarter of one beyond it, to be cut off there.
    """
    lower, upper = points.min(axis=0), points.max(axis=0)
    step = (upper - lower) / GRID
    count = np.rint((points - (lower + upper) / 2) / step)
    kept = np.where(np.abs(count) < GRID / 2, count + 0.25 * np.sign(count), count)
    return (lower + upper) / 2 + kept * step


def outward_hull(points: Floats) -> tuple[Ints, float]:
    """Return the triangles of a convex hull.

    Parameters
    ----------
    points : array of float, shape (k, 3)
        Its corners [m].

    Returns
    -------
    triangles : array of int, shape (m, 3)
        Corners of each triangle, counter-clockwise seen from outside.
    volume : float
        Volume [m3].
    """
    hull = _hull(points)
    corners = hull.simplices.astype(np.int64)
    a, b, c = points[corners].swapaxes(0, 1)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    corners[inward] = corners[inward][:, [0, 2, 1]]
    return corners, float(hull.volume)


def hull_obj(pieces: Sequence[Floats]) -> str:
    """Return convex pieces as the text of an OBJ file.

    Parameters
    ----------
    pieces : sequence of arrays of float, shape (k, 3)
        Corners of each piece [m].

    Returns
    -------
    str
        One object a piece.
    """
    lines, offset = [], 1
    for number, points in enumerate(map(on_grid, pieces)):
        lines.append(f"o piece{number}")
        lines += ["v " + " ".join(map(repr, point)) for point in points.tolist()]
        lines += ["f " + " ".join(map(str, face)) for face in (outward_hull(points)[0] + offset).tolist()]
        offset += len(points)
    return "\n".join(lines) + "\n"
