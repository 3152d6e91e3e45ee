"""What is left of contacts of edges and corners where the faces and edges that they bear on lose their rims."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import WIDTH, Interfaces
from blockstat.geometry.topology import edge_topology
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Facets whose normals have at least this cosine with that of a contact make up the face that it is on. Chosen: within
#: eight degrees.
ALONG = 0.99
#: Facets and edges of a block are in the plane of a contact when they are no further from it than this, relative to the
#: smaller block, and its gap. Chosen: parallel faces of a block are further apart.
IN_PLANE = 1e-3


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
    """

    def __init__(self, assembly: Assembly, interfaces: Interfaces, width: Floats) -> None:
        self._assembly, self._interfaces, self._width = assembly, interfaces, width
        self._first_face = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
        self._edges: dict[int, Floats] = {}
        self._near = IN_PLANE * assembly.size[interfaces.pair].min(axis=1)

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

        across, width = self._interfaces.frame[joint, 1:], self._width[joint]
        sides = self._interfaces.pair[joint].tolist()
        bare = shapely.MultiPoint((points - points[0]) @ across.T).convex_hull
        if len(points) == 1:
            # Facets about a blunt corner may lie in the plane of the contact; they are not what it bears on.
            away = [self._to_corners(joint, block, points[0]) for block in sides]
            sides = [sides[int(np.argmin(away)) ^ 1]] if min(away) < np.inf else sides
        found = []
        for block in sides:
            rings = [(ring - points[0]) @ across.T for ring in self._facets(joint, block, points[0])]
            # Facets that touch are one, also where rounding has left a seam between them.
            room = WIDTH * self._near[joint]
            face = shapely.union_all([shapely.buffer(shapely.Polygon(ring), room) for ring in rings])
            if face.intersects(bare):
                found.append(shapely.intersection(shapely.buffer(face, -width), bare))
        if not found:
            return None
        left = shapely.get_coordinates(found)
        if len(points) > 1:
            # What is between parts of an edge adds nothing to the forces at their ends.
            along = (points[-1] - points[0]) @ across.T
            order = np.argsort(left @ along)
            left = left[order[[0, -1]]] if len(order) and np.ptp(left @ along) > 0 else left[:0]
        return points[0] + left @ across

    def _to_corners(self, joint: int, block: int, point: Floats) -> float:
        """Least distance along the plane of a joint to a corner of a block that is in it; infinite without one [m]."""
        offset = self._assembly.block_vertices(block) - point
        normal, *across = self._interfaces.frame[joint]
        level = np.abs(offset @ normal) < self._near[joint] + self._interfaces.gap[joint]
        return float(np.linalg.norm(offset[level] @ np.transpose(across), axis=1).min(initial=np.inf))

    def _facets(self, joint: int, block: int, point: Floats) -> list[Floats]:
        """Corners of the facets of a block that lie in the plane of a joint, each of shape (n, 3) [m]."""
        assembly, normal = self._assembly, self._interfaces.frame[joint, 0]
        own = slice(*self._first_face[[block, block + 1]])
        planes, start = assembly.planes, assembly.face_start
        # Points are halfway across the gap.
        off = np.abs((point - planes.centre[own]) @ normal) < self._near[joint] + self._interfaces.gap[joint]
        rows = self._first_face[block] + np.flatnonzero(off & (np.abs(planes.normal[own] @ normal) > ALONG))
        return [assembly.vertices[assembly.face_vertices[start[f] : start[f + 1]]] for f in rows]

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
        edges = self._edges_of(block) - point
        normal, *across = self._interfaces.frame[joint]
        height, flat = edges @ normal, edges @ np.transpose(across)
        allowed = self._near[joint] + self._interfaces.gap[joint]
        line = flat[:, 1] - flat[:, 0]
        square = np.einsum("ij,ij->i", line, line)
        share = -np.einsum("ij,ij->i", flat[:, 0], line) / np.where(square > 0, square, 1.0)
        away = np.linalg.norm(flat[:, 0] + np.clip(share, 0.0, 1.0)[:, None] * line, axis=1)
        # The normal is at right angles to both edges: of those that pass nearby the level one is meant.
        off = np.where((np.abs(height).min(axis=1) < allowed), away + np.abs(np.diff(height, axis=1))[:, 0], np.inf)
        return self._edges_of(block)[off.argmin()] if off.min(initial=np.inf) < allowed else None

    def _edges_of(self, block: int) -> Floats:
        """The ends of the convex edges of a block, shape (n, 2, 3) [m]."""
        if block not in self._edges:
            # All blocks of crossings at once: the topology of an assembly costs more than that of a block.
            crossing = self._interfaces.kinds == ContactKind.CROSSING
            blocks: Ints = np.union1d(self._interfaces.pair[crossing], block)
            topology = edge_topology(self._assembly, blocks)
            for own in blocks.tolist():
                rows = slice(*topology.edge_start[[own, own + 1]])
                self._edges[own] = self._assembly.vertices[topology.edge[rows]]
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
