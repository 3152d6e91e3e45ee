"""Ties that were slack and are taut again: at the length that they have, with a strength that is or is not reached.

All scenes are a block of 0.6 m x 1 m x 2 m in the plane xz. Lengths and forces follow by hand from the place of its toe
and its turn.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from blockstat import Assembly, PathOutcome, Tie, box, capacity, settle_to_collapse

WIDTH, HEIGHT, DENSITY = 0.6, 2.0, 1000.0
WEIGHT = WIDTH * HEIGHT * DENSITY * 9.81
TOE, MIDDLE = np.array([WIDTH, 0.0]), np.array([WIDTH / 2, HEIGHT / 2])


def moment(arm, force):
    """Moment that turns to the left, of a force in the plane xz."""
    return arm[0] * force[1] - arm[1] * force[0]


def placed(point, turn, toe=TOE):
    """Where a point of the block is when it has turned by an angle to the right about its toe, which is at `toe`."""
    arm, (c, s) = np.asarray(point) - TOE, (np.cos(turn), np.sin(turn))
    return np.asarray(toe) + (c * arm[0] + s * arm[1], -s * arm[0] + c * arm[1])


def along(start, end):
    """The unit vector from one point to another."""
    return (np.asarray(end) - start) / np.linalg.norm(np.asarray(end) - start)


@dataclass(frozen=True)
class Frame:
    """How a scene is drawn: its size, whether it is mirrored, where it is and in which order its blocks are named."""

    scale: float = 1.0
    sign: int = 1
    origin: tuple[float, float] = (0.0, 0.0)
    order: tuple[int, ...] = (0, 1, 2)

    def point(self, x, y, z):
        return (self.origin[0] + self.sign * self.scale * x, self.origin[1] + self.scale * y, self.scale * z)

    def block(self, low, high, name):
        a, b = self.point(*low), self.point(*high)
        return box(np.minimum(a, b), np.maximum(a, b), name=name)

    @property
    def force(self):
        """Weights grow with the volume."""
        return self.scale**3


FRAMES = [
    Frame(),
    Frame(sign=-1),
    Frame(order=(2, 0, 1)),
    Frame(origin=(5e5, 5.4e6)),
    Frame(scale=1e-2),
    Frame(scale=30.0),
]
NAMES = ["as drawn", "mirrored", "permuted", "UTM", "1e-2", "30"]


def scene(frame, support, ties, friction):
    """The block on the ground, and a support; ties are their two points, least and greatest force."""
    blocks = [
        frame.block((-9, -9, -1), (9, 9, 0), "ground"),
        frame.block((0, 0, 0), (WIDTH, 1, HEIGHT), "block"),
        frame.block(*support, "support"),
    ]
    told = [
        Tie(
            ("support", "block"),
            (frame.point(far[0], 0.5, far[1]), frame.point(near[0], 0.5, near[1])),
            least=least * frame.force,
            greatest=greatest * frame.force,
        )
        for far, near, least, greatest in ties
    ]
    chosen = [blocks[k] for k in frame.order]
    supports = ["ground", "support"]
    return Assembly.from_blocks(chosen, supports=supports, density=DENSITY, friction=friction, ties=told)


# A frame draws a block over its toe by a tie from (2, .6) to (.6, 1). As it rises by x the tie is first slack.
FAR, NEAR = np.array([2.0, 0.6]), np.array([WIDTH, 1.0])
LENGTH = np.linalg.norm(FAR - NEAR)


def drawn_over(rise):
    """The force of a tie that keeps its length, its direction and the turn of the block.

    The tie is as long as at rest, sqrt(1.4^2 + .4^2), where its far end is as high above its near one as it was below:
    after a rise of .8. From there on the block turns by t about its toe, so that the near end is at
    (.6 + sin t, cos t), one length from the far one. Moments about the toe: the weight has the arm
    .3 cos t - sin t, the force T that of its line.
    """
    far = FAR + (0, rise)
    turn = brentq(lambda t: np.linalg.norm(far - placed(NEAR, t)) - LENGTH, 0, 0.6, xtol=1e-15)
    line = along(placed(NEAR, turn), far)
    lever = WIDTH / 2 * np.cos(turn) - HEIGHT / 2 * np.sin(turn)
    return WEIGHT * lever / -moment(placed(NEAR, turn) - TOE, line), line, turn


def test_the_closed_form_has_the_values_of_an_independent_calculation():
    """To the digits of the rises."""
    for rise, reaction in ((0.942, -1211.7), (0.966, -1230.3), (1.151, -1107.4)):
        force, line, _ = drawn_over(rise)
        assert -force * line[1] == pytest.approx(reaction, rel=5e-4)
    assert drawn_over(0.8 + 1e-9)[0] == pytest.approx(WEIGHT * 0.3 / (1.4 / LENGTH), rel=1e-6)


def rising(frame, greatest, most=1.6, **options):
    ties = [(FAR, NEAR, 0.0, greatest)]
    drawn = scene(frame, ((2, 0, 19.1), (3, 1, 20)), ties, 0.6)
    return settle_to_collapse(drawn, {"support": (0, 0, 1)}, displacement=most * frame.scale, **options)


def check_reactions(found, frame):
    """A slack tie has none. The state in which it becomes taut is left out, as the reaction leaps there."""
    rises, reactions = found.displacement / frame.scale, found.reaction / frame.force
    taut = rises > 0.8 + 1e-6
    assert taut.sum() > 2
    np.testing.assert_allclose(reactions[rises < 0.8 - 1e-6], 0.0, atol=1e-6 * WEIGHT)
    by_hand = [-force * line[1] for force, line, _ in map(drawn_over, rises[taut])]
    np.testing.assert_allclose(reactions[taut], by_hand, rtol=1e-5, atol=1e-5 * WEIGHT)


@pytest.mark.parametrize("greatest", [2e4, 1e6, np.inf])
def test_a_tie_that_is_taut_again_draws_a_block_over_whatever_it_could_bear(greatest):
    """The block falls where its weight is above its toe: tan t = .3."""
    found = rising(Frame(), greatest)
    assert found.outcome is PathOutcome.COLLAPSE
    end = brentq(lambda rise: drawn_over(rise)[0], 1.2, 1.31)
    assert found.displacement[-1] == pytest.approx(end, abs=1e-3)
    check_reactions(found, Frame())


def test_so_does_a_tie_that_could_bear_hardly_more_than_it_needs():
    """It needs 3673 N at most."""
    check_reactions(rising(Frame(), 3.7e3, most=0.85), Frame())


@pytest.mark.parametrize("frame", FRAMES[1:], ids=NAMES[1:])
def test_it_draws_the_block_over_however_the_scene_is_drawn(frame):
    check_reactions(rising(frame, 1e5, most=1.0), frame)


def test_a_tie_that_is_taut_again_and_too_weak_yields_and_the_block_stands():
    """With 3000 N it does not turn the block, which needs 3673 N: it pulls with its strength as it lengthens."""
    found = rising(Frame(), 3e3, most=0.85)
    assert found.outcome is PathOutcome.REACHED
    rises = found.displacement[found.displacement > 0.8 + 1e-6]
    lines = [along(NEAR, FAR + (0, rise)) for rise in rises]
    np.testing.assert_allclose(found.reaction[-len(rises) :], [-3e3 * line[1] for line in lines], rtol=1e-6)
    pose = found.poses[-1]
    np.testing.assert_allclose(pose.displacement, 0.0, atol=1e-9)
    longer = np.linalg.norm(FAR + (0, found.displacement[-1]) - NEAR) - LENGTH
    assert pose.yielded == pytest.approx([longer], rel=1e-6)


# A ground that carries a block away from two ties. The first, at (.3, 1.9), yields at once, at 200 N. The second, from
# (.56, .81) to (.6, .8), is first slack.
WEAK, HIGH, FIRST = 200.0, np.array([0.3, 1.9]), 0.05
LOW, ASIDE, ABOVE, SECOND = np.array([WIDTH, 0.8]), 0.04, 0.01, np.hypot(0.04, 0.01)
HIGH_FAR, LOW_FAR = HIGH + (FIRST, 0), LOW + (-ASIDE, ABOVE)


class OnMovingGround:
    """The block when the ground has moved by s to the left, with the turn t about its toe, which moves with the ground.

    Until s = .08 the block rides on the ground. The second tie is taut then, as its near end is as far on the other
    side of its far one, and the first has lengthened from .05 m to .13 m. From there on the second tie keeps its length
    and the block turns about its toe.
    """

    def __init__(self, moved):
        self.toe = TOE - (moved, 0.0)
        self.rides = moved <= 2 * ASIDE
        above = np.arcsin(max(moved - ASIDE, 0.0) / LOW[1])  # the near end of the second tie is below its far one
        self.turn = 0.0
        if not self.rides:
            self.turn = brentq(lambda t: np.linalg.norm(LOW_FAR - self.at(LOW, t)) - SECOND, 0, above, xtol=1e-15)

    def at(self, point, turn=None):
        return placed(point, self.turn if turn is None else turn, self.toe)

    @property
    def first_length(self):
        return np.linalg.norm(HIGH_FAR - self.at(HIGH))

    def reaction(self, first):
        """Force of the block on the ground, to the left: ties draw the block to the right with as much.

        The second tie has the force that moments about the toe ask for.
        """
        line = along(self.at(HIGH), HIGH_FAR)
        if self.rides:
            return -first * line[0]
        other = along(self.at(LOW), LOW_FAR)
        arms = [self.at(point) - self.toe for point in (HIGH, LOW, MIDDLE)]
        turning = first * moment(arms[0], line) + moment(arms[2], (0, -WEIGHT))
        return -(first * line[0] - turning / moment(arms[1], other) * other[0])


@pytest.mark.parametrize("frame", FRAMES, ids=NAMES)
def test_a_tie_that_has_yielded_and_was_slack_is_taut_again_at_the_length_it_has_yielded_to(frame):
    """The first tie yields by .08 m. As the block turns its end passes below the far one, so that it is slack.

    It is taut again where it is .13 m long, and yields from there on. So the reaction leaps there.
    """
    ties = [(HIGH_FAR, HIGH, 0.0, WEAK), (LOW_FAR, LOW, 0.0, np.inf)]
    drawn = scene(frame, ((-5, -5, 6), (5, 5, 7)), ties, 0.9)
    end = 0.26
    found = settle_to_collapse(drawn, {"ground": (-frame.sign, 0, 0)}, displacement=end * frame.scale, steps=20)
    assert found.outcome is PathOutcome.REACHED
    longest = FIRST + 2 * ASIDE
    again = brentq(lambda moved: OnMovingGround(moved).first_length - longest, 0.2, end)
    assert [event.kind for event in found.events] == ["closing", "closing"]
    places = [event.parameter / frame.scale for event in found.events]
    assert places == pytest.approx([2 * ASIDE, again], rel=1e-7)
    there = OnMovingGround(again)
    leap = [found.events[1].before / frame.force, found.events[1].after / frame.force]
    assert leap == pytest.approx([there.reaction(0.0), there.reaction(WEAK)], rel=1e-6)
    for moved, reaction, pose in zip(found.displacement / frame.scale, found.reaction, found.poses, strict=True):
        if min(abs(moved - place) for place in places) < 1e-6:
            continue
        here = OnMovingGround(moved)
        first = WEAK if here.rides or moved > again else 0.0
        assert reaction / frame.force == pytest.approx(here.reaction(first), rel=1e-6)
        longer = {True: moved, False: max(2 * ASIDE, here.first_length - FIRST)}[here.rides]
        assert (pose.yielded[0] if len(pose.yielded) else 0.0) == pytest.approx(longer * frame.scale, rel=1e-6)


class PushedOver:
    """The block that a load to the right, alpha times its weight, turns about its toe until a tie is taut again.

    From there on the tie keeps its length and the toe slides. So the displacement d of the centroid and the length of
    the tie give the turn and the place of the toe, and at each pose three equations of equilibrium give the force T of
    the tie, that of the ground N, with friction mu N against the slip, and alpha.
    """

    def __init__(self, far, near, least, friction):
        self.far, self.near, self.least, self.friction = np.array(far), np.array(near), least, friction
        self.length = np.linalg.norm(self.far - near)
        self.taut = brentq(lambda turn: self.longer(turn, 0.0), 0.02, 0.3, xtol=1e-15)  # the turn at which it is

    def moved(self, turn, slip):
        return placed(MIDDLE, turn, TOE + (slip, 0))[0] - MIDDLE[0]

    def longer(self, turn, slip):
        return np.linalg.norm(self.far - placed(self.near, turn, TOE + (slip, 0))) - self.length

    def slip(self, turn, moved):
        return moved - self.moved(turn, 0.0)

    def turn(self, moved, onwards):
        """The turn at which the tie is as long as before, on the way from that at which it is taut."""
        return brentq(lambda turn: self.longer(turn, self.slip(turn, moved)), self.taut, onwards, xtol=1e-15)

    def first_multiplier(self, turn):
        """Moments about the toe, with the least force in the tie."""
        middle, near = placed(MIDDLE, turn), placed(self.near, turn)
        pull = self.least * moment(near - TOE, along(near, self.far))
        return (pull + moment(middle - TOE, (0, -WEIGHT))) / -moment(middle - TOE, (WEIGHT, 0))

    def multiplier(self, turn, slip, leads):
        """With a toe that slides to the right (leads = 1) or to the left (leads = -1)."""
        toe = TOE + (slip, 0)
        near, middle = placed(self.near, turn, toe), placed(MIDDLE, turn, toe)
        line = along(near, self.far)
        turning = moment(near - toe, line), 0.0, moment(middle - toe, (WEIGHT, 0))
        rows = [[line[0], -leads * self.friction, WEIGHT], [line[1], 1.0, 0.0], turning]
        force, ground, found = np.linalg.solve(rows, [0.0, WEIGHT, -moment(middle - toe, (0, -WEIGHT))])
        assert min(force - self.least, ground) > 0
        return found


HELD_BACK = PushedOver((-2.474, 2.391), (0.0, 0.43), 0.0, 0.6)
HELD_UP = PushedOver((0.68, 0.9), (WIDTH, 0.5), 300.0, 0.7)
ALOFT = ((-5, -5, 6), (5, 5, 7))


def pushed(by_hand, greatest, frame=FRAMES[0], **options):
    ties = [(by_hand.far, by_hand.near, by_hand.least, greatest)]
    drawn = scene(frame, ALOFT, ties, by_hand.friction)
    return capacity(drawn, (frame.sign, 0, 0), control="block", **options)


def checked(curve, by_hand, frame, onwards, leads):
    """Whether all of a curve is as by hand, up to 1e-6; returns the displacement at which the tie is taut again."""
    place = by_hand.moved(by_hand.taut, 0.0)
    [event] = curve.events
    assert (event.kind, event.shut) == ("closing", ())
    assert event.parameter / frame.scale == pytest.approx(place, rel=1e-8)
    assert event.before == pytest.approx(by_hand.first_multiplier(by_hand.taut), rel=1e-6)
    assert event.after == pytest.approx(by_hand.multiplier(by_hand.taut, 0.0, leads), rel=1e-6)
    for moved, lower in zip(curve.displacement / frame.scale, curve.lower, strict=True):
        if abs(moved - place) < 1e-6:
            continue
        if moved < place:
            turn = brentq(lambda turn, moved=moved: by_hand.moved(turn, 0.0) - moved, 0, 0.3)
            assert lower == pytest.approx(by_hand.first_multiplier(turn), rel=1e-6)
        else:
            turn = by_hand.turn(moved, onwards)
            exact = by_hand.multiplier(turn, by_hand.slip(turn, moved), leads)
            assert lower == pytest.approx(exact, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("greatest", [2e4, 1e5, 1e7, np.inf])
def test_a_tie_that_is_taut_again_holds_a_block_back_whatever_it_could_bear(greatest):
    curve = pushed(HELD_BACK, greatest)
    assert curve.outcome.word == "zero"
    assert not curve.warnings
    checked(curve, HELD_BACK, FRAMES[0], 0.6, -1)


@pytest.mark.parametrize("frame", FRAMES[1:], ids=NAMES[1:])
def test_it_holds_the_block_back_however_the_scene_is_drawn(frame):
    curve = pushed(HELD_BACK, 1e5, frame)
    assert curve.outcome.word == "zero"
    checked(curve, HELD_BACK, frame, 0.6, -1)


def test_a_strength_that_is_not_reached_does_not_change_a_curve():
    curves = [pushed(HELD_BACK, greatest) for greatest in (1e5, 1e7, np.inf)]
    for curve in curves[:-1]:
        np.testing.assert_allclose(curve.displacement, curves[-1].displacement, rtol=1e-6)
        np.testing.assert_allclose(curve.lower, curves[-1].lower, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("greatest", [2e4, 1e6, np.inf])
def test_a_tie_that_is_taut_again_bars_the_way_where_its_linkage_turns_back(greatest):
    """The toe slides to the right as the block turns back. The centroid is furthest where d of the turn is largest.

    The tie needs 9 kN there. So no pose with a tie of its length is further, and a curve that goes on has a longer one.
    """

    def slip_at(turn):
        return brentq(lambda slip: HELD_UP.longer(turn, slip), -0.02, 0.1, xtol=1e-15)

    most = minimize_scalar(
        lambda turn: -HELD_UP.moved(turn, slip_at(turn)), bounds=(0.08, HELD_UP.taut), method="bounded"
    )
    curve = pushed(HELD_UP, greatest)
    assert curve.displacement.max() == pytest.approx(-most.fun, rel=1e-4)
    assert curve.displacement.max() <= -most.fun * (1 + 1e-7)
    assert curve.events[0].kind == "closing"
    for point in curve.points:
        pose = point.pose
        turn = np.arcsin(pose.rotation[1][0, 2])
        toe = MIDDLE + pose.displacement[1][[0, 2]] - (placed(MIDDLE, turn, (0, 0)))
        assert np.linalg.norm(HELD_UP.far - placed(HELD_UP.near, turn, toe)) <= HELD_UP.length * (1 + 1e-6)
