"""Search the space of a scene's parameters: statics prune, a dynamic verifier confirms.

- "paper": the paper's procedure. Numbers start at their largest value and go down step by step, presences are tried
  without and then with; every candidate is simulated.
- "pruned": the same answer by asking in another order (see `blockstat.design_search.walk`). A design without any
admissible force field cannot stand, so pruning it is safe, and the far slower dynamic verifier sees few of the rest.
- "gradient": the lightest design with a required reserve, continuous parameters by exact derivatives.
- "pareto": the front of volume against reserve.
- "robust": the lightest design with a required reserve in the worst case of imperfections, or with a probability of
  failure below a target.

A design is offered only if both agree: statics do not exclude it and the verifier sees it stand.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from math import inf
from pathlib import Path
from typing import Any

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.verdict import Verdict
from blockstat.assembly import Assembly
from blockstat.contact.tolerance import GAP, stated_length
from blockstat.design_search.candidate import BY_STATICS, ERROR, PRUNED, UNASKED, Candidate, SearchResult
from blockstat.design_search.descent import front, lightest
from blockstat.design_search.evaluator import Callbacks, Dynamic, Evaluator
from blockstat.design_search.history import History, assembly_digest, digest
from blockstat.design_search.margin import Margin
from blockstat.design_search.shared_joints import SharedJoints
from blockstat.design_search.space import Space, Values, is_discrete, space_of
from blockstat.design_search.target import Assured, FailureTarget, lightest_assured
from blockstat.design_search.walk import WALKS, by_volume, expected
from blockstat.errors import InputError, check_assembly, check_choice, check_count, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.spec import Scene, build
from blockstat.system.old_names import renamed_options
from blockstat.system.writing import check_writable

__all__ = [
    "BY_STATICS", "ERROR", "PRUNED", "STRATEGIES", "UNASKED", "Candidate", "Dynamic", "FailureTarget", "Margin",
    "SearchResult", "Space", "search", "space_of",
]  # fmt: skip

STRATEGIES = ("paper", "pruned", "gradient", "pareto", "robust")
OVER = ("line", "grid")
MARGIN = "Margin((0, 1, 0), 0.1)"  #: what one looks like: 0.1 g along y
FIRST = 100  #: designs that are tried for one that can be built, which tells what designs are put under


@renamed_options(ahead="speculative")
@known_options
def search(
    building: Scene,
    *,
    verify: Callable[[Assembly], Dynamic] | None,
    static: Callable[..., Verdict] = assess,
    strategy: str = "pruned",
    over: str = "line",
    names: Sequence[str] | str | None = None,
    margin: Margin | None = None,
    snap: bool = False,
    points: int = 6,
    imperfections: Imperfections | None = None,
    target: FailureTarget | None = None,
    gap: float | str = GAP,
    under: Callable[[Assembly], Assembly] | None = None,
    memory: Memory | None = None,
    begin: Callable[[Assembly], None] | None = None,
    speculative: int = 2,
    history: str | Path | None = None,
    progress: Callable[[int, int, Candidate], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    remark: Callable[[Verdict, Any], str] | None = None,
    conditions: str = "",
) -> SearchResult:
    """Find the design that needs least and stands.

    Parameters
    ----------
    building : Scene
        The scene with its ranges.
    verify : callable or None
        Evaluates an assembly by dynamics; called only for designs that statics allow (strategy "paper": for all). One
        with an option `interfaces`, such as `dynsim.verify`, is handed those that statics found. None: statics alone
        decide.
    static : callable, optional
        Evaluates an assembly by forces; a design that it calls unstable is pruned. "gradient", "pareto" and "robust",
        which measure the reserve, ask it of each design before they offer it. With `imperfections` it is called with
        that option too.
    strategy : {"pruned", "paper", "gradient", "pareto", "robust"}, optional
        See the module.
    over : {"line", "grid"}, optional
        "line": each parameter in its turn down to its smallest value that stands. "grid": every combination, of which
        the lightest that stands is the answer. For "paper" and "pruned"; the others know "line" alone.
    names : str or sequence of str, optional
        The parameters to move, in order; by default all ranges of the scene.
    margin : Margin, optional
        Reserve that "gradient", "pareto" and "robust" ask for; by default that the design stands.
    snap : bool, optional
        "gradient", and "robust" without a target, offer only designs on the steps of the ranges.
    points : int, optional
        Number of reserves of "pareto".
    imperfections : Imperfections, optional
        Statics judge the worst case of these, and the reserve is that of the worst case; dynamics see the drawing.
    target : FailureTarget, optional
        Probability of failure that "robust" stays below, in place of a margin.
    gap : float or str, optional
        Largest gap of a joint, as in `assess`. Another than the default is handed to `static`; give it to
        `verify`, too.
    under : callable, optional
        Puts each design under another friction or gravity before it is evaluated.
    memory : Memory, optional
        The one that `static` hands to `assess`; after an interruption it is filled as it was.
    begin : callable, optional
        Told of designs that `verify` will probably be asked about, so that it can run them side by side ("pruned"
        only); the history is the same.
    speculative : int, optional
        `begin` is told of so many designs at a time.
    history : str or Path, optional
        CSV file that gets each row as soon as it is known. Rows found there are not computed again, so an interrupted
        search goes on where it stopped.
    progress : callable, optional
        Called with the number of designs evaluated, the number expected at most, and the last candidate.
    cancel : callable, optional
        Asked before each verdict. True ends the search as a KeyboardInterrupt does: what is known is returned.
    remark : callable, optional
        Gives the note of a candidate from its two verdicts.
    conditions : str, optional
        What else the verdicts depend on, as thresholds of `verify` or another `static`; a history under others is not
        taken up. What `under` makes of the first design that can be built is known: blocks, supports, densities,
        friction, gravity, joint laws and ties.

    Returns
    -------
    SearchResult

    Raises
    ------
    InputError
        For what is no scene or has no ranges, an unknown parameter or option, one that the strategy does not have or
        of another kind, a number of points below 1, or a history file of another search or where none can be written.

    Examples
    --------
    >>> from blockstat import scene_from, search
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
    >>> search(scene_from(hut), verify=None).best_parameters
    {'wall.thickness': 0.2}
    """
    _check_kinds(
        {"margin": (margin, Margin), "imperfections": (imperfections, Imperfections), "target": (target, FailureTarget)}
    )
    check_strategy(strategy, over, margin, snap, target)
    check_count("points", points)
    stated_length(gap)
    _check_robust(strategy, margin, imperfections, target)
    space = space_of(building, names)
    margin, target = replace(margin or Margin(), gap=gap), target and replace(target, gap=gap)
    if gap != GAP:
        static, conditions = partial(static, gap=gap), f"{conditions} gap {gap}"
    if imperfections is not None:
        margin, static = replace(margin, imperfections=imperfections), partial(static, imperfections=imperfections)
    if strategy in ("gradient", "pareto", "robust"):
        conditions = f"{conditions} {margin}{target or ''}"
    elif imperfections is not None:
        conditions = f"{conditions} {imperfections}"
    if history is not None:
        check_writable(Path(history))
        conditions += _put_under(under, space)
    log = History(Path(history), space.names, digest(space.scene, conditions)) if history is not None else None
    joints = SharedJoints()
    # Joints without their edges are for statics alone.
    static, verify = static if imperfections else joints.kept(static), verify and joints.handed(verify)
    begin = begin and joints.handed(begin)
    callbacks = Callbacks(static, verify, begin, speculative, under or _as_it_is, memory, remark, progress, cancel)
    evaluator = Evaluator(space, callbacks, log)
    _check_friction(evaluator, margin)
    best: Values | None = None
    assured: Assured | None = None
    found: tuple[Candidate, ...] = ()
    finished = True
    try:
        if strategy == "pareto":
            found = front(evaluator, margin, points)
            best = found[0].parameters if found else None
        elif target is not None:
            best, assured = lightest_assured(evaluator, target)
        elif strategy in ("gradient", "robust"):
            best = lightest(evaluator, margin, snap=snap)
        else:
            evaluator.expected = expected(evaluator, over)
            best = WALKS[strategy, over](evaluator)
    except KeyboardInterrupt:
        # What was simulated for a target has no more than a chance to meet it.
        finished, best = False, None if target else _lightest_so_far(evaluator, margin.least, snap=snap)
    counts = strategy in ("paper", "pruned") or all(map(is_discrete, space.ranges.values()))
    return replace(_result(evaluator, best, found, finished), assured=assured, unexamined=_left(evaluator, counts))


def _left(evaluator: Evaluator, counts: bool) -> float:
    """How many designs of the space were not examined, if its designs can be counted."""
    return max(evaluator.space.size - len(evaluator.rows) - evaluator.unbuilt, 0) if counts else inf


def _put_under(under: Callable[[Assembly], Assembly] | None, space: Space) -> str:
    """What designs are put under, as the first that can be built has it, so that no history under another is taken."""
    if under is None:
        return ""
    for values in chain([{}], islice(space.grid(), FIRST)):
        try:
            first = under(build(space.at(values)))
        except InputError:  # the search tells of designs that cannot be built
            continue
        check_assembly("what under gives", first)
        return f" under {assembly_digest(first)}"
    return ""


def check_strategy(
    strategy: str, over: str, margin: Margin | None, snap: bool, target: FailureTarget | None = None
) -> None:
    """Raise InputError unless options of `search` exist and go together.

    Parameters
    ----------
    strategy, over, margin, snap, target
        As in `search`.

    Raises
    ------
    InputError
        Naming the option.
    """
    check_choice("strategy", strategy, STRATEGIES)
    check_choice("over", over, OVER)
    walks = strategy in ("paper", "pruned")
    snaps = strategy == "gradient" or (strategy == "robust" and target is None)
    for refused, words in (
        (walks and margin is not None, 'margin is for strategies "gradient", "pareto" and "robust"'),
        (snap and not snaps, 'snap is for strategies "gradient" and, without a target, "robust"'),
        (over != "line" and not walks, f'over "{over}" is for strategies "paper" and "pruned"'),
    ):
        if refused:
            raise InputError(f'{words}; strategy is "{strategy}"')


def _check_kinds(options: dict[str, tuple[Any, type]]) -> None:
    """Refuse options that are of another kind than theirs."""
    for name, (given, kind) in options.items():
        if given is not None and not isinstance(given, kind):
            words = f"blockstat.{kind.__name__}" + f", such as {MARGIN}" * (kind is Margin)
            raise InputError(f"{name} is {given!r}; it must be a {words}")


def _check_robust(
    strategy: str, margin: Margin | None, imperfections: Imperfections | None, target: FailureTarget | None
) -> None:
    """Refuse options that do not go together."""
    if target is not None and (strategy != "robust" or margin is not None or imperfections is not None):
        raise InputError('a target is for strategy "robust", without a margin and without imperfections')
    robust = target is not None or imperfections is not None or (margin is not None and margin.imperfections)
    if strategy == "robust" and not robust:
        raise InputError('strategy "robust" needs imperfections, or a target')


def _check_friction(evaluator: Evaluator, margin: Margin) -> None:
    """Refuse a margin that no design of the scene can be asked for, by its largest design."""
    if margin.friction == 1.0:
        return
    try:
        largest = evaluator.make(evaluator.space.start)
    except InputError:
        return  # its row in the history says why it cannot be built; others may be
    margin.applied(largest)


def _result(evaluator: Evaluator, best: Values | None, found: tuple[Candidate, ...], finished: bool) -> SearchResult:
    return SearchResult(
        building=evaluator.space.scene,
        best=evaluator.space.at(best) if best is not None else None,
        best_parameters=best,
        history=tuple(evaluator.rows.values()),
        confirmation=evaluator.standing.get(tuple(best.values())) if best is not None else None,
        finished=finished,
        front=found,
        unbuilt=evaluator.unbuilt,
    )


def _as_it_is(assembly: Assembly) -> Assembly:
    return assembly


def _lightest_so_far(evaluator: Evaluator, least: float, *, snap: bool = False) -> Values | None:
    """The lightest design that stands and has the reserve, unless `static` rules it out: no other is judged then."""
    space = evaluator.space
    standing = [
        candidate
        for candidate in evaluator.rows.values()
        if candidate.stands and (candidate.reserve is None or candidate.reserve >= least)
        if not snap or space.is_on_steps(candidate.parameters)
    ]
    if not standing:
        return None
    best = by_volume(standing, [candidate.volume or 0.0 for candidate in standing])[0].parameters
    return best if evaluator.offer(best).stands else None
