"""Load cases on tilted ground: gravity rotates, and levels and loads stay as they are on upright blocks.

A dam of 1.5 x 2 x 3 m holds water of 2.5 m, which pushes by P = 9810 / 2 x 2.5^2 x 2 = 61.3 kN at a third of its depth.
Tilted by a about y it tips about its toe where W sin a 1.5 + P 2.5 / 3 = W cos a .75, W = 237.6 kN: at 19.198 degrees.
"""

import json
import math
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq

from blockstat import InputError, InputWarning, build, load_case, load_scene
from blockstat.cli.commands import app

pytestmark = pytest.mark.filterwarnings("ignore::blockstat.errors.InputWarning")

SCENE = """\
name = "dam"
[elements.dam]
kind = "box"
size = [1.5, 2, 3]
at = [{x}, {y}, 0]
[loads.water]
kind = "pressure"
level = 2.5
unit_weight = 9810
towards = [-1, 0, 0]
blocks = ["dam"]
[cases.flood]
factors = {{ water = 1.0 }}
[cases.rising]
live = {{ water = 1.0 }}
[cases.light]
factors = {{ water = 1.0 }}
weight = 0.9
"""
W = 2691 * 1.5 * 2 * 3 * 9.81
P = 9810 / 2 * 2.5**2 * 2
#: Beside the origin, at it and at map coordinates.
PLACES = [(-5, 0), (0, 0), (500000, 4500000)]


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "blockstat")


@pytest.fixture
def dam(tmp_path):
    return written(tmp_path, -5, 0)


def written(folder, x, y):
    (folder / "dam.toml").write_text(SCENE.format(x=x, y=y))
    return folder / "dam.toml"


def tips(weight=1.0):
    """The tilt at which the dam tips [degrees]."""

    def turning(a):
        return weight * W * (math.sin(a) * 1.5 - math.cos(a) * 0.75) + P * 2.5 / 3

    return math.degrees(brentq(turning, 0, 1))


def test_the_hand_calculation_is_that_of_the_docstring():
    assert (round(P / 1e3, 1), round(W / 1e3, 1), round(tips(), 3)) == (61.3, 237.6, 19.198)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("case", "weight"), [("flood", 1.0), ("light", 0.9)])
def test_a_dam_on_tilted_ground_tips_where_its_weight_alone_rotates(run, tmp_path, place, case, weight):
    file = written(tmp_path, *place)
    for aside, verdict in ((-0.02, "stable"), (0.02, "unstable")):
        answer = run("check", file, "--case", case, "--tilt", f"y,{-tips(weight) - aside}", "--json")[1]
        assert json.loads(answer)["verdict"] == verdict


def test_a_tilt_of_19_degrees_stands_and_one_of_20_falls(run, dam):
    for tilt, verdict in (("y,-19", "stable"), ("y,-20", "unstable")):
        assert json.loads(run("check", dam, "--case", "flood", "--tilt", tilt, "--json")[1])["verdict"] == verdict


def test_the_multiplier_of_water_on_tilted_ground(run, dam):
    """At 10 degrees what holds is W (.75 cos a - 1.5 sin a); with a friction of 2 it does not slide before."""
    a = math.radians(10)
    expected = W * (0.75 * math.cos(a) - 1.5 * math.sin(a)) / (P * 2.5 / 3)
    tilted = ("--tilt", "y,-10", "--friction", 2)
    found = json.loads(run("limit", dam, "--case", "rising", *tilted, "--json")[1])
    assert found["lower"] == pytest.approx(expected, rel=2e-4)
    rows = {row["case"]: row for row in json.loads(run("cases", dam, *tilted, "--json")[1])["rows"]}
    assert rows["rising"]["lower"] == pytest.approx(expected, rel=2e-4)
    capacity = ("capacity", dam, "--case", "rising", *tilted, "--steps", 2, "--json")
    assert json.loads(run(*capacity)[1])["lower"][0] == pytest.approx(expected, rel=2e-4)


def test_friction_and_ties_of_a_dam_on_tilted_ground(run, dam):
    """It slides where W sin a + P = mu W cos a; a tie down to the ground at 45 degrees holds it beyond 19.198 degrees.

    The tie from the ground at (-8.75, 0, 0) to the edge (-5.75, 0, 3) turns it about its toe by 3 + 1.5 over sqrt(2).
    """
    a = math.radians(10)
    found = json.loads(run("friction", dam, "--case", "flood", "--tilt", "y,-10", "--json")[1])
    assert found["stands"] == pytest.approx((W * math.sin(a) + P) / (W * math.cos(a)), abs=1e-4)
    a = math.radians(22)
    missing = W * (1.5 * math.sin(a) - 0.75 * math.cos(a)) + P * 2.5 / 3
    tie = (
        "tie",
        dam,
        "--between",
        "ground,dam",
        "--points=-8.75,0,0,-5.75,0,3",
        "--case",
        "flood",
        "--friction",
        5,
        "--json",
    )
    found = json.loads(run(*tie, "--tilt", "y,-22")[1])
    assert found["least"] == pytest.approx(missing * math.sqrt(2) / 4.5, rel=1e-4)


COMMANDS = [
    ("check",),
    ("limit", "--load", "1,0,0"),
    ("limit", "--directions", "4"),
    ("cases",),
    ("friction",),
    ("tie", "--between", "ground,dam", "--points=-8.75,0,0,-5.75,0,3"),
    ("report", "-o", "report.html"),
    ("prove", "-o", "proof.json"),
    ("capacity", "--load", "1,0,0"),
    ("settle", "--move", "ground:0,0,-0.01"),
    ("code-check", "--load", "1,0,0"),
    ("reliability", "--uncertain", "friction=uniform,0.5,0.6"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: "-".join(command[:2]))
def test_every_command_makes_the_loads_of_a_case_on_upright_blocks(run, dam, tmp_path, monkeypatch, command):
    seen = []

    def refuse(assembly, *_, **__):
        seen.append(assembly.gravity.tolist())
        raise InputError("seen")

    for name in ("load_case", "load_cases"):
        monkeypatch.setattr(f"blockstat.loading.cases.{name}", refuse)
    monkeypatch.chdir(tmp_path)
    given = () if command[0] == "cases" else ("--case", "flood")
    assert run(command[0], dam, "--tilt", "y,-20", *command[1:], *given)[0] == 2
    assert seen == [[0.0, 0.0, pytest.approx(-9.81, rel=1e-14)]]


def test_the_page_of_a_report_tells_a_tilted_dam_apart(run, dam, tmp_path, monkeypatch):
    monkeypatch.setattr("blockstat.view.assessment._pictures", lambda found: "")
    for tilt, verdict in (("y,-19", "stable"), ("y,-20", "unstable")):
        page = tmp_path / "report.html"
        with pytest.warns(InputWarning, match="rotates gravity alone") as told:
            status, _, _ = run("report", dam, "-o", page, "--directions", 4, "--case", "flood", "--tilt", tilt)
        assert status == 0
        assert sum("rotates gravity alone" in str(one.message) for one in told) == 1
        row = page.read_text().partition("<td>flood</td>")[2].partition("</tr>")[0]
        assert f"<td>{verdict}</td>" in row


def test_a_case_under_another_gravity_keeps_what_acts_beside_the_weight(dam):
    upright = build(load_scene(dam))
    a = math.radians(20)
    tilted = upright.with_(gravity=(9.81 * math.sin(a), 0, -9.81 * math.cos(a)))
    case = load_case(upright, "light")
    found = case.under_gravity_of(tilted)
    np.testing.assert_array_equal(found.beside, case.beside)
    np.testing.assert_allclose(found.beside[1, :3], (P, 0, 0), atol=1e-6)
    lighter = -0.1 * W * np.array([math.sin(a), 0, -math.cos(a)])
    np.testing.assert_allclose(found.permanent[1, :3], (P, 0, 0) + lighter, atol=1e-6)
    np.testing.assert_allclose(found.placed_permanent.wrenches(tilted), found.permanent, atol=1e-6)
