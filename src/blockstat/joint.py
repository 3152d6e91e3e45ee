"""Joint laws: what is different about the joints between two groups of blocks.

A law shifts the friction cone along its axis: with a tension capacity T at a point, f + T n lies in K. So a joint holds
T in tension and mu T in shear without pressure, which is also what a cohesive preload of T does. Scenes without laws
pay nothing for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.polyhedron import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact import Interfaces


@dataclass(frozen=True)
class JointLaw:
    """The law of all joints between two groups; the last law that fits a joint counts."""

    between: tuple[str, str]  #: groups or parts of groups ("wall" fits "wall.north"); "*" fits every block
    friction: float | None = None  #: None: the assembly's
    tension: float = 0.0  #: [Pa], tensile strength of the joint, times its area
    bond: float = 0.0  #: [N], tensile capacity of each joint whatever its area

    def __post_init__(self) -> None:
        label = " and ".join(self.between)
        if len(self.between) != 2 or not all(isinstance(group, str) for group in self.between):
            raise InputError(f"joint law: between is {self.between!r}; it must be two group names")
        if self.friction is not None and not self.friction >= 0:
            raise InputError(f"joint law between {label}: friction is {self.friction!r}; it must be at least 0")
        for name in ("tension", "bond"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"joint law between {label}: {name} is {getattr(self, name)!r}; it must be at least 0")


def check_laws(laws: Sequence[JointLaw], groups: Sequence[str]) -> None:
    """Raise InputError for a law about a group that does not exist."""
    for law in laws:
        for name in law.between:
            if name != "*" and not any(_fits(name, group) for group in groups):
                known = ", ".join(sorted({group for group in groups if group})) or "none"
                raise InputError(f'joint law: no group "{name}"; groups are: {known}')


def joint_friction(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Coefficient of friction of each interface, shape (n_interfaces,)."""
    friction = np.full(interfaces.n_interfaces, assembly.friction)
    for law, rows in _rows(assembly, interfaces):
        if law.friction is not None:
            friction[rows] = law.friction
    return friction


def point_tension(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Tension capacity of each contact point [N]: that of its interface in equal shares, shape (n_points,)."""
    capacity = np.zeros(interfaces.n_interfaces)
    for law, rows in _rows(assembly, interfaces):
        capacity[rows] = law.tension * interfaces.area[rows] + law.bond
    share = capacity / np.maximum(np.diff(interfaces.start), 1)
    return share[interfaces.point_interface]


def _rows(assembly: Assembly, interfaces: Interfaces) -> list[tuple[JointLaw, np.ndarray]]:
    found = []
    for law in assembly.joints:
        one, two = (np.array([_fits(name, group) for group in assembly.groups]) for name in law.between)
        a, b = interfaces.pair.T
        found.append((law, (one[a] & two[b]) | (two[a] & one[b])))
    return found


def _fits(name: str, group: str) -> bool:
    return name in ("*", group) or group.startswith(name + ".")
