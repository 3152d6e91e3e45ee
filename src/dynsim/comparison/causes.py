"""Why statics and Bullet differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.reserve import loose_joints
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.loads import up_of
from blockstat.result import Sentence, plain
from dynsim.judge.stages import stages
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.judge.verify import verify
from dynsim.settings import PRESETS, Settings

#: A verdict of statics that a sideways push of this part of gravity changes is marginal: Bullet's own limits are off by
#: up to this much (docs/dynamics_validation.md).
PUSH, PUSHES = 0.02, 8
#: An instability with less than this missing adhesion (the score, in weights) is marginal.
SCORE = 1e-3
#: Sound assemblies settle by less than this part of the threshold.
SETTLED = 0.1
LONGER = 10.0
#: Imbalance that it has to see, as a share of the weight.
CLOSER = 1e-5


class Cause(Sentence):
    """Why verdicts differ, or why there is none; the value of each is the sentence that a user reads."""

    SELF_STRESS = "it stands only by self-stress or dilatancy: Coulomb friction without them finds no equilibrium"
    GEOMETRY = "the shapes Bullet sees overlap, so it does not simulate quite this geometry"
    OPEN_JOINTS = (
        "statics count joints as closed whose faces do not meet, and Bullet simulates them as drawn: "
        "`blockstat repair` closes them or says what it leaves"
    )
    MARGINAL = (
        "marginal: a push of 2 % of gravity, or adhesion of a thousandth of the weight, changes the static verdict"
    )
    COARSE_FALL = "false fall of a coarse run: with finer time steps it does not fall"
    COARSE_STAND = "false stand of a coarse run: with finer time steps it falls"
    TIME_TOO_SHORT = "statics exclude rest: the motion is slow, and in ten times as long it passes the threshold"
    SETTLED = "blocks moved a little and came to rest elsewhere, on other joints than they were built with"
    FRICTION = (
        "Bullet's friction is too large in a joint: it is bounded in two directions at right angles, and the stand "
        "needs more than Coulomb's law gives"
    )
    WEDGED = "Bullet wedges the blocks: joints that no load presses are pressed by what shapes are rounded to"
    HELD = "it rests in a finer run too, on friction that statics without self-stress do not count on"
    CREEPS = "it creeps in Bullet: neither a stand nor a fall"
    UNDECIDED = "statics do not decide"
    OPEN_FALL = (
        "statics allow rest, with Coulomb friction too: marginal, a motion that rest would have stopped, or forces "
        "that hang on how tight the joints are (`--flow coulomb --tightnesses 12`)"
    )
    OPEN_STAND = "statics find no rest: a motion slower than the threshold in the simulated time, or too coarse a run"


def agrees(static: Verdict, dynamic: DynamicVerdict) -> bool | None:
    """Return whether a static verdict says what Bullet says.

    Parameters
    ----------
    static : Verdict
        Of either flow.
    dynamic : DynamicVerdict
        Of the same assembly.

    Returns
    -------
    bool or None
        None when one of them says neither.
    """
    return outcomes_agree(static.outcome, dynamic.outcome)


def outcomes_agree(static: Outcome, dynamic: DynamicOutcome) -> bool | None:
    """Return whether the outcome of statics says what Bullet's says.

    Parameters
    ----------
    static : Outcome
        Of either flow.
    dynamic : DynamicOutcome
        Of the same assembly.

    Returns
    -------
    bool or None
        None when one of them says neither.
    """
    if static is Outcome.UNDECIDED or dynamic is DynamicOutcome.CREEPS:
        return None
    return (static is Outcome.STABLE) == (dynamic is DynamicOutcome.STANDS)


def likely_reason(static: Verdict, dynamic: DynamicVerdict) -> str:
    """Return why statics and Bullet differ, in one sentence.

    Parameters
    ----------
    static : Verdict
        With associated flow: it asks for a force field alone.
    dynamic : DynamicVerdict
        Of the same assembly.

    Returns
    -------
    str
        Empty when they agree.

    Examples
    --------
    >>> from blockstat import Assembly, assess, box
    >>> from dynsim import likely_reason, verify
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> likely_reason(assess(pillar), verify(pillar))
    ''
    """
    if dynamic.outcome is DynamicOutcome.CREEPS:
        return f"it creeps at {plain(1e3 * dynamic.rate, 2)} mm/s in Bullet: neither a stand nor a fall"
    if agrees(static, dynamic):
        return ""
    found = find_cause(static, with_coulomb(static), dynamic)
    return found.value if found is not None else ""


def with_coulomb(static: Verdict) -> Verdict:
    """Return the verdict without dilatancy and self-stress on the same joints.

    Parameters
    ----------
    static : Verdict
        With associated flow.

    Returns
    -------
    Verdict
        The same one where no force field exists.
    """
    if static.outcome is not Outcome.STABLE:
        return static
    return assess(static.assembly, interfaces=static.interfaces, flow="coulomb")


def find_cause(
    static: Verdict,
    coulomb: Verdict,
    dynamic: DynamicVerdict,
    *,
    settings: Settings | None = None,
    closely: bool = False,
) -> Cause | None:
    """Return why the verdicts on one assembly differ, or say neither.

    Parameters
    ----------
    static, coulomb : Verdict
        With associated flow, and without dilatancy and self-stress.
    dynamic : DynamicVerdict
        Of the same assembly.
    settings : Settings, optional
        With which the dynamic verdict was reached.
    closely : bool
        Push the assembly a little, and simulate it again with finer time steps and for longer, where that may tell. It
        costs several times what the verdicts cost.

    Returns
    -------
    Cause or None
        None when all three agree.

    Examples
    --------
    >>> from blockstat import Assembly, assess, box
    >>> from dynsim import find_cause, verify
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> static, coulomb = (assess(pillar, flow=flow) for flow in ("associated", "coulomb"))
    >>> find_cause(static, coulomb, verify(pillar)) is None
    True
    """
    if dynamic.outcome is DynamicOutcome.CREEPS:
        return Cause.CREEPS
    if static.outcome is Outcome.UNDECIDED:
        return Cause.UNDECIDED
    if agrees(static, dynamic) and agrees(coulomb, dynamic):
        return None
    if dynamic.run.initial_overlap > SETTLED * dynamic.brick_threshold:
        return Cause.GEOMETRY
    if dynamic.misfit > SETTLED * dynamic.brick_threshold:
        return Cause.OPEN_JOINTS
    if static.outcome is Outcome.STABLE and coulomb.outcome is Outcome.UNDECIDED and not closely:
        return Cause.UNDECIDED
    if dynamic.outcome is DynamicOutcome.FALLS:
        return _why_it_fell(coulomb, Settings.of(settings), closely)
    return _why_it_stood(static, coulomb, dynamic, Settings.of(settings), closely)


def _why_it_fell(coulomb: Verdict, settings: Settings, closely: bool) -> Cause:
    """Return why an assembly fell for which a force field exists."""
    if coulomb.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS:
        return Cause.SELF_STRESS
    if _rests_on_open_joints(coulomb):
        return Cause.OPEN_JOINTS
    if closely and _tips(coulomb):
        return Cause.MARGINAL
    if closely:
        again = _in_finer_steps(coulomb, settings)
        if again.outcome is not DynamicOutcome.FALLS:
            return Cause.COARSE_FALL
    return Cause.UNDECIDED if coulomb.outcome is Outcome.UNDECIDED else Cause.OPEN_FALL


def _why_it_stood(
    static: Verdict, coulomb: Verdict, dynamic: DynamicVerdict, settings: Settings, closely: bool
) -> Cause:
    """Return why an assembly stood for which no force field exists, or none without self-stress."""
    assembly = static.assembly
    if dynamic.friction_excess:
        return Cause.FRICTION
    if dynamic.wedged:
        return Cause.WEDGED
    if closely and _in_finer_steps(static, settings).outcome is DynamicOutcome.FALLS:
        return Cause.COARSE_STAND
    if closely and static.outcome is Outcome.STABLE:
        return Cause.UNDECIDED if coulomb.outcome is Outcome.UNDECIDED else Cause.HELD
    longer = replace(settings, resolution=CLOSER, end=LONGER * settings.end)
    if closely:
        slow = verify(assembly, settings=longer, interfaces=joints_as_found(static))
        if slow.outcome is DynamicOutcome.FALLS:
            return Cause.TIME_TOO_SHORT
    if dynamic.settling + dynamic.max_displacement > SETTLED * dynamic.brick_threshold:
        return Cause.SETTLED
    marginal = static.outcome is Outcome.UNSTABLE and static.score < SCORE
    return Cause.MARGINAL if marginal else Cause.OPEN_STAND


def _rests_on_open_joints(stable: Verdict) -> bool:
    """Whether an assembly is stable, and not so without the joints that do not quite close."""
    loose = loose_joints(stable.assembly, stable.interfaces)
    if stable.outcome is not Outcome.STABLE or not loose.any():
        return False
    closed = stable.interfaces.subset(~loose)
    return assess(stable.assembly, interfaces=closed, score=False).outcome is not Outcome.STABLE


def _tips(static: Verdict) -> bool:
    """Whether a small push in some horizontal direction changes the verdict, and leaves it no equilibrium."""
    assembly = static.assembly
    down = -up_of(assembly)
    across = np.cross(down, np.eye(3)[np.argmin(np.abs(down))])
    across /= np.linalg.norm(across)
    for angle in 2 * np.pi * np.arange(PUSHES) / PUSHES:
        push = np.cos(angle) * across + np.sin(angle) * np.cross(down, across)
        gravity = assembly.gravity + PUSH * np.linalg.norm(assembly.gravity) * push
        found = assess(assembly, gravity=gravity, flow="coulomb", interfaces=static.interfaces)
        if found.outcome not in (Outcome.STABLE, static.outcome):
            return True
    return False


def joints_as_found(static: Verdict) -> Interfaces:
    """Return the interfaces of a static verdict as a contact search finds them, not divided into cells for joint laws.

    Parameters
    ----------
    static : Verdict
        Its interfaces are used where they are not divided, else its assembly is searched.

    Returns
    -------
    Interfaces
        Joints of the assembly.
    """
    return (
        static.interfaces
        if static.interfaces.share is None
        else find_interfaces(static.assembly, gap=static.interfaces.searched)
    )


def _in_finer_steps(static: Verdict, settings: Settings) -> DynamicVerdict:
    assembly, interfaces = static.assembly, joints_as_found(static)
    return verify(assembly, settings=finer(assembly, settings, interfaces), interfaces=interfaces)


def finer(assembly: Assembly, settings: Settings, interfaces: Interfaces) -> Settings:
    """Return the settings of one run at half the finest time step behind a verdict.

    Parameters
    ----------
    assembly : Assembly
        What the verdict is on.
    settings : Settings
        With which it was reached.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    Settings
        Half the finest time step, or the finest of the careful preset if that is less.
    """
    runs = stages(assembly, settings, interfaces)
    finest = runs.fine or runs.first
    step = min(finest.time_step / 2, PRESETS["careful"]["fine_step"])
    return replace(finest, time_step=step, quick_step=step, fine_step=step)
