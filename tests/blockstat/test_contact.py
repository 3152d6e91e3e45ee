from dataclasses import replace

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, Outcome, assess, find_interfaces, limit_load
from blockstat.contact.faces import surface_heights
from blockstat.model import assemble, freeform, height_field
from evidence.scenes.small import arch, assembly, box, prism, running_bond, slice_, stack


def touching(asm, **options):
    faces = find_interfaces(asm, **options)
    return {tuple(pair): area for pair, area in zip(faces.pair.tolist(), faces.area, strict=True)}


def test_stack_has_one_interface_a_joint_with_four_corners():
    faces = find_interfaces(stack(3))
    assert faces.pair.tolist() == [[0, 1], [1, 2], [2, 3]]
    np.testing.assert_allclose(faces.area, 1.0)
    assert faces.n_points == 12
    np.testing.assert_allclose(faces.frame[:, 0], [[0, 0, 1]] * 3, atol=1e-15)
    for frame in faces.frame:
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1.0)


def test_running_bond_counts_by_hand():
    # 3 bricks a course, 4 courses: beds of 3 + 3 x 6 (half and half, two at the ends), heads 2 + 3 + 2 + 3.
    asm = running_bond(4, 3)
    faces = find_interfaces(asm)
    vertical = np.abs(faces.frame[:, 0, 2]) > 0.5
    assert vertical.sum() == 3 + 3 * 6
    assert (~vertical).sum() == 2 + 3 + 2 + 3
    assert faces.area[vertical].sum() == pytest.approx(4 * 1.2 * 0.2)
    assert faces.area[~vertical].sum() == pytest.approx(10 * 0.175 * 0.2)
    assert faces.n_points == 4 * faces.n_interfaces


def test_blocks_that_meet_only_at_an_edge_do_not_touch():
    asm = assembly([box((0, 0, 0), (1, 1, 1)), box((1, 0, 1), (2, 1, 2))])
    assert find_interfaces(asm).n_interfaces == 0


def test_overhanging_patch_is_clipped():
    asm = assembly([box((0, 0, 0), (2, 2, 1)), box((1.5, -0.5, 1), (3, 0.75, 2))])
    faces = find_interfaces(asm)
    assert faces.area.tolist() == pytest.approx([0.5 * 0.75])
    assert sorted(map(tuple, faces.point.round(9).tolist())) == [
        (1.5, 0, 1),
        (1.5, 0.75, 1),
        (2, 0, 1),
        (2, 0.75, 1),
    ]


def test_a_long_slab_keeps_all_its_bricks():
    bricks = [box((0.3 * i, 0, 0), (0.3 * i + 0.2, 0.1, 0.1)) for i in range(40)]
    faces = find_interfaces(assembly([box((-1, -1, -0.2), (14, 2, 0)), *bricks]))
    assert faces.n_interfaces == 40


def test_thin_tiles_have_one_interface():
    asm = assembly([box((0, 0, 0), (1, 1, 1e-3)), box((0, 0, 1e-3), (1, 1, 2e-3))])
    assert find_interfaces(asm).n_interfaces == 1


def test_triangulated_faces_make_one_interface():
    faces = []
    for a, b, c, d in box((0, 0, 0), (1, 1, 1)).faces:
        faces += [[a, b, c], [a, c, d]]
    blocks = [Block(box((0, 0, k), (1, 1, k + 1)).vertices, faces) for k in range(2)]
    interfaces = find_interfaces(assembly(blocks))
    assert interfaces.n_interfaces == 1
    assert interfaces.n_points == 4
    assert interfaces.area[0] == pytest.approx(1.0)


def horseshoe(z):
    plan = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    n = len(plan)
    sides = [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    points = [(x, y, z) for x, y in plan] + [(x, y, z + 1) for x, y in plan]
    return Block(points, [list(range(n))[::-1], list(range(n, 2 * n)), *sides])


def test_contact_in_two_pieces_is_one_interface_on_its_hull():
    # A beam across the two arms of a horseshoe touches it twice, in one plane.
    asm = assembly([horseshoe(0), box((-0.5, 1.2, 1), (3.5, 1.8, 2))])
    faces = find_interfaces(asm)
    assert faces.n_interfaces == 1
    assert faces.area[0] == pytest.approx(2 * 1.0 * 0.6)
    assert sorted(map(tuple, faces.point.round(9).tolist())) == [
        (0, 1.2, 1),
        (0, 1.8, 1),
        (3, 1.2, 1),
        (3, 1.8, 1),
    ]


def test_a_beam_over_the_notch_of_a_concave_face_does_not_touch_it():
    asm = assembly([horseshoe(0), box((1.2, 1.2, 1), (1.8, 3, 2))])
    assert find_interfaces(asm).n_interfaces == 0


def test_gap_within_tolerance_is_a_joint_and_beyond_it_is_reported():
    def two(gap):
        return assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1 + gap), (1, 1, 2 + gap))])

    assert find_interfaces(two(5e-3)).gap[0] == pytest.approx(5e-3)
    assert find_interfaces(two(-5e-3)).n_interfaces == 1
    missed = find_interfaces(two(2e-2))
    assert missed.n_interfaces == 0
    assert [(d.a, d.b, d.reason) for d in missed.dropped] == [(0, 1, "gap")]
    assert missed.dropped[0].value == pytest.approx(2e-2)
    assert find_interfaces(two(2e-2), gap=5e-2).n_interfaces == 1
    assert find_interfaces(two(2e-1)).dropped == ()


@pytest.mark.parametrize(
    ("slate", "near"), [(box((0, 0, 1), (1, 1, 1.03)), []), (box((1, 0, 0), (1.03, 1, 2.03)), [(0, 2)])]
)
def test_a_gap_that_a_third_block_fills_is_no_near_miss(slate, near):
    # Two cubes 3 cm apart, and a slate that lies between them, or stands beside them and touches both.
    faces = find_interfaces(assembly([box((0, 0, 0), (1, 1, 1)), slate, box((0, 0, 1.03), (1, 1, 2.03))]))
    assert faces.n_interfaces == 2
    assert [(d.a, d.b) for d in faces.dropped] == near


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_interfaces_do_not_depend_on_units(scale):
    asm = arch(12, 0.2)
    scaled = asm.with_(vertices=asm.vertices * scale)
    a, b = find_interfaces(asm), find_interfaces(scaled)
    assert a.pair.tolist() == b.pair.tolist()
    np.testing.assert_allclose(b.area, a.area * scale**2, rtol=1e-9)


def test_interfaces_follow_a_permutation_of_the_blocks():
    asm = running_bond(5, 4)
    order = np.random.default_rng(1).permutation(asm.n_blocks)
    blocks = [Block(asm.block_vertices(i), asm.faces_of(i), asm.names[i]) for i in order]
    shuffled = assembly(blocks, supports=["ground"])

    def named(a):
        return {frozenset((a.names[i], a.names[j])): round(area, 12) for (i, j), area in touching(a).items()}

    assert named(asm) == named(shuffled)


def test_supports_have_no_interface_between_them():
    asm = assembly(
        [box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1)), box((0.5, 0, 1), (1.5, 1, 2))], supports=[0, 1]
    )
    assert find_interfaces(asm).pair.tolist() == [[0, 2], [1, 2]]


def test_points_of_a_wedge_shaped_joint_lie_between_its_faces():
    # The lower face is long, so its centre is far from the patch; two degrees between them.
    rise = 0.3 * np.tan(np.deg2rad(2))
    lower = slice_([(0, -1), (4, -1), (4, 0), (0, 0)], 1.0)
    upper = slice_([(0, 0), (0.3, rise), (0.3, 1), (0, 1)], 1.0)
    faces = find_interfaces(assembly([lower, upper]), gap=0.03)
    assert faces.n_points == 4
    assert faces.gap == pytest.approx([rise], rel=1e-3)
    np.testing.assert_allclose(faces.point[:, 2], rise / 2 * faces.point[:, 0] / 0.3, atol=1e-3 * rise)


def test_blocks_that_meet_at_a_corner_have_no_joint():
    # Stones of a twisted vault in stack bond: those across a corner share one edge, and patches of rounding there.
    points = height_field(
        lambda x, y: 3 + 0.09375 * y**2 + 0.03125 * x * y, x=(-2.0, 2.0), y=(-1.5, 1.5), courses=5, voussoirs=2
    )
    faces = find_interfaces(assemble(freeform(points, thickness=0.109375, springers=0.2, bond="stack")))
    assert faces.area.min() > 1e-3
    assert np.diff(faces.start).min() >= 3


@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-6])
def test_no_joint_reaches_through_a_plate(thickness):
    faces = find_interfaces(stack(20, 1.0, thickness))
    assert faces.pair.tolist() == [[k, k + 1] for k in range(20)]


@pytest.mark.parametrize(("shared", "joints"), [(0.5, 1), (1e-3, 0)])
def test_a_joint_is_wider_than_it_is_open(shared, joints):
    # Two cubes side by side, 5 mm apart, within the tolerance, that face each other over so much of their height.
    blocks = [box((0, 0, 0), (1, 1, 1)), box((1.005, 0, 1 - shared), (2.005, 1, 2 - shared))]
    assert find_interfaces(assembly(blocks)).n_interfaces == joints


@pytest.mark.parametrize("higher", [0, 1])
def test_the_gap_of_a_joint_is_that_of_its_most_open_part(higher):
    # An underside in two halves, one of them 5 mm above the ground.
    z = [0.0, 0.0]
    z[higher] = 5e-3
    stone = prism([(0, z[0]), (0.5, z[0]), (0.5, z[1]), (1, z[1]), (1, 1), (0, 1)], 1.0)
    faces = find_interfaces(assembly([box((-1, -1, -1), (2, 2, 0)), stone]))
    assert faces.n_interfaces == 1
    assert faces.gap == pytest.approx([5e-3], rel=1e-9)


def test_a_corner_on_the_line_of_its_neighbours_is_no_contact_point():
    # Strength is shared by the points in equal parts: one more in the middle of an edge would move its centre.
    outline = [(0, 0), (0.3, 0), (1, 0), (1, 0.6), (1, 1), (0, 1)]
    faces = find_interfaces(assembly([prism(outline, 1.0), box((-1, 1, -1), (2, 2, 2))]))
    assert sorted(map(tuple, faces.point.round(9).tolist())) == [(0, 1, 0), (0, 1, 1), (1, 1, 0), (1, 1, 1)]


@pytest.mark.parametrize(("tolerances", "joints"), [(0.9, 1), (1.1, 0), (2.0, 0)])
def test_a_gap_is_a_joint_up_to_its_tolerance_and_no_further(tolerances, joints):
    apart = tolerances * 1e-2
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1 + apart), (1, 1, 2 + apart))], supports=[0])
    found = find_interfaces(asm, gap=1e-2)
    assert found.n_interfaces == joints
    assert [drop.reason for drop in found.dropped] == ["gap"] * (1 - joints)


@pytest.mark.parametrize("width", [1e-2, 1e-3, 1e-5])
def test_a_joint_may_be_as_narrow_as_a_hundred_thousandth_of_its_blocks(width):
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((1 - width, 0, 1), (2 - width, 1, 2))], supports=[0])
    found = find_interfaces(asm)
    assert found.area == pytest.approx([width])


def saddle(rise, at=(0, 0), z=1.0, thick=1.0):
    """A metre square whose top goes up and down by turns at its corners, on a flat bottom, and one that fits on it."""
    below, above = (np.array(box((*at, low), (at[0] + 1, at[1] + 1, low + thick)).vertices) for low in (z - thick, z))
    for corners in (below, above):
        level = np.isclose(corners[:, 2], z)
        corners[level, 2] += rise * np.where(np.isclose(corners[level, 0] - at[0], corners[level, 1] - at[1]), 1, -1)
    faces = box((0, 0, 0), (1, 1, 1)).faces
    return Block(below, faces), Block(above, faces)


@pytest.mark.parametrize("gap", [0.01, "1 mm", "5 mm"])
def test_a_block_over_the_plane_of_a_warped_face_stands_on_nothing(gap):
    # The top goes from 50 mm up to 50 mm down round its corners, and is a fan about its middle. Under the block, whose
    # underside is in the mean plane, it is 35 to 45 mm down. No joint is so open.
    support, _ = saddle(0.05)
    asm = assembly([support, box((0.85, 0.05, 1.0), (0.95, 0.15, 1.1))], supports=[0])
    places = np.array([(0.85, 0.05, 1.0), (0.95, 0.05, 1.0), (0.95, 0.15, 1.0), (0.5, 0.5, 1.0)])
    top = np.flatnonzero((asm.face_block == 0) & (asm.planes.normal[:, 2] > 0.9))
    heights = surface_heights(asm, top, np.array([[0.0, 0.0, 1.0]]), places[None])[0]
    np.testing.assert_allclose(heights, [-0.035, -0.045, -0.035, 0.0], atol=1e-12)
    assert find_interfaces(asm, gap=gap).n_interfaces == 0
    assert assess(asm, gap=gap).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("gap", [0.01, "1 mm", "50 mm"])
def test_two_blocks_that_share_a_warped_face_have_no_gap(gap):
    faces = find_interfaces(assembly(saddle(0.05), supports=[0]), gap=gap)
    assert faces.area == pytest.approx([1.0])
    assert faces.gap == pytest.approx([0.0], abs=1e-12)


def test_the_gap_over_a_warped_face_is_that_at_its_lowest_corner():
    support, _ = saddle(2e-3)
    faces = find_interfaces(assembly([support, box((0, 0, 1), (1, 1, 2))], supports=[0]))
    assert faces.gap == pytest.approx([2e-3])
    # A diamond has its corners where the top is level, and the middle of its sides half as far from it as the corners.
    diamond = np.array([(0.5, 0, 1), (1, 0.5, 1), (0.5, 1, 1), (0, 0.5, 1)])
    stone = Block(np.concatenate([diamond, diamond + [0, 0, 1]]), box((0, 0, 0), (1, 1, 1)).faces)
    faces = find_interfaces(assembly([support, stone], supports=[0]))
    assert faces.area == pytest.approx([0.5])
    assert faces.gap == pytest.approx([1e-3])


def test_a_plane_beside_the_box_of_its_warped_block_is_still_found():
    # The corner of the top is 4.5 mm below its plane, and the stone 19 mm above that: more than the gap from the box.
    slope, warp, open_by = 0.02, 4.5e-3, 19e-3
    lower = np.array(box((0, 0, 0), (1, 1, 0.5)).vertices)
    upper = np.array(box((0.97, 0.97, 0.5), (2, 2, 1.5)).vertices)
    lean = slope * lower[:, :2].sum(axis=1) + warp * np.where(lower[:, 0] == lower[:, 1], -1, 1)
    lower[:, 2] += np.where(lower[:, 2] > 0, lean, 0.0)
    upper[:, 2] += open_by + slope * upper[:, :2].sum(axis=1)
    faces = box((0, 0, 0), (1, 1, 1)).faces
    found = find_interfaces(assembly([Block(lower, faces), Block(upper, faces)], supports=[0]), gap="20 mm")
    assert found.gap == pytest.approx([(open_by + warp) / np.sqrt(1 + 2 * slope**2)])


def test_a_corner_listed_twice_at_a_notch_hides_no_part_of_a_face():
    # An L of three squares, with the corner of its notch doubled, on a slab: 3 m2, not the one square that sees all.
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 1), (1, 2), (0, 2)]
    n = len(outline)
    vertices = [(x, y, z) for z in (0, 1) for x, y in outline]
    sides = [[k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n) if k != 3]
    stone = Block(vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides])
    found = find_interfaces(assembly([box((-1, -1, -1), (3, 3, 0)), stone], supports=[0]))
    assert found.area == pytest.approx([3.0])


@pytest.mark.parametrize(("name", "at"), [("point", (0, 0)), ("frame", (0, 0, 0)), ("area", (0,)), ("gap", (0,))])
@pytest.mark.parametrize("ask", [assess, lambda scene, **own: limit_load(scene, (1, 0, 0), **own)])
def test_joints_with_numbers_that_are_none_are_refused(ask, name, at):
    scene = assembly([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))])
    joints = find_interfaces(scene)
    wrong = np.array(getattr(joints, name), dtype=float)
    wrong[at] = np.nan
    with pytest.raises(InputError, match='joint of "block0" and "block1" has numbers that are not finite'):
        ask(scene, interfaces=replace(joints, **{name: wrong}))


def test_a_joint_of_a_block_that_there_is_not_is_refused():
    scene = assembly([box((-1, -1, -1), (1, 1, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 3))])
    joints = find_interfaces(scene)
    with pytest.raises(InputError, match="a joint is of a block that is not among the 2"):
        assess(scene, interfaces=replace(joints, pair=joints.pair + 1))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (lambda own: {"friction": np.full(1, 0.5)}, r"friction has the shape \(1,\); it must be \(2,\) for 2 joints"),
        (lambda own: {"start": own.start[:-1]}, r"start has the shape \(2,\); it must be \(3,\)"),
        (lambda own: {"start": np.array([0, 6, 4])}, "start must grow from 0 to the number of points, 8"),
        (lambda own: {"pair": own.pair.astype(float)}, "pair has numbers that are not whole"),
        (lambda own: {"pair": own.pair[:, [0, 0]]}, '"ground" and "ground" is of a block with itself'),
        (lambda own: {"point": own.point[:4], "start": np.array([0, 4, 4])}, '"stone0" and "stone1" has no points'),
        (lambda own: {"frame": 2 * own.frame}, 'joint of "ground" and "stone0" has a frame that is not three'),
        (lambda own: {"frame": -own.frame}, "has a frame that is not three right-handed axes of length one"),
        (lambda own: {"friction": np.array([0.5, -0.5])}, '"stone0" and "stone1" has a friction that is not 0 or more'),
        (lambda own: {"friction": np.array([np.nan, 0.5])}, '"ground" and "stone0" has a friction that is not 0'),
        (lambda own: {"point": own.point + [0, 0, 10.0]}, '"ground" and "stone0" has points that are not near both'),
        (lambda own: {"point": own.point + [10.0, 0, 0]}, "has points that are not near both of them"),
    ],
)
def test_joints_that_cannot_be_those_of_the_assembly_are_refused(changed, message):
    scene = stack(2)
    joints = find_interfaces(scene)
    with pytest.raises(InputError, match=f"interfaces: .*{message}"):
        assess(scene, interfaces=replace(joints, **changed(joints)))


def test_joints_may_be_without_friction_and_of_blocks_in_any_order():
    scene = stack(1)
    joints = find_interfaces(scene)
    turned = joints.frame * np.array([-1.0, -1.0, 1.0])[:, None]  # the normal points to the other block
    for own in (replace(joints, friction=np.array([np.inf])), replace(joints, pair=joints.pair[:, ::-1], frame=turned)):
        assert assess(scene, interfaces=own).outcome is Outcome.STABLE
