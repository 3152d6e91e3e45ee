"""What exact forces and motions prove, contact by contact, before a file is written.

A force F has the component h = F.n / |n|^2 along the normal as given, and lies in Coulomb's cone if h >= 0 and
|F|^2 |n|^2 <= (1 + mu^2) (F.n)^2. No root is needed, and n need not be a unit vector. A relative velocity g is resisted
by none of these forces if g.n >= 0 and (g.n)^2 >= mu^2 (|g|^2 |n|^2 - (g.n)^2).

Bonds and ties have a range of h, and a shear s in place of friction: |F|^2 |n|^2 - (F.n)^2 <= s^2 |n|^4. The power that
they take up is greatest at the ends of the range, with s times the root of |g|^2 |n|^2 - (g.n)^2 across it. For couples
g is the relative rotation.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

import numpy as np

from blockstat.proof.rational import Exact, exact
from blockstat.proof.structure import Structure

#: Roots are taken up to the next number of so many digits.
ROOT = 10**30


@dataclass(frozen=True)
class Power:
    """What drives a motion, and what resists it."""

    dead: Fraction  #: work of the dead load less the most that bounded forces take up
    live: Fraction  #: work of the live load
    closing: Fraction  #: the most that contact forces without bound of unit size take up at one contact
    weight: Fraction  #: sum of the sizes of the dead forces, each the sum of its components' sizes

    def drives(self, bound: int) -> bool:
        """Return whether the dead load alone drives the motion.

        Parameters
        ----------
        bound
            Contact forces sum to so many dead loads at most.

        Returns
        -------
        bool
            True where it does.
        """
        return self.dead > bound * self.closing * self.weight

    def multiplier(self, bound: int) -> Fraction:
        """Return the multiplier of the live load beyond which the loads drive the motion.

        Parameters
        ----------
        bound
            As in `drives`.

        Returns
        -------
        Fraction
            Of a live load that does work.
        """
        return (bound * self.closing * self.weight - self.dead) / self.live


def admissible(structure: Structure, force: Exact) -> np.ndarray:
    """Return which forces lie within their cones and bounds.

    Parameters
    ----------
    structure
        The contacts.
    force
        On blocks b, shape (n, 3) [N or N m].

    Returns
    -------
    array of bool
        Shape (n,).
    """
    normal, law = structure.normal, structure.law
    if law is not None:
        force = force + exact(law.shift)[:, None] * normal
    head, square = _dot(force, normal), _dot(normal, normal)
    across = _dot(force, force) * square - head**2
    inside = across <= _square(structure) * head**2 + exact(structure.shear) ** 2 * square**2
    rough = np.isinf(structure.friction)
    inside = np.where(rough, (head > 0) | (_dot(force, force) == 0), inside)
    if law is None:
        inside &= head >= 0
    else:
        capped = np.isfinite(law.cap)
        inside &= head >= exact(law.floor) * square
        inside[capped] &= head[capped] <= exact(law.cap[capped]) * square[capped]
    return inside.astype(bool)


def power(structure: Structure, motion: Exact) -> Power:
    """Return what drives a motion, and what resists it.

    Parameters
    ----------
    structure
        The blocks, contacts and loads.
    motion
        Velocity of the point at the origin and rotation of each block, 0 for fixed ones, shape (n_blocks, 6).

    Returns
    -------
    Power
        Exact but for roots, which are rounded up.
    """
    a, b = structure.pair.T
    twist = motion[b] - motion[a]
    rate = twist[:, :3] + np.cross(twist[:, 3:], structure.point)
    rate[structure.couple] = twist[structure.couple, 3:]
    normal = structure.normal
    head = _dot(rate, normal)
    slide = _dot(rate, rate) * _dot(normal, normal) - head**2
    friction, rough = _square(structure), np.isinf(structure.friction)
    opens = (head >= 0) & (rough | (head**2 >= friction * slide))
    taken, closing = Fraction(0), Fraction(0)
    law = structure.law
    lawful = np.zeros(len(a), dtype=bool) if law is None else (law.shift > 0) | (law.floor != 0) | np.isfinite(law.cap)
    for i in np.flatnonzero(lawful | ~opens | (rough & (slide != 0))):
        root = _root(slide[i])
        price = -head[i] if rough[i] else exact(structure.friction[i])[()] * root - head[i]
        price = min(price, Fraction(0)) if opens[i] else price
        closes = root if rough[i] else Fraction(0)
        least = most = Fraction(0)
        if law is not None:
            taken += exact(law.shift[i])[()] * head[i] + exact(structure.shear[i])[()] * root
            least = exact(law.floor[i])[()]
            # of a force without bound the part that is cohesion; the rest is judged by its size
            most = exact(law.cap[i] if np.isfinite(law.cap[i]) else law.shift[i])[()]
        taken += (most if price > 0 else least) * price
        if price > 0 and (law is None or np.isinf(law.cap[i])):
            closes += price
        closing = max(closing, closes)
    free = ~structure.fixed
    dead, live = ((load[free] * motion[free]).sum() for load in (structure.dead, structure.live))
    weight = np.abs(structure.dead[free, :3]).sum()
    return Power(Fraction(dead) - taken, Fraction(live), closing, Fraction(weight))


def _dot(one: Exact, two: Exact) -> Exact:
    return (one * two).sum(axis=1)


def _square(structure: Structure) -> Exact:
    """Friction squared, 0 where it is infinite."""
    return exact(np.where(np.isinf(structure.friction), 0.0, structure.friction)) ** 2


def _root(value: Fraction) -> Fraction:
    """A fraction just above the square root."""
    below = value.denominator
    return Fraction(isqrt(value.numerator * below * ROOT**2) + 1, below * ROOT) if value else value
