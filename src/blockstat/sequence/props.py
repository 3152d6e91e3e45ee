"""Falsework: the least forces in props under an unfinished assembly, and which blocks may be taken out.

A prop pushes and never pulls. With B the wrenches of unit forces in the props, the least total is the conic program::

    minimise sum r   subject to   A f + w + B r = 0,   f in K,   r >= 0,

and the least peak minimises t with r <= t instead.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse

from blockstat.analysis.decision import outcome_of
from blockstat.analysis.problem import Problem
from blockstat.analysis.rims import overlap_warnings, rim_warnings
from blockstat.analysis.verdict import Outcome, Verdict, unit_motion
from blockstat.assembly import block_indices
from blockstat.certificate.check import FORCE_LIMIT, force_errors, power
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, check_vector, known_options
from blockstat.loads import ON_BLOCK, up_of
from blockstat.program.penalty import PenaltyProgram
from blockstat.result import Result, Sentence
from blockstat.sequence.states import State, Whole
from blockstat.solve.clarabel import run
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: What a solution may leave unbalanced, of a block's load, to count as one.
BALANCED = 1e-6


@dataclass(frozen=True)
class Prop:
    """A strut that pushes on a block along a line.

    Raises
    ------
    InputError
        For a point or a direction that is not three finite numbers, and for a direction of no length.
    """

    block: str
    point: tuple[float, float, float]  #: where it pushes [m]
    direction: tuple[float, float, float]  #: along which it pushes on the block; a unit vector

    def __post_init__(self) -> None:
        check_vector(f'prop under "{self.block}": point', self.point, zero=True)
        check_vector(f'prop under "{self.block}": direction', self.direction)


def prop_of(name: str, given: Any) -> Prop:
    """Return a prop of a file.

    Parameters
    ----------
    name : str
        That the file gives it.
    given : object
        What the file says of it.

    Returns
    -------
    Prop
        The prop.

    Raises
    ------
    InputError
        For anything but its block, point and direction, and as `Prop` does.
    """
    try:
        assert set(given) == {"block", "point", "direction"}
        point, direction = (tuple(float(x) for x in given[key]) for key in ("point", "direction"))
    except (KeyError, TypeError, ValueError, AssertionError):
        form = '{"block": NAME, "point": [x, y, z], "direction": [x, y, z]}'
        raise InputError(f'prop "{name}" is {given!r}; it must read {form}') from None
    try:
        return Prop(str(given["block"]), point, direction)  # type: ignore[arg-type]
    except InputError as error:
        raise InputError(f'prop "{name}" {str(error).removeprefix("prop ")}') from None


class FalseworkOutcome(Sentence):
    """Whether props can hold a state."""

    HELD = "Held: forces in the props and the joints balance every block."
    NOT_HELD = "Not held: no forces in these props balance the blocks."
    UNDECIDED = "Undecided: these props are proven neither to hold the blocks nor not to."


#: What the forces in props say of a state that only these may hold.
OF_STATE = {
    FalseworkOutcome.HELD: Outcome.STABLE,
    FalseworkOutcome.NOT_HELD: Outcome.UNSTABLE,
    FalseworkOutcome.UNDECIDED: Outcome.UNDECIDED,
}


@dataclass(frozen=True, eq=False)
class Falsework(Result):
    """The least forces in props."""

    outcome: FalseworkOutcome
    props: tuple[Prop, ...]
    force: Floats  #: of each prop [N], shape (n_props,), none below zero; nan where none are found
    least: str  #: "total" or "peak", what was minimised
    #: by the dual of the program, no forces hold the state with a smaller total, or peak [N]; 0 where none is known
    bound: float
    residual: float  #: largest unbalanced force or moment / size of a block, relative to its load
    cone_violation: float  #: largest missing normal force of a contact point, relative to the lighter block's load

    @property
    def total(self) -> float:
        """Sum of the forces of the props [N]."""
        return float(self.force.sum())

    @property
    def peak(self) -> float:
        """Largest force of a prop [N]."""
        return float(self.force.max(initial=0.0))

    @property
    def by_block(self) -> dict[str, float]:
        """Sum of the forces of the props under each block [N], by its name."""
        found = dict[str, float]()
        for prop, force in zip(self.props, self.force.tolist(), strict=True):
            found[prop.block] = found.get(prop.block, 0.0) + force
        return found

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With the force under each block, which is the sum of its props.
        """
        forces = [{"block": block, "force": force} for block, force in self.by_block.items()]
        names = ("least", "total", "peak", "bound", "residual", "cone_violation")
        return {"outcome": self.outcome.word, **{n: getattr(self, n) for n in names}, "props": forces}

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.outcome is FalseworkOutcome.HELD:
            least = "not proven least" if self.bound == 0 < self.peak else f"least {self.least}"
            lines.append(f"Props: {self.total:.6g} N in total, {self.peak:.6g} N at most; {least}.")
        return "\n".join(lines)


@known_options
def hoists(assembly: Assembly, blocks: Iterable[str]) -> list[Prop]:
    """Return props that push blocks against gravity at their centroids, as ropes from above would pull.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    blocks : iterable of str
        The names of those that are hoisted.

    Returns
    -------
    list of Prop
        One a block.
    """
    up = up_of(assembly)
    chosen = assembly.blocks_named(blocks, "hoists")
    return [Prop(assembly.names[k], tuple(assembly.centroid[k].tolist()), tuple(up.tolist())) for k in chosen]


@known_options
def falsework(
    assembly: Assembly,
    state: State,
    props: Sequence[Prop],
    *,
    least: str = "total",
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Falsework:
    """Find the least forces in props that hold a state of an assembly.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    state : (sequence of str, sequence of str)
        Blocks that are present, and those among them that are held, as of `assess_states`.
    props : sequence of Prop
        Under blocks that are present and free.
    least : str, optional
        "total" minimises the sum of the forces, "peak" the largest of them.
    friction, gap, interfaces
        As of `assess_states`.

    Returns
    -------
    Falsework
        The forces, with the errors of equilibrium.

    Raises
    ------
    InputError
        For a prop under a block that is not present, or held.

    Examples
    --------
    A block on nothing needs its weight of 10 kN.

    >>> from blockstat import Assembly, box, falsework, hoists
    >>> blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, gravity=(0, 0, -10))
    >>> round(falsework(assembly, (["block"], []), hoists(assembly, ["block"])).total)
    10000
    """
    return held_by_props(assembly, state, props, least=least, friction=friction, gap=gap, interfaces=interfaces)[1]


def held_by_props(
    assembly: Assembly,
    state: State,
    props: Sequence[Prop],
    *,
    least: str,
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> tuple[Problem, Falsework, Floats]:
    """Find the least forces in props that hold a state, with the multipliers of equilibrium.

    Parameters
    ----------
    assembly, state, props, least, friction, gap, interfaces
        As of `falsework`.

    Returns
    -------
    problem : Problem
        The state without its props.
    found : Falsework
        The forces.
    twist : array of float, shape (6 n,)
        How the blocks follow when all props give way by one unit of length; a mechanism of the state with its props
        where these cannot hold it. In the units of the program.

    Raises
    ------
    InputError
        As `falsework` does.
    """
    check_choice("least", least, ("total", "peak"))
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    if assembly.joints:
        raise InputError("falsework is for dry joints; this assembly has joint laws")
    present, fixed = whole.state_of(*state, "falsework")
    free, props = present & ~fixed, tuple(props)
    blocks = block_indices(assembly.names, [prop.block for prop in props], "falsework").tolist()
    for prop, block in zip(props, blocks, strict=True):
        if not free[block]:
            raise InputError(f'falsework: block "{prop.block}" is held or not present; props stand under free blocks')
        check_on_block(assembly, block, prop, "falsework: the prop")
    problem = whole.propped(free, present)
    return problem, *_least(problem, props, least)


def check_on_block(assembly: Assembly, block: int, prop: Prop, called: str) -> None:
    """Check that a prop pushes on its block.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    block : int
        The number of the block.
    prop : Prop
        The prop.
    called : str
        How a message begins.

    Raises
    ------
    InputError
        For a point beyond the box of the block.
    """
    place, low, high = np.asarray(prop.point, dtype=float), assembly.bounds[0][block], assembly.bounds[1][block]
    # The whole box: the centre of a warped face or of a notched one lies in it, and so does a hoist's centroid.
    slack = ON_BLOCK * float(assembly.size[block])
    if not ((low - slack <= place) & (place <= high + slack)).all():
        raise InputError(
            f'{called} at {place.tolist()} is not on block "{prop.block}", which is from {low.round(6).tolist()} '
            f"to {high.round(6).tolist()}"
        )


def _least(problem: Problem, props: tuple[Prop, ...], least: str) -> tuple[Falsework, Floats]:
    """Solve for the least total or peak: the forces of the props with their errors, and the multipliers."""
    program = problem.program
    if program is None:
        return Falsework(FalseworkOutcome.HELD, props, np.zeros(len(props)), least, 0.0, 0.0, 0.0), np.empty(0)
    pushes = pushes_of(problem, props)
    m, n = len(program.friction), len(props)
    push, twist, bound, residual, violation = np.full(n, np.nan), program.load, 0.0, 1.0, 0.0
    if m + n:  # else nothing touches anything
        x, twist, bound = _solved(program, pushes, n, least == "peak")
        force, push = x[: 3 * m], np.maximum(x[3 * m : 3 * m + n], 0.0)
        # Tangents without friction are zero but for rounding.
        force.reshape(-1, 3)[program.friction == 0, 1:] = 0.0
        # The load of a block that hangs in its prop is nothing: errors are compared with the weights.
        unbalanced = (program.matrix @ force + program.load + pushes @ push).reshape(-1, 6)
        residual = float((np.linalg.norm(unbalanced, axis=1) / _loads(program)).max(initial=0.0))
        violation = max(-force_errors(program, force.reshape(-1, 3)).slack, 0.0)
    outcome = FalseworkOutcome.HELD
    if not max(residual, violation) <= BALANCED:
        falls = falls_on_props(problem, props, twist)
        outcome, bound = (FalseworkOutcome.NOT_HELD, np.inf) if falls else (FalseworkOutcome.UNDECIDED, 0.0)
        push = np.full(n, np.nan)
    unit = program.force_unit
    return Falsework(outcome, props, push * unit, least, bound * unit, residual, violation), twist


def _loads(program: PenaltyProgram) -> Floats:
    """The load of each block, 1 where that is nothing."""
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    return np.where(own > 0, own, 1.0)


def _solved(program: PenaltyProgram, pushes: sparse.csc_array, n: int, peak: bool) -> tuple[Floats, Floats, float]:
    """The unknowns f and r, the twists that are the multipliers of equilibrium, and the bound of the dual, else 0.

    The rows of each block are divided by its load, forces between two by that of the lighter one, and the cost by the
    geometric mean of all loads. A pebble is balanced as well as the stone that it lies on, however heavy that is.
    """
    clarabel: Any = importlib.import_module("clarabel")
    m, last, own = len(program.friction), int(peak), _loads(program)
    mean = float(np.exp(np.log(own).mean()))
    row, lighter = np.repeat(own, 6), np.append(own, np.inf)[program.point_blocks].min(axis=1)
    on = own[pushes.indices[pushes.indptr[:-1]] // 6]  # the load of the block on each prop
    column = np.concatenate([np.repeat(lighter, 3), on, np.full(last, mean)])
    cost = np.concatenate([np.zeros(3 * m), np.full(n, 1.0 - last), np.ones(last)]) * column / mean
    slip = np.isfinite(program.friction)
    smooth = np.flatnonzero(program.friction == 0)
    heads = np.where(slip & (program.friction > 0), program.friction, 1.0)
    size = np.column_stack([heads, slip, slip]).reshape(-1)  # joints that cannot slip have free tangents
    tangents = np.concatenate([3 * smooth + 1, 3 * smooth + 2])  # those without friction have none
    none = sparse.csr_array(sparse.eye_array(3 * m))[tangents]
    balance = sparse.hstack([program.matrix, pushes, sparse.csc_array((len(row), last))])
    rows = [
        [sparse.diags_array(1.0 / row) @ balance @ sparse.diags_array(column)],
        [none, sparse.csc_array((len(tangents), n + last))],
        [sparse.diags_array(-size), sparse.csc_array((3 * m, n + last))],
        [sparse.csc_array((n, 3 * m)), -sparse.eye_array(n), sparse.csc_array((n, last))],
    ]
    if peak:
        rows.append([sparse.csc_array((n, 3 * m)), sparse.diags_array(on / mean), sparse.csc_array(-np.ones((n, 1)))])
    matrix = sparse.csc_array(sparse.vstack([sparse.hstack(one) for one in rows]))
    half = n * (1 + last)
    cones: list[Any] = [clarabel.ZeroConeT(len(row) + len(tangents)), *[clarabel.SecondOrderConeT(3)] * m]
    cones += [clarabel.NonnegativeConeT(half)] if half else []
    right = np.concatenate([-program.load / row, np.zeros(len(tangents) + 3 * m + half)])
    answer = run(sparse.csc_array((len(cost), len(cost))), cost, matrix, right, cones)
    optimal = str(answer.status) in ("Solved", "AlmostSolved")
    bound = mean * float(answer.obj_val_dual) if optimal else 0.0
    return np.array(answer.x) * column, np.array(answer.z)[: len(row)] * mean / row, bound


def pushes_of(problem: Problem, props: Sequence[Prop]) -> sparse.csc_array:
    """Return B, the wrenches of unit forces in the props.

    Parameters
    ----------
    problem : Problem
        The state, with a program.
    props : sequence of Prop
        The props.

    Returns
    -------
    sparse array of float, shape (6 n, n_props)
        In the units of the program.
    """
    assert problem.program is not None
    assembly, n, rows = problem.assembly, len(props), len(problem.eq.blocks)
    block = block_indices(assembly.names, [prop.block for prop in props], "props")
    way = np.array([prop.direction for prop in props], dtype=float).reshape(n, 3)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    arm = np.array([prop.point for prop in props], dtype=float).reshape(n, 3) - assembly.centroid[block]
    wrench = np.hstack([way, np.cross(arm, way) / problem.program.length_unit])
    row = np.full(assembly.n_blocks, -1)
    row[problem.eq.blocks] = np.arange(rows)
    on = np.flatnonzero(row[block] >= 0)
    place = 6 * np.repeat(row[block[on]], 6) + np.tile(np.arange(6), len(on))
    return sparse.csc_array((wrench[on].reshape(-1), (place, np.repeat(on, 6))), shape=(6 * rows, n))


def falls_on_props(problem: Problem, props: Sequence[Prop], twist: Floats) -> bool:
    """Return whether a twist is a mechanism of a state that neither joints nor props resist.

    Parameters
    ----------
    problem : Problem
        The state.
    props : sequence of Prop
        Its props.
    twist : array of float, shape (6 n,)
        In the units of the program, as `held_by_props` gives it.

    Returns
    -------
    bool
        True where it would take forces beyond `FORCE_LIMIT` weights to resist it, as of a verdict, and it drives no
        blocks into each other where they overlap or touch without a unique normal.
    """
    size = np.abs(twist).max(initial=0.0)
    if problem.program is None or not size > 0:
        return False
    unit = twist / size
    work, closing = power(problem.program, unit)
    pushed = -float((pushes_of(problem, props).T @ unit).min(initial=0.0))
    if not work > max(closing, pushed) * FORCE_LIMIT * problem.program.total_load:
        return False
    motion = unit_motion(problem.assembly, problem.to_blocks(unit))
    return not (overlap_warnings(problem, motion) or rim_warnings(problem, motion))


def on_props(
    whole: Whole, props: Sequence[Prop], verdict: Verdict, state: tuple[np.ndarray, np.ndarray]
) -> tuple[Outcome, Falsework | None]:
    """Return the outcome of a state with its props.

    Parameters
    ----------
    whole : Whole
        The assembly.
    props : sequence of Prop
        What stands.
    verdict : Verdict
        On the state without props.
    state : (array of bool, array of bool)
        Masks as `Whole.state_of` gives them.

    Returns
    -------
    outcome : Outcome
        Stable where some forces in the props hold it. What needs no props, such as a state that stands only by
        self-stress, keeps its verdict. Undecided where they carry no more than what the forces leave unbalanced.
    found : Falsework or None
        Their least total where no forces without them are proven to hold it; 0 in the props of held blocks.
    """
    names, (present, fixed) = whole.assembly.names, state
    there, held = ([name for name, on in zip(names, mask, strict=True) if on] for mask in (present, fixed))
    loaded = np.array([prop.block not in held for prop in props], dtype=bool)  # a held block loads no prop
    if Outcome.STABLE in (verdict.outcome, outcome_of(verdict.certificate)) or not loaded.any():
        return verdict.outcome, None
    own = [prop for prop, on in zip(props, loaded, strict=True) if on]
    options: dict[str, Any] = {"interfaces": whole.interfaces, "gap": whole.gap, "least": "total"}
    problem, found, _ = held_by_props(whole.assembly, (there, held), own, **options)
    outcome = OF_STATE[found.outcome]
    left = max(found.residual, found.cone_violation) * np.linalg.norm(problem.load[problem.eq.blocks, :3], axis=1).sum()
    if found.total <= left:
        outcome = Outcome.UNDECIDED
    force = np.zeros(len(props))
    force[loaded] = found.force
    return outcome, replace(found, props=tuple(props), force=force)
