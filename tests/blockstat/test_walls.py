import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess, limit_load
from blockstat.contact.overlap.penetration import convex_blocks, overlaps
from blockstat.model import Coping, Opening, Run, Through, walls
from blockstat.model.kinds import walls_by_name
from blockstat.model.walling.run import BONDS
from elements import joint_areas, sound
from walls import band, check_solid, grounded, straight_joints


def wall(path=((0, 0), (4, 0)), *, thickness=0.5, height=1.5, brick=(0.5, 0.25), **options):
    return walls(Run(name="a", path=path, thickness=thickness, height=height, **options), brick=brick)


def lengths(blocks, group="wall.a", axis=0):
    """Lengths of the blocks of each course along an axis, in their order."""
    found: dict[str, list[float]] = {}
    for block in blocks:
        if block.group == group:
            found.setdefault(block.name.split(".")[-2], []).append(float(np.ptp(block.vertices[:, axis])))
    return found


def test_a_course_is_whole_bricks_and_one_half_brick():
    # LongitudeRow = NumberOfPoints x SizeOfBrick + HalfBrick (the procedural-masonry paper, Eq. 4): 4.5 = 4 x 1 + 0.5.
    rows = lengths(wall([(0, 0), (4.5, 0)], brick=(1.0, 0.25)))
    assert rows["0"] == pytest.approx([1, 1, 1, 1, 0.5])
    assert rows["1"] == pytest.approx([0.5, 1, 1, 1, 1])


def test_a_half_brick_of_another_size():
    # 4.3 = 4 x 1 + 0.3
    rows = lengths(wall([(0, 0), (4.4, 0)], brick=(1.0, 0.25), half=0.4))
    assert rows["0"] == pytest.approx([1, 1, 1, 1, 0.4])
    assert rows["1"] == pytest.approx([0.4, 1, 1, 1, 1])


def test_english_bond_by_hand():
    # Stretchers of 1 m in two leaves; headers of half a metre through the wall, a quarter off, the quoins 3/4.
    blocks = wall([(0, 0), (4, 0)], brick=(1.0, 0.25), bond="english")
    rows = lengths(blocks)
    assert rows["0"] == pytest.approx([1] * 8)
    assert rows["1"] == pytest.approx([0.75, *[0.5] * 5, 0.75])
    across = lengths(blocks, axis=1)
    assert across["0"] == pytest.approx([0.25] * 8)
    assert across["1"] == pytest.approx([0.5] * 7)


def test_flemish_bond_by_hand():
    # Stretcher 1, header 1/2: S H S H S = 4 m; in the next course headers in the middle of the stretchers below.
    blocks = wall([(0, 0), (4, 0)], brick=(1.0, 0.25), bond="flemish")
    places = {}
    for block in blocks:
        x, y = block.vertices[:, 0], block.vertices[:, 1]
        places.setdefault(block.name.split(".")[2], set()).add(
            (round(x.min(), 9), round(x.max(), 9), round(np.ptp(y), 9))
        )
    assert places["0"] == {(0, 1, 0.25), (1, 1.5, 0.5), (1.5, 2.5, 0.25), (2.5, 3, 0.5), (3, 4, 0.25)}
    assert places["1"] == {(0, 0.75, 0.5), (0.75, 1.75, 0.25), (1.75, 2.25, 0.5), (2.25, 3.25, 0.25), (3.25, 4, 0.5)}


def test_through_stones_cross_every_leaf():
    blocks = wall([(0, 0), (6.25, 0)], leaves=3, thickness=0.6, through=Through(courses=2, bricks=3))
    deep = [b for b in blocks if np.ptp(b.vertices[:, 1]) > 0.59]
    assert {b.name.split(".")[2] for b in deep} == {"1", "3", "5"}
    assert len(deep) == 3 * 4
    assert all(np.ptp(b.vertices[:, 0]) == pytest.approx(0.5) for b in deep)


CORNER = [(0, 3), (0, 0), (4, 0)]
SQUARE = [(0, 0), (4, 0), (4, 3), (0, 3), (0, 0)]


@pytest.mark.parametrize("bond", ["running", "english"])
@pytest.mark.parametrize("path", [CORNER, SQUARE])
def test_no_straight_joint_at_a_corner(bond, path):
    closed = path[0] == path[-1]
    asm = grounded(wall(path[: -1 if closed else None], closed=closed, bond=bond))
    assert straight_joints(asm) == []


@pytest.mark.parametrize("bond", BONDS)
def test_an_unbonded_corner_has_a_straight_joint_and_a_bonded_one_none(bond):
    # The inner corner is at (0.25, 0.25); a joint there is in the line of a face from the inner to an outer corner.
    run = Run(name="a", path=CORNER, thickness=0.5, height=1.5, bond=bond)
    corner = (0.25, 0.25)
    for bonded in (True, False):
        joints = straight_joints(grounded(walls(run, brick=(0.5, 0.25), bonded=bonded)))
        inner = [line for line in joints if min(np.hypot(*(np.array(c) - corner)) for c in line.coords) < 1e-6]
        assert bool(inner) != bonded


@pytest.mark.parametrize("bond", BONDS)
@pytest.mark.parametrize("thickness", [0.2, 0.37, 0.5, 0.81, 1.3])
def test_stones_at_a_corner_are_neither_slivers_nor_beams(bond, thickness):
    blocks = wall(CORNER, thickness=thickness, bond=bond)
    sizes = np.array([np.ptp(b.vertices, axis=0)[:2] for b in blocks])
    assert sizes.max() < 2 * 0.5 + thickness
    along = np.array([s[0] if b.vertices[:, 1].max() < thickness / 2 + 1e-9 else s[1]
                      for b, s in zip(blocks, sizes, strict=True)])  # fmt: skip
    assert along.min() > 0.5 / 3 * 0.9  # bricks are not exactly 0.5 m long


def test_area_of_the_corner_stone_by_hand():
    # Stones of 1 x 0.5 m at the corner lie crosswise on each other: they share 0.5 x 0.5 m.
    asm, faces = check_solid(wall(CORNER, brick=(1.0, 0.25)), area=0.5 * 7, height=1.5, girth=15)
    areas = joint_areas(asm, faces)
    centre = {name: asm.centroid[i] for i, name in enumerate(asm.names)}
    corner = [
        area
        for (a, b), area in areas.items()
        if a != "ground" and abs(centre[a][2] - centre[b][2]) > 0.2 and max(*np.abs(centre[a][:2])) < 0.3
        and max(*np.abs(centre[b][:2])) < 0.3
    ]  # fmt: skip
    assert corner == pytest.approx([0.25] * 5)


@st.composite
def plans(draw):
    """Runs that meet in one of several ways as (path, thickness), and the plan of their union."""
    t, u = draw(st.floats(0.2, 0.9)), draw(st.floats(0.2, 0.9))
    angle = np.deg2rad(draw(st.floats(35, 145)))
    a, b = draw(st.floats(3, 6)), draw(st.floats(3, 6))
    arm = (b * np.cos(angle), b * np.sin(angle))
    back = (-arm[0], -arm[1])
    kind = draw(st.sampled_from(["free", "corner", "tee", "cross", "ring", "zigzag"]))
    if kind in ("tee", "cross"):
        run, stem = ([(-a, 0), (a, 0)], t), ([arm, (0, 0) if kind == "tee" else back], u)
        # A stem ends in the far face of the run.
        crossing = band([arm, back], u) if kind == "cross" else band([arm, back], u) - shapely.box(-9, -9, 9, -t / 2)
        return [run, stem], band(*run) | crossing
    path = {
        "free": [(0, 0), (a, 0)],
        "corner": [(a, 0), (0, 0), arm],
        "ring": [(0, 0), (a, 0), (a + arm[0], arm[1]), arm, (0, 0)],
        "zigzag": [(-a, 0), (0, 0), arm, (arm[0] + a, arm[1])],
    }[kind]
    return [(path, t)], band(path, t)


@settings(max_examples=40, deadline=None)
@given(
    work=plans(), height=st.floats(0.6, 1.4), brick=st.floats(0.3, 0.8), course=st.floats(0.2, 0.5),
    bond=st.sampled_from(BONDS), leaves=st.integers(1, 3), half=st.sampled_from([0.5, 0.4, 0.6]),
)  # fmt: skip
def test_any_walls_are_sound(work, height, brick, course, bond, leaves, half):
    runs, outline = work
    specs = []
    for k, (path, thickness) in enumerate(runs):
        closed = path[0] == path[-1]
        points = path[: -1 if closed else None]
        specs.append(
            Run(name=f"r{k}", path=points, closed=closed, thickness=thickness, height=height, bond=bond, leaves=leaves,
                half=half)
        )  # fmt: skip
    blocks = walls(specs, brick=(brick, course))
    asm, faces = check_solid(blocks, area=outline.area, height=height, girth=outline.length)
    assert {b.group for b in blocks} == {f"wall.{run.name}" for run in specs}
    if bond == "english" or (bond == "running" and leaves == 1):
        assert straight_joints(asm, faces) == []


@settings(max_examples=25, deadline=None)
@given(
    length=st.floats(2, 6), thickness=st.floats(0.4, 0.9), height=st.floats(1, 3), left=st.floats(0, 0.1),
    right=st.floats(0, 0.1), bond=st.sampled_from(BONDS), over=st.floats(0, 0.1), brick=st.floats(0.3, 0.7),
)  # fmt: skip
def test_any_battered_wall_with_a_coping_is_sound(length, thickness, height, left, right, bond, over, brick):
    assume((left + right) * height < 0.5 * thickness)
    blocks = wall(
        [(1, 2), (1 + length * 0.6, 2 + length * 0.8)], thickness=thickness, height=height, bond=bond,
        brick=(brick, 0.25), batter=(left, right), coping=Coping(overhang=over),
    )  # fmt: skip
    asm = grounded(blocks)
    assert convex_blocks(asm).all()
    assert len(overlaps(asm, gap=1e-9)[0]) == 0
    courses = max(round(height / 0.25), 1)
    body = height * (1 - 1 / courses)
    top = thickness - (left + right) * body
    expected = length * (body * (thickness + top) / 2 + (top + 2 * over) * height / courses)
    assert asm.volume[1:].sum() == pytest.approx(expected, rel=1e-9)
    assert set(asm.groups) == {"ground", "wall.a", "wall.a.coping"} if courses > 1 else True


@settings(max_examples=25, deadline=None)
@given(
    length=st.floats(2, 6), height=st.floats(0.6, 2), pitch=st.floats(25, 60), bond=st.sampled_from(BONDS),
    brick=st.floats(0.3, 0.7), course=st.floats(0.2, 0.4), coping=st.booleans(),
)  # fmt: skip
def test_any_gable_is_sound(length, height, pitch, bond, brick, course, coping):
    rise, t, deep = length / 2 * np.tan(np.deg2rad(pitch)), 0.5, 0.15
    cap = Coping(overhang=0.05, height=deep) if coping else None
    blocks = wall(
        [(0, 0), (0, length)], height=height, thickness=t, gable=rise, bond=bond, brick=(brick, course), coping=cap
    )
    asm = grounded(blocks)
    sound(asm, convex=True)
    bare = asm.volume[asm.in_group("wall.a")].sum()
    stones = 0.0
    if coping:
        # Two raked bands as deep as the stones, upright at foot and ridge.
        stones = asm.volume[asm.in_group("wall.a.coping")].sum()
        assert stones == pytest.approx(length * deep / np.cos(np.deg2rad(pitch)) * (t + 0.1))
    assert bare - stones == pytest.approx(t * (length * height + length * rise / 2), rel=1e-9)


def test_raked_stones_are_longer_than_the_joint_at_the_foot_leans():
    # A slope of 2 in 1: an upright joint through stones 0.4 m deep leans 0.4 x 2 = 0.8 m along the slope.
    run = {"gable": 4.0, "coping": Coping(height=0.4, length=0.75)}
    with pytest.raises(InputError, match=r"coping.length is 0.75; .* must be at least 0.84 m long"):
        wall(**run)
    for length in (None, 0.85):
        asm = grounded(wall(**run | {"coping": Coping(height=0.4, length=length)}))
        sound(asm, convex=True)
        # Two raked bands of 4 m of slope each have the height 0.4 x sqrt(5) over a plan of 2 m.
        band = asm.volume[asm.in_group("wall.a.coping")].sum()
        assert band == pytest.approx(4 * 0.4 * np.sqrt(5) * 0.6)
    # With bricks of 0.3 m stones of two bricks would be too short.
    sound(grounded(wall(brick=(0.3, 0.25), gable=4.0, coping=Coping(height=0.4))), convex=True)


def test_joined_runs_share_their_beds():
    # Heights 1.1 and 2.0 of courses near 0.25: 4 of 0.275 and 4 of 0.225.
    blocks = walls(
        [
            Run(name="low", path=[(0, 0), (3, 0)], thickness=0.4, height=1.1),
            Run(name="high", path=[(0, 0), (0, 3)], thickness=0.4, height=2.0),
        ],
        brick=(0.5, 0.25),
    )
    beds = {name: sorted({round(float(z), 9) for b in blocks if b.group == name for z in b.vertices[:, 2]}) for name in
            ("wall.low", "wall.high")}  # fmt: skip
    assert beds["wall.low"] == pytest.approx([0, 0.275, 0.55, 0.825, 1.1])
    assert beds["wall.high"] == pytest.approx([0, 0.275, 0.55, 0.825, 1.1, 1.325, 1.55, 1.775, 2.0])


@pytest.mark.parametrize("bond", BONDS)
def test_a_wall_pushed_out_of_plane_overturns_at_t_over_h(bond):
    # lambda = t / H = 0.25 for a free-standing wall of courses as wide as the wall; a leaf by itself half of it.
    # Headers tie the leaves into one body, but for the lowest stones; leaves that nothing ties only rub.
    asm = grounded(wall([(0, 0), (2, 0)], thickness=0.4, height=1.6, bond=bond, leaves=2, brick=(0.5, 0.2)))
    answer = limit_load(asm, (0, 1, 0), friction=0.7)
    if bond in ("english", "flemish"):
        assert 0.9 * 0.25 < answer.lower <= answer.upper <= 0.25 * (1 + 1e-6)
    else:
        assert 0.125 < answer.lower <= answer.upper < 0.7 * 0.25


@pytest.mark.parametrize(("friction", "limit"), [(0.7, 0.25), (0.1, 0.1)])
def test_limit_of_a_wall_of_one_leaf(friction, limit):
    # lambda = t / H, capped by friction.
    asm = grounded(wall([(0, 0), (2, 0)], thickness=0.4, height=1.6, brick=(0.5, 0.2)))
    answer = limit_load(asm, (0, 1, 0), friction=friction)
    assert answer.lower == pytest.approx(limit, rel=1e-6)
    assert answer.upper == pytest.approx(limit, rel=1e-6)


def test_walls_stand():
    rooms = [Run(name="a", path=SQUARE[:-1], closed=True, thickness=0.4, height=1.2,
                 openings=[Opening(width=0.8, height=0.6, segment=1)])]  # fmt: skip
    assert assess(grounded(walls(rooms, brick=(0.6, 0.2)))).outcome.word == "stable"


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"thickness": 0.0}, 'wall "a": thickness is 0.0'),
        ({"bond": "monk"}, "wall \"a\": bond is 'monk'; it must be one of: running, stack, english, flemish"),
        ({"align": "middle"}, "align is 'middle'"),
        ({"path": [(0, 0)]}, "path is"),
        ({"path": [(0, 0), (0, 0), (1, 0)]}, "twice in a row"),
        ({"path": [(0, 0), (3, 0), (6, 0.5)]}, r'"a": path turns by less than 30 degrees at \[3.0, 0.0\]; turn more'),
        ({"path": [(0, 0), (3, 0), (6, 0.5)], "align": "right"}, "path turns by less than 30 degrees"),
        ({"path": [(0, 0), (3, 0), (6, 0.5)], "align": "left"}, "path turns by less than 30 degrees"),
        ({"path": [(0, 0), (3, 0), (3, 0.2)]}, "shorter than the thickness"),
        ({"leaves": 0}, "leaves is 0"),
        ({"half": 0.05}, "half is 0.05"),
        ({"batter": (0.5, 0.5)}, "leaves no thickness at the top"),
        ({"through": Through()}, "through-stones need several leaves"),
        ({"gable": 1.0, "path": CORNER}, "a gable needs a straight path"),
        ({"openings": [Opening(width=1, height=1, segment=3)]}, "segment of an opening is 3; its path has 1"),
        ({"gable": -0.5}, 'wall "a": gable is -0.5; it must be the height of the ridge above the wall'),
        ({"gable": np.inf}, "gable is inf; it must be the height of the ridge"),
        ({"coping": Coping(overhang=-0.1)}, r"coping\.overhang is -0\.1; it must be at least 0"),
        ({"gable": 1.0, "coping": Coping(height=-0.1)}, "height and length of its coping must be above 0"),
        ({"gable": 1.0, "coping": Coping(length=-0.1)}, "height and length of its coping must be above 0"),
        ({"brick": (0.5,)}, r"brick is \(0\.5,\); it must be its nominal length and height"),
        ({"brick": (0.5, 0.0)}, r"brick\[1\] is 0\.0"),
    ],
)
def test_bad_walls_are_named(change, match):
    with pytest.raises(InputError, match=match):
        wall(**{"path": [(0, 0), (4, 0)], **change})


@pytest.mark.parametrize(
    ("paths", "match"),
    [
        ([[(0, 0), (4, 0)], [(2, 0.25), (4, 2.25)]], '"r0" and "r1" overlap by their sides'),
        ([[(0, 0), (4, 0)], [(1, 0.1), (6, 0.1)]], "meet at less than 30 degrees, or overlap lengthwise"),
        ([[(0, 0), (4, 0)], [(2, 0), (2, 3)], [(2, 0), (4, 3)]], "at one place; let one run pass"),
    ],
)
def test_runs_that_cannot_be_joined_are_named(paths, match):
    with pytest.raises(InputError, match=match):
        walls([Run(name=f"r{k}", path=p, thickness=0.4, height=1) for k, p in enumerate(paths)])


@pytest.mark.parametrize(
    ("path", "closed", "point"),
    [
        ([(0, 0), (2, 0), (4, 0)], False, r"\[2.0, 0.0\]"),
        ([(0, 0), (3, 4.5), (4, 6), (0, 6)], False, r"\[3.0, 4.5\]"),
        ([(2, 0), (4, 0), (4, 3), (0, 3), (0, 0)], True, r"\[2.0, 0.0\]"),
    ],
)
def test_a_path_has_no_point_at_which_it_goes_straight_on(path, closed, point):
    with pytest.raises(InputError, match=f'wall "a": path goes straight on at {point}; leave out the point'):
        wall(path, closed=closed)


def test_heights_too_near_each_other_are_named():
    runs = [Run(name=f"r{k}", path=[(0, 5 * k), (3, 5 * k)], thickness=0.4, height=1 + k / 100) for k in range(2)]
    with pytest.raises(InputError, match=r"heights 1 and 1\.01 m are nearer"):
        walls(runs)


@pytest.mark.parametrize("pair", [(0.8 * 3, 2.4), (1.1 + 2.2, 3.3)])
def test_heights_equal_but_for_rounding_share_a_bed(pair):
    assert pair[0] != pair[1]
    runs = [Run(name=f"r{k}", path=[(0, 5 * k), (3, 5 * k)], thickness=0.4, height=h) for k, h in enumerate(pair)]
    tops = [max(block.vertices[:, 2].max() for block in walls(runs) if block.group == f"wall.r{k}") for k in range(2)]
    assert tops[0] == tops[1] == pytest.approx(pair[1], rel=1e-12)


def test_names_of_runs_are_unique():
    runs = [Run(name="a", path=[(0, 5 * k), (3, 5 * k)], thickness=0.4, height=1) for k in range(2)]
    with pytest.raises(InputError, match='two runs are named "a"'):
        walls(runs)


@pytest.mark.parametrize("sliver", [0.0, 0.46, np.nan])
def test_a_sliver_is_a_fraction_of_a_brick(sliver):
    run = Run(name="a", path=[(0, 0), (2, 0)], thickness=0.5, height=0.5)
    with pytest.raises(
        InputError, match=f"sliver is {sliver}; it must be a fraction of a brick above 0 and up to 0.45"
    ):
        walls(run, brick=(0.5, 0.25), sliver=sliver)
    assert len(walls(run, brick=(0.5, 0.25), sliver=0.45)) > 0


@pytest.mark.parametrize("name", ["", 7])
def test_a_run_needs_a_word_for_its_name(name):
    with pytest.raises(InputError, match=f"name of a run is {name!r}; it must be a word"):
        walls(Run(name=name, path=[(0, 0), (2, 0)], thickness=0.5, height=0.5))


def test_walls_need_a_run_and_absent_runs_make_no_block():
    with pytest.raises(InputError, match="runs is empty; walls need at least one run"):
        walls([])
    gone = Run(name="a", path=[(0, 0)], thickness=-1.0, height=0.5, present=False)  # what is absent is not checked
    assert walls([gone]) == walls(gone) == []
    kept = Run(name="b", path=[(0, 0), (2, 0)], thickness=0.5, height=0.5)
    assert {block.group for block in walls([gone, kept])} == {"wall.b"}


def test_an_opening_that_is_absent_is_neither_checked_nor_cut():
    absent = Opening(width=-1.0, height=0.5, present=False)
    assert [block.name for block in wall(openings=[absent])] == [block.name for block in wall()]
    with pytest.raises(InputError, match="width is -1"):
        wall(openings=[Opening(width=-1.0, height=0.5)])


def test_a_wall_that_meets_a_gable_is_no_higher_than_its_eaves():
    gable = Run(name="front", path=[(0, 0), (4, 0)], thickness=0.5, height=1.0, gable=1.0)
    for height, refused in ((1.0, False), (1.5, True)):
        side = Run(name="side", path=[(0, 0), (0, 3)], thickness=0.5, height=height)
        if not refused:
            assert {block.group for block in walls([gable, side])} == {"wall.front", "wall.side"}
            continue
        with pytest.raises(
            InputError, match='wall "side" is higher than the eaves of the gable "front", which it meets'
        ):
            walls([gable, side])


def test_runs_of_a_scene_are_named_by_their_key():
    run = Run(name="south", path=[(0, 0), (2, 0)], thickness=0.5, height=0.5)
    assert {block.group for block in walls_by_name(runs={"south": run})} == {"wall.south"}
    with pytest.raises(
        InputError, match=r'runs\.north\.name: it is "south"; the name of a run is the key of its table'
    ):
        walls_by_name(runs={"north": run})


def test_a_wall_needs_length_between_those_that_it_meets():
    def between(length):
        middle = Run(name="c", path=[(0, 0), (length, 0)], thickness=0.25, height=1)
        ends = [Run(name=n, path=[(x, -2), (x, 2)], thickness=0.5, height=1) for n, x in (("a", 0), ("b", length))]
        return walls([middle, *ends], brick=(0.5, 0.25))

    assert {block.group for block in between(1.0)} == {"wall.a", "wall.b", "wall.c"}
    with pytest.raises(InputError, match='wall "c" has no length between the walls that it meets'):
        between(0.5)


@pytest.mark.parametrize("sill", [1.5, 9.0])
def test_an_opening_at_the_top_of_its_wall_or_above_is_refused(sill):
    above = Opening(width=0.8, height=0.25, sill=sill)
    with pytest.raises(InputError, match=r'wall "a": openings\[0\]: sill and height reach beyond the wall of 1\.5 m'):
        wall(openings=[above])


def test_openings_whose_jambs_touch_are_refused_where_their_lintels_do():
    # Between jambs that touch no brick is left and none is asked for; the lintels above would overlap.
    openings = [Opening(width=1.0, height=0.75, at=[1.0, 2.0])]
    with pytest.raises(InputError, match=r"nothing is left between wall .* at a height of 0\.75 m"):
        wall(openings=openings)
    near = [Opening(width=1.0, height=0.75, at=[1.0, 2.1])]
    with pytest.raises(InputError, match=r"0\.1 m is left between wall .* at a height of 0 m"):
        wall(openings=near)
