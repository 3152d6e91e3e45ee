"""A plan of building carried out in Bullet, with the criteria at each step.

All blocks are in the client from the beginning, out of reach. A step puts blocks in, takes hold of some, lets others
go, and sets props up or takes them away; nothing pushes a held block. Then the blocks settle under full damping, are
released and have to come to rest, as in `dynsim.verify`. A block is put in where it was built, moved as the blocks that
it touches have moved on average. Where a step falls, its blocks are put back to where they were before, so that later
steps are judged, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.problem import unheeded
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, known_options
from blockstat.result import Result, Unfinished, millimetres
from blockstat.sequence.plan import Plan, Step, check_plan
from blockstat.typing import Floats, Ints
from dynsim.bonds.props import PropForces
from dynsim.engine.world import World
from dynsim.judge.closing import closed_scene
from dynsim.judge.criteria import ARM, SmallBlocks, angles, default_threshold, own_threshold
from dynsim.judge.rest import RestDetection, movement
from dynsim.judge.run import TALL, Contacts, Run, height_of, rotation_vectors
from dynsim.judge.stages import MIDDLE, joints_to_furthest_block
from dynsim.judge.verdict import DynamicOutcome
from dynsim.settings import Settings

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: The default settings of a step: most of its blocks stood before, and settle and rest sooner than a whole building.
STEP = {"settle": 0.06, "resolution": 6e-3, "end": 2.0}


@dataclass(frozen=True)
class StepRun:
    """What one step of a plan came to in Bullet."""

    outcome: DynamicOutcome
    max_displacement: float  #: of a block that is not held, since it was let go in this step [m]
    first_block: str | None  #: the block that crossed the threshold first
    end: float  #: time at the end of the step, from the beginning of the plan [s]


@dataclass(frozen=True, eq=False)
class DynamicSequence(Result):
    """A plan carried out in Bullet."""

    outcome: DynamicOutcome | Unfinished  #: stands when every step does, else that of the first step that does not
    plan: Plan  #: of one that was interrupted, the steps that were carried out
    steps: tuple[StepRun, ...]
    threshold: float  #: displacement from which a block has fallen [m]
    run: Run  #: one frame for the beginning and one for the end of each step; blocks to come lie where they were built
    warnings: tuple[str, ...] = ()
    resolution: float = STEP["resolution"]  #: the imbalance that would have shown in a step, as in `Settings`
    missing: int = 0  #: steps that an interrupt has left out

    @property
    def first_fall(self) -> int | None:
        """The number of the first step that does not stand; None where all do."""
        return next((k for k, step in enumerate(self.steps) if step.outcome is not DynamicOutcome.STANDS), None)

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a step.

        Returns
        -------
        list of dict
            With `step`, `install`, `held`, `verdict`, `max_displacement` and `first_block`.
        """
        return [
            {
                "step": k,
                "install": list(step.install),
                "held": list(step.hold),
                "verdict": ran.outcome.word,
                "max_displacement": ran.max_displacement,
                "first_block": ran.first_block,
            }
            for k, (step, ran) in enumerate(zip(self.plan.steps, self.steps, strict=True))
        ]

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With one row a step.
        """
        return {
            "verdict": self.outcome.word,
            "plan": self.plan.name,
            "threshold": self.threshold,
            "resolution": self.resolution,
            "first_fall": self.first_fall,
            "missing": self.missing,
            "steps": self.rows(),
            "process_seconds": self.run.process_seconds,
            "warnings": list(self.warnings),
        }

    def explain(self) -> str:
        """Return the steps that do not stand, in words.

        Returns
        -------
        str
            One fact a line.
        """
        rows = self.rows()
        bad = [row for row in rows if row["verdict"] != DynamicOutcome.STANDS.word]
        largest = max((row["max_displacement"] for row in rows), default=0.0)
        steps = f"{len(rows)} of {len(rows) + self.missing} steps" if self.missing else f"{len(rows)} steps"
        lines = [Unfinished.STOPPED.value] * bool(self.missing)
        lines.append(f"{self.plan.name}: {steps}, {self.run.process_seconds:.1f} s")
        if not bad:
            each = "Each of these" if self.missing else "Every step"
            lines.append(f"{each} stands; blocks moved by {millimetres(largest, 2)} mm at most in one.")
        else:
            lines.append(f"{len(bad)} steps do not stand, the first is step {bad[0]['step']}.")
        for row in bad:
            what = "" if row["first_block"] is None else f', first "{row["first_block"]}"'
            lines.append(f"step {row['step']}: {row['verdict']}, {millimetres(row['max_displacement'])} mm{what}")
        lines.append(f"An imbalance of {self.resolution:.1g} of the weight would have shown in a step.")
        return "\n".join(lines + [f"Warning: {text}" for text in self.warnings])


@known_options
def sequence(
    assembly: Assembly,
    plan: Plan,
    *,
    friction: float | None = None,
    settings: Settings | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> DynamicSequence:
    """Carry out a plan of building in Bullet and judge each step by displacement.

    Parameters
    ----------
    assembly : Assembly
        All blocks, with dry joints and without ties.
    plan : Plan
        The plan; it is checked first.
    friction : float, optional
        Replaces the assembly's coefficient of friction; `interfaces` with a friction of their own keep it, and a
        warning says so.
    settings : Settings, optional
        Time step and durations, those of one step of the plan.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for when None.
    progress : callable, optional
        Called with the steps carried out and all of them. With it a KeyboardInterrupt after the first step leaves the
        others out, and the outcome is "stopped" unless one of those before does not stand; without it, it is raised.

    Returns
    -------
    DynamicSequence
        The outcome of each step, and the motion as one run.

    Raises
    ------
    InputError
        For a plan that cannot be carried out, for joint laws, for ties and for a scene that Bullet cannot simulate.

    Examples
    --------
    >>> from blockstat import Assembly, Plan, Step, box
    >>> from dynsim import sequence
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.8, 0, 0), (0.2, 1, 1), name="low"),
    ...           box((-0.2, 0, 1), (0.8, 1, 2), name="high")]
    >>> plan = Plan((Step(("low",)), Step(("high",), ("high",)), Step()))
    >>> found = sequence(Assembly.from_blocks(blocks, supports=["ground"]), plan)
    >>> [step.outcome.word for step in found.steps]
    ['stands', 'stands', 'falls']
    """
    check_plan(plan, assembly)
    assembly = assembly if friction is None else assembly.with_(friction=friction)
    if assembly.joints:
        raise InputError("sequences are carried out with dry joints; this assembly has joint laws")
    if assembly.ties:
        raise InputError(f'"{assembly.name}" has ties; sequences are judged without ties')
    start = process_time()
    scene = closed_scene(assembly, find_interfaces(assembly, gap=gap) if interfaces is None else interfaces)
    settings = settings or replace(Settings(), **STEP)
    depth = joints_to_furthest_block(scene.assembly, scene.interfaces)
    settings = replace(settings, iterations=max(settings.iterations, MIDDLE * depth))
    props = _props(scene.assembly, plan)
    with World(scene.assembly, settings, [props] if plan.props else [], interfaces=scene.interfaces) as world:
        site = _Site(world, plan, settings, props)
        steps = site.carry_out_all(progress)
        run = site.run()
    missing = len(plan.steps) - len(steps)
    every = Unfinished.STOPPED if missing else DynamicOutcome.STANDS
    worst = next((s.outcome for s in steps if s.outcome is not DynamicOutcome.STANDS), every)
    run, done = replace(run, process_seconds=process_time() - start), replace(plan, steps=plan.steps[: len(steps)])
    kept = [] if friction is None else unheeded(scene.assembly, scene.interfaces)
    warnings = (*kept, *scene.warnings, *run.warnings)
    return DynamicSequence(worst, done, steps, site.threshold, run, warnings, settings.resolution, missing)


def _props(assembly: Assembly, plan: Plan) -> PropForces:
    """The props of a plan, in its order."""
    props = plan.props.values()
    points, lines = (np.reshape([getattr(prop, key) for prop in props], (-1, 3)) for key in ("point", "direction"))
    return PropForces(assembly, np.array([assembly.names.index(prop.block) for prop in props], int), points, lines)


@dataclass
class _Film:
    """The frames so far."""

    times: list[float] = field(default_factory=list)
    displacement: list[Floats] = field(default_factory=list)
    rotation: list[Floats] = field(default_factory=list)


class _Site:
    """The blocks in Bullet while a plan is carried out."""

    def __init__(self, world: World, plan: Plan, settings: Settings, props: PropForces) -> None:
        self._world, self._plan, self._settings = world, plan, settings
        self._props, self._prop_names = props, list(plan.props)
        self._assembly = assembly = world.assembly
        self._present = assembly.support.copy()
        self._held = assembly.support.copy()
        asked, self.threshold = settings.brick_threshold, settings.brick_threshold or default_threshold(assembly)
        self._own = np.full(assembly.n_blocks, asked) if asked else own_threshold(assembly, self.threshold)
        self._number = {name: k for k, name in enumerate(assembly.names)}
        self._placed = np.where(assembly.support, -np.inf, np.inf)
        self._boundary = [self._number[name] for name in plan.boundary]
        self._time, self._film = 0.0, _Film()
        self._look = settings.substeps * settings.time_step
        self._stretch = float(np.sqrt(max(height_of(assembly) * world.length / TALL, 1.0)))
        for block in assembly.free:
            world.remove(int(block))
        for block in self._boundary:
            self._put_in(block)
        self._placed[self._boundary] = -np.inf
        self._keep()

    def _numbers(self, names: tuple[str, ...]) -> list[int]:
        return [self._number[name] for name in names]

    def _put_in(self, block: int) -> None:
        """Put a block in, moved as its neighbours have moved; it is held."""
        pair = self._world.interfaces.pair
        beside = np.unique(pair[(pair == block).any(axis=1)])
        beside = beside[self._present[beside]]
        moved = self._world.poses()[0][beside].mean(axis=0) if len(beside) else np.zeros(3)
        self._world.place(block, moved, np.eye(3))
        self._present[block] = self._held[block] = True
        self._placed[block] = min(self._placed[block], self._time)

    def carry_out_all(self, progress: Callable[[int, int], None] | None) -> tuple[StepRun, ...]:
        """Carry out the steps; with progress, those until an interrupt, if there are any."""
        steps, plan = list[StepRun](), self._plan
        try:
            for step, standing in zip(plan.steps, plan.standing_props(), strict=True):
                steps.append(self.carry_out(step, standing))
                if progress is not None:
                    progress(len(steps), len(plan.steps))
        except KeyboardInterrupt:
            if progress is None or not steps:
                raise
        return tuple(steps)

    def carry_out(self, step: Step, standing: tuple[str, ...]) -> StepRun:
        """Carry out one step, at whose end some props stand, and judge it."""
        for block in self._numbers(step.install):
            if not self._present[block]:
                self._put_in(block)
        hands = self._assembly.support.copy()
        hands[[*self._numbers(step.hold), *self._boundary]] = True
        for block in np.flatnonzero(self._present & (hands != self._held)).tolist():
            (self._world.hold if hands[block] else self._world.let_go)(block)
        self._held = hands
        if self._prop_names:
            self._props.stand(self._world, np.isin(self._prop_names, standing))
        free = np.flatnonzero(self._present & ~hands)
        before = self._world.poses()
        if not len(free):
            self._advance()  # nothing moves; the time tells the frames apart
            self._keep()
            return StepRun(DynamicOutcome.STANDS, 0.0, None, self._time)
        outcome, furthest, first = self._watch(free)
        if outcome is DynamicOutcome.FALLS:
            for block in np.flatnonzero(self._present & ~self._assembly.support).tolist():
                self._world.place(block, before[0][block], before[1][block])
            self._held = self._present.copy()
        return StepRun(outcome, furthest, first, self._time)

    def _watch(self, free: Ints) -> tuple[DynamicOutcome, float, str | None]:
        """Settle, release, and wait for a rest or a fall of the free blocks."""
        world, s = self._world, self._settings
        world.damp(1.0)
        for _ in range(round(s.settle * self._stretch / self._look)):
            self._advance()
        world.damp(0.0)
        start, turned_at_start = world.poses()
        rest = RestDetection(default_threshold(self._assembly), s.window)
        rest.look(0.0, np.zeros((len(free), 6)))
        size, looks, furthest = self._assembly.size[free], round(s.longest * self._stretch / self._look), 0.0
        small = SmallBlocks(self._assembly, world.interfaces, self._own, gone=np.flatnonzero(~self._present))
        for look in range(1, looks + 1):
            self._advance()
            moved, turned = world.poses()
            length = np.linalg.norm((moved - start)[free], axis=1)
            angle = angles(np.stack([turned_at_start, turned])[:, free])[1]
            beyond = np.maximum(length, angle * ARM * size)
            furthest = max(furthest, float(length.max()))
            fell = (length >= self.threshold) | (angle * ARM * size >= self._own[free])
            fell |= small.strayed(moved - start, turned @ turned_at_start.swapaxes(1, 2))[free]
            if fell.any():
                self._keep()
                return DynamicOutcome.FALLS, furthest, self._assembly.names[free[np.where(fell, beyond, -1.0).argmax()]]
            since = movement(self._assembly, free, moved - start, rotation_vectors(turned_at_start, turned))
            if rest.look(s.longest * look / looks, since):
                break
        self._keep()
        return (DynamicOutcome.STANDS if rest.reached else DynamicOutcome.CREEPS), furthest, None

    def _advance(self) -> None:
        self._world.advance()
        self._time += self._look / self._world.time

    def _keep(self) -> None:
        moved, turned = self._world.poses()
        self._film.times.append(self._time)
        self._film.displacement.append(moved)
        self._film.rotation.append(turned)

    def run(self) -> Run:
        """The frames as a run."""
        film, n = self._film, self._assembly.n_blocks
        frames = len(film.times)
        placed = np.where(self._placed < film.times[-1], self._placed, np.inf)  # not those of a step without an end
        return Run(
            self._assembly, np.array(film.times), np.array(film.displacement), np.array(film.rotation), 0.0, 0.0,
            np.zeros(frames), np.full(n, np.inf), Contacts(*self._world.contact_forces()), self._settings.time_step,
            float(self._world.time / self._stretch), placed=placed, filled=self._world.filled,
        )  # fmt: skip
