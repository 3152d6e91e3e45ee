import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, InputWarning, assess, build, load_scene, scene_from
from blockstat.model import Opening, Run, walls
from blockstat.model.walling.run import BONDS, HEADS
from walls import check, grounded


def soffit(head, width, rise, number):
    """Corners of the intrados from right to left: equal lengths of it by a fine table, shape (n + 1, 2)."""
    half = width / 2
    t = np.linspace(0, 1, 200_001)
    if head == "elliptic":
        x, z = half * np.cos(np.pi * t), rise * np.sin(np.pi * t)
    elif head == "pointed":
        radius = (half**2 + rise**2) / width
        turn = np.arctan2(rise, radius - half) * np.minimum(2 * t, 2 - 2 * t)
        side = np.where(t <= 0.5, 1, -1)
        x, z = side * (half - radius + radius * np.cos(turn)), radius * np.sin(turn)
    else:
        radius = (half**2 + rise**2) / (2 * rise)
        first = np.arctan2(half, radius - rise)
        turn = first * (1 - 2 * t)
        x, z = radius * np.sin(turn), radius * (np.cos(turn) - np.cos(first))
    walked = np.concatenate([[0], np.cumsum(np.hypot(np.diff(x), np.diff(z)))])
    place = np.linspace(0, walked[-1], number + 1)
    return np.column_stack([np.interp(place, walked, x), np.interp(place, walked, z)])


@settings(max_examples=40, deadline=None)
@given(
    head=st.sampled_from(HEADS), width=st.floats(0.6, 1.2), flatness=st.floats(0.1, 0.95), depth=st.floats(0.15, 0.35),
    courses=st.integers(10, 20), brick=st.floats(0.3, 0.6), number=st.integers(1, 2), door=st.booleans(),
    bond=st.sampled_from(BONDS), leaves=st.integers(1, 2), voussoirs=st.sampled_from([None, 6, 10]),
)  # fmt: skip
def test_any_opening_is_cut_exactly(
    head, width, flatness, depth, courses, brick, number, door, bond, leaves, voussoirs
):
    length, height, thickness = 7.0, 3.6, 0.4
    rise = {"segmental": flatness * width / 2, "pointed": width * (0.5 + 0.4 * flatness), "elliptic": flatness * width}
    course = height / courses
    sill, spring = (0 if door else round(0.6 / course)) * course, max(round(1.4 / course), 3) * course
    opening = Opening(
        width=width, height=spring - sill, sill=sill, number=number, head=head, rise=rise.get(head), depth=depth,
        voussoirs=None if head == "lintel" else voussoirs,
    )  # fmt: skip
    run = Run(
        name="a", path=[(0, 0), (0, length)], thickness=thickness, height=height, bond=bond, leaves=leaves,
        openings=[opening],
    )  # fmt: skip
    blocks = walls(run, brick=(brick, course))
    groups = {b.group for b in blocks}
    clear, edge = width * (spring - sill), 2 * (spring - sill) + (0 if door else width)
    if head in ("lintel", "flat"):
        edge += width
    else:
        stones = sum(b.group == "wall.a.arch" for b in blocks) // number
        assert voussoirs in (None, stones)
        line = soffit(head, width, rise.get(head, width / 2), stones)
        x, z = line.T
        clear += (z[1:] + z[:-1]) @ (x[:-1] - x[1:]) / 2
        edge += np.hypot(*np.diff(line, axis=0).T).sum()
    elevation, foot = length * height - number * clear, thickness * (length - number * width * door)
    outside = 2 * elevation + foot + thickness * (length + 2 * height + number * edge)
    check(grounded(blocks), volume=thickness * elevation, foot=foot, outside=outside, tolerance=1e-6)
    assert groups == {"wall.a", "wall.a.lintel" if head == "lintel" else "wall.a.arch"}


def test_a_lintel_by_hand():
    # A window of 1 x 0.6 m at 0.4 m in the middle of 4 m, courses of 0.2 m; a lintel of 1.5 m in one course.
    opening = Opening(width=1.0, height=0.6, sill=0.4, bearing=0.25)
    blocks = walls(
        Run(name="a", path=[(0, 0), (4, 0)], thickness=0.3, height=1.6, openings=[opening]), brick=(0.4, 0.2)
    )
    (lintel,) = (b for b in blocks if b.group == "wall.a.lintel")
    assert lintel.vertices.min(axis=0) == pytest.approx([1.25, -0.15, 1.0])
    assert lintel.vertices.max(axis=0) == pytest.approx([2.75, 0.15, 1.2])
    beside = {round(float(b.vertices[:, 0].max()), 9) for b in blocks if b.name.split(".")[2] in "234"}
    assert 1.5 in beside


def test_a_flat_arch_by_hand():
    # Two courses of 0.2 m deep over 1 m, skewbacks at 45 degrees: a trapezium of 1 and 1.8 m.
    opening = Opening(width=1.0, height=0.6, head="flat", depth=0.4, skew=45, voussoirs=5)
    run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.3, height=1.6, openings=[opening])
    asm = grounded(walls(run, brick=(0.4, 0.2)))
    stones = asm.in_group("wall.a.arch")
    assert len(stones) == 5
    assert asm.volume[stones].sum() == pytest.approx(0.3 * 0.4 * (1 + 1.8) / 2)


@pytest.mark.parametrize("head", HEADS)
def test_bricks_at_openings_are_no_slivers(head):
    rise = {"segmental": 0.25, "pointed": 0.8, "elliptic": 0.3}.get(head)
    openings = [Opening(width=0.97, height=1.0, sill=0.4, number=2, head=head, rise=rise, depth=0.25)]
    blocks = walls(Run(name="a", path=[(0, 0), (7, 0)], thickness=0.4, height=3, openings=openings), brick=(0.5, 0.2))
    shortest = min(np.ptp(b.vertices[:, 0]) for b in blocks if b.group == "wall.a")
    assert shortest > 0.5 / 3 * 0.97  # bricks are not exactly 0.5 m long


@pytest.mark.parametrize("head", HEADS)
def test_walls_with_openings_stand(head):
    rise = {"segmental": 0.25, "pointed": 0.8, "elliptic": 0.4}.get(head)
    openings = [Opening(width=1.0, height=1.0, head=head, rise=rise, depth=0.3)]
    run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.4, height=2.6, openings=openings)
    assert assess(grounded(walls(run, brick=(0.5, 0.2)))).outcome.word == "stable"


def test_positions_and_segments():
    openings = [Opening(width=0.8, height=1, at=[1.0, 2.5], segment=1)]
    run = Run(name="a", path=[(0, 3), (0, 0), (4, 0)], thickness=0.4, height=1.8, openings=openings)
    blocks = walls(run, brick=(0.5, 0.2))
    middles = [float(b.vertices[:, 0].mean()) for b in blocks if b.group == "wall.a.lintel"]
    assert middles == pytest.approx([1.0, 2.5])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"width": 0}, r"openings\[0\]: width is 0"),
        ({"head": "round"}, r"openings\[0\]: head is 'round'; it must be one of: lintel"),
        ({"head": "segmental"}, r"openings\[0\]: rise is missing"),
        ({"head": "semicircular", "height": 1.5}, "a semicircular head over it reaches above the wall of 2 m"),
        ({"height": 3}, "sill and height reach beyond the wall of 2 m"),
        ({"at": [9.0]}, r"at is \[9.0\]; the wall is 4 m long"),
        ({"at": [0.7]}, "is left between its end and"),
        ({"at": [1.0, 2.1]}, r"is left between .* and .* leave at least"),
        ({"head": "pointed", "rise": 0.7, "voussoirs": 7}, "voussoirs is 7"),
        ({"head": "flat", "skew": 80}, "skew is 80"),
        ({"skew": 20.0}, "skew says nothing about a lintel head; it is for: flat"),
        ({"sill": -1}, "sill is -1"),
        # One course of a quarter of a metre is left over the soffit.
        ({"height": 1.75, "depth": 0.4}, "a lintel head of 0.4 m depth over it reaches above the wall of 2 m"),
        ({"rise": 0.3}, "rise says nothing about a lintel head"),
        ({"head": "flat", "bearing": 0.3}, "bearing says nothing about a flat head; it is for: lintel"),
    ],
)
def test_bad_openings_are_named(change, match):
    options = {"width": 1.0, "height": 1.0, **change}
    with pytest.raises(InputError, match=match):
        walls(Run(name="a", path=[(0, 0), (4, 0)], thickness=0.4, height=2, openings=[Opening(**options)]))


def test_an_opening_between_beds_is_told_with_both_heights():
    """Courses of 0.25 m: a window from 0.9 to 2.1 m is built from 1 to 2 m; one drawn to the millimetre is as asked."""

    def wall(sill, height):
        opening = Opening(width=0.6, height=height, sill=sill, number=2)
        run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.3, height=3.0, openings=[opening])
        return walls(run, brick=(0.5, 0.25))

    with pytest.warns(InputWarning) as told:
        blocks = wall(0.9, 1.2)
    assert [str(warning.message) for warning in told] == [
        'wall "a": openings[0]: asked from 0.9 to 2.1 m, built from 1 to 2 m: sill and top go to the nearest bed'
    ]
    lintels = [block for block in blocks if block.group == "wall.a.lintel"]
    assert {round(float(lintel.vertices[:, 2].min()), 9) for lintel in lintels} == {2.0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wall(1.0, 1.0)
        wall(1.0004, 0.9999)


def test_a_lintel_between_beds_is_told_with_both_heights():
    """Courses of 0.25 m: a lintel of 0.4 m over two windows of 1 m is two courses deep; without a depth it is one."""
    openings = [Opening(width=0.6, height=1.0, number=2, depth=0.4)]
    run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.3, height=2.0, openings=openings)
    with pytest.warns(InputWarning) as told:
        blocks = walls(run, brick=(0.5, 0.25))
    assert [str(warning.message) for warning in told] == [
        'wall "a": openings[0]: depth: asked from 1 to 1.4 m, built from 1 to 1.5 m: the top of a lintel goes to the '
        "nearest bed"
    ]
    lintels = [block for block in blocks if block.group == "wall.a.lintel"]
    assert {round(float(lintel.vertices[:, 2].max()), 9) for lintel in lintels} == {1.5}


def test_a_window_of_a_chapel_between_beds_is_told_by_its_key(tmp_path):
    path = tmp_path / "hut.toml"
    window = "[windows.south]\nwidth = 0.8\nsill = 1.0\nheight = 0.8\n"
    path.write_text(f'name = "hut"\nlength = 4.0\nspan = 3.0\n[wall]\nheight = 2.4\n{window}')
    with pytest.warns(
        InputWarning, match=r"^windows.south: asked from 1 to 1.8 m, built from 0.9 to 1.8 m: sill and top"
    ):
        build(load_scene(path))


@pytest.mark.parametrize(("sill", "height"), [(1e308, 1e308), (1e308, 1.0), (2.4, 1.0), (0.0, 1e300)])
def test_a_window_far_above_the_wall_is_refused_by_its_key(sill, height):
    scene = {"name": "hut", "length": 4.0, "span": 3.0, "wall": {"height": 2.4}}
    scene["windows"] = {"south": {"width": 0.8, "sill": sill, "height": height}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match=r"^windows.south: sill and height reach beyond the wall of 2.4 m$"):
            build(scene_from(scene))


@pytest.mark.parametrize("none", [{"number": 0}, {"at": []}])
def test_openings_that_are_none_need_no_room_for_a_head(none):
    bare = walls([Run(name="a", path=[(0, 0), (4, 0)], thickness=0.4, height=2.0)])
    opening = Opening(width=1.0, height=1.75, depth=1.0, **none)
    assert len(walls([Run(name="a", path=[(0, 0), (4, 0)], thickness=0.4, height=2.0, openings=[opening])])) == len(
        bare
    )


EITHER = r"give either number \(evenly spaced\) or at \(where their centres are\)"
THREE = {"value": 3, "min": 1, "max": 3, "step": 1}


@pytest.mark.parametrize("key", ["openings", "buttresses"])
@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        ({"number": 3, "at": [1.0]}, "number is 3, and the list of at has 1"),
        ({"number": 1, "at": [1.0, 3.0]}, "number is 1, and the list of at has 2"),
        ({"number": 0, "at": [1.0]}, "number is 0, and the list of at has 1"),
        ({"number": THREE, "at": [1.0, 2.0, 3.0]}, "a range moves it, and at says where 3 are"),
        ({"number": "= n", "at": [1.0, 2.0, 3.0]}, "number is 1, and the list of at has 3"),
    ],
)
def test_a_number_that_is_not_that_of_the_places_is_refused(key, given, wrong):
    """Formerly the places counted, and the number was not used."""
    run = {"path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 2.0}
    sizes = {"width": 0.5, "height": 1.0}
    if key == "openings":
        wall, place = {"runs": {"a": run | {key: [sizes | given]}}}, "runs.a.openings"
    else:
        wall, place = {"runs": {"a": run}, key: [sizes | {"wall": "a", "projection": 0.5} | given]}, key
    scene = {"name": "w", "parameters": {"n": THREE}, "elements": {"w": {"kind": "walls"} | wall}}
    with pytest.raises(InputError, match=rf"^elements\.w\.{place}\[0\]\.number: {wrong}; {EITHER}$"):
        scene_from(scene)


def test_the_builder_of_walls_refuses_a_number_beside_other_places_too():
    with pytest.raises(InputError, match=rf'^wall "a": openings\[0\]: number is 2, .* at has 1; {EITHER}$'):
        walls([Run(name="a", path=[(0, 0), (4, 0)], thickness=0.4, height=2.0, openings=[door(number=2, at=[1.0])])])


@pytest.mark.parametrize(
    ("given", "centres"),
    [
        ({}, [3.0]), ({"number": 2}, [2.0, 4.0]), ({"at": [1.0, 4.5]}, [1.0, 4.5]),
        ({"number": 2, "at": [1.0, 4.5]}, [1.0, 4.5]), ({"number": 0, "at": []}, []),
    ],
)  # fmt: skip
def test_openings_are_as_many_as_their_number_or_their_places(given, centres):
    run = Run(name="a", path=[(0, 0), (6, 0)], thickness=0.4, height=2.0, openings=[door(**given)])
    lintels = [block.vertices[:, 0] for block in walls([run]) if block.group == "wall.a.lintel"]
    assert [(x.min() + x.max()) / 2 for x in lintels] == pytest.approx(centres)


def door(**places):
    return Opening(width=0.5, height=1.0, **places)
