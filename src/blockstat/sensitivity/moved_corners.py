"""An assembly with its corners in slightly other places, and its joints taken along.

All corners of blocks that lie at one place move together. Contact points and normals follow as in
`blockstat.sensitivity.vertices`, so nothing is searched for and every joint stays. The ends of ties stay where they are
drawn, a little off a face that moves. Exact to first order in the
displacement over the size of the blocks; where the faces stay plane and the contact points are corners, exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from blockstat.assembly import Assembly
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.program.ties import check_anchors
from blockstat.sensitivity.vertices import PointGradient, edges_at, joint_sides, point_carriers, shared_points
from blockstat.typing import Floats, Ints


@dataclass(frozen=True, eq=False)
class MovedCorners:
    """What moves with the shared corners of an assembly, found once for many displacements.

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat import Assembly, box, find_interfaces
    >>> cubes = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))], supports=[0])
    >>> corners = MovedCorners(cubes, find_interfaces(cubes))
    >>> taller, joints = corners.moved(np.full((corners.count, 3), [0.0, 0.0, 0.5]), find_interfaces(cubes))
    >>> joints.point[:, 2].tolist(), taller.volume.round(6).tolist()
    ([1.5, 1.5, 1.5, 1.5], [1.5, 1.0])
    """

    assembly: Assembly  #: as drawn
    interfaces: Interfaces  #: its joints

    def __post_init__(self) -> None:
        check_anchors(self.assembly)

    @cached_property
    def _labels(self) -> tuple[Ints, Ints]:
        """The shared corner of each vertex, and which of them belong to a block that can move."""
        points, label = shared_points(self.assembly)
        free = np.zeros(len(points), dtype=bool)
        free[label[~self.assembly.support[self.assembly.vertex_block]]] = True
        return label, np.flatnonzero(free)

    @property
    def count(self) -> int:
        """Number of shared corners that move: those of blocks that are not all supports."""
        return len(self._labels[1])

    @cached_property
    def _carried(self) -> csr_array:
        """Displacement of each contact point by that of each vertex, shape (3 n_points, 3 n_vertices)."""
        faces, rows, columns, values = self.interfaces, [], [], []
        for number in range(faces.n_interfaces):
            sides = self._sides[number]
            rims = [(tail, head) for _, tail, head in sides] if len(sides) == 2 else []
            for i in range(faces.start[number], faces.start[number + 1]):
                vertices, weights = point_carriers(self.assembly, faces, number, i, rims)
                row, column = np.arange(3)[None, :, None], np.arange(3)[None, None, :]
                rows.append(np.broadcast_to(3 * i + row, weights.shape).ravel())
                columns.append(np.broadcast_to(3 * vertices[:, None, None] + column, weights.shape).ravel())
                values.append(weights.ravel())
        shape = (3 * faces.n_points, 3 * len(self.assembly.vertices))
        if not rows:
            return csr_array(shape)
        return csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)

    @cached_property
    def _sides(self) -> list[list[tuple[float, Ints, Ints]]]:
        """Sign of the normal, and tails and heads of the edges round each side of each joint; none of a crossing."""
        assembly, faces = self.assembly, self.interfaces
        return [
            []
            if faces.kinds[k] == ContactKind.CROSSING
            else [(sign, tail, head) for sign, (tail, head, _) in joint_sides(assembly, faces, k)]
            for k in range(faces.n_interfaces)
        ]

    @cached_property
    def _rims(self) -> tuple[Ints, Ints, Ints, Ints, Floats]:
        """Tails and heads of all sides of joints, the side of each of them, and the joint and the sign of each side."""
        tails, heads, side, joint, signs = [], [], [], [], []
        for number, sides in enumerate(self._sides):
            for sign, tail, head in sides:
                tails.append(tail)
                heads.append(head)
                side.append(np.full(len(tail), len(joint)))
                joint.append(number)
                signs.append(sign)
        none = np.empty(0, np.int64)
        tail, head, own = (np.concatenate([none, *part]) for part in (tails, heads, side))
        return tail, head, own, np.array(joint, np.int64), np.array(signs)

    def moved(self, shift: Floats, interfaces: Interfaces) -> tuple[Assembly, Interfaces]:
        """Return the assembly and its joints with displaced corners.

        Parameters
        ----------
        shift
            Displacement of each corner, shape (count, 3) [m].
        interfaces
            The joints, with a friction of their own or without.

        Returns
        -------
        assembly : Assembly
            With the same blocks, whose faces may be slightly warped.
        interfaces : Interfaces
            With the same joints and points, elsewhere.
        """
        label, free = self._labels
        by_corner = np.zeros((label.max() + 1, 3))
        by_corner[free] = shift
        by_vertex = by_corner[label]
        moved = self.assembly.vertices + by_vertex
        point = interfaces.point + (self._carried @ by_vertex.ravel()).reshape(-1, 3)
        changed = replace(interfaces, point=point, frame=_turned(interfaces.frame, self._normals(moved)), moved=True)
        return self.assembly.with_(vertices=moved), changed

    def gathered(self, gradient: PointGradient) -> Floats:
        """Return a derivative by the coordinates of the corners that move.

        Parameters
        ----------
        gradient
            By all shared corners.

        Returns
        -------
        Floats
            Shape (3 count,).
        """
        return gradient.gradient[self._labels[1]].ravel()

    def _normals(self, vertices: Floats) -> Floats:
        """Unit normals of the joints: the mean of those of their sides, by Newell, and of crossings a x b."""
        faces, (tail, head, side, joint, sign) = self.interfaces, self._rims
        first = self.interfaces.point[faces.start[:-1]][joint[side]]  # about a corner nearby, for rounding
        area = np.zeros((len(joint), 3))
        np.add.at(area, side, np.cross(vertices[tail] - first, vertices[head] - first))
        area *= (sign / np.linalg.norm(area, axis=1))[:, None]
        normal = np.zeros((faces.n_interfaces, 3))
        np.add.at(normal, joint, area)
        for k, (a, b) in self._crossings.items():
            cross = np.cross(vertices[a[1]] - vertices[a[0]], vertices[b[1]] - vertices[b[0]])
            normal[k] = cross * np.sign(cross @ faces.frame[k, 0])
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    @cached_property
    def _crossings(self) -> dict[int, list[tuple[int, int]]]:
        """Tail and head of the two edges of each crossing."""
        faces = self.interfaces
        found = {}
        for k in np.flatnonzero(faces.kinds == ContactKind.CROSSING).tolist():
            ends = (edges_at(self.assembly, faces, k, int(faces.start[k]), int(block)) for block in faces.pair[k])
            found[k] = [(int(tail[0]), int(head[0])) for tail, head in ends]
        return found


def _turned(frame: Floats, normal: Floats) -> Floats:
    """Right-handed frames about other normals, with tangents near those they had."""
    along = frame[:, 1] - np.einsum("ij,ij->i", frame[:, 1], normal)[:, None] * normal
    along /= np.linalg.norm(along, axis=1)[:, None]
    across: Any = np.cross(normal, along)
    return np.stack([normal, along, across], axis=1)
