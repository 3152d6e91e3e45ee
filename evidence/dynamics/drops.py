"""How far a vault comes down in Bullet, by Eq. 1 of the procedural-masonry paper, at given times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from blockstat import Assembly
from dynsim import Action, Run, Settings, simulate
from dynsim.judge.criteria import drops, group_box_centre

TIMES = (1.0, 2.0, 4.0, 10.0)  #: since release [s]


def watched(asm: Assembly, settings: Settings, actions: Sequence[Action]) -> Run:
    """A run of the last of `TIMES`, whatever happens."""
    pace = simulate(asm, settings=replace(settings, end=0.5, settle=0.02)).pace
    return simulate(asm, settings=replace(settings, end=1.02 * TIMES[-1] * pace), actions=actions)


def vault_drop(run: Run) -> np.ndarray:
    """Eq. 1 for the group "vault" at `TIMES` [m]."""
    asm = run.assembly
    vault = asm.in_group("vault")
    frames = np.minimum(np.searchsorted(run.times, TIMES), len(run.times) - 1)
    centres = [group_box_centre(asm, vault, run.displacement[k], run.rotation[k]) for k in (0, *frames)]
    return drops(asm, np.array(centres[1:]) - centres[0])
