"""The designs that a search may try: a scene, and the values that each of its parameters may take."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import product
from os import PathLike
from typing import Any

from blockstat.assembly import Assembly
from blockstat.errors import InputError, no_such
from blockstat.spec import Building, Composition, Range, Scene, parameters, with_values

Values = dict[str, float]


@dataclass(frozen=True)
class Space:
    """A scene and the ranges to move, in the order in which they are moved."""

    scene: Scene
    ranges: dict[str, Range]

    @property
    def names(self) -> list[str]:
        """Names of the parameters, in the order in which they are moved."""
        return list(self.ranges)

    @property
    def start(self) -> Values:
        """Every parameter at its largest; what may be left out is there."""
        return {name: found.max for name, found in self.ranges.items()}

    @property
    def size(self) -> int:
        """Number of combinations."""
        count = 1
        for found in self.ranges.values():
            count *= len(found.steps())
        return count

    def line(self, name: str) -> list[float]:
        """Return the values of one parameter as the paper tries them.

        Numbers go from the largest down; presence is tried without, then with.

        Parameters
        ----------
        name : str
            One of `names`.

        Returns
        -------
        list of float

        References
        ----------
        Procedural masonry with rigid-block dynamics; the loop of its optimiser.
        """
        values = self.ranges[name].steps()
        return values[::-1] if is_boolean(self.ranges[name]) else values

    def grid(self) -> Iterator[Values]:
        """Go through every combination, in nested loops over the lines.

        Yields
        ------
        dict of str to float
            Parameter values of one design.
        """
        for values in product(*(self.line(name) for name in self.names)):
            yield dict(zip(self.names, values, strict=True))

    def around(self, values: Mapping[str, float], names: Sequence[str]) -> Iterator[Values]:
        """Go through the designs on the steps of some parameters, from the nearest to a design on.

        Parameters
        ----------
        values : mapping of str to float
            Of the design; it need not lie on steps.
        names : sequence of str
            The parameters that take other values; the others keep theirs.

        Yields
        ------
        dict of str to float
            Parameter values of one design, by growing sum of the distances in steps.

        Examples
        --------
        >>> from blockstat import scene_from, space_of
        >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
        >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
        >>> near = space_of(scene_from(hut)).around({"wall.thickness": 0.45}, ["wall.thickness"])
        >>> [design["wall.thickness"] for design in near]
        [0.4, 0.6, 0.2, 0.8]
        """
        lines = [sorted((abs(v - values[n]) / self.ranges[n].step, v) for v in self.ranges[n].steps()) for n in names]
        first: tuple[int, ...] = (0,) * len(names)
        # Of each design that is given, its neighbours one place further along one line wait for their turn.
        waiting: list[tuple[float, tuple[int, ...]]] = [(sum(line[0][0] for line in lines), first)]
        met: set[tuple[int, ...]] = {first}
        while waiting:
            away, places = heappop(waiting)
            own = {name: line[k][1] for name, line, k in zip(names, lines, places, strict=True)}
            yield {name: own.get(name, values[name]) for name in self.names}
            for i, (line, k) in enumerate(zip(lines, places, strict=True)):
                further = (*places[:i], k + 1, *places[i + 1 :])
                if k + 1 < len(line) and further not in met:
                    met.add(further)
                    heappush(waiting, (away + line[k + 1][0] - line[k][0], further))

    def is_on_steps(self, values: Mapping[str, float]) -> bool:
        """Tell whether a design lies on the steps of the ranges.

        Parameters
        ----------
        values : mapping of str to float
            Parameter values of the design.

        Returns
        -------
        bool
        """
        return all(value in self.ranges[name].steps() for name, value in values.items())

    def at(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with some values.

        Parameters
        ----------
        values : mapping of str to float
            By parameter; the others stay as they are in the scene.

        Returns
        -------
        Scene

        Raises
        ------
        InputError
            For a path that is no range, or a value outside its bounds.
        """
        return with_values(self.scene, values)

    def near(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with some values that may lie a little outside the bounds, as differences need it.

        Parameters
        ----------
        values : mapping of str to float
            By parameter; the others stay as they are in the scene.

        Returns
        -------
        Scene
            The bounds of its ranges take in the values.

        Raises
        ------
        InputError
            For a path that is no range, or a value that a key cannot have.
        """
        return with_values(self.scene, values, beyond=True)


def space_of(scene: Scene, names: Sequence[str] | str | None = None) -> Space:
    """Return the space of a scene's ranges, or of some of them.

    Parameters
    ----------
    scene : Scene
        The scene with its ranges.
    names : str or sequence of str, optional
        The parameters to move, in order; by default all.

    Returns
    -------
    Space
        Its scene has every parameter at its largest, or, where a key cannot have what follows, is as it was given.

    Raises
    ------
    InputError
        For what is no scene, an unknown name, one named twice, no name at all, or a scene without ranges.

    Examples
    --------
    >>> from blockstat import scene_from, space_of
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
    >>> space_of(scene_from(hut)).line("wall.thickness")
    [0.8, 0.6, 0.4, 0.2]
    """
    space = Space(scene, chosen_ranges(scene, names, "search"))
    try:
        return Space(space.at(space.start), space.ranges)
    except InputError:
        return space  # the row of that design says why it cannot be built; others may be


def check_scene(value: Any) -> None:
    """Raise InputError for anything but a scene.

    Parameters
    ----------
    value : object
        What was given.

    Raises
    ------
    InputError
        Saying what makes a scene.

    Examples
    --------
    >>> check_scene("arch.toml")
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: scene is 'arch.toml'; it must be a Scene, as blockstat.load_scene makes one of a file
    """
    if isinstance(value, (Building, Composition)):
        return
    if isinstance(value, (str, PathLike)):
        raise InputError(f"scene is {str(value)!r}; it must be a Scene, as blockstat.load_scene makes one of a file")
    own = "of type Assembly, which has no ranges" if isinstance(value, Assembly) else f"of type {type(value).__name__}"
    made = "as blockstat.load_scene makes one of a file and blockstat.scene_from of a table"
    raise InputError(f"scene is {own}; it must be a Scene, {made}")


def chosen_ranges(scene: Scene, names: Sequence[str] | str | None, purpose: str) -> dict[str, Range]:
    """Return the ranges of a scene, or some of them.

    Parameters
    ----------
    scene : Scene
        The scene with its ranges.
    names : str or sequence of str or None
        The parameters, in order; None for all.
    purpose : str
        What is done with them, for the error: "search" or "sweep".

    Returns
    -------
    dict of str to Range
        By parameter.

    Raises
    ------
    InputError
        As `space_of`.
    """
    check_scene(scene)
    ranges = parameters(scene)
    if not ranges and not names:
        raise InputError(f'"{scene.name}" has no parameter to {purpose}; write one as {{value, min, max, step}}')
    if names is None:
        return ranges
    chosen = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else []
    if not chosen:
        raise InputError(f"names is {names!r}; it must name at least one parameter of: {', '.join(ranges)}")
    for name in chosen:
        if name not in ranges:
            raise no_such("parameter", name, ranges)
    if len(set(chosen)) < len(chosen):
        raise InputError(f"parameters to {purpose} are {', '.join(chosen)}; each may be named once")
    return {name: ranges[name] for name in chosen}


def is_boolean(found: Range) -> bool:
    """Tell whether a range says absent (0) or present (1).

    Parameters
    ----------
    found : Range
        Of a parameter.

    Returns
    -------
    bool
    """
    return (found.min, found.max, found.step) == (0.0, 1.0, 1.0)


def is_discrete(found: Range) -> bool:
    """Tell whether a range counts something.

    Parameters
    ----------
    found : Range
        Of a parameter.

    Returns
    -------
    bool
        True where its ends and its step are whole numbers.
    """
    return all(float(number).is_integer() for number in (found.min, found.max, found.step))
