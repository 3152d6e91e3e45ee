"""Derivatives by shared points and by added stones against whole solves, and against what scale and place must do."""

from dataclasses import replace

import numpy as np
import pytest
from test_sensitivity import a_hut, a_wall, an_arch, tied

from blockstat import InputError, JointLaw, acceleration, assess, limit_load
from blockstat.sensitivity.parameters import stone_sensitivity
from blockstat.sensitivity.vertices import limit_load_by_point, score_by_point, shared_points
from evidence.scenes.small import arch, assembly, box, hexahedron, running_bond, stack

CASES = {
    "arch": (an_arch, {"t": 0.2, "r": 1.0, "d": 0.5}, (1, 0, 0)),
    "wall": (a_wall, {"length": 0.4, "height": 0.175}, (1, 0, 0)),
    "vault": (a_hut, {"wall.thickness": 0.73, "vault.thickness": 0.27}, (0, 1, 0)),
}


@pytest.fixture(params=CASES, ids=list(CASES), scope="module")
def case(request):
    make, values, direction = CASES[request.param]
    limit = limit_load(make(values), direction)
    return request.param, make, values, direction, limit, limit_load_by_point(limit, direction)


def moved(asm, found, motion):
    """The assembly with its shared points moved."""
    return replace(asm, vertices=asm.vertices + motion[found.vertex_point])


def middle(limit):
    return (limit.lower + limit.upper) / 2


def fair_motion(name, found, rng):
    """A random motion of all points that keeps faces planar and blocks in touch, of the order of a metre."""
    if name == "arch":
        # Every joint's line across the depth goes its own way in the plane of the arch: the faces stay prisms.
        _, line = np.unique(np.round(found.points[:, [0, 2]], 6), axis=0, return_inverse=True)
        motion = np.zeros_like(found.points)
        motion[:, [0, 2]] = rng.normal(size=(line.max() + 1, 2))[line.reshape(-1)] / 2
        return motion
    # Affine maps keep planes planes.
    return found.points @ rng.normal(size=(3, 3)) / 2


def test_shared_points_are_the_places_of_the_corners():
    points, label = shared_points(arch(12, 0.2))
    # 13 joints of four corners, and four more at the far ends of the two springers.
    assert len(points) == 13 * 4 + 2 * 4
    np.testing.assert_allclose(points[label], arch(12, 0.2).vertices, atol=1e-12)


def test_chain_rule_to_the_parameters_of_a_design(case):
    _, make, values, direction, _, found = case
    for name, value in values.items():
        step = 1e-3 * value
        ends = [make({**values, name: value + sign * step}) for sign in (1, -1)]
        motion = np.zeros_like(found.points)
        motion[found.vertex_point] = (ends[0].vertices - ends[1].vertices) / (2 * step)
        slope = (limit_load(ends[0], direction).lower - limit_load(ends[1], direction).lower) / (2 * step)
        assert found.along(motion) == pytest.approx(slope, rel=2e-4, abs=1e-5)


def test_place_and_scale_change_nothing(case):
    *_, found = case
    size = np.abs(found.gradient).sum()
    np.testing.assert_allclose(found.gradient.sum(axis=0), 0.0, atol=1e-6 * size)
    assert found.along(found.points) == pytest.approx(0.0, abs=1e-6 * size)
    assert found.gradient.any()


def test_taylor_remainder_of_the_limit_load_is_of_second_order(case):
    name, _, _, direction, limit, found = case
    motion = fair_motion(name, found, np.random.default_rng(5))
    steps = np.array([8e-3, 4e-3, 2e-3])
    rest = [
        abs(middle(limit_load(moved(limit.assembly, found, s * motion), direction)) - middle(limit) - s * slope)
        for slope in [found.along(motion)]
        for s in steps
    ]
    slopes = np.diff(np.log(rest)) / np.diff(np.log(steps))
    np.testing.assert_allclose(slopes, 2.0, atol=0.1)


def test_taylor_remainder_of_the_score_is_of_second_order():
    verdict = assess(arch(12, 0.09))
    assert verdict.score > 0
    found = score_by_point(verdict)
    assert found.along(found.points) == pytest.approx(0.0, abs=1e-6)
    motion = fair_motion("arch", found, np.random.default_rng(6)) / 10
    steps = np.array([8e-3, 4e-3, 2e-3])
    scores = np.array([assess(moved(verdict.assembly, found, s * motion)).score for s in steps])
    rest = np.abs(scores - verdict.score - steps * found.along(motion))
    np.testing.assert_allclose(np.diff(np.log(rest)) / np.diff(np.log(steps)), 2.0, atol=0.1)
    stands = score_by_point(assess(arch(12, 0.2)))
    assert not stands.gradient.any()


def test_a_cube_that_overhangs_tips_about_the_edge_below_it():
    # The patch has a corner of each block and two crossings. Pushed along x the upper cube tips about the edge x = 1
    # of the lower one: lambda = (1 - x of its centroid) / (half its height).
    asm = assembly([box((0, 0, -1), (1, 1, 0)), box((0.3, 0.4, 0), (1.3, 1.4, 1))])
    limit = limit_load(asm, (1, 0, 0))
    assert middle(limit) == pytest.approx(0.4, rel=1e-6)
    found = limit_load_by_point(limit, (1, 0, 0))
    upper = found.vertex_point[8:]
    for axis, expected in ((0, -2.0), (1, 0.0), (2, 0.0)):
        motion = np.zeros_like(found.points)
        motion[upper, axis] = 1.0
        if axis < 2:  # it slides about on the lower cube
            assert found.along(motion) == pytest.approx(expected, abs=1e-5)
    # The edge of the lower cube goes the other way, and a higher cube tips sooner: d(0.2 / (h / 2)) / dh = -0.4.
    edge = np.where(np.isclose(found.points[:, :1], 1.0), [1.0, 0, 0], 0.0)
    assert found.along(edge) == pytest.approx(2.0, abs=1e-5)
    lid = np.where(np.isclose(found.points[:, 2:], 1.0), [0, 0, 1.0], 0.0)
    assert found.along(lid) == pytest.approx(-0.4, abs=1e-5)


@pytest.mark.parametrize("size", [0.1, 0.02])
@pytest.mark.parametrize("place", [(0, 0, 0), (3.3e5, 5.7e6, 10), (123456.7, 4654321.1, 87.3)], ids=str)
def test_a_small_brick_slides_the_sooner_the_more_its_bed_leans_wherever_it_is(size, place):
    """At tan(atan(mu) - t) of its weight where the bed drops by an angle t along the push: derivative -(1 + mu^2)."""
    blocks = [box((0, 0, -size), (size, size, 0)), box((0, 0, 0), (size, size, 0.3 * size))]
    scene = assembly(blocks, friction=0.5)
    scene = scene.with_(vertices=scene.vertices + place)
    found = limit_load_by_point(limit_load(scene, (1, 0, 0), optimum=True), (1, 0, 0))
    lean = (found.points - place)[:, :1] * (0, 0, -1.0)
    assert found.along(lean) == pytest.approx(-1.25, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 6])
def test_edges_that_nearly_coincide_carry_points_together(seed):
    # As two cubes of one plan from a scanner: their edges cross at tiny angles. Half width over half height is 1, and
    # moving every corner on the right by dx moves the edge by dx and the centroid by dx / 2: d lambda = 1. Turning
    # that side, dx = y, moves its middle by 1/2 and the centroid by 1/4: d lambda = 1/2.
    plan = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    noisy = plan + 2e-4 * np.random.default_rng(seed).normal(size=(4, 2))
    asm = assembly(
        [box((0, 0, -1), (1, 1, 0)), hexahedron([(*p, 0) for p in noisy], [(*p, 1) for p in noisy])], friction=2.0
    )
    limit = limit_load(asm, (1, 0, 0))
    assert middle(limit) == pytest.approx(1.0, abs=2e-3)
    found = limit_load_by_point(limit, (1, 0, 0))
    right = np.where(found.points[:, :1] > 0.5, [1.0, 0, 0], 0.0)
    assert found.along(right) == pytest.approx(1.0, abs=5e-3)
    assert found.along(right * found.points[:, 1:2]) == pytest.approx(0.5, abs=5e-3)
    assert np.abs(found.gradient).max() < 2.0


@pytest.mark.parametrize("pushed", [True, False])
def test_stones_that_help_and_hinder(pushed):
    direction = (1, 0, 0)
    for asm in (arch(12, 0.2), running_bond(5, 4)):
        limit = limit_load(asm, direction)
        found = stone_sensitivity(limit, direction, pushed=pushed)
        assert (found[asm.support] == 0).all()
        for block in asm.free[::5]:
            step = 1e-3 * asm.mass[block]
            ends = []
            for sign in (1, -1):
                density = asm.density.copy()
                density[block] += sign * step / asm.volume[block]
                heavier = asm.with_(density=density)
                load = direction if pushed else acceleration(asm, direction)
                ends.append(limit_load(heavier, load))
            slope = (middle(ends[0]) - middle(ends[1])) / (2 * step)
            # The difference is no better than the brackets of its ends.
            width = sum(end.upper - end.lower for end in ends) / (2 * step)
            assert found[block] == pytest.approx(slope, rel=1e-3, abs=1e-5 + width)


def test_a_stone_on_a_tower():
    # A tower of n unit cubes and a mass m at height z tip at lambda = (n + m) / 2 / (n^2 / 2 + m z).
    tower = stack(4, friction=2.0)
    found = stone_sensitivity(limit_load(tower, (1, 0, 0)), (1, 0, 0))
    expected = [0.0] + [0.5 / 8 - 2 * z / 8**2 for z in (0.5, 1.5, 2.5, 3.5)]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_more_of_every_stone_changes_nothing():
    # With all masses the limit acceleration stays what it is.
    limit = limit_load(arch(12, 0.2), (1, 0, 0))
    helped = stone_sensitivity(limit, (1, 0, 0)) * limit.assembly.mass
    assert helped.sum() == pytest.approx(0.0, abs=1e-6 * np.abs(helped).sum())
    assert (helped > 0).any()
    assert (helped < 0).any()


def test_what_has_no_derivative():
    limit = limit_load(arch(12, 0.2), (1, 0, 0))
    with pytest.raises(InputError, match="not that of this load"):
        limit_load_by_point(limit, (0, 0, 1))
    with pytest.raises(InputError, match="no limit load to differentiate"):
        stone_sensitivity(limit_load(arch(12, 0.05), (1, 0, 0)), (1, 0, 0))
    for strength in ({"tension": 0.01}, {"bond": 0.01}):
        mortar = arch(12, 0.2).with_(joints=[JointLaw(("*", "*"), **strength)])
        with pytest.raises(InputError, match="joints with strengths or bonds, which are shared by area"):
            limit_load_by_point(limit_load(mortar, (1, 0, 0)), (1, 0, 0))
    with pytest.raises(InputError, match="the score is infinite"):
        score_by_point(assess(assembly([box((0, 0, 0), (1, 1, 1)), box((5, 0, 0), (6, 1, 1))])))


def test_a_pillar_with_a_tie_has_derivatives_by_its_corners_and_its_mass():
    """The limit is b / h + 2 F z / (W h); the tie stays at its height z where the pillar grows, and W goes with b h."""
    asm = tied({"width": 0.6, "height": 2.0}, 2000.0)
    weight = float(np.linalg.norm(asm.gravity)) * asm.mass[1]
    gain = 2 * 2000.0 * 1.6 / (weight * 2.0)
    limit = limit_load(asm, (1, 0, 0), optimum=True)
    found = limit_load_by_point(limit, (1, 0, 0))
    assert found.value == pytest.approx(0.3 + gain, rel=1e-6)
    top, right = (np.isclose(found.points[:, axis], end) for axis, end in ((2, 2.0), (0, 0.6)))
    assert found.along(np.where(top[:, None], [0, 0, 1.0], 0.0)) == pytest.approx(-0.15 - gain, rel=1e-6)
    assert found.along(np.where(right[:, None], [1.0, 0, 0], 0.0)) == pytest.approx(0.5 - gain / 0.6, rel=1e-6)
    stone = stone_sensitivity(limit, (1, 0, 0))
    assert stone == pytest.approx([0.0, -gain / asm.mass[1]], rel=1e-6)
    with pytest.raises(InputError, match="not that of this load"):
        stone_sensitivity(limit, (0, 1, 0))


def test_a_score_with_a_tie_changes_with_the_corners_as_whole_solves_do():
    asm = tied({"width": 0.3, "height": 2.0}, 3000.0)
    asm = asm.with_(ties=[replace(asm.ties[0], points=((-3, 0.25, 1.6), (0.1, 0.25, 1.6)), least=3000.0)])
    verdict = assess(asm)
    found = score_by_point(verdict)
    motion = found.points @ np.random.default_rng(4).normal(size=(3, 3)) / 2
    ends = [assess(moved(asm, found, sign * 1e-4 * motion)).score for sign in (1, -1)]
    assert verdict.score > 1
    assert found.along(motion) == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-5)


def test_mass_on_a_block_with_a_bond_at_its_foot():
    """A bond holds the moment M and, about the toe, F b / 2 as well: the limit is b / h + 2 (M + F b / 2) / (W h)."""
    law = JointLaw(("*", "*"), bond=500.0, bond_moment=80.0)
    asm = tied({"width": 0.6, "height": 2.0}, 0.0).with_(joints=[law], ties=[])
    limit = limit_load(asm, (1, 0, 0), optimum=True)
    gain = 2 * (80.0 + 500.0 * 0.3) / (float(np.linalg.norm(asm.gravity)) * asm.mass[1] * 2.0)
    assert limit.lower == pytest.approx(0.3 + gain, rel=1e-6)
    assert stone_sensitivity(limit, (1, 0, 0)) == pytest.approx([0.0, -gain / asm.mass[1]], rel=1e-6)
