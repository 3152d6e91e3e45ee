"""Derivatives of the reserve by joint, density and corner, against whole solves; moved corners against a new search."""

from dataclasses import replace

import numpy as np
import pytest
from test_sensitivity import tied
from test_vertex_sensitivity import CASES, fair_motion

from blockstat import (
    Imperfections,
    InputError,
    JointLaw,
    find_interfaces,
    limit_load,
    limit_load_by_point,
    point_load,
    reserve_map,
    shared_points,
)
from blockstat.contact.point_law import joint_friction
from blockstat.imperfection.lost_edges import edge_speeds, first_event, lose_edges
from blockstat.sensitivity.moved_corners import MovedCorners
from evidence.scenes.small import arch, assembly, box, stack

SHARP = {"optimum": True, "tolerance": 1e-8}
#: Name, scene and push: hinges, sliding joints, both in three dimensions, and a stack that turns about a corner.
SCENES = {
    "hinges": (arch(9, 0.2).with_(friction=0.6), (1.0, 0.3, 0.1)),
    "sliding": (arch(9, 0.3).with_(friction=0.35), (1.0, 0.0, 0.1)),
    "turning": (stack(3, 1.0, 0.5).with_(friction=0.8), (1.0, 0.3, 0.0)),
}
STEP = 1e-4


def multiplier(scene, push, faces, **options):
    found = limit_load(scene, push, interfaces=faces, **SHARP, **options)
    return (found.lower + found.upper) / 2


@pytest.fixture(scope="module", params=SCENES)
def case(request):
    scene, push = SCENES[request.param]
    faces = find_interfaces(scene)
    return scene, push, faces, reserve_map(limit_load(scene, push, interfaces=faces, **SHARP), push)


def differences(count, value):
    units = STEP * np.eye(count)
    return np.array([(value(unit) - value(-unit)) / (2 * STEP) for unit in units])


def test_by_the_friction_of_each_joint(case):
    scene, push, faces, found = case
    mu = joint_friction(scene, faces)
    by_hand = differences(len(mu), lambda d: multiplier(scene, push, replace(faces, friction=mu + d)))
    np.testing.assert_allclose(found.friction, by_hand, atol=5e-5)


def test_by_what_each_joint_loses(case):
    """A difference to one side: no joint gains edges."""
    scene, push, faces, found = case
    loss = STEP * np.eye(faces.n_interfaces)
    by_hand = [(multiplier(scene, push, lose_edges(faces, own)) - found.value) / STEP for own in loss]
    np.testing.assert_allclose(found.edge, by_hand, atol=3e-4)
    assert (found.edge < 1e-9).all()


def test_by_the_density_of_each_block(case):
    scene, push, faces, found = case

    def value(share):
        return multiplier(scene.with_(density=scene.density * (1 + share)), push, faces)

    by_hand = differences(scene.n_blocks, value)
    np.testing.assert_allclose(found.density * scene.density, by_hand, atol=5e-5)


def test_by_all_corners_at_random(case):
    scene, push, faces, found = case
    corners = MovedCorners(scene, faces)
    rng = np.random.default_rng(5)
    for _ in range(3):
        shift = rng.standard_normal((corners.count, 3))
        ends = []
        for sign in (1, -1):
            moved, joints = corners.moved(sign * STEP * shift, faces)
            ends.append(multiplier(moved, push, joints))
        slope = float(corners.gathered(found.corner) @ shift.ravel())
        assert (ends[0] - ends[1]) / (2 * STEP) == pytest.approx(slope, rel=1e-4, abs=2e-4)


def test_permanent_wrenches_and_a_load_that_does_not_follow_the_masses():
    """A block of weight W with a dead load N: mu (W + N) / load, half of it by half the friction."""
    scene = stack(1, 2.0, 0.5, density=1.0).with_(gravity=np.array([0.0, 0.0, -1.0]), friction=0.5)
    dead, live = np.zeros((2, 6)), np.zeros((2, 6))
    dead[1, 2], live[1, 0] = -3.0, 1.0
    weight = float(scene.mass[1])
    found = reserve_map(limit_load(scene, live, loads=dead, **SHARP), live, loads=dead)
    assert found.value == pytest.approx(0.5 * (weight + 3.0))
    assert found.friction.sum() == pytest.approx(weight + 3.0, rel=1e-6)
    assert found.density[1] * scene.density[1] == pytest.approx(0.5 * weight, rel=1e-6)
    with pytest.raises(InputError, match="not that of this load"):
        reserve_map(limit_load(scene, live, loads=dead, **SHARP), live)


def test_strength_that_goes_with_the_area_is_refused():
    law = JointLaw(("*", "*"), tension=1e3)
    glued = stack(1, 1.0, 2.0).with_(joints=[law])
    with pytest.raises(InputError, match="strength goes with their area"):
        reserve_map(limit_load(glued, (1, 0, 0)), (1, 0, 0))


@pytest.mark.parametrize("name", ["arch", "vault"])
def test_moved_corners_take_their_joints_where_a_search_finds_them(name):
    make, values, push = CASES[name]
    scene = make(values)
    faces = find_interfaces(scene)
    corners = MovedCorners(scene, faces)
    points, label = shared_points(scene)

    class Found:
        pass

    found = Found()
    found.points = points
    motion = 1e-3 * fair_motion(name, found, np.random.default_rng(2))
    free = np.unique(label[~scene.support[scene.vertex_block]])
    motion[np.setdiff1d(np.arange(len(points)), free)] = 0.0
    if name == "vault":  # an affine map of all would move the ground
        motion[:, 2] *= 0.0
    moved, joints = corners.moved(motion[free], faces)
    again = find_interfaces(moved)
    np.testing.assert_array_equal(again.pair, joints.pair)
    assert multiplier(moved, push, joints) == pytest.approx(multiplier(moved, push, again), rel=1e-5)


def test_edges_that_move_in_agree_with_clipping():
    """An irregular hexagon: the corners on straight lines up to the first edge that vanishes, and none before."""
    faces = find_interfaces(arch(5, 0.3))
    limit = first_event(faces, edge_speeds(faces))
    for share in (0.3, 0.999, 1.5):
        ours, exact = (lose_edges(faces, depth) for depth in (share * limit, share * limit * (1 + 1e-12)))
        np.testing.assert_allclose(ours.area, exact.area, atol=1e-9)
    width = min(0.3, 1.0)
    np.testing.assert_allclose(limit.min(), width / 2, rtol=1e-9)


def test_what_slides_hangs_on_its_friction_and_on_no_edge():
    # A cube slides at its friction, whatever its edges lose.
    cube = assembly([box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")], friction=0.7)
    found = reserve_map(limit_load(cube, (1, 0, 0), optimum=True), (1, 0, 0))
    assert found.most("edge") == []
    ((names, derivative),) = found.most("friction")
    assert (names, derivative) == ('"ground" and "cube"', pytest.approx(1.0, rel=1e-6))


def test_what_a_tied_pillar_hangs_on():
    """It tips at b / h + 2 F z / (W h): its edges count 2 / h, and its density by the tie alone."""
    asm = tied({"width": 0.6, "height": 2.0}, 2000.0)
    found = reserve_map(limit_load(asm, (1, 0, 0), **SHARP), (1, 0, 0))
    gain = 2 * 2000.0 * 1.6 / (float(np.linalg.norm(asm.gravity)) * asm.mass[1] * 2.0)
    assert found.value == pytest.approx(0.3 + gain, rel=1e-6)
    assert found.edge == pytest.approx([-1.0], rel=1e-6)
    assert found.friction == pytest.approx([0.0], abs=1e-6)
    assert found.density * asm.density == pytest.approx([0.0, -gain], rel=1e-6)


def test_joints_that_are_divided_into_cells_have_a_map_of_their_friction_alone():
    """A slab slides at mu, whatever its cells: the derivative is 1 by friction and not known by edges."""
    slab = stack(1, 2.0, 0.5, friction=0.6, joints=[JointLaw(("*", "*"), cells=4)])
    found = reserve_map(limit_load(slab, (1, 0, 0), **SHARP), (1, 0, 0), corners=False)
    assert found.friction == pytest.approx([1.0], rel=1e-6)
    assert np.isnan(found.edge).all()
    with pytest.raises(InputError, match="the joints are divided into cells; a map by what their edges lose is not"):
        found.most("edge")


def test_joints_that_have_lost_their_edges_have_no_map_by_corners():
    """A block of width b and height h that has lost d at each edge tips at (b - 2 d) / h, and by d at -2 / h."""
    block = stack(1, 1.0, 2.0, friction=2.0)
    limit = limit_load(block, (1, 0, 0), imperfections=Imperfections(edge=0.1), **SHARP)
    assert limit.lower == pytest.approx(0.4, rel=1e-6)
    assert reserve_map(limit, (1, 0, 0), corners=False).edge == pytest.approx([-1.0], rel=1e-6)
    for ask in (reserve_map, limit_load_by_point):
        with pytest.raises(InputError, match="joints that have lost their edges have no derivative by corners"):
            ask(limit, (1, 0, 0))


def test_a_load_with_other_moments_is_not_that_of_the_limit():
    """The same force at half the height is carried twice over: a block tips at W b / (2 z)."""
    block = stack(1, 1.0, 2.0, friction=2.0)
    high, low = (point_load(block, 1, (0.0, 0.5, z), (1.0, 0.0, 0.0)) for z in (2.0, 1.0))
    limit = limit_load(block, high, **SHARP)
    assert limit_load(block, low, **SHARP).lower == pytest.approx(2 * limit.lower, rel=1e-6)
    assert reserve_map(limit, high, corners=False).edge == pytest.approx([-2 * limit.lower], rel=1e-6)
    with pytest.raises(InputError, match="the limit is not that of this load: its forces do not balance"):
        reserve_map(limit, low, corners=False)
