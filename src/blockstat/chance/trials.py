"""Random draws and their verdicts: in batches, on several processes, kept in a file from which a later run goes on."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from blockstat.analysis.assess import judged
from blockstat.analysis.problem import Problem, checked_loads, pose
from blockstat.analysis.verdict import Outcome
from blockstat.chance.evidence import Known, NearbyEvidence
from blockstat.chance.population import Population
from blockstat.contact.interfaces import GAP
from blockstat.contact.overlap.penetration import overlaps
from blockstat.contact.unresolved import Unresolved, unresolved_contacts
from blockstat.errors import InputError
from blockstat.loads import as_load, weighted
from blockstat.system.lock import locked
from blockstat.system.rows import append_rows, kept_rows
from blockstat.system.workers import as_they_come, count_workers
from blockstat.typing import Floats, Ints

#: Draws that a process is given at a time.
BATCH = 20
#: About which multiple of the design point draws are made in turn: the mean, the point, its mirror image, the point.
TURNS = np.array([0, 1, -1, 1])
Progress = Callable[[int, int], None]


#: Random numbers that are drawn at once: 0.8 GB.
MOST_NUMBERS = 100_000_000


@dataclass(frozen=True)
class Row:
    """What became of one draw."""

    draw: int
    outcome: str
    evidence: str  #: "earlier forces", "earlier mechanism" or "solved"
    seconds: float  #: process time
    #: what was drawn, by key; the least, the mean and the greatest where a variable has several values
    values: dict[str, float | list[float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Trials:
    """Draws of a population under a load."""

    population: Population
    load: Any  #: as in `blockstat.limit_load`; None for none
    centre: Floats  #: in turn with the mean what standard normal variables are drawn about, shape (size,)
    seed: int
    reuse: bool  #: whether evidence of earlier draws is tried
    flow: str = "associated"  #: or "coulomb", as in `blockstat.assess`

    def normals(self, draws: int) -> Floats:
        """Return the standard normal variables of the first draws, shape (draws, size).

        Parameters
        ----------
        draws
            How many.

        Returns
        -------
        Floats
            The same however many follow.
        """
        drawn = np.random.default_rng(self.seed).standard_normal((draws, self.population.size))
        return drawn + self.turns(draws)[:, None] * self.centre

    def turns(self, draws: int) -> Ints:
        """Return about which multiple of the centre each draw is made, shape (draws,).

        Parameters
        ----------
        draws
            How many.

        Returns
        -------
        Ints
            Each 0, 1 or -1.
        """
        return np.resize(TURNS, draws)

    def weights(self, draws: int) -> Floats:
        """Return the weights of draws about a centre, its mirror image and the mean: the balance heuristic.

        Parameters
        ----------
        draws
            How many.

        Returns
        -------
        Floats
            Density of the variables over that of the mixture, shape (draws,); at most draws over those about the mean.

        References
        ----------
        Hesterberg: Weighted average importance sampling and defensive mixture distributions, 1995. Veach & Guibas:
        Optimally combining sampling techniques for Monte Carlo rendering, 1995.
        """
        along, turns = self.normals(draws) @ self.centre, self.turns(draws)
        offset = 0.5 * float(self.centre @ self.centre)
        parts = [np.mean(turns == turn) * np.exp(turn * along - turn**2 * offset) for turn in (0, 1, -1)]
        return 1.0 / np.sum(parts, axis=0)

    @cached_property
    def _overlapping(self) -> Ints:
        """Pairs of blocks that overlap as drawn."""
        return overlaps(self.population.assembly, gap=self.population.gap)[0]

    @cached_property
    def _unresolved(self) -> Unresolved:
        """Contacts without a unique normal as drawn: what touches so in no draw touches otherwise."""
        own = self.population
        return unresolved_contacts(own.assembly, own.interfaces, gap=own.gap)

    def judge(self, number: int, normal: Floats, evidence: NearbyEvidence | None) -> Row:
        """Give the verdict on one draw.

        Parameters
        ----------
        number
            Of the draw.
        normal
            Its standard normal variables, shape (size,).
        evidence
            Of earlier draws; None to solve for every verdict.

        Returns
        -------
        Row
            Its outcome and where it comes from.
        """
        start = process_time()
        draw = self.population.realise(normal)
        acting = None if draw.loads is None else checked_loads(draw.assembly, draw.loads)
        if self.load is not None:
            push = draw.push * as_load(draw.assembly, self.load)
            acting = push if acting is None else acting + push
        options: dict[str, Any] = {"friction": None, "gravity": None, "gap": self.population.gap}
        problem = pose(draw.assembly, loads=acting, interfaces=draw.interfaces, **options)
        if evidence is not None:
            evidence.place = normal
        options = {"loads": acting, "memory": evidence, "score": False, "reserve": False, "flow": self.flow}
        verdict = judged(self._as_drawn(problem), **options)
        # Earlier forces are no Coulomb state: that was solved for.
        proven = self.flow == "associated" or verdict.outcome is Outcome.UNSTABLE
        word = verdict.solver if proven and verdict.solver.startswith("earlier") else "solved"
        return Row(number, verdict.outcome.word, word, process_time() - start, self.population.drawn(normal))

    def _as_drawn(self, problem: Problem) -> Problem:
        """The problem with the overlaps and contacts without a normal of the drawing: moved corners make none."""
        return replace(problem, overlapping=self._overlapping, unresolved=lambda: self._unresolved)

    def digest(self) -> str:
        """Return what tells these draws from others.

        Returns
        -------
        str
            Of all of the blocks and joints but their name, metadata and dropped patches, of the loads, the random
            variables, the point about which they are drawn, the seed, the flow and the gap; not of how many draws
            there are.
        """
        own, digest = self.population, hashlib.sha256()
        joints = {k: value for k, value in vars_of(own.interfaces).items() if k not in ("dropped", "crushed", "moved")}
        blocks = {name: value for name, value in vars_of(own.assembly).items() if name not in ("name", "metadata")}
        about = [TURNS, self.centre] if self.centre.any() else []
        beside, factor = (None, 1.0) if own.loads is None else vars_of(weighted(own.loads)).values()
        more = [part for part in (own.gap, own.interfaces.crushed) if part not in (GAP, ())]
        more += [{"weight": factor}] if factor != 1.0 else []
        for part in (blocks, joints, beside, self.load, dict(own.uncertain), about, self.seed, self.flow, *more):
            _take(digest, part)
        return digest.hexdigest()[:16]


def vars_of(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass.

    Parameters
    ----------
    value
        An object of a dataclass.

    Returns
    -------
    dict
        By name.
    """
    return {field.name: getattr(value, field.name) for field in fields(value)}


def _take(digest: Any, value: Any) -> None:
    """Add a value to a digest: arrays by what they hold, and objects by their fields."""
    if isinstance(value, Mapping):
        value = [part for item in value.items() for part in item]
    elif is_dataclass(value):
        value = [type(value).__name__, *vars_of(value).values()]
    if isinstance(value, (list, tuple)):
        digest.update(f"[{len(value)}".encode())
        for part in value:
            _take(digest, part)
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    else:
        digest.update(f"{value!r};".encode())


#: What a process is given: what is drawn, the numbers of draws, their normal variables, and evidence of earlier ones.
Task = tuple[Trials, Ints, Floats, list[Known]]


def judge_all(
    trials: Trials, draws: int, file: str | Path | None, jobs: int | None, progress: Progress | None
) -> list[Row]:
    """Give the verdicts on draws, those of a file and those that it lacks.

    Parameters
    ----------
    trials
        What is drawn.
    draws
        How many.
    file
        Where rows are kept as they come; None for nowhere.
    jobs
        Processes side by side; None for one, or for all workers of the backend of joblib that is in force.
    progress
        Called with the draws done and those asked for. With it an interrupt keeps the draws until the first that is
        missing, if there are any; without it, it is raised.

    Returns
    -------
    list of Row
        In the order of the draws; fewer than asked for after an interrupt.

    Raises
    ------
    InputError
        For a file of other draws, and for more draws than fit into memory.
    """
    size = trials.population.size
    if draws * size > MOST_NUMBERS:
        raise InputError(f"draws is {draws:,}; of {size:,} random numbers each at most {MOST_NUMBERS // size:,} fit")
    path = None if file is None else Path(file)
    with nullcontext() if path is None else locked(path.parent, name=f".{path.name}-lock"):
        rows = {} if path is None else _opened(path, trials)
        with nullcontext() if path is None else path.open("a") as kept:
            try:
                for fresh in _batches(trials, draws, rows, jobs):
                    if kept is not None:
                        append_rows(kept, map(asdict, fresh))
                    rows |= {row.draw: row for row in fresh}
                    if progress is not None:
                        progress(sum(number < draws for number in rows), draws)
            except KeyboardInterrupt:
                if progress is None or 0 not in rows:
                    raise
    # Those after one that is missing were the faster ones: they would say that fewer fall.
    return [rows[number] for number in takewhile(rows.__contains__, range(draws))]


def _batches(trials: Trials, draws: int, rows: Mapping[int, Row], jobs: int | None) -> Iterator[list[Row]]:
    """Rows of the draws that have none, as they come."""
    workers = count_workers(jobs)
    missing = np.setdiff1d(np.arange(draws), list(rows))
    normal = trials.normals(draws)
    parts = [missing[i : i + BATCH] for i in range(0, len(missing), BATCH)]
    known: list[Known] = []

    def task(part: Ints) -> Task:
        return trials, part, normal[part], list(known)

    if not workers:
        for part in parts:
            fresh, known = judge_batch(task(part), everything=True)
            yield fresh
        return
    # No more batches under way than workers: the later one is sent, the more evidence goes with it.
    for fresh, gained in as_they_come(judge_batch, (task(part) for part in parts), jobs, ahead=workers):
        known.extend(gained)
        yield fresh


def judge_batch(task: Task, *, everything: bool = False) -> tuple[list[Row], list[Known]]:
    """Give the verdicts on some draws, in a process of its own.

    Parameters
    ----------
    task
        What is drawn, the numbers of the draws, their standard normal variables, shape (n, size), and evidence of
        earlier draws.
    everything
        Return all evidence there is, not what is new.

    Returns
    -------
    rows : list of Row
        One a draw.
    evidence : list of Known
        What was solved for.
    """
    trials, numbers, normals, known = task
    evidence = NearbyEvidence(known) if trials.reuse else None
    rows = [trials.judge(int(k), normal, evidence) for k, normal in zip(numbers, normals, strict=True)]
    if evidence is None:
        return rows, []
    return rows, evidence.known if everything else evidence.gained


def _opened(path: Path, trials: Trials) -> dict[int, Row]:
    """Rows of a file by the number of their draw."""
    head = {"draws": "blockstat reliability", "of": trials.digest()}
    rows = kept_rows(path, head, lambda row: Row(**row), other="draws of something else")
    return {row.draw: row for row in rows}
