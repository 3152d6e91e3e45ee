import json
import subprocess
import sys

import pytest

from blockstat import Assembly, box, capacity, plot_capacity, write


def wall():
    ground = box((-3, -3, -1), (4, 4, 0), name="ground")
    courses = [box((0, 0, k), (0.5, 1, k + 1), name=f"course {k}", group="wall") for k in range(2)]
    return Assembly.from_blocks([ground, *courses], supports=["ground"], friction=0.8)


def run(*arguments):
    code = "from blockstat.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_the_command_follows_draws_and_explains(tmp_path):
    file, picture = write(wall(), tmp_path / "wall.json"), tmp_path / "capacity.png"
    answer = run("capacity", file, "--load", "1,0,0", "--control", "course 1", "-o", picture, "--json")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert told["outcome"] == "zero"
    assert told["lower"][0] == pytest.approx(0.25, rel=1e-6)
    assert len(told["displacement"]) == len(told["lower"]) == len(told["upper"])
    assert (told["lower"][-1], told["upper"][-1]) == (0, 0)
    # The upper course's centroid is 1.5 m above the toe; the wall falls when that of all is above it.
    turn = 0.25 / (0.25**2 + 1) ** 0.5
    assert told["displacement"][-1] == pytest.approx(0.25 - 0.25 * (1 - turn**2) ** 0.5 + 1.5 * turn, rel=1e-4)
    assert picture.read_bytes().startswith(b"\x89PNG")
    plain = run("capacity", file, "--load", "1,0,0", "--displacement", "0.1", "--control", "course 0:0,0,1")
    assert "Reached" in plain.stdout
    nothing = run("capacity", file, "--load", "1,0,0", "--control", "ground")
    assert nothing.returncode == 2
    assert "does not move" in nothing.stderr


def test_a_group_moves_with_its_mass():
    curve = capacity(wall(), (1, 0, 0), control="wall")
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-6)
    assert "group" in curve.control
    assert "Zero: the multiplier" in curve._repr_html_()


def test_displacements_are_along_the_load():
    curve = capacity(wall(), (-1, 0, 0), control="course 1")
    assert curve.displacement[-1] > 0
    assert curve.points[-1].pose.displacement[2, 0] < 0


def test_the_picture_goes_into_axes_too():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    assert plot_capacity(capacity(wall(), (1, 0, 0), steps=5), axes) is axes
    assert axes.lines
