"""Error against seconds: what the page of choices computes, on tiny scenes with known answers."""

import json
from math import hypot, nan, sqrt

import numpy as np
import pytest

from blockstat import Random, box, capacity
from dynsim import Settings
from evidence.checks.chance import KNOWN
from evidence.choosing import curves, draws, limits, page, runs
from evidence.choosing.picture import TITLES, draw
from evidence.references.linkages import PORTALS, overturning
from evidence.scenes.small import arch, assembly, stack


def test_a_narrower_tolerance_of_a_limit_load_leaves_less_error():
    wall = limits.wall(400)
    rows = limits.series("wall", wall, (1, 0, 0), (1e-2, 1e-3, 1e-5))
    assert [row.tolerances for row in rows] == [(1e-2,), (1e-3,), (1e-5,)]
    for wide, narrow in zip(rows, rows[1:], strict=False):
        assert 0 < narrow.error < 0.5 * wide.error
        assert narrow.width < 0.5 * wide.width
    assert all(row.width <= row.tolerances[-1] for row in rows)
    # The lower end is no further from the middle of the narrowest bracket than the bracket and half of that are wide.
    assert all(row.error <= row.width + rows[-1].width for row in rows)


def test_a_small_scene_has_one_bracket_whatever_the_tolerance():
    (row,) = limits.series("arch", arch(10, 0.2, friction=0.7), (1, 0, 0), (1e-2, 1e-4, 1e-6))
    assert row.tolerances == (1e-2, 1e-4, 1e-6)
    assert "1e-02 to 1e-06" in limits.rows_table([row])


def test_a_scene_that_is_undecided_is_asked_for_no_narrower_bracket():
    rows = limits.series("wall", limits.wall(400), (1, 0, 0), (1e-3, 1e-13, 1e-14))
    assert [row.outcome for row in rows] == ["limit", "undecided"]
    assert rows[-1].tolerances == (1e-13,)
    assert "1 of 1 scenes end undecided" in limits.advice(rows)


def bracketed(tolerance: float, seconds: float, outcome: str = "limit") -> limits.Bracketed:
    return limits.Bracketed("wall", 9, (tolerance,), outcome, tolerance / 2, tolerance / 4, 10, seconds)


def test_the_advice_on_tolerances_has_the_ratios_of_the_seconds():
    rows = [bracketed(1e-2, 1.0), bracketed(1e-4, 2.0), bracketed(1e-5, 3.0), bracketed(1e-6, 24.0)]
    words = limits.advice(rows)
    assert "at most 3.0 times the seconds of 1e-02" in words
    assert "up to 12 times the seconds of the default" in words
    assert "undecided" not in words


def test_a_block_turns_from_width_over_height_to_none():
    assert overturning(0.5, 2.0, np.array([0.0, 0.25])) == pytest.approx([0.25, 0.0])


def test_a_portal_falls_all_along_its_curve():
    for values, end, jumps in PORTALS.values():
        assert (np.diff(values) < 0).all()
        assert all(0 < jump < end for jump in jumps)


def test_a_narrower_tolerance_of_a_curve_leaves_less_error_and_more_points():
    block = curves.known()[0]
    coarse, fine = curves.against_known(block, [(3, 1e-2), (3, 1e-5)])
    assert 0 < fine.error <= 1e-5
    assert fine.error < 0.1 * coarse.error
    assert fine.points > coarse.points
    assert max(coarse.end, fine.end) < 1e-9


def test_the_error_of_a_curve_is_its_distance_from_the_known_one_as_far_as_it_goes():
    curve = capacity(stack(1, 0.5, 2.0, friction=0.9), (1, 0, 0), control="stone0", displacement=0.1)
    places = np.array([0.0, 0.1, 0.2])
    exact = overturning(0.5, 2.0, places)
    assert curves.largest_error(curve, places, exact) < 1e-4
    # Beyond its end a curve says nothing; at rest its multiplier is a quarter.
    assert curves.largest_error(curve, places, exact + (0, 0, 9)) < 1e-4
    assert curves.largest_error(curve, places, exact + (0, 0.05, 0)) == pytest.approx(0.2, abs=1e-4)


def test_walls_are_compared_with_the_run_of_most_steps():
    rows = curves.against_finest("block", stack(1, 0.5, 2.0, friction=0.9), (2, 12))
    assert rows[-1].error == rows[-1].end == 0.0
    assert 0 < rows[0].error < 1e-3
    assert [line.split("|")[-3].strip() for line in curves.walls_table(rows).splitlines()[3:]] == ["-"]


@pytest.mark.parametrize(("name", "width", "height"), [("pillar", 0.5, 2.0), ("wall", 0.2, 6 * 0.175)])
def test_the_imbalance_of_what_turns_over_its_toe_is_the_sine_of_its_slenderness(name, width, height):
    # Work of the excess e of a push of b / h at half the height, over weight times half the diagonal.
    (one,) = [known for known in runs.known() if known.name == name]
    if name == "pillar":
        assert one.imbalance() == pytest.approx(width / hypot(width, height), rel=1e-6)
    else:  # many blocks that turn as one: the mean of their distances from the toe
        blocks = one.scene.centroid[one.scene.free]
        arms = np.hypot(blocks[:, 1] - width, blocks[:, 2])
        mass = one.scene.mass[one.scene.free]
        assert one.imbalance() == pytest.approx(mass.sum() * width / 2 / (mass @ arms), rel=1e-6)


def test_a_finer_resolution_misses_less_of_a_pillar_that_tips():
    pillar = runs.known()[0]
    coarse, fine = (runs.judged(pillar, "x", Settings(resolution=r), within=1e-3) for r in (1e-2, 1e-3))
    assert 0 < fine.missed < 0.5 * coarse.missed
    assert coarse.missed < 1e-2
    assert 0 < coarse.excess < 0.06


def judged(setting: str, resolution: float, low: float, high: float, *, preset: bool = False) -> runs.Judged:
    return runs.Judged("arch", setting, resolution, preset, low, high, (low + high) / 0.2, 1 / sqrt(resolution))


def test_what_falls_before_its_limit_missed_nothing():
    assert judged("x", 1e-3, 0.010, 0.011).missed == 0.010
    assert judged("x", 1e-3, -0.011, -0.010).missed == -0.010
    assert judged("x", 1e-3, -0.001, 0.001).missed == 0.0


def test_the_advice_on_resolutions_names_the_worst_of_each_preset():
    rows = [judged("resolution 1e-02", 1e-2, 0.004, 0.005), judged("default", 1e-3, -0.002, -0.001)]
    rows.append(judged("fast", 1e-3, -0.02, -0.01, preset=True))
    words = runs.advice(rows)
    assert "more than 0.40 times its resolution" in words
    assert "of the arch +4.5 and -1.5 %" in words
    assert "takes up to 3.2 times the seconds" in words
    assert "fast -15.0 %, default -1.5 %" in words


def test_more_draws_leave_less_error_as_theory_says():
    few, many = draws.probabilities(KNOWN[1], {20: 12, 240: 12})
    assert few.expected == pytest.approx(sqrt(12) * many.expected)
    for row in (few, many):  # a root mean square of twelve scatters by a fifth
        assert row.error == pytest.approx(row.expected, rel=0.5)
    assert many.interval < few.interval / 2
    assert few.interval > few.error


def test_draws_about_the_design_point_have_a_narrower_interval():
    (plain,) = draws.probabilities(KNOWN[1], {200: 3})
    (weighted,) = draws.probabilities(KNOWN[1], {200: 3}, draws.DESIGN)
    assert weighted.interval < 0.8 * plain.interval


def test_the_median_of_a_slab_comes_near_its_friction():
    (row,) = draws.medians({50: 3})
    assert 0 < row.error < 3 * row.expected
    assert row.seconds > 0


def test_more_draws_of_a_building_go_on_from_those_it_has():
    block = assembly([box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 2))])
    few, many = draws.building(block, {"push": Random("uniform", 0.4, 0.6)}, [10, 40])
    assert (few.draws, many.draws) == (10, 40)
    assert many.seconds >= few.seconds
    assert many.interval < few.interval
    assert np.isnan(few.error)


def sampled(about: str, number: int, interval: float, seconds: float) -> draws.Sampled:
    return draws.Sampled(KNOWN[-1].name, about, number, 2, interval / 2, nan, interval, seconds)


def test_the_advice_on_draws_compares_the_intervals():
    rows = [sampled(draws.MEAN, 25, 0.8, 1.0), sampled(draws.MEAN, 100, 0.4, 4.0)]
    rows += [sampled(draws.DESIGN, 25, 0.2, 2.0), sampled(draws.DESIGN, 100, 0.1, 6.0)]
    first = draws.First(0.12, 0.05)
    words = draws.advice(rows, first)
    assert "4 times the draws divide the interval by 2.0" in words
    assert "it is 4.0 times narrower" in words
    assert "1.5 times the seconds" in words
    assert "off by 12 %" in words
    table = draws.rows_table(rows, first).splitlines()
    assert table[-1].startswith(f"| {KNOWN[-1].name} | first order | - | - | 12.0 |")


def measured() -> dict:
    linkages = [curves.Followed("block", 3, t, 9, "zero", t, 0.25, 0.0, 1e-4 / t) for t in (1e-2, 1e-4)]
    walls = [curves.Followed("wall", n, 1e-4, n, "zero", e, 0.1, e, n) for n, e in ((5, 0.1), (9, 0.0))]
    judgements = [judged(f"resolution {r:.0e}", r, 0.004, 0.005) for r in (1e-2, 1e-3)]
    judgements.append(judged("fast", 1e-3, -0.02, -0.01, preset=True))
    samples = [sampled(draws.MEAN, 25, 0.8, 1.0), sampled(draws.DESIGN, 25, 0.2, 2.0)]
    limit = [bracketed(1e-2, 1.0), bracketed(1e-4, 2.0)]
    return {
        "limits": limit,
        "curves": (linkages, walls),
        "runs": judgements,
        "draws": (samples, draws.First(0.1, 0.1)),
    }


def test_figures_are_plain_values_and_every_choice_has_a_table_and_advice():
    figures = json.loads(json.dumps(page.figures_of(measured())))
    assert [row["setting"] for row in figures["runs"]] == ["resolution 1e-02", "resolution 1e-03", "fast"]
    assert figures["first_order"] == {"error": 0.1, "seconds": 0.1}
    parts = page.parts_of(measured())
    for name in TITLES:
        assert parts[f"{name}-advice"].startswith("- ")
    assert all(parts[name].startswith("|") for name in ("limits", "linkages", "walls", "runs", "draws"))
    assert page.parts_of({"limits": measured()["limits"]}).keys() == {"limits", "limits-advice"}


def test_the_picture_has_a_logarithmic_panel_a_choice():
    found = measured()
    figure = draw(found["limits"], found["curves"], found["runs"], found["draws"][0])
    titles = [axis.get_title() for axis in figure.axes]
    assert titles == [title for title, _ in TITLES.values()]
    assert {(axis.get_xscale(), axis.get_yscale()) for axis in figure.axes} == {("log", "log")}
    assert all(len(axis.get_lines()) > 0 for axis in figure.axes)
