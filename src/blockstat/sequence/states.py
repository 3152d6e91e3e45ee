"""Verdicts on states of one assembly: some blocks are present, some of these are held, the others are not there yet.

The joints of the whole assembly are found once. A state takes those of its blocks, and the columns of its equilibrium
are the same columns. Supports and held blocks have no rows. The forces of an earlier state are tried on the next one:
where a block was put in and is held, they still balance. Nothing is assumed; each state has its own certificate.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS, judged
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.decision import outcome_of
from blockstat.analysis.limit_load import limit_load
from blockstat.analysis.problem import Problem, pose, unheeded
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.assembly import check_supports
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.overlap.penetration import overlaps
from blockstat.contact.overlap.searched import searched_joints
from blockstat.contact.point_law import joint_friction
from blockstat.contact.unresolved import Unresolved, unresolved_contacts
from blockstat.errors import InputError, InputWarning, check_choice, check_names, known_options, no_such
from blockstat.loads import horizontal
from blockstat.program.equilibrium import Columns, Equilibrium, equilibrium, split_floating, weight
from blockstat.program.penalty import PenaltyProgram, penalty_program
from blockstat.program.planar import find_plane
from blockstat.sequence.nearby import AT_REST, nearby_evidence, nearby_optimum, unbalanced
from blockstat.solve.answer import Answer, Status
from blockstat.system.workers import in_stretches
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A state as users give it: names of the blocks that are present, and of those that are held.
State = tuple[Sequence[str], Sequence[str]]
#: Force fields and mechanisms of earlier states that are tried on the next one.
FIELDS, MECHANISMS = 2, 4
#: Blocks from which earlier forces are tried before a solve, and from which forces are looked for around a change.
FEW, MANY = 12, 120


@known_options
def assess_states(
    assembly: Assembly,
    states: Iterable[State],
    *,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    score: bool = True,
    jobs: int | None = None,
) -> list[Verdict]:
    """Judge states of an assembly in which some blocks are present and some of these are held.

    Parameters
    ----------
    assembly : Assembly
        All blocks. Its supports are present and fixed in every state.
    states : iterable of (sequence of str, sequence of str)
        The names of the blocks that are present, and of those among them that are held. Supports may be left out. A
        held block takes any force, as a support does.
    friction : float, optional
        Replaces the assembly's coefficient of friction, and that of `interfaces` with a friction of their own.
    flow : str, optional
        "associated" or "coulomb", as of `assess`.
    gap : float or str, optional
        Tolerance of the joint search, as of `find_interfaces`.
    interfaces : Interfaces, optional
        Use these joints of the whole assembly instead of searching.
    score : bool, optional
        False ends at the first mechanism found: a state that falls then has no score (nan).
    jobs : int, optional
        Processes side by side, by default one. Under `joblib.parallel_config(backend="dask")`, or another backend,
        states go to all of its workers instead. Each gets a stretch of them at a time: neighbours share their
        evidence.

    Returns
    -------
    list of Verdict
        One a state. In its assembly all that is fixed or absent is a support; its interfaces are those of the state.

    Raises
    ------
    InputError
        For a block that is unknown, or held and not present; the message gives the number of the state, from 0. Also
        for fewer than one process.

    Notes
    -----
    Whether a stable state is balanced without reserve is not asked (`Verdict.neutral` is empty).

    Examples
    --------
    A cube half on the ground needs no hand, and one that juts out further falls unless it is held.

    >>> from blockstat import Assembly, assess_states, box
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.6, 0, 0), (0.4, 1, 1), name="low"),
    ...           box((0, 0, 1), (1, 1, 2), name="high")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> states = [(["low"], []), (["low", "high"], ["high"]), (["low", "high"], [])]
    >>> [verdict.outcome.word for verdict in assess_states(assembly, states)]
    ['stable', 'stable', 'unstable']
    """
    check_choice("flow", flow, FLOWS)
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    named = [whole.state_of(present, held, f"state {k}") for k, (present, held) in enumerate(states)]
    return in_stretches(partial(whole.assess_all, flow=flow, score=score), named, jobs)


class Whole:
    """An assembly with all that its states share: joints, columns of equilibrium, and evidence of earlier states.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    friction : float, optional
        Replaces the assembly's coefficient of friction, and that of `interfaces` with a friction of their own.
    gap : float or str, optional
        Tolerance of the joint search.
    interfaces : Interfaces, optional
        Its joints, instead of searching.

    Warns
    -----
    InputWarning
        Where joint laws keep a friction of their own beside the one that is asked for.
    """

    def __init__(
        self,
        assembly: Assembly,
        *,
        friction: float | None = None,
        gap: float | str = GAP,
        interfaces: Interfaces | None = None,
    ) -> None:
        assembly = assembly if friction is None else assembly.with_(friction=friction)
        check_supports(assembly)
        if assembly.ties:
            raise InputError(f'"{assembly.name}" has ties; sequences are judged without ties')
        if interfaces is None:
            interfaces, overlapping, _ = searched_joints(assembly, gap)
        else:
            overlapping, _ = overlaps(assembly, gap=gap)
        if friction is not None:
            interfaces = replace(interfaces, friction=None)
            for text in unheeded(assembly, interfaces):
                warnings.warn(InputWarning(text), stacklevel=4)
        self.assembly, self.interfaces, self.gap = assembly, interfaces, gap
        self.load = weight(assembly)
        everything = np.arange(assembly.n_blocks), np.arange(interfaces.n_points)
        self._columns = equilibrium(assembly, interfaces, self.load, *everything)
        self._friction = joint_friction(assembly, interfaces)[interfaces.point_interface]
        self._overlapping = overlapping
        self._number = {name: k for k, name in enumerate(assembly.names)}
        self.evidence = Evidence(assembly.n_blocks, interfaces.n_points)
        self.searching = 0.0  #: process time of searches for contacts since then [s]

    @cached_property
    def touching(self) -> Ints:
        """Pairs of blocks that joints, rims or overlaps connect, shape (n, 2)."""
        rims = self.interfaces.rims
        kinds = [self.interfaces.pair, self._overlapping] + ([] if rims is None else [rims])
        return np.unique(np.concatenate(kinds).reshape(-1, 2), axis=0)

    @cached_property
    def unresolved(self) -> Unresolved:
        """The contacts of the whole without a unique normal; they are looked for where a state falls."""
        began = process_time()
        found = unresolved_contacts(self.assembly, self.interfaces, gap=self.gap)
        self.searching += process_time() - began
        return found

    def at_friction(self, friction: float) -> Whole:
        """Return the same assembly with another friction of all joints without laws, as `friction` of the class gives.

        Parameters
        ----------
        friction : float
            Coefficient of friction; it replaces one of the interfaces' own, too.

        Returns
        -------
        Whole
            It shares the joints and the evidence.
        """
        changed = copy.copy(self)
        changed.assembly = _with(self.assembly, friction=friction)
        changed.interfaces = replace(self.interfaces, friction=None)
        changed._friction = joint_friction(changed.assembly, changed.interfaces)[self.interfaces.point_interface]
        return changed

    def state_of(self, present: Iterable[str], held: Iterable[str], where: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the masks of a state given by names.

        Parameters
        ----------
        present, held : iterable of str
            Names of blocks.
        where : str
            What the message of an error begins with.

        Returns
        -------
        present, fixed : array of bool, shape (n_blocks,)
            Which blocks are there, supports among them, and which cannot move.

        Raises
        ------
        InputError
            For an unknown name, or a block that is held and not present.
        """
        there = self.assembly.support.copy()
        there[self._numbers(present, where)] = True
        hands = self._numbers(held, where)
        missing = hands[~there[hands]]
        if len(missing):
            raise InputError(f'{where}: block "{self.assembly.names[missing[0]]}" is held but not present')
        fixed = self.assembly.support.copy()
        fixed[hands] = True
        return there, fixed

    def _numbers(self, names: Iterable[str], where: str) -> Ints:
        names = check_names(where, names)
        unknown = [name for name in names if name not in self._number]
        if unknown:
            raise InputError(f"{where}: {no_such('block', unknown[0], self._number)}")
        return np.array([self._number[name] for name in names], dtype=np.int64)

    def assess(
        self,
        present: np.ndarray,
        fixed: np.ndarray,
        *,
        flow: str = "associated",
        score: bool = True,
        stands: bool = False,
        tightnesses: int = 0,
    ) -> Verdict:
        """Return the verdict on one state.

        Parameters
        ----------
        present, fixed : array of bool, shape (n_blocks,)
            Which blocks are there, and which of them cannot move.
        flow, score
            As in `assess_states`.
        stands
            Whether the state is likely to stand; it makes no difference but in time.
        tightnesses
            As in `blockstat.assess`.

        Returns
        -------
        Verdict
            The certified verdict.
        """
        problem, points = self.problem(present & ~fixed, present)
        self.evidence.state(problem, points, score=score, stands=stands)
        guess = self.evidence.guess()
        options: dict[str, Any] = {"flow": flow, "score": score, "tightnesses": tightnesses, "reserve": False}
        return judged(problem, memory=self.evidence, guess=guess, **options)

    def falls_by(self, motion: Floats, present: np.ndarray, fixed: np.ndarray) -> bool:
        """Return whether a motion proves that a state falls.

        Parameters
        ----------
        motion : array of float, shape (n_blocks, 6)
            Twists of the blocks, of any size.
        present, fixed : array of bool, shape (n_blocks,)
            As of `assess`.

        Returns
        -------
        bool
            Whether the independent check of it as a mechanism says so.
        """
        problem, _ = self.problem(present & ~fixed, present)
        program = problem.program
        if program is None:
            return False
        twist = (motion[problem.eq.blocks] * np.repeat([1.0, program.length_unit], 3)).reshape(-1)
        found = _recalled(program, np.zeros((len(program.friction), 3)), twist, "mechanism")
        return outcome_of(found.certificate) is Outcome.UNSTABLE

    def assess_all(self, states: Iterable[tuple[np.ndarray, np.ndarray]], flow: str, score: bool) -> list[Verdict]:
        """Return the verdicts on states, each with the evidence of those before it.

        Parameters
        ----------
        states : iterable of (array of bool, array of bool)
            As `state_of` gives them.
        flow, score
            As in `assess_states`.

        Returns
        -------
        list of Verdict
            One a state.
        """
        return [self.assess(present, fixed, flow=flow, score=score) for present, fixed in states]

    def tilt(self, present: np.ndarray, fixed: np.ndarray) -> tuple[float, float]:
        """Return how far the ground may tilt while a state stands, in four directions and in any.

        Parameters
        ----------
        present, fixed : array of bool, shape (n_blocks,)
            As of `assess`.

        Returns
        -------
        four : float
            Proven tilt [deg] that the state stands towards +x, -x, +y and -y (their horizontal parts), whichever is
            worst; 0 where the state falls as it is, 90 where nothing is free.
        every : float
            Proven tilt [deg] that it stands in any direction, not larger. It may stand more.

        Notes
        -----
        A tilt turns gravity, and dry joints know its direction only: the tangent of the angle is the horizontal load
        that the state carries, as a share of its weight. The horizontal loads that are carried form a convex set. So
        the four limit loads are the corners of a quadrilateral of loads that are carried, and the distance of its
        sides from the origin is one that is carried in every direction.
        """
        problem, _ = self.problem(present & ~fixed, present)
        if not len(problem.assembly.free):
            return 90.0, 90.0
        if len(problem.floating):
            return 0.0, 0.0
        first, second = horizontal(self.assembly)
        ways = (first, second, -first, -second)
        found = [limit_load(problem.assembly, way, interfaces=problem.interfaces).lower for way in ways]
        loads = np.maximum(np.nan_to_num(found, nan=0.0, posinf=np.inf), 0.0)
        with np.errstate(divide="ignore"):
            inverse = 1.0 / loads
            sides = 1.0 / np.hypot(inverse, np.roll(inverse, -1))
        four, every = np.degrees(np.arctan([loads.min(), sides.min()])).tolist()
        return four, every

    def problem(self, free: np.ndarray, present: np.ndarray) -> tuple[Problem, Ints]:
        """Pose the problem of a state.

        Parameters
        ----------
        free, present : array of bool, shape (n_blocks,)
            Which blocks can move, and which are there.

        Returns
        -------
        problem : Problem
            Its assembly is the whole, with all that is not free as supports.
        points : array of int, shape (n_points,)
            The number of each of its contact points among those of the whole.
        """
        assembly = _with(self.assembly, support=~free)
        faces = self.interfaces
        live = _of_state(faces.pair, free, present)
        shown = faces.subset(live)
        points = np.flatnonzero(np.repeat(live, np.diff(faces.start)))
        n = assembly.n_blocks
        dropped = tuple(d for d in faces.dropped if present[d.a] and present[d.b] and (free[d.a] or free[d.b]))
        rims = None if faces.rims is None else faces.rims[_of_state(faces.rims, free, present)]
        shown = replace(shown, dropped=dropped, rims=rims)
        overlapping = self._overlapping[_of_state(self._overlapping, free, present)]
        if assembly.joints:
            posed = pose(assembly, friction=None, gravity=None, loads=None, gap=self.gap, interfaces=shown)
            return replace(posed, overlapping=overlapping, unresolved=lambda: self.unresolved), points
        held, floating = split_floating(assembly, shown.pair)
        floating = floating[present[floating]]
        row = np.full(n, -1)
        row[held] = np.arange(len(held))
        eq, program = self._program(assembly, shown, held, points, row)
        none = points[:0]
        alone = np.setdiff1d(floating, shown.pair)
        warnings = tuple(f'block "{assembly.names[i]}" touches nothing' for i in alone[:5])
        problem = Problem(
            assembly, shown, self.load, eq, program, floating, self.gap, warnings, {}, none,
            overlapping=overlapping, unresolved=lambda: self.unresolved,
        )  # fmt: skip
        return problem, points

    def propped(self, free: np.ndarray, present: np.ndarray) -> Problem:
        """Pose the problem of a state in which props may hold blocks that touch nothing.

        Parameters
        ----------
        free, present : array of bool, shape (n_blocks,)
            As of `problem`, for dry joints.

        Returns
        -------
        Problem
            With rows for all free blocks, and no reduction to a plane.
        """
        problem, points = self.problem(free, present)
        held = np.flatnonzero(free)
        row = np.full(self.assembly.n_blocks, -1)
        row[held] = np.arange(len(held))
        eq, program = self._program(problem.assembly, problem.interfaces, held, points, row)
        program = None if program is None else replace(program, plane=None)
        return replace(problem, eq=eq, program=program, floating=held[:0])

    def _program(
        self, assembly: Assembly, shown: Interfaces, held: Ints, points: Ints, row: Ints
    ) -> tuple[Equilibrium, PenaltyProgram | None]:
        """The columns of the points of a state in the rows of its free blocks; none where nothing ties them down."""
        sides = row[self._columns.columns[0].pair[points]]
        on = np.flatnonzero((sides >= 0).any(axis=1))
        sides, taken = sides[on], points[on]
        whole = self._columns.columns[0]
        local = self._columns.local.reshape(-1, 3, 2, 6)[taken] * (sides >= 0)[:, None, :, None]
        columns = Columns(whole.point[taken], whole.pair[taken], whole.force[taken])
        size = assembly.size[held]
        eq = Equilibrium(local.reshape(-1, 12), self.load[held], held, on, sides, size, (columns,))
        if not len(held):
            return eq, None
        return eq, penalty_program(eq, self._friction[taken], plane=find_plane(assembly, shown, eq))


class Evidence(Memory):
    """Forces and mechanisms of earlier states, as those of the points and the blocks of the whole, in SI units.

    Parameters
    ----------
    n_blocks, n_points : int
        Of the whole.
    """

    def __init__(self, n_blocks: int, n_points: int) -> None:
        super().__init__()
        self.statistics["nearby"] = 0
        self._n_blocks, self._n_points = n_blocks, n_points
        self._forces: list[Floats] = []
        self._motions: list[Floats] = []
        self._points, self._score, self._stands = np.empty(0, dtype=np.int64), True, False
        self._problem: Problem | None = None
        self._pinned = False

    def pin(self) -> None:
        """Keep the last forces to begin with: the next states are neighbours of this one, not of each other."""
        self._pinned = bool(self._forces)

    def state(self, problem: Problem, points: Ints, *, score: bool, stands: bool = False) -> None:
        """Say which state is judged next.

        Parameters
        ----------
        problem : Problem
            Its problem.
        points : array of int, shape (n_points,)
            The number of each of its contact points among those of the whole.
        score : bool
            Whether a score is asked for, which no earlier mechanism has.
        stands : bool, optional
            Whether the state is likely to stand.
        """
        self._problem, self._score, self._stands = problem, score, stands
        # Cells and crushed contacts of joint laws have other numbers than the points of the whole: nothing is shared.
        same = len(points) == problem.interfaces.n_points
        self._points = points[problem.eq.points] if same else points[:0]

    def guess(self) -> Floats | None:
        """Return the last forces on the points of the state, in the units of its program.

        Returns
        -------
        array or None
            Shape (m, 3); None without any.
        """
        program = self._problem.program if self._problem is not None else None
        if program is None or not self._forces or len(program.friction) != len(self._points):
            return None
        return self._forces[0][self._points] / program.force_unit

    def recall(self, problem: Problem) -> Answer | None:
        """Return evidence of an earlier state that proves the outcome of this one as it is.

        Parameters
        ----------
        problem : Problem
            The problem of the state.

        Returns
        -------
        Answer or None
            Forces or a mechanism with their certificate on this state.
        """
        program = problem.program
        if program is None or len(program.friction) != len(self._points):
            return None
        for force in self._forces:
            own = force[self._points] / program.force_unit
            if unbalanced(program, own).any():
                continue
            found = _recalled(program, own, 0 * program.load, "forces")
            if outcome_of(found.certificate) is Outcome.STABLE:
                self.statistics["forces"] += 1
                return found
        fallen = self._recall_mechanism(problem, program)
        if fallen is not None and not self._score:
            return fallen
        return self._recall_nearby(program, fallen)

    def _recall_mechanism(self, problem: Problem, program: PenaltyProgram) -> Answer | None:
        """An earlier mechanism that is one of this state."""
        for motion in self._motions:
            if not motion[problem.eq.blocks].any():
                continue
            twist = (motion[problem.eq.blocks] * np.repeat([1.0, program.length_unit], 3)).reshape(-1)
            work, closing = certificate.power(program, twist)
            if work <= closing * program.total_load:
                continue
            found = _recalled(program, np.zeros((len(program.friction), 3)), twist, "mechanism")
            if outcome_of(found.certificate) is Outcome.UNSTABLE:
                self.statistics["mechanism"] += not self._score
                return found
        return None

    def _recall_nearby(self, program: PenaltyProgram, fallen: Answer | None) -> Answer | None:
        """The evidence around what has changed since the last forces, or with the score of a known mechanism."""
        n = len(program.load) // 6
        if not self._forces or n < FEW:
            return None
        own = self._forces[0][self._points] / program.force_unit
        if fallen is None:
            proposed = nearby_evidence(program, own, small=n < MANY, score=self._score, stands=self._stands)
        else:
            speed = np.linalg.norm(fallen.twist.reshape(n, 6), axis=1)
            proposed = nearby_optimum(program, own, speed > AT_REST * speed.max())
        for one in proposed:
            found = _recalled(program, one.force, one.twist, "forces", one.adhesion)
            outcome = outcome_of(found.certificate)
            if outcome is not Outcome.UNDECIDED:
                self.statistics["nearby"] += 1
                self._remember(program, found, outcome)
                return found
        return None

    def keep(self, problem: Problem, answer: Answer) -> None:
        """Remember the evidence of an answer that was solved for.

        Parameters
        ----------
        problem : Problem
            The problem of the state.
        answer : Answer
            Its checked answer.
        """
        self.statistics["solved"] += 1
        program, outcome = problem.program, outcome_of(answer.certificate)
        if program is None or outcome is Outcome.UNDECIDED or len(program.friction) != len(self._points):
            return
        self._remember(program, answer, outcome)

    def _remember(self, program: PenaltyProgram, answer: Answer, outcome: Outcome) -> None:
        if outcome is Outcome.STABLE:
            force = np.zeros((self._n_points, 3))
            force[self._points] = answer.force * program.force_unit
            self._forces = [*self._forces[:1], force] if self._pinned else [force, *self._forces][:FIELDS]
        elif self._problem is not None:
            self._motions = [self._problem.to_blocks(answer.twist), *self._motions][:MECHANISMS]


def _recalled(
    program: PenaltyProgram, force: Floats, twist: Floats, kind: str, adhesion: Floats | None = None
) -> Answer:
    checked = certificate.check(program, force, twist)
    own = np.full(program.n_points, np.nan) if adhesion is None else adhesion
    return Answer(force, twist, Status.RECALLED, 0, f"earlier {kind}", adhesion=own, certificate=checked)


def _of_state(pairs: Ints, free: np.ndarray, present: np.ndarray) -> np.ndarray:
    """Which pairs of blocks are both there, one of them free."""
    return np.asarray(present[pairs].all(axis=1) & free[pairs].any(axis=1))


def _with(assembly: Assembly, **changes: Any) -> Assembly:
    """The assembly with other supports or friction; it keeps what was computed of its shapes."""
    changed = copy.copy(assembly)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed
