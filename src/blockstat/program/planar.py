"""Prismatic scenes: three unknowns a block and two numbers a pair of contact points.

When all blocks have the same two ends along one axis and every joint runs through between them, the scene is
symmetric about its middle plane. An optimal motion is then planar (average it with its mirror image), and the
forces at the two ends of a joint may be taken equal and in the plane: the friction cone becomes two half-planes.
This is exact; the answer is unfolded to the whole scene and checked there like any other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from blockstat.contact.interfaces import Interfaces
from blockstat.program.equilibrium import Equilibrium
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Coordinates within this fraction of the block size are equal, and so are directions within this sine.
SAME = 1e-7
#: Loads out of the plane below this fraction of the largest are rounding.
OUT_OF_PLANE = 1e-12


@dataclass(frozen=True, eq=False)
class Plane:
    """The reduction of one equilibrium to its middle plane."""

    unfold: sparse.csr_array  #: R, shape (6 n, 3 n), planar twists to whole ones
    first: Ints  #: one point of each pair, shape (p,)
    second: Ints  #: its mirror image, shape (p,)
    tangent: Floats  #: in-plane tangent in the frame (t1, t2) of the points, shape (p, 2)

    def holds(self, *vectors: Floats | None) -> bool:
        """Whether vectors over whole twists have no part out of the plane.

        Parameters
        ----------
        *vectors
            Shape (6 n,) each; None is planar.

        Returns
        -------
        bool
            True where all vectors are planar.
        """
        for vector in vectors:
            if vector is None:
                continue
            out = vector - self.unfold @ (self.unfold.T @ vector)
            if np.abs(out).max(initial=0.0) > OUT_OF_PLANE * np.abs(vector).max(initial=0.0):
                return False
        return True

    def offsets(self, offset: Floats) -> tuple[Floats, Floats]:
        """Return the normal and the in-plane parts of rates at the first point of each pair.

        Parameters
        ----------
        offset
            Rates at all points, shape (3 m,).

        Returns
        -------
        normal, along : Floats
            Shape (p,) each.
        """
        first = offset.reshape(-1, 3)[self.first]
        return first[:, 0], (first[:, 1:] * self.tangent).sum(axis=1)

    def mirrors(self, offset: Floats) -> bool:
        """Whether rates at all points are planar: the same at both points of each pair.

        Parameters
        ----------
        offset
            Rates at all points, shape (3 m,).

        Returns
        -------
        bool
            True where the rates are planar.
        """
        rate = offset.reshape(-1, 3)
        normal, along = self.offsets(offset)
        expected = np.column_stack([normal, along[:, None] * self.tangent])
        error = max(np.abs(rate[points] - expected).max(initial=0.0) for points in (self.first, self.second))
        return bool(error <= OUT_OF_PLANE * np.abs(rate).max(initial=0.0))

    def local(self, local: Floats) -> tuple[Floats, Floats]:
        """Return the rows that take planar twists of the two blocks to (g_n, g_t) of each pair.

        Parameters
        ----------
        local
            Entries of A's columns, shape (3 m, 12); see `PenaltyProgram.local`.

        Returns
        -------
        normal, along : Floats
            Shape (p, 6) each.
        """
        kept = np.flatnonzero(np.diff(self.unfold.indptr[:7]))
        entries = local[:, np.concatenate([kept, 6 + kept])]
        first = 3 * self.first
        return entries[first], self.tangent[:, :1] * entries[first + 1] + self.tangent[:, 1:] * entries[first + 2]

    def fold_forces(self, force: Floats) -> tuple[Floats, Floats]:
        """Return the normal and the in-plane forces of the pairs, both ends together.

        Parameters
        ----------
        force
            Forces at all points, shape (m, 3).

        Returns
        -------
        normal, along : Floats
            Shape (p,) each.
        """
        both = force[self.first] + force[self.second]
        return both[:, 0], (both[:, 1:] * self.tangent).sum(axis=1)

    def unfold_forces(self, normal: Floats, along: Floats, n_points: int) -> Floats:
        """Return forces of the pairs as forces at all points, half at each end.

        Parameters
        ----------
        normal, along
            Normal and in-plane forces of the pairs, shape (p,) each.
        n_points
            The number of points m.

        Returns
        -------
        Floats
            Shape (m, 3).
        """
        force = np.zeros((n_points, 3))
        half = 0.5 * np.column_stack([normal, along[:, None] * self.tangent])
        force[self.first] = half
        # The twin shares the interface and so the frame.
        force[self.second] = half
        return force

    def forces_of_half_planes(self, friction: Floats, values: Floats) -> Floats:
        """Return multipliers of g_n + mu g_t >= 0 and g_n - mu g_t >= 0 as forces at all points.

        Parameters
        ----------
        friction
            mu of each point, shape (m,).
        values
            The multipliers of all pairs of the first kind, then of the second, shape (2 p,).

        Returns
        -------
        Floats
            Shape (m, 3).
        """
        mu = friction[self.first]
        plus, minus = values[: len(mu)], values[len(mu) :]
        return self.unfold_forces(plus + minus, mu * (plus - minus), len(friction))

    def half_planes_of_forces(self, friction: Floats, force: Floats) -> Floats:
        """Return forces at all points as multipliers of g_n + mu g_t >= 0 and g_n - mu g_t >= 0.

        Parameters
        ----------
        friction
            mu of each point, shape (m,).
        force
            Shape (m, 3).

        Returns
        -------
        Floats
            Shape (2 p,).
        """
        mu = friction[self.first]
        normal, along = self.fold_forces(force)
        sideways = along / np.where(mu > 0, mu, 1.0)
        return np.concatenate([normal + sideways, normal - sideways]) / 2.0


def find_plane(assembly: Assembly, interfaces: Interfaces, eq: Equilibrium) -> Plane | None:
    """Find the reduction of a prismatic scene.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        The joints.
    eq
        The equilibrium of its free blocks.

    Returns
    -------
    Plane or None
        None when the scene is not prismatic along x, y or z.
    """
    if not eq.n_points:
        return None
    size = float(eq.length.min())
    k = interfaces.point_interface[eq.points]
    point = interfaces.point[eq.points]
    centre = assembly.centroid[eq.blocks]
    for axis in range(3):
        low, high = point[:, axis].min(), point[:, axis].max()
        middle = (low + high) / 2
        ends = np.minimum(np.abs(point[:, axis] - low), np.abs(point[:, axis] - high))
        flat = (
            high - low > SAME * size
            and ends.max() <= SAME * size
            and np.abs(interfaces.frame[k, 0, axis]).max() <= SAME
            and np.abs(centre[:, axis] - middle).max() <= SAME * size
        )
        if not flat:
            continue
        pairs = _mirror_pairs(point, k, axis, middle, SAME * size)
        if pairs is None:
            continue
        tangent = _in_plane(interfaces.frame[k[pairs[0]]], axis)
        return Plane(_unfold(eq.n_blocks, axis), *pairs, tangent)
    return None


def _mirror_pairs(
    point: Floats, interface: Ints, axis: int, middle: float, tolerance: float
) -> tuple[Ints, Ints] | None:
    """Indices of the points at one end and of their images at the other, or None if some has none."""
    lower = np.flatnonzero(point[:, axis] < middle)
    upper = np.flatnonzero(point[:, axis] > middle)
    if len(lower) != len(upper):
        return None
    flat = np.delete(point, axis, axis=1)

    def ordered(index: Ints) -> Ints:
        keys = np.round(flat[index] / (10 * tolerance)).astype(np.int64)
        return index[np.lexsort((keys[:, 1], keys[:, 0], interface[index]))]

    lower, upper = ordered(lower), ordered(upper)
    matched = (interface[lower] == interface[upper]).all() and np.abs(flat[lower] - flat[upper]).max() <= tolerance
    return (lower, upper) if matched else None


def _in_plane(frame: Floats, axis: int) -> Floats:
    """Coordinates (t1, t2) of the tangent that lies in the plane, shape (n, 2)."""
    along = np.cross(np.eye(3)[axis], frame[:, 0])
    return np.einsum("nij,nj->ni", frame[:, 1:], along)


def _unfold(n: int, axis: int) -> sparse.csr_array:
    """Selection of the two velocities in the plane and the rotation about its normal for each block."""
    rows = np.sort([*[k for k in range(3) if k != axis], 3 + axis])
    index = (6 * np.arange(n)[:, None] + rows).reshape(-1)
    shape = (6 * n, 3 * n)
    return sparse.csr_array((np.ones(3 * n), (index, np.arange(3 * n))), shape=shape)
