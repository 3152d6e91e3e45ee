"""What processes of the page do with Bullet; each message is sent as soon as it is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.verdict import Verdict
from blockstat.app.background import Channel, Refused
from blockstat.app.design import Model
from blockstat.app.evaluation import rounded
from blockstat.design_search.search import Candidate, search
from blockstat.errors import InputError
from blockstat.typing import Floats
from dynsim.comparison.causes import likely_reason
from dynsim.judge.run import Run, simulate
from dynsim.judge.verdict import DynamicVerdict
from dynsim.judge.verify import verify

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A fall is simulated on, for its film, until a block has gone this far, in block sizes.
FAR = 3.0


@dataclass(frozen=True, eq=False)
class Fallen:
    """Bullet's verdict, with the likely reason where it differs from the static one.

    Attributes
    ----------
    verdict : DynamicVerdict
        Bullet's verdict.
    reason : str
        One sentence; empty where the verdicts agree or no reason is known.
    """

    verdict: DynamicVerdict
    reason: str


@dataclass(frozen=True, eq=False)
class Film:
    """A trajectory to show, in single precision."""

    times: Floats  #: shape (n_frames,) [s]
    displacement: np.ndarray  #: shape (n_frames, n_blocks, 3) [m]
    rotation: np.ndarray  #: shape (n_frames, n_blocks, 3, 3)


@dataclass(frozen=True)
class Step:
    """One more design of a search was evaluated.

    Attributes
    ----------
    done : int
        Designs evaluated so far.
    expected : int
        Designs that the search may need in all.
    candidate : Candidate
        The design.
    """

    done: int
    expected: int
    candidate: Candidate


@dataclass(frozen=True)
class Found:
    """A search is over.

    Attributes
    ----------
    best : dict of str to float or None
        Parameters of the best design, by dotted path; None when no design stood.
    """

    best: dict[str, float] | None = field(default=None)  #: None when no design stood


def let_fall(channel: Channel, static: Verdict) -> None:
    """Verify an assembly in Bullet; of one that falls, go on until the fall can be seen.

    Parameters
    ----------
    channel : Channel
        `Fallen` and then `Film`, or `Refused` alone, are sent through it.
    static : Verdict
        The static verdict on the design on show.
    """
    assembly = static.assembly
    gap = static.interfaces.searched
    try:
        verdict = verify(assembly, gap=gap)  # on joints with the edges that statics may have rounded
    except InputError as error:
        channel.send(Refused(str(error)))
        return
    channel.send(Fallen(verdict, likely_reason(static, verdict)))
    run = verdict.run
    if verdict.outcome.word != "stands":
        far = FAR * float(np.median(assembly.size[assembly.free]))
        run = simulate(assembly, gap=gap, stop=lambda _, moved, __: bool(np.linalg.norm(moved, axis=1).max() > far))
    channel.send(_film(run))


def _film(run: Run) -> Film:
    return Film(run.times, run.displacement.astype(np.float32), run.rotation.astype(np.float32))


def optimise(channel: Channel, model: Model, values: dict[str, float], names: list[str]) -> None:
    """Search some parameters of a scene; statics prune, Bullet confirms.

    Parameters
    ----------
    channel : Channel
        A `Step` for each design and then `Found`, or `Refused`, are sent through it.
    model : Model
        The scene on show.
    values : dict of str to float
        Present values of its parameters, by dotted path; statics judge with the rounded edges of the page.
    names : list of str
        Dotted paths of the parameters to move; the others stay.
    """
    memory = Memory()

    def under(assembly: Assembly) -> Assembly:
        return model.with_material(assembly, values)

    try:
        result = search(
            model.moved(values),
            static=lambda assembly, **options: assess(assembly, memory=memory, score=False, **options),
            verify=partial(verify, gap=model.gap, statics=True),
            under=under,
            memory=memory,
            names=names,
            gap=model.gap,
            imperfections=rounded(values),
            progress=lambda done, expected, last: channel.send(Step(done, expected, last)),
            remark=likely_reason,
        )
    except InputError as error:
        channel.send(Refused(str(error)))
        return
    channel.send(Found(result.best_parameters))
