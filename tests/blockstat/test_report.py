"""The report of an assessment: everything an engineer hands over, on one page."""

import re
import subprocess
import sys
from dataclasses import replace
from datetime import date
from importlib.metadata import version

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import same_color
from matplotlib.figure import Figure

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Site,
    Tie,
    assess,
    assess_fully,
    assessment_html,
    box,
    load_scene,
    plot_directions,
    plot_thrust,
    write,
)
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.analysis.verdict import Outcome
from blockstat.loading.cases import LoadCase
from blockstat.view import assessment
from blockstat.view.plot import joint_resultants
from blockstat.view.thrust_lines import THRUST, WIDEST, thrust_lines
from evidence.scenes.small import arch, prism
from tests.browser import CHAPEL, FLAGS, browser_path


def slab(**options):
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab <1>")]
    return Assembly.from_blocks(blocks, supports=["ground"], name="slab & ground", **options)


def words(html):
    """What a reader sees."""
    body = html.partition("<body>")[2]
    return " ".join(re.sub(r"<[^>]*>", " ", body).split())


@pytest.fixture(scope="module")
def page():
    return assessment_html(assess_fully(slab(density=2000.0, friction=0.6), directions=4), day=date(2026, 1, 2))


def test_the_page_says_what_was_assumed(page):
    text = words(page)
    for fact in (
        "friction 0.6 ", "density 2000 kg/m3", "gravity 9.81 m/s2", "upward axis z", "units of the file m;",
        "gap faces count as touching up to", "weight of the free blocks 19.62 kN", "2026-01-02",
        f"blockstat {version('blockstat')}",
        "joint laws none", "supports ground",
    ):  # fmt: skip
        assert fact in text


def test_the_page_gives_all_verdicts_and_the_least_direction(page):
    text = words(page)
    assert "Force fields alone (associated friction): stable" in text
    assert "Without dilatancy and self-stress (Coulomb friction): stable" in text
    assert "Simulation (Bullet) Not asked for." in text
    assert "is 0.25 times gravity, towards +y." in text
    assert "Least limit load (associated friction): 0.25 " in text
    assert "Real joints may carry less." in text
    assert "Mechanism of the limit load, 0.5 towards -x." in text
    assert text.index("Sources of the method") > text.index("Warnings None.")


def test_the_least_limit_load_has_what_is_carried_without_dilatancy_beside_it(page, monkeypatch):
    """A slab .5 m deep and 2 m high tips at .25 without sliding: dilatancy gives it nothing."""
    text = words(page)
    low, high = map(
        float, re.search(r"self-stress ([\d.]+) is carried in that direction, and ([\d.]+) is", text).groups()
    )
    assert low <= 0.25 <= high <= 1.01 * low
    monkeypatch.setattr(assessment, "FEW", 0)
    many = words(assessment_html(assess_fully(slab(), directions=4)))
    assert "blockstat limit FILE --load=0,1,0 --flow coulomb finds how much" in many
    for found in (text, many):
        assert "flow=" not in found
        assert "tightnesses=" not in found


def test_what_only_self_stress_holds_carries_nothing_without_it():
    """A stone between two walls that nothing presses together: friction holds it on paper."""
    walls = [box((-1, 0, 0), (0, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="right")]
    jammed = Assembly.from_blocks([*walls, box((0, 0, 0), (1, 1, 1), name="stone")], supports=["left", "right"])
    found = assess_fully(jammed, directions=4)
    assert found.coulomb.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    stands = replace(found, directions=assess_fully(slab(), directions=4).directions)
    assert "Without dilatancy and self-stress none is carried" in words(assessment_html(stands))


def test_what_is_not_there_has_no_heading(page):
    assert all(f"<h2>{title}</h2>" not in page for title in ("Load cases", "Ties", "Code check"))
    assert "ties none" in words(page)


def test_the_code_check_of_all_four_directions():
    """The slab tips as one body, e* = 1: ag S = q a0*/g = 2 alpha0 / 1.35 towards +y, with S = 1 on rock."""
    site = {"site": Site(), "behaviour": 2.0}
    html = assessment_html(assess_fully(slab(), directions=4, code={**site, "demand": 0.38}))
    text = words(html)
    assert "Code check (linear): not satisfied" in text
    assert f"Least towards +y: ag = {2 * 0.25 / 1.35:.4g} g at SLV, asked for 0.38 g." in text
    assert f"-x 0.5 1 1 1 {0.5 * 9.81 / 1.35:.4g} {0.5 / 1.35:.4g} {1 / 1.35:.4g} satisfied" in text
    assert "alpha0 is with associated friction" in text
    assert "Circolare 21 gennaio 2019" in text[text.index("Sources of the method") :]
    assert "Code check (linear): capacity" in words(assessment_html(assess_fully(slab(), directions=4, code=site)))


def test_a_direction_without_a_limit_is_left_out_of_the_code_check_by_name(monkeypatch):
    """Nothing is verified of a slab that falls under its weight; of others the answer is open where a limit is."""
    code = {"site": Site(), "demand": 0.15}
    text = words(assessment_html(assess_fully(slab(gravity=(0, -5, -9.81)), directions=4, code=code)))
    falls = LoadOutcome.DEAD_LOAD_UNSTABLE.value
    assert f"Code check (linear): not verified Not verified towards +x, +y, -x, -y: {falls}" in text
    assert "-y - - - - - - - dead load unstable" in text
    assert "Circolare 21 gennaio 2019" in text[text.index("Sources of the method") :]

    found = assess_fully(slab(), directions=4, code=code).directions
    for outcome, demand, answer in (
        (LoadOutcome.UNDECIDED, 0.15, "not verified"),
        (LoadOutcome.UNBOUNDED, 0.15, "satisfied"),
        (LoadOutcome.UNDECIDED, 0.38, "not satisfied"),
    ):
        limits = [
            replace(limit, outcome=outcome) if name == "+y" else limit
            for name, limit in zip(found.names, found.limits, strict=True)
        ]
        without = replace(found, limits=tuple(limits))
        monkeypatch.setattr(assessment, "limit_load_by_direction", lambda *_, without=without, **__: without)
        text = words(assessment_html(assess_fully(slab(), directions=4, code={**code, "demand": demand})))
        assert f"Code check (linear): {answer} Least towards -y: ag = {2 * 0.25 / 1.35:.4g} g" in text
        assert f"Not verified towards +y: {outcome.value}" in text
        assert f"+y - - - - - - - {outcome.word}" in text


def test_a_direction_off_the_axes_that_may_carry_less_leaves_the_code_check_open(monkeypatch):
    found = assess_fully(slab(), directions=8).directions
    for lower, answer in ((0.0, "not verified"), (1.0, "satisfied")):
        wide = {"outcome": LoadOutcome.UNDECIDED, "lower": lower, "upper": np.inf}
        limits = [
            replace(limit, **wide) if name == "45 deg" else limit
            for name, limit in zip(found.names, found.limits, strict=True)
        ]
        without = replace(found, limits=tuple(limits))
        monkeypatch.setattr(assessment, "limit_load_by_direction", lambda *_, without=without, **__: without)
        text = words(assessment_html(assess_fully(slab(), directions=8, code={"site": Site(), "demand": 0.15})))
        assert f"Code check (linear): {answer} Least towards" in text
        assert ("Not verified towards 45 deg" in text) is (answer == "not verified")


def test_ties_are_listed_with_their_forces():
    """A tie of 1 kN at 2 m holds a slab of 19.62 kN that tips about its edge: alpha = .25 + 2 / 19.62."""
    tie = Tie(("ground", "slab <1>"), ((0.5, -4, 2), (0.5, 0, 2)), greatest=1000.0, name="back")
    text = words(assessment_html(assess_fully(slab(density=2000.0, ties=[tie]), directions=4)))
    assert "back ground and slab &lt;1&gt; tie 0 to 1" in text
    assert re.search(r"tie 0 to 1 \S+ 0 ", text)  # at the least limit load, towards the tie, it is slack
    assert f"+y {0.25 + 2 / 19.62:.5g}" in text


def test_the_page_loads_nothing_and_escapes_names(page):
    assert not re.search(r'(src|href)="(?!data:)', page)
    assert "slab &amp; ground" in page
    # The blocks, their forces, the thrust, the horizon, and the mechanisms of four directions.
    assert page.count("data:image/png;base64,") == 8
    assert 'name="viewport"' in page
    assert "@media print" in page


def test_joint_laws_and_densities_are_listed():
    laws = [JointLaw(("*", "*"), tension=1e5, friction=0.4)]
    text = words(assessment_html(assess_fully(slab(joints=laws), directions=4)))
    assert "between * and *: friction 0.4, tension 100000" in text


def test_what_falls_shows_its_mechanism_and_no_forces():
    found = assess_fully(slab(gravity=(0, -5, -9.81)), directions=4)
    text = words(assessment_html(found))
    assert "Force fields alone (associated friction): unstable" in text
    assert "How the blocks move first under the weight of the blocks." in text
    assert "Resultants" not in text
    assert "dead load unstable" in text


def test_the_picture_of_a_fall_says_what_the_blocks_fall_under():
    """A slab of 0.5 m by 2 m tips when pushed at its centre by more than 0.25 of its weight."""
    weight = slab().free_weight
    push = np.zeros((2, 6))
    push[1, 1] = 0.3 * weight
    case = LoadCase("wind", np.zeros((2, 6)), push, combination="1 x push")
    for options, acting in (
        ({"case": case}, "all loads of the case &quot;wind&quot;: 1 x push."),
        ({"loads": push}, "the weight of the blocks, and further loads."),
    ):
        found = assess_fully(slab(), directions=4, **options)
        assert f"How the blocks move first under {acting}" in words(assessment_html(found))
    undecided = replace(found, associated=replace(found.associated, outcome=Outcome.UNDECIDED))
    text = words(assessment_html(undecided))
    assert "How the blocks might move under the weight of the blocks, and further loads. Nothing is proven" in text
    assert "move first" not in text.partition("Evidence")[0]
    still = replace(undecided, associated=replace(undecided.associated, mechanism=np.zeros((2, 6))))
    assert "might move" not in words(assessment_html(still))


def test_the_reason_why_a_direction_is_undecided_is_told_once_and_with_its_name():
    found = assess_fully(slab(), directions=4, code={"site": Site()})
    reason = "blocks a and b touch edge along edge"
    limits = list(found.directions.limits)
    for k in map(found.directions.names.index, ("+x", "-y")):
        limits[k] = replace(limits[k], outcome=LoadOutcome.UNDECIDED, lower=0.1, warnings=(reason,))
    wide = replace(found.directions, limits=tuple(limits), warnings=(reason, "joints are thin"))
    told = [f"undecided towards +x, -y: {reason}", "joints are thin"]
    assert list(replace(found, directions=wide, pushed=wide).warnings) == told
    assert wide.summary()["undecided"] == [{"reason": reason, "towards": ["+x", "-y"]}]
    # Without the live loads of a case, the code check has limit loads and reasons of its own.
    html = assessment_html(replace(found, pushed=wide))
    assert html.count(reason) == 1
    assert f"code check: undecided towards +x, -y: {reason}" in html


def test_both_verdicts_are_undecided_where_only_crushing_an_edge_lets_it_fall():
    wedge = prism([(1, 1), (2, 0.8), (2, 1.2)], 0.5, name="wedge")
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, -1, 0), (1, 1, 2), name="slab"), wedge]
    law = JointLaw(("*", "*"), compression=5e6)
    leaning = Assembly.from_blocks(blocks, supports=["ground", "wedge"], joints=[law], gravity=(7, 0, -9.81))
    found = assess_fully(leaning, directions=4)
    assert (found.associated.outcome.word, found.coulomb.outcome.word) == ("undecided", "undecided")
    with pytest.raises(InputError, match="no limit loads to draw: Undecided"):
        plot_directions(found.directions, "horizon.svg")


def test_a_simulation_stands_beside_the_statics():
    pytest.importorskip("pybullet")
    import dynsim

    text = words(assessment_html(assess_fully(slab(), directions=4, verify=dynsim.verify)))
    assert "Simulation (Bullet): stands" in text


@pytest.fixture(scope="module")
def ring():
    """The verdict on an arch of nine voussoirs with the inner radius .85 and the outer one 1.15."""
    return assess(arch(9, 0.3))


def joints_from_left_to_right(verdict):
    """Centres of pressure of the joints of an arch, and the forces on what is to their right."""
    joint, point, force, _ = joint_resultants(verdict)
    first, second = verdict.assembly.centroid[verdict.interfaces.pair[joint], 0].T
    order = np.argsort(point[:, 0])
    return point[order], (np.sign(second - first)[:, None] * force)[order]


def test_the_forces_of_an_arch_balance_each_voussoir(ring):
    """The thrust is the same at all joints, the shear changes by the weights, and moments about centroids cancel."""
    point, force = joints_from_left_to_right(ring)
    own = ring.assembly.free
    assert len(point) == len(own) + 1
    assert force[0, 0] > 0
    np.testing.assert_allclose(force[:, 0], force[0, 0], rtol=1e-6)
    np.testing.assert_allclose(-np.diff(force[:, 2]), ring.assembly.mass[own], rtol=1e-6)  # gravity is 1
    arms = (point[:-1] - ring.assembly.centroid[own], point[1:] - ring.assembly.centroid[own])
    left, right = (np.cross(arm, push)[:, 1] for arm, push in zip(arms, (force[:-1], force[1:]), strict=True))
    np.testing.assert_allclose(left, right, atol=1e-7)


def test_the_thrust_of_an_arch_runs_from_its_crown_through_the_centres_of_pressure(ring):
    point, force = joints_from_left_to_right(ring)
    radius = np.hypot(point[:, 0], point[:, 2])
    assert ((radius > 0.85 - 1e-9) & (radius < 1.15 + 1e-9)).all()
    lines, carried = thrust_lines(ring)
    order = np.argsort(lines[:, :, 0].mean(axis=1))
    left, right = lines[order][:5], lines[order][5:]
    np.testing.assert_array_equal(left[:-1, 0], left[1:, 1])
    np.testing.assert_array_equal(right[1:, 0], right[:-1, 1])
    # Nothing lies on the voussoir at the crown: what it carries to both sides begins at its centroid.
    crown = ring.assembly.centroid[ring.assembly.names.index("voussoir4")]
    np.testing.assert_array_equal([left[-1, 0], right[0, 0]], [crown, crown])
    np.testing.assert_array_equal([*left[:, 1], *right[:, 1]], point)
    size = np.linalg.norm(force, axis=1)
    np.testing.assert_allclose(carried[order], [*size[1:5], size[4], size[5], *size[5:9]], rtol=1e-9)


def test_the_picture_of_a_thrust_says_where_nothing_is_in_equilibrium(ring):
    fallen = assess(arch(12, 0.08))
    assert fallen.outcome is Outcome.UNSTABLE
    titles = []
    for verdict in (ring, fallen):
        axes = Figure().add_subplot()
        plot_thrust(verdict, axes)
        titles.append("not in equilibrium" in axes.get_title())
    assert titles == [False, True]


def test_the_picture_of_a_thrust_has_its_lines_as_wide_as_their_forces(ring):
    axes = Figure().add_subplot()
    assert plot_thrust(ring, axes, azimuth=-90, elevation=0) is axes  # x to the right, z upwards
    (drawn,) = (
        own for own in axes.collections if isinstance(own, LineCollection) and same_color(own.get_colors()[0], THRUST)
    )
    lines, force = thrust_lines(ring)
    np.testing.assert_allclose(drawn.get_segments(), lines[:, :, [0, 2]], atol=1e-12)
    np.testing.assert_allclose(np.square(drawn.get_linewidths()) / WIDEST**2, force / force.max(), rtol=1e-9)


def test_the_command_writes_the_page_and_refuses_other_files(tmp_path):
    file = write(slab(), tmp_path / "slab.json")
    code = "from blockstat.cli.commands import main; main()"

    def run(*arguments):
        command = [sys.executable, "-c", code, "report", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True)

    # A slab tips at depth / height = .25 of its weight; with .9 of the weight to hold it down, at .225.
    loads = tmp_path / "loads.toml"
    loads.write_text('[cases.light]\nweight = 0.9\n[cases.heavy]\ndescription = "snow"\nweight = 1.1\n')
    answer = run(file, "-o", tmp_path / "light.html", "--directions", 4, "--loads", loads, "--case", "light")
    assert answer.returncode == 0, answer.stderr
    text = words((tmp_path / "light.html").read_text())
    assert "is 0.225 times gravity" in text
    assert "loads light: 0.9 weight " in text
    assert "heavy snow (1.1 weight) stable no live loads" in text
    answer = run(file, "-o", tmp_path / "report.html", "--directions", 4, "--friction", 0.5)
    assert answer.returncode == 0, answer.stderr
    assert "friction 0.5 " in words((tmp_path / "report.html").read_text())
    code_check = ["--directions", 4, "--ag", 0.15, "--soil", "B", "--tc", 0.3]
    answer = run(file, "-o", tmp_path / "code.html", *code_check)
    assert answer.returncode == 0, answer.stderr
    assert "on soil B, S_T 1, F0 2.5, TC* 0.3 s. Asked for at SLV: ag = 0.15 g." in words(
        (tmp_path / "code.html").read_text()
    )
    assert "which needs --ag" in run(file, "-o", tmp_path / "code.html", "--soil", "B").stderr
    assert "it is written as: .html, .htm" in run(file, "-o", tmp_path / "report.pdf").stderr
    assert "no such directory" in run(file, "-o", "/nowhere/report.html").stderr


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_fits_a_screen_and_a_telephone(page, tmp_path, width):
    executable = browser_path()
    from playwright.sync_api import sync_playwright

    file = tmp_path / "report.html"
    file.write_text(page)
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=list(FLAGS))
        tab = browser.new_page(viewport={"width": width, "height": 900})
        requests = []
        tab.on("request", lambda request: requests.append(request.url))
        tab.goto(file.as_uri())
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        columns = tab.evaluate("getComputedStyle(document.querySelector('.pictures')).gridTemplateColumns").split()
        assert len(columns) == (2 if width > 640 else 1)
        assert tab.pdf(format="A4").startswith(b"%PDF")
        assert all(url.startswith(("file:", "data:")) for url in requests)
        browser.close()


@pytest.mark.slow
def test_the_report_of_a_search_fits_a_telephone(tmp_path):
    executable = browser_path()
    from types import SimpleNamespace

    from playwright.sync_api import sync_playwright

    from blockstat.design_search.search import search
    from blockstat.view.report import write_report

    scene = tmp_path / "hut.toml"
    scene.write_text(CHAPEL)
    stands = SimpleNamespace(outcome=SimpleNamespace(word="stands"))
    result = search(load_scene(scene), static=assess, verify=lambda _: stands, names=["wall.thickness"])
    file = write_report(result, tmp_path, [])
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=list(FLAGS))
        tab = browser.new_page(viewport={"width": 390, "height": 844})
        tab.goto(file.as_uri())
        # The history has eight columns: it scrolls by itself, and the page does not.
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390
        assert tab.evaluate("[...document.querySelectorAll('.wide')].some(part => part.scrollWidth > 390)")
        browser.close()
