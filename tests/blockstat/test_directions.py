"""The limit load over the horizon."""

import json
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from blockstat import (
    Assembly,
    Block,
    DirectionOutcome,
    InputError,
    JointLaw,
    LoadOutcome,
    box,
    limit_load,
    limit_load_by_direction,
    plot_directions,
    read,
    write,
)
from blockstat.analysis import limit_load as limit_loads
from blockstat.cli.commands import app
from blockstat.system.process import INTERRUPTED
from evidence.scenes.small import prism, stack


def slab(width=1.0, depth=0.5, height=2.0, **options):
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (width, depth, height), name="slab")]
    return Assembly.from_blocks(blocks, supports=["ground"], **options)


def turned(assembly, degrees):
    """The assembly turned about the vertical."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return replace(assembly, vertices=assembly.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))


def test_a_slab_tips_over_the_edge_that_it_is_pushed_to():
    # Push at an angle a over a w x d base: the resultant leaves it through a side at min(w/|cos a|, d/|sin a|) / h.
    found = limit_load_by_direction(slab(friction=2.0), 16, refine=False)
    with np.errstate(divide="ignore"):
        expected = np.minimum(1.0 / np.abs(found.directions[:, 0]), 0.5 / np.abs(found.directions[:, 1])) / 2.0
    np.testing.assert_allclose(found.lower, expected, rtol=1e-6)
    np.testing.assert_allclose(found.upper, expected, rtol=1e-6)
    assert found.names[found.weakest] == "+y"
    assert found.names[:5] == ("+x", "22.5 deg", "45 deg", "67.5 deg", "+y")


@pytest.mark.parametrize("degrees", [17.0, 33.0, 58.0])
def test_the_weakest_direction_is_found_between_those_asked_for(degrees):
    # Across the slab .25, which is towards +y turned; the four axes alone show more than that.
    assembly = turned(slab(friction=2.0), degrees)
    axes = limit_load_by_direction(assembly, 4, refine=False)
    assert axes.upper.min() > 0.255
    low, high = axes.horizon
    assert low <= 0.25 * (1 + 1e-6)
    assert high >= 0.25 * (1 - 1e-6)
    found = limit_load_by_direction(assembly, 4)
    assert found.horizon == pytest.approx((0.25, 0.25), rel=2e-3)
    assert found.least.upper == pytest.approx(0.25, rel=2e-3)
    assert abs((np.rad2deg(found.angles[found.weakest]) - degrees) % 180 - 90) < 3


def test_where_friction_governs_every_direction_is_alike():
    # A sliding block: the set of what is carried is a disc of radius mu, which no polygon fills.
    found = limit_load_by_direction(slab(friction=0.2), 8, refine=False)
    np.testing.assert_allclose(found.upper, 0.2, rtol=1e-6)
    assert found.horizon == pytest.approx((0.2 * np.cos(np.pi / 8), 0.2), rel=1e-6)


def test_a_round_set_is_known_as_well_as_the_chords_between_the_directions_asked_for():
    """All horizontal accelerations up to mu slide: n directions leave a polygon whose sides are at cos(pi / n) mu."""
    block = slab(1.0, 1.0, 0.2, friction=0.4)
    for n in (16, 64):
        low, high = limit_load_by_direction(block, n).horizon
        assert high == pytest.approx(0.4, rel=1e-3)
        assert low == pytest.approx(0.4 * np.cos(np.pi / n), rel=1e-3)


def test_a_triangular_prism_is_weakest_towards_its_longest_side():
    # Over the side nearest to the centroid: right angle, legs 1, the hypotenuse 1/(3 sqrt 2) away; h = 1, mu = 2.
    plan = prism([(0, 0), (1, 0), (0, 1)], 1.0, name="prism")
    corners = np.asarray(plan.vertices)[:, [0, 2, 1]]  # extruded upwards
    faces = [list(face)[::-1] for face in plan.faces]
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), Block(corners, faces, name="prism")]
    assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=2.0)
    found = limit_load_by_direction(assembly, 4)
    assert found.horizon == pytest.approx((2 / (3 * np.sqrt(2)),) * 2, rel=2e-3)
    assert np.rad2deg(found.angles[found.weakest]) == pytest.approx(45, abs=3)


def test_tilted_gravity_has_its_own_horizon():
    found = limit_load_by_direction(slab(gravity=(0.0, -0.981, -9.81)), 4, refine=False)
    np.testing.assert_allclose(found.directions @ [0.0, -0.981, -9.81], 0, atol=1e-12)
    assert found.upper[1] > found.upper[3]  # downhill is easier


@pytest.mark.parametrize(("gravity", "low", "high", "names"), [
    ((0, -9.81, 0), (-1, -1, -1), (2, 0, 4), ("+x", "-z", "-x", "+z")),
    ((-9.81, 0, 0), (-1, -1, -1), (0, 2, 4), ("+z", "-y", "-z", "+y")),
])  # fmt: skip
def test_directions_are_called_by_the_axes_that_they_are_along(gravity, low, high, names):
    up = np.argmin(gravity)
    size = np.array([1.0, 1.0, 1.0])
    size[up], size[2] = 2.0, 0.5
    asm = Assembly.from_blocks([box(low, high), box((0, 0, 0), size)], supports=[0], gravity=gravity)
    found = limit_load_by_direction(asm, 4, refine=False)
    assert found.names == names
    for name, direction in zip(names, found.directions, strict=True):
        assert direction["xyz".index(name[1])] == (1.0 if name[0] == "+" else -1.0)
    # Thin along z, and two high.
    assert found.names[found.weakest][1] == "z"
    assert found.least.upper == pytest.approx(0.25)


def test_what_does_not_stand_has_no_directions():
    found = limit_load_by_direction(slab(gravity=(0, -5, -9.81)), 8)
    assert found.outcome is DirectionOutcome.DEAD_LOAD_UNSTABLE
    assert len(found.limits) == 8
    with pytest.raises(InputError, match="no limit loads to draw"):
        plot_directions(found, "x.png")


def test_an_interrupt_keeps_the_directions_that_were_looked_at():
    def stop(done, name, found):
        if done == 3:
            raise KeyboardInterrupt

    found = limit_load_by_direction(slab(friction=2.0), 16, progress=stop)
    assert found.outcome is DirectionOutcome.STOPPED
    assert found.names == ("+x", "22.5 deg", "45 deg")
    low, high = found.horizon
    assert low <= 0.25 <= high <= 0.5  # across, which was not looked at
    assert "only some directions" in found.explain()
    assert "45 deg" in found.explain()


def test_each_direction_says_that_it_hangs_on_the_joint_tolerance():
    # A wall touches the block at +x, where it bears any push; another is 12 mm away at -y, beyond the tolerance.
    blocks = [box((-2, -2, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 2))]
    blocks.append(box((0, -1.012, 0), (1, -0.012, 1)))
    found = limit_load_by_direction(Assembly.from_blocks(blocks, supports=[0, 2, 3]), 4, refine=False)
    assert found.limits[0].outcome is LoadOutcome.UNBOUNDED
    assert [text for text in found.warnings if "not taken" in text]


def test_the_command_ends_as_interrupted_where_directions_are_missing(run_command, tmp_path, monkeypatch):
    asked = []

    def limited(*arguments, **options):
        asked.append(arguments)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return limit_load(*arguments, **options)

    monkeypatch.setattr("blockstat.studies.directions.limit_load", limited)
    file = write(slab(friction=2.0), tmp_path / "slab.json")
    status, out, err = run_command(app, "blockstat", "limit", file, "--directions", 8)
    assert (status, err[-12:]) == (INTERRUPTED, "interrupted\n")
    assert "Least so far: 0.35" in out  # of +x and 45 degrees, where it is .25 / sin(45)


def test_blocks_that_touch_nothing_have_no_directions():
    apart = [box((0, 0, 2 * k), (1, 1, 2 * k + 1)) for k in range(3)]
    found = limit_load_by_direction(Assembly.from_blocks(apart, supports=[0]), 4)
    assert found.outcome is DirectionOutcome.DEAD_LOAD_UNSTABLE
    assert found.weakest == 0
    assert "does not stand without the load" in found.explain()


@pytest.mark.parametrize("number", [0, 3, 6])
def test_a_number_that_leaves_out_the_axes_is_refused(number):
    with pytest.raises(InputError, match="must be a multiple of 4"):
        limit_load_by_direction(slab(), number)


def test_coulomb_friction_has_a_bracket_in_each_direction():
    found = limit_load_by_direction(slab(friction=0.2), 4, flow="coulomb")
    for limit in found.limits:
        assert limit.coulomb == pytest.approx((0.2, 0.2), rel=1e-3)
    assert "without dilatancy" in found.explain()
    assert found.summary()["coulomb_least"] == pytest.approx(0.2, rel=1e-3)


def test_the_least_without_dilatancy_is_said_and_drawn_in_its_own_direction():
    """Associated .25 towards +y; by the joints that carry least .1 towards -x, which those that carry most hide."""
    found = limit_load_by_direction(slab(friction=2.0), 4, refine=False)
    told, drawn = found.explain(), Figure().add_subplot(projection="polar")
    assert found.weakest_coulomb is found.summary()["coulomb_least"] is found.summary()["coulomb_towards"] is None
    assert "Least: 0.25 towards +y." in told
    assert "Friction is associated" in told
    plot_directions(found, drawn)
    assert drawn.get_legend() is None
    kinds = [((0.3, 0.31), (0.4, 0.41)), ((0.2, 0.21),), ((0.45, 0.46), (0.1, 0.11)), ((0.2, 0.21),)]
    limits = [replace(limit, coulomb_kinds=own) for limit, own in zip(found.limits, kinds, strict=True)]
    found = replace(found, limits=tuple(limits))
    told, summary, drawn = found.explain(), found.summary(), Figure().add_subplot(projection="polar")
    assert "Least without dilatancy, of 4 directions: 0.1 to 0.11 towards -x, in the kind of joints that" in told
    assert "Least with associated friction: 0.25 towards +y." in told
    assert "Over the whole horizon with associated friction: " in told
    assert (summary["least"], summary["upper"]) == ("+y", pytest.approx(0.25))
    assert (summary["coulomb_least"], summary["coulomb_towards"]) == (0.1, "-x")
    assert [row["coulomb_least"] for row in summary["directions"]] == [0.3, 0.2, 0.1, 0.2]
    plot_directions(found, drawn)
    assert drawn.get_title() == "assembly: least of 4 directions without dilatancy: 0.1 towards -x"
    assert [text.get_text() for text in drawn.get_legend().get_texts()] == ["associated friction", "without dilatancy"]
    # What associated friction does not carry is not looked for without dilatancy, and is the least all the same.
    none = replace(found.limits[3], lower=0.0, upper=0.0, coulomb_kinds=((0.0, 0.0),))
    held = replace(found.limits[0], outcome=LoadOutcome.UNBOUNDED, lower=np.inf, upper=np.inf, coulomb_kinds=())
    found = replace(found, limits=(held, *found.limits[1:3], none))
    assert "Least without dilatancy, of 3 directions: 0 to 0 towards -y" in found.explain()


def test_directions_in_which_a_cube_jams_are_undecided_without_dilatancy():
    """In a slot along y the walls hold it whichever way it is pushed; without dilatancy it slides at mu along y."""
    walls = [box((-1, 0, 0), (0, 1, 1)), box((1, 0, 0), (2, 1, 1)), box((0, 0, -1), (1, 1, 0))]
    asm = Assembly.from_blocks([*walls, box((0, 0, 0), (1, 1, 1))], supports=range(3), friction=0.9)
    assert limit_load_by_direction(asm, 4, refine=False).outcome is DirectionOutcome.UNBOUNDED
    found = limit_load_by_direction(asm, 4, refine=False, flow="coulomb")
    against, along = found.summary()["directions"][:2]
    assert (against["status"], against["coulomb_lower"], against["coulomb_least"]) == ("unbounded", None, None)
    assert along["status"] == "undecided"
    assert along["coulomb_least"] == pytest.approx(0.9, rel=1.5e-3)
    assert found.summary()["coulomb_least"] == pytest.approx(0.9, rel=1.5e-3)
    assert found.outcome is DirectionOutcome.UNDECIDED
    assert "Undecided towards +y, -y: joints that dilate as they slide carry any multiple" in found.explain()
    wide = replace(found, limits=(*found.limits[:2], *limit_load_by_direction(slab(), 4, refine=False).limits[2:]))
    assert wide.outcome is DirectionOutcome.LIMIT
    assert "+y  inf to inf (undecided), without dilatancy 0.89" in wide.explain()


def test_an_interrupt_ends_all_directions(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    told = []
    monkeypatch.setattr(limit_loads, "interior_point", SimpleNamespace(solve=interrupted))
    with pytest.raises(KeyboardInterrupt):
        limit_load_by_direction(slab(), 4, solver="interior-point", progress=lambda *step: told.append(step))
    assert told == []


def test_a_wide_tolerance_takes_fewer_iterations_in_every_direction():
    options = {"refine": False, "solver": "interior-point"}
    rough, fine = (limit_load_by_direction(slab(friction=0.2), 4, tolerance=t, **options) for t in (0.1, 1e-6))
    assert all(a.iterations < b.iterations for a, b in zip(rough.limits, fine.limits, strict=True))
    assert (rough.lower <= 0.2 * (1 + 1e-6)).all()
    assert (rough.upper >= 0.2 * (1 - 1e-6)).all()
    with pytest.raises(InputError, match="tolerance is 5; it must be above 0"):
        limit_load_by_direction(slab(), 4, tolerance=5)


def run(*arguments):
    code = "from blockstat.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_the_command_names_the_least_direction_and_draws_all(tmp_path):
    file = write(slab(friction=2.0), tmp_path / "slab.json")
    picture = tmp_path / "horizon.svg"
    answer = run("limit", file, "--directions", 8, "-o", picture, "--json")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert told["least"] == "+y"
    assert told["upper"] == pytest.approx(0.25)
    assert [row["name"] for row in told["directions"]][::2] == ["+x", "+y", "-x", "-y"]
    expected = limit_load(read(file), (1, 0, 0)).lower
    assert told["directions"][0]["lower"] == pytest.approx(expected, rel=1e-9)
    assert "<svg" in picture.read_text()
    plain = run("limit", file, "--directions", 4)
    assert "Least: 0.25 towards +y." in plain.stdout


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "give --load AX,AY,AZ, --directions N for all of the horizon, or --case NAME with live loads"),
        (["--load", "1,0,0", "--directions", "4"], "ask for one of them"),
        (["--directions", "5"], "must be a multiple of 4"),
        (["--directions", "4", "--tolerance", "5"], "tolerance is 5.0; it must be above 0"),
        (["--load", "1,0,0", "-o", "x.png"], "-o draws the directions; it goes with --directions"),
    ],
)
def test_the_command_says_what_is_wrong(tmp_path, arguments, expected):
    file = write(stack(2), tmp_path / "stack.json")
    answer = run("limit", file, *arguments)
    assert answer.returncode == 2
    assert expected in answer.stderr


def test_without_limits_the_answer_is_printed_and_no_picture_drawn(tmp_path):
    file, picture = write(slab(gravity=(0, -5, -9.81)), tmp_path / "falls.json"), tmp_path / "rose.svg"
    answer = run("limit", file, "--directions", 4, "-o", picture)
    assert answer.returncode == 0
    assert "Infeasible under dead load" in answer.stdout
    assert f"{picture}: not written, for there are no limit loads to draw" in answer.stderr
    assert not picture.exists()
    told = json.loads(run("limit", file, "--directions", 4, "-o", picture, "--json").stdout)
    assert told["outcome"] == "dead_load_unstable"
    assert "output" not in told


def test_wide_bounds_matter_only_where_the_weakest_direction_may_be():
    found = limit_load_by_direction(slab(friction=2.0), 4, refine=False)
    strong = replace(found.limits[0], outcome=LoadOutcome.UNDECIDED, upper=0.9)  # carries .5, the weakest .25
    assert replace(found, limits=(strong, *found.limits[1:])).outcome is DirectionOutcome.LIMIT
    doubtful = replace(strong, lower=0.1)
    stopped = replace(doubtful, outcome=LoadOutcome.STOPPED)
    for limit in (doubtful, stopped):
        assert replace(found, limits=(limit, *found.limits[1:])).outcome is DirectionOutcome.UNDECIDED


def test_a_direction_that_a_wall_holds_is_told_as_unbounded_and_bounds_nothing():
    """A smooth wall stands on one side of the slab: it tips away from it at .5, and along it at .25 as ever."""
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    wall = box((1, 0, 0), (2, 0.5, 2), name="wall", group="wall")
    held = box((0, 0, 0), (1, 0.5, 2), name="slab", group="slab")
    smooth = JointLaw(("slab", "wall"), friction=0.0)
    scene = Assembly.from_blocks([ground, wall, held], supports=["ground", "wall"], friction=2.0, joints=[smooth])
    found = limit_load_by_direction(scene, 4)
    assert found.outcome is DirectionOutcome.LIMIT
    assert found.horizon == pytest.approx((0.25, 0.25), rel=2e-3)
    lines = found.explain().splitlines()
    assert [line.split() for line in lines if "unbounded" in line] == [["+x", "inf", "to", "inf", "(unbounded)"]]
    assert found.limits[0].outcome is LoadOutcome.UNBOUNDED
    assert found.upper[found.names.index("-x")] == pytest.approx(0.5, rel=1e-6)


def test_where_gravity_is_along_x_the_horizon_begins_at_z():
    """The slab on its side on a wall: 1 m along z, .5 m along y, 2 m out. From z, what stands to its left is -y."""
    for sign in (-1, 1):
        blocks = [box((-1, -5, -5), (0, 5, 5), name="wall"), box((0, 0, 0), (2, 0.5, 1), name="slab")]
        lying = Assembly.from_blocks(blocks, supports=["wall"], friction=2.0, gravity=(-9.81, 0, 0))
        if sign > 0:
            lying = replace(lying, vertices=lying.vertices @ np.diag([-1, -1, 1]), gravity=np.array([9.81, 0, 0]))
        found = limit_load_by_direction(lying, 4, refine=False)
        np.testing.assert_allclose(found.directions, [[0, 0, 1], [0, sign, 0], [0, 0, -1], [0, -sign, 0]], atol=1e-12)
        np.testing.assert_allclose(found.upper, [0.5, 0.25, 0.5, 0.25], rtol=1e-6)
