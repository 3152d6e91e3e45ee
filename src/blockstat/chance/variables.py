"""Random variables: distributions, and the keys that say what they are of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from blockstat.assembly import check_supports
from blockstat.contact.point_law import kept_by
from blockstat.errors import HUGE, InputError, check_choice, known_options
from blockstat.joint import fits
from blockstat.loads import Loads, numbers
from blockstat.spec.material import KEYS, KNOWN_KEYS, is_random_key

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

KINDS = ("normal", "lognormal", "uniform")
#: What has a value of its own.
EACH = ("all", "group", "course", "block", "joint")
#: Keys whose values belong to joints, and those of which there is one value.
OF_JOINTS, SINGLE = ("friction", "edge"), ("corner", "push")
#: The length of a direction may be so far from one, as it is written with three digits.
UNIT = 1e-3


@dataclass(frozen=True)
class Random:
    """A distribution: normal and lognormal by mean and standard deviation, uniform by its two ends.

    Examples
    --------
    >>> from blockstat import Random
    >>> print(Random("uniform", 0.5, 0.7).value(0.0))
    0.6
    """

    kind: str  #: "normal", "lognormal" or "uniform"
    first: float  #: mean, or lower end
    second: float  #: standard deviation, or upper end
    #: what has a value of its own: "all" together, each "group", "course" (blocks of a group at one height), "block" or
    #: "joint"; a joint counts with the higher of its two blocks. A corner always has its own, in each direction.
    each: str = "all"
    #: of any two of these values, in the space of standard normal variables: the part of the variance they share
    correlation: float = 0.0

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, KINDS)
        check_choice("each", self.each, EACH)
        if not max(abs(self.first), abs(self.second)) < HUGE or math.isnan(self.second):
            raise InputError(f"{self.kind}: {self.first} and {self.second} must be finite and below {HUGE:g}")
        if self.kind == "uniform" and not self.first <= self.second:
            raise InputError(f"uniform: the ends are {self.first} and {self.second}; the least comes first")
        if self.kind != "uniform" and self.second < 0:
            raise InputError(f"{self.kind}: the standard deviation is {self.second}; it must not be negative")
        if self.kind == "lognormal" and self.first < 1 / HUGE:
            raise InputError(f"lognormal: the mean is {self.first}; it must be positive, {1 / HUGE:g} at least")
        if not 0 <= self.correlation <= 1:
            raise InputError(f"{self.kind}: the correlation is {self.correlation}; it must be from 0 to 1")

    def value(self, normal: Any) -> Any:
        """Return the value of the same probability as that of a standard normal variable.

        Parameters
        ----------
        normal
            The standard normal variable, a number or an array.

        Returns
        -------
        float or Floats
            Rises with it.
        """
        if self.kind == "uniform":
            return self.first + (self.second - self.first) * ndtr(normal)
        if self.kind == "normal":
            return self.first + self.second * normal
        spread = math.log1p((self.second / self.first) ** 2)
        return self.first * np.exp(math.sqrt(spread) * normal - 0.5 * spread)

    def slope(self, normal: Any) -> Any:
        """Return the derivative of `value`.

        Parameters
        ----------
        normal
            The standard normal variable, a number or an array.

        Returns
        -------
        float or Floats
            Of the same shape, not negative.
        """
        if self.kind == "uniform":
            return (self.second - self.first) * np.exp(-0.5 * np.square(normal)) / math.sqrt(2.0 * math.pi)
        if self.kind == "normal":
            return self.second * np.ones_like(normal)
        return math.sqrt(math.log1p((self.second / self.first) ** 2)) * self.value(normal)


@known_options
def random_variables(assembly: Assembly) -> tuple[dict[str, Random], list[float] | None]:
    """Return the random variables that the scene of an assembly names under `[uncertain]`.

    Parameters
    ----------
    assembly
        Built from a scene.

    Returns
    -------
    uncertain : dict of Random
        By key, as `blockstat.reliability` takes them; none where the scene names none.
    direction : list of float or None
        Of the acceleration that "push" is a multiple of, in units of gravity; None where nothing pushes.

    Raises
    ------
    InputError
        For a distribution that is none.

    Examples
    --------
    >>> from blockstat import build, random_variables, scene_from
    >>> post = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    >>> random = {"friction": {"kind": "normal", "mean": 0.6, "deviation": 0.1}}
    >>> scene = scene_from({"name": "gate", "elements": {"post": post}, "uncertain": random})
    >>> random_variables(build(scene))[0]["friction"].first
    0.6
    """
    found, direction = {}, None
    for key, table in assembly.metadata.get("uncertain", {}).items():
        own = dict(table)
        direction = own.pop("direction", None) or direction
        ends = ("least", "most") if own["kind"] == "uniform" else ("mean", "deviation")
        try:
            found[key] = Random(own["kind"], own[ends[0]], own[ends[1]], own["each"], own["correlation"])
        except InputError as error:
            raise InputError(f"uncertain.{key}: {error}") from None
    return found, direction


def as_strong_as(uncertain: Mapping[str, Random], strength: float) -> dict[str, Random]:
    """Return random variables in which the push is so many times as strong.

    Parameters
    ----------
    uncertain
        The random variables.
    strength
        Of the push, in units of gravity.

    Returns
    -------
    dict of Random
        With a push of just that strength where there was none, unless it is one.

    Examples
    --------
    >>> as_strong_as({"push": Random("normal", 1.0, 0.1)}, 0.3)["push"].first
    0.3
    """
    if strength == 1.0:
        return dict(uncertain)
    push = uncertain.get("push", Random("uniform", 1.0, 1.0))
    return {**uncertain, "push": replace(push, first=strength * push.first, second=strength * push.second)}


def check_strength(uncertain: Mapping[str, Random], load: Any) -> None:
    """Check that it is known how strong a load is that acts once.

    Parameters
    ----------
    uncertain
        The random variables.
    load
        As in `blockstat.reliability`.

    Raises
    ------
    InputError
        For three numbers that are no unit vector, where no "push" says how often the direction acts: their length
        would be dropped.
    """
    values = numbers(load)
    if "push" in uncertain or values.shape != (3,):
        return
    length = float(np.linalg.norm(values))
    if length > 0 and abs(length - 1.0) > UNIT:
        given = ", ".join(f"{float(value):g}" for value in values)
        raise InputError(
            f'load is ({given}), a direction, which has no size: without a random "push" it would act as strong as '
            f"gravity. Give {length:.4g} * acceleration(assembly, ({given})), which does not follow random densities, "
            f'or "push": Random("uniform", {length:.4g}, {length:.4g}), which does; or a vector of length 1'
        )


def checked(assembly: Assembly, uncertain: Mapping[str, Random], loads: Loads | None) -> None:
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
        For an assembly without supports, for what is no `Random`, for a key or a group that there is not, for none at
        all, for load factors without loads, for friction where joint laws have their own, and where there is nothing to
        have a value of its own.
    """
    check_supports(assembly)
    if not uncertain:
        raise InputError(f"nothing is uncertain; keys are: {KNOWN_KEYS}")
    for key, variable in uncertain.items():
        if not isinstance(variable, Random):
            example = 'Random("lognormal", 0.7, 0.05)'
            raise InputError(f'uncertain "{key}" is {variable!r}; it must be a blockstat.Random, such as {example}')
        kind, _, group = key.partition(".")
        if key in SINGLE and variable.each != "all":
            raise InputError(f'uncertain "{key}": each is "{variable.each}"; it has no parts of its own to choose')
        if key in SINGLE and variable.correlation:
            raise InputError(f'uncertain "{key}": correlation is {variable.correlation}; its values have none')
        if key not in OF_JOINTS and variable.each == "joint":
            raise InputError(f'uncertain "{key}": each is "joint"; it belongs to blocks: all, group, course or block')
        if key in KEYS:
            own = [law for law in assembly.joints if law.friction is not None]
            if key == "friction" and own:
                raise InputError(f'uncertain "friction": joints {kept_by(own)}; leave it out where friction is random')
            continue
        if not is_random_key(key):
            raise InputError(f'uncertain "{key}"; keys are: {KNOWN_KEYS}')
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
