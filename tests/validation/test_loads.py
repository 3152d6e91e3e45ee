"""Loads beside the weight, ties, tendons and the linear code check.

Expected values come from closed forms, from moments about hinges, and from planar linear programs.
"""

import numpy as np
import pytest
from scipy.optimize import linprog

from blockstat import (
    Assembly,
    Floor,
    InputError,
    JointLaw,
    Outcome,
    Site,
    Tie,
    acceleration,
    assess,
    box,
    dispersed_load,
    fill_load,
    fluid_pressure,
    limit_load,
    line_load,
    linear_check,
    moving_load,
    patch_load,
    point_load,
    side_wall_friction,
    surface_load,
    tendon_load,
    tie_gain,
    tie_range,
)
from evidence.scenes.arches import barrel_on_piers
from evidence.scenes.small import arch

CLOSE = 1e-6


def value(found, rel=CLOSE):
    assert found.upper - found.lower <= rel * max(found.upper, 1.0)
    return (found.lower + found.upper) / 2


def on_ground(*blocks, friction=0.7):
    ground = box((-9, -9, -1), (9, 9, 0), name="ground")
    return Assembly.from_blocks(
        [ground, *blocks], supports=["ground"], friction=friction, density=1.0, gravity=(0, 0, -1)
    )


@pytest.mark.parametrize(("e", "expected"), [(0.0, (5 / 3, 1.25, 0.3125)), (0.1, (4.4 / 3, 1.1, 0.275))])
def test_a_block_under_a_dead_load_is_pushed_at_a_point_and_by_body_forces(e, expected):
    # b 1, h 2, W 2, N 3 at e towards the toe, mu .5: min(mu (W + N), M / z), 2 M / (W h), M / (W h / 2 + N h).
    asm = on_ground(box((0, 0, 0), (1, 1, 2), name="block"), friction=0.5)
    dead = point_load(asm, "block", (0.5 + e, 0.5, 2), (0, 0, -3))
    push = point_load(asm, "block", (0, 0.5, 1.5), (1, 0, 0))
    body = acceleration(asm, (1, 0, 0))
    both = body + point_load(asm, "block", (0.5, 0.5, 2), (3, 0, 0))
    found = [value(limit_load(asm, load, loads=dead)) for load in (push, body, both)]
    assert found == pytest.approx(expected, rel=CLOSE)


FACES = {4: (1.888766941, 4.128460646), 6: (0.360223187, 0.804019906), 9: (0.264629197, 0.650634819)}
CORNERS = {4: (10.256791581, 21.325664057), 6: (0.434935993, 0.958474767), 9: (0.196628703, 0.477431484)}


@pytest.mark.parametrize("voussoir", [4, 6, 9])
def test_a_point_load_on_an_arch_with_and_without_fill(voussoir):
    asm = arch(20, 0.2)
    weight = float(asm.density[-1] * np.linalg.norm(asm.gravity))
    depth = float(np.ptp(asm.bounds[0][:, 1])) or 0.5
    fill = fill_load(asm, 1.3, 0.8 * weight)
    assert -fill[:, 2].sum() / (weight * depth) == pytest.approx(0.773714378, rel=1e-8)
    name = f"voussoir{voussoir}"
    corners = asm.block_vertices(asm.names.index(name))
    outer = corners[np.linalg.norm(corners[:, [0, 2]], axis=1) > 1.0]
    left = outer[np.isclose(outer[:, 0], outer[:, 0].min())].mean(axis=0)
    for point, expected in ((outer.mean(axis=0), FACES[voussoir]), (left, CORNERS[voussoir])):
        load = point_load(asm, name, point, (0, 0, -weight * depth))
        found = [value(limit_load(asm, load, loads=loads, friction=0.7)) for loads in (None, fill)]
        assert found == pytest.approx(expected, rel=CLOSE)


def test_a_wheel_on_an_arch_is_worst_at_a_joint_and_the_sweep_of_faces_misses_it():
    asm = arch(20, 0.2)
    weight, y = float(asm.density[-1]) * 0.5, 0.25
    found = moving_load(asm, [(0, weight)], [(-0.9, y, 1.5), (0, y, 1.5)], friction=0.7, tolerance=1e-7, positions=20)
    k = found.worst
    assert found.upper[k] == pytest.approx(0.196628703, rel=CLOSE)
    assert found.place[k] - 0.9 == pytest.approx(-0.172078, abs=1e-6)
    bounded = np.isfinite(found.upper)
    assert (found.upper[bounded] - found.lower[bounded] <= 1e-6 * found.upper[bounded]).all()
    coarse = moving_load(
        asm, [(0, weight)], [(-0.9, y, 1.5), (0, y, 1.5)], friction=0.7, tolerance=1e-4, positions=20, joints=False
    )
    assert coarse.upper.min() > 0.1967
    for place, lower, upper in zip(coarse.place, coarse.lower, coarse.upper, strict=True):
        same = np.isclose(found.place, place)
        assert not same.any() or (lower <= found.upper[same].max() * (1 + 1e-9) and upper >= found.lower[same].min())


def portal(least=0.0, greatest=np.inf):
    ends = ((-2.25, 0.5, 2.5), (2.25, 0.5, 2.5))
    asm = barrel_on_piers(0.6, 2.5)
    unit = float(asm.density[-1] * np.linalg.norm(asm.gravity))
    return asm.with_(ties=[Tie(("pier-1", "pier1"), ends, least * unit, greatest * unit)]), unit


def test_a_tie_holds_a_portal_between_its_least_and_its_greatest_force():
    # T_min = max_j [H_j z_I - W1 (x_T - x_I) - W2 (x_T - x_2)] / h by moments of half an arch.
    asm, unit = portal()
    assert assess(asm.with_(ties=())).outcome is Outcome.UNSTABLE
    found = tie_range(asm)
    assert found.least / unit == pytest.approx(0.104038567, rel=CLOSE)
    assert found.greatest / unit == pytest.approx(1.569570531, rel=CLOSE)
    for factor, outcome in ((1 - 1e-5, Outcome.UNSTABLE), (1 + 1e-5, Outcome.STABLE)):
        verdict = assess(portal(0.0, factor * 0.104038567)[0])
        assert verdict.outcome is outcome
    assert verdict.ties is not None
    assert verdict.ties[0] / unit == pytest.approx(0.104038567, rel=2e-5)


def planar_portal(greatest, least=0.0, mu=0.7):
    """The same portal as a linear program of its own: three equations a block, two half-planes a corner."""
    n, inner, outer, width, height = 20, 2.25, 2.75, 0.6, 2.5
    angle = np.linspace(np.pi, 0, n + 1)
    ring = np.array([[(r * np.cos(a), height + r * np.sin(a)) for r in (inner, outer)] for a in angle])
    left = np.array([(-inner - width, 0), (-inner, 0), (-inner, height), (-inner - width, height)])
    solids = [left, *(np.array([ring[k, 0], ring[k, 1], ring[k + 1, 1], ring[k + 1, 0]]) for k in range(n))]
    solids.append(left * [-1, 1])
    area, centre = zip(*(_area(corners) for corners in solids), strict=True)
    joints = [(-1, 0, left[0], left[1]), *((k, k + 1, *ring[k]) for k in range(n + 1))]
    joints.append((n + 1, -1, -left[1] * [1, -1], -left[0] * [1, -1]))
    columns = []

    def column(actions):
        entries = np.zeros((n + 2, 3))
        for block, point, force in actions:
            if block >= 0:
                arm = np.asarray(point) - centre[block]
                entries[block] += (*force, arm[0] * force[1] - arm[1] * force[0])
        columns.append(entries.reshape(-1))

    for a, b, p, q in joints:
        along = (q - p) / np.linalg.norm(q - p)
        normal = np.array([-along[1], along[0]])
        away = centre[b] - (p + q) / 2 if b >= 0 else (p + q) / 2 - centre[a]
        normal = normal if normal @ away > 0 else -normal
        for point in (p, q):
            for sign in (mu, -mu):
                force = normal + sign * along
                column([(a, point, -force), (b, point, force)])
    column([(0, left[2], np.array([1.0, 0])), (n + 1, left[2] * [-1, 1], np.array([-1.0, 0]))])
    load, dead = np.zeros((n + 2, 3)), np.zeros((n + 2, 3))
    load[:, 0], dead[:, 1] = area, np.negative(area)
    matrix = np.column_stack([*columns, load.reshape(-1)])
    bounds = [(0, None)] * (len(columns) - 1) + [(least, greatest), (None, None)]
    cost = np.zeros(matrix.shape[1])
    cost[-1] = -1
    return -linprog(cost, A_eq=matrix, b_eq=-dead.reshape(-1), bounds=bounds, method="highs").fun


def _area(corners):
    x, y = corners.T
    after = np.roll(corners, -1, axis=0).T
    cross = x * after[1] - after[0] * y
    return abs(cross.sum() / 2), np.array([((x + after[0]) * cross).sum(), ((y + after[1]) * cross).sum()]) / (
        3 * cross.sum()
    )


@pytest.mark.parametrize("greatest", [0.2156775, 0.36598887, 0.54044931, 0.71593253, 0.75126198, 0.94717523, 2.0])
def test_the_limit_load_grows_with_the_strength_of_a_tie(greatest):
    assert value(limit_load(portal(0.0, greatest)[0], (1, 0, 0))) == pytest.approx(planar_portal(greatest), rel=CLOSE)


def test_pretension_is_worthless_and_a_constant_force_is_no_tie():
    slack, tight = (value(limit_load(portal(least, 0.3)[0], (1, 0, 0))) for least in (0.0, 0.2))
    assert [slack, tight] == pytest.approx([planar_portal(0.3), planar_portal(0.3, 0.2)], rel=CLOSE)
    assert planar_portal(0.3, 0.2) == pytest.approx(planar_portal(0.3), rel=1e-9)
    assert value(limit_load(portal(1.0, 1.0)[0], (1, 0, 0))) == pytest.approx(planar_portal(1.0, 1.0), rel=CLOSE)
    assert planar_portal(1.0, 1.0) < planar_portal(1.0) * (1 - 1e-3)
    assert assess(portal(2.0, 2.0)[0]).outcome is Outcome.UNSTABLE


def test_the_greatest_useful_force_and_the_gain_of_a_tie():
    asm, unit = portal()
    limit = limit_load(asm, (1, 0, 0))
    assert value(limit) == pytest.approx(planar_portal(np.inf), rel=CLOSE)
    useful = tie_range(asm, loads=(1 - 1e-9) * limit.lower * acceleration(asm, (1, 0, 0))).least / unit
    assert planar_portal(useful) == pytest.approx(planar_portal(np.inf), rel=1e-7)
    assert planar_portal(0.999 * useful) < planar_portal(np.inf) * (1 - 1e-5)
    weaker = limit_load(portal(0.0, 0.2)[0], (1, 0, 0))
    slope = (planar_portal(0.201) - planar_portal(0.2)) / 0.001
    assert tie_gain(weaker, (1, 0, 0), asm.ties)[0] * unit == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("height", [0.5, 1.0, 2.0])
def test_the_gain_of_a_tie_up_to_a_force(height):
    """The foot of a pillar slides away under a tie off its centroid, before the pillar tips about its edge.

    A pillar of b x h = 0.5 x 2 with its weight W = 1 and a tie of F = 2 at the height z. About its edge:
    a h/2 = b/2 + F z. About the tie, with full friction at the foot: a |h/2 - z| = b/2 + mu z.
    """
    friction, force = 0.7, 2.0
    blocks = [box((-4, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="pillar")]
    pillar = Assembly.from_blocks(blocks, supports=["ground"], density=1 / 9.81, friction=friction)
    tie = Tie(("ground", "pillar"), ((-4, 0.5, height), (0, 0.5, height)))
    limit = limit_load(pillar, (1, 0, 0))
    off = abs(1.0 - height)
    tips, slides = 0.25 + force * height, (0.25 + friction * height) / off if off else np.inf
    assert value(limit) == pytest.approx(0.25, rel=CLOSE)
    found = tie_gain(limit, (1, 0, 0), [tie], force=force)
    assert found[0] == pytest.approx((min(tips, slides) - 0.25) / force, rel=1e-6)
    assert found[0] <= tie_gain(limit, (1, 0, 0), [tie])[0] * (1 + 1e-6)
    with pytest.raises(InputError, match="force is 0"):
        tie_gain(limit, (1, 0, 0), [tie], force=0)


def test_the_tie_of_a_verdict_without_dilatancy_balances_its_forces():
    """Beside the ground's, only the tie acts along it: what the contacts push back is its tension."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    tie = Tie(("ground", "slab"), ((0.5, -4, 2), (0.5, 0, 2)), greatest=1000.0)
    held = Assembly.from_blocks(blocks, supports=["ground"], density=2000.0, ties=[tie])
    found = assess(held, flow="coulomb")
    assert found.outcome is Outcome.STABLE
    across = np.einsum("pi,pij->j", found.forces, found.interfaces.frame[found.interfaces.point_interface])[1]
    assert abs(across) == pytest.approx(found.ties[0], abs=1e-6 * held.free_weight)


@pytest.mark.parametrize("mu", [0.7, 0.3])
@pytest.mark.parametrize("force", [0.5, 1.0, 4.0])
def test_a_tendon_presses_a_stack_together(mu, force):
    # min over joints, W_k above, h_k high: (W_k b/2 + F b/2) / (W_k h_k / 2) and mu (W_k + F) / W_k.
    b, a, n = 0.5, 0.25, 8
    asm = on_ground(*(box((0, 0, k * a), (b, 1, (k + 1) * a), name=f"b{k}") for k in range(n)), friction=mu)
    total = asm.free_weight
    above = total / n * np.arange(1, n + 1)
    high = a * np.arange(1, n + 1)
    pull = force * total
    expected = np.minimum((above + pull) * b / (above * high), mu * (above + pull) / above).min()
    loads = tendon_load(asm, ["b7", "ground"], [(b / 2, 0.5, 2.0), (b / 2, 0.5, 0.0)], pull)
    assert value(limit_load(asm, (1, 0, 0), loads=loads)) == pytest.approx(expected, rel=CLOSE)
    if force == 1.0 and mu == 0.7:
        aside = tendon_load(asm, ["b7", "ground"], [(0.35, 0.5, 2.0), (0.35, 0.5, 0.0)], pull)
        assert value(limit_load(asm, (1, 0, 0), loads=aside)) == pytest.approx(0.4, rel=CLOSE)
        assert value(limit_load(asm, (-1, 0, 0), loads=aside)) == pytest.approx(0.6, rel=CLOSE)


def test_a_squeezed_row_carries_itself():
    # n 10, L 5, h .5, mu .7, c0 .1, F at mid height: F (h - z) / (q (L (x - c0) / 2 - x^2 / 2)) at x = 2.5.
    n, length, h, c0 = 10, 5.0, 0.5, 0.1
    row = [box((k * length / n, 0, 0), ((k + 1) * length / n, 1, h), name=f"b{k}") for k in range(n)]
    ends = [box((0, 0, -1), (c0, 1, 0), name="left"), box((length - c0, 0, -1), (length, 1, 0), name="right")]
    blocks = [*row, *ends]
    groups = [
        type(block)(block.vertices, block.faces, block.name, "row" if i < n else "bearing")
        for i, block in enumerate(blocks)
    ]
    asm = Assembly.from_blocks(
        groups, supports=["left", "right"], friction=0.7, density=1.0, gravity=(0, 0, -1),
        joints=[JointLaw(("row", "bearing"), friction=0.0)],
    )  # fmt: skip
    for force, mu, expected in ((5.0, 0.7, 0.869565217), (10.0, 0.1, 1.0)):
        squeeze = tendon_load(asm, ["b0", "b9"], [(0, 0.5, h / 2), (length, 0.5, h / 2)], force)
        weight = acceleration(asm, (0, 0, -1))
        found = limit_load(asm, weight, loads=squeeze - weight, friction=mu)
        assert value(found) == pytest.approx(expected, rel=CLOSE)


def test_a_monolith_in_shear_under_a_beam():
    # A beam that may turn: V = (N + W_b + W) L / (2 H0) at the centroid of the beam.
    asm = on_ground(
        box((0, 0, 0), (1, 0.2, 1.2), name="wall"), box((0, 0, 1.2), (1, 0.2, 1.45), name="beam"), friction=0.65
    )
    dead = point_load(asm, "beam", (0.5, 0.1, 1.45), (0, 0, -1.6))
    push = point_load(asm, "beam", (0.5, 0.1, 1.325), (1, 0, 0))
    expected = (1.6 + asm.free_weight) / (2 * 1.325)
    assert value(limit_load(asm, push, loads=dead)) == pytest.approx(expected, rel=CLOSE)


def test_pressure_fill_and_dispersion_are_exact_integrals():
    asm = on_ground(box((0, 0, 0), (1, 2, 3), name="dam"))
    water = fluid_pressure(asm, 2.0, 10.0, (-1, 0, 0))[1]
    assert water[0] == pytest.approx(10 * 2**2 / 2 * 2)
    assert water[4] == pytest.approx(water[0] * (2 / 3 - 1.5))
    earth = fluid_pressure(asm, 2.0, 10.0, (-1, 0, 0), coefficient=0.3, surcharge=5.0)[1]
    assert earth[0] == pytest.approx(0.3 * (10 * 2**2 / 2 + 5 * 2) * 2)
    spread = dispersed_load(asm, (0.5, 1.0, 3.2), 7.0, spread=0.5)[1]
    assert spread == pytest.approx([0, 0, -7, 0, 0, 0], abs=1e-12)
    aside = dispersed_load(asm, (0.1, 1.0, 3.2), 7.0, spread=0.5)[1]  # [0, .2] x .2 of it lie on the block
    assert aside == pytest.approx([0, 0, -7, 0, 7 * (0.1 - 0.5), 0], abs=1e-9)
    lines = line_load(asm, (0, 0, 3), (0, 2, 3), (0, 0, -4))[1]
    assert lines == pytest.approx([0, 0, -8, 0, -4.0, 0], abs=1e-12)


def test_a_joint_takes_its_part_out_of_a_surface():
    asm = on_ground(box((0, 0, 0), (2, 1, 1), name="low"), box((0, 0, 1), (1, 1, 2), name="high"))
    load = surface_load(asm, (0, 0, -3), (0, 0, 1))
    assert load[1] == pytest.approx([0, 0, -3, 0, 1.5, 0], abs=1e-12)
    assert load[2] == pytest.approx([0, 0, -3, 0, 0, 0], abs=1e-12)
    with pytest.raises(InputError, match=r"0\.5 of 0\.6 m2 of the patch lie on free faces \(of low\)"):
        patch_load(asm, [(0.9, 0, 1), (1.5, 0, 1), (1.5, 1, 1), (0.9, 1, 1)], (0, 0, -1))


def test_inertia_that_grows_with_the_height_has_the_moment_of_a_triangle():
    asm = on_ground(box((0, 0, 0), (1, 1, 3), name="wall"))
    load = acceleration(asm, (1, 0, 0), profile=[(0, 0), (3, 1)])[1]
    weight = asm.free_weight
    assert load[0] == pytest.approx(weight / 2)
    assert load[4] + 1.5 * load[0] == pytest.approx(weight / 2 * 2.0)  # about the foot: at two thirds of the height


def test_a_point_off_its_block_is_refused_by_name():
    asm = on_ground(box((0, 0, 0), (1, 1, 2), name="block"))
    with pytest.raises(InputError, match=r'point \[1\.2, 0\.5, 1\.0\] is not on block "block"'):
        point_load(asm, "block", (1.2, 0.5, 1.0), (1, 0, 0))
    with pytest.raises(InputError, match=r'tie "long": the point .* is not on block "block"'):
        assess(asm.with_(ties=[Tie(("block", "ground"), ((0, 0, 3), (0, 5, 0)), name="long")]))


@pytest.mark.parametrize("courses", [1, 2, 4])
def test_courses_that_turn_as_one_count_as_one_body_in_the_code_check(courses):
    # Circolare 7/2019, C8.7.1.2.1: wall 4 x .5, soil B. Counted one by one, four courses would give e* = .761905.
    blocks = [box((0, 0, 4 * k / courses), (0.5, 3, 4 * (k + 1) / courses), name=f"c{k}") for k in range(courses)]
    found = linear_check(limit_load(on_ground(*blocks), (1, 0, 0)), (1, 0, 0), site=Site("B", 2.5, 0.3))
    assert found.participation == pytest.approx(1.0, rel=CLOSE)
    assert found.acceleration == pytest.approx(0.125 * 9.81 / 1.35, rel=CLOSE)
    assert found.ag_damage == pytest.approx(0.077160, rel=1e-5)
    assert found.ag_life == pytest.approx(2 * 0.077160, rel=1e-5)


@pytest.mark.parametrize(("thrust", "alpha0", "acceleration_", "ag"), [
    (0.0, 0.070351393, 0.511220, 0.043427), (15.0, 0.047356984, 0.344127, 0.029233)])  # fmt: skip
def test_the_hand_example_of_a_facade(thrust, alpha0, acceleration_, ag):
    # A facade of three strips 6 m wide with floor, roof, a mass without weight and the thrust of a vault [kN].
    gable = box((0, 0, 6.8), (0.4, 6, 8.9))
    triangle = [(0, 0, 6.8), (0, 6, 6.8), (0, 3, 8.9), (0.4, 0, 6.8), (0.4, 6, 6.8), (0.4, 3, 8.9)]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
    blocks = [
        box((0, 0, 0), (0.6, 6, 3.6), name="low"), box((0, 0, 3.6), (0.5, 6, 6.8), name="high"),
        type(gable)(triangle, faces, name="gable"),
    ]  # fmt: skip
    ground = box((-2, -1, -1), (2, 7, 0), name="ground")
    asm = Assembly.from_blocks([ground, *blocks], supports=["ground"], density=18.0, gravity=(0, 0, -1), friction=10.0)
    floor, roof, mass = (0.45, 3, 3.6), (0.35, 3, 6.8), (0.35, 3, 6.8)
    dead = point_load(asm, "low", floor, (0, 0, -36)) + point_load(asm, "high", roof, (0, 0, -24))
    dead = dead + point_load(asm, "low", (0.6, 3, 3.2), (-thrust, 0, 0))
    live = acceleration(asm, (-1, 0, 0))
    for block, point, weight in (("low", floor, 36), ("high", roof, 24), ("high", mass, 20)):
        live = live + point_load(asm, block, point, (-weight, 0, 0))
    limit = limit_load(asm, live, loads=dead)
    assert value(limit) == pytest.approx(alpha0, rel=CLOSE)
    heavy = [("low", floor, 36 * 9.81), ("high", roof, 24 * 9.81), ("high", mass, 20 * 9.81)]
    found = linear_check(limit, (-1, 0, 0), site=Site("B"), masses=heavy)
    assert len(found.bodies) == 1
    assert found.acceleration == pytest.approx(acceleration_, rel=2e-6)
    assert found.ag_damage == pytest.approx(ag, rel=2e-5)
    assert found.ag_life == pytest.approx(2 * ag, rel=2e-5)


def test_a_bell_gable_on_a_building():
    # T0/T1 = .62, m = 1.1 / sqrt(.05): a_g .011301 at SLD, twice that with q = 2; soil A.
    wall = on_ground(box((0, 0, 0), (0.5, 3, 3), name="gable"))
    floor = Floor(period=0.05 * 10**0.75, own_period=0.174556213, gamma=1.2)
    found = linear_check(limit_load(wall, (1, 0, 0)), (1, 0, 0), site=Site("A"), floor=floor)
    assert found.acceleration == pytest.approx(1.211111, rel=1e-6)
    assert found.ag_damage == pytest.approx(0.011301, rel=5e-5)
    assert found.ag_life == pytest.approx(0.022603, rel=5e-5)


def test_friction_of_side_walls_by_the_code_is_four_fifths_of_the_sum_over_the_joints():
    # Circolare 7/2019, C8.7.1.2.1, with Phi = h / l = 1.2, which may be given: the k-th joint bears k courses.
    wall = {"height": 0.3, "overlap": 0.25, "thickness": 0.5, "unit_weight": 18.0, "friction": 0.577}
    for courses in (5, 12):
        joints = [0.577 * (k * 0.3 * 0.25 * 0.5 * 18.0) for k in range(1, courses + 1)]
        assert side_wall_friction(courses=courses, **wall) == pytest.approx(0.8 * sum(joints))
        assert side_wall_friction(courses=courses, phi=0.6, **wall) == pytest.approx(0.8 * sum(joints) * 0.6 / 1.2)
        assert side_wall_friction(courses=np.int64(courses), **wall) == side_wall_friction(courses=courses, **wall)
    for key in wall:
        for value in (0.0, "1", None):
            with pytest.raises(InputError, match=f"{key} is {value!r}; it must be above 0"):
                side_wall_friction(courses=12, **{**wall, key: value})
    with pytest.raises(InputError, match="courses is 0"):
        side_wall_friction(courses=0, **wall)


def test_the_envelope_alone_has_the_worst_place_of_the_whole_line_and_all_places_carry_as_much():
    asm = arch(20, 0.2)
    weight, y = float(asm.density[-1]) * 0.5, 0.25
    train = [(0, weight), (0.2, weight)], [(-0.9, y, 1.5), (0.9, y, 1.5)]
    whole = moving_load(asm, *train, friction=0.7, tolerance=1e-4, positions=15)
    alone = moving_load(asm, *train, friction=0.7, tolerance=1e-4, positions=15, only_worst=True)
    least = whole.upper.min()
    assert alone.upper[alone.worst] == pytest.approx(least, rel=2e-4)
    assert (alone.lower >= least * (1 - 3e-4)).all()
    assert (alone.lower <= whole.upper * (1 + 1e-9)).all()
    assert (alone.upper >= whole.lower * (1 - 1e-9)).all()
    assert alone.solves < whole.solves
    for k in (0, 7, len(alone.place) - 1):
        # Bounds at a place from a program of its own.
        load = train_at(asm, *train, alone.place[k], alone.side[k])
        if load.any() and np.isfinite(alone.lower[k]):
            assert limit_load(asm, load, friction=0.7, tolerance=1e-6).upper >= alone.lower[k] * (1 - 1e-9)


def train_at(asm, axles, path, place, side):
    from blockstat.contact.interfaces import find_interfaces
    from blockstat.loading.faces import selected
    from blockstat.loading.on_faces import facing
    from blockstat.loads import up_of
    from blockstat.traffic.places import road_along, train_loads

    faces = facing(asm, selected(asm, None, None), up_of(asm), find_interfaces(asm))
    road = road_along(asm, path, faces)
    return train_loads(road, np.array(axles), np.array([place]), np.array([side]), spread=None, footprint=(0, 0))[0]
