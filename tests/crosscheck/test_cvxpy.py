"""The fast path against the literal program in cvxpy: the same score and the same verdict."""

import numpy as np
import pytest

from blockstat import assess
from blockstat.contact import find_interfaces
from blockstat.equilibrium import equilibrium, split_floating, weight
from blockstat.program import penalty_program
from blockstat.solve import clarabel_dual, cvxpy_primal
from problems import SCENES


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_verdict_and_score(scene):
    _, make, options = scene
    direct, literal = assess(make(), **options), assess(make(), solver="cvxpy", **options)
    assert direct.outcome is literal.outcome
    assert direct.score == pytest.approx(literal.score, abs=1e-6)


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_energy_before_any_certificate(scene):
    _, make, options = scene
    asm = make().with_(**options)
    faces = find_interfaces(asm)
    held, _ = split_floating(asm, faces)
    program = penalty_program(
        equilibrium(asm, faces, weight(asm), held, np.arange(faces.n_points)),
        np.full(faces.n_points, asm.friction),
    )
    direct, literal = clarabel_dual.solve(program), cvxpy_primal.solve(program)
    total = np.abs(program.load).sum()
    assert np.linalg.norm(direct.adhesion) / total == pytest.approx(np.linalg.norm(literal.adhesion) / total, abs=1e-6)
