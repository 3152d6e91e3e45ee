import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, InputWarning, limit_load
from blockstat.model import Buttress, Run, buttress, flying_buttress, walls
from blockstat.model.solids import box
from elements import joint_areas, sound
from walls import check_solid, grounded, straight_joints, tight


@settings(max_examples=25, deadline=None)
@given(
    number=st.integers(1, 3), width=st.floats(0.4, 1.0), projection=st.floats(0.3, 1.2), bonded=st.booleans(),
    side=st.sampled_from(["left", "right"]), thickness=st.floats(0.3, 0.8),
    bond=st.sampled_from(["running", "english"]), brick=st.floats(0.3, 0.7), courses=st.integers(4, 8),
)  # fmt: skip
def test_any_buttressed_wall_is_sound(number, width, projection, bonded, side, thickness, bond, brick, courses):
    height = 0.25 * courses
    run = Run(name="a", path=[(0, 0), (6, 0)], thickness=thickness, height=height, bond=bond)
    spec = Buttress(
        wall="a", number=number, width=width, projection=projection, height=height, bonded=bonded, side=side
    )
    blocks = walls(run, brick=(brick, 0.25), buttresses=[spec])
    area = 6 * thickness + number * width * projection
    girth = 2 * (6 + thickness) + number * 2 * projection
    asm, faces = check_solid(blocks, area=area, height=height, girth=girth)
    assert set(asm.groups) == {"ground", "wall.a", *(f"buttress.a.{k + 1}" for k in range(number))}
    if bonded:
        assert straight_joints(asm, faces) == []


@settings(max_examples=25, deadline=None)
@given(
    width=st.floats(0.3, 1.0), projection=st.floats(0.6, 1.2), rake=st.floats(0, 0.1), first=st.integers(2, 4),
    second=st.integers(5, 7), weathering=st.integers(0, 1), brick=st.floats(0.3, 0.7),
)  # fmt: skip
def test_any_stepped_and_raked_buttress_is_sound(width, projection, rake, first, second, weathering, brick):
    # Eight courses of 0.25 m; projections p, 0.7 p and 0.4 p; a step slopes back over one course or none.
    p, top, slope = projection, 2.0, 0.25 * weathering
    steps = [(0.25 * first, 0.7 * p), (0.25 * second, 0.4 * p)]
    blocks = buttress(
        width=width, projection=p, height=top, steps=steps, weathering=slope, rake=rake, brick=(brick, 0.25)
    )
    asm = grounded(blocks)
    z = [0.25 * first, 0.25 * second]
    profile = p * (z[0] + 0.7 * (z[1] - z[0]) + 0.4 * (top - z[1])) + 2 * slope * 0.3 * p / 2 - rake * top**2 / 2
    assert asm.volume[1:].sum() == pytest.approx(width * profile, rel=1e-9)
    tight(asm)
    assert set(asm.groups) == {"ground", "buttress"}


@pytest.mark.parametrize("push", [1, -1])
def test_a_bonded_buttress_holds_a_wall_better_than_one_that_stands_against_it(push):
    # The wall alone tips at t / H = 0.2; a loose buttress leans on it or is leant on, a bonded one goes along.
    limits = {}
    for bonded in (True, False):
        run = Run(name="a", path=[(0, 0), (2, 0)], thickness=0.3, height=1.5)
        spec = Buttress(wall="a", width=0.4, projection=0.6, height=1.5, bonded=bonded)
        asm = grounded(walls(run, brick=(0.5, 0.25), buttresses=[spec]))
        limits[bonded] = limit_load(asm, (0, push, 0), friction=0.7)
    assert limits[True].lower > 1.2 * limits[False].upper > 1.2 * 0.2


def test_a_buttress_on_a_battered_wall_meets_its_face():
    run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2, batter=(0.0, 0.05))
    for bonded in (True, False):
        spec = Buttress(wall="a", width=0.5, projection=0.6, height=1.5, bonded=bonded)
        asm = grounded(walls(run, brick=(0.5, 0.25), buttresses=[spec]))
        # The wedge between the leaning face and the upright one belongs to the buttress.
        volume = 4 * 2 * 0.5 - 4 * 0.05 * 2**2 / 2 + 0.5 * (0.6 * 1.5 + 0.05 * 1.5**2 / 2)
        assert asm.volume[1:].sum() == pytest.approx(volume, rel=1e-9)
        sound(asm, convex=True)


@settings(max_examples=30, deadline=None)
@given(
    form=st.sampled_from(["arc", "straight"]), span=st.floats(1, 5), low=st.floats(0.5, 4), rise=st.floats(0.15, 0.9),
    depth=st.floats(0.05, 0.15), width=st.floats(0.3, 1), voussoirs=st.integers(2, 12), pinnacle=st.booleans(),
)  # fmt: skip
def test_any_flyer_is_sound(form, span, low, rise, depth, width, voussoirs, pinnacle):
    high, depth = low + rise * span, depth * span
    blocks = flying_buttress(
        form, span=span, low=low, high=high, depth=depth, width=width, voussoirs=voussoirs, pier=(0.8, width + 0.2),
        courses=5, pinnacle=0.5 * pinnacle,
    )  # fmt: skip
    wall = box((-0.5, -width, 0.0), (0.0, width, high + 4 * depth + 1), name="wall", group="wall")
    asm = grounded([*blocks, wall])
    faces, closed = tight(asm)
    groups = {"ground", "wall", "flyer", "pier"} | ({"pinnacle"} if pinnacle else set())
    assert set(asm.groups) == groups
    areas = joint_areas(asm, SimpleNamespace(pair=faces.pair[closed], area=faces.area[closed]))
    assert areas["flyer.0", "wall"] > 0.9 * depth * width
    top = asm.block_vertices(asm.names.index("pier.4.0"))[:, 2].max()
    ends = [area for (a, b), area in areas.items() if {a.split(".")[0], b.split(".")[0]} == {"flyer", "pier"}]
    assert sum(ends) == pytest.approx((top - low) * width, rel=1e-9)
    assert len([b for b in blocks if b.group == "flyer"]) == voussoirs
    section = asm.volume[asm.in_group("flyer")].sum() / width
    if form == "straight":
        assert section == pytest.approx(span * depth * np.hypot(1, rise), rel=1e-9)  # a parallelogram


def test_a_flyer_holds_a_wall_that_is_pushed_outwards():
    # The wall alone tips at t / H = 0.6 / 3.2.
    run = Run(name="a", path=[(0, -1), (0, 1)], thickness=0.6, height=3.2, align="left")
    wall = walls(run, brick=(0.5, 0.2))
    flyer = flying_buttress(
        span=1.5, low=1.6, high=2.4, depth=0.3, width=0.4, voussoirs=5, pier=(1.0, 0.6), courses=6, pinnacle=0.4
    )
    alone = limit_load(grounded(wall), (1, 0, 0), friction=0.7)
    held = limit_load(grounded(wall + flyer), (1, 0, 0), friction=0.7)
    assert alone.upper == pytest.approx(0.6 / 3.2, rel=1e-5)
    assert held.lower > 1.1 * alone.upper


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"wall": "b"}, "there is no such wall; walls are: a"),
        ({"number": 9}, "9 buttresses of 0.6 m width do not fit 4 m of wall"),
        ({"at": [0.1]}, "a width of 0.6 m at 0.1 m does not fit"),
        ({"side": "outer"}, "side is 'outer'; it must be one of: left, right"),
        ({"steps": [(1.0, 0.9)]}, "heights must grow and projections decrease"),
        ({"rake": 2.0}, "slopes back into the wall"),
        ({"height": 9.0}, "height is 9 m; the walls reach 2 m"),
        ({"segment": 1}, "segment is 1; its path has 1"),
        ({"projection": -1}, "projection is -1"),
        ({"weathering": -1}, r'buttresses\[0\] of wall "a": weathering and rake must be at least 0'),
        ({"rake": -0.1}, "weathering and rake must be at least 0"),
    ],
)
def test_bad_buttresses_are_named(change, match):
    spec = Buttress(**{"wall": "a", "width": 0.6, "projection": 0.8, "height": 1.5, **change})
    with pytest.raises(InputError, match=match):
        walls(Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2), buttresses=[spec])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"form": "wavy"}, "form is 'wavy'; it must be one of: arc, straight"),
        ({"high": 0.5}, "the soffit must rise"),
        ({"high": 9.0}, "that of an arc must be less than the span"),
        ({"voussoirs": 1}, "voussoirs is 1"),
        ({"pier_height": 1.0}, "pier_height is 1"),
        ({"pier": None, "pier_height": 3.0}, "pier_height says nothing without a pier; give the size of one as pier"),
        ({"pier": None, "courses": 4}, "courses says nothing without a pier"),
        ({"pier": None, "pinnacle": 0.5}, "pinnacle says nothing without a pier"),
        # A slope of 45 degrees: what is square to it reaches as far along as it is deep, and the soffit is 2 sqrt(2) m.
        ({"form": "straight", "high": 3.0, "depth": 2.9}, "depth is 2.9; joints .* need less than 2.83 m"),
    ],
)
def test_bad_flyers_are_named(change, match):
    options = {"span": 2.0, "low": 1.0, "high": 2.0, "depth": 0.3, "width": 0.5, "voussoirs": 5, "pier": (0.6, 0.6)}
    with pytest.raises(InputError, match=match):
        flying_buttress(**{**options, **change})


@pytest.mark.parametrize(("change", "told"), [
    ({"height": 1.1}, 'buttresses[0] of wall "a": asked from 0 to 1.1 m, built from 0 to 1 m: its height goes to'),
    ({"bonded": False, "height": 1.4}, "asked from 0 to 1.4 m, built from 0 to 1.5 m: its height goes to the nearest"),
    ({"steps": [(0.6, 0.5)]}, "a step: asked from 0.6 m, built from 0.5 m: steps go to the nearest bed"),
    ({"steps": [(0.5, 0.5)], "weathering": 0.1}, "a step: asked from 0.5 to 0.6 m, built from 0.5 to 0.5 m: steps go"),
])  # fmt: skip
def test_a_buttress_that_is_built_at_other_heights_than_asked_says_so(change, told):
    spec = Buttress(**{"wall": "a", "number": 2, "width": 0.6, "projection": 0.8, "height": 1.5, **change})
    with pytest.warns(InputWarning) as caught:
        walls(Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2), buttresses=[spec])
    assert all(told in str(warning.message) for warning in caught)


def test_a_buttress_that_is_built_as_asked_says_nothing():
    spec = Buttress(
        wall="a", width=0.6, projection=0.8, height=1.5 + 1e-9, steps=[(0.5, 0.6), (1.0, 0.4)], weathering=0.25
    )
    own = Buttress(wall="a", width=0.6, projection=0.8, height=1.1, courses=3, bonded=False, at=[0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        walls(Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2), buttresses=[spec, own])


@pytest.mark.parametrize(("height", "bonded", "brick", "course"), [
    (0.2, True, (0.5, 0.5), "0.5"), (0.05, False, (0.5, 0.25), "0.25"),
])  # fmt: skip
def test_a_buttress_without_a_course_is_named_with_the_least(height, bonded, brick, course):
    spec = Buttress(wall="a", width=0.6, projection=0.8, height=height, bonded=bonded)
    with pytest.raises(InputError, match=f"height is {height} m; .* lowest course, which is {course} m high"):
        walls(Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2), brick=brick, buttresses=[spec])


def test_a_buttress_that_is_absent_or_of_an_absent_wall_is_neither_checked_nor_built():
    run = Run(name="a", path=[(0, 0), (4, 0)], thickness=0.5, height=2)
    gone = Run(name="b", path=[(0, 5), (4, 5)], thickness=0.5, height=2, present=False)
    bad = {"width": -1.0, "projection": 0.8, "height": 1.5}
    specs = [Buttress(wall="a", present=False, **bad), Buttress(wall="b", **bad)]
    assert {block.group for block in walls([run, gone], buttresses=specs)} == {"wall.a"}
    with pytest.raises(InputError, match=r'buttresses\[0\] of wall "a": width is -1'):
        walls([run, gone], buttresses=[Buttress(wall="a", **bad)])


@pytest.mark.parametrize(
    ("given", "places"),
    [
        ({}, [3.0]), ({"number": 2}, [2.0, 4.0]), ({"at": [1.0, 3.0, 5.0]}, [1.0, 3.0, 5.0]),
        ({"number": 2, "at": [1.0, 5.0]}, [1.0, 5.0]),
    ],
)  # fmt: skip
def test_buttresses_are_as_many_as_their_number_or_their_places(given, places):
    run = Run(name="a", path=[(0, 0), (6, 0)], thickness=0.4, height=1.0)
    spec = Buttress(wall="a", width=0.5, projection=0.5, height=1.0, bonded=False, courses=1, **given)
    stones = [block.vertices[:, 0] for block in walls(run, buttresses=[spec]) if block.group.startswith("buttress")]
    assert [(x.min() + x.max()) / 2 for x in stones] == pytest.approx(places)


def test_a_number_of_buttresses_that_is_not_that_of_their_places_is_refused():
    """Formerly the places counted, and the number was not used."""
    run = Run(name="a", path=[(0, 0), (6, 0)], thickness=0.4, height=1.0)
    spec = Buttress(wall="a", width=0.5, projection=0.5, height=1.0, number=3, at=[3.0])
    with pytest.raises(InputError, match=r'^buttresses\[0\] of wall "a": number is 3, and the list of at has 1; give'):
        walls(run, buttresses=[spec])
