"""Plans: in which steps an assembly is built, which blocks are held after each, and whether every step stands."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from time import monotonic, process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.contact.interfaces import GAP
from blockstat.errors import InputError, check_choice, check_names, known_options, no_such
from blockstat.result import Result, Unfinished, counted, finite, listed
from blockstat.sequence.props import Falsework, Prop, check_on_block, on_props, prop_of
from blockstat.sequence.states import Whole
from blockstat.system.reading import json_of
from blockstat.system.workers import in_stretches
from blockstat.system.writing import written_whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: What a plan and a step may say; who holds a block ("robots") makes no difference.
KEYS = ("steps", "boundary", "never_installed", "name", "assembly", "props")
STEP_KEYS = ("install", "hold", "in", "out", "robots")
#: Brackets of the least friction are narrowed to this.
FRICTION_STEP = 1e-5
#: Friction beyond which none helps: the cone is a half-space but for a hundredth of a degree.
MOST_FRICTION = 1e4


@dataclass(frozen=True)
class Step:
    """One step of a plan."""

    install: tuple[str, ...] = ()  #: blocks put in now
    hold: tuple[str, ...] = ()  #: blocks held at the end of the step
    props_in: tuple[str, ...] = ()  #: props set up now, by the names that the plan gives them
    props_out: tuple[str, ...] = ()  #: props taken away now

    def __post_init__(self) -> None:
        for name in ("install", "hold", "props_in", "props_out"):
            object.__setattr__(self, name, check_names(f"step: {name}", getattr(self, name)))


@dataclass(frozen=True)
class Plan:
    """The steps in which an assembly is built; steps are numbered from 0."""

    steps: tuple[Step, ...]
    boundary: tuple[str, ...] = ()  #: blocks that stand and are fixed from the beginning, besides the supports
    never_installed: tuple[str, ...] = ()  #: blocks that the plan leaves out
    name: str = "plan"
    assembly: str = ""  #: the file of the assembly
    metadata: dict[str, Any] = field(default_factory=dict)  #: other keys of the file
    props: Mapping[str, Prop] = field(default_factory=dict)  #: struts that push and never pull, by name

    def __post_init__(self) -> None:
        steps = (None,) if isinstance(self.steps, Step) else tuple(self.steps)
        if not all(isinstance(step, Step) for step in steps):
            raise InputError(f"plan: steps are {self.steps!r}; they must be a tuple of Step")
        object.__setattr__(self, "steps", steps)
        for name in ("boundary", "never_installed"):
            object.__setattr__(self, name, check_names(f"plan: {name}", getattr(self, name)))

    @property
    def most_held(self) -> int:
        """The largest number of blocks held at once."""
        return max((len(step.hold) for step in self.steps), default=0)

    def standing_props(self) -> list[tuple[str, ...]]:
        """Return the props that stand after each step.

        Returns
        -------
        list of tuple of str
            Their names, one tuple a step.
        """
        standing, found = dict[str, None](), []
        for step in self.steps:
            standing = {name: None for name in (*standing, *step.props_in) if name not in step.props_out}
            found.append(tuple(standing))
        return found

    def states(self) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
        """Return the blocks present and fixed after each step.

        Returns
        -------
        list of (tuple of str, tuple of str)
            One a step, as `assess_states` takes them: the boundary is among both.
        """
        present, found = list(self.boundary), []
        for step in self.steps:
            present += step.install
            found.append((tuple(present), self.boundary + step.hold))
        return found


@known_options
def read_plan(path: str | Path, assembly: Assembly) -> Plan:
    """Read a plan and check it against its assembly.

    Parameters
    ----------
    path : str or Path
        A JSON file with `steps`, a list of `{"install": [...], "hold": [...]}`, and perhaps `boundary`,
        `never_installed`, `name` and `assembly`. Blocks are given by name; a number stands for the name of that number.
        `props` gives struts by name, `{"block": ..., "point": [x, y, z], "direction": [x, y, z]}`; steps set them up
        with `in` and take them away with `out`, lists of these names.
    assembly : Assembly
        The blocks.

    Returns
    -------
    Plan
        The plan.

    Raises
    ------
    InputError
        For a file that is no plan, and for what `check_plan` finds.
    """
    try:
        data = json_of(Path(path))
        steps = tuple(_step(step, k) for k, step in enumerate(data["steps"]))
        boundary, never = (check_names(key, data.get(key, ())) for key in ("boundary", "never_installed"))
        other = {k: v for k, v in data.items() if k not in KEYS}
        props = {str(name): prop_of(str(name), prop) for name, prop in data.get("props", {}).items()}
        name, of = str(data.get("name", Path(path).stem)), str(data.get("assembly", ""))
        plan = Plan(steps, boundary, never, name, of, other, props)
        check_plan(plan, assembly)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, InputError):
            raise InputError(str(error) if str(error).startswith(f"{path}: ") else f"{path}: {error}") from None
        raise InputError(f'{path}: a plan is JSON with "steps", a list of {{"install": [], "hold": []}}') from None
    return plan


def _step(step: dict[str, Any], number: int) -> Step:
    if unknown := set(step) - set(STEP_KEYS):
        raise InputError(f"step {number}: {no_such('key', min(unknown), STEP_KEYS)}")
    return Step(*(check_names(f"step {number}: {key}", step.get(key, ())) for key in ("install", "hold", "in", "out")))


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write a plan as JSON, one line a step.

    Parameters
    ----------
    plan : Plan
        The plan.
    path : str or Path
        The file.
    """
    head = {
        "name": plan.name, "assembly": plan.assembly, **plan.metadata,
        "boundary": plan.boundary, "never_installed": plan.never_installed,
    }  # fmt: skip
    if plan.props:
        head["props"] = {name: asdict(prop) for name, prop in plan.props.items()}
    top = json.dumps(head)[:-1]
    with written_whole(path) as place:
        place.write_text(top + ', "steps": [\n' + ",\n".join(json.dumps(_row(step)) for step in plan.steps) + "\n]}\n")


def _row(step: Step) -> dict[str, tuple[str, ...]]:
    """A step as it is written; props where there are some."""
    row = {"install": step.install, "hold": step.hold}
    return row | {key: names for key, names in (("in", step.props_in), ("out", step.props_out)) if names}


@known_options
def check_plan(plan: Plan, assembly: Assembly) -> None:
    """Check that a plan can be carried out, statics aside.

    Parameters
    ----------
    plan : Plan
        The plan.
    assembly : Assembly
        The blocks.

    Raises
    ------
    InputError
        One sentence with the step: for a block that is unknown, put in twice, held or let go before it is put in, held
        twice, or never put in; for a prop that is unknown, set up twice, taken away before it is set up, set up under a
        block that is not there, or not on its block. And for what is no plan.
    """
    if not isinstance(plan, Plan):
        raise InputError(f"plan is {plan!r}; it must be a Plan, as read_plan returns it")
    for where, blocks in (("the boundary", plan.boundary), ("never_installed", plan.never_installed)):
        _check_names(assembly, where, blocks)
    supports = [name for name, fixed in zip(assembly.names, assembly.support, strict=True) if fixed]
    since = dict.fromkeys([*supports, *plan.boundary], "the beginning")
    for k, step in enumerate(plan.steps):
        _check_names(assembly, f"step {k}", step.install + step.hold)
        for block in step.install:
            _check_put_in(plan, k, block, since)
            since.setdefault(block, f"step {k}")
        for block in step.hold:
            if block not in since:
                when = next((n for n in range(k, len(plan.steps)) if block in plan.steps[n].install), None)
                later = "is never put in" if when is None else f"is put in only at step {when}"
                raise InputError(f'step {k}: block "{block}" is held, but {later}')
        if len(set(step.hold)) < len(step.hold):
            raise InputError(f"step {k}: a block is held twice")
    _check_props(plan, assembly)
    missing = [name for name in assembly.names if name not in since and name not in plan.never_installed]
    if missing:
        more = f" (nor are {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise InputError(f'block "{missing[0]}" is never put in{more}; list it under "never_installed"')


def _check_names(assembly: Assembly, where: str, blocks: tuple[str, ...]) -> None:
    for block in blocks:
        if block not in assembly.names:
            raise InputError(f"{where}: {no_such('block', block, assembly.names)}")


def _check_put_in(plan: Plan, number: int, block: str, since: dict[str, str]) -> None:
    # The first step of a plan that goes on from a given state may list the boundary again.
    if block in since and not (number == 0 and since[block] == "the beginning"):
        raise InputError(f'step {number}: block "{block}" is put in, but stands since {since[block]}')
    if block in plan.never_installed:
        raise InputError(f'step {number}: block "{block}" is put in, but listed as never installed')


def _check_props(plan: Plan, assembly: Assembly) -> None:
    for name, prop in plan.props.items():
        _check_names(assembly, f'prop "{name}"', (prop.block,))
        step = next((f"step {k}: " for k, step in enumerate(plan.steps) if name in step.props_in), "")
        check_on_block(assembly, assembly.names.index(prop.block), prop, f'{step}prop "{name}"')
    standing = set[str]()
    for k, (step, (present, _)) in enumerate(zip(plan.steps, plan.states(), strict=True)):
        for name in (*step.props_in, *step.props_out):
            if name not in plan.props:
                raise InputError(f"step {k}: {no_such('prop', name, plan.props)}")
        for name in step.props_in:
            if name in standing:
                raise InputError(f'step {k}: prop "{name}" is set up, but stands already')
            block = plan.props[name].block
            if block not in present:
                raise InputError(f'step {k}: prop "{name}" is under block "{block}", which is not put in yet')
            standing.add(name)
        for name in step.props_out:
            if name not in standing:
                raise InputError(f'step {k}: prop "{name}" is taken away, but does not stand')
            standing.remove(name)


@dataclass(frozen=True, eq=False)
class PlanVerdict(Result):
    """The verdicts on the steps of a plan."""

    outcome: Outcome | Unfinished  #: stable when every step is, else that of the first step which is not
    plan: Plan  #: of one that was interrupted, the steps that were judged
    verdicts: tuple[Verdict, ...]  #: one a step, without props
    outcomes: tuple[Outcome, ...]  #: one a step, with its props
    friction: float
    #: some step is not proven to stand at the first, all are at the second
    least_friction: tuple[float, float] | None = None
    seconds: float = 0.0  #: process time of the verdicts, without the search for joints
    #: the least total force of the props of a step that is not proven to stand without them; None elsewhere
    falsework: tuple[Falsework | None, ...] = ()
    #: how far the ground may tilt towards +x, -x, +y and -y at each step, whichever is worst [deg] (`Whole.tilt`)
    tilt: tuple[float, ...] | None = None
    tilt_any_way: tuple[float, ...] | None = None  #: what each step is proven to stand in any direction [deg]
    missing: int = 0  #: steps that an interrupt has left unjudged

    @property
    def first_fall(self) -> int | None:
        """The number of the first step that is not stable; None where all are."""
        return next((k for k, outcome in enumerate(self.outcomes) if outcome is not Outcome.STABLE), None)

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a step.

        Returns
        -------
        list of dict
            With `step`, `install`, `present` (fixed blocks among them), `held`, `verdict`, `score` and `moving`; with
            tilts also `tilt` [deg], the worst of +x, -x, +y and -y, and `tilt_any_way` [deg], proven in any direction;
            where the plan has props also `props`, and `prop_force`, the force of each where their total is least [N] if
            they are needed.
        """
        found = []
        states, props = self.plan.states(), self.plan.standing_props()
        for k, (step, verdict) in enumerate(zip(self.plan.steps, self.verdicts, strict=True)):
            propped = self.falsework[k] if self.falsework else None
            stands = self.outcomes[k] is Outcome.STABLE
            row: dict[str, Any] = {
                "step": k,
                "install": list(step.install),
                "present": list(dict.fromkeys(states[k][0])),
                "held": list(step.hold),
                "verdict": self.outcomes[k].word,
                "score": 0.0 if stands and propped is not None else finite(verdict.score),
                "moving": [] if stands else [verdict.assembly.names[i] for i in verdict.moving],
            }
            if self.tilt is not None and self.tilt_any_way is not None:
                row |= {"tilt": self.tilt[k], "tilt_any_way": self.tilt_any_way[k]}
            if self.plan.props:
                row |= {"props": list(props[k]), "prop_force": propped and [finite(force) for force in propped.force]}
            found.append(row)
        return found

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With one row a step.
        """
        return {
            "outcome": self.outcome.word,
            "plan": self.plan.name,
            "friction": finite(self.friction),
            "held_at_most": self.plan.most_held,
            "first_fall": self.first_fall,
            "missing": self.missing,
            "seconds": self.seconds,
            "least_friction": self.least_friction and [finite(value) for value in self.least_friction],
            "steps": self.rows(),
        }

    def explain(self, limit: int = 5) -> str:
        """Return the table of the steps that do not stand, the first of them, and which stones move.

        Parameters
        ----------
        limit : int, optional
            Most blocks and props that are named.

        Returns
        -------
        str
            One fact a line.
        """
        rows = self.rows()
        bad = [row for row in rows if row["verdict"] != "stable"]
        each = 1e3 * self.seconds / max(len(rows), 1)
        steps = f"{len(rows)} of {len(rows) + self.missing} steps" if self.missing else f"{len(rows)} steps"
        head = f"{self.plan.name}: {steps}, at most {self.plan.most_held} held, friction {self.friction:g}"
        falls = f"{len(bad)} steps are not stable, the first is step {self.first_fall}."
        stand = "Each of these is stable." if self.missing else "Every step is stable."
        lines = [Unfinished.STOPPED.value] * bool(self.missing)
        lines += [f"{head}; {each:.1f} ms a step", falls if bad else stand]
        lines += [f"{'step':>5} {'verdict':<10} {'score':>9}  held; first to move"] if bad else []
        for row in bad:
            score = "-" if row["score"] is None else f"{row['score']:.3g}"
            what = f"{', '.join(row['held']) or 'nothing'}; {listed(row['moving'], limit)}"
            lines.append(f"{row['step']:>5} {row['verdict']:<10} {score:>9}  {what}")
        on = {k: one for k, one in enumerate(self.falsework) if one and self.outcomes[k] is Outcome.STABLE}
        if on:
            worst, most = max(on.items(), key=lambda item: item[1].total)
            line = f"{len(on)} steps stand on props; step {worst} needs most: at least {most.total:.6g} N in total,"
            lines.append(f"{line} then with up to {most.peak:.6g} N in one of them.")
        if self.plan.steps and not self.missing and (left := self.plan.standing_props()[-1]):
            line = f"{counted(len(left), 'prop')} never taken away: {listed(left, limit)}."
            lines.append(f"{line} The last step is judged with them.")
        if self.tilt and self.tilt_any_way:
            least, every = min(self.tilt), min(self.tilt_any_way)
            line = f"The ground may tilt by {least:.2f} deg towards +x, -x, +y and -y in any step, least at step"
            lines.append(f"{line} {self.tilt.index(least)}; in any other direction by {every:.2f} deg at least.")
        if self.least_friction is not None:
            low, high = self.least_friction
            below = f" (not proven at {low:.5f}): reserve {self.friction / high:.3f}" if high > 0 else ""
            line = f"Every step stands from a friction of {high:.5f}{below}."
            lines.append(line if high < np.inf else f"No friction up to {low:g} is proven to make every step stand.")
        return "\n".join(lines)


@known_options
def assess_plan(
    assembly: Assembly,
    plan: Plan,
    *,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    reserve: bool = False,
    tilt: bool = False,
    jobs: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PlanVerdict:
    """Judge every step of a plan.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    plan : Plan
        The plan; it is checked first.
    friction, flow, gap
        As of `assess_states`. A step that falls without its props is judged by limit analysis with them, whatever the
        flow; one that needs none of them keeps its verdict.
    reserve : bool, optional
        Whether the least friction at which every step stands is sought, too. It takes the time of a second run.
    tilt : bool, optional
        Whether the tilt of the ground at which each step falls is sought, too: towards +x, -x, +y and -y. Between
        these a step may fall earlier; what it is proven to stand in any direction is given beside it. Both searches
        have flow "associated" alone: what stands without dilatancy need not stand with more friction, and the loads
        that it carries are no convex set.
    jobs : int, optional
        As of `assess_states`; the search of the least friction is done by this process alone.
    progress : callable, optional
        Called with the steps judged and all of them. With it, and one process, a KeyboardInterrupt after the first step
        leaves the others out, and the outcome is "stopped" unless one of those before is not stable; after the last
        step it leaves out the least friction. Without it, it is raised.

    Returns
    -------
    PlanVerdict
        The verdicts, step by step.

    Raises
    ------
    InputError
        For a plan that cannot be carried out, and for a search with a flow or with props that it does not take.

    Examples
    --------
    >>> from blockstat import Assembly, Plan, Step, assess_plan, box
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.6, 0, 0), (0.4, 1, 1), name="low"),
    ...           box((-0.8, 0, 1), (0.2, 1, 2), name="high")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plan = Plan((Step(("low",), ("low",)), Step(), Step(("high",))))
    >>> assess_plan(assembly, plan).outcome.word
    'stable'
    """
    check_choice("flow", flow, FLOWS)
    if flow != "associated" and (reserve or tilt):
        raise InputError(f'{"reserve" if reserve else "tilt"}=True has flow "associated" alone, not "{flow}"')
    check_plan(plan, assembly)
    whole = Whole(assembly, friction=friction, gap=gap)
    states = [whole.state_of(*state, f"step {k}") for k, state in enumerate(plan.states())]
    if plan.props and (reserve or tilt):
        raise InputError(f"{'reserve' if reserve else 'tilt'}=True is for plans without props")
    judged = in_stretches(partial(_judged, whole, plan, flow, tilt), list(enumerate(states)), jobs, progress)
    verdicts, outcomes, falsework, tilts, any_way, seconds = zip(*judged, strict=True) if judged else ((),) * 6
    missing, done, least = len(states) - len(judged), replace(plan, steps=plan.steps[: len(judged)]), None
    every = Unfinished.STOPPED if missing else Outcome.STABLE
    worst = next((outcome for outcome in outcomes if outcome is not Outcome.STABLE), every)
    with suppress(*([] if progress is None else [KeyboardInterrupt])):
        least = least_friction(whole, states) if reserve and not missing else None
    given = whole.assembly.friction, least, sum(seconds), falsework, *((tilts, any_way) if tilt else ())
    return PlanVerdict(worst, done, verdicts, outcomes, *given, missing=missing)


def _judged(
    whole: Whole, plan: Plan, flow: str, tilt: bool, states: list[tuple[int, tuple[np.ndarray, np.ndarray]]]
) -> list[tuple[Verdict, Outcome, Falsework | None, float, float, float]]:
    """The verdict on each of some steps, its outcome and falsework on its props, its tilts and the process time."""
    props, found = [[plan.props[name] for name in names] for names in plan.standing_props()], []
    for step, state in states:
        began, searched = process_time(), whole.searching
        verdict = whole.assess(*state, flow=flow)
        outcome, falsework = on_props(whole, props[step], verdict, state)
        seconds = process_time() - began - (whole.searching - searched)
        found.append((verdict, outcome, falsework, *(whole.tilt(*state) if tilt else (np.nan, np.nan)), seconds))
    return found


def least_friction(whole: Whole, states: list[Any], until: float | None = None) -> tuple[float, float]:
    """Find the least coefficient of friction at which every state is stable.

    Parameters
    ----------
    whole : Whole
        The assembly; its joints have one coefficient of friction.
    states : list of (array of bool, array of bool)
        Masks as `Whole.state_of` gives them.
    until : float, optional
        When to stop, by the clock `time.monotonic` [s].

    Returns
    -------
    low, high : float
        Some state is not proven stable at the first, or the first is 0; all are at the second, which is inf if none
        helps.

    Raises
    ------
    InputError
        Where joint laws, or the interfaces, give joints a friction of their own.
    KeyboardInterrupt
        When the time is over.

    Notes
    -----
    What stands at some friction stands at any larger one. So a state is asked at the bound so far, and only one that
    does not stand there raises it.
    """
    if whole.assembly.joints or whole.interfaces.friction is not None:
        own = "this assembly has such laws" if whole.assembly.joints else "these interfaces have their own"
        raise InputError(f"the least friction is that of joints without laws of their own; {own}")
    low, high = 0.0, 0.0

    def stands(friction: float, state: Any) -> bool:
        if until is not None and monotonic() > until:
            raise KeyboardInterrupt
        return whole.at_friction(friction).assess(*state, score=False).outcome is Outcome.STABLE

    for state in states:
        if stands(high, state):
            continue
        if not stands(MOST_FRICTION, state):
            return MOST_FRICTION, float("inf")
        low, high = high, max(2.0 * high, 0.25)
        while not stands(high, state):
            low, high = high, 2.0 * high
        while high - low > FRICTION_STEP:
            middle = (low + high) / 2
            low, high = (low, middle) if stands(middle, state) else (middle, high)
    return low, high
