"""Imperfections, and the cases among which the worst one is.

Less of a joint and less friction leave fewer admissible forces, so all of the loss is the worst case: one program,
still conic. (With both tensile strength and a cohesion of its own less friction narrows the cone but lowers its apex;
there it is a case and not a bound, and the words of the case say so.) Densities and load factors lie in a box, and the
loads w + lambda l depend linearly on them. The loads that some admissible forces balance are a convex set. So an
assembly stands under all loads of the box if it does at its vertices, and a multiplier is carried in all of the box if
it is at its vertices: the worst case is one of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.contact.tolerance import LENGTH, UNITS
from blockstat.errors import InputError
from blockstat.imperfection.lost_edges import check_edges, least_width, lose_edges
from blockstat.joint import fits
from blockstat.loads import Loads, numbers, weighted
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.joint import JointLaw

#: What the words of a case add where less friction need not be worse.
NO_BOUND = "one case and no bound, as joints have cohesion and tensile strength"
#: Ranges of density and load: each one doubles the cases.
MOST = 10


@dataclass(frozen=True)
class Imperfections:
    """What a robust verdict allows for.

    Examples
    --------
    >>> from blockstat import Imperfections
    >>> Imperfections(edge="3 mm", friction=1.2, density={"wall": (1800, 2200)}).words
    'joints lose 3 mm at each edge, friction / 1.2'
    """

    #: what each joint loses along each edge: a length [m], or text: "3 mm", or "5 %" of the joint's least width.
    #: Edges and corners of other blocks have nothing to bear on along the rims of faces that have lost a length.
    edge: float | str = 0.0
    friction: float = 1.0  #: divides the coefficients of friction of all joints, at least 1
    #: least and greatest density [kg/m3] by group ("wall" takes "wall.north" along, "*" all); the last that fits counts
    density: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    #: least and greatest factor on the permanent loads beside the weight, by group of the blocks that bear them
    loads: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._edge()
        if not (isinstance(self.friction, (int, float)) and 1 <= self.friction < np.inf):
            raise InputError(f"imperfections: friction is {self.friction!r}; it divides friction and is at least 1")
        for name, ranges in (("density", self.density), ("loads", self.loads)):
            if not isinstance(ranges, Mapping):
                raise InputError(f"imperfections: {name} is {ranges!r}; it must be ranges by group")
            for group, ends in ranges.items():
                if not _rising(ends) or (name == "density" and ends[0] <= 0):
                    what = "two densities [kg/m3]" if name == "density" else "two factors"
                    raise InputError(f'imperfections: {name} of "{group}" is {ends}; it must be {what}, least first')
        if len(self.density) + len(self.loads) > MOST:
            raise InputError(f"imperfections: {len(self.density) + len(self.loads)} ranges; {MOST} are the most")

    def _edge(self) -> tuple[float, bool]:
        """The loss, and whether it is a share of the joint."""
        value = self.edge
        if isinstance(value, str):
            length, share = LENGTH.fullmatch(value), LENGTH.fullmatch(value.replace("%", "m"))
            if length:
                return float(length[1]) * UNITS[length[2]], False
            if value.strip().endswith("%") and share and float(share[1]) < 50:
                return float(share[1]) / 100, True
        elif isinstance(value, (int, float)) and 0 <= value < np.inf:
            return float(value), False
        raise InputError(f'imperfections: edge is {value!r}; it must be metres, or text such as "3 mm" or "5 %"')

    @property
    def words(self) -> str:
        """What all cases have in common, in words."""
        loss, relative = self._edge()
        what = f"{100 * loss:g} % of their width" if relative else f"{1e3 * loss:g} mm"
        parts = [f"joints lose {what} at each edge"] if loss else []
        return ", ".join(parts + ([f"friction / {self.friction:g}"] if self.friction > 1 else []))

    def joints(self, assembly: Assembly, interfaces: Interfaces) -> Interfaces:
        """Return the joints without their edges.

        Parameters
        ----------
        assembly
            The blocks.
        interfaces
            Joints without cells.

        Returns
        -------
        Interfaces
            Those that are left; where the loss is a length, without what of edges, corners and crossings bears on a
            lost strip of a face.
        """
        loss, relative = self._edge()
        if not loss:
            return interfaces
        check_edges("imperfections", interfaces)
        if relative:  # of a joint, not of the faces beside it
            return lose_edges(interfaces, loss * least_width(interfaces))
        return lose_edges(interfaces, np.full(interfaces.n_interfaces, loss), assembly)


@dataclass(frozen=True, eq=False)
class Realisation:
    """One case: an assembly, its joints and loads, and what it is in words."""

    assembly: Assembly
    interfaces: Interfaces
    loads: Floats | None
    words: str


def realisations(
    assembly: Assembly, interfaces: Interfaces, loads: Loads | None, imperfections: Imperfections
) -> Iterator[Realisation]:
    """Give the cases among which the worst one is.

    Parameters
    ----------
    assembly
        The blocks as drawn.
    interfaces
        Their joints.
    loads
        Wrench on each block beside the weight, shape (n_blocks, 6) [N, N m], or these with a factor on the weight,
        which is that of the densities of each case; None for none.
    imperfections
        What is allowed for.

    Yields
    ------
    Realisation
        One for each combination of the ends of the ranges.

    Raises
    ------
    InputError
        For a group that no block has, and for load factors without loads.
    """
    if imperfections.loads and loads is None:
        raise InputError("imperfections: loads has factors, but there are no permanent loads")
    own = None if loads is None else weighted(loads)
    joints = imperfections.joints(assembly, interfaces)
    gamma = imperfections.friction
    caveat = [NO_BOUND] if gamma > 1 and any(_apex_moves(law) for law in assembly.joints) else []
    weaker = assembly
    if gamma > 1:
        laws = [law if law.friction is None else replace(law, friction=law.friction / gamma) for law in assembly.joints]
        weaker = assembly.with_(friction=assembly.friction / gamma, joints=laws)
        if joints.friction is not None:
            joints = replace(joints, friction=joints.friction / gamma)
    ranges = [("density", *item) for item in imperfections.density.items()]
    ranges += [("loads", *item) for item in imperfections.loads.items()]
    chosen = [_blocks(assembly, group) for _, group, _ in ranges]
    for ends in product(*(dict.fromkeys(span) for _, _, span in ranges)):
        density, factor = assembly.density.copy(), np.ones(assembly.n_blocks)
        words = [imperfections.words, *caveat] if imperfections.words else []
        for (kind, group, _), blocks, value in zip(ranges, chosen, ends, strict=True):
            (density if kind == "density" else factor)[blocks] = value
            words.append(f'{"density" if kind == "density" else "loads"} of "{group}" {value:g}')
        case = weaker if np.array_equal(density, assembly.density) else weaker.with_(density=density)
        acting = None if own is None else factor[:, None] * own.beside + own.more_weight(case)
        yield Realisation(case, joints, acting, ", ".join(words))


def _rising(ends: Any) -> bool:
    """Whether these are two finite numbers, the least first."""
    span = numbers(ends)
    rising = span.shape == (2,) and bool(-np.inf < span[0] <= span[1] < np.inf)
    return rising and not any(isinstance(end, str) for end in ends)


def _apex_moves(law: JointLaw) -> bool:
    """Whether less friction lets a joint in tension hold more shear."""
    return bool(law.cohesion) and bool(law.tension or (law.bond and law.bond_moment is None))


def _blocks(assembly: Assembly, group: str) -> np.ndarray:
    """Which blocks a range means."""
    if group == "*":
        return np.ones(assembly.n_blocks, dtype=bool)
    found = np.array([fits(group, own) for own in assembly.groups])
    if not found.any():
        assembly.in_group(group)  # raises with the groups there are
    return found
