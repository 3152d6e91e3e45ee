"""Joint laws: what is different about the joints between two groups of blocks; and ties between two blocks.

Coulomb's cone with cohesion and a tension cut-off, and a limit on the pressure (Rankine's caps):

    |f_t| <= mu f_n + c,    -T <= f_n <= C

with T, c and C [N] the strengths of the joint [Pa] times the share of its area that a contact point stands for. The
programs work with f' = f + a n, a the height of the cone's apex: f' in K, floor <= f'_n <= cap. Without a cohesion of
its own a joint in tension T holds mu T in shear, which is also what a cohesive preload of T does.

A joint crushes when its pressure reaches the compressive strength. Its corners cannot say so, so it is divided into
cells, each with uniform stress and one force at its centroid: every force field found so is one of a real stress
field, and the capacity rises to the true one as the cells become more. Scenes without laws pay nothing for them.

An edge or a corner on a face has no area. Tensile strength, cohesion and bonds give it nothing, and with a compressive
strength, however great, it carries nothing: a real edge crushes until it has an area that a rigid block does not have.
A warning names its blocks. What stands without it is stable; what falls only by driving it in is undecided. To let it
carry, leave compressive strength out of its law, or model the narrow face that the edge really has.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from blockstat.errors import ROUGHEST, TOO_ROUGH, InputError, is_number, no_such

#: Cells along each side of a joint that may crush, unless the law says how many.
CELLS = 8
MOST_CELLS = 64
#: Strengths above this [Pa, N, N m] are mistakes of a unit: granite bears 5e8 Pa. Beside larger ones the weight is
#: rounding.
STRONGEST = 1e10
LAYER = "::"  #: what stands between the layer of a block and its own name, as drawing programs write it


@dataclass(frozen=True)
class JointLaw:
    """The law of all joints between two groups; the last law that fits a joint counts.

    Examples
    --------
    >>> from blockstat import JointLaw
    >>> JointLaw(("wall", "*"), friction=0.5, tension=1e5).as_dict()
    {'between': ('wall', '*'), 'friction': 0.5, 'tension': 100000.0}
    """

    between: tuple[str, str]  #: groups or parts of groups ("wall" fits "wall.north"); "*" fits every block
    friction: float | None = None  #: None: the assembly's
    tension: float = 0.0  #: [Pa], tensile strength of the joint, times its area
    bond: float = 0.0  #: [N], tensile capacity of each joint whatever its area, spread evenly over it
    cohesion: float | None = None  #: [Pa], shear strength without pressure; None: friction x (tension and bond)
    #: [N m], bending and torsion that a bond at the centre of the joint holds; it then holds `bond` in tension and
    #: `bond` in shear, each by itself (a fixed constraint with capacities). None: no bond at the centre.
    bond_moment: float | None = None
    #: [Pa], compressive strength, under which contacts without area carry nothing; None: no limit
    compression: float | None = None
    cells: int = 0  #: contact cells along each side of the joint; 0: its corners, or 8 if it can crush

    def __post_init__(self) -> None:
        pair = self.between
        if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not all(isinstance(group, str) for group in pair):
            raise InputError(f"joint law: between is {self.between!r}; it must be two group names")
        label = " and ".join(self.between)
        for name in ("friction", "tension", "bond", "cohesion", "bond_moment", "compression"):
            value = getattr(self, name)
            missing = value is None and name not in ("tension", "bond")
            if not missing and not is_number(value):
                raise InputError(f"joint law between {label}: {name} is {value!r}; it must be a number")
        if self.friction is not None and not self.friction >= 0:
            raise InputError(f"joint law between {label}: friction is {self.friction!r}; it must be at least 0")
        if self.friction is not None and ROUGHEST < self.friction < np.inf:
            raise InputError(f"joint law between {label}: {TOO_ROUGH.format(self.friction)}")
        units = {"tension": "Pa", "cohesion": "Pa", "compression": "Pa", "bond": "N", "bond_moment": "N m"}
        for name, unit in units.items():
            value, what = getattr(self, name) or 0.0, "stone" if unit == "Pa" else "bond"
            if STRONGEST < value < np.inf:
                raise InputError(
                    f"joint law between {label}: {name} is {value!r} {unit}; no {what} bears {STRONGEST:g} {unit}"
                )
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
        """Return what differs from the defaults, for files.

        Returns
        -------
        dict
            Values by field.
        """
        return {f.name: value for f in fields(self) if (value := getattr(self, f.name)) != f.default}


def check_laws(laws: Sequence[JointLaw], groups: Sequence[str]) -> None:
    """Check that joint laws are about groups that exist.

    Parameters
    ----------
    laws : sequence of JointLaw
        The laws.
    groups : sequence of str
        The groups of the blocks.

    Raises
    ------
    InputError
        For a law about a group that does not exist.
    """
    unknown = [
        f"joint law: {no_such('group', name, sorted({group for group in groups if group}))}"
        for law in laws
        for name in law.between
        if name != "*" and not any(fits(name, group) for group in groups)
    ]
    if unknown:
        raise InputError(*dict.fromkeys(unknown))


def fits(name: str, group: str) -> bool:
    """Return whether a name in a joint law means a group.

    Parameters
    ----------
    name : str
        The group itself, one that it is part of, or "*".
    group : str
        The group of a block.

    Returns
    -------
    bool
        True where the law holds for blocks of the group.

    Examples
    --------
    >>> fits("wall", "wall.north"), fits("wall", "walls")
    (True, False)
    """
    return name in ("*", group) or group.startswith(name + ".")


def with_layers(names: Sequence[str], given: Iterable[int | str] | int | str) -> list[int | str]:
    """Return what is given, with the names of its blocks in the place of a layer.

    A layer is the text before a "::" in names of blocks, unless a block has that name itself.

    Parameters
    ----------
    names : sequence of str
        Names of all blocks.
    given : str, int, or an iterable of them
        Names and numbers of blocks, and names of layers.

    Returns
    -------
    list of str or int
        In the order given.

    Examples
    --------
    >>> with_layers(["ARCH::left", "ARCH::right", "tie"], ["tie", "ARCH"])
    ['tie', 'ARCH::left', 'ARCH::right']
    """
    asked = [given] if isinstance(given, (str, int)) or not isinstance(given, Iterable) else list(given)
    unknown = {own for own in asked if isinstance(own, str)}.difference(names)
    inside: dict[int | str, list[str]] = {
        own: [name for name in names if name.startswith(f"{own}{LAYER}")] for own in unknown
    }
    return [part for own in asked for part in inside.get(own) or [own]]


@dataclass(frozen=True)
class Tie:
    """A straight tie, anchor or tendon between two blocks, or a strut: a force along the line of its ends.

    In a limit analysis the force is an unknown from `least` to `greatest`: the tie yields. Where both are the same it
    is a constant force, which is a load. A pretension of a tie that yields does not change a limit load: it is the
    least force of a tie that cannot slacken below it.

    Examples
    --------
    >>> from blockstat import Tie
    >>> Tie(("pier.left", "pier.right"), ((0, 0, 2), (4, 0, 2)), greatest=5e4).as_dict()
    {'between': ('pier.left', 'pier.right'), 'points': ((0, 0, 2), (4, 0, 2)), 'greatest': 50000.0}
    """

    between: tuple[int | str, int | str]  #: two blocks, by name or number; a support for an anchor in the ground
    points: tuple[Sequence[float], Sequence[float]]  #: where it holds each of them, shape (2, 3) [m]
    least: float = 0.0  #: T0 [N], at least 0
    greatest: float = np.inf  #: Ty [N], what it or its anchorage bears: at most 1e10, or inf for no limit
    strut: bool = False  #: whether it pushes the blocks apart instead of pulling them together
    name: str = ""

    def __post_init__(self) -> None:
        label = self.label
        if not isinstance(self.strut, (bool, np.bool_)):
            raise InputError(f"{label}: strut is {self.strut!r}; it must be true or false")
        if not isinstance(self.between, (tuple, list)) or len(self.between) != 2 or self.between[0] == self.between[1]:
            raise InputError(f"{label}: between is {self.between!r}; it must be two blocks")
        try:
            ends = np.asarray(self.points, dtype=float)
        except (TypeError, ValueError):
            ends = np.empty(0)
        if ends.shape != (2, 3) or not np.isfinite(ends).all() or not (ends[0] != ends[1]).any():
            raise InputError(f"{label}: points are {self.points!r}; they must be two different points of three numbers")
        for field in ("least", "greatest"):
            value = getattr(self, field)
            if not is_number(value) or not value >= 0:
                raise InputError(f"{label}: {field} is {value!r}; it must be a number of at least 0")
            if STRONGEST < value < np.inf:
                raise InputError(f"{label}: {field} is {value!r} N; it must be at most {STRONGEST:g} N, or inf")
        if not self.least <= self.greatest or np.isinf(self.least):
            raise InputError(f"{label}: least is {self.least!r}; it must be at most greatest, {self.greatest!r}")

    @property
    def label(self) -> str:
        """What messages call it."""
        return f'tie "{self.name}"' if self.name else "tie"

    @property
    def constant(self) -> bool:
        """Whether its force is given."""
        return self.least == self.greatest

    def as_dict(self) -> dict[str, object]:
        """Return what differs from the defaults, for files.

        Returns
        -------
        dict
            Values by field.
        """
        return {f.name: value for f in fields(self) if (value := getattr(self, f.name)) != f.default}
