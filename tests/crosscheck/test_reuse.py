"""Evidence of earlier designs decides like a solve, or not at all."""

import numpy as np
import pytest

from blockstat import Memory, Outcome, assess, build, limit_load, load_scene, with_values
from blockstat.analysis.problem import pose
from blockstat.solve.answer import Status
from blockstat.solve.penalty import solve_penalty
from blockstat.spec import scene_from
from evidence.paths import EXAMPLES
from evidence.scenes.small import HUT, arch, running_bond, stack


def hut(thickness):
    scene = {**HUT, "wall": {"thickness": {"value": 0.8, "min": 0.1, "max": 0.9, "step": 0.1}, "height": 1.5}}
    return build(with_values(scene_from(scene), {"wall.thickness": thickness}))


WALKS = [
    ("arch growing thin", lambda x: (arch(12, 0.2 - 0.15 * x), {})),
    ("walls growing thin", lambda x: (hut(0.8 - 0.6 * x), {})),
    ("wall tilted along", lambda x: (running_bond(6, 5), {"gravity": (1.2 * x, 0.05, -1)})),
    ("wall tilted out", lambda x: (running_bond(5, 4), {"gravity": (0, 0.5 * x, -1)})),
    ("stack growing slippery", lambda x: (stack(4, 1.0, 0.3), {"gravity": (0.3, 0, -1), "friction": 0.6 - 0.5 * x})),
]


@pytest.mark.parametrize("walk", WALKS, ids=lambda w: w[0])
def test_same_verdicts_with_and_without_memory(walk):
    memory, outcomes = Memory(), []
    for x in np.linspace(0, 1, 33):
        asm, options = walk[1](x)
        kept, fresh = assess(asm, memory=memory, **options), assess(asm, **options)
        assert Outcome.UNDECIDED in (kept.outcome, fresh.outcome) or kept.outcome is fresh.outcome
        assert kept.solver.startswith("earlier") or kept.score == pytest.approx(fresh.score, abs=1e-9)
        outcomes.append(kept.outcome)
    assert {Outcome.STABLE, Outcome.UNSTABLE} <= set(outcomes)
    assert sum(memory.statistics.values()) == 33
    assert memory.statistics["forces"] > 0


def test_a_mechanism_decides_again():
    memory = Memory()
    for tilt in np.linspace(0.6, 0.9, 7):
        assess(stack(3), gravity=(tilt, 0, -1), memory=memory)
    assert memory.statistics == {"forces": 0, "mechanism": 6, "solved": 1}
    again = assess(stack(3), gravity=(0.65, 0, -1), memory=memory)
    assert again.solver == "earlier mechanism"
    assert np.isnan(again.score)
    assert again.summary()["score"] is None
    assert "nan" not in again.explain()


def test_evidence_of_other_joints_is_not_asked():
    memory = Memory()
    assess(stack(3), memory=memory)
    assess(stack(4), memory=memory)
    assess(arch(10, 0.2), memory=memory)
    assert memory.statistics == {"forces": 0, "mechanism": 0, "solved": 3}


def test_memory_never_crosses_the_limit():
    # Both neighbours of the limit are asked right after the other, so that the wrong evidence is at hand.
    asm = running_bond(5, 4)
    limit = limit_load(asm, (1, 0, 0)).lower
    memory = Memory()
    for k in range(2, 7):
        for sign, outcome in ((-1, Outcome.STABLE), (1, Outcome.UNSTABLE)):
            tilt = limit * (1 + sign * 10.0**-k)
            assert assess(asm, gravity=(tilt, 0, -1), memory=memory).outcome is outcome


@pytest.mark.parametrize("walk", WALKS, ids=lambda w: w[0])
def test_same_verdicts_without_a_score(walk):
    for x in np.linspace(0, 1, 17):
        asm, options = walk[1](x)
        early = assess(asm, score=False, solver="interior-point", **options)
        full = assess(asm, solver="interior-point", **options)
        assert early.outcome is full.outcome
        assert early.score == full.score or (early.outcome is Outcome.UNSTABLE and np.isnan(early.score))


def test_the_first_mechanism_comes_before_the_one_of_least_adhesion():
    asm = hut(0.2)
    problem = pose(asm, friction=None, gravity=None, loads=None, gap=0.01, interfaces=None)
    early, full = (
        solve_penalty(problem.program, solver="interior-point", motions=problem.motions, score=score)
        for score in (False, True)
    )
    assert early.status is Status.MECHANISM
    assert early.iterations < full.iterations
    assert np.isnan(early.adhesion).all()
    assert np.isfinite(full.adhesion).all()


def test_the_first_mechanism_of_a_building_takes_a_fraction_of_the_iterations_of_its_score():
    # Iterates that are kept inside the cones are mechanisms as soon as they gain work. Those that are not have to wait
    # until they close by less than the certificate lets pass, next to the optimum.
    tower = build(load_scene(EXAMPLES / "tower.toml"))
    problem = pose(tower, friction=None, gravity=(4.0, 0, -9.81), loads=None, gap=0.001, interfaces=None)
    early, full = (
        solve_penalty(problem.program, solver="interior-point", motions=problem.motions, score=score)
        for score in (False, True)
    )
    assert early.status is Status.MECHANISM
    assert 3 * early.iterations < full.iterations
