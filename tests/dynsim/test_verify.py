"""Bullet against closed forms, and the verdict's own figures. Wider accuracy tables are made by the benchmarks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Block, InputError, find_interfaces
from dynsim import DynamicOutcome, Settings, simulate, verify
from evidence.scenes.small import arch, assembly, box, running_bond, stack

STANDS, FALLS = DynamicOutcome.STANDS, DynamicOutcome.FALLS


def turned(asm, rotation):
    """The same scene, blocks and gravity rotated together."""
    return asm.with_(vertices=asm.vertices @ rotation.T, gravity=rotation @ asm.gravity)


def wedged(asm):
    """The same blocks with one corner cut off the ground, so that all shapes are hulls instead of boxes."""
    ground = box((-5, -5, -1), (5, 5, 0))
    vertices = ground.vertices.astype(float).copy()
    vertices[0] += [0.1, 0.1, 0.05]
    blocks = [Block(asm.block_vertices(i), asm.faces_of(i), asm.names[i]) for i in range(1, asm.n_blocks)]
    faces = []
    for face in ground.faces:
        faces += [[face[0], face[1], face[2]], [face[0], face[2], face[3]]] if 0 in face else [face]
    return assembly([Block(vertices, faces, "ground"), *blocks], gravity=asm.gravity)


@pytest.mark.parametrize("shape", ["boxes", "hulls"])
def test_tipping_of_a_block(shape):
    asm = stack(1, 0.5, 2.0)
    asm = wedged(asm) if shape == "hulls" else asm
    assert verify(asm.with_(gravity=(0.25 * 0.998, 0, -1))).outcome is STANDS
    assert verify(asm.with_(gravity=(0.25 * 1.002, 0, -1))).outcome is FALLS


def test_arch_thickness_on_both_sides_of_its_limit():
    # 15 straight-sided voussoirs: t/R = .1070 by static bisection; 4 % on each side.
    assert verify(arch(15, 0.107 * 1.04)).outcome is STANDS
    assert verify(arch(15, 0.107 * 0.96)).outcome is FALLS


def test_wall_out_of_plane_on_both_sides_of_its_limit():
    # A free-standing wall of thickness t and height H tips at t / H.
    asm = running_bond(6, 3)
    limit = 0.2 / (6 * 0.175)
    assert verify(asm.with_(gravity=(0, 0.97 * limit, -1))).outcome is STANDS
    assert verify(asm.with_(gravity=(0, 1.03 * limit, -1))).outcome is FALLS


def test_incline_slide_follows_the_closed_form():
    # s = 1/2 g (sin th - mu cos th) t^2, on a plane of 40 degrees with mu = .5; acceleration within 2 %.
    angle, mu, g = np.deg2rad(40), 0.5, 9.81
    asm = assembly([box((-9, -9, -1), (9, 9, 0), name="ground"), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2))], friction=mu)
    run = simulate(asm.with_(gravity=(g * np.sin(angle), 0, -g * np.cos(angle))), settings=Settings(end=1.0))
    moved = run.since_release[:, 1, 0]
    late = run.times > 0.3
    expected = 0.5 * g * (np.sin(angle) - mu * np.cos(angle)) * run.times[late] ** 2
    np.testing.assert_allclose(moved[late], expected, rtol=0.02)


@pytest.mark.parametrize(("length", "strength", "density"), [(1e-3, 1.0, 1.0), (1e3, 1.0, 1.0), (1.0, 1e-2, 1e4)])
def test_units_change_nothing(length, strength, density):
    for factor, outcome in ((1.04, STANDS), (0.96, FALLS)):
        asm = arch(15, 0.107 * factor)
        other = asm.with_(vertices=length * asm.vertices, gravity=strength * asm.gravity, density=density * asm.density)
        a, b = verify(asm), verify(other)
        assert a.outcome is b.outcome is outcome
        assert b.brick_threshold == pytest.approx(a.brick_threshold * length)
        if outcome is STANDS:  # what shaking is left at rest is rounding and differs
            assert max(b.max_displacement / length, a.max_displacement) < 0.25 * a.brick_threshold
        else:
            assert b.max_displacement / length == pytest.approx(a.max_displacement, rel=0.2)
            assert b.first_time == pytest.approx(a.first_time * np.sqrt(length / strength), rel=0.1)


def test_rotating_the_whole_scene_changes_nothing():
    rotation = Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix()
    for push, outcome in ((0.24, STANDS), (0.26, FALLS)):
        assert verify(turned(stack(1, 0.5, 2.0, gravity=(push, 0, -1)), rotation)).outcome is outcome


def test_the_same_input_gives_the_same_run():
    asm = arch(9, 0.1)
    one, two = verify(asm).run, verify(asm).run
    np.testing.assert_array_equal(one.displacement, two.displacement)


def test_equations_look_down_and_the_displacement_looks_everywhere():
    # A block that slides on level ground does not drop; it has moved all the same.
    asm = assembly([box((-5, -5, -1), (5, 5, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2), name="slab")], friction=0.2)
    verdict = verify(asm.with_(gravity=(0.4, 0, -1)))
    down = asm.with_(gravity=(0.4, 0, -1)).gravity
    assert verdict.outcome is FALLS
    assert verdict.first_block == "slab"
    along = verdict.displacement[1]
    assert along[0] > 0.99 * verdict.max_displacement
    assert verdict.max_drop == pytest.approx(along @ down / np.linalg.norm(down), rel=1e-9)
    assert verdict.max_drop < 0.5 * verdict.max_displacement


def test_equation_one_is_about_the_group():
    blocks = [
        box((-5, -5, -1), (5, 5, 0)),
        box((0, 0, 0), (1, 1, 1), group="vault.a"),
        box((3, 0, 2), (4, 1, 3), name="loose"),
    ]
    verdict = verify(assembly(blocks))
    assert (verdict.outcome, verdict.group, verdict.first_block) == (FALLS, "vault", "loose")
    assert verdict.passes_eq1
    assert not verdict.passes_eq2
    whole = verify(assembly(blocks), settings=Settings(brick_threshold=0.5, roof_threshold=0.5))
    assert whole.max_displacement >= 0.5
    with pytest.raises(InputError, match=r'no group "roof"; groups are: vault\.a'):
        verify(assembly(blocks), settings=Settings(group="roof"))


def test_a_loose_block_falls_freely():
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 1, 1))], gravity=(0, 0, -9.81))
    run = simulate(asm, settings=Settings(end=1.0))
    drop = -run.since_release[:, 1, 2]
    # The last damped step leaves the velocity of one step: 3 dt / t, about 1 % at the first of these times.
    late = run.times > 0.5
    np.testing.assert_allclose(drop[late], 0.5 * 9.81 * run.times[late] ** 2, rtol=0.012)


def test_a_concave_block_is_cut_and_holds_what_lies_in_its_notch():
    plan = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    n = len(plan)
    faces = [
        list(range(n)),
        list(range(n, 2 * n))[::-1],
        *([i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)),
    ]
    # The profile stands upright: a U holding a ball-like cube between its arms.
    u = Block([(x, y, z) for y in (0, 1) for x, z in plan], faces, "u")
    asm = assembly([box((-5, -5, -1), (5, 5, 0)), u, box((1.01, 0, 1), (1.99, 1, 2), name="cube")])
    verdict = verify(asm)
    assert verdict.outcome is STANDS
    assert verdict.max_displacement < 1e-3
    assert verdict.run.initial_overlap < 1e-4


@pytest.mark.parametrize(
    "bad",
    [
        {"time_step": 0},
        {"iterations": 0},
        {"end": float("nan")},
        {"look_every": 9.0},
        {"brick_threshold": -1.0},
    ],
)
def test_bad_settings(bad):
    with pytest.raises(InputError, match="settings:"):
        Settings(**bad)


def test_nothing_to_simulate():
    with pytest.raises(InputError, match="no supports"):
        verify(assembly([box((0, 0, 0), (1, 1, 1))], supports=[]))
    with pytest.raises(InputError, match="all blocks are supports"):
        verify(assembly([box((0, 0, 0), (1, 1, 1))]))


def test_joints_that_cannot_be_those_of_the_blocks_are_refused():
    scene = stack(2)
    joints = find_interfaces(scene)
    with pytest.raises(InputError, match='interfaces: the joint of "ground" and "stone0" has points that are not near'):
        verify(scene, interfaces=replace(joints, point=joints.point + [0, 0, 10.0]))
