"""The criteria on their own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, InputError
from dynsim import DynamicOutcome, Settings, verify
from dynsim.judge.criteria import ARM, angles, courses, default_threshold, rate
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
