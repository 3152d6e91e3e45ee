"""Shear walls of a laboratory (doi 10.1007/s10518-017-0188-5) against the statics; skipped without the data."""

import numpy as np
import pytest

from blockstat import limit_load
from evidence.experiments import compare, predict
from evidence.experiments.walls import FILE, Wall

MONOLITH = Wall("wall", "WS", 1.0, 1.2, 0.2, 0.2, 8, 1.325, 100e3, 73e6)

needs_data = pytest.mark.skipif(not FILE.is_file(), reason="no directory of experiments")


def test_a_wall_carries_no_more_than_one_block_that_turns_about_its_toe():
    # (N + W) L / (2 H0) for the monolith, W = 4.8 kN; a wedge at the foot that stays behind takes at most W L / (2 H0).
    assembly = MONOLITH.blocks(0.65)
    assert assembly.n_blocks == 1 + 4 * 5 + 4 * 6 + 1
    found = limit_load(assembly, MONOLITH.push(assembly))
    rigid, weightless = 104.8 / 2 / 1.325, 100 / 2 / 1.325
    assert weightless < found.lower <= found.upper < rigid


def test_the_toe_of_a_wall_that_crushes_stands_inside_the_edge():
    # The axial load stands on at least N / (f t) of the foot, so its arm is shorter by half of that.
    weak = Wall("weak", "WS", 1.0, 1.2, 0.2, 0.2, 8, 1.325, 100e3, 5e6)
    plain, crushing = (weak.blocks(0.65, crushing=crushing) for crushing in (False, True))
    bound = (100 * (0.5 - 100e3 / (5e6 * 0.2) / 2) + 4.8 / 2) / 1.325
    assert limit_load(crushing, weak.push(crushing)).lower < bound < limit_load(plain, weak.push(plain)).lower


@needs_data
def test_all_tests_have_a_committed_prediction():
    found = predict.predictions()
    assert [test["id"] for test in compare.tests()] == list(found)
    assert all(len(row) == len(predict.KINDS) * len(predict.FRICTIONS) for row in found.values())


@needs_data
def test_the_committed_predictions_are_what_the_statics_say():
    found = predict.predictions()
    for wall in [w for w in predict.walls() if w.name in ("WS.40", "SW.250.1")]:
        for mu in (0.5, 0.8):
            assembly = wall.blocks(mu)
            limit = limit_load(assembly, wall.push(assembly))
            assert limit.lower == pytest.approx(found[wall.name]["associated", mu], abs=2e-3)


@needs_data
def test_granite_walls_are_within_six_percent_on_the_mean():
    # Vasconcelos 2005; Vasconcelos and Lourenco 2009. At 250 kN that takes joints that crush.
    rows = [(test, predict.predictions()[test["id"]]) for test in compare.tests()]
    loads = {test["axial"]["load_kN"] for test, _ in rows if test["series"] == "WS"}
    assert loads == {40.0, 100.0, 175.0, 250.0}
    for load in loads:
        own = [row for row in rows if row[0]["series"] == "WS" and row[0]["axial"]["load_kN"] == load]
        for mu in predict.FRICTIONS:
            ratio = np.mean([np.mean(compare.measured(test)) / forces["crushing", mu] for test, forces in own])
            assert 0.94 < ratio < 1.06


@needs_data
def test_the_comparison_on_the_page_is_that_of_the_data(monkeypatch, tmp_path):
    from evidence import results
    from evidence.paths import RESULTS

    shown = results.load(RESULTS / "experiments_measured.md")[1]
    rows = [(test, predict.predictions()[test["id"]]) for test in compare.tests()]
    assert shown["means"] == compare.means(rows)
    assert shown["misses"] == compare.misses(rows)
    assert all(test["id"] in shown["walls"] for test, _ in rows)
