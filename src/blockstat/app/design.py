"""What is open on the page and what is asked of it: plain data, no viser.

This is the one place that knows how a scene is loaded, moved and built.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from math import floor, log10
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.verdict import Verdict
from blockstat.assembly import Assembly
from blockstat.contact.tolerance import GAP, read_gap
from blockstat.errors import InputError, InputWarning, NoSupportError
from blockstat.spec import Range, parameters, with_values

#: Directions of the limit load, as accelerations in units of gravity.
PUSHES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0)}
#: When a mechanism is shown to and fro: of a design that falls (not while arrows are shown), of any, or of none.
FALLING, ALWAYS, NEVER = "what falls", "always", "never"
LEAST = "least"  #: the weakest of `PUSHES`
FRICTION, DENSITY, EDGES = "friction", "density", "rounded_edges"
#: Greatest loss of joints at each edge that the page offers, and its step [mm].
ROUND, ROUND_STEP = 20.0, 0.5
NO_SCENE = '"{}" was read as blocks and has no scene; open a .toml scene for that'
SUFFIXES = (".toml", ".json", ".obj", ".glb")


@dataclass(frozen=True, eq=False)
class Model:
    """A scene with parameters, or an assembly without any of its own.

    Attributes
    ----------
    name : str
        Name of the scene or the assembly.
    scene : Building, Composition or None
        The scene; None for an assembly.
    assembly : Assembly or None
        The assembly; None for a scene.
    ranges : dict of str to Range
        Parameters that may move, by dotted path, with "friction", "density" and "rounded_edges" where the page adds
        them.
    gap : float or str
        Largest gap of a joint, as in `blockstat.assess`.
    """

    name: str
    scene: Any  #: what `load_scene` returned, None for an assembly
    assembly: Assembly | None
    ranges: dict[str, Range]  #: parameters that may move, by dotted path
    gap: float | str = GAP  #: largest gap of a joint, as in `blockstat.assess`

    @property
    def start(self) -> dict[str, float]:
        """The values that the file gives, by dotted path."""
        return {path: found.value for path, found in self.ranges.items()}

    @property
    def idle(self) -> str:
        """That the load cases of the file do not act on the page, in words; empty where it has none."""
        if self.assembly is not None:
            return idle_loads(self.assembly)
        return _idle_words(list(self.scene.loads), list(self.scene.cases))

    @property
    def own_ranges(self) -> dict[str, Range]:
        """The ranges that the scene itself has, which a search may move.

        Returns
        -------
        dict of str to Range
            By dotted path.

        Raises
        ------
        InputError
            For an assembly, which has no scene.
        """
        if self.scene is None:
            raise InputError(NO_SCENE.format(self.name))
        return parameters(self.scene)

    def with_material(self, assembly: Assembly, values: dict[str, float]) -> Assembly:
        """Return an assembly with the friction and the density of the page, where they differ from the file's.

        Parameters
        ----------
        assembly : Assembly
            Blocks of the model.
        values : dict of str to float
            Values by dotted path. Only "friction" [-] and "density" [kg/m3] count. The density is set only where all
            blocks have the same one.

        Returns
        -------
        Assembly
            The same blocks.

        Raises
        ------
        InputError
            For a negative coefficient of friction.
        """
        moved, changes = self.moved_material(values), dict[str, Any]()
        if FRICTION in moved:
            changes[FRICTION] = moved[FRICTION]
        if DENSITY in moved and len(np.unique(assembly.density)) == 1:
            changes[DENSITY] = np.full(assembly.n_blocks, moved[DENSITY])
        return assembly.with_(**changes) if changes else assembly

    def moved_material(self, values: dict[str, float]) -> dict[str, float]:
        """Return the friction and the density of the page, where they differ from the file's.

        Parameters
        ----------
        values : dict of str to float
            Values by dotted path.

        Returns
        -------
        dict of str to float
            By "friction" [-] and "density" [kg/m3]; empty where neither was moved.
        """
        start, own = self.start, [name for name in (FRICTION, DENSITY) if name in values]
        return {name: values[name] for name in own if values[name] != start.get(name)}

    def built(self, values: dict[str, float]) -> Assembly:
        """Return the blocks for some values of the parameters.

        Parameters
        ----------
        values : dict of str to float
            Values by dotted path.

        Returns
        -------
        Assembly
            The blocks, with the page's friction and density.

        Raises
        ------
        InputError
            For values from which nothing can be built.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            if self.assembly is not None:
                return self.with_material(self.assembly, values)
            from blockstat.spec import build

            return self.with_material(build(self.moved(values)), values)

    def moved(self, values: dict[str, float]) -> Any:
        """Return the scene with its parameters and its material at some values, as it is saved and searched.

        Parameters
        ----------
        values : dict of str to float
            Values by dotted path. Those that the scene does not have are ignored, but "friction" and "density" that
            differ from the file's are put into its material.

        Returns
        -------
        Building or Composition
            The scene with the same ranges.

        Raises
        ------
        InputError
            For an assembly, which has no scene, and for a value outside its range.
        """
        own = self.own_ranges
        scene: Any = with_values(self.scene, {path: value for path, value in values.items() if path in own})
        changes = self.moved_material(values)
        if not changes:
            return scene
        is_table = isinstance(scene.material, dict)
        material = scene.material | changes if is_table else msgspec.structs.replace(scene.material, **changes)
        return msgspec.structs.replace(scene, material=material)


def idle_loads(assembly: Assembly) -> str:
    """Return that the load cases of an assembly do not act on the page.

    Parameters
    ----------
    assembly : Assembly
        Blocks with the loads and the cases of their scene in `metadata`.

    Returns
    -------
    str
        Sentences in plain text; empty for an assembly without loads.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from blockstat.app.design import idle_loads
    >>> idle_loads(Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], metadata={"cases": {"storm": {}}}))
    'No load case acts on this page, only the weight: storm. blockstat check FILE --case NAME judges under one.'
    """
    return _idle_words(*(list(assembly.metadata.get(key, ())) for key in ("loads", "cases")))


def _idle_words(loads: list[str], cases: list[str]) -> str:
    if cases:
        words = f"No load case acts on this page, only the weight: {', '.join(cases)}."
        return f"{words} blockstat check FILE --case NAME judges under one."
    return f"No load acts on this page, only the weight: {', '.join(loads)}." if loads else ""


def open_model(
    path: str | Path,
    *,
    supports: str = "",
    units: str | None = None,
    up: str | None = None,
    gap: str | None = None,
    folder: Path | None = None,
) -> Model:
    """Open a scene (.toml) or an assembly (.json, .obj, .glb).

    A scene that cannot be built is opened all the same; the page then says why it cannot be built.

    Parameters
    ----------
    path : str or Path
        The file.
    supports : str, optional
        Names of blocks that cannot move, separated by commas. A mesh needs them; a scene takes none.
    units, up : str, optional
        Of the coordinates in the file, as in `blockstat.read`; a scene is in metres, z up.
    gap : str, optional
        Largest gap of a joint, as a user types it: a share of the block size, or a length such as "2 mm".
    folder : Path, optional
        Where the files are that a scene may name, and nowhere else; without it they are beside the scene or anywhere.

    Returns
    -------
    Model
        What the page shows.

    Raises
    ------
    InputError
        For a file that cannot be used, naming the file and what is wrong in it.
    """
    path, near = Path(path), read_gap(gap)
    named = [name.strip() for name in supports.split(",") if name.strip()] or None
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path.name}: the page opens {', '.join(SUFFIXES)}")
    if path.suffix.lower() == ".toml":
        from blockstat.spec import load_scene
        from blockstat.spec.files import check_scene_options

        check_scene_options(path, supports=named, units=units, up=up)
        scene = load_scene(path, folder=folder)
        ranges = parameters(scene)
        model = Model(scene.name, scene, None, ranges, near)
        try:
            return replace(model, ranges=ranges | _material(model.built(model.start), ranges))
        except InputError:
            return model  # the page will say why it cannot be built
    from blockstat.spec import read

    assembly = read(path, supports=named, units=units, up=up)
    if not assembly.support.any():
        some = ", ".join(assembly.names[:6])
        raise NoSupportError(
            f"{path.name}: no block is a support; give names of blocks that cannot move (blocks: {some})"
        )
    return Model(assembly.name, None, assembly, _material(assembly, {}), near)


def _material(assembly: Assembly, ranges: dict[str, Range]) -> dict[str, Range]:
    """Ranges of the intrinsic parameters that the scene does not move itself, and of what joints lose at their edges.

    Of density only if there is one.
    """
    found: dict[str, Range] = {}
    friction = assembly.friction
    if np.isfinite(friction) and f"material.{FRICTION}" not in ranges:
        found[FRICTION] = _range(friction, 0.0, max(1.2, friction), 0.01)
    density = np.unique(assembly.density)
    if len(density) == 1 and f"material.{DENSITY}" not in ranges:
        value = float(density[0])
        found[DENSITY] = _range(value, min(500.0, value), max(4000.0, value), 1.0)
    found[EDGES] = Range(0.0, 0.0, ROUND, ROUND_STEP)
    return found


def _range(value: float, low: float, high: float, step: float) -> Range:
    """A range in steps of a power of ten where it is too wide for the usual step."""
    return Range(value, low, high, max(step, 10.0 ** floor(log10((high - low) / 1000))))


@dataclass(frozen=True, eq=False)
class Question:
    """A design to be evaluated.

    Attributes
    ----------
    number : int
        Number of the question; the larger number is the newer one.
    model : Model
        The scene or the assembly.
    values : dict of str to float
        Values of its parameters, by dotted path.
    """

    number: int
    model: Model = field(repr=False)
    values: dict[str, float]


@dataclass(frozen=True)
class Began:
    """The evaluator took up a question.

    Attributes
    ----------
    number : int
        Number of the question.
    """

    number: int


@dataclass(frozen=True, eq=False)
class Judged:
    """The static verdict on a question.

    Attributes
    ----------
    number : int
        Number of the question.
    verdict : Verdict
        The static verdict.
    seconds : dict of str to float
        Process time of each step of the evaluation [s].
    """

    number: int
    verdict: Verdict
    seconds: dict[str, float]  #: process time of each step of the judge


@dataclass(frozen=True, eq=False)
class Scored:
    """The verdict with the score that an earlier mechanism left open.

    Attributes
    ----------
    number : int
        Number of the question.
    verdict : Verdict
        The static verdict with its score.
    """

    number: int
    verdict: Verdict


@dataclass(frozen=True)
class Failed:
    """A question without an answer, and why.

    Attributes
    ----------
    number : int
        Number of the question.
    message : str
        Why there is no answer.
    is_internal : bool
        True when the fault is in the program.
    """

    number: int
    message: str
    is_internal: bool = False


@dataclass(frozen=True, eq=False)
class Pushed:
    """The limit load of a question in one direction.

    Attributes
    ----------
    number : int
        Number of the question.
    push : str
        The direction, a key of `PUSHES`.
    limit : LimitLoad or None
        The bracket on the multiplier; None when there is none.
    reason : str
        Why there is no limit load.
    seconds : float
        Process time of the limit analysis [s].
    """

    number: int
    push: str
    limit: LimitLoad | None
    reason: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Slipped:
    """The least friction with which a question's design stands.

    Attributes
    ----------
    number : int
        Number of the question.
    least : float
        Coefficient of friction [-]; nan when none was found.
    seconds : float
        Process time of the bisection [s].
    reason : str
        Why it is not known; empty where it is, and where no friction is enough.
    """

    number: int
    least: float
    seconds: float
    reason: str = ""


@dataclass(frozen=True)
class Stopped:
    """The slower results of a question that were not told yet will not come.

    Attributes
    ----------
    number : int
        Number of the question.
    message : str
        Why.
    """

    number: int
    message: str
