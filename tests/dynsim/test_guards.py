"""What Bullet would take without a word is refused; hostile scenes end in an error of ours or in a right verdict."""

import dataclasses
import importlib
import sys

import numpy as np
import pytest

from blockstat import InputError, JointLaw, find_interfaces
from dynsim import Constant, DynamicOutcome, Settings, World, verify
from dynsim.engine.bullet import import_bullet
from dynsim.engine.friction import block_friction
from dynsim.engine.guards import SWEEPS, check_overlap, check_rotations, iterations_for, thickness
from evidence.scenes.small import assembly, box

STANDS, FALLS = DynamicOutcome.STANDS, DynamicOutcome.FALLS
GROUND = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")


def pile(*boxes, **options):
    return assembly([GROUND, *boxes], **options)


def cube(z=0.0, name="cube", size=1.0, **options):
    return box((0, 0, z), (size, size, z + size), name=name, **options)


def broken(**changes):
    """A good scene changed behind the back of the checks at reading."""
    return dataclasses.replace(pile(cube()), **changes)


def corners(function):
    asm = pile(cube())
    vertices = asm.vertices.copy()
    vertices[8:] = function(vertices[8:])
    return dataclasses.replace(asm, vertices=vertices)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (lambda: corners(lambda v: v * np.nan), 'block "cube" has a corner that is not a number'),
        (lambda: corners(lambda v: v * [1, 1, 0]), 'block "cube" has no volume'),
        (lambda: corners(lambda v: v * [1, 1, -1]), 'block "cube" has no volume or is inside out'),
        (lambda: corners(lambda v: v * 0), 'block "cube" has no volume'),
        (lambda: broken(density=np.array([1.0, -1.0])), 'block "cube" has a mass that is not a positive number'),
        (lambda: broken(density=np.array([1.0, 0.0])), 'block "cube" has a mass that is not a positive number'),
        (lambda: broken(gravity=np.array([0.0, 0.0, np.nan])), "gravity is"),
        (lambda: broken(friction=float("nan")), "friction is nan"),
        (lambda: broken(support=np.array([False, False])), "has no supports"),
        (lambda: broken(support=np.array([True, True])), "all blocks are supports"),
        (lambda: pile(cube(), cube(1, "b"), cube(2, "crumb", 1e-3)), 'block "crumb" is less than 1/100'),
        (lambda: pile(cube(), cube(1, "b"), cube(2, "giant", 200.0)), 'block "giant" is more than 100 times as large'),
        (lambda: pile(cube(), cube(1, "lead", density=2e4)), '"lead" is 2e\\+04 times as heavy as what carries'),
        (lambda: pile(cube(), cube(1, "b"), box((0, 0, 2), (2, 2, 2.005), name="slab")), 'block "slab" is thinner'),
        (lambda: pile(cube(), cube(0.4, "deep")), '"deep" overlap by so much'),
    ],
)
def test_what_bullet_would_swallow_is_refused(scene, message):
    with pytest.raises(InputError, match=message):
        verify(scene())


def test_a_rotation_that_is_none_is_refused():
    asm = pile(cube())
    turns = np.stack([np.eye(3)] * 2)
    check_rotations(asm, turns)
    for wrong in (2 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan)):
        with pytest.raises(InputError, match='block "cube" has an orientation that is not a rotation'):
            check_rotations(asm, np.stack([np.eye(3), wrong]))


def test_a_force_on_no_block_or_of_no_number_is_refused():
    with World(pile(cube()), Settings()) as world:
        with pytest.raises(InputError, match="no block 7; blocks are 0 to 1"):
            world.push([7], np.ones((1, 3)), np.zeros((1, 3)))
        with pytest.raises(InputError, match="not a number"):
            world.push([1], np.full((1, 3), np.nan), np.zeros((1, 3)))


@pytest.mark.parametrize("step", ["time_step", "quick_step", "settle_step"])
def test_an_absurd_time_step_is_refused(step):
    with pytest.raises(InputError, match="at most 1/60 s"):
        Settings(**{step: 1.0, "look_every": 1.0})


def test_the_thickness_of_a_box_is_its_least_edge():
    asm = pile(box((0, 0, 0), (0.3, 2, 1)), box((0, 0, 1), (1, 1, 1.005)))
    np.testing.assert_allclose(thickness(asm), [1.0, 0.3, 0.005], rtol=1e-6)


def test_a_block_in_the_air_falls():
    verdict = verify(pile(cube(), cube(3, "loose")))
    assert (verdict.outcome, verdict.first_block) == (FALLS, "loose")
    assert verdict.first_time > 0


@pytest.mark.parametrize("ratio", [300, 1000])
def test_a_heavy_block_on_a_light_one_stands(ratio):
    # Bullet's defaults let it sink through the floor; weight alone never moves a block that is stacked straight.
    verdict = verify(pile(cube(0, "light"), cube(1, "heavy", density=ratio)))
    assert verdict.outcome is STANDS


def heavy_on_a_slab(ratio):
    """It slides on the slab, or with it, at a slope of the friction; nothing tips before."""
    slab = box((0, 0, 0), (1, 1, 0.25), name="slab", density=4.0)
    return pile(slab, box((0, 0, 0.25), (1, 1, 0.75), name="block", density=2 * ratio), friction=0.5), 0.5


def heavy_on_two(ratio):
    """All three tip about the edge of the two below: half a width over the height of the centre."""
    feet = [box((0, y, 0), (1, y + 0.5, 0.5), name=f"foot{y}", density=4.0) for y in (0, 0.5)]
    block = box((0, 0, 0.5), (1, 1, 1.5), name="block", density=ratio)
    height = (2 * 0.25 + ratio * 1.0) / (2 + ratio)
    return pile(*feet, block, friction=0.9), 0.5 / height


@pytest.mark.parametrize("ratio", [300, 3000])
@pytest.mark.parametrize("scene", [heavy_on_a_slab, heavy_on_two])
def test_blocks_on_much_lighter_ones_keep_their_limits(scene, ratio):
    asm, limit = scene(ratio)
    for factor, outcome in ((0.97, STANDS), (1.03, FALLS)):
        slope = np.arctan(factor * limit)
        leaning = asm.with_(gravity=9.81 * np.array([np.sin(slope), 0, -np.cos(slope)]))
        assert verify(leaning).outcome is outcome


def test_a_thin_slab_under_large_blocks_stands():
    blocks = [box((0, 0, 0), (0.4, 0.2, 0.01), name="slab")]
    blocks += [box((0, 0, z), (0.4, 0.2, z + 0.2), name=f"b{z:.3f}") for z in 0.01 + 0.2 * np.arange(6)]
    assert verify(pile(*blocks)).outcome is STANDS


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_friction_of_each_pair_of_groups_is_exact(factor):
    # A slab on the ground with mu = .3, a second on the first with mu = .6: only the lower joint may slip.
    blocks = [box((0, 0, 0), (1, 1, 0.2), group="low"), box((0, 0, 0.2), (1, 1, 0.4), group="high")]
    laws = [JointLaw(("ground", "low"), friction=0.3), JointLaw(("low", "high"), friction=0.6)]
    asm = pile(*blocks, joints=laws)
    m = block_friction(asm, find_interfaces(asm))
    assert (m[0] * m[1], m[1] * m[2]) == pytest.approx((0.3, 0.6), rel=1e-9)
    verdict = verify(asm.with_(gravity=(0.3 * factor, 0, -1)), settings=Settings(time_step=1e-3))
    assert verdict.outcome is (STANDS if factor < 1 else FALLS)
    assert verdict.displacement[2] == pytest.approx(verdict.displacement[1], abs=1e-3)


def test_frictions_that_no_product_gives_are_refused():
    blocks = [
        box((0, 0, 0), (1, 1, 1), group="a"), box((1, 0, 0), (2, 1, 1), group="b"),
    ]  # fmt: skip
    laws = [JointLaw(("ground", "*"), friction=0.5), JointLaw(("a", "b"), friction=0.0)]
    with pytest.raises(InputError, match="friction 0 between a and b: Bullet multiplies"):
        verify(pile(*blocks, joints=laws))


def test_a_joint_without_friction_has_none_in_bullet():
    # Two stacks side by side, one of them on ice: its block has coefficient 0, and the others keep their product.
    blocks = [box((0, 0, 0), (1, 1, 1), group="ice"), box((3, 0, 0), (4, 1, 1), group="stone")]
    asm = pile(*blocks, joints=[JointLaw(("ground", "ice"), friction=0.0)])
    ground, ice, stone = block_friction(asm, find_interfaces(asm))
    assert ice == 0.0
    assert ground * stone == pytest.approx(asm.friction, rel=1e-9)
    alone = pile(blocks[0], joints=[JointLaw(("ground", "*"), friction=0.0)])
    assert block_friction(alone, find_interfaces(alone)).tolist() == [0.0, 0.0]
    assert verify(alone).outcome is STANDS
    assert verify(alone.with_(gravity=(0.05, 0, -1))).outcome is FALLS


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ModuleNotFoundError("No module named 'pybullet'"), "^Bullet needs pybullet: pip install "),
        (ImportError("numpy.core.multiarray failed to import"), "cannot be imported .numpy.core.* need numpy below 2"),
    ],
)
def test_pybullet_that_is_missing_is_told_from_one_that_numpy_refuses(error, words, monkeypatch):
    def refuse(name):
        raise error

    monkeypatch.delitem(sys.modules, "pybullet", raising=False)
    monkeypatch.setattr(importlib, "import_module", refuse)
    with pytest.raises(InputError, match=words):
        import_bullet()


def test_blocks_may_begin_in_each_other_by_a_twentieth_of_their_size():
    scene = pile(cube(), cube(1, "upper", size=3.0), cube(4, "top"))  # the median of their sizes is a metre
    check_overlap(scene, (1, 2), 0.0499)
    with pytest.raises(InputError, match=r'blocks "cube" and "upper" overlap by 50\.1 mm; .* At most 50 mm'):
        check_overlap(scene, (1, 2), 0.0501)


def needed(*blocks, careful=False):
    asm = pile(*blocks)
    return iterations_for(asm, find_interfaces(asm), careful=careful)


def test_sweeps_follow_the_ratio_of_a_mass_to_what_carries_it_and_the_joints_below():
    for careful in (False, True):
        assert needed(cube(), careful=careful) == 0  # a support carries anything
        assert needed(cube(), cube(3, "apart", density=9.0), careful=careful) == 0
        # On one of its own, three times as heavy, with two joints down to the ground.
        assert needed(cube(), cube(1, "heavy", density=3.0), careful=careful) == 3 * SWEEPS * (2 if careful else 1)
        # What stands on a heavy block does not carry it; that one carries a ninth of its own mass, two joints up.
        assert needed(cube(0, "heavy", density=9.0), cube(1, "light"), careful=careful) == np.ceil(
            SWEEPS / 9 * (2 if careful else 1)
        )
    # On a column of four, with five joints.
    column = [*(cube(k, f"c{k}") for k in range(4)), cube(4, "heavy", density=3.0)]
    assert needed(*column) == 3 * SWEEPS
    assert needed(*column, careful=True) == 3 * 5 * SWEEPS
    # Four legs share it; where it tips it rests on two of them.
    legs = [box((x, y, 0), (x + 1, y + 1, 1), name=f"leg{x}{y}") for x in (0, 3) for y in (0, 3)]
    table = box((0, 0, 1), (4, 4, 2), name="table", density=2.0)
    assert needed(*legs, table) == 32 / 4 * SWEEPS
    assert needed(*legs, table, careful=True) == 32 / 2 * 2 * SWEEPS
    # All legs together say whether it is too heavy, and there are never more sweeps than for the largest ratio allowed.
    heavy = dataclasses.replace(table, density=2400.0)
    assert needed(*legs, heavy) == 16 * 2400 / 4 * SWEEPS
    assert needed(*legs, heavy, careful=True) == 2e4
    # Of three in a row, the last alone.
    row = [box((x, 0, 0), (x + 1, 1, 1), name=f"leg{x}") for x in (0, 2, 4)]
    beam = box((0, 0, 1), (5, 1, 2), name="beam", density=3.0)
    assert needed(*row, beam) == 15 / 3 * SWEEPS
    assert needed(*row, beam, careful=True) == 15 * 2 * SWEEPS
    # Two small blocks beside a heavy one on the ground can be pushed: sweeps for the ratio to both of one side.
    heavy = box((0, 0, 0), (2, 2, 1), name="heavy", density=5.0)
    beside = [box((2, y, 0), (3, y + 1, 1), name=f"side{y}") for y in (0, 1)]
    assert needed(heavy, *beside) == 20 / 2 * SWEEPS


def test_a_floor_on_many_bricks_needs_few_sweeps_and_keeps_its_limits():
    # A plate thirty times as heavy as a brick on two walls of sixteen bricks each: it slides at a slope of .6.
    bricks = [
        box((x, y, z), (x + 0.5, y + 0.25, z + 0.2), name=f"brick{x}{y}{z:.1f}")
        for y in (0, 2) for z in 0.2 * np.arange(4) for x in (0, 0.5, 1, 1.5)
    ]  # fmt: skip
    mass = 0.5 * 0.25 * 0.2
    plate = box((0, 0, 0.8), (2, 2.25, 0.95), name="plate", density=30 * mass / (2 * 2.25 * 0.15))
    asm = pile(*bricks, plate, friction=0.6)
    joints = find_interfaces(asm)
    # On eight bricks; at the end of a row of four, on the last of both walls, five joints above the ground.
    assert iterations_for(asm, joints) == np.ceil(30 / 8 * SWEEPS)
    assert iterations_for(asm, joints, careful=True) == np.ceil(30 / 2 * 5 * SWEEPS)
    for factor, outcome in ((0.97, STANDS), (1.03, FALLS)):
        slope = np.arctan(factor * 0.6)
        leaning = asm.with_(gravity=9.81 * np.array([np.sin(slope), 0, -np.cos(slope)]))
        assert verify(leaning, interfaces=joints).outcome is outcome


def test_a_slab_on_light_posts_rests_at_95_percent_of_the_push_that_slides_it():
    # Every joint slides at an acceleration of the coefficient, .5 g; the slab has 75 times the mass of a post.
    posts = [box((x, y, 0), (x + 0.2, y + 0.2, 0.2), name=f"post{x}{y}") for x in (0, 1.8) for y in (0, 0.8)]
    asm = pile(*posts, box((0, 0, 0.2), (2, 1, 0.5), name="slab"), friction=0.5)
    for factor, outcome in ((0.95, STANDS), (1.05, FALLS)):
        assert verify(asm, loads=[Constant((factor * 0.5, 0, 0))]).outcome is outcome
