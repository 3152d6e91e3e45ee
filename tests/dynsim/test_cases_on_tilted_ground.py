"""Load cases in Bullet on tilted ground: gravity rotates, and levels and loads stay as they are on upright blocks."""

import json
import math
from functools import partial

import pytest

from dynsim.cli.commands import app

pytestmark = pytest.mark.filterwarnings("ignore::blockstat.errors.InputWarning")

SCENE = """\
name = "dam"
[elements.dam]
kind = "box"
size = [1.5, 2, 3]
at = [-5, 0, 0]
[loads.water]
kind = "pressure"
level = 2.5
unit_weight = 9810
towards = [-1, 0, 0]
blocks = ["dam"]
[cases.flood]
factors = { water = 1.0 }
[cases.rising]
live = { water = 1.0 }
[cases.light]
weight = 0.9
"""
#: Weight of the dam, and the push of the water on its 2 m [N].
W, P = 2691 * 1.5 * 2 * 3 * 9.81, 9810 / 2 * 2.5**2 * 2


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "dynsim")


@pytest.fixture
def dam(tmp_path):
    (tmp_path / "dam.toml").write_text(SCENE)
    return tmp_path / "dam.toml"


def test_a_dam_on_tilted_ground_falls_beyond_the_tilt_at_which_it_tips(run, dam):
    """W sin a 1.5 + P 2.5 / 3 = W cos a .75 at 19.198 degrees."""
    for tilt, outcome in (("y,-18.7", "stands"), ("y,-19.7", "falls")):
        answer = run("verify", dam, "--case", "flood", "--tilt", tilt, "--json")[1]
        assert json.loads(answer)["verdict"] == outcome


def test_the_multiplier_of_water_on_tilted_ground(run, dam):
    a = math.radians(10)
    expected = W * (0.75 * math.cos(a) - 1.5 * math.sin(a)) / (P * 2.5 / 3)
    asked = ("--case", "rising", "--tilt", "y,-10", "--friction", 2, "--no-check", "--json")
    found = json.loads(run("limit", dam, *asked)[1])
    assert 0.98 * expected < found["lower"] < found["upper"] < 1.02 * expected


def test_a_factor_on_the_weight_is_refused_beside_ground_that_tilts_during_the_run(run, dam):
    status, _, told = run("verify", dam, "--case", "light", "--tilt-to", "y,-5")
    assert status == 2
    assert told.endswith(
        '--tilt-to y,-5 rotates the weight as drawn; the factor 0.9 on it in case "light" would not rotate\n'
    )
