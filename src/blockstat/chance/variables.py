"""Random variables of an assembly, as functions of independent standard normal ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError, check_choice
from blockstat.imperfection.lost_edges import lose_edges
from blockstat.joint import fits
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

KINDS = ("normal", "lognormal", "uniform")
#: What may be random; density and loads go with a group, as in "density.wall".
KEYS = ("friction", "edge", "push")
GROUP_KEYS = ("density", "loads")
#: A density below this is this [kg/m3]: blocks have weight.
LIGHT = 1e-3


@dataclass(frozen=True)
class Random:
    """A distribution: normal and lognormal by mean and standard deviation, uniform by its two ends.

    Examples
    --------
    >>> Random("uniform", 0.5, 0.7).value(0.0)
    0.6
    """

    kind: str  #: "normal", "lognormal" or "uniform"
    first: float  #: mean, or lower end
    second: float  #: standard deviation, or upper end

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, KINDS)
        if not (math.isfinite(self.first) and math.isfinite(self.second)):
            raise InputError(f"{self.kind}: {self.first} and {self.second} must be finite")
        if self.kind == "uniform" and not self.first <= self.second:
            raise InputError(f"uniform: the ends are {self.first} and {self.second}; the least comes first")
        if self.kind != "uniform" and self.second < 0:
            raise InputError(f"{self.kind}: the standard deviation is {self.second}; it must not be negative")
        if self.kind == "lognormal" and self.first <= 0:
            raise InputError(f"lognormal: the mean is {self.first}; it must be positive")

    def value(self, normal: float) -> float:
        """Return the value of the same probability as that of a standard normal variable.

        Parameters
        ----------
        normal
            The standard normal variable.

        Returns
        -------
        float
            Rises with it.
        """
        if self.kind == "uniform":
            return self.first + (self.second - self.first) * 0.5 * math.erfc(-normal / math.sqrt(2.0))
        if self.kind == "normal":
            return self.first + self.second * normal
        spread = math.log1p((self.second / self.first) ** 2)
        return self.first * math.exp(math.sqrt(spread) * normal - 0.5 * spread)


@dataclass(frozen=True, eq=False)
class Draw:
    """One realisation."""

    assembly: Assembly
    interfaces: Interfaces
    loads: Floats | None  #: permanent loads
    push: float  #: factor on the load in question


def realise(
    assembly: Assembly,
    interfaces: Interfaces,
    loads: Floats | None,
    uncertain: Mapping[str, Random],
    normal: Floats,
) -> Draw:
    """Return the assembly, joints and loads for values of the standard normal variables.

    Parameters
    ----------
    assembly
        The blocks as drawn.
    interfaces
        Their joints, without cells.
    loads
        Permanent loads beside the weight, shape (n_blocks, 6) [N, N m]; None for none.
    uncertain
        The random variables (see `blockstat.reliability`).
    normal
        One value for each of them, shape (n,).

    Returns
    -------
    Draw
        Negative friction, losses and densities, which a normal distribution may give, count as none.
    """
    density, friction, push = assembly.density.copy(), assembly.friction, 1.0
    acting = None if loads is None else np.array(loads, dtype=float)
    joints = interfaces
    for (key, variable), z in zip(uncertain.items(), normal.tolist(), strict=True):
        value = variable.value(z)
        kind, _, group = key.partition(".")
        if key == "friction":
            friction = max(value, 0.0)
        elif key == "edge":
            joints = lose_edges(interfaces, np.full(interfaces.n_interfaces, max(value, 0.0)))
        elif key == "push":
            push = value
        elif kind == "density":
            density[blocks_of(assembly, group)] = max(value, LIGHT)
        elif acting is not None:
            acting[blocks_of(assembly, group)] *= value
    return Draw(assembly.with_(density=density, friction=friction), joints, acting, push)


def checked(assembly: Assembly, uncertain: Mapping[str, Random], loads: Floats | None) -> None:
    """Check the names of random variables.

    Parameters
    ----------
    assembly
        The blocks.
    uncertain
        The random variables.
    loads
        The permanent loads.

    Raises
    ------
    InputError
        For a key or a group that there is not, for none at all, for load factors without loads, and for friction where
        joint laws have their own.
    """
    if not uncertain:
        raise InputError(f"nothing is uncertain; keys are: {', '.join(KEYS)}, density.GROUP and loads.GROUP")
    for key in uncertain:
        kind, _, group = key.partition(".")
        if key in KEYS:
            if key == "friction" and any(law.friction is not None for law in assembly.joints):
                raise InputError('uncertain "friction": joint laws have their own friction')
            continue
        if kind not in GROUP_KEYS or not group:
            raise InputError(f'uncertain "{key}"; keys are: {", ".join(KEYS)}, density.GROUP and loads.GROUP')
        if kind == "loads" and loads is None:
            raise InputError(f'uncertain "{key}": there are no permanent loads')
        if not blocks_of(assembly, group).any():
            assembly.in_group(group)  # raises with the groups there are


def blocks_of(assembly: Assembly, group: str) -> np.ndarray:
    """Return which blocks are of a group; "*" means all.

    Parameters
    ----------
    assembly
        The blocks.
    group
        The group, with its subgroups.

    Returns
    -------
    array of bool
        Shape (n_blocks,).
    """
    return np.array([group == "*" or fits(group, own) for own in assembly.groups])
