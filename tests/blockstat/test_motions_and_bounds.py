"""Bounds from iterates, motions that open joints, and blocks that nothing holds, against plain computations."""

from dataclasses import replace
from math import inf, nan, nextafter

import numpy as np
import pytest

from blockstat import Interfaces, find_interfaces
from blockstat.certificate.bracket import Bracket, is_closed
from blockstat.certificate.check import opening_slack
from blockstat.certificate.falling import falling_blocks
from blockstat.certificate.interior_motions import (
    SPREADS,
    cheapest,
    expansions,
    least_slack,
    no_motions,
    with_interior_motion,
)
from blockstat.certificate.neutral import loose_blocks
from blockstat.contact.faces import frames
from evidence.scenes.bonded import program_of
from evidence.scenes.small import assembly, box, stack

MU = 0.4


@pytest.mark.parametrize(
    ("lower", "upper", "tolerance", "closed"),
    [
        (1.0, 2.0, 0.5, True), (1.0, 2.0, nextafter(0.5, 0), False), (-3.0, -2.0, 0.5, True), (-3.0, -2.0, 0.4, False),
        (0.0, 2e-9, 0.0, True), (0.0, 2.1e-9, 0.0, False), (2.0, 2.0 + 1.9e-9, 1e-12, True), (0.0, inf, 1.0, False),
        (0.5, nan, 1.0, False), (2.0, 1.0, 0.0, True),
    ],
)  # fmt: skip
def test_a_bracket_is_closed_at_its_width_relative_to_its_upper_end(lower, upper, tolerance, closed):
    assert is_closed(lower, upper, tolerance) is closed


@pytest.fixture(scope="module")
def pushed():
    """A block of weight one on the ground, and a push of one at its base: it slides at the coefficient of friction."""
    program = replace(program_of(stack(1, 2.0, 0.5, friction=MU)), plane=None)
    shear = np.einsum("kcj,j->kc", program.local.reshape(4, 3, 2, 6)[:, :, 1, :3], [1.0, 0, 0])
    assert (np.abs(shear[:, 0]) < 1e-12).all()
    return program, -program.matrix @ (-0.25 * shear).reshape(-1), -shear


INSIDE = np.tile([0.25, 0.0, 0.0], (4, 1))


def bracket(pushed, tolerance=0.1, motions=no_motions, progress=None, inside=INSIDE):
    program, load, _ = pushed
    return Bracket(program, load, inside, tolerance, motions, progress)


def slide(rise, speed=1.0):
    return np.array([speed, 0, rise, 0, 0, 0])


def carrying(pushed, *shares):
    """Forces that carry a push, so much of it at each of the four points."""
    return INSIDE + np.array(shares)[:, None] * pushed[2]


def test_a_bracket_begins_with_the_dead_load_alone(pushed):
    own = bracket(pushed)
    assert (own.lower, own.upper, own.iterates, own.closed) == (0.0, inf, 0, False)
    assert own.force is INSIDE
    assert own.twist.tolist() == [0.0] * 6
    own.close()  # nothing to prove yet
    assert own.lower == 0.0


def test_a_mechanism_that_opens_bounds_the_multiplier_by_its_work(pushed):
    own = bracket(pushed)
    push = float(pushed[1] @ slide(0.0))
    for rise, speed, bound in ((0.5, 1.0, 0.5), (0.9, 1.0, 0.5), (0.9, 2.0, 0.45), (0.5, -1.0, 0.45)):
        own.narrow(slide(rise, speed), INSIDE, 0.0)
        assert own.upper == pytest.approx(bound / push, rel=1e-12)
    assert own.iterates == 4
    assert pushed[1] @ own.twist == pytest.approx(1.0)
    assert own.twist == pytest.approx(slide(0.9, 2.0) / 2.0 / push)


def test_a_mechanism_that_closes_a_little_gets_as_much_of_the_last_one_that_opens(pushed):
    own = bracket(pushed, motions=lambda: [slide(9.0, 0.0)])
    own.narrow(slide(0.9), INSIDE, 0.0)  # slack .5
    own.narrow(slide(0.5), INSIDE, 0.0)  # slack .1
    own.narrow(slide(0.3), INSIDE, 0.0)  # slack -.1
    assert own.upper == pytest.approx((0.3 + 0.5 * 1.000001) / (1.0 + 1.000001), rel=1e-12)


def test_a_mechanism_that_closes_a_little_gets_a_motion_of_the_assembly_where_none_has_opened(pushed):
    own = bracket(pushed, motions=lambda: [slide(0.3), slide(2.0, 0.0)])
    own.narrow(slide(0.3), INSIDE, 0.0)
    assert own.upper == pytest.approx(0.3 + 0.1 * 1.000001, rel=1e-12)
    alone = bracket(pushed)
    alone.narrow(slide(0.3), INSIDE, 0.0)
    assert alone.upper == inf


def test_forces_are_proven_where_they_may_close_the_bracket(pushed):
    force = carrying(pushed, 0.0875, 0.0875, 0.0875, 0.0875)
    for tolerance, lower in ((0.2, 0.35), (0.1, 0.0)):
        own = bracket(pushed, tolerance)
        assert own.narrow(slide(0.4 + 1e-9), force, 0.35) is (lower > 0)
        assert own.lower == pytest.approx(lower, rel=1e-9)
        own.close()
        assert own.lower == pytest.approx(0.35, rel=1e-9)
        assert own.force == pytest.approx(force, abs=1e-9)
        assert own.closed is (lower > 0)


def test_progress_is_told_the_iterate_what_it_would_carry_and_the_upper_bound(pushed):
    told = []
    own = bracket(pushed, progress=lambda *values: told.append(values))
    own.narrow(slide(0.9), carrying(pushed, 0.1, 0.05, 0.02, 0.03), 9.0)
    own.narrow(slide(0.6), carrying(pushed, -0.1, -0.05, -0.02, -0.03), 9.0)
    assert [k for k, _, _ in told] == [1, 2]
    assert [guess for _, guess, _ in told] == pytest.approx([0.2, -0.2])
    assert [upper for _, _, upper in told] == pytest.approx([0.9, 0.6])
    own.close()  # what carries less than nothing is not tried
    assert own.lower == 0.0


def test_the_multiplier_of_unbalanced_forces_is_their_projection_on_the_load(pushed):
    told = []
    program, load, _ = pushed
    own = Bracket(program, 3.0 * load, INSIDE, 0.1, no_motions, lambda *values: told.append(values[1]))
    force = np.random.default_rng(0).normal(size=(4, 3))
    own.narrow(slide(0.9), force, 0.0)
    rest = program.matrix.toarray() @ force.reshape(-1) + program.load
    assert told == pytest.approx([-(rest @ load) / (3.0 * load @ load)])


def test_the_next_attempt_is_made_when_a_tenth_of_the_width_is_gained(pushed):
    # The first forces are outside their cones at one point, so mixed with those that have slack they carry little.
    own = bracket(pushed, 0.19)
    own.narrow(slide(0.5), carrying(pushed, 0.225, 0.225, 0.0, 0.0), 0.0)
    low = own.lower
    assert low == pytest.approx(0.45 * 0.25 / 0.5625, rel=1e-9)
    own.narrow(slide(0.5), carrying(pushed, *[0.4545 / 4] * 4), 0.0)  # .0455 of .05 is left
    assert own.lower == low
    own.narrow(slide(0.5), carrying(pushed, *[0.4555 / 4] * 4), 0.0)
    assert own.lower == pytest.approx(0.4, rel=1e-9)


def test_a_mixture_carries_its_share_of_the_multiplier(pushed):
    own = bracket(pushed)
    force = carrying(pushed, 0.2, 0.2, 0.05, 0.05)
    own.carry(force, 0.5)
    share = 0.25 / (0.25 - (0.25 - 0.2 / MU))
    assert own.lower == pytest.approx(share * 0.5, rel=1e-12)
    assert own.force == pytest.approx((1 - share) * INSIDE + share * force, abs=1e-12)
    own.carry(carrying(pushed, 0.05, 0.05, 0.05, 0.05), 0.2)  # less than is known
    assert own.lower == pytest.approx(share * 0.5, rel=1e-12)
    own.carry(carrying(pushed, 0.06, 0.075, 0.05, 0.065), 0.25)
    assert own.lower == pytest.approx(0.25, rel=1e-9)


def test_what_the_check_does_not_prove_is_no_bound(pushed):
    own = bracket(pushed, inside=0.5 * INSIDE)  # does not carry the dead load
    own.carry(carrying(pushed, 0.2, 0.2, 0.05, 0.05), 0.5)
    assert own.lower == 0.0


@pytest.mark.parametrize(("multiplier", "lower"), [(0.3, 0.3), (0.5, 0.25 / 0.3125 * 0.5)])
def test_forces_far_from_equilibrium_are_corrected_before_they_are_mixed(pushed, multiplier, lower):
    # The least correction is the same at all four points: slack .25 - multiplier / 4 MU, which is .0625 and -.0625.
    own = bracket(pushed)
    own.carry(-INSIDE, multiplier)
    assert own.lower == pytest.approx(lower, rel=1e-9)


@pytest.fixture(scope="module")
def two_blocks():
    asm = assembly(
        [box((-2, -2, -1), (3, 3, 0)), box((0, 0, 0), (1, 0.7, 0.5)), box((0.2, 0.1, 0.5), (1.5, 0.6, 1.7))],
        gravity=(0.3, -0.2, -1.1), friction=0.6,
    )  # fmt: skip
    return asm, replace(program_of(asm), plane=None)


def test_the_slack_of_a_motion_is_that_of_its_worst_joint(two_blocks):
    _, program = two_blocks
    motion = np.random.default_rng(3).normal(size=12)
    rates = (program.matrix.toarray().T @ motion).reshape(-1, 3)
    assert least_slack(program, motion) == pytest.approx(
        min(rate[0] - 0.6 * np.hypot(rate[1], rate[2]) for rate in rates)
    )


def test_a_motion_is_opened_by_the_first_that_opens_every_joint(two_blocks):
    _, program = two_blocks
    up, higher = (np.array([0, 0, a, 0, 0, 0, 0, 0, b, 0, 0, 0.0]) for a, b in ((1, 3), (2, 5)))
    assert with_interior_motion(program, up, [higher]) is up
    still = np.zeros(12)
    assert with_interior_motion(program, still, [higher]) is still
    down = -0.5 * up
    closing = -least_slack(program, down)
    assert closing == pytest.approx(1.0)
    found = with_interior_motion(program, down, [still, -up, higher, up])
    assert found == pytest.approx(down + 1.000001 * closing / least_slack(program, higher) * higher, rel=1e-12)
    assert least_slack(program, found) > 0
    assert with_interior_motion(program, down, [still, -up]) is down
    assert no_motions() == ()


def test_the_cheapest_of_the_first_four_opening_motions_is_taken(two_blocks):
    _, program = two_blocks
    random = np.random.default_rng(5).normal(size=(7, 12))
    work = [-(program.load @ motion) for motion in random]
    # By price: 1.0, .5, -, .7, .2 within the first four that open; the last one would be cheapest.
    prices = [1.0, 0.5, 0.01, 0.7, 0.2, 0.1, 0.05]
    motions = [(np.sign(w) * m, abs(w) / price) for m, w, price in zip(random, work, prices, strict=True)]
    motions[2] = motions[2][0], 0.0
    assert cheapest(program, motions) is motions[4][0]
    assert cheapest(program, motions[:2]) is motions[1][0]
    assert cheapest(program, motions[3:]) is motions[6][0]
    assert cheapest(program, [(random[0], 0.0), (random[1], -1.0)]) is None
    assert cheapest(program, []) is None
    twice = [(motions[0][0], motions[0][1]), (2 * motions[0][0], 2 * motions[0][1])]
    assert cheapest(program, twice) is twice[0][0]


def test_assemblies_grow_upwards_and_more_slowly_sideways(two_blocks):
    asm, _ = two_blocks
    # Points of supports lie at their lowest along gravity, which leans.
    rng = np.random.default_rng(0)
    point = rng.normal(size=(7, 3))
    faces = Interfaces(
        pair=np.array([[0, 1], [1, 2], [0, 2]]), frame=frames(rng.normal(size=(3, 3))), area=np.ones(3),
        gap=np.zeros(3), point=point, start=np.array([0, 3, 5, 7]),
    )  # fmt: skip
    found = expansions(asm, faces, np.array([1, 2]))
    up = -np.array([0.3, -0.2, -1.1]) / np.sqrt(0.09 + 0.04 + 1.21)
    foot = min(up @ p for p in point[[0, 1, 2, 5, 6]])
    centre = [asm.centroid[1], asm.centroid[2]]
    middle = (centre[0] + centre[1]) / 2
    aside = [(c - middle) - up * (up @ (c - middle)) for c in centre]
    furthest = max(np.sqrt(a @ a) for a in aside)
    assert SPREADS == (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
    assert len(found) == len(SPREADS)
    for spread, twist in zip(SPREADS, found, strict=True):
        expected = [
            spread * a + up * (up @ c - foot + 2.0 * spread * furthest) for a, c in zip(aside, centre, strict=True)
        ]
        assert twist.reshape(2, 6)[:, :3] == pytest.approx(np.array(expected), rel=1e-12)
        assert not twist.reshape(2, 6)[:, 3:].any()
    assert expansions(asm, faces.subset(np.array([1])), np.array([1, 2])) == ()
    assert expansions(asm, faces, np.empty(0, dtype=int)) == ()


def test_some_growth_opens_every_joint_of_a_pile(two_blocks):
    asm, program = two_blocks
    opened = [
        opening_slack((program.matrix.T @ twist).reshape(-1, 3), program.friction).min()
        for twist in expansions(asm, find_interfaces(asm), asm.free)
    ]
    assert max(opened) > 0


def contacts(pairs, normals, points=None):
    """Interfaces with a normal each, of one point where none are given."""
    n = len(pairs)
    points = [[(0.0, 0.0, 0.0)]] * n if points is None else points
    normals = np.array(normals, dtype=float)
    return Interfaces(
        pair=np.array(pairs), frame=frames(normals / np.linalg.norm(normals, axis=1)[:, None]), area=np.zeros(n),
        gap=np.zeros(n), point=np.concatenate([np.reshape(p, (-1, 3)) for p in points]).astype(float),
        start=np.cumsum([0, *map(len, points)]),
    )  # fmt: skip


DOWN = np.array([0.0, 0.6, -0.8])


def leaning(sine):
    """A normal that points against gravity by a sine."""
    across = np.array([1.0, 0.0, 0.0])
    return np.sqrt(1 - sine**2) * across - sine * DOWN


@pytest.mark.parametrize(
    ("sine", "tied", "falls"),
    [
        (1.0, [], []), (2e-6, [], []), (0.5e-6, [], [1, 2, 3]), (-0.5e-6, [], [1, 2, 3]), (-2e-6, [], [1, 2, 3]),
        (0.0, [0], [2, 3]), (-1.0, [0], [2, 3]), (0.0, [1], [1, 2, 3]), (0.0, [0, 1, 2], []), (0.0, [0, 2], [2, 3]),
    ],
)  # fmt: skip
def test_what_presses_on_nothing_that_is_carried_falls(sine, tied, falls):
    # Block 0 is fixed; 1 beside or on it, 2 on 1 and 3 on 2 at the same slope, each seen from below or from above.
    faces = contacts([(0, 1), (2, 1), (2, 3)], [leaning(sine), -leaning(sine), leaning(sine)])
    found = falling_blocks(np.array([True, False, False, False]), faces, DOWN, np.array(tied, dtype=int))
    assert found.tolist() == falls


def test_a_block_falls_though_another_rests_on_it():
    # 1 leans on the wall 0 and carries 2, which also presses on the support 3; 4 stands on the ground.
    faces = contacts(
        [(0, 1), (1, 2), (3, 2), (3, 4), (4, 1)], [leaning(0), leaning(0.9), leaning(0.2), leaning(0.7), leaning(0)]
    )
    support = np.array([True, False, False, True, False])
    assert falling_blocks(support, faces, DOWN, np.empty(0, dtype=int)).tolist() == [1]
    assert not support[[1, 2, 4]].any()


def loose_by_hand(support, faces, held, fixed):
    """Blocks that move in the null space of all constraints, dense: no point of a joint moves, bonds not at all."""
    place = {int(block): k for k, block in enumerate(held)}
    rows = []
    for k, (a, b) in enumerate(faces.pair.tolist()):
        points = faces.point[faces.start[k] : faces.start[k + 1]]
        if k in fixed:
            points = np.concatenate([points, points[:1] + np.eye(3)])
        for point in points:
            row = np.zeros((3, 6 * len(held)))
            for block, sign in ((a, -1.0), (b, 1.0)):
                if block in place:
                    first = 6 * place[block]
                    row[:, first : first + 3] += sign * np.eye(3)
                    x, y, z = point
                    row[:, first + 3 : first + 6] += sign * np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
            rows.append(row)
    _, value, right = np.linalg.svd(np.concatenate(rows), full_matrices=True)
    still = right[np.append(value, np.zeros(len(right) - len(value)))[: len(right)] < 1e-8]
    moves = np.linalg.norm(still.reshape(len(still), len(held), 6), axis=(0, 2)) > 1e-6
    return held[moves].tolist()


@pytest.mark.parametrize("seed", range(40))
def test_blocks_are_loose_where_they_can_move_without_moving_a_contact_point(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 7))
    support = np.zeros(n, dtype=bool)
    support[rng.choice(n, size=int(rng.integers(1, 3)), replace=False)] = True
    pairs = [sorted((k, int(rng.integers(k)))) for k in range(1, n)]
    pairs += [sorted(rng.choice(n, 2, replace=False).tolist()) for _ in range(int(rng.integers(0, 5)))]
    pairs = [pair for pair in pairs if not support[pair].all()] or [
        sorted((int(np.argmax(support)), int(np.argmin(support))))
    ]
    points, area = [], []
    for _ in pairs:
        count = int(rng.choice([1, 2, 2, 3, 4]))
        points.append(rng.normal(size=(count, 3)))
        area.append(float(count == 4))
    faces = replace(contacts(pairs, rng.normal(size=(len(pairs), 3)), points), area=np.array(area))
    # Blocks that a chain of joints ties to a support.
    tied = set(np.flatnonzero(support).tolist())
    for _ in range(n):
        tied |= {b for pair in pairs for b in pair if tied & set(pair)}
    held = np.array(sorted(tied - set(np.flatnonzero(support).tolist())), dtype=int)
    faces = faces.subset(np.array([k for k, pair in enumerate(pairs) if set(pair) <= tied], dtype=int))
    fixed = rng.choice(len(faces.pair), size=int(rng.integers(0, 2)), replace=False)
    found = loose_blocks(support, faces, held, fixed)
    assert found.tolist() == loose_by_hand(support, faces, held, fixed)


ALONG = [(0.0, 0.0, 0.0), (1.0, 2.0, 0.5), (2.0, 4.0, 1.0)]


@pytest.mark.parametrize(("aside", "loose"), [(0.0, [1]), (0.5e-6, [1]), (1e-5, []), (0.5, [])])
def test_points_on_a_line_let_a_block_turn_about_it(aside, loose):
    points = [[*ALONG[:2], tuple(np.add(ALONG[2], [0, 0, aside]))]]
    faces = contacts([(0, 1)], [(0, 0, 1)], points)
    support, held, none = np.array([True, False]), np.array([1]), np.empty(0, dtype=int)
    assert loose_blocks(support, faces, held, none).tolist() == loose
    assert loose_blocks(support, faces, held, np.array([0])).tolist() == []
    assert loose_blocks(support, replace(faces, area=np.ones(1)), held, none).tolist() == []
    assert loose_blocks(support, faces, held[:0], none).tolist() == []


def test_a_block_between_two_supports_is_held_by_points_on_both():
    # One point on the first and two on the second, not on a line: the two supports are one ground.
    points = [[(0.0, 0, 0)], [(1.0, 0, 0), (0.0, 1.0, 0)]]
    faces = contacts([(0, 2), (1, 2)], [(0, 0, 1), (0, 0, 1)], points)
    support, none = np.array([True, True, False]), np.empty(0, dtype=int)
    assert loose_blocks(support, faces, np.array([2]), none).tolist() == []
    level = replace(faces, point=np.array([(0.0, 0, 0), (1, 0, 0), (2, 0, 0)]))
    assert loose_blocks(support, level, np.array([2]), none).tolist() == [2]


def test_two_blocks_that_turn_as_one_are_both_loose_and_what_they_stand_on_is_not():
    # 1 is fixed to the ground by a patch, 2 stands on 1 on two points, 3 is joined to 2 by a patch.
    patch = [(0.0, 0, 2), (1, 0, 2), (1, 1, 2), (0, 1, 2)]
    faces = contacts([(0, 1), (1, 2), (2, 3)], [(0, 0, 1)] * 3, [patch, [(0.0, 0, 0), (1, 1, 3)], patch])
    faces = replace(faces, area=np.array([1.0, 0.0, 1.0]))
    support = np.array([True, False, False, False])
    assert loose_blocks(support, faces, np.array([1, 2, 3]), np.empty(0, dtype=int)).tolist() == [2, 3]


def test_forces_that_carry_less_than_nothing_make_no_attempt(pushed):
    own = bracket(pushed, 2.0)
    own.narrow(slide(0.4 + 1e-9), carrying(pushed, *[-0.001 / 4] * 4), 0.0)
    own.narrow(slide(0.4 + 1e-9), carrying(pushed, *[0.03 / 4] * 4), 0.0)
    assert own.lower == pytest.approx(0.03, rel=1e-9)


def test_a_motion_on_which_the_load_does_no_work_bounds_nothing(pushed):
    own = bracket(pushed)
    own.narrow(slide(1.0, 0.0), INSIDE, 0.0)
    assert own.upper == inf
    own.narrow(slide(0.5), INSIDE, 0.0)
    assert own.upper == pytest.approx(0.5)


@pytest.mark.parametrize("seed", range(4))
def test_a_ring_of_three_hinges_with_different_axes_holds_and_one_with_parallel_axes_moves(seed):
    # The ground and two blocks, each on two points of the next: three points between no two of them.
    rng = np.random.default_rng(seed)
    points = list(rng.normal(size=(3, 2, 3)))
    support, held, none = np.array([True, False, False]), np.array([1, 2]), np.empty(0, dtype=int)
    faces = contacts([(0, 1), (1, 2), (0, 2)], rng.normal(size=(3, 3)), points)
    assert loose_blocks(support, faces, held, none).tolist() == []
    straight = [np.array([p[0], p[0] + [0, 0, 1.5]]) for p in points]
    straight[2] = np.array([points[0][0] + [0, 0, 4.0], points[0][0] + [0, 0, 5.0]])
    straight[1] = np.array([points[0][0] + [0, 0, 2.0], points[0][0] + [0, 0, 3.0]])
    one_axis = contacts([(0, 1), (1, 2), (0, 2)], rng.normal(size=(3, 3)), straight)
    assert loose_blocks(support, one_axis, held, none).tolist() == [1, 2]


@pytest.mark.parametrize("seed", range(4))
def test_three_blocks_that_hold_each_other_turn_as_one_about_the_hinge_of_the_first(seed):
    rng = np.random.default_rng(seed)
    pairs, support = [(0, 1), (1, 2), (2, 3), (1, 3)], np.array([True, False, False, False])
    faces = contacts(pairs, rng.normal(size=(4, 3)), list(rng.normal(size=(4, 2, 3))))
    held, none = np.array([1, 2, 3]), np.empty(0, dtype=int)
    assert loose_blocks(support, faces, held, none).tolist() == [1, 2, 3] == loose_by_hand(support, faces, held, none)
    # With a third point on the ground, beside the hinge, none moves.
    third = contacts([*pairs, (0, 2)], rng.normal(size=(5, 3)), [*np.split(faces.point, 4), rng.normal(size=(1, 3))])
    assert loose_blocks(support, third, held, none).tolist() == [] == loose_by_hand(support, third, held, none)
