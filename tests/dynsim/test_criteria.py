"""The criteria on their own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, InputError, Plan, Step, find_interfaces
from dynsim import DynamicOutcome, Settings, sequence, verify
from dynsim.judge.criteria import ARM, SmallBlocks, angles, courses, default_threshold, own_threshold, rate
from evidence.scenes.small import assembly, box, running_bond


def test_the_threshold_grows_with_courses_squared_and_with_size():
    small, tall = running_bond(5, 2), running_bond(40, 2)
    assert (courses(small), courses(tall)) == pytest.approx((5, 40))
    size = np.median(small.size[small.free])
    halves = small.size[small.free].min()
    assert default_threshold(small) == pytest.approx(max(size / 30, halves / 20), rel=0.01)
    # Sound walls settle 0.13 mm at 40 courses of 0.3 m blocks: the threshold leaves room for ten times that.
    assert default_threshold(tall) - default_threshold(small) == pytest.approx(size * 4.7e-3, rel=0.05)
    big = small.with_(vertices=10 * small.vertices)
    assert default_threshold(big) == pytest.approx(10 * default_threshold(small))


def test_angles_are_those_of_the_rotations():
    given = np.array([0.0, 1e-6, 0.3, np.pi - 1e-3])
    turns = Rotation.from_rotvec(given[:, None] * [[0.6, 0.0, 0.8]]).as_matrix()
    np.testing.assert_allclose(angles(turns[:, None])[:, 0], given, rtol=1e-6, atol=1e-12)


def test_the_rate_is_that_of_the_fastest_block_and_leaves_out_shaking():
    times = np.linspace(0, 3, 151)
    moved = np.zeros((151, 2, 3))
    moved[:, 1, 0] = 2e-3 * times
    assert rate(times, moved, 0.5) == pytest.approx(2e-3)
    moved[-1, 0, 2] = 1e-3  # the last look catches one block in a shake
    assert rate(times, moved, 0.1) == pytest.approx(2e-3)


def test_slow_motion_without_acceleration_is_neither_a_stand_nor_a_fall():
    # A slab driven over ice at a constant 3 mm/s by nothing: simulated friction would stop it, so it gets none.
    class Glide:
        each_step = False

        def begin(self, world):
            pass

        def act(self, world, time):
            if time >= 0:
                world.set_velocity(1, np.array([3e-3, 0, 0]), np.zeros(3))

    asm = assembly([box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 0.3))], friction=0.0, gravity=(0, 0, -9.81))
    verdict = verify(asm, actions=[Glide()])
    assert verdict.outcome is DynamicOutcome.CREEPS
    assert verdict.rate == pytest.approx(3e-3, rel=0.05)
    assert verdict.summary()["verdict"] == "creeps"
    assert verify(asm).outcome is DynamicOutcome.STANDS


def test_presets():
    assert Settings.named("default") == Settings()
    assert Settings.named("careful", group="vault").group == "vault"
    assert Settings.named("fast").time_step > Settings.named("careful").time_step
    with pytest.raises(InputError, match="no preset 'quick'; presets are: fast, default, careful"):
        Settings.named("quick")


def test_a_slab_that_spins_in_place_falls():
    # It turns by more than a threshold at an arm of its size, though its centroid stays where it is.
    class Spin:
        each_step = False

        def begin(self, world):
            pass

        def act(self, world, time):
            if time >= 0:
                world.set_velocity(1, np.zeros(3), np.array([0, 0, 0.3]))

    asm = assembly([box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 0.3))], friction=0.0, gravity=(0, 0, -9.81))
    verdict = verify(asm, actions=[Spin()])
    assert verdict.outcome is DynamicOutcome.FALLS
    assert verdict.max_displacement < 0.1 * verdict.brick_threshold
    assert verdict.max_drop < 0.1 * verdict.brick_threshold
    assert np.radians(verdict.max_rotation) * ARM * asm.size[1] >= verdict.brick_threshold
    assert verdict.first_block == asm.names[1]


def test_a_block_that_fell_over_has_fallen_whatever_the_threshold():
    # A pillar that tips over turns by a right angle, and its centre moves by half a metre.
    ground, pillar = box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (0.3, 0.3, 0.9))
    tips = assembly([ground, pillar], friction=2.0, gravity=(4.0, 0, -9.0))
    verdict = verify(tips, settings=Settings(brick_threshold=2.0, roof_threshold=2.0))
    assert verdict.max_displacement < 2.0
    assert verdict.max_rotation == pytest.approx(90, abs=5)
    assert verdict.outcome is DynamicOutcome.FALLS


def test_a_fall_by_rotation_prints_what_was_compared():
    """A top that turns over its edge: its centroid moves by less than a corner."""
    blocks = [box((-1, -1, -1), (0.2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    verdict = verify(Assembly.from_blocks(blocks, supports=["ground"]))
    turn = np.radians(verdict.max_rotation) * ARM * verdict.run.assembly.size[1]
    assert verdict.max_turn == pytest.approx(turn)
    assert max(verdict.max_turn, verdict.max_displacement) >= verdict.turn_threshold
    assert "rotation moved points at half a block's size by up to" in verdict.explain()


@pytest.mark.parametrize("size", [0.06, 0.3, 1.0])
def test_far_bricks_do_not_save_a_slab_that_topples(size):
    # Its centroid is 18 mm beyond the edge of the ledge; the floor 20 mm below stops it, a third of its height lower.
    ledge = box((-0.5, -0.5, -0.1), (0, 0.5, 0), name="ledge")
    floor = box((0, -0.5, -0.1), (0.5, 0.5, -0.02), name="floor")
    slab = box((-0.012, 0, 0), (0.048, 0.05, 0.035), name="slab")
    far = [box((10 + 2.5 * k, 0, 0), (10 + 2.5 * k + size, size, size), name=f"far{k}") for k in range(2)]
    ground = box((9, -1, -1), (20, 4, 0), name="ground")
    scene = assembly([ledge, floor, slab, ground, *far], friction=0.7, supports=["ledge", "floor", "ground"])
    found = verify(scene)
    assert (found.outcome, found.first_block) == (DynamicOutcome.FALLS, "slab")
    (step,) = sequence(scene, Plan((Step(("slab", "far0", "far1")),))).steps
    assert (step.outcome, step.first_block) == (DynamicOutcome.FALLS, "slab")


def test_far_bricks_do_not_save_a_small_block_that_slides():
    # Under .7 of gravity to the side, with a friction of .5, it slides into a stop 6 mm on: a tenth of its size. What
    # the large ones lean on holds them.
    stop = box((0.066, -0.5, 0), (0.2, 0.5, 0.2), name="stop")
    ground = box((-0.5, -0.5, -0.1), (0.5, 0.5, 0), name="ground")
    big = box((-0.5, -0.5, 0), (-0.2, -0.2, 0.3), name="big")
    held = box((-0.2, -0.5, 0), (-0.1, 0.5, 0.3), name="held")
    scene = assembly(
        [ground, stop, box((0, 0, 0), (0.06, 0.06, 0.06), name="cube"), big, held,
         box((-0.5, -0.2, 0), (-0.2, 0.1, 0.3), name="big 2")],
        friction=0.5, gravity=(7, 0, -10), supports=["ground", "stop", "held"],
    )  # fmt: skip
    found = verify(scene)
    assert (found.outcome, found.first_block) == (DynamicOutcome.FALLS, "cube")
    assert any("their own thresholds: cube" in text for text in found.warnings)
    # A threshold that is asked for is that of every block.
    assert verify(scene, settings=Settings(brick_threshold=0.02)).outcome is DynamicOutcome.STANDS


def test_a_small_block_that_rides_on_a_large_one_has_not_fallen():
    low, high = box((0, 0, 0), (1, 1, 1), name="large"), box((0.4, 0.4, 1), (0.6, 0.6, 1.2), name="small")
    scene = assembly([box((-5, -5, -1), (5, 5, 0), name="ground"), low, high], supports=["ground"])
    own = own_threshold(scene, 0.03)
    assert own[1:] == pytest.approx([0.03, 0.01], rel=0.01)  # a twentieth of the size, and no more than that of any
    small, turned = SmallBlocks(scene, find_interfaces(scene), own), np.tile(np.eye(3), (3, 1, 1))

    def strayed(of_large, of_small):
        return small.strayed(np.array([[0.0] * 3, of_large, of_small]), turned).tolist()

    ride = [0.02, 0, 0]  # twice the threshold of the small one
    assert strayed(ride, ride) == [False, False, False]
    assert strayed(ride, [0.029, 0, 0]) == [False, False, False]  # slid on it by 9 mm
    assert strayed(ride, [0.031, 0, 0]) == strayed([0.0] * 3, ride) == [False, False, True]
    assert strayed(ride, [0.02, 0, -0.02]) == [False, False, False]  # into it: neither open nor slid
    assert strayed([0.04, 0, 0], [0.04, 0, 0]) == [False, True, True]  # with a large one that has fallen
    gone = SmallBlocks(scene, find_interfaces(scene), own, gone=np.array([1]))
    assert gone.strayed(np.array([[0.0] * 3, ride, ride]), turned).tolist() == [False, False, True]


def test_what_loads_move_is_added_to_thresholds_of_the_own_size():
    scene = assembly([box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 1, 1))], supports=["ground"])
    own = own_threshold(scene, 2.0, overturns=True)
    assert own[1] == pytest.approx(1.0)  # where loads change, its size
    small = SmallBlocks(scene, find_interfaces(scene), own, carried=0.5)
    moved, turned = np.array([[0.0] * 3, [1.4, 0, 0]]), np.tile(np.eye(3), (2, 1, 1))
    assert small.strayed(moved, turned).tolist() == [False, False]
    assert small.strayed(moved * 1.1, turned).tolist() == [False, True]
