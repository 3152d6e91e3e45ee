"""The faces of joints at rest: the corners of each block's face, in order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.faces import outline_hull
from blockstat.contact.interfaces import Interfaces
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Faces of a block belong to a joint when the sine of the angle between the normals is below this. Chosen: faces of one
#: joint are nearly parallel, and other faces of a block stand at an angle to it.
SAME_FACE_SINE = 0.05
#: Faces of a block belong to a joint when they are within this distance of it, beside the joint's gap at rest. Relative
#: to the block's size. Chosen: parallel faces of a block are further apart.
SAME_FACE_DISTANCE = 1e-3


class FaceOutlines:
    """Outlines of the two faces of joints, each found when it is first asked for."""

    def __init__(self, assembly: Assembly, interfaces: Interfaces) -> None:
        self._assembly, self._interfaces = assembly, interfaces
        self._found: dict[int, tuple[Floats, Floats]] = {}

    def of(self, joints: Ints) -> Floats:
        """Return the corners of the two faces of joints at rest.

        Parameters
        ----------
        joints
            Numbers of the joints, shape (k,).

        Returns
        -------
        Floats
            Shape (k, 2, w, 3) [m]: of each face, counter-clockwise seen against the joint's normal. A face with fewer
            than w corners repeats its last one.
        """
        for joint in map(int, joints):
            if joint not in self._found:
                self._found[joint] = (self._outline(joint, 0), self._outline(joint, 1))
        outlines = [self._found[int(joint)] for joint in joints]
        width = max((len(outline) for pair in outlines for outline in pair), default=0)
        corner = np.empty((len(outlines), 2, width, 3))
        for k, pair in enumerate(outlines):
            for side, outline in enumerate(pair):
                corner[k, side, : len(outline)] = outline
                corner[k, side, len(outline) :] = outline[-1]
        return corner

    def _outline(self, joint: int, side: int) -> Floats:
        """The convex hull in the joint's plane of the corners of one face, shape (n, 3) [m]."""
        corner = self._corners(joint, side)
        flat = (corner - corner[0]) @ self._interfaces.frame[joint, 1:].T
        nearest = np.linalg.norm(outline_hull(flat)[:, None] - flat, axis=2).argmin(axis=1)
        outline: Floats = corner[nearest]
        return outline

    def _corners(self, joint: int, side: int) -> Floats:
        """Corners at rest of those faces of a block that lie in a joint, shape (n, 3) [m]."""
        assembly, interfaces = self._assembly, self._interfaces
        block, normal = int(interfaces.pair[joint, side]), interfaces.frame[joint, 0]
        points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
        faces = np.flatnonzero(assembly.face_block == block)
        outward = 1.0 if side == 0 else -1.0
        facing = outward * (assembly.planes.normal[faces] @ normal) > np.sqrt(1 - SAME_FACE_SINE**2)
        height = np.abs((assembly.planes.centre[faces] - points.mean(axis=0)) @ normal)
        distance = float(interfaces.gap[joint]) + SAME_FACE_DISTANCE * float(assembly.size[block])
        rows = faces[facing & (height <= distance)]
        if not len(rows):
            return points
        own = np.concatenate(
            [assembly.face_vertices[assembly.face_start[f] : assembly.face_start[f + 1]] for f in rows]
        )
        found: Floats = assembly.vertices[np.unique(own)]
        return found
