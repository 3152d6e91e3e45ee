"""Construction stages of a scene: the walls, then the vault on its centring, then decentring.

A stage is a table of the scene file::

    [[stages]]
    name = "vault"
    place = ["vault"]        # groups that are put in now
    centring = ["vault"]     # groups that rest on a centring at its end
    courses = true           # judged after each course, too

Without a centring a stage is one more static verdict. On a centring it has the least total force of its boards, which
push on the soffits of the blocks, normal to them (`blockstat.centring`). What is put in later plays no part, but that
no board lies in a joint between two blocks of one centring.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP
from blockstat.errors import InputError, check_choice, known_options
from blockstat.result import Result, Unfinished, finite, listed
from blockstat.sequence.centring import centring
from blockstat.sequence.courses import levels
from blockstat.sequence.props import OF_STATE, Falsework, falsework
from blockstat.sequence.states import Whole
from blockstat.spec.material import Stage, stages_from
from blockstat.system.workers import in_stretches
from blockstat.typing import Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class StageVerdict:
    """What the statics say at the end of a stage, or of one of its courses."""

    name: str
    blocks: int  #: that are there and free
    outcome: Outcome
    score: float
    moving: tuple[str, ...]  #: blocks that move where it falls
    falsework: Falsework | None = None  #: with a centring
    unpropped: tuple[str, ...] = ()  #: blocks on the centring all of whose faces that look down are in joints

    @property
    def most_under_a_block(self) -> float:
        """The largest force under one block [N], summed over its soffits; nan where the centring does not hold it."""
        forces = {} if self.falsework is None else self.falsework.by_block
        return max(forces.values(), default=0.0)


@dataclass(frozen=True, eq=False)
class StagesVerdict(Result):
    """The stages of a scene, one after the other."""

    outcome: Outcome | Unfinished  #: stable when every stage is, else that of the first which is not
    stages: tuple[StageVerdict, ...]
    missing: int = 0  #: stages and courses that an interrupt has left unjudged

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            One row a stage.
        """
        return {
            "verdict": self.outcome.word,
            "missing": self.missing,
            "stages": [
                {
                    "name": stage.name,
                    "blocks": stage.blocks,
                    "verdict": stage.outcome.word,
                    "score": finite(stage.score),
                    "moving": list(stage.moving),
                    "unpropped": list(stage.unpropped),
                    "centring_total": None if stage.falsework is None else finite(stage.falsework.total),
                    "centring_peak": None if stage.falsework is None else finite(stage.most_under_a_block),
                }
                for stage in self.stages
            ],
        }

    def explain(self, limit: int = 5) -> str:
        """Return one line a stage.

        Parameters
        ----------
        limit : int, optional
            Most blocks that are named.

        Returns
        -------
        str
            One fact a line.
        """
        done = len(self.stages)
        lines = [f"Stopped: {done} of {done + self.missing} stages and courses were judged."] if self.missing else []
        for stage in self.stages:
            words = f"{stage.name}: {stage.blocks} blocks, {stage.outcome.word}"
            if stage.falsework is not None and stage.outcome is Outcome.STABLE:
                total, most = 1e-3 * stage.falsework.total, 1e-3 * stage.most_under_a_block
                words += f" on a centring that needs {total:.2f} kN at least, up to {most:.2f} kN under one block"
            elif stage.unpropped:
                words += f"; no board of the centring has room under {listed(stage.unpropped, limit)}"
            if stage.moving:
                words += f"; first to move: {listed(stage.moving, limit)}"
            lines.append(words)
        return "\n".join(lines)


def stages_of(assembly: Assembly) -> tuple[Stage, ...]:
    """Return the stages that a scene gives its assembly.

    Parameters
    ----------
    assembly : Assembly
        Built from a scene; its stages are in `metadata["stages"]`, and in `metadata["absent"]` those of their groups
        that the scene leaves out by choice. These are empty.

    Returns
    -------
    tuple of Stage
        In their order; none without any.

    Raises
    ------
    InputError
        Naming the stage, for an unknown key or group, a block placed twice or never, or a centring under a group that
        is not there yet.
    """
    found: list[Stage] = []
    placed: dict[int, str] = {}
    tables = assembly.metadata.get("stages", ())
    if not isinstance(tables, Sequence) or isinstance(tables, str):
        raise InputError(f'metadata: "stages" is {tables!r}; it is a list of tables')
    for number, stage in enumerate(stages_from(tables)):
        where = f'stages.{number} ("{stage.name}")'
        for block in _blocks(assembly, stage.place, where).tolist():
            if block in placed:
                name = assembly.names[block]
                raise InputError(f'{where}: block "{name}" is put in, but stands since stage "{placed[block]}"')
            placed[block] = stage.name
        absent = _absent(assembly)
        idle = [own for own in stage.centring if own not in absent and not len(_blocks(assembly, (own,), where))]
        if idle:
            raise InputError(f'{where}: all blocks of "{idle[0]}" are supports; nothing of it rests on a centring')
        late = [b for b in _blocks(assembly, stage.centring, where).tolist() if b not in placed]
        if late:
            raise InputError(f'{where}: block "{assembly.names[late[0]]}" is on a centring, but not put in yet')
        found.append(stage)
    missing = [assembly.names[k] for k in assembly.free.tolist() if k not in placed] if found else []
    if missing:
        more = f" (nor are {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise InputError(f'stages: block "{missing[0]}" is never put in{more}')
    return tuple(found)


def _absent(assembly: Assembly) -> Sequence[str]:
    """The groups that the scene leaves out by choice."""
    absent = assembly.metadata.get("absent", ())
    if not isinstance(absent, Sequence) or isinstance(absent, str):
        raise InputError(f'metadata: "absent" is {absent!r}; it is a list of groups')
    return absent


def _blocks(assembly: Assembly, groups: tuple[str, ...], where: str) -> Ints:
    """The free blocks of some groups."""
    chosen = np.zeros(assembly.n_blocks, dtype=bool)
    for group in groups:
        try:
            chosen[assembly.in_group(group)] = True
        except InputError as error:
            if group not in _absent(assembly):
                raise InputError(f"{where}: {error}") from None
    return np.flatnonzero(chosen & ~assembly.support)


@known_options
def assess_stages(
    assembly: Assembly,
    *,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    jobs: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> StagesVerdict:
    """Judge the construction stages that a scene gives its assembly.

    Parameters
    ----------
    assembly : Assembly
        Built from a scene with stages, with dry joints.
    friction, flow, gap
        As of `assess_states`. A stage on a centring is judged by limit analysis whatever the flow: it stands if some
        forces of the centring hold it, and falls if a mechanism proves that none do, wherever its boards push on the
        soffits (see `centring`).
    jobs : int, optional
        As of `assess_states`.
    progress : callable, optional
        Called with the stages and courses judged and all of them. With it, and one process, a KeyboardInterrupt after
        the first leaves the others out, and the outcome is "stopped" unless one of those before is not stable; without
        it, it is raised.

    Returns
    -------
    StagesVerdict
        One verdict a stage, or a course of it.

    Raises
    ------
    InputError
        For an assembly without stages, and for what `stages_of` finds.

    Examples
    --------
    >>> from blockstat import assess_stages
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=5, springers=0.3))
    >>> stages = [{"name": "ring", "place": ["arch"], "centring": ["arch"], "courses": True}, {"name": "decentring"}]
    >>> found = assess_stages(ring.with_(metadata={"stages": stages}))
    >>> [stage.falsework.total > 1.0 for stage in found.stages[:3]], found.stages[-1].outcome.word
    ([False, True, False], 'stable')
    """
    check_choice("flow", flow, FLOWS)
    stages = stages_of(assembly)
    if not stages:
        raise InputError(f'"{assembly.name}" has no stages; write them as [[stages]] in its scene file')
    whole = Whole(assembly, friction=friction, gap=gap)
    present, states = assembly.support.copy(), []
    for stage in stages:
        new = _blocks(assembly, stage.place, stage.name)
        courses = levels(assembly, new, -assembly.gravity) if stage.courses and len(new) else [new]
        for number, level in enumerate(courses):
            present[level] = True
            name = (
                f"{stage.name}, course {number + 1} of {len(courses)}"
                if stage.courses and len(courses) > 1
                else stage.name
            )
            on = _blocks(assembly, stage.centring, stage.name)
            states.append((name, present.copy(), on))
    found = in_stretches(partial(_judged, whole, flow), states, jobs, progress)
    missing = len(states) - len(found)
    every = Unfinished.STOPPED if missing else Outcome.STABLE
    worst = next((stage.outcome for stage in found if stage.outcome is not Outcome.STABLE), every)
    return StagesVerdict(worst, tuple(found), missing)


def _judged(whole: Whole, flow: str, states: list[tuple[str, np.ndarray, Ints]]) -> list[StageVerdict]:
    """The verdicts on some stages, each by its name, the blocks that are there, and those of its centring."""
    return [_verdict(whole, flow, *state) for state in states]


def _verdict(whole: Whole, flow: str, name: str, present: np.ndarray, on: Ints) -> StageVerdict:
    """The verdict on a stage with some blocks on a centring, now or in a later course of it."""
    assembly, free = whole.assembly, int((present & ~whole.assembly.support).sum())
    there = [name for name, is_there in zip(assembly.names, present, strict=True) if is_there]
    if not present[on].any():
        verdict = whole.assess(present, assembly.support, flow=flow, score=False)
        moving = tuple(assembly.names[k] for k in verdict.moving)
        return StageVerdict(name, free, verdict.outcome, verdict.score, moving)
    props = centring(assembly, [assembly.names[k] for k in on], present=there, interfaces=whole.interfaces)
    options: dict[str, Any] = {"least": "total", "interfaces": whole.interfaces, "gap": whole.gap}
    found = falsework(assembly, (there, []), props, **options)
    held = {prop.block for prop in props}
    unpropped = tuple(assembly.names[k] for k in on[present[on]] if assembly.names[k] not in held)
    return StageVerdict(name, free, OF_STATE[found.outcome], np.nan, (), found, unpropped)
