"""What is left of contacts of edges and corners where the faces and edges that they bear on lose their rims."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import WIDTH, Interfaces
from blockstat.geometry.topology import edge_topology
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Facets whose normals have at least this cosine with that of a contact, or with each other, are one face, and edges
#: whose directions have it are one edge. Chosen: within eight degrees.
ALONG = 0.99
#: What lies along a face rises by this at most: the sine of the same angle.
LEVEL = float(np.sqrt(1 - ALONG**2))
#: Facets and edges of a block are in the plane of a contact when they are no further from it than this, relative to the
#: smaller block, and its gap. Chosen: parallel faces of a block are further apart.
IN_PLANE = 1e-3
#: Sides of a polygon about a quarter of a circle: within a thousandth of it.
QUARTER = 18


class BareContacts:
    """The faces and the edges on which contacts without area bear.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    width
        How much the blocks of each joint lose along their rims, shape (n_interfaces,) [m].

    Notes
    -----
    A rim of a face is a convex edge at which the surface turns by more than `ALONG`. An edge between facets of a rough
    face is none, and at a re-entrant one there is stone on both sides.
    """

    def __init__(self, assembly: Assembly, interfaces: Interfaces, width: Floats) -> None:
        self._assembly, self._interfaces, self._width = assembly, interfaces, width
        self._first_face = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
        self._size = assembly.size[interfaces.pair].min(axis=1)
        self._near = IN_PLANE * self._size + interfaces.gap
        self._edges: dict[int, tuple[Ints, Floats]] = {}

    def left(self, joint: int, points: Floats) -> Floats:
        """Return what the lost rims leave of an edge, a corner or a crossing.

        Parameters
        ----------
        joint
            Number of the joint that it is or belongs to.
        points
            The ends of the edge, or one point, shape (n, 3) [m].

        Returns
        -------
        Floats
            The ends of what is left, shape (k, 3) [m]: nothing where the faces that it bears on are nowhere as far as
            the width from their rims. Where two edges cross, nothing if a slip of this width parts them. All of what
            bears on no face and no edge that is found.
        """
        kind = self._interfaces.kinds[joint]
        found = None if kind == ContactKind.CROSSING else self._left_on_faces(joint, points)
        if found is not None:
            return found
        # A single point that is part of a patch may be one where edges cross.
        crosses = len(points) == 1 and kind in (ContactKind.CROSSING, ContactKind.FACE)
        return self._left_of_crossing(joint, points) if crosses else points

    def _left_on_faces(self, joint: int, points: Floats) -> Floats | None:
        """What lies on faces further from their rims than the width; None where it is on no face."""
        import shapely

        across = self._interfaces.frame[joint, 1:]
        bare = shapely.MultiPoint((points - points[0]) @ across.T).convex_hull
        sides = self._interfaces.pair[joint].tolist()
        rims = [self._rims(joint, own, points[0], bare) for own in sides if self._is_on_face(joint, own, points, bare)]
        if not rims:
            return None
        # An edge or a corner of a block is on its rims, and bears on the face of the other one. Points are halfway
        # across the gap, and so beside what they are of where that leans.
        rounding = WIDTH * self._size[joint] + LEVEL * self._interfaces.gap[joint]
        others = [own for own in rims if not shapely.buffer(own, rounding).contains(bare)]
        lost = shapely.buffer(shapely.union_all(others), self._width[joint], quad_segs=QUARTER)
        left = shapely.get_coordinates(shapely.difference(bare, lost) if others else shapely.Point())
        if len(points) > 1:
            # What is between parts of an edge adds nothing to the forces at their ends.
            along = (points[-1] - points[0]) @ across.T
            order = np.argsort(left @ along)
            left = left[order[[0, -1]]] if len(order) and np.ptp(left @ along) > 0 else left[:0]
        return points[0] + left @ across

    def _is_on_face(self, joint: int, block: int, points: Floats, bare: Any) -> bool:
        """Whether a contact touches a facet of a block that lies along the plane of the joint."""
        import shapely

        assembly, near = self._assembly, self._near[joint]
        normal, across = self._interfaces.frame[joint, 0], self._interfaces.frame[joint, 1:]
        own = slice(*self._first_face[[block, block + 1]])
        lower, upper = (bound[own] for bound in assembly.face_bounds)
        close = (lower <= points.max(axis=0) + near).all(axis=1) & (upper >= points.min(axis=0) - near).all(axis=1)
        along = np.abs(assembly.planes.normal[own] @ normal) > ALONG
        for face in (own.start + np.flatnonzero(close & along)).tolist():
            ring = assembly.vertices[assembly.face_vertices[slice(*assembly.face_start[[face, face + 1]])]]
            if shapely.Polygon((ring - points[0]) @ across.T).distance(bare) <= WIDTH * self._size[joint]:
                return True
        return False

    def _rims(self, joint: int, block: int, origin: Floats, bare: Any) -> Any:
        """Rims of the face of a block that are no further from a contact than the width, in the plane of the joint."""
        import shapely

        width, normal, across = self._width[joint], *np.split(self._interfaces.frame[joint], [1])
        ends, inward = self._edges_of(block)
        edges = self._assembly.vertices[ends] - origin
        height, flat = edges @ normal[0], edges @ across.T
        line = np.diff(edges, axis=1)[:, 0]
        level = np.abs(line @ normal[0]) <= LEVEL * np.linalg.norm(line, axis=1)
        level &= (np.abs(inward @ normal[0]) <= LEVEL).any(axis=1)
        sharp = np.einsum("ij,ij->i", inward[:, 0], inward[:, 1]) > -ALONG
        # Along the face the rim is as far below or above the contact as this at most.
        beside = self._near[joint] + width * LEVEL / ALONG
        chosen = level & sharp & (height.min(axis=1) <= beside) & (height.max(axis=1) >= -beside)
        height, rims = height[chosen], np.asarray(shapely.linestrings(flat[chosen]))
        between = shapely.shortest_line(rims, bare)
        at = shapely.line_locate_point(rims, shapely.get_point(between, 0), normalized=True)
        off = np.abs(height[:, 0] + at * (height[:, 1] - height[:, 0]))
        return shapely.union_all(rims[(shapely.length(between) <= width) & (off <= beside)])

    def _left_of_crossing(self, joint: int, points: Floats) -> Floats:
        """The point where two edges cross, unless a slip of the width in the plane of the joint parts them.

        It parts them past an end of one of them: past the line through this end along the other edge.
        """
        frame = self._interfaces.frame[joint]
        edges = [self._edge_at(joint, block, points[0]) for block in self._interfaces.pair[joint].tolist()]
        flat = [(edge - points[0]) @ frame[1:].T for edge in edges if edge is not None]
        if len(flat) < 2:
            return points
        along = [(tail - head) / np.linalg.norm(tail - head) for head, tail in flat]
        aside = [np.array([-u[1], u[0]]) for u in along]
        slip = min(float(np.abs(flat[k] @ aside[1 - k]).min()) for k in (0, 1))
        return points if slip > self._width[joint] else points[:0]

    def _edge_at(self, joint: int, block: int, point: Floats) -> Floats | None:
        """The ends of the edge of a block that runs in the plane of a joint through a point, shape (2, 3) [m]."""
        ends = self._edges_of(block)[0]
        edges = self._assembly.vertices[ends] - point
        normal, *across = self._interfaces.frame[joint]
        height, flat = edges @ normal, edges @ np.transpose(across)
        line = flat[:, 1] - flat[:, 0]
        square = np.einsum("ij,ij->i", line, line)
        share = -np.einsum("ij,ij->i", flat[:, 0], line) / np.where(square > 0, square, 1.0)
        away = np.linalg.norm(flat[:, 0] + np.clip(share, 0.0, 1.0)[:, None] * line, axis=1)
        # The normal is at right angles to both edges: of those that pass nearby the level one is meant.
        near = self._near[joint]
        off = np.where(np.abs(height).min(axis=1) < near, away + np.abs(np.diff(height, axis=1))[:, 0], np.inf)
        if not off.min(initial=np.inf) < near:
            return None
        return self._assembly.vertices[self._whole_edge(ends, int(off.argmin()))]

    def _whole_edge(self, ends: Ints, one: int) -> Ints:
        """The ends of the row of edges that goes on in the direction of one of them."""
        corner = self._assembly.vertices
        found = ends[one].copy()
        unit = corner[found[1]] - corner[found[0]]
        unit /= np.linalg.norm(unit)
        for end, ahead in ((0, -unit), (1, unit)):
            for _ in range(len(ends)):
                rows, column = np.nonzero(ends == found[end])
                other = ends[rows, 1 - column]
                arm = corner[other] - corner[found[end]]
                turn = arm @ ahead / np.linalg.norm(arm, axis=1)
                if turn.max(initial=-1.0) < ALONG:
                    break
                found[end] = other[turn.argmax()]
        return found

    def _edges_of(self, block: int) -> tuple[Ints, Floats]:
        """The convex edges of a block: vertices at their ends, (n, 2), and directions into their faces, (n, 2, 3)."""
        if block not in self._edges:
            # All blocks of such contacts at once: the topology of an assembly costs more than that of a block.
            bare = self._interfaces.kinds != ContactKind.FACE
            blocks: Ints = np.union1d(self._interfaces.pair[bare], block)
            topology = edge_topology(self._assembly, blocks)
            for own in blocks.tolist():
                rows = slice(*topology.edge_start[[own, own + 1]])
                self._edges[own] = topology.edge[rows], topology.inward[rows]
        return self._edges[block]


def common_part(one: Floats, other: Floats) -> Floats:
    """Return what two parts of an edge, a corner or a crossing have in common.

    Parameters
    ----------
    one, other
        Both ends of each part, or the point; nothing where nothing is left, shape (n, 3) [m].

    Returns
    -------
    Floats
        Shape (k, 3) [m].
    """
    if not len(other) or len(one) < 2:
        return one[: len(other)]
    length = float(np.linalg.norm(one[1] - one[0]))
    place = np.sort((other - one[0]) @ (one[1] - one[0]) / length)
    low, high = max(place[0], 0.0), min(place[1], length)
    if low == 0.0 and high == length:
        return one
    return one[0] + np.outer([low, high], one[1] - one[0]) / length if high > low else one[:0]
