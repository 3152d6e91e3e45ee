"""Joint laws: what is different about the joints between two groups of blocks.

Coulomb's cone with cohesion and a tension cut-off, and a limit on the pressure (Rankine's caps):

    |f_t| <= mu f_n + c,    -T <= f_n <= C

with T, c and C [N] the strengths of the joint [Pa] times the share of its area that a contact point stands for. The
programs work with f' = f + a n, a the height of the cone's apex: f' in K, floor <= f'_n <= cap. Without a cohesion of
its own a joint in tension T holds mu T in shear, which is also what a cohesive preload of T does.

A joint crushes when its pressure reaches the compressive strength. Its corners cannot say so, so it is divided into
cells, each with uniform stress and one force at its centroid: every force field found so is one of a real stress
field, and the capacity rises to the true one as the cells become more. Scenes without laws pay nothing for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.polyhedron import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact import Interfaces

#: Cells along each side of a joint that may crush, unless the law says how many.
CELLS = 8
MOST_CELLS = 64
#: Cohesion needs a cone with an apex, and one not so far away that the forces drown in it.
LEAST_FRICTION = 1e-3


@dataclass(frozen=True)
class JointLaw:
    """The law of all joints between two groups; the last law that fits a joint counts."""

    between: tuple[str, str]  #: groups or parts of groups ("wall" fits "wall.north"); "*" fits every block
    friction: float | None = None  #: None: the assembly's
    tension: float = 0.0  #: [Pa], tensile strength of the joint, times its area
    bond: float = 0.0  #: [N], tensile capacity of each joint whatever its area, spread evenly over it
    cohesion: float | None = None  #: [Pa], shear strength without pressure; None: friction x (tension and bond)
    #: [N m], bending and torsion that a bond at the centre of the joint holds; it then holds `bond` in tension and
    #: `bond` in shear, each by itself (a fixed constraint with capacities). None: no bond at the centre.
    bond_moment: float | None = None
    compression: float | None = None  #: [Pa], compressive strength; None: no limit
    cells: int = 0  #: contact cells along each side of the joint; 0: its corners, or 8 if it can crush

    def __post_init__(self) -> None:
        pair = self.between
        if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not all(isinstance(group, str) for group in pair):
            raise InputError(f"joint law: between is {self.between!r}; it must be two group names")
        label = " and ".join(self.between)
        for name in ("friction", "tension", "bond", "cohesion", "bond_moment", "compression"):
            value = getattr(self, name)
            missing = value is None and name not in ("tension", "bond")
            if not missing and (isinstance(value, bool) or not isinstance(value, (int, float, np.number))):
                raise InputError(f"joint law between {label}: {name} is {value!r}; it must be a number")
        if self.friction is not None and not self.friction >= 0:
            raise InputError(f"joint law between {label}: friction is {self.friction!r}; it must be at least 0")
        for name in ("tension", "bond", "cohesion", "bond_moment"):
            value = getattr(self, name)
            if value is not None and not 0 <= value < np.inf:
                raise InputError(f"joint law between {label}: {name} is {value!r}; it must be at least 0")
        if self.compression is not None and not 0 < self.compression < np.inf:
            raise InputError(f"joint law between {label}: compression is {self.compression!r}; it must be above 0")
        if not (isinstance(self.cells, int) and not isinstance(self.cells, bool) and 0 <= self.cells <= MOST_CELLS):
            raise InputError(f"joint law between {label}: cells is {self.cells!r}; it must be 0 to {MOST_CELLS}")

    @property
    def strong(self) -> bool:
        """Whether the joint has a strength of its own, which does not grow with the weight."""
        return bool(set(self.as_dict()) - {"between", "friction", "cells"})

    @property
    def divisions(self) -> int:
        """Cells along each side of the joint, 0 for its corners alone."""
        return self.cells or (CELLS if self.compression is not None else 0)

    def as_dict(self) -> dict[str, object]:
        """What differs from the defaults, for files."""
        return {f.name: value for f in fields(self) if (value := getattr(self, f.name)) != f.default}


def glued(assembly: Assembly, strength: float, *, moment: float | None = None) -> Assembly:
    """The assembly with glue in every joint: a bond of so much force, whatever the joint's area.

    strength [N] : tension that each joint holds, and with friction mu it holds mu x strength more in shear. moment
    [N m] : if given, the bond sits at the centre of the joint and holds `strength` in tension, `strength` in shear
    and `moment` in bending and in torsion, each by itself (see `JointLaw`). Other laws of the assembly stay.
    """
    everywhere = JointLaw(("*", "*"), bond=strength, bond_moment=moment)
    return assembly.with_(
        joints=(everywhere, *(replace(law, bond=strength, bond_moment=moment) for law in assembly.joints))
    )


def check_laws(laws: Sequence[JointLaw], groups: Sequence[str]) -> None:
    """Raise InputError for a law about a group that does not exist."""
    for law in laws:
        for name in law.between:
            if name != "*" and not any(_fits(name, group) for group in groups):
                known = ", ".join(sorted({group for group in groups if group})) or "none"
                raise InputError(f'joint law: no group "{name}"; groups are: {known}')


@dataclass(frozen=True, eq=False)
class PointLaw:
    """The laws of contact points, arrays of shape (n_points,)."""

    friction: Floats
    shift: Floats  #: height a of the cone's apex below zero force [N]
    floor: Floats  #: least f'_n = f_n + a [N], 0 where the apex itself cuts off the tension
    cap: Floats  #: greatest f'_n [N], inf without a compressive strength


def joint_friction(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Coefficient of friction of each interface, shape (n_interfaces,)."""
    friction = np.full(interfaces.n_interfaces, assembly.friction)
    for law, rows in laws_of(assembly, interfaces):
        if law.friction is not None:
            friction[rows] = law.friction
    return friction


def point_law(assembly: Assembly, interfaces: Interfaces) -> PointLaw:
    """The law of each contact point. Raises InputError for cohesion on a joint with next to no friction."""
    k = interfaces.point_interface
    friction = joint_friction(assembly, interfaces)
    n = interfaces.n_interfaces
    tension, cohesion, compression = np.zeros(n), np.full(n, np.nan), np.full(n, np.inf)
    for law, rows in laws_of(assembly, interfaces):
        spread = law.bond if law.bond_moment is None else 0.0
        tension[rows] = law.tension * interfaces.area[rows] + spread
        cohesion[rows] = np.nan if law.cohesion is None else law.cohesion * interfaces.area[rows]
        compression[rows] = np.inf if law.compression is None else law.compression * interfaces.area[rows]
        if law.cohesion and (friction[rows] < LEAST_FRICTION).any():
            label = " and ".join(law.between)
            raise InputError(f"joint law between {label}: cohesion needs a friction of at least {LEAST_FRICTION:g}")
    with np.errstate(divide="ignore", invalid="ignore"):
        apex = np.where(np.isnan(cohesion) | (friction == 0) | np.isinf(friction), tension, cohesion / friction)
    share = interfaces.point_share
    floor = np.maximum(apex - tension, 0.0)
    return PointLaw(friction[k], share * apex[k], share * floor[k], share * (compression + apex)[k])


def laws_of(assembly: Assembly, interfaces: Interfaces) -> list[tuple[JointLaw, np.ndarray]]:
    """Each law with the mask of the interfaces it fits, shape (n_interfaces,), in order."""
    found = []
    for law in assembly.joints:
        one, two = (np.array([_fits(name, group) for group in assembly.groups]) for name in law.between)
        a, b = interfaces.pair.T
        found.append((law, (one[a] & two[b]) | (two[a] & one[b])))
    return found


def last_law(assembly: Assembly, interfaces: Interfaces) -> list[JointLaw | None]:
    """The law that counts for each interface, None where none fits."""
    chosen: list[JointLaw | None] = [None] * interfaces.n_interfaces
    for law, rows in laws_of(assembly, interfaces):
        for row in np.flatnonzero(rows):
            chosen[row] = law
    return chosen


def _fits(name: str, group: str) -> bool:
    return name in ("*", group) or group.startswith(name + ".")
