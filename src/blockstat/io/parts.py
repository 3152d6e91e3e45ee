"""What a file says, before anything is checked: readers make it, `read` and `repair` turn it into an assembly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from blockstat.assembly import LOWEST, Assembly, Block
from blockstat.errors import InputError, NoSupportError, check_gravity, rough
from blockstat.io.names import numbered
from blockstat.io.raw import glb, ply, stl
from blockstat.io.raw.precision import spacing
from blockstat.joint import Tie
from blockstat.loads import up_of
from blockstat.result import listed
from blockstat.typing import Floats

INFINITE = "inf"  #: what a file says for a friction without limit: JSON has no number for it
UP = ("x", "y", "z", "-x", "-y", "-z")  #: axes of a file that may point up
#: Corners that single precision moves by no more than this fraction of their extent are near enough to the origin.
NEAR = 1e-6
#: Metres in one unit of length.
UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}


def own_up(suffix: str) -> str:
    """Return the axis of a file that points up by its format.

    Parameters
    ----------
    suffix : str
        Of the file, as ".glb".

    Returns
    -------
    str
        One of `UP`.
    """
    return "y" if suffix.lower() == ".glb" else "z"


def friction_said(friction: float) -> float | str:
    """Return what a JSON file says for a coefficient of friction.

    Parameters
    ----------
    friction : float
        The coefficient.

    Returns
    -------
    float or str
        "inf" for one without limit.
    """
    return INFINITE if friction == np.inf else friction


def with_friction(said: Any) -> Any:
    """Return a table of a JSON file with its friction as a number.

    Parameters
    ----------
    said : object
        The table; files of before 0.3 say Infinity for "inf".

    Returns
    -------
    object
        The same where it says no "inf".
    """
    infinite = isinstance(said, dict) and said.get("friction") == INFINITE
    return {**said, "friction": np.inf} if infinite else said


@dataclass(frozen=True)
class Parts:
    """Blocks as a file gives them, perhaps open or inverted, and what else it says."""

    blocks: Sequence[Block]
    supports: Iterable[int | str]
    options: dict[str, Any] = field(default_factory=dict)  #: keyword arguments of `Assembly.from_blocks`
    up: str = "z"  #: the axis of the file that points up here, along z
    spacing: Sequence[float] = ()  #: of numbers in single precision at each block, none for double precision

    def __post_init__(self) -> None:
        object.__setattr__(self, "options", with_friction(self.options))

    def assembled(self) -> Assembly:
        """Return the assembly.

        Returns
        -------
        Assembly

        Raises
        ------
        InputError
            For blocks that are no closed solids (see `Assembly.from_blocks`).
        """
        return Assembly.from_blocks(self.blocks, supports=self.supports, **self.options)

    def scaled(self, metres: float) -> Parts:
        """Return the same with coordinates multiplied.

        Densities and strengths are in SI units in every file.

        Parameters
        ----------
        metres : float
            Metres in one unit of the coordinates.

        Returns
        -------
        Parts
            In metres.
        """
        if metres == 1.0:
            return self
        spacing = [metres * step for step in self.spacing]
        return replace(self._mapped(metres * np.eye(3), self.options), spacing=spacing)

    def turned(self, up: str | None) -> Parts:
        """Return the same with an axis of the file turned upwards; gravity and ties turn with the blocks.

        Parameters
        ----------
        up : str or None
            The axis of the file that points up, one of `UP`; None for the one that does so by the file's format.

        Returns
        -------
        Parts
            With z up.

        Raises
        ------
        InputError
            For another axis, or a gravity that is no vector.
        """
        if up in (None, self.up):
            return self
        turn = _turn(up, self.up)
        options = dict(self.options)
        if options.get("gravity") is not None:
            options["gravity"] = turn @ check_gravity(options["gravity"])
        return self._mapped(turn, options)

    def _mapped(self, matrix: Floats, options: dict[str, Any]) -> Parts:
        """The same with every point multiplied by a matrix."""
        blocks = [replace(b, vertices=_times(b.vertices, matrix)) for b in self.blocks]
        if ties := options.get("ties"):
            options = {**options, "ties": _moved(ties, matrix)}
        return replace(self, blocks=blocks, options=options)


def in_frame(assembly: Assembly, units: str | None, up: str | None, own: str) -> Assembly:
    """Return an assembly in the coordinates of a file, so that a reader with the same options gets it back.

    Parameters
    ----------
    assembly : Assembly
        In metres, z up.
    units : str or None
        Of the coordinates in the file; None for metres.
    up : str or None
        The axis of the file that points up; None for the one that does so by its format.
    own : str
        That one: "z", or "y" in GLB. The writer of GLB turns z to y by itself.

    Returns
    -------
    Assembly
        With blocks, ties and gravity in those coordinates; all else is in SI units.

    Raises
    ------
    InputError
        For a unit or an axis that is not known.
    """
    metres = metres_in(units)
    turn = np.eye(3) if up in (None, own) else _turn(up, own).T
    if metres == 1.0 and np.array_equal(turn, np.eye(3)):
        return assembly
    matrix = turn / metres
    vertices, gravity = assembly.vertices @ matrix.T, turn @ assembly.gravity
    return assembly.with_(vertices=vertices, gravity=gravity, ties=_moved(assembly.ties, matrix))


def _turn(up: str, own: str) -> Floats:
    """Rotation that turns an axis of a file upwards, from what its format makes of the file."""
    if up not in UP:
        raise InputError(f"up is {up!r}; the axis that points up must be one of: {', '.join(UP)}")
    third = np.eye(3)["xyz".index(up[-1])] * (-1.0 if up.startswith("-") else 1.0)
    first = np.eye(3)[1 if up[-1] == "x" else 0]
    return np.array([first, np.cross(third, first), third]) @ as_written(own)


def _moved(ties: Iterable[Tie], matrix: Floats) -> list[Tie]:
    """Ties with their points multiplied by a matrix."""
    return [replace(t, points=tuple(map(tuple, (np.array(t.points) @ matrix.T).tolist()))) for t in ties]


#: No block ever laid is longer [m]: the largest stones of Baalbek have 20 m.
LONGEST = 25.0
#: No masonry weighs more [N]: the pyramid of Khufu has 6e9 kg.
HEAVIEST = 6e10
IN_METRES = "a scene is in metres: write its lengths so"
LIGHT = 1000.0  #: no earth, rubble or fluid that presses on masonry weighs less [N/m3]
#: Gravity is 1 in models without units, 1.6 on the Moon, 9.8 here and some 500 in a centrifuge at 50 times that [m/s2].
GRAVITIES = (1.0, 500.0)
DENSITIES = (200.0, 20e3)  #: of any building material, from cork to lead twice over [kg/m3]


def as_written(up: str) -> Floats:
    """Return the rotation from coordinates with z up to those of a file.

    Parameters
    ----------
    up : str
        The axis of the file that points up by its format: "z", or "y" in GLB.

    Returns
    -------
    array of float, shape (3, 3)
        Multiplies a column of coordinates.
    """
    return np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) if up == "y" else np.eye(3)


def doubts(assembly: Assembly, *, up: str = "z", scene: bool = False) -> list[str]:
    """Return what looks like numbers in other units or coordinates with another axis up, and what to type instead.

    Parameters
    ----------
    assembly : Assembly
        As it was read.
    up : str, optional
        The axis of the file that points up by its format: "z", or "y" in GLB.
    scene : bool, optional
        Whether it is of a scene, which is in metres with z up, so that there is nothing to type.

    Returns
    -------
    list of str
        A sentence each; none where all is plausible.
    """
    free = assembly.free
    if not len(free):
        return _odd_numbers(assembly)
    corners = assembly.vertices
    first = assembly.vertex_start[:-1]
    size = (np.maximum.reduceat(corners, first) - np.minimum.reduceat(corners, first))[free].max(axis=1)
    found = []
    if size.max() > LONGEST:
        found.append(
            f'block "{assembly.names[free[size.argmax()]]}" is {size.max():,.4g} m long, longer than any stone laid; '
            + (IN_METRES if scene else "if the coordinates are not in metres, give --units mm, cm, in or ft")
        )
    elif size.max() < 1e-3:
        found.append(
            f"no block is longer than {size.max():.2g} m; "
            + (IN_METRES if scene else "if the file is in larger units than was said, give --units m")
        )
    if assembly.free_weight > HEAVIEST and not found:
        found.append(
            f"the blocks weigh {assembly.free_weight / 1e3:.2g} kN, more than the largest pyramid; "
            + (IN_METRES if scene else "see --units")
        )
    low, high = assembly.density[free].min(), assembly.density[free].max()
    if (low < DENSITIES[0] or high > DENSITIES[1]) and not low == high == 1.0:  # 1 stands for no density at all
        given = f"the density is {low:g}" if low == high else f"densities go from {low:g} to {high:g}"
        found.append(f"{given} kg/m3; that of a file is in kg/m3")
    return found + odd_gravity(assembly) + _odd_numbers(assembly) + ([] if scene else _sideways(assembly, up))


def odd_gravity(assembly: Assembly) -> list[str]:
    """Return what looks wrong about gravity.

    Parameters
    ----------
    assembly : Assembly
        The blocks, z up.

    Returns
    -------
    list of str
        A sentence each, where it does not pull down or is in other units than m/s2.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], gravity=(0, 0, 9.81))
    >>> odd_gravity(cube)
    ['gravity points up; down is -z, as in 0,0,-9.81']
    >>> odd_gravity(cube.with_(gravity=(0, 0, -9810)))
    ['gravity is 9,810 m/s2; it is in m/s2, and 9.81 on Earth']
    """
    size, down = float(np.linalg.norm(assembly.gravity)), -float(assembly.gravity[2])
    found = []
    if down <= 0:
        found.append(f"gravity points {'up' if down < 0 else 'sideways'}; down is -z, as in 0,0,-9.81")
    if not GRAVITIES[0] <= size <= GRAVITIES[1]:
        found.append(f"gravity is {size:,.4g} m/s2; it is in m/s2, and 9.81 on Earth")
    return found


def _odd_numbers(assembly: Assembly) -> list[str]:
    """Doubt friction of joint laws that may be an angle, and weights of fill and fluids that may be in kN/m3."""
    told = [
        rough(f'friction between "{law.between[0]}" and "{law.between[1]}"', law.friction)
        for law in assembly.joints
        if law.friction is not None
    ]
    found = [text for text in told if text is not None]
    loads = assembly.metadata.get("loads")
    for name, table in loads.items() if isinstance(loads, dict) else ():
        weight = table.get("unit_weight") if isinstance(table, dict) else None
        if isinstance(weight, (int, float)) and 0 < weight < LIGHT:
            found.append(f"loads.{name}.unit_weight is {weight:g} N/m3; if it is in kN/m3, give {1e3 * weight:g}")
    return found


def _sideways(assembly: Assembly, up: str) -> list[str]:
    """Doubt where all that is free is beside its supports along the axis that is up, and beyond them along another."""
    lower, upper = assembly.vertices.min(axis=0), assembly.vertices.max(axis=0)
    reach = np.where(upper > lower, upper - lower, 1.0)
    held, free = assembly.centroid[assembly.support], assembly.centroid[assembly.free]
    if not len(held):
        return []
    mass = (assembly.density * assembly.volume)[assembly.free]
    above = (mass @ free / mass.sum() - held.mean(axis=0)) / reach
    beyond = (free.min(axis=0) >= held.max(axis=0)) & (above > 0.25)
    before = (free.max(axis=0) <= held.min(axis=0)) & (above < -0.25)
    gap = beyond | before
    if abs(up_of(assembly)[2]) < 0.999 or abs(above[2]) > 0.1 or not gap[:2].any():
        return []
    most = int(np.argmax(np.where(gap[:2], np.abs(above[:2]), -np.inf)))
    written = as_written(up)[:, most] * np.sign(above[most])
    axis = ("-" if written.sum() < 0 else "") + "xyz"[int(np.argmax(np.abs(written)))]
    return [
        f"the blocks are beside their supports, along {axis}, and not above them; if {axis} is up, give --up {axis}"
    ]


def metres_in(units: str | None) -> float:
    """Return the metres in a unit of length.

    Parameters
    ----------
    units : str or None
        One of `UNITS`; None for metres.

    Returns
    -------
    float

    Raises
    ------
    InputError
        For a unit that is not known.

    Examples
    --------
    >>> metres_in("cm")
    0.01
    """
    if units is None:
        return 1.0
    if units not in UNITS:
        raise InputError(f"units are {units!r}; known are: {', '.join(UNITS)}")
    return UNITS[units]


def rounding_of(corners: Floats) -> float:
    """Return how far single precision may have moved one of some corners out of the plane of others.

    Parameters
    ----------
    corners : array of float, shape (n, 3)
        Corners as a file has them [m].

    Returns
    -------
    float
        Distance [m]; zero where not all of the corners are in single precision.
    """
    if (corners != corners.astype(np.float32)).any():
        return 0.0
    return float(2 * np.finfo(np.float32).eps * np.abs(corners).max(initial=0.0))


def spacings(path: Path, corners: Sequence[Any]) -> list[float]:
    """Return how far apart numbers of single precision are at the largest coordinate of each block of a file.

    Parameters
    ----------
    path : Path
        A mesh file that was read.
    corners : sequence of array of float
        Of each block, in the unit of the file.

    Returns
    -------
    list of float
        In the unit of the file; zeros where it holds text or numbers of double precision. Of a GLB, whose objects are
        moved after they are rounded, only the spacing of the places that they are moved to, where these are rounded
        and differ: one place alone moves all blocks as one.
    """
    suffix = path.suffix.lower()
    if suffix == ".glb":
        rounded = [max(map(abs, place)) for place in glb.places(path) if all(x == np.float32(x) for x in place)]
        return [spacing(np.array(sorted(rounded)[-2])) if len(rounded) > 1 else 0.0] * len(corners)
    single = stl.is_binary(path) if suffix == ".stl" else suffix == ".ply" and ply.is_single(path)
    return [spacing(np.asarray(own, dtype=float)) if single else 0.0 for own in corners]


def moved_far_away(corners: Floats) -> float:
    """Return how far single precision will move corners that are far from the origin.

    Parameters
    ----------
    corners : array of float, shape (n, 3)
        All corners of an assembly [m].

    Returns
    -------
    float
        The furthest that a coordinate moves [m]; zero where that is no more than `NEAR` of their extent.
    """
    moved = float(np.abs(corners - corners.astype(np.float32)).max())
    return moved if moved > NEAR * float(np.ptp(corners, axis=0).max()) else 0.0


def chosen_supports(
    marked: Sequence[int], given: Iterable[int | str] | None, names: Sequence[str], kind: str
) -> list[int | str]:
    """Return supports as they were given, or else those that the file marks.

    Parameters
    ----------
    marked : sequence of int
        Numbers of the blocks that the file marks.
    given : iterable of int or str, or None
        Names or numbers of blocks, or one of them; an empty list stands for none at all.
    names : sequence of str
        Of all blocks, for the message.
    kind : str
        What the file is called in the message.

    Returns
    -------
    list of int or str

    Raises
    ------
    NoSupportError
        Naming some blocks when there are no supports.
    """
    chosen: list[int | str] = [given] if isinstance(given, (int, str)) else list(marked if given is None else given)
    if not chosen and given is None:
        some = listed([name or f"block{i}" for i, name in enumerate(numbered(names))], 8)
        raise NoSupportError(
            f'{kind} does not say which blocks are supports; give their names or numbers, or "{LOWEST}" for those that '
            f"reach down to the lowest corner (blocks: {some})"
        )
    return chosen


def is_marked(label: str, key: str, value: Any) -> bool:
    """Return whether a file marks a block as a support.

    Parameters
    ----------
    label : str
        The name of the block.
    key : str
        What the mark is called in the file.
    value : object
        The mark, None for none.

    Returns
    -------
    bool

    Raises
    ------
    InputError
        For anything but a truth value, 0 or 1: the text "false" is no mark.

    Examples
    --------
    >>> is_marked("brick", "support", 1), is_marked("brick", "support", None)
    (True, False)
    """
    if value is None:
        return False
    if not isinstance(value, (bool, int, float, np.bool_, np.number)) or value not in (0, 1):
        raise InputError(f'block "{label}": {key} is {value!r}; it must be true, false, 0 or 1')
    return bool(value)


def _times(vertices: Any, matrix: Floats) -> Any:
    try:
        return np.asarray(vertices, dtype=float) @ matrix.T
    except (TypeError, ValueError):
        return vertices  # not numbers: refused, with the block's name, where the assembly is made
