"""The limit load multiplier in Bullet, by bracketing."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, check_number, known_options
from blockstat.loads import as_load
from blockstat.result import Result, Sentence, finite, millimetres
from blockstat.typing import Floats
from dynsim.judge.closing import closed_scene
from dynsim.judge.criteria import default_threshold
from dynsim.judge.static_reserve import friction_excess
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.judge.verify import verify_unasked  # statics are asked for the lower end alone
from dynsim.loads.load import Load, as_loads
from dynsim.loads.loading import Constant
from dynsim.settings import Settings

#: The first run is at this share of the static upper bound: Bullet falls a little early, hardly ever late.
FIRST, SECOND = 0.98, 1.005
#: Steps away from a bracket's open end grow by this factor, from the first of this relative size.
GROWTH, STEP = 2.0, 0.025
#: A load carried this many times over, in units of the weight, is called unbounded.
UNBOUNDED = 64.0
#: A bracket that still begins at 0 is halved down to this share of the first upper end. A static limit that is a
#: smaller share of the weight is no guess.
LEAST = 1e-6
#: Outside a bracket, this far off relative to it, the verdicts are asked for once more.
BESIDE = 0.05


class LimitOutcome(Sentence):
    """How a bracketing ended; the value of each is the sentence that a user reads."""

    LIMIT = "Limit: in Bullet the assembly carries the load up to the lower multiplier, and moves at the upper one."
    UNBOUNDED = "Unbounded: no multiple of the load that was tried moves the assembly in Bullet."
    STOPPED = "Stopped: the runs until then, and what they bracket in Bullet."
    DEAD_LOAD_FALLS = "Falls under dead load: in Bullet the assembly does not stand without the load."


@dataclass(frozen=True)
class Trial:
    """One run of a bracketing."""

    multiplier: float
    verdict: str  #: word of the DynamicOutcome
    max_displacement: float  #: [m]
    simulated_seconds: float
    process_seconds: float


@dataclass(frozen=True, eq=False)
class DynamicLimit(Result):
    """Bracket on the multiplier of a load at which an assembly ceases to stand in Bullet."""

    outcome: LimitOutcome
    #: largest multiplier below `upper` at which it stood; 0 where runs cannot tell one from 0; -inf where an interrupt
    #: came before it stood at any
    lower: float
    upper: float  #: smallest multiplier at which it did not; inf where an interrupt came before
    static: tuple[float, float]  #: the static bracket, associated flow
    trials: tuple[Trial, ...]  #: in the order they were run
    process_seconds: float  #: of the runs and the static limit
    threshold: float  #: displacement from which a block has fallen [m]
    warnings: tuple[str, ...] = ()

    @property
    def ratio(self) -> float | None:
        """Return the middle of the bracket over the static upper bound; None where one is infinite or not above 0."""
        middle = (self.lower + self.upper) / 2
        return middle / self.static[1] if self.lower > 0 and middle < np.inf and 0 < self.static[1] < np.inf else None

    def explain(self) -> str:
        """Return the bracket, its ratio to the static limit and all runs in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.outcome in (LimitOutcome.LIMIT, LimitOutcome.STOPPED):
            lines.append(self._between())
        if np.isinf(self.static[0]) and self.static[0] > 0:
            lines.append("Statics carry the load without bound.")
        elif np.isneginf(self.static[1]):
            lines.append("By statics it falls without the load, too.")
        elif np.isneginf(self.static[0]) and np.isinf(self.static[1]):
            lines.append("Statics do not decide.")
        else:
            lines.append(f"Static bracket: {self.static[0]:.5g} to {self.static[1]:.5g}.")
        if self.ratio is not None and self.outcome is LimitOutcome.LIMIT:
            lines.append(f"Bullet / static: {self.ratio:.3f}.")
        most = millimetres(self.threshold, 2)
        lines.append(f"Falls: a block moves by more than {most} mm, or turns too far; a run ends there.")
        lines += [f"{t.multiplier:.5g}: {t.verdict}, {millimetres(t.max_displacement, 2)} mm" for t in self.trials]
        lines += [f"Warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    def _between(self) -> str:
        """The bracket, or the end of it that is known."""
        if np.isneginf(self.lower):
            return f"Multiplier below {self.upper:.5g}; it has not stood at any so far."
        if np.isinf(self.upper):
            return f"Multiplier above {self.lower:.5g}; it has not moved at any so far."
        return f"Multiplier between {self.lower:.5g} and {self.upper:.5g}."

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; what is not finite is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "lower": finite(self.lower),
            "upper": finite(self.upper),
            "static_lower": finite(self.static[0]),
            "static_upper": finite(self.static[1]),
            "ratio": self.ratio,
            "threshold": self.threshold,
            "runs": len(self.trials),
            "trials": [vars(trial) for trial in self.trials],
            "process_seconds": self.process_seconds,
            "warnings": list(self.warnings),
        }


@known_options
def limit(
    assembly: Assembly,
    load: Any,
    *,
    loads: Floats | None = None,
    settings: Settings | None = None,
    width: float = 0.01,
    check: bool = True,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    progress: Callable[[Trial], None] | None = None,
) -> DynamicLimit:
    """Bracket the multiplier of a load at which an assembly ceases to stand in Bullet.

    The search starts from the static limit load. Whatever is not "stands" counts as beyond the limit; where statics
    carry the load without bound, only "falls" does. A block falls by the criteria of `verify`, with the threshold of
    `settings`; a run ends there, so its displacement is the threshold and little more.

    Parameters
    ----------
    assembly : Assembly
        Blocks, supports and joint laws.
    load : sequence of three floats, or array of shape (n_blocks, 6)
        A direction of acceleration, in units of the scene's gravity, or a wrench on each block about its centroid
        [N, N m], as in `blockstat.limit_load`. The load acts from the start of settling on.
    loads : array of shape (n_blocks, 6), optional
        Wrenches that stay as they are [N, N m], as in `blockstat.limit_load`.
    settings : Settings, optional
        Of each run, as in `verify`.
    width : float
        Width of the bracket relative to its upper end, from 1e-4 to below 1.
    check : bool
        Two more runs beside the bracket, which notice when verdicts change more than once.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for once when None.
    progress : callable, optional
        Called with the `Trial` of every run. With it a KeyboardInterrupt after the first run gives the outcome
        "stopped" and the bracket until then; without it, it is raised.

    Returns
    -------
    DynamicLimit
        The bracket, the static bracket and all runs.

    Raises
    ------
    InputError
        As `verify` does, or for a bad load or width. Also for an option that does not exist.

    Examples
    --------
    A pillar of 0.5 x 0.5 x 2 m tips at a quarter of its weight.

    >>> from blockstat import Assembly, box
    >>> from dynsim import limit
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = limit(pillar, (1, 0, 0), width=0.1, check=False)
    >>> found.outcome.word, found.lower < 0.26, found.upper > 0.24
    ('limit', True, True)
    """
    check_number("limit: width", width)
    if not 1e-4 <= width < 1:
        raise InputError(f"limit: width is {width!r}; it must be from 0.0001 to below 1")
    start = process_time()
    force = _as_force(assembly, load)
    static = limit_load(assembly, load, loads=loads, gap=gap, interfaces=interfaces)
    if interfaces is None:
        divided = static.interfaces.share is not None  # into cells, for a joint law
        interfaces = find_interfaces(assembly, gap=gap) if divided else static.interfaces
    search = _Search(
        assembly, force, as_loads(assembly, loads), settings, interfaces, width, progress,
        unbounded=static.outcome is LoadOutcome.UNBOUNDED,
    )  # fmt: skip
    try:
        outcome, lower, upper = search.beside(static, check)
    except KeyboardInterrupt:
        if progress is None or not search.trials:
            raise
        outcome, lower, upper = LimitOutcome.STOPPED, *search.until_then()
    return DynamicLimit(
        outcome, lower, upper, (static.lower, static.upper), tuple(search.trials), process_time() - start,
        search.threshold,
        (*search.warnings, *_warnings(search.trials, lower, upper, unbounded=search.unbounded),
         *search.on_friction(lower), *_creeping(settings)),
    )  # fmt: skip


def _as_force(assembly: Assembly, load: Any) -> Floats:
    """Return what `Constant` takes: of a direction an acceleration, which Bullet applies without stepping from here."""
    wrench = as_load(assembly, load)
    direction = np.asarray(load, dtype=float)
    if direction.shape != (3,):
        return wrench
    return direction / np.linalg.norm(direction) * np.linalg.norm(assembly.gravity)


def _greatest_share(assembly: Assembly, force: Floats) -> float:
    """Largest share of its weight with which the load acts on a free block; 1 where it acts on none."""
    strength = np.linalg.norm(assembly.gravity)
    if force.shape == (3,):
        return float(np.linalg.norm(force) / strength)
    free = assembly.free
    size = np.linalg.norm(force[free, :3], axis=1) + np.linalg.norm(force[free, 3:], axis=1) / assembly.size[free]
    return float((size / (assembly.mass[free] * strength)).max()) or 1.0


class _Search:
    """Runs of one assembly under multiples of one load, all kept."""

    def __init__(
        self,
        assembly: Assembly,
        force: Floats,
        permanent: tuple[Load, ...],
        settings: Settings | None,
        interfaces: Interfaces,
        width: float,
        progress: Callable[[Trial], None] | None,
        *,
        unbounded: bool,
    ) -> None:
        self._assembly, self._force, self._settings = assembly, force, settings
        self._permanent = permanent
        self._interfaces, self._width, self._progress = interfaces, width, progress
        self.unbounded = unbounded
        chosen = None if settings is None else settings.brick_threshold
        self.threshold = chosen or default_threshold(assembly)
        self.trials: list[Trial] = []
        self.warnings: dict[str, None] = {}  #: of the runs, each once
        self._ends: dict[float, DynamicVerdict] = {}  # of runs that stood, by multiplier, with their last frame alone
        total = Constant(force).size(assembly)
        self._unit = assembly.free_weight / total if total > 0 else 1.0  # where the load is as strong as the weight
        self._found: tuple[float, float] | None = None  # the bracket, once it is narrow enough
        self._blind = Settings.of(settings).resolution / _greatest_share(assembly, force)  # no run has to show less

    def stands(self, multiplier: float) -> bool:
        """Run the protocol at a multiplier."""
        loads = self._loads(multiplier)
        verdict = verify_unasked(self._assembly, settings=self._settings, loads=loads, interfaces=self._interfaces)
        run = verdict.run
        trial = Trial(
            float(multiplier), verdict.outcome.word, verdict.max_displacement, float(run.times[-1]), run.process_seconds
        )
        self.trials.append(trial)
        self.warnings |= dict.fromkeys(verdict.warnings)
        if verdict.outcome is DynamicOutcome.STANDS:
            last = replace(run, displacement=run.displacement[-1:].copy(), rotation=run.rotation[-1:].copy())
            self._ends[trial.multiplier] = replace(verdict, run=last)
        if self._progress is not None:
            self._progress(trial)
        return _carries(trial, unbounded=self.unbounded)

    def _loads(self, multiplier: float) -> list[Load]:
        """What acts at a multiplier."""
        return [*self._permanent, *([Constant(multiplier * self._force)] if multiplier else [])]

    def on_friction(self, lower: float) -> list[str]:
        """What is said of a lower multiplier that is only carried on friction beyond Coulomb's.

        Statics are asked for it alone, and only where they do not prove it for some of the smaller ones.
        """
        if (text := self._oblique(lower)) is None:
            return []
        stood = sorted(at for at in self._ends if at < lower)
        without = stood[: bisect_left(stood, True, key=lambda at: self._oblique(at) is not None)]
        return [f"at {lower:.5g} {text}" + (f"; up to {without[-1]:.5g} it stood without" if without else "")]

    def _oblique(self, multiplier: float) -> str | None:
        """What a run says that stood on friction beyond Coulomb's."""
        if multiplier not in self._ends:
            return None
        end, joints = self._ends[multiplier], closed_scene(self._assembly, self._interfaces).interfaces
        excess = friction_excess(end.run, joints, self._loads(multiplier), end.resolution)
        return None if excess is None else excess.warning

    def beside(self, static: LimitLoad, check: bool) -> tuple[LimitOutcome, float, float]:
        """Outcome and bounds, from the static limit; to check them, more runs beside them."""
        if static.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE and not self.stands(0.0):
            return LimitOutcome.DEAD_LOAD_FALLS, -np.inf, -np.inf
        outcome, lower, upper = self.bracket(static.upper if np.isfinite(static.upper) and static.upper > 0 else None)
        self._found = lower, upper
        if check and outcome is LimitOutcome.LIMIT:
            for multiplier in (lower * (1 - BESIDE), upper * (1 + BESIDE)):
                if multiplier:  # 0 was tried
                    self.stands(multiplier)
        return outcome, lower, upper

    def until_then(self) -> tuple[float, float]:
        """The bracket as far as the runs have found it."""
        if self._found is not None:
            return self._found
        stood = {trial.multiplier: _carries(trial, unbounded=self.unbounded) for trial in self.trials}
        high = min((at for at, carries in stood.items() if not carries), default=np.inf)
        low = max((at for at, carries in stood.items() if carries and at < high), default=-np.inf)
        return low if low > self._blind or np.isneginf(low) else 0.0, high

    def bracket(self, guess: float | None) -> tuple[LimitOutcome, float, float]:
        """Outcome and bounds, from a guess of the limit or from nothing."""
        low, high = self._from_nothing() if guess is None or guess <= LEAST * self._unit else self._below(guess)
        if low is None:
            return LimitOutcome.DEAD_LOAD_FALLS, -np.inf, -np.inf
        if high is None:
            return LimitOutcome.UNBOUNDED, low, np.inf
        least = LEAST * high
        while high - low > self._width * high and high > (self._blind if low else least):
            middle = (low + high) / 2
            low, high = (middle, high) if self.stands(middle) else (low, middle)
        return LimitOutcome.LIMIT, low if low > self._blind else 0.0, high

    def _below(self, guess: float) -> tuple[float | None, float | None]:
        """Close to the guess first, then further and further away on the side that is open."""
        first, step = FIRST * guess, STEP * guess
        if self.stands(first):
            low, high = first, SECOND * guess
            while self.stands(high):
                low, high, step = high, high + step, GROWTH * step
                if high > UNBOUNDED * max(guess, self._unit):
                    return low, None
            return low, high
        high, low = first, first - step
        while low > 0.0 and not self.stands(low):
            step *= GROWTH
            high, low = low, low - step
        if low > 0.0:
            return low, high
        return (0.0, high) if self.stands(0.0) else (None, None)

    def _from_nothing(self) -> tuple[float | None, float | None]:
        """No static limit to start from: loads about as strong as the weight, doubled."""
        if not self.stands(0.0):
            return None, None
        low, high = 0.0, 0.5 * self._unit
        while self.stands(high):
            low, high = high, GROWTH * high
            if high > UNBOUNDED * self._unit:
                return low, None
        return low, high


def _carries(trial: Trial, *, unbounded: bool) -> bool:
    """Whether a run counts as carried.

    What statics carry without bound, blocks that creep have not ceased to carry: only a fall is a limit there.
    """
    return trial.verdict == DynamicOutcome.STANDS.word or (unbounded and trial.verdict == DynamicOutcome.CREEPS.word)


def _creeping(settings: Settings | None) -> list[str]:
    """What is said of time steps in which joints creep near their limit."""
    if settings is None or settings.time_step <= Settings().time_step:
        return []
    return [
        f"in steps of {1e3 * settings.time_step:g} ms joints creep near their limit; the default preset has finer ones"
    ]


def _warnings(trials: list[Trial], lower: float, upper: float, *, unbounded: bool = False) -> tuple[str, ...]:
    """Return what the runs say that does not fit one limit."""
    stood = [t.multiplier for t in trials if _carries(t, unbounded=unbounded)]
    moved = [t.multiplier for t in trials if not _carries(t, unbounded=unbounded)]
    warnings = []
    faint = [m for m in stood if 0.0 < m < upper]
    if lower == 0.0 and np.isfinite(upper) and faint:
        warnings.append(
            f"not resolved: it stood at {max(faint):.5g}, but a run need not show so small a load; the limit may be "
            f"anywhere below {upper:.5g}"
        )
    elif lower == 0.0 and np.isfinite(upper):
        warnings.append(f"it moved down to a multiplier of {upper:.5g}; smaller ones above 0 were not tried")
    early, late = [m for m in moved if m <= lower], [m for m in stood if m >= upper]
    if early:
        listed = ", ".join(f"{m:.5g}" for m in sorted(early))
        warnings.append(f"not one limit: it moved at {listed} too, below the bracket")
    if late:
        listed = ", ".join(f"{m:.5g}" for m in sorted(late))
        warnings.append(f"not one limit: it stood{' or crept' * unbounded} at {listed} too, above the bracket")
    slow = sorted({t.verdict for t in trials} - {"stands", "falls"})
    if slow:
        counted = "carried, as statics carry the load without bound" if unbounded else "beyond the limit"
        warnings.append(f"some runs neither stood nor fell ({', '.join(slow)}); they count as {counted}")
    return tuple(warnings)
