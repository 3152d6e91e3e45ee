import json
import subprocess
import sys

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    Tie,
    acceleration,
    box,
    capacity,
    load_case,
    plot_capacity,
    point_load,
    settle_to_collapse,
    write,
    write_path,
)


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


def track(path, node, what):
    """All keys of an animated node, and their times."""
    data = path.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    content, binary = json.loads(data[20 : 20 + length]), data[28 + length :]

    def read(accessor, count):
        accessor = content["accessors"][accessor]
        view = content["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, np.float32, accessor["count"] * count, start).reshape(-1, count)

    number = next(k for k, one in enumerate(content["nodes"]) if one["name"] == node)
    (animation,) = content["animations"]
    channel = next(one for one in animation["channels"] if one["target"] == {"node": number, "path": what})
    sampler = animation["samplers"][channel["sampler"]]
    return read(sampler["output"], 4 if what == "rotation" else 3), read(sampler["input"], 1)[:, 0]


def keys(path, node, what):
    """The last key of an animated node, and the time of the last key."""
    values, times = track(path, node, what)
    return values[-1], float(times[-1])


def test_a_film_of_a_curve_ends_in_the_pose_of_its_last_point(tmp_path):
    # Both courses turn about the toe (.5, ., 0) until their centroid (.25, ., 1) is above it: by atan(1/4).
    path = write_path(capacity(wall(), (1, 0, 0), control="wall"), tmp_path / "falls.glb")
    turned, seconds = keys(path, "course 1", "rotation")
    assert abs(turned) == pytest.approx([0, np.sin(0.5 * np.arctan(0.25)), 0, np.cos(0.5 * np.arctan(0.25))], abs=1e-4)
    assert seconds == pytest.approx(5.0)


def test_a_film_of_a_settlement_moves_the_support(tmp_path):
    piers = [box((x, 0, 0), (x + 0.5, 1, 2), name=name) for x, name in ((0, "left"), (1.5, "right"))]
    lintel = box((0, 0, 2), (2, 1, 2.5), name="lintel")
    portal = Assembly.from_blocks([*piers, lintel], supports=["left", "right"], friction=0.9)
    found = settle_to_collapse(portal, {"right": (0, 0, -1)}, displacement=0.05)
    moved, _ = keys(write_path(found, tmp_path / "settles.glb"), "right", "translation")
    assert moved == pytest.approx([1.75, 0.5, 0.95], abs=1e-6)  # its centroid, which was 1 m high
    strip = write_path(found, tmp_path / "settles.svg").read_text()
    assert "<!-- 50 mm -->" in strip


@pytest.mark.parametrize("name", ["film.xyz", "film", "nowhere/film.glb"])
def test_a_film_that_cannot_be_written_is_refused_before_the_work(tmp_path, name):
    write(wall(), tmp_path / "wall.json")
    answer = run("capacity", tmp_path / "wall.json", "--load", "1,0,0", "--film", tmp_path / name)
    assert answer.returncode == 2
    assert name.split("/")[0] in answer.stderr
    assert "limit load" not in answer.stderr


@pytest.mark.parametrize("load", [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (1, 0.6, 0)])
@pytest.mark.parametrize("control", ["block", ("block", (0.1, 0.37, 1.0)), "mean"])
def test_a_curve_does_not_know_where_the_origin_is(load, control):
    """A pillar with a tie, a load at its top and one at its side, at the origin and at UTM coordinates."""
    ends = []
    for o in (np.zeros(3), np.array([5e5, 4.6e6, 200]), np.array([499999.37, 4599999.11, -73.3])):
        blocks = [box(o - (5, 5, 1), o + (5, 5, 0), name="ground"), box(o, o + (0.37, 0.37, 1.3), name="block")]
        tie = Tie(("ground", "block"), (tuple(o + (0.1, -2, 0)), tuple(o + (0.1, 0, 1))), greatest=300.0)
        pillar = Assembly.from_blocks(blocks, supports=["ground"], friction=0.7, ties=[tie])
        at = control if isinstance(control, str) else (control[0], o + control[1])
        loads = [("block", o + (0.2, 0.2, 1.3), (0, 0, -500.0)), ("block", o + (0.37, 0.3, 0.9), (-20.0, 0, 0))]
        curve = capacity(pillar, load, control=at, loads=loads, steps=10)
        ends.append([curve.lower[0], curve.displacement[-1], curve.lower[len(curve.lower) // 2]])
        assert curve.outcome.word == "zero"
    np.testing.assert_allclose(ends[1:], ends[:1] * 2, rtol=1e-6)


def on_ground(*blocks, **options):
    ground = box((-9, -9, -1), (9, 9, 0), name="ground")
    return Assembly.from_blocks([ground, *blocks], supports=["ground"], density=1000.0, **options)


def test_a_load_whose_place_on_its_block_is_not_known_is_told():
    block = on_ground(box((0, 0, 0), (0.5, 1, 2), name="block"))
    top = (0.25, 0.5, 2)
    placed = capacity(block, (1, 0, 0), control="block", loads=[("block", top, (0, 0, -9810))])
    wrench = capacity(block, (1, 0, 0), control="block", loads=point_load(block, "block", top, (0, 0, -9810)))
    assert not placed.warnings
    assert [text.split(" are")[0] for text in wrench.warnings] == ["the forces of `loads`"]
    # The load is as heavy as the block. They are over the toe at tan(turn) = .25, with the load on top at .25 / 1.5.
    turn = np.arctan([0.25, 0.5 / 3])
    moved = 0.25 - 0.25 * np.cos(turn) + np.sin(turn)
    assert [wrench.displacement[-1], placed.displacement[-1]] == pytest.approx(moved, rel=1e-4)


def test_an_acceleration_acts_at_centroids_and_is_not_told():
    pair = on_ground(box((0, 0, 0), (0.5, 1, 2)), box((3, 0, 0), (3.6, 1, 1)))
    assert not capacity(pair, acceleration(pair, (1, 0, 0)), control="mean").warnings


@pytest.mark.parametrize("control", [1.5, True, (["one", "two"], (0, 0, 0))])
def test_a_control_that_is_no_block_is_refused(control):
    pair = on_ground(box((0, 0, 0), (0.5, 1, 2), name="one"), box((3, 0, 0), (3.6, 1, 1), name="two"))
    with pytest.raises(InputError, match="control"):
        capacity(pair, (1, 0, 0), control=control)


@pytest.mark.parametrize(
    "floor",
    [
        {"kind": "point", "block": "block", "point": [0.25, 0.5, 2], "force": [0, 0, -9810]},
        {"kind": "line", "start": [0.25, 0, 2], "end": [0.25, 1, 2], "force": [0, 0, -9810]},
        {"kind": "surface", "pressure": [0, 0, -19620], "towards": [0, 0, 1]},
        {"kind": "patch", "corners": [[0, 0, 2], [0.5, 0, 2], [0.5, 1, 2], [0, 1, 2]], "pressure": [0, 0, -19620]},
        {"kind": "fill", "level": 3, "unit_weight": 19620},
        {"kind": "dispersed", "point": [0.25, 0.5, 2], "force": 9810, "spread": 0.5, "footprint": [0.3, 0.6]},
    ],
    ids=lambda table: table["kind"],
)
def test_the_loads_of_a_case_go_with_the_face_they_act_on(tmp_path, floor):
    # Block and floor are as heavy. With the floor on top of the block both are over the toe at tan(turn) = .25 / 1.5.
    file = write(on_ground(box((0, 0, 0), (0.5, 1, 2), name="block")), tmp_path / "block.json")
    cases = tmp_path / "cases.toml"
    keys = [f"{key} = {json.dumps(value)}" for key, value in floor.items()]
    cases.write_text("\n".join(["[loads.floor]", *keys, "[cases.used.factors]", "floor = 1.0"]))
    options = ("--load", "1,0,0", "--control", "block", "--case", "used", "--loads", cases, "--json")
    answer = run("capacity", file, *options)
    assert answer.returncode == 0, answer.stderr
    told, turn = json.loads(answer.stdout), np.arctan(0.25 / 1.5)
    assert told["displacement"][-1] == pytest.approx(0.25 - 0.25 * np.cos(turn) + np.sin(turn), rel=1e-4)
    (warning,) = told["warnings"]
    assert warning.startswith('case "used": the loads that stay press down by 9810 N and have no mass')


def test_the_live_loads_of_a_case_go_with_their_points(tmp_path):
    # The same force in words of a case and of Python, which acts on the top edge.
    block = on_ground(box((0, 0, 0), (0.5, 1, 2), name="block"))
    push = {"kind": "point", "block": "block", "point": [0, 0.5, 2], "force": [9810, 0, 0]}
    case = load_case(block, "pushed", {"push": push}, {"pushed": {"live": {"push": 1.0}}})
    placed = capacity(block, case.placed_live, control="block")
    known = capacity(block, [("block", (0, 0.5, 2), (9810, 0, 0))], control="block")
    there = np.linspace(0, 0.9 * known.displacement[-1], 10)
    np.testing.assert_allclose([placed.at(one) for one in there], [known.at(one) for one in there], rtol=1e-9)


def test_blocks_that_a_curve_ends_with_fall_out_where_it_ends():
    """Two blocks on each other that lean over an edge beside a support fall out where nothing is carried any more.

    What is told of them is where they begin to fall, and not where they were when they had fallen by half their size.
    """
    blocks = [
        box((-1, -1, -1), (2, 2, 0), name="ground"),
        box((0, 0, 0), (0.3, 1, 1.5), name="a"),
        box((0, 0, 1.5), (0.3, 1, 3), name="b"),
        box((0.3, 0, 2.9), (1, 1, 3.2), name="stop"),
    ]
    scene = Assembly.from_blocks(blocks, supports=["ground", "stop"], friction=0.7)
    curve = capacity(scene, (1, 0, 0), control="a")
    end = curve.displacement[-1]
    assert curve.outcome.word == "collapse"
    assert [fallen.parameter for fallen in curve.fallen] == [pytest.approx(end, rel=1e-2)]
    assert f'"a", "b": fallen out at {end:.4g} m' in curve.warnings[-1]
