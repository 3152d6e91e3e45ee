"""Incremental dynamic analysis: the result, and the function that makes it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, check_choice, check_number, known_options
from blockstat.result import Result, Sentence, finite, millimetres
from blockstat.typing import Floats
from dynsim.earthquake.fragility import FEWEST, Fragility, fit_fragility
from dynsim.earthquake.hunt import Hunt, bracket
from dynsim.earthquake.motion import MEASURES, Motions, intensity_of, named_motions
from dynsim.earthquake.runs import REST, Kept, ScaledRun, Shaking, kept
from dynsim.earthquake.schedule import Hunted, hunt_all
from dynsim.engine.guards import check_can_simulate
from dynsim.engine.world import Action
from dynsim.judge.rest import threshold_under
from dynsim.judge.verdict import DynamicOutcome
from dynsim.loads.load import as_actions, as_loads
from dynsim.parallel.pool import jobs_checked
from dynsim.settings import Settings


class IncrementalOutcome(Sentence):
    """How an incremental dynamic analysis ended; the value of each is the sentence that a user reads."""

    COLLAPSE = "Collapse: every record fells a block at some intensity."
    PARTIAL_COLLAPSE = "Partial collapse: some records fell a block; the others do not up to the greatest intensity."
    STANDS = "Stands: no record fells a block up to the greatest intensity."
    FALLS_AT_REST = "Falls at rest: a block falls without a record."
    INCOMPLETE = "Incomplete: records have runs to come."


@dataclass(frozen=True, eq=False)
class IncrementalCurve:
    """The runs of one record: intensity against the largest displacement."""

    name: str
    runs: tuple[ScaledRun, ...]  #: by ascending intensity
    complete: bool  #: whether its hunt is over
    error: str = ""  #: why it has no more runs

    @cached_property
    def _bracket(self) -> tuple[float, float]:
        return bracket({run.intensity: run.fell for run in self.runs})

    @property
    def lower(self) -> float:
        """Largest intensity below `upper` at which no block fell; 0 where there is none."""
        return self._bracket[0]

    @property
    def upper(self) -> float:
        """Collapse intensity, the lowest at which a block fell; inf where none ever did."""
        return self._bracket[1]

    @property
    def first_block(self) -> str | None:
        """The block that fell first at the collapse intensity; None where none ever did, or a group did by Eq. 1."""
        return next((run.first_block for run in self.runs if run.intensity == self.upper), None)

    @property
    def resurrections(self) -> tuple[float, ...]:
        """Intensities above the collapse intensity at which no block fell."""
        return tuple(run.intensity for run in self.runs if run.intensity > self.upper and not run.fell)

    @property
    def unsettled(self) -> tuple[float, ...]:
        """Intensities at which no block fell and some were still moving when the run ended."""
        return tuple(run.intensity for run in self.runs if run.outcome == DynamicOutcome.CREEPS.word)


@dataclass(frozen=True, eq=False)
class IncrementalAnalysis(Result):
    """Curves of an assembly under scaled records, and their fragility."""

    assembly: Assembly
    curves: tuple[IncrementalCurve, ...]  #: one a record, in the order given
    measure: str  #: intensity measure, a key of `MEASURES`
    up_to: float  #: the greatest intensity asked for
    threshold: float  #: displacement from which a block has fallen [m]
    at_rest: str  #: word of the outcome without a record; "" where that was not run
    confidence: float  #: of the fragility
    finished: bool  #: False after an interrupt
    process_seconds: float  #: of all runs, those of earlier calls too

    @property
    def outcome(self) -> IncrementalOutcome:
        """Whether records fell a block."""
        if self.at_rest == DynamicOutcome.FALLS.word:
            return IncrementalOutcome.FALLS_AT_REST
        if not all(curve.complete for curve in self.curves):
            return IncrementalOutcome.INCOMPLETE
        fell = [np.isfinite(curve.upper) for curve in self.curves]
        if all(fell):
            return IncrementalOutcome.COLLAPSE
        return IncrementalOutcome.PARTIAL_COLLAPSE if any(fell) else IncrementalOutcome.STANDS

    @property
    def unit(self) -> str:
        """Unit of the intensities."""
        return MEASURES[self.measure]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader should know of the runs, a sentence each."""
        runs = [run for curve in self.curves for run in curve.runs]
        found = list(dict.fromkeys(text for run in runs for text in run.warnings))
        for curve in self.curves:
            if curve.error:
                found.append(f"{curve.name}: {curve.error}; the same call tries again")
            if curve.resurrections:
                at = self._listed(curve.resurrections)
                found.append(f"{curve.name}: stands again at {at}, above the lowest intensity at which it fell")
            if curve.unsettled:
                at = self._listed(curve.unsettled)
                found.append(f"{curve.name}: blocks were still moving at the end at {at}; that counts as no fall")
        if self.at_rest == DynamicOutcome.CREEPS.word:
            found.append("without a record blocks neither rest nor fall: they creep")
        return tuple(found)

    def _listed(self, intensities: Sequence[float]) -> str:
        return ", ".join(f"{value:.4g}" for value in intensities) + f" {self.unit}"

    def fragility(self, *, confidence: float | None = None) -> Fragility:
        """Fit a lognormal fragility to the brackets of the records.

        Parameters
        ----------
        confidence : float, optional
            Of the intervals and of the band; that of the analysis when None.

        Returns
        -------
        Fragility
            As `fit_fragility` does it. A record that fell nothing is censored at the greatest intensity at which it was
            run.

        Raises
        ------
        InputError
            As `fit_fragility`; only records with a run count.
        """
        run = [curve for curve in self.curves if curve.runs]
        bounds: Floats = np.array([(curve.lower, curve.upper) for curve in run]).reshape(-1, 2)
        return fit_fragility(*bounds.T, confidence=self.confidence if confidence is None else confidence)

    def _lacking(self, error: InputError) -> str:
        """Why there is no fragility; of enough records runs to come may be all that it lacks."""
        coming = sum(not curve.complete for curve in self.curves)
        if len(self.curves) < FEWEST or not coming:
            return error.line
        return f"fragility: {coming} of {len(self.curves)} records have runs to come"

    def explain(self) -> str:
        """Return the collapse intensities and the fragility in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.outcome is IncrementalOutcome.FALLS_AT_REST:
            return lines[0]
        unit = self.unit
        for curve in self.curves:
            runs = f"{len(curve.runs)} run{'s' * (len(curve.runs) != 1)}"
            if np.isfinite(curve.upper):
                stands = f"stands at {curve.lower:.4g} {unit}, " if curve.lower else ""
                block = f", {curve.first_block} first" if curve.first_block else ""  # none by Eq. 1 alone
                first = f"{stands}falls at {curve.upper:.4g} {unit}{block}"
            else:
                first = f"stands up to {curve.lower:.4g} {unit}" if curve.runs else "no verdict"
            lines.append(f"{curve.name}: {first} ({runs}).")
        lines.append(f"Falls: a block moves by more than {millimetres(self.threshold)} mm, or overturns.")
        try:
            lines.append(self.fragility().explain() + f" Intensities are {self.measure.upper()} in {unit}.")
        except InputError as error:
            lines.append(f"No fragility: {self._lacking(error).removeprefix('fragility: ')}.")
        return "\n".join([*lines, *(f"Warning: {text}." for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; what is infinite is None.

        Returns
        -------
        dict
            Values by name.
        """
        try:
            fitted, why = self.fragility().summary(), None
        except InputError as error:
            fitted, why = None, self._lacking(error)
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "finished": self.finished,
            "measure": self.measure,
            "unit": self.unit,
            "up_to": self.up_to,
            "threshold": self.threshold,
            "records": [
                {
                    "name": curve.name,
                    "lower": curve.lower,
                    "upper": finite(curve.upper),
                    "first_block": curve.first_block,
                    "complete": curve.complete,
                    "resurrections": list(curve.resurrections),
                    "error": curve.error,
                    "runs": [asdict(run) for run in curve.runs],
                }
                for curve in self.curves
            ],
            "fragility": fitted,
            "no_fragility": why,
            "process_seconds": self.process_seconds,
            "warnings": list(self.warnings),
        }


@known_options
def incremental(
    assembly: Assembly,
    records: Motions,
    *,
    measure: str = "pga",
    start: float = 0.1,
    factor: float = 1.25,
    up_to: float = 3.0,
    resolution: float = 0.05,
    beyond: int = 2,
    confidence: float = 0.95,
    loads: Floats | None = None,
    actions: Sequence[Action] = (),
    settings: Settings | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    directory: str | Path | None = None,
    jobs: int | None = None,
    progress: Callable[[ScaledRun], None] | None = None,
) -> IncrementalAnalysis:
    """Scale ground motions until a block falls, and fit a fragility over them (incremental dynamic analysis).

    Each record is scaled up by steps until a block falls. The interval between the largest intensity that it stood and
    the one at which it fell is then halved until it is narrow enough. Runs of different records go side by side. An
    interrupt (Ctrl-C) ends what runs, and keeps what is done.

    Parameters
    ----------
    assembly : Assembly
        Blocks, supports and joint laws.
    records : mapping of str to Record or Pulse, or sequence of them
        The motions by name; a sequence gets the names "record 1", "record 2" and so on.
    measure : str, optional
        Intensity measure: "pga", the largest length of the horizontal acceleration of the scaled record [g, 9.81 m/s2],
        or "pgv", that of its horizontal velocity [m/s]. All components are scaled alike.
    start : float, optional
        First intensity, in the unit of the measure.
    factor : float, optional
        From one step to the next, above 1.
    up_to : float, optional
        Greatest intensity.
    resolution : float, optional
        Width of the bracket of the collapse intensity relative to its upper end (to `start` where that is more).
    beyond : int, optional
        So many of the steps above the collapse intensity are run, too: they show whether it stands again.
    confidence : float, optional
        Of the intervals and the band of the fragility.
    loads : array of shape (n_blocks, 6), optional
        Wrenches that stay as they are [N, N m], as in `blockstat.limit_load`.
    actions : sequence of Action, optional
        What else acts on the blocks, as in `verify`.
    settings : Settings, optional
        Of each run, as in `verify`.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for once when None.
    directory : str or Path, optional
        Keeps each run in a file runs.jsonl as it ends. The same call goes on from the runs that are there; so does one
        with more records, other steps or a finer resolution.
    jobs : int, optional
        Processes at a time; all cores when None. A record uses one at a time.
    progress : callable, optional
        Called with the `ScaledRun` of every new run.

    Returns
    -------
    IncrementalAnalysis
        Curves, brackets and fragility.

    Raises
    ------
    InputError
        As `verify` does; for no record, a record without horizontal motion, a bad option, or a directory of another
        analysis or in use. Also for an option that does not exist.

    Notes
    -----
    Collapse need not be monotonic: a block that a record fells may stand under a stronger one, when its pulses meet the
    rocking block in another phase. The collapse intensity is the lowest at which a run fell a block, and the bracket is
    that below it. Runs that stood above it are kept and told (`resurrections`). A fall between two steps that both
    stood is not seen: a smaller factor sees more.

    References
    ----------
    Vamvatsikos & Cornell: Incremental dynamic analysis, 2002.

    Examples
    --------
    A block four times as high as wide rocks from 0.25 g on. A rectangular pulse of a quarter of a second fells it at
    0.41 g (Housner 1963).

    >>> from blockstat import Assembly, box
    >>> from dynsim import Pulse, incremental
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.25, 0.5, 1), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"], friction=0.9)
    >>> pulse = {"rectangle": Pulse((9.81, 0, 0), 0.25)}
    >>> found = incremental(pillar, pulse, start=0.2, factor=2, resolution=0.1, jobs=1, beyond=0)
    >>> found.outcome.word, found.curves[0].lower < 0.41 < found.curves[0].upper
    ('collapse', True)
    """
    check_choice("measure", measure, MEASURES)
    hunt = Hunt(start, factor, up_to, resolution, beyond)
    check_number("incremental: confidence", confidence)
    if not 0 < confidence < 1:
        raise InputError(f"incremental: confidence is {confidence!r}; it must be between 0 and 1")
    motions, processes = named_motions(records), jobs_checked(jobs)
    check_can_simulate(assembly)
    units = {name: intensity_of(motion, assembly.gravity, measure) for name, motion in motions.items()}
    for name, unit in units.items():
        if not unit > 0:
            raise InputError(f'incremental: "{name}" has no horizontal motion, so its {measure.upper()} is 0')
    joints = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    lasting = as_loads(assembly, loads)
    shaking = Shaking(assembly, Settings.of(settings), lasting, as_actions(actions), joints)
    with kept(directory, shaking, measure, motions) as runs:
        hunted = hunt_all(shaking, hunt, motions, units, runs, processes, progress)
    chosen = threshold_under(assembly, [*lasting, *motions.values()], shaking.settings.brick_threshold)
    return IncrementalAnalysis(
        assembly=assembly, curves=_curves(motions, hunt, runs, hunted), measure=measure, up_to=up_to, threshold=chosen,
        at_rest=next((run.outcome for run in runs.of(REST).values()), ""), confidence=confidence,
        finished=hunted.finished,
        process_seconds=sum(run.process_seconds for run in runs.runs if run.record in (REST, *motions)),
    )  # fmt: skip


def _curves(motions: Iterable[str], hunt: Hunt, runs: Kept, hunted: Hunted) -> tuple[IncrementalCurve, ...]:
    """The runs of each record."""
    curves = []
    for name in motions:
        own = runs.of(name)
        ordered = tuple(own[intensity] for intensity in sorted(own))
        complete = hunt.following({run.intensity: run.fell for run in ordered}) is None
        curves.append(IncrementalCurve(name, ordered, complete, hunted.errors.get(name, "")))
    return tuple(curves)
