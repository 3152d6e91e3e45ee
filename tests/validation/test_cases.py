"""Assemblies from other projects: verdicts against independently computed ones (see MANIFEST.md beside them)."""

import json
import warnings

import pytest

from blockstat import InputWarning, Outcome, assess, find_interfaces, limit_load, read

#: What the expectation says of force-only statics. "falls" (H, A) and the shelf stand on paper by self-stress.
STATIC = {
    "stable": "stable",
    "admissible": "stable",
    "falls (statically admissible!)": "stable",
    "stable only if the cone is not shrunk": "stable",
    "slides": "unstable",
    "unstable": "unstable",
}


def test_every_case_gets_the_expected_static_verdict(cases):
    wrong = []
    for row in json.loads((cases / "expected.json").read_text()):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            verdict = assess(read(cases / f"{row['case']}.json"))
        expected = STATIC.get(row["expected"])
        if expected is None:
            assert row["expected"].startswith("limit state")
            continue
        if verdict.outcome.word != expected:
            wrong.append((row["case"], row["expected"], verdict.outcome.word))
    assert wrong == []


@pytest.mark.parametrize("case", ["asm_crossvault", "dem_pavillionvault"])
def test_a_verdict_that_hangs_on_the_gap_tolerance_says_so(cases, case):
    tight = assess(read(cases / f"{case}.json"), gap=1e-3)
    assert tight.outcome.word != "stable"
    assert any("a larger tolerance may change the answer" in text for text in tight.warnings)
    assert any("do not quite close" in text for text in assess(read(cases / f"{case}.json")).warnings)


def names():
    """The cases that are there, when tests are collected."""
    from evidence.paths import CASES

    return sorted(p.stem for p in CASES.glob("*.json") if p.stem != "expected")


@pytest.mark.parametrize("case", names())
@pytest.mark.filterwarnings("ignore::blockstat.errors.InputWarning")
def test_every_solver_gives_the_same_answer(cases, case):
    asm = read(cases / f"{case}.json")
    faces = find_interfaces(asm)
    solvers = ("interior-point", "clarabel", "cvxpy") if asm.n_blocks <= 60 else ("interior-point", "clarabel")
    ours, *others = (assess(asm, interfaces=faces, solver=solver) for solver in solvers)
    for verdict in others:
        assert verdict.outcome is ours.outcome
        assert verdict.score == pytest.approx(ours.score, abs=1e-6)
    if ours.outcome is Outcome.STABLE and asm.n_blocks <= 100:
        one, other = (limit_load(asm, (1, 0.2, 0), interfaces=faces, solver=s, optimum=True) for s in solvers[:2])
        assert one.outcome is other.outcome
        # Both are proven; how near a lower bound comes to the limit hangs on the rounding of a machine.
        assert max(one.lower, other.lower) <= min(one.upper, other.upper) * (1 + 1e-7)
        assert one.lower == pytest.approx(other.lower, rel=1e-5)
