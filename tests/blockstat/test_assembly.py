import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, JointLaw
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
