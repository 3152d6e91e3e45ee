"""Blocks that ties hold while supports move: hand statics at every pose, and strengths that no tie reaches."""

import numpy as np
import pytest
from scipy.optimize import brentq

from blockstat import Assembly, Tie, box, capacity, settle_to_collapse
from blockstat.studies.settling_path import PathOutcome

WIDTH, HEIGHT = 0.8, 1.2
WEIGHT = WIDTH * HEIGHT * 2000 * 9.81


def beside_a_frame(far, greatest):
    """A block of 0.8 m x 1.2 m on the ground, with a tie from its top edge to a frame at the right."""
    blocks = [box((-3, -1, -1), (4, 2, 0), name="ground"), box((3, 0, 0), (4, 1, 4), name="frame")]
    blocks.append(box((0, 0, 0), (WIDTH, 1, HEIGHT), name="block"))
    tie = Tie(("frame", "block"), ((*far[:1], 0.5, far[1]), (WIDTH, 0.5, HEIGHT)), greatest=greatest)
    return Assembly.from_blocks(blocks, supports=["ground", "frame"], density=2000.0, friction=0.7, ties=[tie])


def force_over_the_toe(far, move, distance):
    """Force on the frame along its movement when it draws the block over its toe.

    The block has turned by t about its toe (0.8, 0), with the end of the tie 1.2 above that at rest: at
    1.2 (sin t, cos t) from the toe. The tie keeps its length, which gives t. Moments about the toe: the tie pulls with
    the force T on the arm that its line has, and the weight has the arm 0.4 cos t - 0.6 sin t.
    """
    toe, start, move = np.array([WIDTH, 0.0]), np.array(far), np.array(move)
    end = start + distance * move
    length = np.linalg.norm(start - toe - (0, HEIGHT))

    def near(turn):
        return toe + HEIGHT * np.array([np.sin(turn), np.cos(turn)])

    turn = brentq(lambda turn: np.linalg.norm(end - near(turn)) - length, -0.01, 0.5)
    along, arm = (end - near(turn)) / length, near(turn) - toe
    lever = WIDTH / 2 * np.cos(turn) - HEIGHT / 2 * np.sin(turn)
    pull = WEIGHT * lever / (arm[1] * along[0] - arm[0] * along[1])
    return -pull * float(along @ move)


@pytest.mark.parametrize("steps", [4, 9])
@pytest.mark.parametrize("greatest", [8e3, 1e5, 5e5, np.inf])
@pytest.mark.parametrize(("far", "move"), [((3, 2.4), (0, 1)), ((3, 2.4), (1, 0)), ((3, 0.9), (0.6, 0.8))])
def test_a_tie_that_draws_a_block_over_pulls_with_the_moments_about_its_toe(far, move, greatest, steps):
    scene = beside_a_frame(far, greatest)
    found = settle_to_collapse(scene, {"frame": (move[0], 0, move[1])}, displacement=0.05, steps=steps)
    assert found.outcome is PathOutcome.REACHED
    assert not found.events
    expected = [force_over_the_toe(far, move, distance) for distance in found.displacement]
    np.testing.assert_allclose(found.reaction, expected, rtol=1e-5)
    assert found.reaction[0] == pytest.approx(found.first.reaction, rel=1e-6)


def test_a_tie_yields_where_the_force_over_the_toe_passes_its_strength():
    """At first it would have to pull with W w / 2 over the arm of its line about the toe, 7152 N: one of 5000 N yields.

    Then the block stands, and the tie has its strength, times the slope of its line to the frame, which rises by d.
    """
    scene = beside_a_frame((3, 2.4), 5e3)
    found = settle_to_collapse(scene, {"frame": (0, 0, 1)}, displacement=0.05, steps=9)
    rise = 1.2 + found.displacement
    np.testing.assert_allclose(found.reaction, -5e3 * rise / np.hypot(2.2, rise), rtol=1e-6)
    assert not found.poses[-1].displacement.any()


def hung(places, greatest=np.inf):
    """A block of 1 m on the ground, under a frame to which vertical bars hold it."""
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 3), (1, 1, 4), name="frame")]
    blocks.append(box((0, 0, 0), (1, 1, 1), name="block"))
    ties = [Tie(("frame", "block"), ((x, y, 3), (x, y, 1)), greatest=greatest) for x, y in places]
    return Assembly.from_blocks(blocks, supports=["ground", "frame"], density=2000.0, ties=ties)


ONE = [(0.5, 0.5)]
TWO = [(0.25, 0.5), (0.75, 0.5)]
UNEVEN = [(0.2, 0.5), (0.6, 0.5)]
FOUR = [(x, y) for x in (0.0, 1.0) for y in (0.0, 1.0)]


@pytest.mark.parametrize("steps", [3, 10])
@pytest.mark.parametrize(
    ("places", "greatest"),
    [
        (ONE, 19621.0),
        (ONE, 25e3),
        (ONE, 1e5),
        (ONE, np.inf),
        (TWO, 12e3),
        (TWO, 1e5),
        (TWO, np.inf),
        (UNEVEN, 1e5),
        (UNEVEN, np.inf),
        (FOUR, 1e5),
    ],
)
def test_bars_that_carry_a_block_hold_it_where_it_is_as_the_ground_sinks(places, greatest, steps):
    """The bars carry its 19,620 N, in equilibrium about its centroid. A dry joint does not pull: the ground gets 0."""
    found = settle_to_collapse(hung(places, greatest), {"ground": (0, 0, -1)}, displacement=0.1, steps=steps)
    assert found.outcome is PathOutcome.REACHED
    assert found.displacement[-1] == pytest.approx(0.1)
    np.testing.assert_allclose(found.reaction, 0.0, atol=1e-6)
    np.testing.assert_allclose([pose.displacement[2] for pose in found.poses], 0.0, atol=1e-6)


@pytest.mark.parametrize(("places", "greatest"), [(ONE, np.inf), (TWO, np.inf), (TWO, 1e5), (UNEVEN, 1e5)])
def test_a_frame_that_rises_lifts_the_block_on_its_bars(places, greatest):
    """It carries the weight from the first moment on, as the bars were no shorter before."""
    found = settle_to_collapse(hung(places, greatest), {"frame": (0, 0, 1)}, displacement=0.1, steps=10)
    assert found.outcome is PathOutcome.REACHED
    np.testing.assert_allclose(found.reaction, -2000 * 9.81, rtol=1e-6)
    assert found.poses[-1].displacement[2] == pytest.approx([0, 0, 0.1], abs=1e-6)


@pytest.mark.parametrize("strength", [8e3, 9.8e3])
def test_two_bars_that_are_too_weak_yield_and_the_block_follows_the_ground(strength):
    """The ground carries what they do not."""
    found = settle_to_collapse(hung(TWO, strength), {"ground": (0, 0, -1)}, displacement=0.1, steps=10)
    np.testing.assert_allclose(found.reaction, 2000 * 9.81 - 2 * strength, rtol=1e-6)


def test_blocks_that_swing_on_their_bars_have_not_fallen():
    """The frame rises askew. The block follows below it, which is not looked for, and said."""
    found = settle_to_collapse(hung(TWO), {"frame": (0.5, 0, 1)}, displacement=0.1, steps=10)
    assert found.outcome is not PathOutcome.COLLAPSE


def on_two_grounds(**options):
    """A block of 1 m that lies on two grounds, for 0.4 m on each."""
    blocks = [box((-3, -1, -1), (0.4, 2, 0), name="left"), box((0.6, -1, -1), (4, 2, 0), name="right")]
    blocks += [box((3, 0, 0), (4, 1, 4), name="frame"), *options.pop("blocks", [box((0, 0, 0), (1, 1, 1), name="one")])]
    return Assembly.from_blocks(blocks, supports=["left", "right", "frame"], density=2000.0, **options)


@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_a_path_begins_with_the_force_that_settle_has_though_others_are_admissible(friction):
    """The right ground leaves. The left one holds the block by no more friction than its share of the weight gives.

    So the greatest force of friction is that of equal shares, mu W / 2. With less on the right, where the block may
    bear as little as a sixth of its weight, there is less, and that is in equilibrium too.
    """
    scene = on_two_grounds(friction=friction)
    found = settle_to_collapse(scene, {"right": (1, 0, 0)}, displacement=0.01, steps=4)
    assert found.first.reaction == pytest.approx(-friction * 2000 * 9.81 / 2, rel=1e-6)
    assert found.reaction[0] == pytest.approx(found.first.reaction, rel=1e-6)
    assert not any("thrust_range" in text for text in found.warnings)


def test_a_path_says_where_it_begins_with_another_force_than_settle():
    """Friction of 3 makes joints rise steeply as they slide, so that `settle` finds another mechanism than the path.

    Its energy is the least of all, so its force is no larger than that of the path.
    """
    width, height, at = 1.14, 1.76, 1.24
    courses = [box((0, 0, z), (width, 1, z + height / 2), name=name) for name, z in (("low", 0), ("high", height / 2))]
    tie = Tie(("frame", "high"), ((3, 0.5, 2.03), (width, 0.5, at)))
    scene = on_two_grounds(blocks=courses, friction=3.0, ties=[tie])
    found = settle_to_collapse(scene, {"right": (-1, 0, 0)}, displacement=0.001, steps=1)
    assert found.first.reaction < 0.9 * found.reaction[0] < 0
    [told] = [text for text in found.warnings if "thrust_range" in text]
    assert f"{found.reaction[0]:.6g} N" in told
    assert f"{found.first.reaction:.6g} N" in told


def multiplier_of_a_held_top(slid, friction=0.7):
    """The multiplier of a block whose foot slides away while a tie without end of strength holds its top.

    Its toe, the corner (0.8, 0), has slid by s and with associated flow has risen by mu s. The end of the tie, 1.2 from
    it, stays 2.2 from the frame. At the toe the ground presses with N and rubs with mu N against the slip. Two forces
    and the moments about the toe, where N and mu N have none, give T, N and the multiplier of the weight to the left.
    """
    toe, far = np.array([WIDTH - slid, friction * slid]), np.array([3.0, HEIGHT])

    def top(turn):
        return toe + HEIGHT * np.array([np.sin(turn), np.cos(turn)])

    turn = brentq(lambda turn: np.linalg.norm(far - top(turn)) - 2.2, -0.1, 0.5)
    along, arm = (far - top(turn)) / 2.2, top(turn) - toe
    mass = -WIDTH / 2 * np.array([np.cos(turn), -np.sin(turn)]) + HEIGHT / 2 * np.array([np.sin(turn), np.cos(turn)])
    # Unknown T, N and alpha, all over the weight; moments are x F_z - z F_x.
    rows = [[along[0], friction, -1.0], [along[1], 1.0, 0.0], [arm[0] * along[1] - arm[1] * along[0], 0.0, mass[1]]]
    return np.linalg.solve(rows, [0.0, 1.0, mass[0]])[2]


@pytest.mark.parametrize("y", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("greatest", [3e4, 5e5, np.inf])
def test_a_tie_that_is_strong_enough_holds_a_top_for_as_long_as_any(greatest, y):
    """Its greatest force at 0.1 m is 27 kN. A control at the side of the block must not turn it about the vertical.

    The block turns by 0.08 on the way. In each of the steps a toe that rises by friction times its slip is off by the
    square of the turn of that step, so 12 steps are off by 1e-4 at most, and 24 steps by a half of that.
    """
    scene = beside_a_frame((3, 1.2), greatest)
    curve = capacity(scene, (-1, 0, 0), control=("block", (WIDTH, y, 0)), displacement=0.1, steps=12, flow="associated")
    assert curve.outcome.word == "reached"
    expected = [multiplier_of_a_held_top(slid) for slid in curve.displacement]
    np.testing.assert_allclose(curve.lower, expected, rtol=1e-4)
    assert not curve.events
