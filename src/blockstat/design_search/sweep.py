"""Many designs of one scene: grids, Latin hypercubes and lists, in parallel, into one file that can be resumed.

Rows go out to processes in batches and are appended by this process alone as batches come back, so a worker that dies
takes no row with it: what has no row in the file is computed again, and nothing has two.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from itertools import chain, islice, product
from math import inf, isfinite, nan, prod
from pathlib import Path
from time import process_time
from types import FunctionType, MethodType
from typing import Any, overload

import msgspec
import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.design_search.candidate import ERROR, failures
from blockstat.design_search.history import digest
from blockstat.design_search.space import check_scene, chosen_ranges
from blockstat.errors import InputError, check_count, check_seed, known_options, no_such
from blockstat.result import Result, Sentence
from blockstat.spec import Scene, build, parameters, scene_from, with_values
from blockstat.spec.reading import number_at
from blockstat.system.lock import locked
from blockstat.system.rows import append_rows, kept_rows, read_rows
from blockstat.system.workers import as_they_come
from blockstat.system.writing import check_writable

Values = Mapping[str, float]
#: Evaluates a design: plain values, of which a line of the file is made.
Measure = Callable[[Scene, Memory], dict[str, Any]]

DESIGNS = "a sequence of dicts of parameter values by name, such as blockstat.grid gives"
PLAIN = "numbers, text, True, False or None, or lists and dicts of these"
#: Numbers that JSON does not have, by the words that stand for them in a row.
NOT_FINITE = {"Infinity": inf, "-Infinity": -inf, "NaN": nan}
OWN = ("blockstat", "dynsim")  #: packages whose functions are known by their names
BATCH = 16  #: designs that a process is given at a time; within a batch evidence of one design may decide the next


class SweepOutcome(Sentence):
    """The answers of `sweep`; each value is the sentence a user reads."""

    COMPLETE = "Complete: every design has a row in the file."
    FAILED = "Failed: no design could be judged; every row says why."
    RESUMED = "Resumed: every design has a row in the file, some of them from an earlier run."


@dataclass(frozen=True)
class SweepResult(Result):
    """The file of a sweep."""

    path: Path
    designs: int  #: that were asked for
    computed: int  #: in this run; the others were there
    failed: int = 0  #: rows that say "error" in place of a verdict
    reasons: str = ""  #: why, in one sentence

    @property
    def outcome(self) -> SweepOutcome:
        """Whether any design could be judged, and whether rows of an earlier run were kept."""
        if self.designs and self.failed == self.designs:
            return SweepOutcome.FAILED
        return SweepOutcome.COMPLETE if self.computed == self.designs else SweepOutcome.RESUMED

    def explain(self) -> str:
        """Return what the file holds, one fact a line.

        Returns
        -------
        str
        """
        rows = f"{self.path}: {self.designs} designs, {self.computed} computed in this run."
        return "\n".join(filter(None, (self.outcome.value, rows, self.reasons)))

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict of str to object
            The outcome and its sentence, the path, and the numbers of designs, of those computed and of those failed.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "path": str(self.path),
            "designs": self.designs,
            "computed": self.computed,
            "failed": self.failed,
        }

    def rows(self) -> list[dict[str, Any]]:
        """Read the rows of the designs that were asked for, in their order.

        Returns
        -------
        list of dict
            Number of the design, its parameters, and what was measured.

        Raises
        ------
        InputError
            For a damaged line.
        """
        return sorted(_rows_of(self.path, self.designs), key=lambda row: row["design"])


class Grid(Sequence[dict[str, float]]):
    """Every combination of the values of some parameters, each made when it is asked for.

    Parameters
    ----------
    lines : mapping of str to sequence of float
        Values of each parameter; those of the last change fastest.
    """

    def __init__(self, lines: Mapping[str, Sequence[float]]) -> None:
        self._lines = {name: tuple(values) for name, values in lines.items()}

    def __len__(self) -> int:
        return prod(len(values) for values in self._lines.values())

    def __iter__(self) -> Iterator[dict[str, float]]:
        """Go through the designs, also more than a length can count."""
        for values in product(*self._lines.values()):
            yield dict(zip(self._lines, values, strict=True))

    @overload
    def __getitem__(self, place: int) -> dict[str, float]: ...
    @overload
    def __getitem__(self, place: slice) -> list[dict[str, float]]: ...
    def __getitem__(self, place: int | slice) -> dict[str, float] | list[dict[str, float]]:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(len(self)))]
        left, design = range(len(self))[place], {}
        for name, values in reversed(self._lines.items()):
            left, own = divmod(left, len(values))
            design[name] = values[own]
        return {name: design[name] for name in self._lines}


def grid(scene: Scene, names: Sequence[str] | str | None = None) -> Grid:
    """Return every combination of the steps of a scene's ranges, or of some of them.

    Parameters
    ----------
    scene : Scene
        The scene with its ranges.
    names : str or sequence of str, optional
        The parameters to move; by default all.

    Returns
    -------
    Grid
        A sequence of designs, each a dict of parameter values. A design is made when it is asked for, so a million take
        no memory.

    Raises
    ------
    InputError
        For what is no scene, an unknown parameter, one named twice, no name at all, or a scene without any.

    Examples
    --------
    >>> from blockstat import grid, scene_from
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.6, "step": 0.4}}
    >>> list(grid(scene_from(hut)))
    [{'wall.thickness': 0.6}, {'wall.thickness': 0.2}]
    """
    return Grid({name: found.steps() for name, found in chosen_ranges(scene, names, "sweep").items()})


def latin_hypercube(
    scene: Scene, number: int, *, seed: int = 0, names: Sequence[str] | str | None = None
) -> list[dict[str, float]]:
    """Spread a number of designs evenly over each range of a scene.

    Parameters
    ----------
    scene : Scene
        The scene with its ranges. Ranges that count (whole ends and step) get whole values.
    number : int
        How many designs, at least 1.
    seed : int, optional
        The same seed gives the same designs.
    names : str or sequence of str, optional
        The parameters to move; by default all.

    Returns
    -------
    list of dict of str to float
        Parameter values of each design.

    Raises
    ------
    InputError
        For what is no scene, an unknown parameter, one named twice, no name at all, a scene without any, a number of
        designs below 1, or a seed that is no whole number.

    References
    ----------
    McKay, M. D., Beckman, R. J. & Conover, W. J. (1979). A comparison of three methods for selecting values of input
    variables. Technometrics 21(2), 239-245.

    Examples
    --------
    >>> from blockstat import latin_hypercube, scene_from
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
    >>> thin, thick = sorted(found["wall.thickness"] for found in latin_hypercube(scene_from(hut), 2))
    >>> thin < 0.5 < thick
    True
    """
    from scipy.stats import qmc

    check_count("latin_hypercube: number", number)
    check_seed(seed)
    ranges = chosen_ranges(scene, names, "sweep")
    samples = qmc.LatinHypercube(d=len(ranges), rng=seed).random(number)
    designs = []
    for sample in samples:
        design = {}
        for (name, found), share in zip(ranges.items(), sample, strict=True):
            steps = found.steps()
            whole = all(float(v).is_integer() for v in (found.min, found.max, found.step))
            place = steps[min(int(share * len(steps)), len(steps) - 1)]
            design[name] = place if whole else float(found.min + share * (found.max - found.min))
        designs.append(design)
    return designs


def verdict_row(scene: Scene, memory: Memory) -> dict[str, Any]:
    """Return what statics say of a design, as a row of a sweep.

    Parameters
    ----------
    scene : Scene
        The design.
    memory : Memory
        Evidence of earlier designs.

    Returns
    -------
    dict
        Verdict, score, volume of the free blocks [m3] and number of blocks.

    Raises
    ------
    InputError
        For a design that cannot be built.
    """
    assembly = build(scene)
    verdict = assess(assembly, memory=memory)
    return {
        "static": verdict.outcome.word,
        "score": verdict.score if isfinite(verdict.score) else None,
        "volume": float(assembly.volume[assembly.free].sum()),
        "blocks": assembly.n_blocks,
    }


@known_options
def sweep(
    scene: Scene,
    designs: Iterable[Values],
    path: str | Path,
    *,
    measure: Measure = verdict_row,
    jobs: int | None = None,
    batch: int = BATCH,
    progress: Callable[[int], None] | None = None,
) -> SweepResult:
    """Evaluate designs side by side and append a row of each to a file of JSON lines.

    Parameters
    ----------
    scene : Scene
        The scene with its ranges.
    designs : iterable of dict
        Parameter values of each, such as `grid` and `latin_hypercube` give. They are read as they are needed, so a
        million take no memory.
    path : str or Path
        The file. Its first line says what the file is of; rows follow as they come.
    measure : callable, optional
        Evaluates one design: a function at the top of a module, or a `functools.partial` of one. It gets the scene and
        a memory of evidence that lives for one batch, and gives numbers and text by name; the processes must be able to
        import it. Where its text has changed, the file is of another sweep; what it calls is not compared.
    jobs : int, optional
        Processes, by default as many as cores. Under `joblib.parallel_config(backend="dask")`, or another backend,
        batches go there instead.
    batch : int, optional
        Designs that a process is given at a time.
    progress : callable, optional
        Called with the number of rows.

    Returns
    -------
    SweepResult

    Raises
    ------
    InputError
        For what is no scene, a file of another sweep, or of other designs, one that cannot be written, a measure
        without a name or inside another function, one that gives no dict of plain values or a key that rows have
        already, a design with an unknown parameter or a value that is no number, for no designs at all, and for `jobs`
        or `batch` below 1. No file is left without a row.
    RuntimeError
        Where `measure` raises anything but an InputError, which makes a row; it names the design, and its cause is
        what was raised.

    Notes
    -----
    Each row has the number of its `design`, its parameters and what `measure` says. A sweep that was killed goes on
    where it stopped when called again; a line cut short is dropped. JSON has no word for numbers that are not finite:
    a line says "Infinity", "-Infinity" or "NaN", of which `SweepResult.rows` makes numbers again.

    Examples
    --------
    >>> from blockstat import grid, scene_from, sweep
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.6, "step": 0.4}}
    >>> scene = scene_from(hut)
    >>> [row["static"] for row in sweep(scene, grid(scene), "hut.jsonl", jobs=1).rows()]
    ['stable', 'stable']
    """
    path = Path(path)
    check_count("batch", batch)
    if jobs is not None:
        check_count("jobs", jobs)
    check_writable(path)
    with locked(path.parent, name=f".{path.name}-lock"):
        return _swept(scene, designs, path, measure, jobs, batch, progress)


def _swept(
    scene: Scene,
    designs: Iterable[Values],
    path: Path,
    measure: Measure,
    jobs: int | None,
    batch: int,
    progress: Callable[[int], None] | None,
) -> SweepResult:
    """Append the rows that are missing to the file."""
    check_scene(scene)
    head = {"scene": scene.name, "digest": digest(scene, _name_of(measure))}
    names = parameters(scene)
    numbered = _numbered(designs, names)
    if (first := next(numbered, None)) is None:
        raise InputError("there are no designs to sweep; an iterator that was gone through before has none left")
    done = _opened(path, head, list(names))
    data = msgspec.to_builtins(scene)
    counted = 0

    def missing() -> Iterator[tuple[int, dict[str, float]]]:
        nonlocal counted
        for number, values in chain([first], numbered):
            counted = number + 1
            if number not in done:
                yield number, values
            elif done[number] != _mark(values):
                raise InputError(f"{path}: row {number} is of another design; move the file away or choose another")

    computed = 0
    tasks = ((data, part, measure) for part in _batched(missing(), batch))
    finished = as_they_come(_evaluated, tasks, -1 if jobs is None else jobs)
    try:
        with path.open("a") as file:
            for rows in finished:
                append_rows(file, rows)
                computed += len(rows)
                if progress is not None:
                    progress(len(done) + computed)
    except (InputError, RuntimeError):
        if not done and not computed:
            path.unlink(missing_ok=True)  # else another measure would be refused because of no row at all
        raise
    rows = _rows_of(path, counted)
    return SweepResult(path, counted, computed, sum(row.get("static") == ERROR for row in rows), failures(rows))


def _numbered(designs: Any, names: Collection[str]) -> Iterator[tuple[int, dict[str, float]]]:
    """Designs in plain numbers, each with its own, from 0 on."""
    if isinstance(designs, Mapping) or not isinstance(designs, Iterable):
        raise InputError(f"designs is {designs!r}; it must be {DESIGNS}")
    for number, values in enumerate(designs):
        if not isinstance(values, Mapping):
            raise InputError(f"design {number} is {values!r}; designs must be {DESIGNS}")
        for name in values:
            if name not in names:
                raise no_such("parameter", name, names)
        yield number, {name: number_at(name, value) for name, value in values.items()}


def _rows_of(path: Path, designs: int) -> list[dict[str, Any]]:
    """Rows of the first designs; a file may have more, of an earlier call with more of them."""
    return [_numbers_in(row) for row in read_rows(path, dict)[1] if row["design"] < designs]


def _evaluated(task: tuple[dict[str, Any], list[tuple[int, dict[str, float]]], Measure]) -> list[dict[str, Any]]:
    """Rows of a batch of a scene, by a measure, in a process of its own."""
    data, part, measure = task
    scene, memory, rows = scene_from(data), Memory(), []
    taken = {"design", "seconds", *parameters(scene)}
    for number, values in part:
        begin = process_time()
        try:
            row = measure(with_values(scene, values), memory)
        except InputError as error:
            row = {"static": ERROR, "note": error.line}
        except MemoryError:  # of the machine, not of the design
            raise
        except Exception as error:
            said = ", ".join(f"{name} {value:.15g}" for name, value in values.items())
            raise RuntimeError(f"measure raised {type(error).__name__} at design {number} ({said}): {error}") from error
        rows.append({"design": number, **values, **_plain(row, taken), "seconds": process_time() - begin})
    return rows


def _plain(row: Any, taken: set[str]) -> dict[str, Any]:
    """What a measure gave, as a line of the file can hold it."""
    if not isinstance(row, Mapping):
        raise InputError(f"measure gave {row!r}; it must give a dict of values by name")
    for key in taken.intersection(row):
        raise InputError(
            f'measure gave the key "{key}", which a row has already: "design" is its number, "seconds" its time, and '
            "parameters have their paths; name it otherwise"
        )
    try:
        return json.loads(json.dumps(dict(row), default=_from_numpy), parse_constant=str)
    except (TypeError, ValueError):
        raise InputError(f"measure gave {row!r}; values must be {PLAIN}") from None


def _numbers_in(value: Any) -> Any:
    """What a line says, with numbers in place of the words for those that are not finite."""
    if isinstance(value, dict):
        return {key: _numbers_in(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_numbers_in(part) for part in value]
    return NOT_FINITE.get(value, value) if isinstance(value, str) else value


def _from_numpy(value: Any) -> Any:
    """A number or an array of numpy in plain values."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError


def _batched(items: Iterator[Any], size: int) -> Iterator[list[Any]]:
    while part := list(islice(items, size)):
        yield part


def _name_of(measure: Callable[..., Any]) -> str:
    """What tells a measure from others in every process: its name, what is bound to it, and its text."""
    if isinstance(measure, partial):
        bound = [*measure.args, *chain.from_iterable(sorted(measure.keywords.items()))]
        return " ".join([_name_of(measure.func), *map(_mark_of, bound)])
    name = getattr(measure, "__qualname__", None)
    if name is None:
        raise InputError(
            f"measure is {measure!r}, which has no name for the head of the file; it must be a function or a "
            "functools.partial of one"
        )
    if "<" in name:  # as in "<lambda>" and "outer.<locals>.inner"
        raise InputError(
            f'measure is "{name}"; a lambda or a function inside another has no name that tells the rows of its file '
            "from others; define a function with a name at the top of a module, and bind what it needs by "
            "functools.partial"
        )
    text = _source_of(measure) + (_mark_of(measure.__self__) if isinstance(measure, MethodType) else "")
    return f"{measure.__module__}.{name} {sha256(text.encode()).hexdigest() if text else ''}".rstrip()


def _mark_of(value: Any) -> str:
    """What tells a value that is bound to a measure from others."""
    from joblib import hash as hash_of

    if isinstance(value, (FunctionType, MethodType, partial)):
        return _name_of(value)
    try:
        return str(hash_of(value))
    except Exception:  # of many kinds, as values please
        raise InputError(f"measure has {value!r} bound to it, which cannot be sent to processes") from None


def _source_of(function: Callable[..., Any]) -> str:
    """The text of a function of one's own; those of this package are known by their names."""
    if function.__module__.split(".")[0] in OWN:
        return ""
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):  # typed at a prompt, or not written in Python
        return ""


def _mark(values: Values) -> int:
    """Tells the values of designs apart in little memory."""
    return hash(tuple(sorted((name, float(value)) for name, value in values.items())))


def _opened(path: Path, head: dict[str, Any], names: list[str]) -> dict[int, int]:
    """Marks of the designs that have a row."""
    rows = kept_rows(path, head, dict, other="rows of another sweep")
    return {row["design"]: _mark({name: row[name] for name in names if name in row}) for row in rows}
