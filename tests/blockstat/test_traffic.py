"""A train on a path: places and brackets that follow from statics, what is told, and what is refused."""

import re
from dataclasses import replace
from itertools import pairwise
from math import cos, inf, nan, sin

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    InputWarning,
    JointLaw,
    MovingOutcome,
    find_interfaces,
    moving_load,
    point_load,
)
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.traffic import envelope, place_brackets
from blockstat.traffic.envelope import MOST_POSITIONS
from blockstat.traffic.places import road_along, train_loads
from evidence.scenes.small import assembly, box, prism

WEIGHT = 1000.0 * 9.81 * 1.5  #: of the slab [N]; it tips about x = 2, .5 m beyond its centroid
WHEEL = [(0.0, 1000.0)]


def overhang():
    """A slab 3 m long on a pier of 2 m."""
    blocks = [box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab")]
    return Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)


def along(*ends, height=0.5):
    return [(x, 0.5, height) for x in ends]


def test_the_worst_place_is_told_with_its_bracket():
    found = moving_load(overhang(), WHEEL, along(0, 3), positions=7)
    first, bracket, place, count = found.explain().splitlines()
    assert (
        first == "Limit: at its worst place the train is carried up to the lower bound, and not beyond the upper one."
    )
    low, high = (float(part) for part in bracket.split(" <= multiplier <= "))
    exact = 0.5 * WEIGHT / 1000.0
    assert low * (1 - 1e-5) <= exact <= high * (1 + 1e-5)
    assert high - low <= 1.1e-3 * high
    assert place == "Worst place of the first axle: 3 m along the path."
    assert count == f"{len(found.place)} places, {found.solves} solved."


def test_a_train_that_is_carried_everywhere_has_no_worst_place_to_tell():
    found = moving_load(overhang(), WHEEL, along(0.5, 1.5), positions=1, joints=False)
    assert found.explain().splitlines()[:2] == [
        "Unbounded: any multiple of the train is carried wherever an axle stands.",
        "1 places, 1 solved.",
    ]
    assert found.summary()["upper"] == [None]


def test_where_the_path_crosses_a_gap_nothing_is_loaded_and_nothing_is_solved():
    scene = assembly([box((-1, -1, -1), (9, 2, 0)), box((0, 0, 0), (1, 1, 0.5)), box((4, 0, 0), (5, 1, 0.5))])
    found = moving_load(scene, WHEEL, along(0, 5), positions=1, joints=False)
    np.testing.assert_array_equal(found.place, [2.5])
    assert not found.load.any()
    assert found.lower[0] == inf
    assert found.upper[0] == inf
    assert found.solves == 0


def test_places_where_no_axle_stands_on_a_block_are_told():
    """Of 5 even places on 5 m of path, 1.25 m apart, two lie on a slab: of .5 m, and of .5 m at the other end."""
    scene = assembly([box((-1, -1, -1), (9, 2, 0)), box((0, 0, 0), (0.5, 1, 0.5)), box((4.5, 0, 0), (5, 1, 0.5))])
    found = moving_load(scene, WHEEL, along(0, 5), positions=5, joints=False)
    says = "at 3 of 5 places no axle stands on a block, so nothing is loaded there"
    assert says in found.warnings
    assert f"Warning: {says}" in found.explain()
    assert not any("no axle" in text for text in moving_load(overhang(), WHEEL, along(0, 3), positions=7).warnings)


def test_axles_further_apart_than_the_path_is_long_are_told():
    """An axle 1,200 m behind, meant in millimetres: of 40 places over 1,203 m only the first and the last load."""
    far = moving_load(overhang(), [(0, 1.0), (1200, 1.0)], along(0, 3), positions=40, joints=False)
    assert any(text.startswith("at 38 of 40 places no axle stands on a block") for text in far.warnings)
    assert any("are 1200 m apart, and the path is 3 m long" in text for text in far.warnings)
    for train in ([(0, 1.0), (1.5, 1.0), (3.5, 1.0)], [(0, 1.0), (3.0, 1.0)]):  # longer than the path; just as long
        near = moving_load(overhang(), train, along(0, 3), positions=4)
        assert not any("apart" in text or "no axle" in text for text in near.warnings)


def test_axles_on_fill_press_on_the_part_of_their_rectangle_that_has_a_face():
    """.5 m of fill spreads to .25 m on each side: of 2.65 to 3.15 m only 2.65 to 3 m is slab."""
    found = moving_load(overhang(), WHEEL, along(2.8, 3.0, height=1.0), positions=1, spread=0.5)
    exact = 0.5 * WEIGHT / (1000.0 * (2.825 - 2.0))
    assert found.lower[0] <= exact * (1 + 1e-6)
    assert found.upper[0] >= exact * (1 - 1e-6)
    assert found.lower[0] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(
    ("options", "push", "mean"),
    [
        ({"footprint": (0.2, 0.2)}, 0.5, 2.775),
        ({"gravity": (0, 0, -2 * 9.81)}, 1.0, 2.825),
        ({"loads": 0.25}, 0.75, 2.825),
        ({"footprint": (0.2, 0.2), "gravity": (0, 0, -2 * 9.81), "loads": 0.25}, 1.25, 2.775),
    ],
    ids=["footprint", "gravity", "loads", "all"],
)
def test_what_stands_beside_an_axle_on_fill_counts(options, push, mean):
    """A footprint of .2 m spreads from 2.55 to 3.25 m; the slab ends at 3 m. A load at x = 1 has an arm of 1."""
    slab = overhang()
    if "loads" in options:
        options = options | {"loads": point_load(slab, "slab", (1, 0.5, 0.5), (0, 0, -options["loads"] * WEIGHT))}
    found = moving_load(slab, WHEEL, along(2.8, 3.0, height=1.0), positions=1, spread=0.5, **options)
    exact = push * WEIGHT / (1000.0 * (mean - 2.0))
    assert found.lower[0] <= exact * (1 + 1e-6)
    assert found.upper[0] >= exact * (1 - 1e-6)
    assert found.lower[0] == pytest.approx(exact, rel=2e-3)


BAD_TRAIN = "each is a distance behind the first, at least 0, and a force above 0"


@pytest.mark.parametrize(
    ("axles", "path", "options", "says"),
    [
        *((WHEEL, along(0, 3), {"positions": n}, f"positions is {n!r}; it must be a whole number from 1 to 100000")
          for n in (0, 2.5, "7", MOST_POSITIONS + 1)),
        *((WHEEL, along(0, 3), {"tolerance": t}, f"tolerance is {t!r}; it must be from 1e-09 to 0.1")
          for t in (0.0, 0.11, nan)),
        *((bad, along(0, 3), {}, BAD_TRAIN)
          for bad in ([], "wheel", [1.0, 2.0, 3.0], [(0, 1000, 1.2), (3, 2000, 1.2)], [(0, 0)], [(0, -1)], [(-1, 5)],
                      [(0, inf)], [(nan, 1)])),
        *((WHEEL, bad, {}, "path: a list of points of three finite numbers is needed, 2 at least")
          for bad in (along(0), [(0, 0), (3, 0)], (0, 0, 3), along(0, nan), [(0, 0.5, 0), (0.5, 0.5)], "abc")),
        (WHEEL, along(0, 1, 1, 3), {}, "path: two of its points that follow each other are the same"),
        (WHEEL, along(7, 9), {}, "path: no free face of these blocks lies below it"),
        *((WHEEL, along(0, 3, height=1.0), {"spread": bad}, f"spread is {bad!r}; it must be at least 0")
          for bad in (-0.4, nan, "x")),
        (WHEEL, along(0, 3, height=1.0), {"spread": 0.5, "footprint": (-1, 0)}, "footprint is (-1, 0); it must be"),
        (WHEEL, along(0, 3), {"footprint": (1, 1)}, "footprint is (1, 1) without a spread"),
    ],
)  # fmt: skip
def test_a_bad_train_or_path_is_refused(axles, path, options, says):
    with pytest.raises(InputError, match=re.escape(says)):
        moving_load(overhang(), axles, path, **options)


def test_a_spread_of_axles_that_may_be_an_angle_is_doubted():
    with pytest.warns(InputWarning, match="spread is 30; it is the tangent of an angle: 30 degrees are 0.577"):
        moving_load(overhang(), WHEEL, along(0, 3, height=1.0), spread=30, positions=2)


@pytest.mark.parametrize("across", [0.0, 0.5, 1.0], ids=["edge", "middle", "other edge"])
def test_a_path_on_the_edge_of_the_faces_is_on_them(across):
    # Turned and moved, the edge is a line of rounding. Each wheel stands on the pier's bed, so all is carried.
    stones = [box((k, 0, 0), (k + 1, 1, 1), name=f"stone{k}") for k in range(5)]
    row = Assembly.from_blocks([box((-1, -0.5, -1), (6, 1.5, 0), name="pier"), *stones], supports=["pier"])
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    there = row.with_(vertices=row.vertices @ turn.T + [3.3, 7.7, 0])
    path = np.array([(0, across, 1), (5, across, 1)]) @ turn.T + [3.3, 7.7, 0]
    found = moving_load(there, WHEEL, path.tolist(), positions=6)
    assert found.outcome is MovingOutcome.UNBOUNDED
    np.testing.assert_allclose(np.unique(found.place.round(9)), np.arange(6.0))


def test_an_axle_on_fill_with_no_face_below_presses_on_nothing():
    found = moving_load(overhang(), WHEEL, along(-1, 2.9, height=1.0), positions=3, spread=0.5)
    exact = 0.5 * WEIGHT / (1000.0 * (2.825 - 2.0))
    assert found.lower[0] == inf
    assert found.upper[-1] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9])
@pytest.mark.parametrize("way", [1, -1])
def test_without_joints_an_even_place_on_one_has_both_its_sides(way, off):
    """A slab from 0 to 2 m on a pier of 1.5 m, and a lower step from there on: on the slab the wheel tips it at W."""
    blocks = [
        box((0, 0, -1), (1.5, 1, 0), name="pier"),
        box((0, 0, 0), (2, 1, 0.5), name="slab"),
        box((2, 0, -2), (4, 1, -1), name="floor"),
        box((2, 0, -1), (4, 1, -0.5), name="step"),
    ]
    scene = Assembly.from_blocks(blocks, supports=["pier", "floor"], density=1000.0)
    ends = along(off, 4 + off)[::way]
    found = moving_load(scene, WHEEL, ends, positions=5, joints=False)
    np.testing.assert_allclose(found.place, [0, 1, 2, 2, 3, 4])
    assert found.side[2:4].tolist() == [-1, 1]
    assert found.upper[2 if way == 1 else 3] == pytest.approx(1000.0 * 9.81 * 0.5 / (0.5 * 1000.0), rel=2e-3)
    assert found.upper[3 if way == 1 else 2] == inf
    aside = moving_load(scene, WHEEL, along(1e-3, 4 + 1e-3)[::way], positions=5, joints=False)
    np.testing.assert_allclose(aside.place, [0, 1, 2, 3, 4])


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.234])
def test_an_even_place_on_a_joint_is_one_place_however_the_scene_lies(angle):
    """Slabs of .7, .3 and .5 m, each on a pier: even places each .1 m meet all four ends, two of them in the middle."""
    turn, away = (
        np.array([[cos(angle), -sin(angle), 0], [sin(angle), cos(angle), 0], [0, 0, 1]]),
        (1300.0, -7100.0, 0.2),
    )
    ends, blocks = np.array([0.0, 0.7, 1.0, 1.5]), []
    for a, b in pairwise(ends):
        blocks += [box((a + 0.1 * (b - a), 0, -1), (b - 0.1 * (b - a), 1, 0)), box((a, 0, 0), (b, 1, 0.2))]
    blocks = [replace(block, vertices=block.vertices @ turn.T + away) for block in blocks]
    scene = Assembly.from_blocks(blocks, supports=[0, 2, 4], density=1000.0)
    path = np.array([(x, 0.5, 0.2) for x in (0.0, 1.5)]) @ turn.T + away
    found = moving_load(scene, WHEEL, path.tolist(), positions=16)
    np.testing.assert_allclose(found.place, sorted([*np.linspace(0, 1.5, 16), 0.7, 1.0]), atol=1e-6)


@pytest.mark.parametrize(("positions", "tolerance"), [(1, 0.1), (1, 1e-9)])
def test_the_ends_of_what_is_allowed_are_allowed(positions, tolerance):
    found = moving_load(overhang(), WHEEL, along(2.5, 3), positions=positions, tolerance=tolerance, joints=False)
    exact = 0.5 * WEIGHT / (1000.0 * 0.75)
    assert found.lower[0] <= exact * (1 + 1e-8)
    assert found.upper[0] >= exact * (1 - 1e-8)


def beside(*other, **options):
    """The overhang, and another support under or beside its end."""
    blocks = [box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab"), *other]
    return Assembly.from_blocks(blocks, supports=["pier", other[0].name], density=1000.0, **options)


@pytest.mark.parametrize("only_worst", [False, True])
@pytest.mark.parametrize(
    ("other", "law", "says"),
    [
        (box((3, 0, -1), (4, 1, 0), name="pier2"), {}, '"slab" and "pier2" touch only edge along edge'),
        (box((2.7, 0, -1), (4, 1, 0.08), name="pier2"), {}, '"slab" and "pier2" overlap too far to have a joint'),
        (prism([(2.8, -1), (3.0, -1), (2.9, 0)], 1.0, name="pier2"), {"compression": 1e9},
         "contacts without area carry nothing under a joint law with compressive strength"),
    ],
    ids=["edge", "overlap", "crushed"],
)  # fmt: skip
def test_a_mechanism_into_what_is_in_no_program_bounds_no_place(other, law, says, only_worst):
    asm = beside(other, joints=[JointLaw(("*", "*"), **law)] if law else [])
    found = moving_load(asm, WHEEL, along(0, 3), positions=7, only_worst=only_worst)
    assert found.outcome is MovingOutcome.UNDECIDED
    # The slab without the other pier carries so much at its end, and nothing is proven not to be carried.
    alone = moving_load(overhang().with_(joints=asm.joints), WHEEL, along(0, 3), positions=7)
    assert found.lower.min() == pytest.approx(alone.upper.min(), rel=2e-3)
    if not law:
        assert found.lower.min() == pytest.approx(0.5 * WEIGHT / 1000.0, rel=2e-3)
        assert np.isinf(found.upper).all()
        assert found.place[found.worst] == pytest.approx(3.0)
    assert np.isinf(found.upper[-1])
    assert any(text.startswith(says) for text in found.warnings)
    lines = found.explain().splitlines()
    assert lines[0] == found.outcome.value
    assert " <= multiplier" in lines[1]
    assert lines[2] == "Least is proven with the first axle 3 m along the path."
    assert any(line.startswith(f"Warning: {says}") for line in lines)
    assert found.summary()["warnings"] == list(found.warnings)
    assert found.summary()["outcome"] == "undecided"


def test_a_place_that_carries_more_than_the_worst_may_stay_undecided():
    # The pier under the left end has its edge along that of the slab; the right one overhangs twice as far.
    blocks = [
        box((1, 0, -1), (3, 1, 0), name="pier"), box((0, 0, 0), (6, 1, 0.5), name="slab"),
        box((3.5, 0, -1), (4, 1, 0), name="post"), box((-1, 0, -1), (0, 1, 0), name="edge"),
    ]  # fmt: skip
    asm = Assembly.from_blocks(blocks, supports=["pier", "post", "edge"], density=1000.0)
    found = moving_load(asm, WHEEL, along(0, 6), positions=2)
    weight = 3.0 * 1000.0 * 9.81  # 1 m left of x = 4, 2 m right of x = 1
    assert found.outcome is MovingOutcome.LIMIT
    assert found.upper[found.worst] == pytest.approx(weight * 1.0 / 2.0 / 1000.0, rel=2e-3)
    assert found.place[found.worst] == pytest.approx(6.0)
    left = np.flatnonzero(found.place == 0.0)
    assert np.isinf(found.upper[left]).all()
    assert found.lower[left] == pytest.approx(weight * 2.0 / 1.0 / 1000.0, rel=2e-3)


def test_what_falls_whatever_an_edge_carries_is_bounded():
    # The slab tips at its free end about x = 1, off the edge of the support at its other one.
    blocks = [
        box((1, 0, -1), (3, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab"),
        box((3, 0, -1), (4, 1, 0), name="pier2"),
    ]  # fmt: skip
    asm = Assembly.from_blocks(blocks, supports=["pier", "pier2"], density=1000.0)
    found = moving_load(asm, WHEEL, along(0, 3), positions=7)
    assert found.outcome is MovingOutcome.LIMIT
    assert found.upper[found.worst] == pytest.approx(WEIGHT * 0.5 / 1000.0, rel=2e-3)
    assert found.warnings == ()


def test_a_deep_overlap_is_refused_and_a_shallow_one_told():
    deep = beside(box((2.7, 0, -1), (4, 1, 0.3), name="pier2"))
    with pytest.raises(InputError, match='blocks "slab" and "pier2" overlap by'):
        moving_load(deep, WHEEL, along(0, 3), positions=3)
    moving_load(deep, WHEEL, along(0, 1.5), positions=1, joints=False, interfaces=find_interfaces(deep))
    shallow = beside(box((2.7, 0, -1), (4, 1, 0.08), name="pier2"))
    found = moving_load(shallow, WHEEL, along(0.5, 1.5), positions=1, joints=False)
    assert found.outcome is MovingOutcome.UNBOUNDED
    assert found.warnings[0] == '1 pairs of blocks overlap, the worst "slab" and "pier2" by 0.08 m'
    assert "\nWarning: 1 pairs of blocks overlap" in found.explain()


def test_a_bracket_that_is_left_open_is_judged_as_a_limit_load_is(monkeypatch):
    plain = place_brackets.bracket

    def left_open(*given):
        found = plain(*given)
        return (LoadOutcome.UNDECIDED, 0.5 * found[1], np.inf, *found[3:])

    monkeypatch.setattr(place_brackets, "bracket", left_open)
    found = moving_load(overhang(), WHEEL, along(2.5, 3), positions=1, joints=False)
    assert found.outcome is MovingOutcome.LIMIT
    exact = 0.5 * WEIGHT / (1000.0 * 0.75)
    assert found.lower[0] <= exact * (1 + 1e-8)
    assert found.upper[0] >= exact * (1 - 1e-8)
    assert found.upper[0] - found.lower[0] <= 1e-3 * found.upper[0]
    monkeypatch.setattr(place_brackets, "bracket", lambda *given: (LoadOutcome.UNDECIDED, *plain(*given)[1:]))
    over = moving_load(overhang(), WHEEL, along(0.5, 1.5), positions=1, joints=False)
    assert over.outcome is MovingOutcome.UNBOUNDED


def balanced():
    """A slab 10 m long on a pier of 2 m below its middle, of weight 49,050 N."""
    blocks = [box((4, 0, -1), (6, 1, 0), name="pier"), box((0, 0, 0), (10, 1, 0.5), name="slab")]
    return Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)


@pytest.mark.parametrize("only_worst", [False, True])
@pytest.mark.parametrize(
    ("axles", "ends", "place", "side"),
    [
        ([(0.0, 10e3), (7.5, 20e3)], (0, 8), 8.0, 1),  # the light axle has just left at x = 8
        ([(0.0, 20e3), (7.5, 10e3)], (8, 0), 7.5, -1),  # the light axle is about to enter there
    ],
    ids=["leaves", "enters"],
)
def test_a_train_is_worst_when_the_axle_that_balances_it_is_off_the_path(axles, ends, place, side, only_worst):
    # 20 kN at x = .5, 3.5 m from the edge at x = 4; the weight 1 m behind it.
    found = moving_load(balanced(), axles, along(*ends), positions=2, only_worst=only_worst)
    exact = 49050.0 * 1.0 / (20e3 * 3.5)
    k = found.worst
    assert (found.place[k], found.side[k]) == (place, side)
    assert found.lower[k] <= exact * (1 + 1e-6)
    assert found.upper[k] == pytest.approx(exact, rel=1e-6)


def test_an_axle_beyond_an_end_or_in_a_gap_presses_on_nothing():
    scene = assembly([box((-1, -1, -1), (9, 2, 0)), box((0, 0, 0), (1, 1, 0.5)), box((4, 0, 0), (5, 1, 0.5))])
    faces = [face for face in envelope.facing(scene, [1, 2], np.array([0.0, 0, 1]), find_interfaces(scene))]
    road = road_along(scene, along(0, 5), faces)
    place, side = np.repeat([0.0, 1.0, 4.0, 5.0], 3), np.tile([-1, 0, 1], 4)
    loads = train_loads(road, np.array([(0.0, 1.0)]), place, side, spread=None, footprint=(0, 0))
    pressed = -loads[:, :, 2].sum(axis=1)
    np.testing.assert_array_equal(pressed.reshape(4, 3), [[0, 1, 1], [1, 1, 0], [0, 1, 1], [1, 1, 0]])


@pytest.mark.parametrize("down", [(0, 0, -1), (0.6, 0, -0.8)])
def test_the_heights_of_a_path_do_not_count_unless_loads_spread(down):
    """From x = 0 to 3 in plan, 3 up, whatever height is given: 3 m long. With a spread the path is a surface of 5 m."""
    scene = overhang().with_(gravity=tuple(9.81 * np.array(down)))
    up = -np.array(down)
    faces = envelope.facing(scene, [1], up, find_interfaces(scene))
    level, steep = along(0, 3), [(0.0, 0.5, 0.5), tuple(np.array([3, 0.5, 0.5]) + 4 * up)]
    flat, risen = (road_along(scene, path, faces) for path in (level, steep))
    assert risen.length == pytest.approx(flat.length)
    assert (risen.start, risen.end) == (pytest.approx(flat.start), pytest.approx(flat.end))
    assert risen.wheel(2.0, 0) == pytest.approx(flat.wheel(2.0, 0))
    if down == (0, 0, -1):
        assert risen.length[-1] == pytest.approx(3.0)
        assert road_along(scene, steep, faces, spread=1.0).length[-1] == pytest.approx(5.0)
    upright = [(1.0, 0.5, 0.5), tuple(np.array([1, 0.5, 0.5]) + up)]
    with pytest.raises(InputError, match="path: two of its points that follow each other are the same in plan"):
        road_along(scene, upright, faces)


def test_an_axle_on_a_path_with_heights_is_worst_where_it_is_on_a_level_one():
    found = moving_load(overhang(), WHEEL, [(0.0, 0.5, 0.5), (3.0, 0.5, 4.5)], positions=7)
    assert found.place.max() == pytest.approx(3.0)
    assert found.upper[found.worst] == pytest.approx(0.5 * WEIGHT / 1000.0, rel=2e-3)


def test_the_last_axle_stands_on_the_end_of_a_path_whatever_its_distance_is_rounded_to():
    for behind in (0.1 + 0.2, 0.1 + 0.7, 1 / 3, 1e-7 / 3):
        found = moving_load(overhang(), [(0.0, 1.0), (behind, 1000.0)], along(0, 3), positions=3)
        last = found.place == found.place.max()
        assert found.place.max() == 3.0 + behind
        assert found.side[last].tolist() == [-1]
        assert found.upper[last] == pytest.approx(0.5 * WEIGHT / 1000.0, rel=2e-3)


def side_by_side(*order):
    """A slab on two piers and beside it an overhang, without friction: the joint between them is at y = 1."""
    made = {
        "pier": box((0, 0, -1), (2, 2, 0), name="pier"),
        "pier2": box((2.5, 0, -1), (3, 0.9, 0), name="pier2"),
        "slab": box((0, 0, 0), (3, 1, 0.5), name="slab"),
        "overhang": box((0.9, 1, 0), (3, 2, 0.5), name="overhang"),
    }
    blocks = [made[name] for name in order]
    return Assembly.from_blocks(blocks, supports=["pier", "pier2"], density=1000.0, friction=0.0)


@pytest.mark.parametrize("last", [("slab", "overhang"), ("overhang", "slab")])
@pytest.mark.parametrize("way", [1, -1])
def test_a_path_along_a_joint_loads_the_blocks_on_both_of_its_sides(last, way):
    """The overhang of 2.1 m tips about x = 2, .05 m beyond its centroid, under a wheel at its end, 1 m further."""
    scene, ends = side_by_side("pier", "pier2", *last), [(0, 1.0, 0.5), (3, 1.0, 0.5)][::way]
    found = moving_load(scene, WHEEL, ends, positions=4)
    weight = 1000.0 * 9.81 * 2.1 * 0.5
    assert found.upper[found.worst] == pytest.approx(weight * 0.05 / 1000.0, rel=2e-3)
    twice = [np.count_nonzero((found.place == there) & (found.side == 1)) for there in (1.0, 2.0)]
    assert twice == [2, 2]


def test_places_that_leave_out_joints_are_told():
    says = "only the places listed were looked at; between them the train may be carried less"
    assert says in moving_load(overhang(), WHEEL, along(0, 3), positions=3, joints=False).warnings
    assert says in moving_load(overhang(), WHEEL, along(0, 3, height=1.0), positions=3, spread=0.5).warnings
    assert says not in moving_load(overhang(), WHEEL, along(0, 3), positions=3).warnings
