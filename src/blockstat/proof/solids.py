"""The blocks of a proof file: corners and faces, and their exact weight."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from blockstat.proof.rational import Exact, exact
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True)
class Solid:
    """One block, its equal corners merged."""

    corners: Floats  #: shape (n, 3) [m]
    faces: list[list[int]]  #: corners of each face, counter-clockwise seen from outside

    @cached_property
    def normals(self) -> Floats:
        """Unit normals of the faces, by Newell's method, shape (n_faces, 3)."""
        rings = [self.corners[face] - self.corners[face[0]] for face in self.faces]
        area = np.array([np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) for ring in rings])
        return area / np.maximum(np.linalg.norm(area, axis=1), 1e-300)[:, None]

    @cached_property
    def face_boxes(self) -> Floats:
        """Least and greatest coordinates of the corners of each face, shape (n_faces, 2, 3) [m]."""
        rings = [self.corners[face] for face in self.faces]
        return np.array([(ring.min(axis=0), ring.max(axis=0)) for ring in rings])

    @cached_property
    def size(self) -> float:
        """Length of the diagonal of its box [m]."""
        return float(np.linalg.norm(np.ptp(self.corners, axis=0)))

    @cached_property
    def uneven(self) -> Floats:
        """How far the corners of each face are off its mean plane, shape (n_faces,) [m]."""
        rings = [self.corners[face] for face in self.faces]
        off = [np.abs((ring - ring.mean(axis=0)) @ unit).max() for ring, unit in zip(rings, self.normals, strict=True)]
        return np.array(off)

    @cached_property
    def edges(self) -> Ints:
        """Ends of the edges, shape (n_edges, 2)."""
        pairs = {(i, j) for face in self.faces for i, j in _sides(face) if i < j}
        return np.array(sorted(pairs), dtype=np.int64)

    def normal(self, face: int) -> Exact:
        """Return a normal in exactly the direction of that of a face, of unit length to rounding.

        Parameters
        ----------
        face
            Its number.

        Returns
        -------
        Exact
            Outward, shape (3,).
        """
        ring = exact(self.corners[self.faces[face]])
        area = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
        return area * exact(1.0 / float(np.linalg.norm(area.astype(float))))[()]

    def weigh(self, density: Fraction) -> tuple[Fraction, Exact]:
        """Return the mass and the mass times the centroid, exactly.

        Parameters
        ----------
        density
            [kg/m3].

        Returns
        -------
        mass : Fraction
            [kg].
        moment : Exact
            Shape (3,) [kg m], about the origin.

        Notes
        -----
        A face is split about the mean of its corners, as everywhere (`blockstat.geometry.polyhedron`).
        """
        corners = exact(self.corners)
        volume, moment = Fraction(0), np.array([Fraction(0)] * 3)
        for face in self.faces:
            ring = corners[face]
            following = np.roll(ring, -1, axis=0)
            middle = ring.sum(axis=0) / len(face)
            part = (np.cross(ring, following) * middle).sum(axis=1) / 6
            volume += part.sum()
            moment = moment + (part[:, None] * (ring + following + middle)).sum(axis=0) / 4
        return density * volume, density * moment


def _sides(face: list[int]) -> list[tuple[int, int]]:
    return list(zip(face, face[1:] + face[:1], strict=True))


def solids(assembly: Assembly) -> list[Solid]:
    """Return the blocks one by one, without corners that repeat one another or are of no face.

    Parameters
    ----------
    assembly
        The blocks.

    Returns
    -------
    list of Solid
        In the order of the blocks.
    """
    found = []
    for block in range(assembly.n_blocks):
        corners, merged = np.unique(assembly.block_vertices(block), axis=0, return_inverse=True)
        faces = []
        for face in assembly.faces_of(block):
            ring = merged.reshape(-1)[face].tolist()
            ring = [i for i, before in zip(ring, ring[-1:] + ring[:-1], strict=True) if i != before]
            faces += [ring] if len(ring) > 2 else []
        used, number = np.unique(np.concatenate(faces), return_inverse=True)
        number, starts = number.reshape(-1), np.cumsum([len(face) for face in faces])[:-1]
        found.append(Solid(corners[used], [ring.tolist() for ring in np.split(number, starts)]))
    return found
