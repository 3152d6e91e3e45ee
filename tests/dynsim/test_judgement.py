"""What a run comes to: criteria, trends, cracks, loads, chains of joints and limits, against closed forms.

Motions are prescribed where the judgement is what is tested.
"""

from dataclasses import FrozenInstanceError, dataclass, replace
from time import process_time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, JointLaw, Outcome, Plan, Step, assess, find_interfaces
from dynsim import (
    Constant,
    DynamicOutcome,
    InertiaScale,
    Pulse,
    Push,
    Removal,
    Settings,
    Settlement,
    Tilt,
    limit,
    past_verdict,
    sequence,
    simulate,
    verify,
)
from dynsim.bonds.glue import weakened
from dynsim.engine.world import World
from dynsim.judge import verify as judging
from dynsim.judge.closing import _openings, _refusal, closed_scene
from dynsim.judge.cracks import find_cracks
from dynsim.judge.criteria import angles, courses, default_threshold, drops, group_box_centre, rate
from dynsim.judge.limit import LimitOutcome, Trial, _Search
from dynsim.judge.limit import _warnings as limit_warnings
from dynsim.judge.rest import RestDetection, last_change, stays, threshold_under, trend
from dynsim.judge.run import Contacts, height_of
from dynsim.judge.stages import joints_to_furthest_block, stages
from dynsim.judge.static_reserve import StaticReserve
from dynsim.judge.verify import _Evaluator, _staged, _warnings
from evidence.scenes.edges import two_ridges
from evidence.scenes.small import assembly, box, stack

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")


def rows(sizes, **options):
    """Blocks in a row on a ground, a metre from each other, as wide, deep and high as is said."""
    blocks = [box((2 * k, 0, 0), (2 * k + x, y, z), name=f"b{k}") for k, (x, y, z) in enumerate(sizes)]
    return assembly([box((-99, -99, -9), (99, 99, 0), name="ground"), *blocks], **options)


def test_the_threshold_is_a_share_of_the_free_blocks_and_of_their_courses():
    sizes = [(0.2, 0.3, 0.1), (1.0, 0.5, 0.4), (0.9, 0.8, 0.7)]
    asm = rows(sizes)
    edges = [np.cbrt(x * y * z) for x, y, z in sizes]
    assert asm.size[1:] == pytest.approx(edges)
    tall = 1.0  # they stand side by side
    expected = max(np.median(edges) / 30, min(edges) / 20) + 3e-6 * np.median(edges) * tall**2
    assert default_threshold(asm) == pytest.approx(expected, rel=1e-12)
    alike = rows([(0.5, 0.5, 0.5), (0.6, 0.6, 0.6)])
    assert default_threshold(alike) == pytest.approx(0.5 / 20 + 3e-6 * 0.55, rel=1e-12)


def test_courses_are_counted_along_gravity():
    asm = rows([(0.2, 0.3, 0.1), (1.0, 0.5, 0.4), (0.9, 0.8, 0.7)])
    assert courses(asm) == pytest.approx(1.0)  # side by side
    aside = asm.with_(gravity=(3.0, 0, 0))  # along x: from 0 to 4.9, and the mean width is .7
    assert courses(aside) == pytest.approx(4.9 / 0.7)
    leaning = asm.with_(gravity=(3.0, 0, -4.0))
    low, high = [], []
    for k, (x, _, z) in enumerate([(0.2, 0.3, 0.1), (1.0, 0.5, 0.4), (0.9, 0.8, 0.7)]):
        low.append(0.6 * 2 * k - 0.8 * z)
        high.append(0.6 * (2 * k + x))
    assert height_of(leaning) == pytest.approx(max(high) - min(low))


def test_a_pillar_far_away_lets_no_tile_move_further():
    # Tiles 30 mm thick beside a pillar of 20 m: it lies on no tile. A pile of bricks has as many courses as bricks.
    tiles = [box((-8, 2 * k, 0), (-7.4, 2 * k + 0.6, 0.03)) for k in range(5)]
    pillar = box((5, 5, 0), (6.5, 6.5, 20))
    assert courses(assembly([GROUND, *tiles, pillar])) == pytest.approx(1.0)
    pile = [box((0, 0, 0.1 * k), (0.3, 0.2, 0.1 * k + 0.1)) for k in range(12)]
    beside = [box((0.3, 0, 0.1 * k), (0.6, 0.2, 0.1 * k + 0.1)) for k in range(4)]
    assert courses(assembly([GROUND, *pile, *beside])) == pytest.approx(12.0)


def test_drops_are_along_gravity_whatever_its_size():
    asm = rows([(1, 1, 1)], gravity=(3.0, 0, -4.0))
    moved = np.array([[[1.0, 2.0, -3.0], [0.5, 1.0, 0.5]]])
    np.testing.assert_allclose(drops(asm, moved), [[3.0, -0.1]])


def test_the_box_of_a_group_follows_its_corners():
    asm = rows([(1, 1, 1), (1, 2, 1), (1, 1, 3)])
    turn = Rotation.from_rotvec([0, 0, np.pi / 2]).as_matrix()
    rotation = np.tile(np.eye(3), (4, 1, 1))
    rotation[2] = turn
    moved = np.zeros((4, 3))
    moved[2], moved[3], moved[1] = (1, 0, 0), (0, 0, 2), (50, 50, 50)
    # b1 stands at x 2..3, y 0..2, turns about (2.5, 1) to x 1.5..3.5, y .5..1.5, and moves by 1; b2 rises by 2.
    low, high = np.array([2.5, 0.0, 0.0]), np.array([5.0, 1.5, 5.0])
    np.testing.assert_allclose(group_box_centre(asm, np.array([2, 3]), moved, rotation), (low + high) / 2)


def test_angles_are_since_the_first_frame_up_to_half_a_turn():
    given = np.array([[0.3, 0.1], [0.3, -0.2], [1.3, 0.1], [0.3 + np.pi, 0.4]])
    rotation = Rotation.from_rotvec(given.reshape(-1, 1) * [[0.0, 0.6, 0.8]]).as_matrix().reshape(4, 2, 3, 3)
    np.testing.assert_allclose(angles(rotation), np.abs(given - given[0]), atol=1e-7)


def test_the_rate_is_over_the_window_or_a_third_of_the_run():
    times = np.linspace(0, 6, 61)
    moved = np.zeros((61, 2, 3))
    moved[:, 0, 1] = 1e-3 * times**2
    # Over half a second 11.5 mm/s at the end; over a third of the run, 2 s, 10 mm/s.
    assert rate(times, moved, 0.5) == pytest.approx(10e-3)
    assert rate(times, moved, 3.0) == pytest.approx(9e-3)
    slowing = np.zeros((61, 1, 3))
    slowing[:, 0, 2] = -1e-3 * (12 * times - times**2)
    assert rate(times, slowing, 1.0) == pytest.approx(1e-3)
    steps = np.arange(5) * 0.1  # .3 is a little more there than .2 and .1
    kinked = np.zeros((4, 1, 3))
    kinked[:, 0, 0] = [0.0, 0.0, 0.3, 0.4]
    assert rate(steps[:4], kinked, 0.2) == pytest.approx(0.4 / 0.2)
    assert rate(times[:1], moved[:1], 0.5) == 0.0
    assert rate(times[:2], moved[:2], 0.5) == pytest.approx(1e-4)
    assert rate(times, moved, 99.0) == pytest.approx(6e-3)
    away = moved.copy()
    away[:, 1] = [3e-3, -4e-3, 0] * times[:, None]
    assert rate(times, away, 3.0) == pytest.approx(9e-3)
    away[:, 1] *= 2
    assert rate(times, away, 3.0) == pytest.approx(10e-3)


def test_a_trend_is_the_parabola_of_least_squares_with_its_standard_error():
    random = np.random.default_rng(4)
    times = np.sort(random.uniform(2, 5, 12))
    values = random.normal(size=(12, 3))
    velocity, error = trend(times, values)
    middle, end = (times[0] + times[-1]) / 2, times[-1]
    for column in range(3):
        c, cov = np.polyfit(times - end, values[:, column], 2, cov="unscaled")
        left = values[:, column] - np.polyval(c, times - end)
        assert velocity[0, column] == pytest.approx(2 * c[0] * (middle - end) + c[1])
        assert velocity[1, column] == pytest.approx(c[1])
        assert error[column] == pytest.approx(np.sqrt(left @ left / (12 - 3) * cov[1, 1]))


def first_rest(position, window=0.5, threshold=0.01, start=0.0, step=0.02):
    """When a motion first counts as rest; None: not in 200 looks."""
    rest = RestDetection(threshold, window)
    for k in range(200):
        time = start + step * k
        if rest.look(time, np.asarray(position(time), dtype=float).reshape(-1, 3)):
            return time
    return None


def test_rest_needs_half_a_window_after_release_and_eight_looks():
    assert first_rest(lambda t: (0, 0, 0)) == pytest.approx(0.26, abs=1e-9)  # the first look from a quarter second on
    assert first_rest(lambda t: (0, 0, 0), start=-0.3) == pytest.approx(0.26, abs=0.021)
    assert first_rest(lambda t: (0, 0, 0), step=0.05) == pytest.approx(0.35)
    assert first_rest(lambda t: (0, 0, 0), step=0.07) == pytest.approx(0.49)
    assert first_rest(lambda t: (0, 0, 0), step=0.1) == pytest.approx(0.7)  # the last eight looks
    assert first_rest(lambda t: (0, 0, 0), step=0.6) == pytest.approx(4.2)
    assert first_rest(lambda t: (0.005 * t**2, 0, 0), step=0.1) is None  # 2 x (1/8 threshold) / window^2
    rest = RestDetection(0.01, 0.5)
    assert not any(rest.look(-k * 0.1, np.zeros((1, 3))) for k in range(9, 0, -1))


@pytest.mark.parametrize("changes", [{"look_every": 0.1}, {"look_every": 1.5}, {"resolution": 0.02}])
def test_a_block_at_rest_rests_however_few_looks_a_window_has(changes):
    assert verify(stack(1), settings=Settings.named("fast", **changes)).outcome is DynamicOutcome.STANDS


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_steady_motion_rests_below_a_quarter_of_the_least_velocity(axis):
    # 2 x (1/8 threshold) / window / 4.
    least = 2 * 0.01 / 8 / 0.5 / 4
    for factor, found in ((0.98, True), (1.02, False)):
        for sign in (1, -1):
            move = lambda t, s=sign, f=factor: np.eye(3)[axis] * s * f * least * t  # noqa: E731
            assert (first_rest(move) is not None) is found
    both = lambda t: [(0, 0, 0), np.array([0.75, 0.75, 0]) * least * t]  # noqa: E731
    assert first_rest(both) is None
    assert first_rest(lambda t: [(0, 0, 0), np.array([0.69, 0.69, 0]) * least * t]) is not None
    assert first_rest(lambda t: np.array([1.02 * least * t, 0, 0]), threshold=0.011) is not None


def test_loads_change_for_the_last_time_when_the_last_of_them_ends():
    asm = rows([(1, 1, 1), (0.5, 1, 1)])
    push = Constant((0.1, 0, 0))
    assert last_change([]) == -np.inf
    assert np.isinf(last_change([push]))
    removal = Removal("b0", time=1.5)
    assert last_change([removal, Removal("b1", time=0.5)]) == pytest.approx(max(removal.end, 0.5))
    assert stays(asm, []).tolist() == [1, 2]
    assert stays(asm, [push]).tolist() == [1, 2]
    assert stays(asm, [Removal("b0")]).tolist() == [2]
    assert stays(asm, [Removal("b1"), Removal(["b0"])]).tolist() == []
    assert threshold_under(asm, []) == threshold_under(asm, [push]) == default_threshold(asm)
    sizes = np.median(asm.size[1:])
    assert threshold_under(asm, [Removal("b0")]) == pytest.approx(sizes)
    way = Settlement("ground", [(0.03, 0, 0), (0.03, 0.04, 0)], 0.1)
    assert threshold_under(asm, [way]) == pytest.approx(sizes + 0.05)
    assert threshold_under(asm, [way, way], 0.01) == pytest.approx(0.11)
    assert threshold_under(asm, [Removal("b0")], 0.01) == threshold_under(asm, [], 0.01) == 0.01


def test_runs_follow_from_the_settings_and_the_longest_chain():
    asm = stack(30)
    joints = find_interfaces(asm)
    given = Settings(time_step=1e-3, quick_step=2e-3, fine_step=5e-4, iterations=50, fine_iterations=100)
    found = stages(asm, given, joints)
    assert (found.first.iterations, found.fine.iterations, found.check.iterations) == (60, 120, 60)
    assert (found.first.time_step, found.check.time_step, found.fine.time_step) == (1e-3, 2e-3, 5e-4)
    assert (found.first.settle_step, found.check.settle_step, found.fine.settle_step) == (2e-3, None, 2e-3)
    own = stages(asm, replace(given, settle_step=1.5e-3), joints)
    assert (own.first.settle_step, own.check.settle_step) == (1.5e-3, None)
    many = stages(asm, replace(given, iterations=500, fine_iterations=700), joints)
    assert (many.first.iterations, many.fine.iterations) == (500, 700)
    even = stages(asm, replace(given, quick_step=1e-3), joints)
    assert even.check is None
    assert even.first.settle_step is None
    assert even.fine.time_step == 5e-4
    single = stages(asm, replace(given, fine_step=1e-3), joints)
    assert (single.first, single.check, single.fine) == (replace(given, fine_step=1e-3), None, None)


def test_a_chain_is_the_way_to_the_nearest_support():
    blocks = [box((k, 0, 0), (k + 1, 1, 1), name=f"c{k}") for k in range(7)]
    for supports, expected in (([0], 6), ([0, 6], 3), ([0, 5], 2), ([3], 3), (range(7), 0)):
        asm = assembly(blocks, supports=list(supports))
        assert joints_to_furthest_block(asm, find_interfaces(asm)) == expected
    apart = assembly([*blocks[:3], box((9, 9, 9), (10, 10, 10), name="apart")], supports=[0])
    assert joints_to_furthest_block(apart, find_interfaces(apart)) == 2
    # Two seats of one block on another are one joint on the way.
    posts = assembly([box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 1, 1)), box((0, 0, 1), (3, 1, 2))], supports=[0, 1])
    joints = find_interfaces(posts)
    twice = replace(joints, pair=np.zeros_like(joints.pair) + (0, 2))
    assert (joints.n_interfaces, joints_to_furthest_block(posts, twice)) == (2, 1)


def test_contact_forces_are_on_the_second_block_and_against_the_first():
    contacts = Contacts(
        np.array([[0, 1], [1, 0], [1, 2], [2, 1]]), np.zeros((4, 3)),
        np.array([[1.0, 2, 3], [10, 20, 30], [100, 0, 0], [0, 0, 7]]),
    )  # fmt: skip
    np.testing.assert_allclose(contacts.on(1), [1 - 10 - 100 + 0, 2 - 20, 3 - 30 + 7])
    np.testing.assert_allclose(contacts.on(0), [-1 + 10, -2 + 20, -3 + 30])
    found = contacts.between()
    assert list(found) == [(0, 1), (1, 2)]
    np.testing.assert_allclose(found[0, 1], [1 - 10, 2 - 20, 3 - 30])
    np.testing.assert_allclose(found[1, 2], [100, 0, -7])


def poses(asm):
    return np.zeros((asm.n_blocks, 3)), np.tile(np.eye(3), (asm.n_blocks, 1, 1))


def test_joints_that_turn_as_a_whole_neither_open_nor_slide():
    asm = assembly([
        box((-2, -2, -1), (2, 2, 0), group="g"), box((0, 0, 0), (1, 1, 1), group="w"),
        box((0, 0, 1), (1, 1, 2), group="w"), box((0, 0, 2), (1, 1, 2.2), group="top"),
    ])  # fmt: skip
    turn = Rotation.from_rotvec([0.2, -0.1, 0.4]).as_matrix()
    moved, turned = poses(asm)
    for block in (1, 2, 3):
        arm = asm.centroid[block] - asm.centroid[1]
        moved[block], turned[block] = turn @ arm - arm + [0, 0, 0.5], turn
    moved[3] += turn @ [0.06, 0.08, 0.03]  # the top slides and lifts in the frame of what it lies on
    found = find_cracks(asm, poses(asm), (moved, turned))
    row = {tuple(pair): k for k, pair in enumerate(found.pair.tolist())}
    assert found.opening[row[1, 2]] == pytest.approx(0.0, abs=1e-12)
    assert found.slip[row[1, 2]] == pytest.approx(0.0, abs=1e-12)
    assert found.opening[row[2, 3]] == pytest.approx(0.03)
    assert found.slip[row[2, 3]] == pytest.approx(0.1)
    assert found.threshold[row[2, 3]] == pytest.approx(0.01 * np.cbrt(0.2))
    assert found.per_group() == {"g | w": 1, "top | w": 1}
    since = find_cracks(asm, (moved, turned), (moved, turned))
    assert since.n_cracks == 0
    assert since.explain() == "Cracks: 0 of 3 joints."
    assert since.outcome.word == "sound"
    closing = poses(asm)
    closing[0][3] = 0, 0, -0.5
    assert find_cracks(asm, poses(asm), closing).opening.max() == 0.0


def test_cracks_are_counted_by_group_most_first_and_then_by_name():
    groups = ["", "b", "b", "a", "a", "c"]
    blocks = [box((k, 0, 0), (k + 1, 1, 1), group=g, name=f"c{k}") for k, g in enumerate(groups)]
    asm = assembly([*blocks, box((6, 0, 0), (7, 1, 1), group="c", name="c6"), box((7, 0, 0), (8, 1, 1), name="c7")])
    moved, turned = poses(asm)
    moved[:, 2] = [0, 1, 0, 1, 0, 1, 0, 1]
    found = find_cracks(asm, poses(asm), (moved, turned), threshold=0.5)
    assert found.n_cracks == 7
    assert list(found.per_group().items()) == [
        (" | b", 1), (" | c", 1), ("a", 1), ("a | b", 1), ("a | c", 1), ("b", 1), ("c", 1),
    ]  # fmt: skip
    assert found.explain(2).endswith("( | b 1,  | c 1 and 5 more groups).")
    assert found.explain(7).endswith("b 1, c 1).")
    assert found.summary() == {
        "outcome": "cracked", "sentence": found.outcome.value, "cracks": found.per_group(), "n_cracks": 7,
        "n_interfaces": 7,
    }  # fmt: skip
    assert find_cracks(asm, poses(asm), (moved, turned), threshold=1.0).n_cracks == 0
    plain = asm.with_(groups=("",) * 8)
    told = find_cracks(plain, poses(asm), (moved, turned)).explain()
    assert told == "Cracks: 7 of 7 joints (7 without a group)."


@dataclass
class Drive:
    """Blocks that move as is said, on ice: velocities [m/s] and spins [rad/s] by number, from a time on."""

    velocities: dict
    each_step: bool = False
    start: float = 0.0

    def begin(self, world):
        pass

    def act(self, world, time):
        for block, (linear, angular) in self.velocities.items() if time >= self.start - 1e-9 else ():
            world.set_velocity(block, np.array(linear, dtype=float), np.array(angular, dtype=float))


def ice(**options):
    return rows([(1, 1, 0.3)] * 3, friction=0.0, gravity=(0, 0, -9.81), **options)


def driven(motions, asm=None, **options):
    return verify(ice() if asm is None else asm, actions=[Drive(motions)], **options)


def test_a_verdict_names_what_moved_when_and_how_far():
    still = (0, 0, 0)
    found = driven({1: ((0.12, 0, 0), still), 2: ((0, -0.1, 0), still), 3: ((0.001, 0, 0), still)})
    threshold = default_threshold(ice())
    assert found.outcome is DynamicOutcome.FALLS
    assert (found.brick_threshold, found.roof_threshold, found.turn_threshold) == pytest.approx((threshold,) * 3)
    assert found.first_block == "b0"
    assert found.first_time == pytest.approx(threshold / 0.12, abs=0.06)
    assert found.moved.tolist() == [1]
    assert found.max_displacement == pytest.approx(0.12 * found.run.times[-1], rel=0.02)
    np.testing.assert_allclose(found.displacement[2], [0, -0.1 * found.run.times[-1], 0], atol=1e-3)
    assert found.rate == pytest.approx(0.12, rel=0.03)
    assert found.max_drop == pytest.approx(0.0, abs=1e-3)
    assert (found.passes_eq1, found.passes_eq2) == (True, True)
    assert found.settling == np.linalg.norm(found.run.displacement[0], axis=1).max()
    assert found.settling < 1e-3 < np.linalg.norm(found.run.displacement[1], axis=1).max()
    assert found.summary()["moved"] == ["b0"]
    assert f"First to move: b0, at {found.first_time:.2g} s. Moved: b0." in found.explain()


def test_thresholds_that_are_given_count():
    still = (0, 0, 0)
    motions = {1: ((0.05, 0, 0), still), 2: ((0.1, 0, 0), still)}
    found = driven(motions, settings=Settings(brick_threshold=0.03, roof_threshold=0.04))
    assert (found.brick_threshold, found.roof_threshold) == (0.03, 0.04)
    assert found.max_displacement == pytest.approx(0.04, abs=0.01)  # the run ends at the larger one
    assert found.max_displacement >= 0.04
    assert found.moved.tolist() == [2]
    # Where the fast block has gone .03 to .04 the slow one has gone half of that.
    for crack_threshold, cracks in ((0.010, 2), (0.025, 1)):
        given = Settings(brick_threshold=0.03, roof_threshold=0.01, crack_threshold=crack_threshold)
        small = driven(motions, settings=given)
        assert 0.03 <= small.max_displacement < 0.04
        assert small.cracks.n_cracks == cracks
        assert (small.cracks.threshold == crack_threshold).all()


@pytest.mark.parametrize(("drop", "passes"), [
    (0.0, (True, True)), (0.124, (True, True)), (0.125, (False, True)), (0.25, (False, True)), (0.499, (False, True)),
    (0.5, (False, False)), (0.75, (False, False)),
])  # fmt: skip
@pytest.mark.parametrize("at_rest", [True, False])
def test_a_drop_by_the_threshold_of_its_group_is_a_fall(drop, passes, at_rest):
    asm = rows([(1, 1, 1)] * 2, gravity=(0, 0, -4.0))
    settings = Settings(roof_threshold=0.125, brick_threshold=0.5)
    evaluator = _Evaluator(asm, settings, [], [], find_interfaces(asm))
    made = simulate(asm, settings=Settings(end=0.1, settle=0.02))
    moved = np.zeros_like(made.displacement)
    moved[-1, 1:, 2] = -drop
    run = replace(made, displacement=moved, rotation=np.tile(np.eye(3), (*moved.shape[:2], 1, 1)))
    found = evaluator._verdict(run, settings, at_rest)
    assert (found.group_drop, found.max_drop, found.max_displacement) == (drop, drop, drop)
    assert (found.passes_eq1, found.passes_eq2) == passes
    still = DynamicOutcome.STANDS if at_rest else DynamicOutcome.CREEPS
    assert found.outcome is (still if all(passes) else DynamicOutcome.FALLS)
    assert found.moved.tolist() == ([] if passes[1] else [1, 2])


def test_blocks_that_turn_are_judged_at_half_their_size():
    found = driven({1: ((0, 0, 0), (0, 0, 0.5))})
    size = ice().size[1]
    assert found.outcome is DynamicOutcome.FALLS
    assert found.max_rotation == pytest.approx(np.degrees(0.5 * found.run.times[-1]), rel=0.05)
    assert found.max_turn == pytest.approx(np.radians(found.max_rotation) * 0.5 * size, rel=1e-6)
    assert found.max_turn >= found.turn_threshold
    assert found.first_block == "b0"


def test_a_verdict_says_what_it_is_of():
    found = driven({1: ((0.3, 0, 0), (0, 0, 0))})
    told = replace(
        found, group="vault.a", group_drop=0.0021, max_drop=0.0032, settling=0.1, falls_alone=True, warnings=("w",),
        moved=np.array([2, 1, 3]), first_block="b1", first_time=0.25, rate=0.5, max_rotation=12.3, max_turn=0.0456,
        roof_threshold=0.002, brick_threshold=0.0033,
    )  # fmt: skip
    assert (told.passes_eq1, told.passes_eq2) == (False, True)
    assert (replace(told, group_drop=0.002).passes_eq1, replace(told, max_drop=0.0033).passes_eq2) == (False, False)
    lines = told.explain(limit=2).splitlines()
    assert lines[0] == DynamicOutcome.FALLS.value
    assert lines[1].startswith("It falls without the loads that change, too")
    assert "Eq. 1: vault.a dropped 2.1 mm (threshold 2 mm)." in lines[2]
    assert "Eq. 2: largest drop of a block 3.2 mm (threshold 3.3 mm)." in lines[2]
    assert "rate at the end 500 mm/s. Largest rotation 12 degrees" in lines[2]
    assert "by up to 46 mm" in lines[2]
    fine = replace(told, group_drop=1.2345e-3, max_drop=2.345e-3, max_displacement=3.456e-3, rate=4.567e-3)
    figures = replace(fine, max_turn=5.678e-3, turn_threshold=6.789e-3).explain()
    assert "dropped 1.2 mm " in figures
    assert "largest drop of a block 2.3 mm " in figures
    assert "Largest displacement 3.5 mm, rate at the end 4.6 mm/s." in figures
    assert "by up to 5.7 mm (threshold 6.79 mm)." in figures
    assert lines[3] == "First to move: b1, at 0.25 s. Moved: b1, b0 and 1 more."
    assert lines[-1] == "Warning: w"
    assert "Moved: b1, b0, b2." in told.explain(limit=3)
    assert "whole assembly dropped" in replace(told, group="").explain()
    assert replace(told, run=replace(told.run, engine="lmgc90")).explain().startswith(f"{lines[0]} (LMGC90)")
    assert "would have shown" not in told.explain()
    stands = replace(told, outcome=DynamicOutcome.STANDS, resolution=1e-3, moved=np.array([], dtype=int))
    assert "An imbalance of 0.001 of the weight would have shown." in stands.explain()
    assert "First to move" not in stands.explain()
    plain = told.summary()
    expected = {
        "verdict": "falls", "engine": "bullet", "group": "vault.a", "group_drop": 0.0021, "max_drop": 0.0032,
        "max_rotation_deg": 12.3, "max_turn": 0.0456, "rate": 0.5, "settling": 0.1, "roof_threshold": 0.002,
        "brick_threshold": 0.0033, "falls_alone": True, "passes_eq1": False, "passes_eq2": True, "first_block": "b1",
        "first_time": 0.25, "moved": ["b1", "b0", "b2"], "blocks": 4, "warnings": ["w"],
        "simulated_seconds": told.run.times[-1],
    }  # fmt: skip
    assert {key: plain[key] for key in expected} == expected


def test_a_group_that_sinks_fails_equation_one_where_no_block_is_beyond_its_own():
    groups = ["", "vault", "vault.b", "walls"]
    blocks = [GROUND, *(box((2 * k, 0, 0), (2 * k + 1, 1, 1), group=g, name=f"c{k}") for k, g in enumerate(groups))]
    asm = assembly(blocks, gravity=(0, -9.81, 0), friction=0.0)  # along -y: they slide down a wall
    found = verify(asm, settings=Settings(brick_threshold=0.5, roof_threshold=0.1, fine_step=1e-3))
    assert found.group == "vault"
    assert found.group_drop >= 0.1
    assert found.outcome is DynamicOutcome.FALLS
    assert found.group_drop == pytest.approx(found.max_drop, rel=0.02)
    whole = verify(asm, settings=Settings(brick_threshold=0.5, roof_threshold=0.1, fine_step=1e-3, group="walls"))
    assert whole.group == "walls"
    none = verify(asm.with_(groups=("",) * 5), settings=Settings(brick_threshold=0.1, fine_step=1e-3))
    assert none.group == ""
    assert none.summary()["group_drop"] == pytest.approx(none.max_drop, rel=0.02)


def test_statics_tell_without_a_run_whether_blocks_fall_without_the_loads_that_change(monkeypatch):
    runs, run = [], judging.simulate
    monkeypatch.setattr(judging, "simulate", lambda *args, **options: runs.append(1) or run(*args, **options))
    found = verify(stack(3, 1.0, 1.0), loads=[Removal(["stone0", "stone1"])])
    assert (found.outcome, found.falls_alone, len(runs)) == (DynamicOutcome.FALLS, False, 1)


def test_a_run_tells_what_falls_without_the_loads_that_change_where_statics_leave_it_open():
    walls = [box((-1, 0, 0), (0, 1, 4), name="left"), box((1, 0, 0), (2, 1, 4), name="right")]
    blocks = [*walls, box((0, 0, 2), (1, 1, 3), name="between"), box((5, 0, 0), (6, 1, 1), name="stout")]
    ground = box((4, -1, -1), (7, 2, 0), name="ground")
    asm = assembly([ground, *blocks], supports=["ground", "left", "right"], friction=0.5)
    assert assess(asm, flow="coulomb").outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    found = verify(asm, loads=[Removal("stout", time=0.1)])
    assert (found.outcome, found.first_block, found.falls_alone) == (DynamicOutcome.FALLS, "between", True)


def test_blocks_that_do_not_settle_begin_where_they_were_built():
    asm = stack(2, 1.0, 1.0)
    run = simulate(asm, settings=Settings(settle=1e-3, end=0.1, resolution=0.1))
    assert run.times[0] == 0.0
    np.testing.assert_allclose(run.displacement[0], 0.0, atol=1e-9)
    assert np.abs(run.displacement[-1]).max() > 1e-9


def test_weaker_glue_is_tried_under_loads_and_not_with_actions():
    law = JointLaw(("*", "*"), bond=1e3)  # a thousand times the weight
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="block")], supports=["ground"], joints=[law])
    for loads in ([], [Constant((0.5, 0, 0))], [Tilt((0, 1, 0), 1.0, rate=9.0)]):
        found = verify(asm, settings=Settings(end=0.5), loads=loads)
        assert found.outcome is DynamicOutcome.STANDS
        whole = ", which never came apart" if isinstance(loads and loads[0], Tilt) else ""
        assert found.warnings == (
            f"it stands with glue of no more than the weight of all blocks and the loads on them a joint{whole}, so it "
            "stands with the stronger glue given",
        )
    found = verify(asm, settings=Settings(end=0.5), actions=[InertiaScale(2.0)])
    assert found.outcome is DynamicOutcome.STANDS
    assert not any("weight" in text for text in found.warnings)


def test_weaker_glue_holds_the_weight_and_the_loads():
    # A cube of 1 N: pushed by 3 N and turned by 2 N m, which at its size of 1 m count as 2 N.
    glued = JointLaw(("*", "*"), bond=1e9)
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="block")], supports=["ground"], joints=[glued])
    wrench = np.array([[9.0] * 6, [0, 0, 3.0, 0, 2.0, 0]])  # what acts on a support counts for nothing
    for loads, most in (([], 1), ([Constant((0, 0, 3.0))], 4), ([Constant(wrench)], 6), ([Constant(wrench)] * 2, 11)):
        (law,) = weakened(asm, find_interfaces(asm), loads).joints
        assert law.bond == pytest.approx(most)


def test_glue_far_stronger_than_loads_ask_for_stands_under_them():
    """Two cubes of 3.3 kN each, that a push of .5 W would tip if they were dry, and a push that is next to none."""
    cubes = [box((0, 0, 0), (0.5, 0.5, 0.5)), box((0, 0, 0.5), (0.5, 0.5, 1))]
    asm = assembly([GROUND, *cubes], gravity=(0, 0, -9.81), density=2690.0, joints=[JointLaw(("*", "*"), bond=1e9)])
    for push in (1e-6, 6.0):
        found = verify(asm, loads=[Constant((push, 0, 0))])
        assert found.outcome is DynamicOutcome.STANDS
        assert found.settling < 1e-3
    # The film is of the same blocks: to go on with the stronger glue would fell them.
    film = past_verdict(found, 0.2, loads=[Constant((6.0, 0, 0))])
    assert np.abs(film.since_release[-1]).max() < 1e-3


def test_a_search_ends_where_all_multiples_of_a_load_move_the_blocks():
    asm, joints = foot(1.0)

    class Fragile(_Search):
        def stands(self, multiplier):
            self.trials.append(Trial(multiplier, "falls" if multiplier else "stands", 0.0, 1.0, 1.0))
            return not multiplier

    for guess in (0.5, None):
        search = Fragile(asm, np.array([1.0, 0, 0]), (), None, joints, 0.1, None, unbounded=False)
        outcome, low, high = search.bracket(guess)
        first = max(trial.multiplier for trial in search.trials)
        assert (outcome, low) == (LimitOutcome.LIMIT, 0.0)
        assert 1e-7 * first < high <= 1e-6 * first
        (text,) = limit_warnings(search.trials, low, high)
        assert text == f"it moved down to a multiplier of {high:.5g}; smaller ones above 0 were not tried"


def test_glued_blocks_settle_for_a_tenth_of_a_second_more(monkeypatch):
    settled, run = [], judging.simulate

    def noted(*args, settings, **options):
        settled.append(settings.settle)
        return run(*args, settings=settings, **options)

    monkeypatch.setattr(judging, "simulate", noted)
    for bond in (0.0, 0.5):
        asm = assembly(
            [GROUND, box((0, 0, 0), (1, 1, 1))], supports=["ground"], joints=[JointLaw(("*", "*"), bond=bond)]
        )
        verify(asm, settings=Settings(end=0.5, settle=0.2))
    assert settled == pytest.approx([0.2, 0.3])


def runs_noted(monkeypatch):
    """Settings and process times of all runs that are made from now on."""
    asked, times, run = [], [], judging.simulate

    def noted(*args, settings, **options):
        found = run(*args, settings=settings, **options)
        asked.append((settings.settle, settings.end))
        times.append(found.process_seconds)
        return found

    monkeypatch.setattr(judging, "simulate", noted)
    return asked, times


def glued_cube(strength):
    """A cube under a ceiling, glued with a share of its weight."""
    law = JointLaw(("*", "*"), bond=strength)
    return assembly([box((-1, -1, 1), (2, 2, 2), name="ceiling"), box((0, 0, 0), (1, 1, 1), name="bell")], joints=[law])


def test_a_run_without_the_loads_that_change_settles_as_long_and_counts(monkeypatch):
    # Its weight alone pulls the cube off; with an action beside it statics are not asked.
    asked, times = runs_noted(monkeypatch)
    found = verify(
        glued_cube(0.5), settings=Settings(settle=0.2, end=0.7), loads=[Push("bell", velocity=(0.01, 0, 0))],
        actions=[InertiaScale(1.0)],
    )  # fmt: skip
    assert found.falls_alone
    np.testing.assert_allclose(asked, [(0.3, 2.1), (0.3, 0.7)])
    assert found.process_seconds == pytest.approx(sum(times))


def test_a_trial_with_weaker_glue_that_fails_counts(monkeypatch):
    # W L / 2 = F a / 2 about the lower edge: the beam of W = .5, L = 2, a = .5 needs F = 2, four times its weight.
    wall, beam = box((-1, 0, -1), (0, 0.5, 1), name="wall"), box((0, 0, -0.25), (2, 0.5, 0.25), name="beam")
    asm = assembly([wall, beam], friction=5.0, joints=[JointLaw(("*", "*"), bond=2.2)])
    _, times = runs_noted(monkeypatch)
    found = verify(asm)
    assert found.outcome is DynamicOutcome.STANDS
    assert len(times) == 2
    assert found.process_seconds == pytest.approx(sum(times))


@pytest.mark.parametrize("settle", [0.02, 0.04, 0.06, 0.2])
def test_blocks_are_let_go_with_the_time_step_of_the_free_run(settle):
    steps = []

    class Noted:
        each_step = True

        def begin(self, world):
            pass

        def act(self, world, time):
            steps.append((time * world.time, world.time_step * world.time))

    simulate(stack(1), settings=Settings(settle=settle, settle_step=2e-3, end=0.1, resolution=0.1), actions=[Noted()])
    time, step = np.array(steps).T
    np.testing.assert_allclose(step[time > -0.19 * settle], 1e-3)


def test_what_falls_at_every_multiplier_has_no_limit():
    asm, joints = foot(1.0)
    tried = []

    class Falling(_Search):
        def stands(self, multiplier):
            tried.append(multiplier)
            return False

    search = Falling(asm, np.zeros((2, 6)), (), None, joints, 0.1, None, unbounded=False)
    assert search._below(0.5) == (None, None)
    assert tried[0] == pytest.approx(0.49)
    assert tried[-1] == 0.0
    assert sorted(tried, reverse=True) == tried
    tried.clear()
    assert search._from_nothing() == (None, None)
    assert tried == [0.0]


def test_a_group_that_is_taken_out_does_not_drop():
    asm = assembly(
        [GROUND, box((0, 0, 0), (1, 1, 1), name="key", group="vault"), box((3, 0, 0), (4, 1, 1))], supports=["ground"]
    )
    found = verify(asm, settings=Settings(end=0.5), loads=[Removal("key")])
    assert (found.outcome, found.group, found.group_drop) == (DynamicOutcome.STANDS, "vault", 0.0)


def test_blocks_that_are_taken_out_do_not_count():
    asm = stack(2, 1.0, 1.0)
    found = verify(asm, loads=[Removal("stone1")])
    assert found.outcome is DynamicOutcome.STANDS
    assert found.max_displacement < 0.1
    assert not found.falls_alone
    lost = verify(stack(3, 1.0, 1.0), loads=[Removal(["stone0", "stone1"])])
    assert (lost.outcome, lost.first_block, lost.falls_alone) == (DynamicOutcome.FALLS, "stone2", False)
    pair = [box((0, 0, 0), (0.5, 1, 4), name="thin"), box((4, 0, 0), (6, 1, 1), name="stout")]
    leaning = assembly([GROUND, *pair], gravity=(0.3, 0, -1), friction=0.9)
    alone = verify(leaning, loads=[Removal("stout", time=0.1)])
    assert alone.first_block == "thin"
    assert alone.outcome is DynamicOutcome.FALLS
    assert alone.falls_alone


def test_a_run_ends_where_it_is_told_to_and_tells_its_progress():
    seen, told = [], []

    def stop(time, moved, turned):
        assert turned.shape == (3, 3)
        seen.append((time, moved))
        return time >= 0.1

    asm = stack(2, 1.0, 1.0)
    settings = Settings(end=1.0, settle=0.06)
    run = simulate(asm, settings=settings, stop=stop, progress=lambda *step: told.append(step), hold=0.2)
    times = np.array([time for time, _ in seen])
    np.testing.assert_allclose(np.diff(times), times[1] - times[0])
    assert times[0] < 0 <= times[-1]
    assert times[-1] == pytest.approx(0.1, abs=0.021)
    assert len(run.times) == len(seen) == len(told)
    assert seen[0][1].shape == (3, 3)
    assert not seen[0][1].any()
    np.testing.assert_allclose(run.since_release[0], 0.0)
    np.testing.assert_allclose([step[0] for step in told], run.times)
    assert len({step[1:] for step in told}) == 1
    _, held, end = told[0]
    assert held >= 0.2 - 1e-9
    assert held == pytest.approx(0.2, abs=2 * (run.times[1] - run.times[0]))
    assert end > held
    whole = simulate(asm, settings=settings)
    assert whole.times[-1] == pytest.approx(end - held, rel=1e-6)
    assert whole.times[0] == 0.0


@pytest.mark.parametrize(("loads", "factor"), [
    ([], 1.0), ([Constant((0.1, 0, 0))], 1.0), ([Removal("stone1", time=0.1)], 3.0),
])  # fmt: skip
def test_after_loads_that_change_a_run_may_take_three_times_as_long(loads, factor):
    steps = []
    found = verify(stack(2, 1.0, 1.0), settings=Settings(end=1.0), loads=loads, progress=lambda *s: steps.append(s))
    _, held, end = steps[0]
    assert (end - held) * found.run.pace == pytest.approx(factor, rel=0.02)


def test_the_last_fifth_of_settling_has_the_step_of_the_free_run(monkeypatch):
    steps, advance = [], World.advance

    def noted(world, time=0.0):
        steps.append(world.settings.time_step)
        advance(world, time)

    monkeypatch.setattr(World, "advance", noted)
    simulate(stack(1), settings=Settings(settle=0.4, settle_step=2e-3, end=0.1, resolution=0.1, look_every=0.02))
    settling = round(0.4 / 0.02)
    assert steps[:settling] == [2e-3] * 16 + [1e-3] * 4
    assert set(steps[settling:]) == {1e-3}


def test_a_refusal_names_the_widest_joint_and_the_furthest_fall():
    asm = open_stack(2, 1.2504e-2)  # 13 mm in two digits; a thousandth less would be 12
    joints = find_interfaces(asm, gap="20 mm")
    told = _refusal(asm, joints, np.ones(joints.n_interfaces, dtype=bool), joints.gap)
    assert "faces are off by 13 mm" in told
    assert "In Bullet blocks would fall by 13 mm until they touch" in told


def test_energies_of_a_falling_block_add_up():
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 2, 3), density=5.0)], gravity=(0, 0, -9.81))
    run = simulate(asm, settings=Settings(end=0.6))
    fallen = -run.since_release[:, 1, 2]
    mass = 5.0 * 6
    late = run.times > 0.2
    speed = np.gradient(run.displacement[:, 1, 2], run.times)
    np.testing.assert_allclose(run.kinetic[late][:-1], (mass * speed**2 / 2)[late][:-1], rtol=0.02)
    np.testing.assert_allclose(run.potential - run.potential[0], -mass * 9.81 * fallen, rtol=1e-6, atol=1e-6)
    spin = simulate(
        ice(), settings=Settings(end=0.3), actions=[Drive({1: ((0.1, 0.2, 0), (0, 0, 0.6))})]
    )  # fmt: skip
    inertia = ice().inertia[1][2, 2]
    expected = (0.3 * 0.05 + inertia * 0.36) / 2
    assert spin.kinetic[-1] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("n", "pace"), [(5, 1.0), (9, (2.7 / 2) ** -0.5), (15, 1.5**-1)])
def test_times_grow_with_the_root_of_the_height_above_two_metres(n, pace):
    pile = assembly(
        [GROUND, *(box((0, 0, 0.3 * k), (0.3, 0.3, 0.3 * (k + 1))) for k in range(n))], gravity=(0, 0, -9.81)
    )
    run = simulate(pile, settings=Settings(end=0.06, settle=0.02))
    assert run.pace == pytest.approx(pace, rel=0.03)
    assert run.times[-1] >= 0.06 / pace * 0.9


def test_a_removal_is_noted_at_its_time():
    run = simulate(stack(2, 1.0, 1.0), settings=Settings(end=0.5), loads=[Removal("stone1", time=0.2)])
    assert np.isinf(run.removed[:2]).all()
    step = run.times[1] - run.times[0]
    assert run.removed[2] == pytest.approx(0.2, abs=1.01 * step)


@pytest.mark.parametrize(("width", "asked", "found"), [
    (0.0205, 1e-3, 1e-3), (0.0195, 1e-3, 1e-4), (0.0195, 1e-5, 1e-5), (0.0205, 1e-5, 1e-5),
])  # fmt: skip
def test_a_run_resolves_less_where_statics_prove_two_percent_of_reserve(width, asked, found):
    asm = assembly([GROUND, box((0, 0, 0), (width, 3 * width, 1.0), name="pillar")], friction=0.7)
    reserve = StaticReserve(asm, find_interfaces(asm))
    assert reserve.sideways == pytest.approx(width, rel=0.02)
    assert reserve.resolution(asked) == found


def test_without_an_equilibrium_a_run_resolves_more():
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="b")], gravity=(0.8, 0, -1.0))
    reserve = StaticReserve(asm, find_interfaces(asm))
    assert not reserve.equilibrium
    assert reserve.resolution(1e-3) == 1e-4


#: One run for each trial, of two courses of the tests: what is tested is where a search goes.
QUICK = Settings(time_step=2e-3, quick_step=2e-3, fine_step=2e-3, end=1.0)


def foot(factor, x=1.0, place=0.0):
    """A block of 1 x 2 m, and joints of which the foot is wider or narrower than it is."""
    asm = assembly([box((-9, -9, -1), (x, 9, 0), name="ground"), box((place, 0, 0), (place + 1, 1, 2), name="b")])
    asm = asm.with_(friction=3.0)
    joints = find_interfaces(asm)
    middle = asm.centroid[1] * [1, 1, 0]
    return asm, replace(joints, point=middle + factor * (joints.point - middle))


@pytest.mark.parametrize("factor", [2.0, 1.0, 0.5])
def test_a_search_reaches_the_limit_in_bullet_from_either_side(factor):
    asm, joints = foot(factor)
    told = []
    found = limit(asm, (1, 0, 0), settings=QUICK, width=0.1, check=False, interfaces=joints, progress=told.append)
    assert found.static[1] == pytest.approx(0.5 * factor, rel=1e-3)
    assert found.outcome is LimitOutcome.LIMIT
    assert found.lower <= 0.51
    assert found.upper >= 0.49
    assert found.upper - found.lower <= 0.1 * found.upper
    assert tuple(told) == found.trials
    first = [trial.multiplier for trial in found.trials[:2]]
    start = 0.98 * found.static[1]
    second = start - 0.025 * found.static[1] if factor == 2.0 else 1.005 * found.static[1]
    assert first == pytest.approx([start, second], rel=1e-9)
    if factor != 1.0:  # steps double away from where the search began
        tried = np.array([trial.multiplier for trial in found.trials[:4]])
        steps = np.abs(np.diff(tried if factor > 1 else tried[1:]))
        assert steps[1] / steps[0] == pytest.approx(2.0)
    assert found.ratio == pytest.approx((found.lower + found.upper) / 2 / found.static[1])


def test_a_search_goes_on_where_bullet_carries_sixty_times_what_statics_do():
    asm, joints = foot(0.01)
    found = limit(asm, (1, 0, 0), settings=QUICK, width=0.1, check=False, interfaces=joints)
    assert found.static[1] == pytest.approx(0.005, rel=1e-3)
    assert found.outcome is LimitOutcome.LIMIT  # the block tips at half its weight
    assert found.lower <= 0.51
    assert found.upper >= 0.49


def test_what_stands_without_the_load_alone_has_a_limit_above_nothing():
    # The ground ends 2 mm beyond the centroid: it tips at .001 / 1 in Bullet, and statics see the whole foot.
    asm, _ = foot(1.0, x=0.52)
    whole, joints = foot(1.0, x=1.0)
    found = limit(asm, (1, 0, 0), settings=QUICK, width=0.5, check=False, interfaces=joints)
    assert found.outcome is LimitOutcome.LIMIT
    assert found.lower <= 0.021
    assert found.upper >= 0.019
    assert 0.0 in [trial.multiplier for trial in found.trials]
    assert whole.n_blocks == 2


def test_what_does_not_stand_in_bullet_falls_under_its_dead_load():
    asm, _ = foot(1.0, x=0.4)
    _, joints = foot(1.0, x=1.0)
    found = limit(asm, (1, 0, 0), settings=QUICK, width=0.5, interfaces=joints)
    assert found.outcome is LimitOutcome.DEAD_LOAD_FALLS
    assert (found.lower, found.upper) == (-np.inf, -np.inf)
    assert found.trials[-1].multiplier == 0.0
    assert found.trials[-1].verdict == "falls"
    assert "Multiplier between" not in found.explain()


def test_a_limit_says_what_it_rests_on():
    asm, joints = foot(1.0)
    found = limit(asm, (1, 0, 0), settings=replace(QUICK, brick_threshold=0.05), width=0.5, interfaces=joints)
    assert found.threshold == 0.05
    beside = [trial.multiplier for trial in found.trials[-2:]]
    assert beside == pytest.approx([0.95 * found.lower, 1.05 * found.upper])
    lines = found.explain().splitlines()
    assert lines[1] == f"Multiplier between {found.lower:.5g} and {found.upper:.5g}."
    assert lines[2] == f"Static bracket: {found.static[0]:.5g} to {found.static[1]:.5g}."
    assert lines[3] == f"Bullet / static: {found.ratio:.3f}."
    assert "moves by more than 50 mm" in lines[4]
    assert lines[5].startswith(f"{found.trials[0].multiplier:.5g}: {found.trials[0].verdict}, ")
    assert len(lines) == 5 + len(found.trials) + len(found.warnings)
    assert replace(found, lower=0.3, upper=0.5, static=(0.2, 0.8)).ratio == pytest.approx(0.5)
    far = replace(found, static=(np.inf, np.inf))
    assert far.ratio is None
    assert "Statics carry the load without bound." in far.explain()
    open_ = replace(found, static=(0.4, np.inf))
    assert open_.ratio is None
    assert "Static bracket: 0.4 to inf." in open_.explain()
    below = replace(found, static=(-np.inf, -np.inf), upper=np.inf)
    assert below.ratio is None
    assert "By statics it falls without the load, too." in below.explain()
    undecided = replace(found, static=(-np.inf, np.inf)).explain()
    assert "Statics do not decide." in undecided
    assert "it falls without the load" not in undecided
    assert "Static bracket: -inf to 0.5." in replace(found, static=(-np.inf, 0.5)).explain()
    assert replace(found, outcome=LimitOutcome.UNBOUNDED).explain().count("Bullet / static") == 0
    for result, name in ((found, "lower"), (found.trials[0], "multiplier")):
        with pytest.raises(FrozenInstanceError):
            setattr(result, name, 0.0)
    assert found != replace(found)  # results are told apart by identity
    plain = found.summary()
    assert plain["trials"][0]["multiplier"] == found.trials[0].multiplier
    assert (plain["runs"], plain["threshold"], plain["static_lower"]) == (len(found.trials), 0.05, found.static[0])


@pytest.mark.parametrize("width", [9e-5, 0.0, 1.0, 2.0])
def test_the_width_of_a_bracket_is_a_share(width):
    with pytest.raises(InputError, match=r"limit: width is .*; it must be from 0\.0001 to below 1"):
        limit(stack(1), (1, 0, 0), width=width)


def test_a_load_that_statics_carry_by_self_stress_has_a_limit_in_bullet():
    """A block between two walls is lifted by its weight; associated friction would jam it."""
    blocks = [
        GROUND, box((-1, 0, 0), (0, 1, 3), name="left"), box((1, 0, 0), (2, 1, 3), name="right"),
        box((0, 0, 0), (1, 1, 1), name="block"),
    ]  # fmt: skip
    asm = assembly(blocks, supports=["ground", "left", "right"], friction=0.5)
    lift = np.zeros((4, 6))
    lift[3, 2] = 2.0  # twice the weight
    found = limit(asm, lift, settings=QUICK, width=0.2, check=False)
    assert np.isinf(found.static[1])
    assert found.outcome is LimitOutcome.LIMIT
    assert found.lower <= 0.5 * 1.05
    assert found.upper >= 0.5 * 0.95
    tried = [trial.multiplier for trial in found.trials[:3]]
    # The first load is half as strong as the weight, then it doubles.
    assert tried == pytest.approx([0.0, 0.25, 0.5])


def test_plans_are_carried_out_with_dry_joints():
    asm = stack(1).with_(joints=[JointLaw(("*", "*"), bond=1.0)])
    with pytest.raises(InputError, match="sequences are carried out with dry joints; this assembly has joint laws"):
        sequence(asm, Plan((Step(("stone0",)),)))


def test_a_block_is_put_in_where_its_neighbours_have_moved_on_average():
    blocks = [
        box((6, 0, 0), (7, 1, 1), name="far"), GROUND, box((-1, 0, 0), (0, 1, 1), name="side"),
        box((0, 0, 0), (1, 1, 1), name="one"), box((0, 0, 1), (1, 1, 2), name="top"),
        box((0, 0, 2), (1, 1, 3), name="above"),
    ]  # fmt: skip
    asm = assembly(blocks, supports=["ground"], gravity=(9.81 * 0.02, 0, -9.81), friction=0.0)
    names = ("far", "side", "top", "above")
    plan = Plan((Step(("one",)), Step(names, ("one", *names))))
    settings = Settings(settle=0.06, end=0.4, resolution=1e-2, brick_threshold=0.1)
    found = sequence(asm, plan, settings=settings)
    assert [step.outcome.word for step in found.steps] == ["creeps", "stands"]
    moved = {name: found.run.displacement[-1, k] for k, name in enumerate(asm.names)}
    slid = moved["one"][0]
    assert 0.005 < slid < 0.1
    assert slid == pytest.approx(found.steps[0].max_displacement, rel=0.1)
    np.testing.assert_allclose(moved["top"], moved["one"], atol=1e-9)
    np.testing.assert_allclose(moved["above"], moved["one"], atol=1e-9)
    np.testing.assert_allclose(moved["side"], moved["one"] / 2, atol=1e-9)  # beside it and on the ground
    np.testing.assert_allclose(moved["far"], 0.0, atol=1e-9)
    placed = dict(zip(asm.names, found.run.placed, strict=True))
    assert (placed["ground"], placed["one"]) == (-np.inf, 0.0)
    assert {placed[name] for name in names} == {found.steps[0].end}
    # All are held, so that nothing moves; times tell the frames of the two steps apart.
    assert found.steps[1].max_displacement == 0.0
    assert found.steps[1].end > found.steps[0].end
    assert found.run.times[-1] == found.steps[1].end


@pytest.mark.parametrize("gap", [0.0, 0.004])
def test_blocks_rest_as_soon_where_earlier_steps_have_moved_them(gap):
    lower, upper = (box((0, 0, k + gap), (1, 1, k + 1 + gap), name=name) for k, name in enumerate(("one", "top")))
    asm = assembly([GROUND, lower, upper], supports=["ground"], gravity=(0, 0, -9.81), friction=0.7)
    settings = Settings(settle=0.06, end=1.0)
    found = sequence(asm, Plan((Step(("one",)), Step(("top",)))), settings=settings)
    assert [step.outcome.word for step in found.steps] == ["stands", "stands"]
    assert found.run.displacement[-1, 2, 2] == pytest.approx(-gap, abs=2e-5)
    looks = settings.settle + settings.window / 2 + 2 * settings.look_every  # half a window, to whole looks
    assert (found.steps[1].end - found.steps[0].end) * found.run.pace <= looks


def test_blocks_of_a_step_that_falls_are_put_back_and_held():
    blocks = [GROUND, box((0, 0, 0), (1, 1, 1), name="one"), box((4, 0, 0), (5, 1, 1), name="two")]
    asm = assembly(blocks, supports=["ground"], gravity=(9.81 * 0.3, 0, -9.81), friction=0.0)
    plan = Plan((Step(("one",)), Step(("two",), ("one", "two"))))
    settings = Settings(settle=0.06, end=1.0, brick_threshold=0.1)
    found = sequence(asm, plan, settings=settings)
    assert [step.outcome.word for step in found.steps] == ["falls", "stands"]
    assert found.outcome is DynamicOutcome.FALLS
    assert found.first_fall == 0
    np.testing.assert_allclose(found.run.displacement[-1, 1:], 0.0, atol=1e-9)
    assert found.run.displacement[:, 1, 0].max() >= 0.1
    assert found.steps[0].end == pytest.approx(settings.settle + np.sqrt(2 * 0.1 / (9.81 * 0.3)), abs=0.1)


@pytest.mark.parametrize(("tilt", "outcome"), [(0.0, "stands"), (0.02, "creeps"), (0.2, "falls")])
def test_a_step_stands_creeps_or_falls(tilt, outcome):
    """On ice a block slides by g t^2 / 2: by less than a threshold, visibly, or beyond it."""
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="one")], gravity=(9.81 * tilt, 0, -9.81), friction=0.0)
    settings = Settings(settle=0.06, end=0.4, resolution=1e-2, brick_threshold=0.1)
    found = sequence(asm, Plan((Step(("one",)),)), settings=settings)
    (step,) = found.steps
    assert step.outcome.word == found.outcome.word == outcome
    assert found.threshold == 0.1
    assert found != replace(found)
    for result, name in ((found, "threshold"), (step, "end"), (found.run, "pace")):
        with pytest.raises(FrozenInstanceError):
            setattr(result, name, 0.0)
    assert (step.first_block == "one") is (outcome == "falls")
    assert (step.max_displacement >= 0.1) is (outcome == "falls")
    if outcome == "creeps":
        moved = found.run.displacement[-1, 1, 0]
        assert moved == pytest.approx(step.max_displacement, rel=0.1)
    told = found.explain()
    assert ("Every step stands" in told) is (outcome == "stands")
    assert ("1 steps do not stand, the first is step 0." in told) is (outcome != "stands")
    assert (', first "one"' in told) is (outcome == "falls")
    assert found.rows() == [
        {
            "step": 0, "install": ["one"], "held": [], "verdict": outcome, "max_displacement": step.max_displacement,
            "first_block": step.first_block,
        }
    ]  # fmt: skip
    plain = found.summary()
    assert (plain["verdict"], plain["first_fall"]) == (outcome, None if outcome == "stands" else 0)


def test_a_sequence_tells_its_steps_in_two_or_three_digits_and_the_time_it_took():
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="one"), box((4, 0, 0), (5, 1, 1), name="two")])
    plan = Plan((Step(("one",)), Step(("two",), ("two",)), Step()), name="a plan")
    before = process_time()
    made = sequence(asm, plan, settings=Settings(settle=0.06, end=0.4, resolution=1e-2))
    assert 0 < made.run.process_seconds <= process_time() - before
    run = replace(made.run, process_seconds=12.345)
    moved = (1.2345e-3, 5.4321e-3, 2.0e-3)
    steps = tuple(replace(step, max_displacement=d) for step, d in zip(made.steps, moved, strict=True))
    stands = replace(made, steps=steps, run=run, warnings=("w1", "w2"))
    assert stands.explain().splitlines() == [
        "a plan: 3 steps, 12.3 s", "Every step stands; blocks moved by 5.4 mm at most in one.",
        "An imbalance of 0.01 of the weight would have shown in a step.", "Warning: w1", "Warning: w2",
    ]  # fmt: skip
    steps = (
        steps[0], replace(steps[1], outcome=DynamicOutcome.FALLS, first_block="two"),
        replace(steps[2], outcome=DynamicOutcome.CREEPS),
    )  # fmt: skip
    fell = replace(stands, outcome=DynamicOutcome.FALLS, steps=steps, warnings=())
    assert fell.explain().splitlines() == [
        "a plan: 3 steps, 12.3 s", "2 steps do not stand, the first is step 1.",
        'step 1: falls, 5.43 mm, first "two"', "step 2: creeps, 2 mm",
        "An imbalance of 0.01 of the weight would have shown in a step.",
    ]  # fmt: skip
    assert (stands.first_fall, fell.first_fall) == (None, 1)
    assert [row["held"] for row in fell.rows()] == [[], ["two"], []]
    plain = fell.summary()
    assert (plain["verdict"], plain["plan"], plain["process_seconds"]) == ("falls", "a plan", 12.345)
    assert (plain["threshold"], plain["first_fall"], plain["warnings"]) == (made.threshold, 1, [])


def open_stack(n, gap, size=0.3, gravity=(0, 0, -9.81)):
    blocks = [box((0, 0, (size + gap) * k + gap), (size, size, (size + gap) * (k + 1)), name=f"s{k}") for k in range(n)]
    return assembly([GROUND, *blocks], gravity=gravity)


@pytest.mark.parametrize("lean", [0.0, 0.5])
@pytest.mark.parametrize("n", [1, 3])
def test_gaps_are_closed_where_blocks_would_fall_by_a_tenth_of_the_threshold(n, lean):
    # A block falls by gap / cos(lean) at each joint.
    gravity = (9.81 * np.sin(lean), 0, -9.81 * np.cos(lean))
    least = 0.1 * default_threshold(open_stack(n, 1e-3, gravity=gravity)) * np.cos(lean) / n
    for factor, closes in ((0.97, False), (1.03, True)):
        asm = open_stack(n, factor * least, gravity=gravity)
        joints = find_interfaces(asm)
        scene = closed_scene(asm, joints)
        assert (scene.assembly is not asm) is closes
        assert scene.closed == (n if closes else 0)
        assert bool(scene.warnings) is closes
        assert not (closes and scene.interfaces.gap.any())
        if closes:
            assert scene.moved == pytest.approx(factor * least, rel=0.6)
            np.testing.assert_allclose(scene.assembly.mass, asm.mass)
            assert scene.interfaces.pair.tolist() == joints.pair.tolist()
        else:
            assert (scene.moved, scene.left, scene.trimmed) == (0.0, 0, 0)


def test_joints_are_closed_where_no_support_is_below():
    blocks = [box((-50, 0, 0), (-49, 1, 1)), box((0, 0, 0), (1, 1, 1)), box((0, 0, 1.008), (1, 1, 2.008))]
    asm = assembly(blocks, supports=[0])
    scene = closed_scene(asm, find_interfaces(asm))
    assert (scene.closed, scene.left) == (1, 0)
    assert scene.moved == pytest.approx(0.004)


def test_edges_of_blocks_that_have_a_face_in_common_are_not_open():
    joints = find_interfaces(open_stack(4, 0.0))
    gap, pair = np.array([1e-3, 2e-3, 3e-3, 4e-3]), np.array([(0, 1), (1, 2), (1, 2), (2, 3)])
    given = replace(joints, gap=gap, pair=pair)
    areas = {"faces": (1, 1, 1, 1), "an edge beside a face": (1, 1, 0, 1), "edges alone": (1, 0, 0, 0)}
    opening = {"faces": gap, "an edge beside a face": gap * [1, 1, 0, 1], "edges alone": gap}
    for name, area in areas.items():
        kind = np.where(np.array(area) > 0, 0, 1)
        found = _openings(replace(given, area=np.array(area, dtype=float), kind=kind))
        assert found.tolist() == list(opening[name]), name
    assert _openings(replace(given, kind=None)).tolist() == gap.tolist()


def test_what_is_further_apart_than_a_joint_stays_where_it_is():
    """A pile with gaps of 1 mm, which are closed, beside two blocks that are 15 mm apart, which are no joint."""
    size, gap, apart = 0.3, 1e-3, 15e-3
    pile = [box((0, 0, k * (size + gap) + gap), (size, size, (k + 1) * (size + gap))) for k in range(3)]
    far = [
        box((2, 0, 0), (2 + size, size, size), name="near"),
        box((2 + size + apart, 0, 0), (2 + 2 * size + apart, size, size), name="far"),
    ]  # fmt: skip
    asm = assembly([GROUND, *pile, *far], gravity=(0, 0, -9.81))
    scene = closed_scene(asm, find_interfaces(asm))
    assert scene.closed == 3
    for name in ("near", "far"):
        block = asm.names.index(name)
        np.testing.assert_allclose(scene.assembly.block_vertices(block), asm.block_vertices(block), atol=1e-5)
    assert scene.moved == pytest.approx(gap, rel=0.6)


def test_a_sliver_that_an_overlap_makes_is_no_joint_that_is_left():
    """Two bricks that overlap by 2.6 mm, and one across that lies over the second by 1 mm until they are parted."""
    blocks = [
        box((0, 0, 0), (0.3, 0.3, 0.3), name="one"), box((0.2974, 0, 0), (0.5974, 0.3, 0.3), name="two"),
        box((0, 0, 0.3010), (0.2984, 0.3, 0.6), name="across"),
    ]  # fmt: skip
    asm = assembly([GROUND, *blocks], gravity=(0, 0, -9.81))
    joints = find_interfaces(asm)
    assert [2, 3] not in joints.pair.tolist()
    scene = closed_scene(asm, joints)
    assert scene.left == 0
    assert scene.closed >= 2
    assert [2, 3] not in find_interfaces(scene.assembly).pair.tolist()
    assert scene.misfit == 0.0


def test_a_wider_gap_that_was_asked_for_is_closed_and_no_wider_one():
    size = 0.3
    for asked, found in ((0.02, 5e-3), (0.04, 9e-3)):
        asm = open_stack(2, found)
        joints = find_interfaces(asm, gap=asked)
        assert joints.n_interfaces == 2
        scene = closed_scene(asm, joints)
        assert scene.closed == 2
        assert scene.assembly.mass == pytest.approx(asm.mass)
        assert scene.moved == pytest.approx(found, rel=0.6)
        assert scene.moved < 0.1 * size


def test_a_joint_beside_is_closed_where_it_alone_is_open_by_a_tenth_of_the_threshold():
    def beside(gap):
        blocks = [box((0, 0, 0), (0.3, 0.3, 0.3), name="a"), box((0.3 + gap, 0, 0), (0.6 + gap, 0.3, 0.3), name="b")]
        return assembly([GROUND, *blocks], gravity=(0, 0, -9.81))

    least = 0.1 * default_threshold(beside(0.0))
    for factor, closes in ((0.97, False), (1.03, True)):
        asm = beside(factor * least)
        scene = closed_scene(asm, find_interfaces(asm))
        assert (scene.closed == 1) is closes
        assert (scene.assembly is asm) is not closes


def above_its_ridges(*others, gap=6e-3):
    """A box of 1 x .8 x 1.2 m above the two ridges it is to lie on, beside other blocks that are supports."""
    ridges = two_ridges(0.0, 0.8, (1, 0)).scene
    moved = ridges.vertices.copy()
    moved[ridges.vertex_start[2] :] += (0, 0, gap)
    own = [
        Block(
            moved[ridges.vertex_start[k] : ridges.vertex_start[k + 1]], [f.tolist() for f in ridges.faces_of(k)], name
        )
        for k, name in enumerate(("ridge0", "ridge1", "box"))
    ]
    names = [block.name for block in others]
    return assembly([*own, *others], supports=["ridge0", "ridge1", *names], gravity=(0, 0, -9.81))


def test_what_a_neighbour_pins_by_its_side_alone_is_simulated_as_drawn():
    beside = box((0.5, -0.4, 0.1), (1.5, 0.4, 1.1), name="beside")
    pinned = above_its_ridges(beside)
    scene = closed_scene(pinned, find_interfaces(pinned))
    assert scene.assembly is pinned
    assert (scene.closed, scene.left, scene.moved) == (0, 2, 0.0)
    assert scene.misfit == pytest.approx(6e-3)
    # A side that is open by more than a tenth of the threshold is closed, and pins the box on its own.
    for gap in (5e-3, 8e-3):
        asm = above_its_ridges(box((0.5 + gap, -0.4, 0.1), (1.5, 0.4, 1.1), name="beside"))
        scene = closed_scene(asm, find_interfaces(asm))
        assert (scene.closed, scene.left) == (1, 2)
        assert scene.misfit == pytest.approx(6e-3)
        assert scene.interfaces.gap == pytest.approx([6e-3, 6e-3, 0.0])
        assert scene.moved == pytest.approx(gap / 2, rel=0.1)
    loose = above_its_ridges(box((1.5, -0.4, 0.1), (2.5, 0.4, 1.1), name="beside"))
    with pytest.raises(InputError) as caught:
        closed_scene(loose, find_interfaces(loose))
    told = str(caught.value)
    assert told.startswith('blocks "ridge0" and "box" do not meet') or told.startswith('blocks "ridge1" and "box"')
    assert "faces are off by 6 mm" in told
    assert "blocks would fall by 6 mm until they touch" in told


def test_runs_that_settle_by_more_than_the_threshold_or_begin_in_each_other_say_so():
    sunk = open_stack(3, -2e-4)
    rough = verify(sunk, settings=Settings(brick_threshold=1e-7, roof_threshold=1e-7, fine_step=1e-3, end=0.5))
    told = [text for text in rough.warnings if "while settling, more than the threshold" in text]
    assert len(told) == 1
    assert told[0].startswith(f"blocks moved {1e3 * rough.settling:.2g} mm")
    overlap = [text for text in rough.warnings if "before the first step" in text]
    assert bool(overlap) is (rough.run.initial_overlap > 1e-8)
    deep = replace(rough.run, initial_overlap=1.2504e-2)  # 13 mm in two digits; a thousandth less would be 12
    assert _warnings(deep, 0.0, 0.1)[0].startswith("shapes overlap by up to 13 mm before the first step")
    fine = verify(open_stack(3, 0.0), settings=Settings(end=0.5))
    assert fine.warnings == ()


def test_a_scene_that_was_changed_says_by_how_much():
    scene = closed_scene(open_stack(2, 0.0), find_interfaces(open_stack(2, 0.0)))
    assert scene.warnings == []
    told = replace(scene, trimmed=2, cut=0.0123, closed=3, moved=0.0045, left=4, misfit=0.0067).warnings
    assert told[0].startswith("2 blocks overlapped others")
    assert "cut back by up to 12 mm" in told[0]
    assert told[1].startswith("3 joints that statics count as closed were open")
    assert "by up to 4.5 mm" in told[1]
    assert told[2].startswith("4 joints that statics count as closed were simulated as drawn")
    assert "off by up to 6.7 mm" in told[2]
    # 1.0496 mm is 1 mm in two digits, and a thousandth more would be 1.1 mm.
    told = replace(scene, trimmed=1, cut=1.0496e-3, closed=1, moved=1.0496e-3, left=1, misfit=1.0496e-3).warnings
    assert [text.split("by up to ")[1].split(" mm")[0] for text in told] == ["1", "1", "1"]


def staged(first, check, fine="creeps", **options):
    """The verdict where runs fall at given times, in seconds, and how many runs it took; None is a stand.

    "group" is a fall of the group by Eq. 1 alone, which has no time.
    """
    made = driven({})
    asked = Settings(**{"time_step": 1e-3, "quick_step": 2e-3, "fine_step": 5e-4, **options})
    steps = []

    def evaluate(settings, spent=0.0):
        steps.append(settings)
        falls = {1e-3: first, 2e-3: check, 5e-4: fine}[settings.time_step]
        own = {None: DynamicOutcome.STANDS, "creeps": DynamicOutcome.CREEPS}.get(falls, DynamicOutcome.FALLS)
        falls = falls if isinstance(falls, float) else None
        run = replace(made.run, process_seconds=spent + 1.0)
        return replace(made, outcome=own, first_time=None if falls is None else falls / run.pace, run=run)

    asm = made.run.assembly
    found = _staged(evaluate, stages(asm, asked, find_interfaces(asm)), None)
    return found, steps


@pytest.mark.parametrize(("first", "check", "same"), [
    (1.3, 1.3, True), (1.3, 1.0, True), (1.3, 0.99, False), (1.0, 1.3, True), (1.0, 1.31, False), (1.0, None, False),
    (1.0, 0.5, False), (1.0, 2.2, False),
])  # fmt: skip
def test_a_fall_is_believed_where_a_coarser_run_falls_within_thirty_percent_of_its_time(first, check, same):
    found, steps = staged(first, check)
    assert found.outcome is (DynamicOutcome.FALLS if same else DynamicOutcome.CREEPS)
    assert [settings.time_step for settings in steps] == [1e-3, 2e-3] + [5e-4] * (not same)
    assert steps[1].end == pytest.approx(1.3 * first)  # what falls later than that does not count
    assert found.process_seconds == len(steps)


@pytest.mark.parametrize(
    ("first", "check", "same"),
    [("group", "group", True), ("group", None, False), ("group", "creeps", False), ("group", 1.0, False),
     (1.0, "group", False)],
)  # fmt: skip
def test_a_fall_of_the_group_is_believed_where_the_coarser_run_sees_one_too(first, check, same):
    found, steps = staged(first, check, fine=None)
    assert found.outcome is (DynamicOutcome.FALLS if same else DynamicOutcome.STANDS)
    assert len(steps) == 3 - same


def test_stands_and_clear_falls_take_one_run():
    clear = Settings().clear_fall
    for first, runs, outcome in ((None, 1, "stands"), (0.99 * clear, 1, "falls"), (1.01 * clear, 2, "falls")):
        found, steps = staged(first, first)
        assert (len(steps), found.outcome.word) == (runs, outcome)
        assert found.process_seconds == runs
    found, steps = staged("creeps", None, fine=None)  # what creeps has the last word from the finest run
    assert (len(steps), found.outcome.word) == (2, "stands")


@pytest.mark.parametrize("total", [0.25, 0.9, 2.0, 50.0])
def test_without_a_static_limit_a_search_begins_at_half_the_weight(total):
    """The weight is 2 N, and loads of so many newtons are doubled until the block moves, or up to 64 weights."""
    asm, joints = foot(1.0)
    assert asm.free_weight == pytest.approx(2.0)
    force = np.zeros((2, 6))
    force[1, 0] = total
    tried = []

    class Prescribed(_Search):
        def stands(self, multiplier):
            tried.append(multiplier * total / asm.free_weight)
            return tried[-1] < moves

    for moves, loads, most in (
        (3.0, [0.0, 0.5, 1.0, 2.0, 4.0], 4.0),
        (np.inf, [0.0, *2.0 ** np.arange(-1, 7)], np.inf),
    ):
        tried.clear()
        search = Prescribed(asm, force, (), None, joints, 0.6, None, unbounded=True)
        outcome, low, high = search.bracket(None)
        assert tried == pytest.approx(loads)
        assert outcome is (LimitOutcome.LIMIT if np.isfinite(moves) else LimitOutcome.UNBOUNDED)
        assert high * total / asm.free_weight == pytest.approx(most)
        assert low < moves * asm.free_weight / total


def overhanging(length, thickness, beyond):
    """A plank whose centroid is so far beyond the edge of its support."""
    ledge = box((-1, -1, -1), (length / 2 - beyond, 2, 0), name="ledge")
    return Assembly.from_blocks(
        [ledge, box((0, 0, 0), (length, 0.3, thickness), name="plank")], supports=["ledge"], friction=0.6
    )


@pytest.mark.parametrize("beyond", [0.01, 0.02])
def test_a_plank_that_tips_slowly_about_a_point_near_its_centroid_does_not_rest(beyond):
    asm = overhanging(4.0, 0.05, beyond)
    assert assess(asm).outcome is Outcome.UNSTABLE
    assert verify(asm).outcome is DynamicOutcome.FALLS


def test_a_block_that_a_couple_spins_does_not_rest():
    asm = assembly([GROUND, box((0, 0, 0), (0.3, 0.3, 0.3), name="cube")], friction=0.0, gravity=(0, 0, -9.81))
    wrench = np.zeros((2, 6))
    wrench[1, 5] = 0.008 * 0.3 * 9.81 * asm.mass[1]
    found = verify(asm, loads=wrench)
    assert found.outcome is DynamicOutcome.FALLS
    assert found.max_displacement < 1e-3


def test_a_parapet_in_one_piece_that_lies_on_its_face_has_fallen():
    # West: it rocks from .3 g on. Its size, the cube root of its volume, is 1.44 m, more than it moves.
    parapet = box((0, 0, 0), (0.3, 10, 1), name="parapet")
    ground = box((-20, -20, -1), (20, 20, 0), name="ground")
    asm = Assembly.from_blocks([ground, parapet], supports=["ground"], friction=1.0)
    found = verify(asm, loads=[Pulse((5, 0, 0), 1.0)])
    assert found.outcome is DynamicOutcome.FALLS
    assert found.max_displacement < found.brick_threshold
    assert verify(asm, loads=[Pulse((2.0, 0, 0), 1.0)]).outcome is DynamicOutcome.STANDS


def test_ground_that_turns_about_the_vertical_does_not_tilt():
    with pytest.raises(InputError, match="it must be at right angles to gravity"):
        verify(stack(1, 1.0, 1.0), loads=[Tilt((0, 0, 1), 10.0)])


def test_a_plan_with_careful_settings_sees_what_a_careful_verdict_sees():
    # A slab whose centroid is 3 mm beyond the edge: an imbalance of .003 / .15 of its weight at first.
    asm = overhanging(2.0, 0.3, 0.003)
    plan = Plan((Step(("plank",)),))
    assert sequence(asm, plan, settings=Settings.named("careful")).outcome is DynamicOutcome.FALLS
