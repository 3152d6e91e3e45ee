"""The dynamic verdict on an assembly: simulate it, and judge it by how far its blocks moved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import degrees
from typing import TypeAlias

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.verdict import Outcome
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import known_options
from blockstat.typing import Floats, Ints
from dynsim.bonds.glue import changed_joints, weakened
from dynsim.bonds.stiffness import caveats
from dynsim.checks import check_engine
from dynsim.engine.guards import check_can_simulate, iterations_for
from dynsim.engine.world import Action
from dynsim.judge.closing import ClosedScene, closed_scene
from dynsim.judge.cracks import find_cracks
from dynsim.judge.criteria import ARM, default_threshold, drops, group_box_centre, rate
from dynsim.judge.rest import AFTERWARDS, Falls, RestDetection, last_change, movement
from dynsim.judge.run import Run, simulate
from dynsim.judge.stages import SAME_FALL, Stages, stages
from dynsim.judge.static_reserve import StaticReserve, doubted
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.loads.load import Load, Loads, as_actions, as_loads
from dynsim.settings import Settings

Progress: TypeAlias = Callable[[float, float, float], None] | None


@known_options
def verify(
    assembly: Assembly,
    *,
    settings: Settings | None = None,
    loads: Loads = (),
    actions: Sequence[Action] = (),
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    engine: str = "bullet",
    statics: bool = False,
    progress: Progress = None,
) -> DynamicVerdict:
    """Simulate an assembly in Bullet or LMGC90 and judge it by displacement.

    It falls when a block goes beyond its threshold: by Eq. 1, by Eq. 2, by the length of its displacement or by its
    rotation. A block that is small beside most others also has a threshold of its own size. It stands when none does
    and the trend of no block is as fast as an imbalance of
    `Settings.resolution` of the weight would have made it (see `dynsim.judge.rest`). It creeps when neither holds.

    Parameters
    ----------
    assembly : Assembly
        Blocks, supports and joint laws. The bonds of the joint laws are simulated too.
    settings : Settings, optional
        Time steps, durations and thresholds; the default settings when None.
    loads : Load, array of shape (n_blocks, 6), or a sequence of them
        What acts besides the weight. An array holds wrenches about the centroids [N, N m], as in `blockstat.assess`.
        Under loads that change, blocks rock and slide and come to rest elsewhere. The default threshold is then the
        size of a block. What the loads themselves move is added to it, and to thresholds that are given. A warning
        names the block that came down most within it.
    actions : sequence of Action
        What else acts on the blocks, such as `AngularSprings` or `InertiaScale`.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces, optional
        Joints of the assembly as `blockstat.find_interfaces` finds them; searched for once when None.
    engine : str
        "bullet", or "lmgc90": non-smooth contact dynamics, a second opinion on what stands under its weight, with the
        same criteria. It needs the package compas_lmgc90 and takes neither loads, actions and bonds nor joints with
        their own friction. There is one run, with steps of `Settings.quick_step`.
    statics : bool
        Whether statics say how much the runs have to resolve, for blocks under their weight in Bullet; a search asks
        for it. A rest then counts at `Settings.resolution` only where statics prove an equilibrium with Coulomb
        friction and a reserve to all sides beyond Bullet's own error of 2 %, and at a resolution of 1e-4 elsewhere. A
        fall needs no finer run where statics find no such equilibrium. The outcome is then not independent of statics.
        In any case statics decide whether a stand or a creep on friction beyond Coulomb's has a warning and a
        `friction_excess`.
    progress : callable, optional
        Called as the run goes on with the time that has been simulated, the time from which the loads no longer change,
        and the time at which the run ends at the latest [s]. Where one run is followed by another, it begins anew.

    Returns
    -------
    DynamicVerdict
        The outcome, the displacements behind it, the cracks and the run.

    Raises
    ------
    InputError
        When nothing is supported or nothing is free, when the group of Eq. 1 or a block of a load does not exist, when
        removals leave nothing that can move, when a joint law cannot be simulated (see `dynsim.bonds.glue`), when
        blocks do not meet at joints that statics count as closed and cannot be made to, or for a scene that the engine
        cannot simulate, and where it is not installed. Also for an engine or an option that does not exist.

    Notes
    -----
    A run ends early on a fall and on a rest. Where nothing acts but weight, a fall that is not clear is accepted only
    if a run with another time step sees the same one (see `dynsim.judge.stages`). Where no actions are given, glue
    stronger than the weight of all blocks and the loads on them is tried at that strength first, and at ten and a
    hundred times it. A stand with weaker glue counts under loads that last, and under loads that change where that glue
    never came apart: a joint that cracks may keep a shock from the blocks above it. Joints that statics count as closed
    are closed for Bullet, too (see `dynsim.judge.closing`).

    A block whose weight no joints and ties can carry to a support falls when it drops by more than a joint may be open,
    settling included. A stand or a creep that needs more than Coulomb friction in a joint, where statics prove no
    equilibrium with it, has a warning and a `friction_excess` (see `dynsim.judge.static_reserve`). A stand in
    which a joint carries more than all weight and loads, where statics find self-stress alone, has one and is `wedged`.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> from dynsim import Removal, verify
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> verify(ring).outcome.word
    'stands'
    >>> verify(ring, loads=[Removal("arch.5")]).outcome.word
    'falls'
    """
    settings = Settings.of(settings)
    check_engine(engine)
    check_can_simulate(assembly)
    acting, actions = as_loads(assembly, loads), as_actions(actions)
    scene = closed_scene(assembly, find_interfaces(assembly, gap=gap) if interfaces is None else interfaces)
    asked = statics and engine == "bullet" and not (acting or actions)
    reserve = StaticReserve(scene.assembly, scene.interfaces) if asked else None
    verdict = _judged(scene, settings, acting, actions, engine, reserve, progress)
    return doubted(verdict, scene.interfaces, acting, reserve)


def verify_unasked(
    assembly: Assembly, *, settings: Settings | None, loads: Loads, interfaces: Interfaces
) -> DynamicVerdict:
    """Return the verdict of `verify` without the question whether a stand needs more than Coulomb friction.

    Parameters
    ----------
    assembly : Assembly
        Blocks, supports and joint laws.
    settings : Settings or None
        As in `verify`.
    loads : Loads
        As in `verify`.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    DynamicVerdict
        Its `friction_excess` is 0, whatever the friction.
    """
    settings = Settings.of(settings)
    check_can_simulate(assembly)
    acting = as_loads(assembly, loads)
    return _judged(closed_scene(assembly, interfaces), settings, acting, (), "bullet", None, None)


def _judged(
    scene: ClosedScene,
    given: Settings,
    acting: Sequence[Load],
    actions: Sequence[Action],
    engine: str,
    reserve: StaticReserve | None,
    progress: Progress,
) -> DynamicVerdict:
    """The verdict on a scene, by what its blocks do."""
    settings = given
    if np.isfinite(last_change(acting)):
        settings = replace(settings, end=AFTERWARDS * settings.end)
    if any(law.strong for law in scene.assembly.joints):
        settings = replace(settings, settle=settings.settle + GLUE_SETTLES)
    if engine == "bullet":
        verdict = _verify(scene.assembly, settings, acting, actions, scene.interfaces, reserve, progress)
    else:
        verdict = _Evaluator(scene.assembly, settings, acting, actions, scene.interfaces, engine, progress=progress)(
            settings
        )
    if verdict.outcome is DynamicOutcome.FALLS and np.isfinite(last_change(acting)):
        alone, spent = _falls_alone(scene, replace(settings, end=given.end), acting, actions)
        run = replace(verdict.run, process_seconds=verdict.process_seconds + spent)
        verdict = replace(verdict, falls_alone=alone, run=run)
    if scene.warnings:
        verdict = replace(verdict, corners_moved=scene.moved, misfit=scene.misfit)
    return replace(verdict, warnings=(*scene.warnings, *verdict.warnings))


def _falls_alone(
    scene: ClosedScene, settings: Settings, loads: Sequence[Load], actions: Sequence[Action]
) -> tuple[bool, float]:
    """Whether blocks fall without the loads that change, and the process time of the runs that say so [s].

    It is by statics, or by a run where statics leave it open.
    """
    lasting = [load for load in loads if np.isinf(load.end)]
    if not (lasting or actions):
        static = assess(scene.assembly, interfaces=scene.interfaces, flow="coulomb", score=False).outcome
        if static in (Outcome.STABLE, Outcome.UNSTABLE):
            return static is Outcome.UNSTABLE, 0.0
    verdict = _verify(scene.assembly, settings, lasting, actions, scene.interfaces, None, None)
    return verdict.outcome is DynamicOutcome.FALLS, verdict.process_seconds


def _verify(
    assembly: Assembly,
    settings: Settings,
    acting: Sequence[Load],
    actions: Sequence[Action],
    interfaces: Interfaces,
    reserve: StaticReserve | None,
    progress: Progress,
) -> DynamicVerdict:
    """The verdict on blocks whose joints are closed."""
    runs = stages(assembly, settings, interfaces)
    iterations = runs.first.iterations
    if acting or actions:  # one run alone
        iterations = max(iterations, iterations_for(assembly, interfaces, careful=True))
    settings = replace(settings, iterations=iterations)
    evaluate = _Evaluator(assembly, settings, acting, actions, interfaces, reserve=reserve, progress=progress)
    if not (acting or actions or any(law.strong for law in assembly.joints)):
        return _staged(evaluate, runs, reserve)

    def weaker(glued: Assembly, spent: float) -> DynamicVerdict:
        return _Evaluator(glued, settings, acting, actions, interfaces, progress=progress)(settings, spent)

    return _glued(assembly, interfaces, acting, evaluate, weaker, tried=() if actions else GLUE_TRIED)


def _glued(
    assembly: Assembly,
    interfaces: Interfaces,
    acting: Sequence[Load],
    evaluate: _Evaluator,
    weaker: Callable[[Assembly, float], DynamicVerdict],
    tried: Sequence[int],
) -> DynamicVerdict:
    """The verdict of one run: with the weakest glue tried whose stand counts, else with the glue given.

    Under loads that change, a joint that weaker glue lets crack may hold with the stronger one, and what follows
    differs: it may have kept a shock from the blocks above. So a stand then counts only if that glue never came apart.
    """
    changing, spent, most = bool(np.isfinite(last_change(acting))), 0.0, None
    for times in tried:
        if (weak := weakened(assembly, interfaces, acting, times)) is None:
            break
        verdict = weaker(weak, spent)
        spent, most = verdict.process_seconds, verdict if times == GLUE_TRIED[-1] else None
        joints = interfaces.subset(changed_joints(assembly, weak, interfaces))
        if verdict.outcome is DynamicOutcome.STANDS and not (changing and verdict.run.came_apart(joints)):
            return replace(verdict, warnings=(*verdict.warnings, _weaker(times, changing=changing)))
    verdict = evaluate(evaluate.settings, spent)
    if verdict.outcome is DynamicOutcome.STANDS or most is None:
        return verdict
    beside = [name for block, name in enumerate(assembly.names) if block not in joints.pair]
    if verdict.first_block == most.first_block and verdict.first_block in beside:
        return verdict  # what falls first is not glued, and falls at either strength
    cracked = " with cracks in it" * (most.outcome is DynamicOutcome.STANDS)
    return replace(
        verdict, warnings=(*verdict.warnings, f"{AT_MOST} it {most.outcome.word}{cracked}, and {TOO_STRONG}")
    )


def _staged(evaluate: _Evaluator, runs: Stages, reserve: StaticReserve | None) -> DynamicVerdict:
    """Return the verdict of the first run that is accepted, with the process time of all."""
    verdict = evaluate(runs.first)
    if runs.fine is None or verdict.outcome is DynamicOutcome.STANDS:
        return verdict
    fell = _fall_time(verdict)
    if fell < runs.first.clear_fall:
        return verdict
    spent = verdict.run.process_seconds
    if runs.check is not None and verdict.outcome is DynamicOutcome.FALLS:
        longest = min(max(SAME_FALL * fell, runs.check.window), runs.check.longest)
        check = evaluate(replace(runs.check, end=longest))
        spent += check.run.process_seconds
        fell_too = check.outcome is DynamicOutcome.FALLS  # a fall by Eq. 1 alone has no time: inf in both
        same = fell_too and fell / SAME_FALL <= _fall_time(check) <= fell * SAME_FALL
        if same or (reserve is not None and not reserve.equilibrium):
            return replace(verdict, run=replace(verdict.run, process_seconds=spent))
    return evaluate(runs.fine, spent)


def _fall_time(verdict: DynamicVerdict) -> float:
    """When blocks passed their threshold, in the time of `Settings` [s]; inf if none did."""
    return np.inf if verdict.first_time is None else verdict.first_time * verdict.run.pace


#: Bonds give a little before they hold, so glued blocks settle longer by this [s].
GLUE_SETTLES = 0.1
#: Glue that is stronger is first tried at these multiples of the weight of all blocks and the loads on them. Four cubes
#: begin to creep at some five hundred times their weight.
GLUE_TRIED = (1, 10, 100)
AT_MOST = f"with glue of {GLUE_TRIED[-1]} times the weight of all blocks and the loads on them"
TOO_STRONG = (
    "Bullet does not balance the preload of stronger glue well: blocks may creep, so this run does not say what the "
    "glue given would hold"
)


def _weaker(times: int, *, changing: bool) -> str:
    """What is said of a stand with weaker glue."""
    most = "the weight" if times == 1 else f"{times} times the weight"
    whole = ", which never came apart" * changing
    return (
        f"it stands with glue of no more than {most} of all blocks and the loads on them a joint{whole}, so it stands "
        "with the stronger glue given"
    )


class _Evaluator:
    """What counts in one assembly, and the verdict on a run of it."""

    def __init__(
        self,
        assembly: Assembly,
        settings: Settings,
        loads: Sequence[Load],
        actions: Sequence[Action],
        interfaces: Interfaces,
        engine: str = "bullet",
        reserve: StaticReserve | None = None,
        progress: Progress = None,
    ) -> None:
        self._assembly, self._interfaces, self._engine, self.settings = assembly, interfaces, engine, settings
        self._reserve, self._progress = reserve, progress
        self._group, blocks = _roof(assembly, settings.group)
        self._falls = Falls(assembly, interfaces, loads, settings)
        self._blocks = np.intersect1d(blocks, self._falls.judged)
        self._hold = max(last_change(loads), 0.0)
        self._threshold = default_threshold(assembly)
        self._loads, self._actions = loads, actions
        self._crack = settings.crack_threshold

    def __call__(self, settings: Settings, spent: float = 0.0) -> DynamicVerdict:
        rest = RestDetection(self._threshold, settings.window)
        resolution = settings.resolution

        def decided(elapsed: float, moved: Floats, turned: Floats) -> bool:
            nonlocal resolution
            if self._falls.decided(moved, turned):
                return True
            if not rest.look(elapsed, movement(self._assembly, self._falls.judged, moved, turned)):
                return False
            if self._reserve is not None and (finer := self._reserve.resolution(resolution)) < resolution:
                resolution = finer
                rest.lengthen(replace(settings, resolution=finer).window)
                return False
            return True

        run = simulate(
            self._assembly, settings=settings, stop=decided, loads=self._loads, actions=self._actions, hold=self._hold,
            interfaces=self._interfaces, engine=self._engine, progress=self._progress,
        )  # fmt: skip
        run = replace(run, process_seconds=run.process_seconds + spent)
        return self._verdict(run, replace(settings, resolution=resolution), rest.reached)

    def _verdict(self, run: Run, settings: Settings, at_rest: bool) -> DynamicVerdict:
        """Return the verdict on a run.

        Parameters
        ----------
        run : Run
            What is judged.
        settings : Settings
            Those of the run.
        at_rest : bool
            Whether the run ended on a rest.
        """
        assembly, falls = self._assembly, self._falls
        fallen = falls.of(run)
        since, beyond, turned = fallen.moved, fallen.beyond, fallen.turned
        length = np.linalg.norm(since, axis=2)
        group_drop, max_drop = self._group_drop(run), float(drops(assembly, since[-1]).max())
        ever = np.flatnonzero(beyond.any(axis=0))
        speed = rate(run.times, since, settings.window / run.pace, self._hold)
        outcome = DynamicOutcome.STANDS if at_rest else DynamicOutcome.CREEPS
        if len(ever) or group_drop >= falls.roof or max_drop >= falls.brick:
            outcome = DynamicOutcome.FALLS
        settling = float(np.linalg.norm(run.displacement[0], axis=1).max())
        frame = int(np.argmax(beyond.any(axis=1)))
        told = [*caveats(self._actions), *_warnings(run, settling, falls.brick), *falls.words(fallen)]
        return DynamicVerdict(
            outcome=outcome, group=self._group, group_drop=group_drop, max_drop=max_drop,
            max_displacement=float(length.max()), max_rotation=degrees(turned.max()), rate=speed, settling=settling,
            max_turn=float((turned * ARM * assembly.size).max()), turn_threshold=falls.turn,
            roof_threshold=falls.roof, brick_threshold=falls.brick,
            moved=ever[np.argsort(-length[-1, ever], kind="stable")],
            first_block=_first(assembly, beyond[frame], length[frame]) if len(ever) else None,
            first_time=float(run.times[frame]) if len(ever) else None,
            cracks=find_cracks(
                assembly, (run.displacement[0], run.rotation[0]), (run.displacement[-1], run.rotation[-1]),
                threshold=self._crack, interfaces=self._interfaces, removed=np.flatnonzero(np.isfinite(run.removed)),
            ),
            run=run, resolution=settings.resolution, settings=settings, warnings=tuple(told),
        )  # fmt: skip

    def _group_drop(self, run: Run) -> float:
        """Eq. 1 [m]."""
        if not len(self._blocks):
            return 0.0
        start, end = (
            group_box_centre(self._assembly, self._blocks, run.displacement[k], run.rotation[k]) for k in (0, -1)
        )
        return float(drops(self._assembly, end - start))


def _warnings(run: Run, settling: float, brick: float) -> list[str]:
    warnings = run.warnings
    if run.initial_overlap > 0.1 * brick:
        warnings.append(
            f"shapes overlap by up to {1e3 * run.initial_overlap:.2g} mm before the first step; "
            "motion is counted after settling"
        )
    if settling > brick:
        warnings.append(f"blocks moved {1e3 * settling:.2g} mm while settling, more than the threshold")
    return warnings


def _roof(assembly: Assembly, group: str | None) -> tuple[str, Ints]:
    """Group of Eq. 1 and its blocks."""
    if group is None and not any(g == "vault" or g.startswith("vault.") for g in assembly.groups):
        return "", assembly.free
    group = group or "vault"
    return group, assembly.in_group(group)


def _first(assembly: Assembly, beyond: np.ndarray, length: Floats) -> str:
    """Name of the furthest of the blocks beyond the threshold in one look."""
    return assembly.names[int(np.argmax(np.where(beyond, length, -1.0)))]
