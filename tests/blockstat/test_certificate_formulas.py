"""Every figure of a certificate against the sums that define it, on programs without any symmetry."""

from dataclasses import FrozenInstanceError, replace
from math import hypot, inf, isinf, nan, nextafter

import numpy as np
import pytest

from blockstat.certificate import check as certificate
from blockstat.certificate.check import (
    UNCHECKED,
    Certificate,
    ForceErrors,
    balance,
    check,
    cone_slack,
    force_errors,
    opening_slack,
    point_slack,
    power,
    pressed,
    settle,
    total_load,
)
from blockstat.certificate.coulomb_state import CoulombCertificate, check_coulomb_state, loaded_points
from blockstat.program.penalty import PenaltyProgram
from evidence.scenes.bonded import program_of
from evidence.scenes.small import arch, assembly, box, stack

FRICTION = np.array([0.0, 0.3, 0.7, 1.6, inf, 0.5, 0.9, inf, 0.4])
PAIRS = np.array([[-1, 0], [-1, 0], [0, 1], [1, 0], [2, 1], [1, 2], [2, -1], [0, 2], [-1, 1]])
N, M = 3, len(PAIRS)


def program(seed=0, *, laws=False):
    """Three blocks and nine points, all numbers random: nothing is like anything else."""
    rng = np.random.default_rng(seed)
    local = rng.normal(size=(M, 3, 2, 6)) * (PAIRS >= 0)[:, None, :, None]
    lower, upper = np.zeros(M), np.full(M, inf)
    if laws:
        lower[[1, 4, 6]], upper[[2, 4, 5]] = [0.3, 0.2, 0.5], [2.0, 1.5, 3.0]
    return PenaltyProgram(
        local=local.reshape(-1, 12), load=rng.normal(size=6 * N), friction=FRICTION, force_unit=2.0, length_unit=3.0,
        total_load=5.0, shift=np.zeros(M), lower=lower, upper=upper, point_blocks=PAIRS, n_points=M,
    )  # fmt: skip


def dense(own):
    """A, column by column from the entries of each point."""
    matrix = np.zeros((len(own.load), 3 * len(own.point_blocks)))
    for k, pair in enumerate(own.point_blocks):
        for c in range(3):
            for side, block in enumerate(pair):
                if block >= 0:
                    matrix[6 * block : 6 * block + 6, 3 * k + c] += own.local[3 * k + c, 6 * side : 6 * side + 6]
    return matrix


def forces(seed=1):
    force = np.random.default_rng(seed).normal(size=(M, 3)) + [1.5, 0, 0]
    force[3] = [0.4, 0.0, 0.0]
    force[7] = [-0.2, 0.3, -0.1]
    return force


def slack_of_force(force, mu):
    normal, tangent = force[0], hypot(force[1], force[2])
    if isinf(mu):
        return min(normal, -tangent) if normal <= 0 and tangent > 0 else normal
    if tangent == 0:
        return normal
    return normal - tangent / mu if mu else -inf


def slack_of_rate(rate, mu):
    slide = hypot(rate[1], rate[2])
    return min(rate[0], 0.0) - slide if isinf(mu) else rate[0] - mu * slide


CORNERS = np.array([
    [2.0, 0.3, -0.4], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.3, 0.4], [-0.1, 0.3, 0.4], [-0.9, -0.3, 0.4],
    [1e-3, -0.6, 0.8], [3.0, 0.0, 0.0],
])  # fmt: skip


@pytest.mark.parametrize("mu", [0.0, 0.25, 1.0, 2.0, inf])
def test_the_slack_of_a_force_is_its_distance_from_its_cone_along_the_normal(mu):
    expected = [slack_of_force(force, mu) for force in CORNERS.tolist()]
    assert cone_slack(CORNERS, np.full(len(CORNERS), mu)).tolist() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("mu", [0.0, 0.25, 1.0, 2.0, inf])
def test_the_slack_of_an_opening_is_what_the_slip_leaves_of_it(mu):
    expected = [slack_of_rate(rate, mu) for rate in CORNERS.tolist()]
    assert opening_slack(CORNERS, np.full(len(CORNERS), mu)).tolist() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("laws", [False, True])
@pytest.mark.parametrize("bounds", [{}, {"upper": np.full(M, inf)}, {"lower": np.zeros(M)}])
def test_the_slack_of_a_point_is_the_least_of_its_cone_and_its_bounds(laws, bounds):
    own, force = replace(program(laws=laws), **bounds), forces()
    expected = [
        min(
            slack_of_force(force[k], own.friction[k]),
            force[k, 0] - own.lower[k] if own.lower[k] > 0 else inf,
            own.upper[k] - force[k, 0],
        )
        for k in range(M)
    ]
    assert point_slack(own, force).tolist() == pytest.approx(expected, rel=1e-12)


def work_and_closing(own, twist):
    rates = (dense(own).T @ twist).reshape(-1, 3)
    work, worst = float(own.load @ twist), 0.0
    for rate, mu, lower, upper in zip(rates.tolist(), own.friction, own.lower, own.upper, strict=True):
        slack, slide = slack_of_rate(rate, mu), hypot(rate[1], rate[2])
        if lower > 0:
            work += lower * max(slack, 0.0)
        if isinf(upper):
            worst = max(worst, -slack)
        elif isinf(mu):
            work -= upper * max(-rate[0], 0.0)
            worst = max(worst, slide)
        else:
            work -= upper * max(-slack, 0.0)
    return work, worst


@pytest.mark.parametrize("laws", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_the_work_on_a_twist_is_that_of_loads_less_what_joints_take_up(seed, laws):
    own, twist = program(laws=laws), np.random.default_rng(seed).normal(size=6 * N)
    assert power(own, twist) == pytest.approx(work_and_closing(own, twist), rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_cohesion_takes_up_its_part_of_what_closes(seed):
    own, twist = program(laws=True), np.random.default_rng(seed).normal(size=6 * N)
    strong, (work, closing) = replace(own, shift=np.arange(M) / 7.0), work_and_closing(own, twist)
    for k, rate in enumerate((dense(own).T @ twist).reshape(-1, 3)):
        if isinf(own.upper[k]):
            work -= k / 7.0 * max(-slack_of_rate(rate, own.friction[k]), 0.0)
    assert power(strong, twist) == pytest.approx((work, closing), rel=1e-12)


def test_where_all_points_have_an_upper_bound_nothing_closes_beyond_it():
    own = replace(program(), friction=np.where(np.isinf(FRICTION), 0.6, FRICTION), upper=np.full(M, 2.0))
    assert power(own, np.random.default_rng(3).normal(size=6 * N))[1] == 0.0


@pytest.mark.parametrize("laws", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_mechanism_needs_the_force_that_would_take_up_its_work(seed, laws):
    own, twist = program(laws=laws), np.random.default_rng(seed).normal(size=6 * N)
    twist *= np.sign(work_and_closing(own, twist)[0])  # one of the two directions is driven, unless bounds take it up
    found = check(own, forces(), 7.0 * twist)
    work, closing = work_and_closing(own, twist / np.abs(twist).max())
    assert found.work == pytest.approx(work / np.abs(own.load).sum(), rel=1e-12)
    assert found.mechanism_violation == pytest.approx(closing, rel=1e-12)
    total = sum(hypot(*own.load[6 * k : 6 * k + 6]) for k in range(N))
    assert found.required_force == pytest.approx(work / closing / total if work > 0 else 0.0, rel=1e-12)


def test_what_the_loads_do_not_drive_needs_no_force_and_what_closes_nowhere_needs_any():
    own = program_of(stack(1))
    up = np.array([0.0, 0, 1, 0, 0, 0])
    force = np.zeros((4, 3))
    assert check(own, force, up).required_force == 0.0  # no work: up against the weight
    down = check(own, force, -up)
    assert down.required_force == pytest.approx(1.0)  # unit work over unit closing, in one weight
    assert not down.proves_unstable
    lifted = check(replace(own, load=-own.load), force, up)
    assert lifted.mechanism_violation == 0.0
    assert lifted.required_force == inf
    assert lifted.work == pytest.approx(1.0)
    assert lifted.proves_unstable
    still = check(own, force, 0 * up)
    assert (still.work, still.mechanism_violation, still.required_force) == (0.0, 0.0, 0.0)


def test_without_loads_work_is_measured_in_ones():
    own = replace(program(laws=True), load=np.zeros(6 * N))
    twist = np.random.default_rng(5).normal(size=6 * N)
    twist /= np.abs(twist).max()
    assert check(own, forces(), twist).work == pytest.approx(work_and_closing(own, twist)[0], rel=1e-12)


def test_the_total_load_is_of_forces_and_moments_and_of_one_without_either():
    own = program()
    load = own.load.reshape(-1, 6)
    for part in (load, np.where(np.arange(6) < 3, load, 0.0), np.where(np.arange(6) >= 3, load, 0.0)):
        expected = sum(np.sqrt((row**2).sum()) for row in part)
        assert total_load(replace(own, load=part.reshape(-1))) == pytest.approx(expected, rel=1e-12)
    assert total_load(replace(own, load=0 * own.load)) == 1.0


def test_the_total_load_of_a_program_with_cohesion_is_that_without_it():
    own, shift = program(), np.arange(M) / 7.0
    apex = np.column_stack([shift, 0 * shift, 0 * shift]).reshape(-1)
    moved = replace(own, shift=shift, load=own.load - dense(own) @ apex)
    assert total_load(moved) == pytest.approx(total_load(own), rel=1e-12)


@pytest.mark.parametrize("laws", [False, True])
def test_what_forces_leave_is_measured_by_the_load_of_each_block(laws):
    own, force = program(laws=laws), forces()
    own = replace(own, shift=np.linspace(0.0, 0.8, M))
    rest, load = (dense(own) @ force.reshape(-1) + own.load).reshape(N, 6), own.load.reshape(N, 6)
    size = [np.sqrt((row**2).sum()) for row in load]
    residual = max(np.sqrt((row**2).sum()) / unit for row, unit in zip(rest, size, strict=True))
    missing = max(
        max(-slack, 0.0) / min(size[b] for b in pair if b >= 0)
        for slack, pair in zip(point_slack(own, force), PAIRS, strict=True)
    )
    total = sum(
        np.sqrt((f**2).sum()) if isinf(mu) else abs(f[0] - a)
        for f, mu, a in zip(force, own.friction, own.shift, strict=True)
    )
    found = force_errors(own, force)
    assert found.residual == pytest.approx(residual, rel=1e-12)
    assert found.imbalance == pytest.approx(residual, rel=1e-9)
    assert found.slack == pytest.approx(-missing, rel=1e-12)
    assert found.total == pytest.approx(total / total_load(own), rel=1e-12)
    whole = check(own, force, np.zeros(6 * N))
    assert (whole.residual, whole.imbalance, whole.total_force) == (found.residual, found.imbalance, found.total)
    assert (whole.cone_violation, whole.slack) == (-found.slack, found.slack)


def test_forces_inside_their_cones_have_the_least_slack_over_the_lighter_load():
    own = replace(program(), friction=np.linspace(0.5, 1.3, M))
    force = np.column_stack([np.arange(3.0, 3 + M), np.full(M, 0.1), np.full(M, -0.2)])
    size = np.linalg.norm(own.load.reshape(N, 6), axis=1)
    spare = [
        slack_of_force(f, mu) / min(size[b] for b in pair if b >= 0)
        for f, mu, pair in zip(force, own.friction, PAIRS, strict=True)
    ]
    found = check(own, force, np.zeros(6 * N))
    assert found.slack == pytest.approx(min(spare), rel=1e-12)
    assert found.cone_violation == 0.0


def test_a_block_without_load_takes_no_residual_and_no_missing_force():
    own = program()
    load = own.load.copy()
    load[6:12] = 0.0
    assert force_errors(replace(own, load=load), forces()).residual == inf
    # Between two such blocks, or one and a support, any missing force is too much.
    idle = replace(own, load=0 * load)
    assert force_errors(idle, np.where(np.arange(3) == 0, -1e-9, 0.0) * np.ones((M, 1))).slack == -inf
    nothing = force_errors(idle, np.zeros((M, 3)))
    assert (nothing.residual, nothing.imbalance, nothing.slack, nothing.total) == (0.0, 0.0, 0.0, 0.0)
    # A slack on a block without load is shown as it is.
    pressed_only = replace(idle, friction=np.full(M, 0.5))
    assert force_errors(pressed_only, np.tile([2.5, 0.0, 0.0], (M, 1))).slack == 2.5


def row_of_weights(*, size, load):
    """Block 0 on a support and block 1 on block 0, one point each; forces of a size, loads that they just balance."""
    local = np.zeros((2, 3, 2, 6))
    local[:, :, 1, :3], local[1, :, 0, :3] = np.eye(3), -np.eye(3)
    force = np.array([[size, 0.0, 0.0], [0.25 * size, 0.0, 0.0]])
    weights = np.zeros(12)
    weights[0], weights[6] = -(0.75 * size) + load, -0.25 * size
    own = PenaltyProgram(
        local=local.reshape(-1, 12), load=weights, friction=np.full(2, 0.5), force_unit=1.0, length_unit=1.0,
        total_load=1.0, shift=np.zeros(2), lower=np.zeros(2), upper=np.full(2, inf),
        point_blocks=np.array([[-1, 0], [0, 1]]), n_points=2,
    )  # fmt: skip
    return own, force


def test_rounding_of_the_forces_that_meet_in_a_block_is_taken_off_its_residual():
    # In block 0 meet forces of 1.25; a hundred-trillionth of them is rounding.
    for residual, excess in ((1.0e-14, 0.0), (1.2e-14, 0.0), (3.2e-14, 3.2e-14 - 1.25e-14)):
        own, force = row_of_weights(size=1.0, load=residual)
        found = force_errors(own, force)
        exact = own.load[0] + 0.75
        assert found.residual == pytest.approx(exact / -own.load[0], rel=1e-9)
        assert found.imbalance == pytest.approx(max(exact - 1.25e-14, 0.0) / -own.load[0], rel=1e-9, abs=1e-20)
        assert (found.imbalance > 0) == (excess > 0)


def test_nothing_is_taken_off_where_rounding_exceeds_the_load_of_a_block():
    # Forces of 1e16 weights: their rounding would let a whole weight pass.
    own, force = row_of_weights(size=1.0, load=0.0)
    light = replace(own, load=np.where(np.arange(12) == 0, -1.0, own.load))
    huge = force.copy()
    huge[0, 0] = 1e16
    found = force_errors(light, huge)
    assert found.imbalance == found.residual > 1e15
    # A block without load has no load that its rounding could exceed.
    bare = replace(own, load=np.where(np.arange(12) < 6, 0.0, own.load))
    kept = force_errors(bare, np.array([[0.25 + 2e-15, 0, 0], [0.25, 0, 0]]))
    assert kept.residual == inf
    assert kept.imbalance == 0.0


@pytest.mark.parametrize("field", ["imbalance", "cone_violation"])
def test_forces_prove_stability_to_a_billionth_of_the_load_of_a_block(field):
    sound = Certificate(0.0, 0.0, 0.0, 0.0, 0.0, total_force=1.0)
    assert replace(sound, **{field: 1e-9}).proves_stable
    assert not replace(sound, **{field: nextafter(1e-9, 1)}).proves_stable
    assert replace(sound, residual=1.0).proves_stable  # what is shown is not what decides


def test_both_proofs_are_bounded_by_a_million_weights():
    sound = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
    assert replace(sound, total_force=1e6).proves_stable
    assert not replace(sound, total_force=nextafter(1e6, inf)).proves_stable
    driven = replace(sound, work=2e-13, required_force=1e6)
    assert driven.proves_unstable
    assert not replace(driven, required_force=nextafter(1e6, 0)).proves_unstable
    assert not replace(driven, work=1e-13).proves_unstable
    assert replace(driven, work=nextafter(1e-13, 1)).proves_unstable
    assert not UNCHECKED.proves_stable
    assert not UNCHECKED.proves_unstable
    assert (UNCHECKED.residual, UNCHECKED.cone_violation, UNCHECKED.imbalance) == (inf, inf, inf)
    assert (UNCHECKED.work, UNCHECKED.mechanism_violation, UNCHECKED.required_force) == (0.0, 0.0, 0.0)
    assert (UNCHECKED.total_force, UNCHECKED.slack) == (0.0, 0.0)
    with pytest.raises(FrozenInstanceError):
        UNCHECKED.work = 1.0


def test_forces_are_within_a_tolerance_that_the_caller_names():
    errors = ForceErrors(residual=9.0, imbalance=2e-6, slack=-3e-6, total=1e6)
    assert errors.within(3e-6)
    assert not errors.within(2.9e-6)
    assert replace(errors, slack=1.0).within(2e-6)
    assert not replace(errors, slack=1.0).within(1.9e-6)
    assert not replace(errors, total=nextafter(1e6, inf)).within(1.0)
    with pytest.raises(FrozenInstanceError):
        errors.total = 0.0


def step(own, force):
    """One correction onto equilibrium, dense: df = -D A' (A D A')^-1 r."""
    slack = np.maximum(point_slack(own, force), 0.0)
    slack = slack + 1e-9 * max(1.0, slack.max())
    weights = np.array([[s, s * min(mu, 1.0), s * min(mu, 1.0)] for s, mu in zip(slack, own.friction, strict=True)])
    matrix, weights = dense(own), weights.reshape(-1)
    rest = matrix @ force.reshape(-1) + own.load
    change = -weights * (matrix.T @ np.linalg.solve(matrix @ np.diag(weights) @ matrix.T, rest))
    return force + change.reshape(-1, 3)


@pytest.mark.parametrize("laws", [False, True])
def test_forces_are_corrected_by_the_least_change_relative_to_their_slack(laws):
    own, force = program(laws=laws), forces(4) + [4.0, 0, 0]
    own = replace(own, upper=8.0 * own.upper)
    assert balance(own, force, passes=2) == pytest.approx(step(own, force), abs=1e-9)
    assert (balance(own, force, passes=1) == force).all()
    found = balance(own, force)
    assert np.abs(dense(own) @ found.reshape(-1) + own.load).max() < 1e-12
    assert found == pytest.approx(step(own, force), abs=1e-9)


def test_points_without_slack_are_weighed_by_a_billionth_of_the_greatest():
    own = program()
    force = forces(4)
    force[:, 0] = np.abs(force[:, 0]) + 30.0  # a slack of tens: what points without any get grows with it
    force[2] = [0.0, 0.5, 0.2]
    found = balance(own, force, passes=2)
    expected = step(own, force)
    assert found == pytest.approx(expected, abs=1e-8)
    change, exact = np.abs(found - force)[2].max(), np.abs(expected - force)[2].max()
    assert 0 < change == pytest.approx(exact, rel=1e-3)


def test_balanced_forces_stay_as_they_are():
    own, force = program(), forces(4)
    own = replace(own, load=-dense(own) @ force.reshape(-1))
    assert balance(own, force) == pytest.approx(force, abs=1e-12)


def test_what_cannot_be_balanced_stays_as_it_is():
    own, force = program(), forces(4)
    force[2, 0] = nan
    assert balance(own, force) is force


@pytest.fixture(scope="module")
def flat():
    """An arch in the plane without symmetry about its crown, and forces that are the same at both ends of a joint."""
    own = program_of(arch(7, 0.2).with_(gravity=(0.1, 0, -1)))
    assert own.plane is not None
    rng = np.random.default_rng(2)
    normal, along = rng.uniform(1, 3, len(own.plane.first)), 0.2 * rng.normal(size=len(own.plane.first))
    return own, own.plane.unfold_forces(normal, along, len(own.friction))


def test_in_the_plane_forces_are_corrected_as_in_space(flat):
    own, force = flat
    found = balance(own, force)
    assert found == pytest.approx(balance(replace(own, plane=None), force), abs=1e-8)
    assert own.plane.mirrors(found.reshape(-1))
    assert np.abs(own.matrix @ found.reshape(-1) + own.load).max() < 1e-12


@pytest.mark.parametrize("what", ["force", "load"])
def test_what_leaves_the_plane_is_corrected_in_space(flat, what):
    own, force = flat
    if what == "force":
        force = force.copy()
        force[own.plane.first[2]] += [0.1, 0.02, -0.03]
    else:
        load = own.load.copy()
        load[7] += 1e-3  # across the plane
        own = replace(own, load=load)
    found = balance(own, force)
    assert np.abs(own.matrix @ found.reshape(-1) + own.load).max() < 1e-12
    assert found == pytest.approx(balance(replace(own, plane=None), force), abs=1e-8)


def test_forces_outside_their_cones_are_pressed_by_a_little_more_than_they_lack():
    own, force = program(laws=True), forces()
    own = replace(own, friction=np.where(own.friction == 0, 0.2, own.friction))
    slack = point_slack(own, force)
    assert (slack < 0).any()
    assert (slack > 0).any()
    expected = force.copy()
    for k, value in enumerate(slack):
        if value < 0:
            expected[k, 0] += 1.02 * -value + 0.02
    assert pressed(own, force) == pytest.approx(expected, rel=1e-12)
    given = forces()
    pressed(own, given)
    assert (given == forces()).all()


def test_nothing_is_pressed_where_nothing_lacks_or_no_pressure_would_help():
    own = replace(program(), friction=np.full(M, 0.5))
    inside = np.tile([4.0, 0.3, 0.4], (M, 1))
    assert pressed(own, inside) is inside
    smooth = replace(own, friction=np.zeros(M))  # shear without friction lacks an infinite pressure
    assert pressed(smooth, inside) is inside


@pytest.mark.parametrize("trials", [0, 1, 2])
def test_forces_are_pressed_and_balanced_as_often_as_asked(trials):
    own, force = program(), forces(6)
    own = replace(own, friction=np.where(own.friction == 0, 0.2, own.friction))
    expected = balance(own, force)
    for _ in range(trials):
        expected = balance(own, pressed(own, expected))
    assert (settle(own, force, trials=trials) == expected).all()
    assert (point_slack(own, balance(own, force)) < 0).any()


def test_settled_forces_are_those_that_need_no_more_pressing():
    own = program_of(stack(2, 1.3, 0.7).with_(gravity=(0.2, 0.1, -1)))
    force = np.random.default_rng(1).normal(size=(8, 3)) * 0.1 + [0.5, 0, 0]
    force[2, 0] = -0.05
    found = settle(own, force)
    assert check(own, found, np.zeros(12)).proves_stable
    assert settle(own, found) == pytest.approx(found, abs=1e-12)


def test_settling_gives_up_after_four_trials(monkeypatch):
    calls = []
    real = certificate.balance
    monkeypatch.setattr(certificate, "balance", lambda *args, **options: (calls.append(1), real(*args, **options))[1])
    own = replace(program(), friction=np.full(M, 1e-3))
    settle(own, forces())
    assert len(calls) == 5


def state(seed=0):
    own = replace(program(seed, laws=True), n_points=7)
    rng = np.random.default_rng(seed + 10)
    force = rng.normal(size=(M, 3)) + [1.5, 0, 0]
    force[[0, 5]] = 0.0
    return own, force, rng.normal(size=6 * N)


def coulomb_by_hand(own, force, displacement, opening):
    rate = (dense(own).T @ displacement).reshape(-1, 3)
    size = np.abs(rate).max()
    rate, load = rate / size, own.load.reshape(N, 6)
    unit = np.sqrt((load**2).sum(axis=1))
    loaded, closing = [], -rate[:, 0]
    for k, pair in enumerate(own.point_blocks):
        tolerance = 1e-9 * min(unit[b] for b in pair if b >= 0)
        bound = own.lower[k] > 0 and force[k, 0] <= own.lower[k] + tolerance
        loaded.append(np.sqrt((force[k] ** 2).sum()) > tolerance and not bound)
    points = [k for k in range(M) if loaded[k] and k < own.n_points]
    most = max([closing[k] for k in points], default=0.0)
    clearance = [
        closing[k] - max(most, 0.0 if opening is None else opening[k] / size)
        for k in range(own.n_points)
        if not loaded[k]
    ]
    friction = [0.0]
    for k in range(M):
        if not loaded[k]:
            continue
        tangent, slip = force[k, 1:], rate[k, 1:]
        strength = np.sqrt((tangent**2).sum())
        if strength:
            along = tangent / strength
            rest = slip - min(along @ slip, 0.0) * along
            friction.append(strength / np.sqrt((force[k] ** 2).sum()) * np.sqrt((rest**2).sum()))
        if k >= own.n_points:
            friction.append(max(rate[k, 0], 0.0))
    pressure = np.maximum(force[: own.n_points, 0], 0.0)
    return {
        "closing": min([closing[k] for k in points], default=inf),
        "clearance_violation": max([0.0, *clearance]),
        "friction_violation": max(friction),
        "unsupported": sum(pressure[k] for k in points if closing[k] <= 1e-6) / pressure.sum(),
    }, loaded


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_the_figures_of_a_coulomb_state_are_those_of_its_definition(seed, known):
    own, force, displacement = state(seed)
    opening = np.random.default_rng(seed).uniform(0, 3, M) if known else None
    expected, loaded = coulomb_by_hand(own, force, displacement, opening)
    found = check_coulomb_state(own, force, displacement, opening)
    assert loaded_points(own, force).tolist() == loaded
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-9, abs=1e-15), name
    errors = force_errors(own, force)
    assert (found.residual, found.total_force) == (errors.imbalance, errors.total)
    assert found.cone_violation == -errors.slack > 0


def test_a_point_without_friction_may_slip_anyhow_and_an_unpressed_one_is_not_supported():
    own, _, displacement = state()
    found = check_coulomb_state(own, np.tile([1.0, 0.0, 0.0], (M, 1)), displacement)
    rates = (dense(own).T @ displacement).reshape(-1, 3)
    stretched = max(0.0, *rates[own.n_points :, 0]) / np.abs(rates).max()
    assert found.friction_violation == pytest.approx(stretched, rel=1e-12)


def test_without_forces_nothing_is_loaded_and_without_motion_nothing_closes():
    own, force, displacement = state()
    nothing = check_coulomb_state(own, 0 * force, displacement)
    assert nothing.closing == inf
    assert nothing.unsupported == 0.0
    assert nothing.friction_violation == 0.0
    rates = (dense(own).T @ displacement).reshape(-1, 3)
    assert nothing.clearance_violation == pytest.approx(
        max(0.0, *-rates[: own.n_points, 0]) / np.abs(rates).max(), rel=1e-12
    )
    still = check_coulomb_state(own, np.abs(force), 0 * displacement)
    assert (still.closing, still.clearance_violation, still.friction_violation) == (0.0, 0.0, 0.0)
    pressure, loaded = np.abs(force[: own.n_points, 0]), loaded_points(own, np.abs(force))[: own.n_points]
    assert still.unsupported == pytest.approx(pressure[loaded].sum() / pressure.sum(), rel=1e-12)


def test_numbers_that_are_none_have_the_worst_figures():
    own, force, displacement = state()
    for bad in ((force * nan, displacement), (force, displacement * inf)):
        with np.errstate(invalid="ignore"):
            found = check_coulomb_state(own, *bad)
        assert (found.residual, found.total_force, found.cone_violation) == (inf, inf, inf)
        assert (found.closing, found.clearance_violation, found.friction_violation) == (-inf, inf, inf)
        assert found.unsupported == 1.0
        assert not found.proves_settled


def test_each_figure_of_a_coulomb_state_decides_at_its_tolerance():
    sound = CoulombCertificate(1e-9, 1e6, 1e-9, nextafter(1e-6, 1), 1e-6, 1e-6, 0.0)
    assert sound.proves_settled
    for field, value in (
        ("residual", nextafter(1e-9, 1)), ("total_force", nextafter(1e6, inf)), ("cone_violation", nextafter(1e-9, 1)),
        ("closing", 1e-6), ("clearance_violation", nextafter(1e-6, 1)), ("friction_violation", nextafter(1e-6, 1)),
    ):  # fmt: skip
        assert not replace(sound, **{field: value}).proves_settled, field
    with pytest.raises(FrozenInstanceError):
        sound.closing = 1.0


def test_a_force_at_its_lower_bound_and_one_of_rounding_are_no_loads():
    # Two blocks of weights 1 and 1/4 on each other: what counts at their joint is the lighter one.
    own, force = row_of_weights(size=1.0, load=0.0)
    for size, loaded in ((2.4e-10, False), (2.6e-10, True)):
        assert loaded_points(own, np.array([[0.5, 0, 0], [0.0, -size, 0]])).tolist() == [True, loaded]
    for size, loaded in ((7.4e-10, False), (7.6e-10, True)):
        assert loaded_points(own, np.array([[0.0, 0, size], force[1]])).tolist() == [loaded, True]
    bound = replace(own, lower=np.array([0.3, 0.0]))
    for normal, loaded in ((0.3 + 7e-10, False), (0.3 + 8e-10, True)):
        assert loaded_points(bound, np.array([[normal, 0.1, 0], [0.25, 0, 0]])).tolist() == [loaded, True]


def test_the_check_sees_a_hand_made_state_of_one_block():
    # A block sinks by 1 and slips by 1/2 against friction: it closes and slips the right way.
    own = program_of(assembly([box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 1))], friction=0.7))
    frame = own.local.reshape(4, 3, 2, 6)[:, :, 1, :3]
    force = np.einsum("kcj,j->kc", frame, [0.05, 0.0, 0.25])
    for slip, right in ((-0.5, True), (0.5, False)):
        found = check_coulomb_state(own, force, np.array([slip, 0, -1.0, 0, 0, 0]))
        assert found.closing == pytest.approx(1.0)
        assert (found.friction_violation < 1e-12) == right
        assert found.unsupported == 0.0


def test_options_of_balancing_are_named():
    own, force = program(), forces()
    for call in (balance, settle):
        with pytest.raises(TypeError):
            call(own, force, 2)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_size_of_a_twist_and_of_forces_does_not_matter(size):
    own, twist = program(laws=True), np.random.default_rng(2).normal(size=6 * N)
    twist *= np.sign(work_and_closing(own, twist)[0]) / np.abs(twist).max()
    one, other = (check(own, forces(), factor * twist) for factor in (1.0, size))
    assert (other.work, other.mechanism_violation, other.required_force) == pytest.approx(
        (one.work, one.mechanism_violation, one.required_force), rel=1e-12
    )
    own, force, displacement = state(3)
    scaled = replace(own, load=size * own.load, lower=size * own.lower, upper=size * own.upper)
    found = check_coulomb_state(scaled, size * force, displacement)
    expected, _ = coulomb_by_hand(own, force, displacement, None)
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-9, abs=1e-15), name


@pytest.mark.parametrize("size", [0.1, 30.0])
def test_points_without_slack_are_weighed_by_a_billionth_of_one_or_of_the_greatest_slack(size):
    own = replace(program(), friction=np.full(M, 0.8))
    force = size * np.column_stack([np.linspace(0.5, 0.9, M), np.full(M, 0.05), np.full(M, -0.1)])
    force[2] = [0.0, 0.05 * size, 0.02 * size]
    assert (point_slack(own, force) > 0).sum() == M - 1
    found, expected = balance(own, force, passes=2), step(own, force)
    change, exact = np.abs(found - force)[2].max(), np.abs(expected - force)[2].max()
    assert 0 < change == pytest.approx(exact, rel=1e-3)


def test_planar_forces_are_balanced_with_half_the_unknowns(flat, monkeypatch):
    own, force = flat
    monkeypatch.setattr(certificate, "_solver", lambda *_: pytest.fail("all of it is planar"))
    for size in (1e-3, 1.0, 1e3):
        scaled = replace(own, load=size * own.load)
        assert np.abs(scaled.matrix @ balance(scaled, size * force).reshape(-1) + scaled.load).max() < 1e-11 * size
