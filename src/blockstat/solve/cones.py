"""Products of second-order cones of dimension 3, zeros and half-lines, all at once in numpy.

A vector of the product holds the heads, the second and the third components of n_soc triples, head >= |second, third|,
then n_zero zeros, whose multipliers are free, and n_half numbers >= 0: component by component, so that every operation
runs over contiguous memory.

The Nesterov-Todd scaling W of a pair (s, z) inside takes both to the same point, lambda = W z = W^-1 s (Vandenberghe:
The CVXOPT linear and quadratic cone program solvers, 2010, section 5).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from blockstat.typing import Floats


@dataclass(frozen=True)
class Cones:
    """The product of n_soc second-order cones of dimension 3, n_zero zeros and n_half half-lines."""

    n_soc: int
    n_zero: int
    n_half: int

    @property
    def degree(self) -> int:
        """Of the barrier: one for each cone in the complementarity measure s'z / degree."""
        return self.n_soc + self.n_half

    def parts(self, vector: Floats) -> tuple[Floats, Floats]:
        """Return the triples and the numbers of a vector.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        triples : Floats
            Shape (3, n_soc), a view.
        numbers : Floats
            Shape (n_half,), a view.
        """
        return vector[: 3 * self.n_soc].reshape(3, -1), vector[3 * self.n_soc + self.n_zero :]

    def zeros(self, vector: Floats) -> Floats:
        """Return the part of a vector that belongs to the zeros.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        Floats
            Shape (n_zero,), a view.
        """
        return vector[3 * self.n_soc : 3 * self.n_soc + self.n_zero]

    def join(self, triples: Floats, numbers: Floats, zeros: Floats | None = None) -> Floats:
        """Join parts to a vector.

        Parameters
        ----------
        triples
            Shape (3, n_soc).
        numbers
            Shape (n_half,).
        zeros
            Shape (n_zero,); 0 by default.

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        if not self.n_zero + self.n_half:
            return triples.reshape(-1)
        return np.concatenate([triples.reshape(-1), np.zeros(self.n_zero) if zeros is None else zeros, numbers])

    @cached_property
    def unit(self) -> Floats:
        """The unit element: (1, 0, 0) and 1."""
        return np.concatenate([np.ones(self.n_soc), np.zeros(2 * self.n_soc + self.n_zero), np.ones(self.n_half)])

    @cached_property
    def identity(self) -> Scaling:
        """The scaling that changes nothing."""
        return Scaling(self, self.parts(self.unit)[0], np.ones(self.n_soc), np.ones(self.n_half))

    def depths(self, vector: Floats) -> Floats:
        """Return how far inside its cone each part of a vector is.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        Floats
            Least eigenvalues, shape (n_soc + n_half,); negative outside.
        """
        triples, numbers = self.parts(vector)
        return np.concatenate([triples[0] - np.sqrt(triples[1] ** 2 + triples[2] ** 2), numbers])

    def depth(self, vector: Floats) -> float:
        """Return the least of the depths.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        float
            The least eigenvalue of all; negative outside.
        """
        return float(self.depths(vector).min(initial=np.inf))

    def lifted(self, vector: Floats, lift: Floats) -> Floats:
        """Return the vector with its parts deeper inside their cones.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).
        lift
            How much deeper each part is to be, shape (n_soc + n_half,).

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        found = vector.copy()
        triples, numbers = self.parts(found)
        triples[0] += lift[: self.n_soc]
        numbers += lift[self.n_soc :]
        return found

    def product(self, a: Floats, b: Floats) -> Floats:
        """Return the Jordan product a o b.

        Parameters
        ----------
        a, b
            Vectors of the product.

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        (a3, a1), (b3, b1) = self.parts(a), self.parts(b)
        triples = a3[0] * b3 + b3[0] * a3
        triples[0] = (a3 * b3).sum(axis=0)
        return self.join(triples, a1 * b1)

    def quotient(self, divisor: Floats, vector: Floats) -> Floats:
        """Return the x with divisor o x = vector.

        Parameters
        ----------
        divisor
            A vector inside the cones.
        vector
            Any vector of the product.

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        (l3, l1), (d3, d1) = self.parts(divisor), self.parts(vector)
        triples = np.empty_like(d3)
        triples[0] = _minkowski(l3, d3) / determinant(l3)
        triples[1:] = (d3[1:] - triples[0] * l3[1:]) / l3[0]
        return self.join(triples, d1 / l1)

    def longest_step(self, start: Floats, step: Floats) -> float:
        """Return the largest alpha with start + alpha step in the product.

        Parameters
        ----------
        start
            A vector inside the cones.
        step
            Any vector of the product.

        Returns
        -------
        float
            The largest alpha, inf if there is none.
        """
        return float(self.longest_steps(start, step).min(initial=np.inf))

    def longest_steps(self, start: Floats, step: Floats) -> Floats:
        """Return the largest alpha of each cone.

        Parameters
        ----------
        start
            A vector inside the cones.
        step
            Any vector of the product.

        Returns
        -------
        Floats
            Shape (n_soc + n_half,), inf where there is none.
        """
        (s3, s1), (d3, d1) = self.parts(start), self.parts(step)
        a, b, c = determinant(d3), _minkowski(s3, d3), determinant(s3)
        root = b * b - a * c
        # The smallest positive root of a t^2 + 2 b t + c, in the form that does not cancel.
        below = np.sqrt(np.maximum(root, 0.0)) - b
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            soc = np.where((root >= 0) & (below > 0), c / below, np.inf)
            half = np.where(d1 < 0, -s1 / d1, np.inf)
        return np.concatenate([soc, half])

    def towards(self, vector: Floats, low: float, high: float) -> Floats:
        """Return what brings the eigenvalues of a vector between two numbers, those above by `high` at most.

        Parameters
        ----------
        vector
            Any vector of the product.
        low, high
            Positive numbers.

        Returns
        -------
        Floats
            A vector of the same frame as the given one, 0 where all eigenvalues lie between.
        """

        def change(value: Floats) -> Floats:
            return np.maximum(np.clip(value, low, high) - value, -high)

        triples, numbers = self.parts(vector)
        tail = np.sqrt(triples[1] ** 2 + triples[2] ** 2)
        less, more = change(triples[0] - tail), change(triples[0] + tail)
        found = np.empty_like(triples)
        found[0] = (less + more) / 2.0
        found[1:] = np.where(tail > 0, triples[1:] / np.where(tail > 0, tail, 1.0), 0.0) * (more - less) / 2.0
        return self.join(found, change(numbers))

    def scaling(self, s: Floats, z: Floats) -> Scaling:
        """Return the Nesterov-Todd scaling of two vectors inside the product.

        Parameters
        ----------
        s, z
            Slack and multipliers, inside the cones.

        Returns
        -------
        Scaling
            The W with W z = W^-1 s.
        """
        (s3, s1), (z3, z1) = self.parts(s), self.parts(z)
        root_s, root_z = np.sqrt(determinant(s3)), np.sqrt(determinant(z3))
        unit_s, unit_z = s3 / root_s, z3 / root_z
        gamma = np.sqrt((1.0 + (unit_s * unit_z).sum(axis=0)) / 2.0)
        unit_z[1:] *= -1.0
        point = (unit_s + unit_z) / (2.0 * gamma)
        point[0] = np.sqrt(1.0 + point[1] ** 2 + point[2] ** 2)  # on the hyperboloid, whatever rounding did
        return Scaling(self, point, np.sqrt(root_s / root_z), np.sqrt(s1 / z1))


@dataclass(frozen=True, eq=False)
class Scaling:
    """W of one pair: for a triple eta (2 w w' - J)^(1/2) with w'J w = 1, for a number `half`."""

    cones: Cones
    point: Floats  #: w, shape (3, n_soc)
    eta: Floats  #: shape (n_soc,)
    half: Floats  #: shape (n_half,)

    def apply(self, vector: Floats) -> Floats:
        """Return W x.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        triples, numbers = self.cones.parts(vector)
        return self.cones.join(self.eta * _rotated(self.point, triples, 1.0), self.half * numbers)

    def inverse(self, vector: Floats) -> Floats:
        """Return W^-1 x.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        triples, numbers = self.cones.parts(vector)
        return self.cones.join(_rotated(self.point, triples, -1.0) / self.eta, numbers / self.half)

    @cached_property
    def spectrum(self) -> tuple[Floats, Floats]:
        """Eigenvalues of W^2 on (1, d), (1, -d) and across, shape (3, n_soc), and the unit direction d, (2, n_soc)."""
        tail = np.sqrt(self.point[1] ** 2 + self.point[2] ** 2)
        along = np.where(tail > 0, self.point[1:] / np.where(tail > 0, tail, 1.0), np.array([[1.0], [0.0]]))
        stretch = (self.point[0] + tail) ** 2
        return self.eta**2 * np.stack([stretch, 1.0 / stretch, np.ones_like(tail)]), along

    def squared(self, vector: Floats, shift: float = 0.0) -> Floats:
        """Return (W^2 + shift I) x.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).
        shift
            Added to the eigenvalues.

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        triples, numbers = self.cones.parts(vector)
        value, along = self.spectrum
        zeros = shift * self.cones.zeros(vector)
        return self.cones.join(_spectral(value + shift, along, triples), (self.half**2 + shift) * numbers, zeros)

    def inverse_squared(self, vector: Floats, shift: float) -> Floats:
        """Return (W^2 + shift I)^-1 x.

        Parameters
        ----------
        vector
            Shape (3 n_soc + n_zero + n_half,).
        shift
            Added to the eigenvalues; above zero where there are zeros.

        Returns
        -------
        Floats
            Shape (3 n_soc + n_zero + n_half,).
        """
        triples, numbers = self.cones.parts(vector)
        value, along = self.spectrum
        zeros = self.cones.zeros(vector) / shift
        turned = _spectral(1.0 / (value + shift), along, triples)
        return self.cones.join(turned, numbers / (self.half**2 + shift), zeros)

    def root(self, shift: float) -> Floats:
        """Return C with C'C = (W^2 + shift I)^-1 for each triple.

        Parameters
        ----------
        shift
            Added to the eigenvalues.

        Returns
        -------
        Floats
            Shape (n_soc, 3, 3).
        """
        value, along = self.spectrum
        scale = np.sqrt(1.0 / (value + shift))
        scale[:2] *= np.sqrt(0.5)
        found = np.zeros((self.cones.n_soc, 3, 3))
        found[:, :2, 0] = scale[:2].T
        found[:, 0, 1:] = (scale[0] * along).T
        found[:, 1, 1:] = -(scale[1] * along).T
        found[:, 2, 1], found[:, 2, 2] = -scale[2] * along[1], scale[2] * along[0]
        return found


def determinant(triples: Floats) -> Floats:
    """Return x0^2 - |x1, x2|^2 of each triple.

    Parameters
    ----------
    triples
        Shape (3, n).

    Returns
    -------
    Floats
        Shape (n,).
    """
    tail = np.sqrt(triples[1] ** 2 + triples[2] ** 2)
    return (triples[0] - tail) * (triples[0] + tail)


def _minkowski(a: Floats, b: Floats) -> Floats:
    return a[0] * b[0] - a[1] * b[1] - a[2] * b[2]


def _rotated(w: Floats, x: Floats, sign: float) -> Floats:
    """The hyperbolic rotation of w, or for sign -1 its inverse, applied to triples."""
    along = w[1] * x[1] + w[2] * x[2]
    turned = np.empty_like(x)
    turned[0] = w[0] * x[0] + sign * along
    turned[1:] = x[1:] + w[1:] * (sign * x[0] + along / (1.0 + w[0]))
    return turned


def _spectral(value: Floats, along: Floats, x: Floats) -> Floats:
    """The symmetric matrix with the given eigenvalues on (1, d), (1, -d) and across d, applied to triples."""
    along_axis, across = along[0] * x[1], along[0] * x[2]
    along_axis += along[1] * x[2]
    across -= along[1] * x[1]
    across *= value[2]
    plus, minus = x[0] + along_axis, x[0] - along_axis
    plus *= value[0]
    minus *= value[1]
    found = np.empty_like(x)
    np.add(plus, minus, out=found[0])
    plus -= minus
    np.multiply(along[0], plus, out=found[1])
    np.multiply(along[1], plus, out=found[2])
    found *= 0.5
    found[1] -= along[1] * across
    found[2] += along[0] * across
    return found
