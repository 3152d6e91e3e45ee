import copy
import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import (
    Assembly,
    Block,
    InputError,
    InputWarning,
    JointLaw,
    Tie,
    find_interfaces,
    glued,
    point_load,
    tendon_load,
)
from blockstat.assembly import block_indices
from evidence.scenes.small import box


def single(block, **options):
    return Assembly.from_blocks([block], supports=[0], density=2.0, **options)


def test_box_integrals_match_the_textbook_wherever_the_box_is():
    a, b, c = 0.3, 0.5, 1.1
    turn = Rotation.from_rotvec([0.3, -0.7, 0.2]).as_matrix()
    for far in (0.0, 1e6):
        base = box((-a / 2, -b / 2, -c / 2), (a / 2, b / 2, c / 2))
        asm = single(Block(base.vertices @ turn.T + far, base.faces))
        mass = 2.0 * a * b * c
        inertia = turn @ np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) @ turn.T * mass / 12
        rounding = 1e-9 if far else 1e-13
        assert asm.mass[0] == pytest.approx(mass, rel=100 * rounding)
        np.testing.assert_allclose(asm.centroid[0], [far] * 3, atol=1e-9 if far else 1e-15)
        np.testing.assert_allclose(asm.inertia[0], inertia, rtol=1e-6 if far else 1e-12, atol=1e-8 if far else 1e-15)


def test_tetrahedron_integrals():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    asm = single(Block(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    assert asm.volume[0] == pytest.approx(1 / 6)
    np.testing.assert_allclose(asm.centroid[0], [0.25] * 3)
    # About the centroid: integral of x^2 is 1/60 - V/16, of x y is 1/120 - V/16.
    diagonal, off = 2 * (1 / 60 - 1 / 96), -(1 / 120 - 1 / 96)
    np.testing.assert_allclose(asm.inertia[0], 2.0 * (np.eye(3) * (diagonal - off) + off), rtol=1e-12)


def test_concave_prism_integrals():
    # An L of three unit squares, one unit deep.
    plan = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    bottom = [(x, y, 0) for x, y in plan]
    top = [(x, y, 1) for x, y in plan]
    faces = [
        list(range(5, -1, -1)),
        list(range(6, 12)),
        *([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)),
    ]
    asm = single(Block(bottom + top, faces))
    assert asm.volume[0] == pytest.approx(3.0)
    np.testing.assert_allclose(asm.centroid[0], [5 / 6, 5 / 6, 0.5])
    # About the origin the squares give 1/3 + 7/3 + 1/3 for the integral of x^2 and 1/4 + 3/4 + 3/4 for that of x y.
    xx, xy, zz = 3 - 3 * (5 / 6) ** 2, 7 / 4 - 3 * (5 / 6) ** 2, 3 / 12
    np.testing.assert_allclose(
        asm.inertia[0], 2.0 * np.array([[xx + zz, -xy, 0], [-xy, xx + zz, 0], [0, 0, 2 * xx]]), rtol=1e-12, atol=1e-15
    )


def test_groups_take_their_subgroups_along():
    blocks = [box((i, 0, 0), (i + 1, 1, 1), group=g) for i, g in enumerate(("wall.north", "wall.south", "vault"))]
    asm = Assembly.from_blocks(blocks, supports=[0])
    assert asm.in_group("wall").tolist() == [0, 1]
    with pytest.raises(InputError, match=r'no group "wal"; groups are: vault, wall\.north, wall\.south'):
        asm.in_group("wal")


def test_supports_by_name_or_index():
    blocks = [box((i, 0, 0), (i + 1, 1, 1), name=n) for i, n in enumerate("abc")]
    assert Assembly.from_blocks(blocks, supports=["c", 0]).support.tolist() == [True, False, True]


def test_of_many_blocks_an_error_names_those_spelled_alike_first():
    blocks = [box((i, 0, 0), (i + 1, 1, 1), name=f"wall.{i}") for i in range(30)]
    plate = box((0, 1, 0), (1, 2, 1), name="pfw")
    with pytest.raises(InputError, match=r'no block "pfw\.0"; blocks are: pfw, wall\.0, .*, \.\.\. \(31 in all\)'):
        Assembly.from_blocks([*blocks, plate], supports=["pfw.0"])


def test_laws_given_with_groups_are_about_those_groups():
    asm = Assembly.from_blocks([box((i, 0, 0), (i + 1, 1, 1), group="old") for i in range(2)], supports=[0])
    law = JointLaw(("left", "right"), friction=0.5)
    changed = asm.with_(groups=("left", "right"), joints=[law])
    assert changed.joints == (law,)
    with pytest.raises(InputError, match='no group "old"; groups are: left, right'):
        asm.with_(groups=("left", "right"), joints=[JointLaw(("old", "*"), friction=0.5)])


def test_laws_and_ties_of_a_copy_are_checked():
    asm = Assembly.from_blocks([box((i, 0, 0), (i + 1, 1, 1), name=n) for i, n in enumerate("ab")], supports=[0])
    with pytest.raises(InputError, match='no field "frction"; fields are: '):
        asm.with_(frction=0.5)
    for changes, message in (
        ({"friction": -1.0}, "friction is"), ({"gravity": (0, 0)}, "gravity"),
        ({"ties": [Tie(("a", "c"), ((0, 0, 0), (1, 0, 0)), name="rod")]}, 'rod.*: no block "c"'),
        ({"joints": [JointLaw(("x", "*"), friction=0.5)]}, 'no group "x"'),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            asm.with_(**changes)
    changed = asm.with_(friction=0.25, gravity=(1, 2, 3), joints=[JointLaw(("*", "*"), bond=2.0)], name="new")
    assert (changed.friction, changed.gravity.tolist(), changed.name) == (0.25, [1, 2, 3], "new")
    assert changed.joints == (JointLaw(("*", "*"), bond=2.0),)
    assert (asm.friction, asm.gravity.tolist(), asm.joints, asm.name) == (0.7, [0, 0, -9.81], (), "assembly")
    tied = asm.with_(ties=[Tie((0, "b"), ((0, 0, 0), (1, 0, 0)))])
    assert isinstance(tied.ties, tuple)


def test_what_is_computed_of_shapes_is_computed_once_until_they_change():
    asm = single(box((0, 0, 0), (1, 2, 3)))
    planes, mass = asm.planes, asm.mass
    lighter = asm.with_(density=1.0)
    assert lighter.planes is planes
    assert lighter.mass == pytest.approx(mass / 2)
    twice = asm.with_(vertices=2 * asm.vertices)
    assert twice.volume == pytest.approx(8 * asm.volume)
    assert twice.size == pytest.approx(2 * asm.size)
    np.testing.assert_allclose(twice.planes.centre, 2 * planes.centre)


def test_densities_names_and_groups_are_those_of_the_blocks():
    blocks = [box((0, 0, 0), (1, 1, 2)), box((1, 0, 0), (3, 1, 1), density=7.0, group="g"), box((4, 0, 0), (5, 1, 1))]
    asm = Assembly.from_blocks(blocks, supports=[1], density=3.0, gravity=(0, 3, -4), metadata={"k": 1})
    assert asm.names == ("block0", "block1", "block2")
    assert asm.groups == ("", "g", "")
    assert asm.mass == pytest.approx([6.0, 14.0, 3.0])
    assert asm.free.tolist() == [0, 2]
    assert asm.free_weight == pytest.approx(5.0 * 9.0)
    assert asm.metadata == {"k": 1}
    assert asm.vertex_start.tolist() == [0, 8, 16, 24]
    assert asm.face_block.tolist() == [0] * 6 + [1] * 6 + [2] * 6
    for block in range(3):
        assert {len(face) for face in asm.faces_of(block)} == {4}
        assert (asm.block_vertices(block) == blocks[block].vertices).all()
    assert Assembly.from_blocks(blocks).density.tolist() == [2691.0, 7.0, 2691.0]
    assert Assembly.from_blocks(blocks).friction == 0.7


def test_the_number_of_a_block_is_its_name_unless_that_is_taken():
    cube = box((0, 0, 0), (1, 1, 1)).vertices
    faces = box((0, 0, 0), (1, 1, 1)).faces
    names = ["block1", "", "", "block2", "block2_"]
    asm = Assembly.from_blocks([Block(cube + [2 * k, 0, 0], faces, name) for k, name in enumerate(names)])
    assert asm.names == ("block1", "block1_", "block2__", "block2", "block2_")
    with pytest.raises(InputError, match='two blocks are named "b"; names must be unique'):
        Assembly.from_blocks([Block(cube + [2 * k, 0, 0], faces, "b") for k in range(2)])
    with pytest.raises(InputError, match="the assembly has no blocks"):
        Assembly.from_blocks([])


@pytest.mark.parametrize(("vertices", "message"), [
    ("abc", "vertices must be a list of"), ([[0, 0, 0], [1]], "vertices must be a list of"),
    (np.zeros((3, 3)), r"vertices have shape \(3, 3\)"), (np.zeros((8, 2)), r"vertices have shape \(8, 2\)"),
    (np.zeros(12), r"vertices have shape \(12,\)"),
    (np.zeros((2, 4, 3)), r"vertices have shape \(2, 4, 3\); at least 4"),
])  # fmt: skip
def test_bad_vertices_are_named(vertices, message):
    blocks = [box((0, 0, 0), (1, 1, 1)), Block(vertices, [[0, 1, 2]] * 4, "odd")]
    with pytest.raises(InputError, match=f'block "odd": {message}'):
        Assembly.from_blocks(blocks)


def test_coordinates_are_finite_and_below_the_largest():
    tetrahedron = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    for value in (1e30, -1e30, np.nan, -np.inf):
        bad = corners.copy()
        bad[2, 1] = value
        blocks = [Block(corners, tetrahedron, "good"), Block(bad, tetrahedron, "bad"), Block(-bad, tetrahedron, "two")]
        with pytest.raises(InputError) as caught:
            Assembly.from_blocks(blocks)
        assert [text.split(" is ")[0] for text in caught.value.args] == [
            'block "bad": vertex 2', 'block "two": vertex 2',
        ]  # fmt: skip
        assert "coordinates must be finite and below 1e+30" in str(caught.value)


def test_faces_have_three_corners_that_exist():
    good = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    for face, message in (
        ([0, 1], r"face 1 is \[0, 1\]; it needs three or more different corners"),
        ([0, 1, 1], r"face 1 is \[0, 1, 1\]; it needs three or more different corners"),
        ([0, 1, 4], r"face 1 is \[0, 1, 4\]; corners must lie between 0 and 3"),
        ([-1, 1, 3], r"face 1 is \[-1, 1, 3\]; corners must lie between 0 and 3"),
    ):
        with pytest.raises(InputError, match=f'block "t": {message}'):
            Assembly.from_blocks([Block(corners, [good[0], face, *good[2:]], "t")])
    assert Assembly.from_blocks([Block(corners, good)]).volume[0] == pytest.approx(1 / 6)
    with pytest.raises(InputError, match='block "t": 3 faces cannot close a volume; at least 4 are needed'):
        Assembly.from_blocks([Block(corners, good[:3], "t")])
    with pytest.raises(InputError, match="3 faces cannot close a volume"):
        Assembly.from_blocks([Block(corners, [*good[:3], [2, 1, 0]], "t")])


def test_blocks_and_assemblies_do_not_change_and_an_assembly_is_compared_by_identity():
    block = box((0, 0, 0), (1, 2, 3), name="a")
    with pytest.raises(FrozenInstanceError):
        block.name = "b"
    assert replace(block) == block
    own = Assembly.from_blocks([block])
    with pytest.raises(FrozenInstanceError):
        own.names = ("b",)
    assert replace(own) != own
    assert len({own, replace(own)}) == 2


def test_a_face_listed_twice_counts_once_wherever_it_begins():
    good = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    blocks = [Block(corners, good, "a"), Block(corners + 5, [*good, [3, 0, 1]], "b"), Block(corners + 9, good, "c")]
    with pytest.warns(InputWarning, match=r'1 blocks list faces twice \(the first is "b"\); each counts once'):
        asm = Assembly.from_blocks(blocks)
    assert asm.face_block.tolist() == [0] * 4 + [1] * 4 + [2] * 4
    assert asm.volume == pytest.approx([1 / 6] * 3)


def test_of_several_blocks_that_list_faces_twice_the_first_is_named():
    good = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    twice = [*good, [3, 0, 1]], [*good, *good]
    blocks = [Block(corners, good, "a"), Block(corners + 5, twice[0], "b"), Block(corners + 9, twice[1], "c")]
    with pytest.warns(InputWarning) as told:
        Assembly.from_blocks(blocks)
    (warning,) = told
    assert str(warning.message) == '2 blocks list faces twice (the first is "b"); each counts once'


def test_blocks_are_given_by_name_or_number_or_a_number_as_text():
    names = ["a", "1", "c"]
    assert block_indices(names, ["c", 0, "2", np.int64(1)], "x").tolist() == [2, 0, 2, 1]
    assert block_indices(names, "1", "x").tolist() == [1]  # the name comes first
    assert block_indices(names, "0", "x").tolist() == [0]
    assert block_indices(names, 2, "x").tolist() == [2]
    for given, message in (
        ("3", 'x: no block "3"; blocks are: a, 1, c'), (3, "x: no block 3; blocks are numbered 0 to 2"),
        (-1, "x: no block -1; blocks are numbered 0 to 2"), ([True], "x: True is neither a block's index nor its name"),
        ([1.0], r"x: 1\.0 is neither a block's index nor its name"), ([None], "x: None is neither"),
        (["²"], 'x: no block "²"'), (["٢"], 'x: no block "٢"'),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            block_indices(names, given, "x")
    asm = Assembly.from_blocks([box((i, 0, 0), (i + 1, 1, 1), name=n) for i, n in enumerate(names)])
    assert asm.blocks_named(["c", "a"]).tolist() == [2, 0]
    with pytest.raises(InputError, match=r"^blocks: no blocks are given"):
        asm.blocks_named([])
    with pytest.raises(InputError, match=r'^these: no block "d"'):
        asm.blocks_named("d", "these")


def test_a_few_blocks_are_all_named_in_an_error_and_many_are_not():
    eight = [f"n{k}" for k in range(8)]
    with pytest.raises(InputError, match=r"blocks are: n0, n1, n2, n3, n4, n5, n6, n7$"):
        block_indices(eight, "zzz", "x")
    with pytest.raises(InputError, match=r"blocks are: n0, n1, n2, n3, n4, n5, n6, n7, \.\.\. \(9 in all\)"):
        block_indices([*eight, "last"], "zzz", "x")
    with pytest.raises(InputError, match=r"blocks are: last, n0, n1, n2, n3, n4, n5, n6, \.\.\. \(9 in all\)"):
        block_indices([*eight, "last"], "lasd", "x")


def test_a_group_takes_its_subgroups_and_not_those_that_begin_alike():
    groups = ("wall", "wall.a", "wall2", "", "a.wall")
    asm = Assembly.from_blocks([box((i, 0, 0), (i + 1, 1, 1), group=g) for i, g in enumerate(groups)])
    assert asm.in_group("wall").tolist() == [0, 1]
    assert asm.in_group("a").tolist() == [4]
    assert asm.in_group("wall").dtype == np.int64
    with pytest.raises(InputError, match=r'no group "b"; groups are: a\.wall, wall, wall\.a, wall2$'):
        asm.in_group("b")


def test_glue_is_added_to_the_laws_that_there_are():
    asm = Assembly.from_blocks([box((i, 0, 0), (i + 1, 1, 1), group="g") for i in range(2)], supports=[0])
    law = JointLaw(("g", "*"), friction=0.3)
    assert glued(asm, 5.0).joints == (JointLaw(("*", "*"), bond=5.0),)
    found = glued(asm.with_(joints=[law]), 5.0, moment=2.0).joints
    assert found == (
        JointLaw(("*", "*"), bond=5.0, bond_moment=2.0), JointLaw(("g", "*"), friction=0.3, bond=5.0, bond_moment=2.0),
    )  # fmt: skip


def test_who_reads_blocks_with_doubled_faces_is_told_in_his_own_line():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    doubled = Block(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [3, 1, 2]])

    def reader():
        return Assembly.from_blocks([doubled])

    def user():
        return reader()

    with pytest.warns(InputWarning) as caught:
        user()
    assert (caught[0].filename, caught[0].lineno) == (__file__, user.__code__.co_firstlineno + 1)


def test_a_vertex_of_no_face_is_no_part_of_a_block():
    cubes = [box((500000 + k, 5500000, 100), (500001 + k, 5500001, 101)) for k in (0, 1)]
    spare = Block(np.vstack([[(0, 0, 0)], cubes[0].vertices]), [[c + 1 for c in face] for face in cubes[0].faces])
    asm = Assembly.from_blocks([spare, cubes[1]], supports=[0])
    assert asm.volume == pytest.approx([1.0, 1.0])
    np.testing.assert_allclose(asm.bounds[0], [(500000, 5500000, 100), (500001, 5500000, 100)])
    assert find_interfaces(asm).area == pytest.approx([1.0])


ARRAYS = "vertices vertex_start face_vertices face_start face_block density support gravity mass inertia volume size"


@pytest.mark.parametrize("of", [lambda a: a, copy.copy, copy.deepcopy, lambda a: pickle.loads(pickle.dumps(a))])
@pytest.mark.parametrize("name", ARRAYS.split())
def test_the_arrays_of_an_assembly_cannot_be_written_to(name, of):
    made = single(box((0, 0, 0), (1, 1, 1)))
    assert made.mass.sum() > 0 < made.size.sum() * made.inertia.sum()
    with pytest.raises(ValueError, match="read-only"):
        getattr(of(made), name)[...] = 0


@pytest.mark.parametrize("name", ["bounds", "face_bounds"])
def test_the_boxes_of_an_assembly_cannot_be_written_to(name):
    for bound in getattr(single(box((0, 0, 0), (1, 1, 1))), name):
        with pytest.raises(ValueError, match="read-only"):
            bound[...] = 0


def test_an_array_that_an_assembly_is_given_stays_its_owners():
    made = single(box((0, 0, 0), (1, 1, 1)))
    own = 2 * made.vertices
    larger = made.with_(vertices=own)
    own *= 2
    assert larger.volume == pytest.approx(8.0)
    assert larger.with_(density=1.0).vertices is larger.vertices


def test_the_lowest_blocks_are_supports():
    piers = [box((x, 0, 0), (x + 1, 1, 3), name=f"pier{x}") for x in (0, 4)]
    beam = box((0, 0, 3), (5, 1, 4), name="beam")

    def held(*blocks, supports="lowest", **options):
        asm = Assembly.from_blocks(blocks, supports=supports, **options)
        return {asm.names[i] for i in np.flatnonzero(asm.support)}

    assert held(*piers, beam) == held(beam, *piers, supports=["lowest"]) == {"pier0", "pier4"}
    # A pier of 3 m: 29 mm higher is as low, 31 mm are not.
    for rise, found in ((0.029, {"pier0", "pier4"}), (0.031, {"pier0"})):
        raised = box((4, 0, rise), (5, 1, 3 + rise), name="pier4")
        assert held(piers[0], raised, beam) == found
    # A long beam on thin pads is no support.
    pads = [box((x, 0, 0), (x + 0.2, 0.3, 0.05), name=f"pad{x}") for x in (0, 5)]
    assert held(*pads, box((0, 0, 0.05), (6, 0.3, 0.35), name="beam")) == {"pad0", "pad5"}
    # Gravity says what is down; along x, the pier at x = 0 and the end of the beam above it.
    assert held(*piers, beam, gravity=(-9.81, 0, 0)) == {"pier0", "beam"}
    assert held(*piers, beam, gravity=(0, 0, 9.81)) == {"beam"}
    assert held(*piers, beam, supports=["beam", "lowest"]) == {"pier0", "pier4", "beam"}
    # A block of that name is meant before anything else.
    assert held(*piers, replace(beam, name="lowest")) == {"lowest"}
    with pytest.raises(InputError, match='supports: no block "lowst"'):
        held(*piers, beam, supports=["lowst"])
    # A corner that no face has is no corner of the block.
    stray = Block(np.vstack([beam.vertices, [0, 0, -9]]), beam.faces, "beam")
    assert held(*piers, stray) == {"pier0", "pier4"}


def test_a_name_is_found_however_its_letters_are_composed():
    assembly = Assembly.from_blocks([box((k, 0, 0), (k + 1, 1, 1), name=n) for k, n in enumerate(("a", "W\u00fcrfel"))])
    assert assembly.blocks_named("Wu\u0308rfel").tolist() == [1]
    assert assembly.blocks_named(["W\u00fcrfel", 0]).tolist() == [1, 0]
    with pytest.raises(InputError, match='no block "Wurfel"'):
        assembly.blocks_named("Wurfel")


def test_a_layer_stands_for_its_blocks():
    names = ["BASE::left", "BASE::right", "ARCH::crown::stone 1", "ARCH::crown::stone 2", "ARCH", "BASEMENT::x"]
    blocks = [box((3 * k, 0, 0), (3 * k + 1, 1, 1), name=name) for k, name in enumerate(names)]
    asm = Assembly.from_blocks(blocks, supports=["BASE"])
    assert asm.support.tolist() == [True, True, False, False, False, False]
    assert asm.blocks_named(["ARCH::crown", 0]).tolist() == [2, 3, 0]
    assert asm.blocks_named("ARCH").tolist() == [4]  # a block's own name counts first
    with pytest.raises(InputError, match='no block "BAS"'):
        asm.blocks_named("BAS")
    with pytest.raises(InputError, match=r"load: 'BASE' are 2 blocks; give one"):
        point_load(asm, "BASE", (0, 0, 1), (0, 0, -1))
    with pytest.raises(InputError, match='no block "BASE"'):  # a tie has two ends
        asm.with_(ties=[Tie(("BASE", "ARCH"), ((0, 0, 0), (12, 0, 0)))])
    with pytest.raises(InputError, match="is a layer of several blocks; one point a block is needed"):
        tendon_load(asm, ["BASE", "ARCH"], [(0, 0, 0), (12, 0, 0)], 1.0)


def test_a_block_that_is_a_surface_is_told_apart_from_one_that_is_open():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    told = "1 face cannot close a volume; at least 4 are needed; give a surface a thickness, or delete it and choose"
    with pytest.raises(InputError, match=told):
        Assembly.from_blocks([Block(corners, [[0, 1, 2, 3]], "bed")])
