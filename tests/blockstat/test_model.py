import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from blockstat import InputError, build, find_interfaces, load_scene
from blockstat.contact.overlap.penetration import overlaps
from blockstat.model import Buttress, Opening, Run, walls
from blockstat.model.walling.pattern import plain_row
from blockstat.spec import lowered, scene_from


@pytest.fixture(scope="module")
def chapel(root):
    return build(load_scene(root / "examples" / "chapel.toml"))


def test_rows_are_whole_bricks_and_one_half_brick():
    # LongitudeRow = NumberOfPoints x SizeOfBrick + HalfBrick (the procedural-masonry paper, Eq. 4).
    for course, ends in enumerate(plain_row(5.4, 0.9)):
        lengths = np.diff(ends).tolist()
        half = lengths.pop(-1 if course % 2 == 0 else 0)
        brick = 5.4 / (len(lengths) + 0.5)
        assert len(lengths) in (5, 6)
        assert half == pytest.approx(brick / 2)
        assert lengths == pytest.approx([brick] * len(lengths))


def test_no_head_joint_stands_over_another():
    even, odd = ({round(x, 9) for x in ends[1:-1].tolist()} for ends in plain_row(5.4, 0.9))
    assert even
    assert odd
    assert not even & odd


@settings(deadline=None)
@given(st.floats(0.5, 4.5), st.floats(0.2, 1.5))
def test_bricks_are_cut_at_an_opening_without_slivers(centre, width):
    row, nominal, course = 5.0, 0.6, 0.3
    brick = np.diff(plain_row(row, nominal)[0])[0]
    start, end = centre - width / 2, centre + width / 2
    assume(start > brick / 2 and end < row - brick / 2)
    opening = Opening(width=width, height=2 * course, at=[centre])
    wall = Run(name="w", path=[(0, 0), (row, 0)], thickness=0.4, height=4 * course, closers=True, openings=[opening])
    blocks = walls(wall, brick=(nominal, course))
    for level in range(4):
        extents = [(b.vertices[:, 0].min(), b.vertices[:, 0].max(), b.group) for b in blocks if at(b, level * course)]
        bricks = sorted(extents)
        void = width if level < 2 else 0.0
        assert sum(b - a for a, b, _ in bricks) == pytest.approx(row - void)
        lintel = [(a, b) for a, b, group in bricks if group == "wall.w.lintel"]
        assert lintel == ([] if level != 2 else [pytest.approx((start - brick / 2, end + brick / 2))])
        assert all(later[0] >= earlier[1] - 1e-12 for earlier, later in zip(bricks, bricks[1:], strict=False))
        inner = [b - a for a, b, _ in bricks if a > 1e-9 and b < row - 1e-9 and (a, b) not in lintel]
        assert min(inner, default=brick) >= brick / 3 - 1e-9


def at(block, height: float) -> bool:
    """Whether a block stands on the bed at a height."""
    return abs(block.vertices[:, 2].min() - height) < 1e-9


def test_a_stretch_too_narrow_for_a_brick_is_refused_or_a_closer():
    window = Opening(width=1.0, height=0.6, at=[0.6])
    wall = {"name": "w", "path": [(0, 0), (5, 0)], "thickness": 0.4, "height": 1.2, "openings": [window]}
    with pytest.raises(InputError, match=r"0\.1 m is left between its end and .*openings\[0\]"):
        walls(Run(**wall), brick=(0.6, 0.3))
    window = Opening(width=0.4, height=0.6, at=[0.6], bearing=0.3)
    blocks = walls(Run(**wall | {"openings": [window], "closers": True}), brick=(0.6, 0.3))
    over = [b for b in blocks if at(b, 0.6)]
    assert min(np.ptp(b.vertices[:, 0]) for b in over) == pytest.approx(0.1)


def test_own_courses_of_a_buttress_are_single_stones_of_its_own_height():
    wall = Run(name="w", path=[(0, 0), (5, 0)], thickness=0.4, height=1.2)
    own = {"wall": "w", "width": 0.5, "projection": 0.9, "height": 1.0, "side": "left", "courses": 4}
    blocks = [b for b in walls(wall, buttresses=[Buttress(**own, bonded=False)]) if b.group == "buttress.w.1"]
    assert len(blocks) == 4
    for k, block in enumerate(blocks):
        np.testing.assert_allclose(block.vertices.min(axis=0), (2.25, 0.2, k / 4), atol=1e-12)
        np.testing.assert_allclose(block.vertices.max(axis=0), (2.75, 1.1, (k + 1) / 4), atol=1e-12)
    with pytest.raises(InputError, match="bonded = false"):
        walls(wall, buttresses=[Buttress(**own)])
    with pytest.raises(InputError, match="upright face"):
        walls(
            Run(name="w", path=[(0, 0), (5, 0)], thickness=0.4, height=1.2, batter=(0.1, 0.0)),
            buttresses=[Buttress(**own, bonded=False)],
        )


def test_chapel_groups(chapel):
    groups = set(chapel.groups)
    assert {
        "ground",
        "vault",
        "wall.south",
        "wall.north",
        "wall.west",
        "wall.east",
        "buttress.south.1",
    } <= groups
    assert chapel.names[int(np.flatnonzero(chapel.support)[0])] == "ground"
    assert len(chapel.in_group("wall")) + len(chapel.in_group("vault")) + len(chapel.in_group("buttress")) + 1 == (
        chapel.n_blocks
    )


def test_the_short_form_can_be_written_as_a_composition(root, chapel):
    plan = lowered(load_scene(root / "examples" / "chapel.toml"))
    whole = build(scene_from({"name": "chapel", "elements": msgspec.to_builtins(plan.elements)}))
    assert whole.names == chapel.names
    assert whole.groups == chapel.groups
    np.testing.assert_array_equal(whole.vertices, chapel.vertices)


def test_chapel_volumes_by_hand(chapel):
    thickness, length, span, height = 0.8, 5.4, 3.6, 2.4
    window, door = 0.6 * 0.8, 1.1 * 1.6
    assert chapel.volume[chapel.in_group("wall.south")].sum() == pytest.approx(
        thickness * (length * height - 2 * window)
    )
    assert chapel.volume[chapel.in_group("wall.west")].sum() == pytest.approx(thickness * (span * height - door))
    assert chapel.volume[chapel.in_group("wall.east")].sum() == pytest.approx(thickness * span * height)
    assert chapel.volume[chapel.in_group("buttress.south.1")].sum() == pytest.approx(0.6 * 0.6 * 1.6)
    # Straight-sided voussoirs: eleven wedges of pi/11 between two polygons.
    inner, outer, n = 1.8, 1.8 + 0.35, 11
    section = n * 0.5 * np.sin(np.pi / n) * (outer**2 - inner**2)
    assert chapel.volume[chapel.in_group("vault")].sum() == pytest.approx(section * length)


def test_buttresses_are_spaced_by_the_paper():
    # Eqs. 3-5: DistanceAmongButtresses = LongitudeRow / (number + 1), centred between the wall's ends.
    scene = {
        "name": "row", "length": 9.0, "span": 3.0, "wall": {"thickness": 0.5, "height": 1.2},
        "buttresses": {"south": {"number": 2, "thickness": 0.5, "width": 0.6, "height": 0.9}},
    }  # fmt: skip
    assembly = build(scene_from(scene))
    for k in (1, 2):
        blocks = assembly.in_group(f"buttress.south.{k}")
        np.testing.assert_allclose(assembly.centroid[blocks, 0], 3.0 * k)
        np.testing.assert_allclose(assembly.centroid[blocks, 1], -0.75)


def test_every_joint_of_the_chapel_closes_and_nothing_overlaps(chapel):
    faces = find_interfaces(chapel)
    assert faces.gap.max() < 1e-9
    assert faces.dropped == ()
    assert np.unique(faces.pair).tolist() == list(range(chapel.n_blocks))
    pairs, _ = overlaps(chapel, gap=1e-9)
    assert len(pairs) == 0


def test_vault_beds_meet_over_their_whole_area(chapel):
    # Ten radial beds of thickness x length, and two springings.
    faces = find_interfaces(chapel)
    vault = np.zeros(chapel.n_blocks, dtype=bool)
    vault[chapel.in_group("vault")] = True
    course = np.array([int(n.split(".")[1]) if n.startswith("vault") else -1 for n in chapel.names])
    both = vault[faces.pair].all(axis=1)
    beds = both & (course[faces.pair[:, 0]] != course[faces.pair[:, 1]])
    assert faces.area[beds].sum() == pytest.approx(10 * 0.35 * 5.4)
    springing = vault[faces.pair].sum(axis=1) == 1
    assert faces.area[springing].sum() == pytest.approx(2 * 0.35 * 5.4)


@settings(max_examples=20, deadline=None)
@given(
    length=st.floats(3.0, 9.0), span=st.floats(1.5, 5.0), brick=st.floats(0.3, 1.2), course=st.floats(0.15, 0.5),
    thickness=st.floats(0.2, 1.0), height=st.floats(0.8, 3.0), window=st.floats(0.3, 0.8), number=st.integers(0, 2),
    voussoirs=st.integers(3, 15),
)  # fmt: skip
def test_any_building_that_builds_is_sound_geometry(
    length, span, brick, course, thickness, height, window, number, voussoirs
):
    scene = {
        "name": "any", "length": length, "span": span, "brick": {"length": brick, "height": course},
        "wall": {"thickness": thickness, "height": height},
        "windows": {"north": {"width": window, "height": 0.4, "sill": 0.3, "number": number}},
        "buttresses": {"south": {"number": number, "thickness": 0.4, "width": 0.4, "height": height / 2}},
        "vault": {"thickness": 0.2, "voussoirs": voussoirs},
    }  # fmt: skip
    try:
        assembly = build(scene_from(scene))
    except InputError:
        return
    assert (assembly.volume > 0).all()
    assert len(overlaps(assembly, gap=1e-9)[0]) == 0
    assert len(np.unique(find_interfaces(assembly).pair)) == assembly.n_blocks
