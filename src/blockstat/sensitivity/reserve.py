"""What a limit load hangs on: its derivatives by each joint, each block and each corner, without solving again.

Envelope theorem, as in `blockstat.sensitivity.parameters`: with l' u = 1 the optimum changes by the change of the
Lagrangian at fixed forces f and twist u. A contact point with normal force n slides by s:

    d lambda / d mu = sum of n |s|                          over the points of the joint,
    d lambda / d delta = -sum of dp/d delta . (F x w)       w the rotation of b against a, F the force on b,
    d lambda / d rho = -V v . (g + lambda a)                v the velocity of the centroid, a that of the load.

Where several optima exist (a block about to rock about either of two edges) the derivative is that of one of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.problem import checked_loads
from blockstat.errors import InputError, check_choice
from blockstat.imperfection.lost_edges import edge_speeds
from blockstat.loads import Loads, as_load, weighted
from blockstat.sensitivity.parameters import friction_power, pinned
from blockstat.sensitivity.vertices import PointGradient, field_of, point_gradient
from blockstat.typing import Floats

MAPS = ("edge", "friction", "density", "corner")
#: Derivatives below this share of the largest are rounding.
NOTHING = 1e-6
MISSING = {
    "edge": "the joints are divided into cells; a map by what their edges lose is not known",
    "corner": "the map was made without corners; ask for them by corners=True",
}


@dataclass(frozen=True, eq=False)
class ReserveMap:
    """A limit load multiplier and its derivatives: where to repoint, where to measure."""

    limit: LimitLoad
    #: by what each joint loses along its edges, shape (n_interfaces,) [1/m]; nan where joints are divided into cells
    edge: Floats
    friction: Floats  #: by the coefficient of friction of each joint, shape (n_interfaces,)
    density: Floats  #: by the density of each block, shape (n_blocks,) [m3/kg]; zero on supports
    corner: PointGradient | None  #: by the place of each shared corner [1/m]; None where it was not asked for

    @property
    def value(self) -> float:
        """The multiplier."""
        return self.limit.lower

    def by(self, what: str) -> Floats:
        """Return the derivatives by one quantity.

        Parameters
        ----------
        what
            "edge", "friction", "density" or "corner".

        Returns
        -------
        Floats
            One value a joint, block or corner; of a corner the length of its derivative.

        Raises
        ------
        InputError
            For another word, for edges of joints that are divided into cells, and for corners that were not asked for.
        """
        check_choice("what", what, MAPS)
        value = getattr(self, what)
        if value is None or (what == "edge" and np.isnan(value).any()):
            raise InputError(MISSING[what])
        return np.linalg.norm(value.gradient, axis=1) if what == "corner" else value

    def most(self, what: str, number: int = 5) -> list[tuple[str, float]]:
        """Return what the limit load hangs on most.

        Parameters
        ----------
        what
            "edge", "friction", "density" or "corner".
        number
            How many at most.

        Returns
        -------
        list of (str, float)
            The two blocks of a joint, a block, or the place of a corner, with the derivative (of a corner its length);
            the largest first, without those on which nothing hangs.

        Raises
        ------
        InputError
            As `by`.
        """
        value = self.by(what)
        assembly, faces = self.limit.assembly, self.limit.interfaces
        if what == "corner" and self.corner:
            names = [f"({x:.3f}, {y:.3f}, {z:.3f})" for x, y, z in self.corner.points]
        else:
            pairs = [f'"{assembly.names[a]}" and "{assembly.names[b]}"' for a, b in faces.pair]
            names = [f'"{name}"' for name in assembly.names] if what == "density" else pairs
        order, floor = np.argsort(-np.abs(value), kind="stable")[:number], self.floor(what)
        return [(names[k], float(value[k])) for k in order if abs(value[k]) > floor]

    def floor(self, what: str) -> float:
        """Return the magnitude up to which derivatives count as rounding.

        Parameters
        ----------
        what
            As `by` takes it.

        Returns
        -------
        float
            In the unit of `by`.

        Raises
        ------
        InputError
            As `by`.
        """
        # Where nothing hangs on them all values are rounding, so they are held against the multiplier itself.
        length, density = (float(np.median(own)) for own in (self.limit.assembly.size, self.limit.assembly.density))
        whole = abs(self.value) / {"edge": length, "corner": length, "density": density}.get(what, 1.0)
        return NOTHING * max(float(np.abs(self.by(what)).max(initial=0.0)), whole)


def reserve_map(limit: LimitLoad, load: Any, *, loads: Loads | None = None, corners: bool = True) -> ReserveMap:
    """Return the derivatives of a limit load by what each joint loses, its friction, each density and each corner.

    Parameters
    ----------
    limit
        A limit load, best with `optimum=True`.
    load
        The load it is the limit of, as in `blockstat.limit_load`. Three numbers are an acceleration, which follows the
        masses; wrenches stay what they are.
    loads
        Its permanent loads, as in `blockstat.limit_load`; a factor on the weight follows the masses.
    corners
        Whether the derivative by corners is asked for, which takes longer than the others.

    Returns
    -------
    ReserveMap
        Derivatives by quantities that change one at a time.

    Raises
    ------
    InputError
        When there is no limit, when `load` and `loads` are not those of it, for joints whose strength goes with
        their area, and for the corners of joints that have lost their edges.

    Examples
    --------
    A pillar tips at width / height: what its joint loses at each edge counts at the toe alone.

    >>> from blockstat import Assembly, box, limit_load, reserve_map
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = reserve_map(limit_load(pillar, (1, 0, 0)), (1, 0, 0))
    >>> round(found.value, 4), found.edge.round(4).tolist(), bool(abs(found.friction[0]) < 1e-6)
    (0.25, [-1.0], True)
    """
    assembly, faces = limit.assembly, limit.interfaces
    if any(law.strong for law in assembly.joints):
        raise InputError("joints whose strength goes with their area have no map of the reserve; friction alone does")
    pushed = as_load(assembly, load)
    multiplier, twist = pinned(limit, pushed, checked_loads(assembly, loads))
    factor = 1.0 if loads is None else weighted(loads).weight
    field = field_of(assembly, load, multiplier) + (factor - 1.0) * assembly.gravity
    k = faces.point_interface
    a, b = faces.pair[k].T
    force = np.einsum("nij,ni->nj", faces.frame[k], limit.forces)
    edge: Any = np.full(faces.n_interfaces, np.nan)
    if faces.share is None:
        moment = np.einsum("ij,ij->i", edge_speeds(faces), np.cross(force, twist[b, 3:] - twist[a, 3:]))
        edge = -np.bincount(k, moment, faces.n_interfaces)
    friction: Any = np.bincount(k, friction_power(limit, twist), faces.n_interfaces)
    return ReserveMap(
        limit=limit,
        edge=edge,
        friction=friction,
        density=np.where(assembly.support, 0.0, -assembly.volume * np.einsum("ij,ij->i", twist[:, :3], field)),
        corner=point_gradient(limit, multiplier, twist, field) if corners else None,
    )
