"""Whether a block can be put in by a straight motion that collides with nothing.

A block that comes along -d leaves along d. Its joints leave a cone of directions open, {d : n'd >= 0} with n their
normals towards the block. Tried are upwards, the direction of the cone that is furthest from all joints, the mean of
their normals, the horizontals, the tangents of the joints, the edges of the cone, and the normals. That no straight
motion exists is proven only where the cone is empty.

Blocks are cut into convex pieces. A piece A that moves along d runs into a piece B where the ray of d passes through
the polytope B - A = {b - a}. Its faces have normals of B, opposite ones of A, or the directions of the cross products
of their edges. No collision is missed, since half-spaces of any other normals only enlarge the polytope. The ray must
pass through it deeper than a tolerance: a block that slides along its joints grazes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.contact.overlap.penetration import convex_blocks
from blockstat.geometry.convex_pieces import convex_pieces
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.geometry.triangulation import triangulate
from blockstat.loads import up_of
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A motion may pass through another block, deeper than the two overlap already, by this share of the smaller one.
DEPTH = 1e-3
#: A block is convex, and a piece of it, if no corner is in front of its faces by more than this share of its size.
CONVEX = 1e-4
#: Pieces in which no larger ball fits, as a share of the size of their block, are left out.
SLIVER = 1e-5
#: Directions that lean into a joint by less than this sine are tried.
ALONG = 1e-3
#: Joints block every direction only if their planes must move by more than this, of a step of 1, for one to be open.
BLOCKED = 0.1
#: Vectors are the same, or of no length, below this.
SAME = 1e-6


@dataclass(frozen=True)
class StraightMotion:
    """How blocks come in as one, or that they cannot."""

    direction: Floats | None  #: a unit vector; None where none of those that were tried is free
    is_excluded: bool = False  #: whether no straight motion at all exists, because joints block every direction


class StraightMotions:
    """The straight motions of the blocks of an assembly; shapes that were needed once are kept.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    interfaces : Interfaces
        Their joints.

    Examples
    --------
    A drawer between two cheeks and below a lid comes in from the front.

    >>> import numpy as np
    >>> from blockstat import Assembly, box, find_interfaces
    >>> from blockstat.sequence.insertion import StraightMotions
    >>> blocks = [box((0, 0, 0), (3, 1, 1)), box((0, 0, 1), (1, 1, 2)), box((2, 0, 1), (3, 1, 2)),
    ...           box((0, 0, 2), (3, 1, 3)), box((1, 0, 1), (2, 1, 2))]
    >>> chest = Assembly.from_blocks(blocks, supports=[0])
    >>> motions = StraightMotions(chest, find_interfaces(chest))
    >>> np.abs(motions.find([4], np.ones(5, bool)).direction).round(6).tolist()
    [0.0, 1.0, 0.0]
    """

    def __init__(self, assembly: Assembly, interfaces: Interfaces) -> None:
        self._assembly, self._interfaces = assembly, interfaces
        self._up = up_of(assembly)
        self._convex = convex_blocks(assembly, tolerance=CONVEX)
        self._pieces: dict[int, list[_Piece]] = {}
        self._obstacles: dict[tuple[int, int], list[_Obstacle]] = {}

    def find(self, blocks: Sequence[int], present: np.ndarray) -> StraightMotion:
        """Find a way for blocks to come in beside others, all along one direction.

        Parameters
        ----------
        blocks : sequence of int
            The blocks, which are put in as one.
        present : array of bool, shape (n_blocks,)
            Which others are there.

        Returns
        -------
        StraightMotion
            The first direction that is free, or whether there is none.
        """
        away = _distinct(self._normals(blocks, present), sided=True)
        others = np.setdiff1d(np.flatnonzero(present), blocks)
        tried = self._up[None]
        for is_last in (False, True):
            tried = tried[(tried @ away.T >= -ALONG).all(axis=1)]
            free = np.flatnonzero(~np.any([self._collides(block, others, tried) for block in blocks], axis=0))
            if len(free):
                return StraightMotion(-tried[free[0]])
            if not is_last:
                margin, inward = _opening(away)
                if margin < -BLOCKED:
                    return StraightMotion(None, is_excluded=True)
                tried = self._directions(away, inward)
        return StraightMotion(None)

    def _normals(self, blocks: Sequence[int], present: np.ndarray) -> Floats:
        """Normals of the joints of blocks with others that are present, towards the blocks, shape (n, 3)."""
        pair = self._interfaces.pair
        inside = np.isin(pair, blocks)
        own = (inside.sum(axis=1) == 1) & (present[pair] | inside).all(axis=1)
        sign = np.where(inside[own, 1], 1.0, -1.0)
        return self._interfaces.frame[own, 0] * sign[:, None]

    def _directions(self, away: Floats, inward: Floats) -> Floats:
        """Unit vectors that are tried where the way upwards is not free, shape (n, 3)."""
        axis = np.eye(3)[np.abs(self._up).argmax() - 1]
        axis = axis - (axis @ self._up) * self._up
        level = np.array([axis, _cross(self._up, axis)])
        rise = self._up - (away @ self._up)[:, None] * away
        course = _cross(self._up, away)
        slant = _cross(away[:, None], level[None]).reshape(-1, 3)  # where a joint is level rise and course are nothing
        first, second = np.triu_indices(len(away), 1)
        both = np.concatenate([level, rise, course, slant, _cross(away[first], away[second])])
        found = np.concatenate([inward[None], away.sum(axis=0)[None], both, -both, away])
        return _distinct(found, sided=True)

    def _collides(self, block: int, others: Ints, directions: Floats) -> np.ndarray:
        """Whether a block that leaves along each of some directions runs into one of the others."""
        lower, upper = self._assembly.bounds
        walls = np.tile(np.vstack([np.eye(3), -np.eye(3)]), (len(others), 1))
        room = np.hstack([upper[others] - lower[block], upper[block] - lower[others]]).ravel()
        near = _passes(walls, room, np.arange(0, len(room), 6), directions).any(axis=1)  # by the boxes around blocks
        found = [obstacle for other in others[near].tolist() for obstacle in self._between(block, other)]
        if not found:
            return np.zeros(len(directions), dtype=bool)
        first = np.cumsum([0, *(len(one.reach) for one in found[:-1])])
        axes, reach = (np.concatenate([getattr(one, name) for one in found]) for name in ("axes", "reach"))
        return np.asarray(_passes(axes, reach, first, directions).any(axis=0))

    def _between(self, block: int, other: int) -> list[_Obstacle]:
        """What stands in the way of a block because of another: one polytope for each two of their pieces."""
        if (block, other) not in self._obstacles:
            depth = DEPTH * float(self._assembly.size[[block, other]].min())
            pairs = [(mine, theirs) for mine in self._of(block) for theirs in self._of(other)]
            self._obstacles[block, other] = [_obstacle(mine, theirs, depth) for mine, theirs in pairs]
        return self._obstacles[block, other]

    def _of(self, block: int) -> list[_Piece]:
        """The convex pieces of a block."""
        if block not in self._pieces:
            self._pieces[block] = (
                [_whole(self._assembly, block)] if self._convex[block] else _cut(self._assembly, block)
            )
        return self._pieces[block]


@dataclass(frozen=True, eq=False)
class _Piece:
    corner: Floats  #: shape (n, 3) [m]
    normal: Floats  #: outward normals of the faces, shape (n, 3)
    edge: Floats  #: directions of the edges, shape (n, 3)


@dataclass(frozen=True, eq=False)
class _Obstacle:
    """The polytope {x : axes x <= reach} through which a block must not pass."""

    axes: Floats  #: shape (n, 3)
    reach: Floats  #: less the tolerance, shape (n,) [m]


def _whole(assembly: Assembly, block: int) -> _Piece:
    """A block that is convex, as one piece."""
    corner = assembly.block_vertices(block)
    normal = assembly.planes.normal[assembly.face_block == block]
    sides = [corner[np.roll(face, -1)] - corner[face] for face in map(np.asarray, assembly.faces_of(block))]
    return _Piece(corner, _distinct(normal, sided=True), _distinct(np.concatenate(sides), sided=False))


def _cut(assembly: Assembly, block: int) -> list[_Piece]:
    """A block that is not convex, in convex pieces."""
    corner, size = assembly.block_vertices(block), float(assembly.size[block])
    lower, upper = (bound[[block]] for bound in assembly.bounds)
    triangles = corner[triangulate(corner, assembly.faces_of(block))]
    planes = convex_pieces([triangles], lower, upper, np.array([CONVEX * size]))[0]
    found = (_piece(own, (lower + upper)[0] / 2, size) for own in planes)
    return [piece for piece in found if piece is not None]


def _piece(planes: Floats, origin: Floats, size: float) -> _Piece | None:
    """The corners and edges of a piece from its planes; None for a sliver."""
    from scipy.spatial import HalfspaceIntersection

    normal, offset = planes[:, :3], planes[:, 3] - planes[:, :3] @ origin
    radius, centre = inscribed_balls(normal, offset, np.array([0, len(normal)]), np.zeros(1))
    if radius[0] < SLIVER * size:
        return None
    corner = HalfspaceIntersection(np.column_stack([normal, -offset]), centre[0]).intersections
    on = np.abs(corner @ normal.T - offset) <= CONVEX * size
    faces = on.sum(axis=0) >= 3
    normal, on = normal[faces], on[:, faces]
    first, second = np.nonzero(np.triu(on.T.astype(int) @ on, 1) >= 2)
    return _Piece(corner + origin, normal, _distinct(_cross(normal[first], normal[second]), sided=False))


def _obstacle(mine: _Piece, theirs: _Piece, depth: float) -> _Obstacle:
    """The polytope of what a piece may not move by because of another, less the tolerance."""
    cross = _cross(mine.edge[:, None], theirs.edge[None]).reshape(-1, 3)
    axes = _distinct(np.concatenate([theirs.normal, -mine.normal, cross, -cross]), sided=True)
    reach = (theirs.corner @ axes.T).max(axis=0) - (mine.corner @ axes.T).min(axis=0)
    return _Obstacle(axes, reach - depth - max(float(reach.min()), 0.0))


def _passes(axes: Floats, reach: Floats, first: Ints, directions: Floats) -> np.ndarray:
    """Whether rays from the origin pass through polytopes, shape (n_polytopes, n_directions); each begins at a row."""
    if not len(first):
        return np.zeros((0, len(directions)), dtype=bool)
    rate = axes @ directions.T
    along = np.abs(rate) < 1e-12
    bound = reach[:, None] / np.where(along, 1.0, rate)
    shut = np.where(reach > 0, np.inf, -np.inf)[:, None]
    most = np.where(rate > 0, bound, np.inf)
    end = np.minimum.reduceat(np.where(along, shut, most), first)
    begin = np.maximum.reduceat(np.where(~along & (rate < 0), bound, 0.0), first)
    return np.asarray(end > begin)


def _opening(away: Floats) -> tuple[float, Floats]:
    """How far the planes of joints must at least move out for a direction to be open, below zero, and one inside.

    A vector of the cone may be made to end on a side of the cube from -1 to 1: its joints bound a set on each side. The
    ball in the cone and the cube has its centre far from all joints.
    """
    walls, n = np.concatenate([np.eye(3), -np.eye(3)]), len(away)
    normal = np.tile(np.concatenate([-away, walls]), (7, 1))
    offset = np.tile(np.concatenate([np.zeros(n), np.ones(6)]), (7, 1))
    offset[np.arange(6), n + (np.arange(6) + 3) % 6] = -1.0  # on the side k the opposite wall is moved there, too
    radius, centre = inscribed_balls(normal, offset.reshape(-1), np.arange(8) * (n + 6))
    return float(radius[:6].max()), centre[6]


def _cross(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.cross(one, other), dtype=float)


def _distinct(vectors: Floats, *, sided: bool) -> Floats:
    """Unit vectors of some vectors, each direction once, in their order; without a side, opposite ones are the same."""
    length = np.linalg.norm(vectors, axis=1)
    unit = vectors[length > SAME] / length[length > SAME, None]
    keys = np.round(unit, 6) + 0.0
    if not sided:
        rows = np.arange(len(keys))
        keys *= np.sign(keys[rows, (keys != 0).argmax(axis=1)])[:, None]
    kept = np.unique(keys, axis=0, return_index=True)[1]
    return unit[np.sort(kept)]
