import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess, find_interfaces
from blockstat.contact.overlap.penetration import convex_blocks, overlaps
from blockstat.model import Coping, Opening, Through, arc_wall
from blockstat.model.walling.run import BONDS
from elements import sound
from walls import grounded, straight_joints

CENTRE = np.array([2.0, -1.0])


def sector(block):
    """Area of the annular sector whose corners are those of a brick, between its circles and radii [m2]."""
    plan = block.vertices[:, :2] - CENTRE
    r, turn = np.hypot(*plan.T), np.arctan2(plan[:, 1], plan[:, 0])
    turn = (turn - turn[0] + np.pi) % (2 * np.pi)
    return np.ptp(turn) * (r.max() ** 2 - r.min() ** 2) / 2


@settings(max_examples=30, deadline=None)
@given(
    radius=st.floats(1.2, 4), thickness=st.floats(0.3, 0.8), turn=st.sampled_from([90.0, 180.0, 250.0, 360.0]),
    start=st.floats(-180, 180), bond=st.sampled_from(BONDS), leaves=st.integers(1, 2), brick=st.floats(0.3, 0.6),
    courses=st.integers(2, 5),
)  # fmt: skip
def test_any_round_wall_is_sound(radius, thickness, turn, start, bond, leaves, brick, courses):
    blocks = arc_wall(
        "r", centre=CENTRE, radius=radius, start=start, end=start + turn, thickness=thickness, height=0.25 * courses,
        bond=bond, leaves=leaves, brick=(brick, 0.25),
    )  # fmt: skip
    asm = grounded(blocks)
    faces = sound(asm, convex=True)
    # The sectors of each course fill the ring; with no overlap, nothing is left out.
    for course in range(courses):
        found = sum(sector(b) for b in blocks if b.name.split(".")[2] == str(course))
        assert found == pytest.approx(np.deg2rad(turn) * radius * thickness, rel=1e-9)
    # Head joints are whole: the radial faces of a leaf or of the whole wall.
    upright = (np.abs(faces.frame[:, 0, 2]) < 1e-9) & (faces.pair > 0).all(axis=1)
    middle = np.array([faces.point[a:b].mean(axis=0) for a, b in zip(faces.start, faces.start[1:], strict=False)])
    out = middle[:, :2] - CENTRE
    radial = upright & (np.abs((faces.frame[:, 0, :2] * out).sum(axis=1)) < 1e-6 * np.hypot(*out.T))
    wide = faces.area[radial] / (thickness * 0.25)
    number = 2 if bond in ("english", "flemish") else leaves
    assert np.isclose(wide[:, None], [1.0, 1 / number], rtol=1e-9).any(axis=1).all()
    crossed = wide.sum() + (0 if turn == 360 else courses)
    if bond in ("running", "stack"):
        assert crossed == pytest.approx(len(blocks) / number, rel=1e-9)
    if bond == "running" and leaves == 1:
        assert straight_joints(asm, faces) == []


def test_a_tower_stands():
    blocks = arc_wall(
        "tower", radius=2.0, thickness=0.5, height=3.0, batter=(0.0, 0.05), coping=Coping(overhang=0.05),
        openings=[Opening(width=0.9, height=1.8, at=[1.5]), Opening(width=0.4, height=0.7, sill=1.0, at=[5.0, 8.0])],
    )  # fmt: skip
    asm = grounded(blocks)
    assert set(asm.groups) == {"ground", "wall.tower", "wall.tower.lintel", "wall.tower.coping"}
    assert convex_blocks(asm).all()
    assert len(overlaps(asm, gap=1e-9)[0]) == 0
    assert len(asm.in_group("wall.tower.lintel")) == 3
    assert assess(asm).outcome.word == "stable"


def test_openings_of_a_tower_are_cut_at_the_jambs():
    blocks = arc_wall(
        "r", centre=CENTRE, radius=2.0, thickness=0.4, height=2.0, openings=[Opening(width=0.8, height=1.25, at=[3.0])]
    )
    for course in range(5):
        found = sum(sector(b) for b in blocks if b.name.split(".")[2] == str(course))
        assert found == pytest.approx((4 * np.pi - 0.8) * 0.4, rel=1e-9)


def test_an_apse_runs_on_straight():
    blocks = arc_wall("apse", radius=2.0, start=0, end=180, tails=(1.0, 1.5), thickness=0.5, height=1.0)
    asm = grounded(blocks)
    sound(asm, convex=True)
    plan = np.vstack([b.vertices for b in blocks])
    assert plan[:, :2].min(axis=0) == pytest.approx([-2.25, -1.5], abs=1e-3)
    ends = {round(float(y), 9) for y in plan[plan[:, 0] > 1.7, 1] if y < 0}
    assert min(ends) == pytest.approx(-1.0)


@pytest.mark.parametrize("end", [132.0, 150.0, 360.0])
def test_coping_stones_of_long_bricks_are_as_short_as_the_radius_needs(end):
    # Two bricks would be over 80 degrees: a straight side of the stone is then outside the wall.
    brick = (0.7, 0.25)
    stones = arc_wall("r", centre=CENTRE, radius=1.0, end=end, thickness=0.3, height=0.75, brick=brick, coping=Coping())
    for stone in (block for block in stones if block.group.endswith("coping")):
        plan = stone.vertices[:, :2] - CENTRE
        turn = np.angle((plan @ (1, 1j)) / (plan[0] @ (1, 1j)), deg=True)
        assert np.ptp(turn) < 60 + 1e-9


@pytest.mark.parametrize("batter", [(0.1, 0.0), (0.0, 0.1)])
def test_a_battered_apse_of_one_leaf_runs_on_straight(batter):
    options = {"radius": 1.0, "thickness": 0.45, "end": 180, "height": 1.25, "tails": (0.1, 0.3)}
    assert len(overlaps(grounded(arc_wall("r", batter=batter, **options)), gap=1e-7)[0]) == 0


def test_leaves_with_through_stones():
    asm = grounded(arc_wall("r", radius=2.0, thickness=0.6, height=1.5, leaves=3, through=Through()))
    faces = find_interfaces(asm)
    assert faces.gap.max() < 1e-9
    assert len(overlaps(asm, gap=1e-9)[0]) == 0


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"radius": 0.1}, "radius is 0.1; it must be more than half the thickness"),
        ({"end": 400.0}, "end must be up to 360 degrees beyond"),
        ({"end": 270.0, "tails": (1.0, 1.0)}, "run into each other"),
        ({"openings": [Opening(width=0.6, height=0.5, head="semicircular")]}, "a round wall has lintels only"),
        ({"openings": [Opening(width=3.0, height=0.5)]}, "lintel is too long for the radius"),
        # An eighth of a brick at each side is the least: 2.2 m are more than 60 degrees of 2 m, 2.09 m.
        (
            {"openings": [Opening(width=1.0, height=0.5), Opening(width=2.2, height=0.5)]},
            r"openings\[1\]: width is 2.2 ",
        ),
        ({"openings": [Opening(width=1.0, height=0.5, bearing=0.6)]}, "width is 1 and bearing 0.6; .* up to 2.09 m"),
        ({"coping": Coping(length=2.2)}, "coping.length is 2.2; it must be up to 1.57 m, as the radius is 2 m"),
        ({"brick": (3.0, 0.25)}, "too long for a radius"),
        ({"gable": 1.0}, 'no option "gable"; options are: batter'),
        ({"end": 90.0, "tails": (1.0, 0.0), "batter": (0.0, 0.1), "leaves": 2}, r"batter is \[0.0, 0.1\]; .* one leaf"),
        ({"end": 90.0, "tails": (1.0, 0.0), "batter": (0.1, 0.0), "bond": "english"}, r"batter is \[0.1, 0.0\]"),
        ({"end": 90.0, "tails": (1.0,)}, r"tails is \(1\.0,\); it must be two lengths of at least 0"),
        ({"end": 90.0, "tails": (1.0, -0.1)}, r"tails is \(1\.0, -0\.1\); it must be two lengths of at least 0"),
        ({"end": 90.0, "tails": (0.0, np.inf)}, "it must be two lengths of at least 0"),
    ],
)
def test_bad_round_walls_are_named(change, match):
    with pytest.raises(InputError, match=match):
        arc_wall("r", **{"radius": 2.0, "thickness": 0.4, "height": 1.0, **change})


def test_a_round_wall_has_one_stretch_for_openings():
    openings = [Opening(width=0.5, height=0.5), Opening(width=0.5, height=0.5, segment=1)]
    with pytest.raises(InputError, match=r'wall "r": openings\[1\]: segment is 1; a round wall has one, 0'):
        arc_wall("r", radius=2.0, thickness=0.4, height=1.0, openings=openings)


@pytest.mark.parametrize("key", ["thickness", "height"])
def test_a_round_wall_without_a_thickness_or_a_height_says_so(key):
    options = {"radius": 2.0, "thickness": 0.4, "height": 1.0}
    del options[key]
    with pytest.raises(InputError, match=f"arc_wall: {key} is missing; a round wall needs one"):
        arc_wall("r", **options)


def test_an_opening_that_is_absent_is_neither_checked_nor_cut():
    absent = Opening(width=9.0, height=0.5, head="semicircular", present=False)
    options = {"radius": 2.0, "thickness": 0.4, "height": 1.0}
    whole, spared = arc_wall("r", **options), arc_wall("r", openings=[absent], **options)
    assert [block.name for block in spared] == [block.name for block in whole]


def test_a_lintel_bears_by_default_on_as_little_as_the_radius_needs():
    # 1.9 m of 2.09 m that a lintel may span; half a brick at each end would be .3 m.
    asm = grounded(arc_wall("r", radius=2.0, thickness=0.5, height=3.0, openings=[Opening(width=1.9, height=2.0)]))
    (lintel,) = (k for k, group in enumerate(asm.groups) if group.endswith("lintel"))
    plan = asm.block_vertices(lintel)[:, :2]
    turn = np.angle((plan @ (1, 1j)) / (plan.mean(axis=0) @ (1, 1j)), deg=True)
    assert np.ptp(turn) == pytest.approx(60, abs=1e-6)


@pytest.mark.parametrize("none", [{"number": 0}, {"at": []}])
def test_openings_that_are_none_are_not_asked_for_their_lintel(none):
    bare = arc_wall("r", radius=2.0, thickness=0.5, height=3.0)
    with_none = arc_wall("r", radius=2.0, thickness=0.5, height=3.0, openings=[Opening(width=3.0, height=2.9, **none)])
    assert len(with_none) == len(bare)
