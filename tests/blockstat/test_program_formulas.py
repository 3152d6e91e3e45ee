"""The programs against the equations that define them, column by column, on data without any symmetry."""

from dataclasses import MISSING, FrozenInstanceError, fields, replace
from math import inf

import numpy as np
import pytest

from blockstat import Interfaces, JointLaw, Tie, acceleration, find_interfaces
from blockstat.analysis.problem import pose
from blockstat.contact.faces import frames
from blockstat.contact.interfaces import GAP
from blockstat.program.bonds import bond_columns, bond_forces, bonded
from blockstat.program.conic import ConicProgram, PointBounds, conic_program
from blockstat.program.equilibrium import Columns, equilibrium, in_place, split_floating, weight
from blockstat.program.penalty import PenaltyProgram, penalty_program
from blockstat.program.planar import Plane, find_plane
from blockstat.program.ties import check_anchors, tie_columns, tie_wrenches, tied_pairs
from evidence.scenes.bonded import program_of
from evidence.scenes.small import arch, assembly, box, prism, stack

FRICTION = np.array([0.3, 0.0, inf, 1.6, 0.7, 0.0, inf, 0.5, 2.5])
PAIRS = np.array([[-1, 0], [1, 0], [0, 1], [2, -1], [2, 1], [1, 2], [0, 2], [-1, 1], [2, 0]])
N, M, POINTS = 3, len(PAIRS), 7


def program(*, friction=FRICTION, bounds="both", seed=0):
    """Three blocks, seven points and two bonds, all numbers random."""
    rng = np.random.default_rng(seed)
    local = rng.normal(size=(M, 3, 2, 6)) * (PAIRS >= 0)[:, None, :, None]
    lower, upper = np.zeros(M), np.full(M, inf)
    if bounds in ("both", "lower"):
        lower[[0, 3, 8]] = [0.3, 0.2, 0.5]
    if bounds in ("both", "upper"):
        upper[[3, 4, 7]] = [2.0, 1.5, 3.0]
    return PenaltyProgram(
        local=local.reshape(-1, 12), load=rng.normal(size=6 * N), friction=friction, force_unit=2.0, length_unit=3.0,
        total_load=5.0, shift=rng.uniform(0, 1, M), lower=lower, upper=upper, point_blocks=PAIRS, n_points=POINTS,
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


def test_columns_in_the_rows_of_their_blocks_are_the_matrix():
    own = program()
    assert own.matrix.toarray() == pytest.approx(dense(own), rel=1e-15)
    assert own.matrix.has_sorted_indices
    ordered = np.sort(PAIRS, axis=1)
    entries = np.random.default_rng(1).normal(size=(M, 3, 2, 6)) * (ordered >= 0)[:, None, :, None]
    straight = replace(own, point_blocks=ordered, local=entries.reshape(-1, 12))
    assert straight.matrix.toarray() == pytest.approx(dense(straight), rel=1e-15)
    alone = in_place(own.local[:3], PAIRS[:1], N)
    assert alone.shape == (18, 3)
    assert own.normal_columns.toarray() == pytest.approx(dense(own)[:, [0, 3, 6, 9, 12, 15, 18]], rel=1e-15)
    assert own.upper_bounded.tolist() == [3, 4, 7]
    assert own.lower_bounded.tolist() == [0, 3, 8]
    with pytest.raises(FrozenInstanceError):
        own.n_points = 3


@pytest.fixture(scope="module")
def pile():
    """Four blocks, two of them supports, with random contact points and frames."""
    rng = np.random.default_rng(4)
    asm = assembly(
        [box((0, 0, 0), (1, 2, 3)), box((1, 0, 0), (1.5, 2.5, 2)), box((2, 0, 0), (3, 1.2, 0.7)),
         box((4, 0, 0), (5, 1, 1))],
        supports=[1, 3], density=2.0, gravity=(0.3, -0.4, -1.2),
    )  # fmt: skip
    faces = Interfaces(
        pair=np.array([[0, 1], [0, 2], [2, 3]]), frame=frames(_unit(rng, 3)), area=np.array([0.5, 2.0, 1.2]),
        gap=np.zeros(3), point=rng.normal(size=(8, 3)), start=np.array([0, 3, 5, 8]),
    )  # fmt: skip
    return asm, faces


def _unit(rng, n):
    value = rng.normal(size=(n, 3))
    return value / np.linalg.norm(value, axis=1)[:, None]


def test_equilibrium_is_force_and_moment_about_each_free_block(pile):
    asm, faces = pile
    rng = np.random.default_rng(1)
    extra = Columns(rng.normal(size=(2, 3)), np.array([[2, 0], [3, 2]]), rng.normal(size=(2, 3, 3)))
    couple = Columns(
        rng.normal(size=(1, 3)), np.array([[0, 2]]), rng.normal(size=(1, 3, 3)), rng.normal(size=(1, 3, 3))
    )
    blocks, points, load = np.array([2, 0]), np.array([1, 4, 3, 7]), rng.normal(size=(4, 6))
    eq = equilibrium(asm, faces, load, blocks, points, (extra, couple))
    contacts = [
        (faces.pair[k], faces.point[i], faces.frame[k], np.zeros((3, 3))) for i, k in ((1, 0), (4, 1), (3, 1), (7, 2))
    ]
    contacts += [(extra.pair[k], extra.point[k], extra.force[k], np.zeros((3, 3))) for k in range(2)]
    contacts += [(couple.pair[0], couple.point[0], couple.force[0], couple.couple[0])]
    expected = np.zeros((12, 21))
    for k, (pair, point, force, moment) in enumerate(contacts):
        for block, sign in zip(pair, (-1, 1), strict=True):
            if block in (2, 0):
                first = 0 if block == 2 else 6
                for c in range(3):
                    arm = point - asm.centroid[block]
                    expected[first : first + 3, 3 * k + c] += sign * force[c]
                    expected[first + 3 : first + 6, 3 * k + c] += sign * (np.cross(arm, force[c]) + moment[c])
    assert eq.matrix.toarray() == pytest.approx(expected, abs=1e-14)
    assert (eq.load == load[[2, 0]]).all()
    assert eq.length.tolist() == [asm.size[2], asm.size[0]]
    assert (eq.n_blocks, eq.n_points, eq.n_columns) == (2, 4, 7)
    assert eq.point_blocks.tolist() == [[1, -1], [1, 0], [1, 0], [0, -1], [0, 1], [-1, 0], [1, 0]]


def test_weights_act_along_gravity_at_the_centroids(pile):
    asm, _ = pile
    expected = [[m * 0.3, m * -0.4, m * -1.2, 0, 0, 0] for m in (2.0 * 6.0, 2.0 * 2.5, 2.0 * 0.84, 2.0)]
    assert weight(asm) == pytest.approx(np.array(expected), rel=1e-12)


def test_blocks_without_a_chain_to_a_support_float(pile):
    asm, _ = pile
    split = [part.tolist() for part in split_floating(asm, np.array([[0, 2]]))]
    assert split == [[], [0, 2]]
    assert [part.tolist() for part in split_floating(asm, np.array([[0, 2], [2, 3]]))] == [[0, 2], []]
    assert [part.tolist() for part in split_floating(asm, np.array([[1, 2]]))] == [[2], [0]]
    assert [part.tolist() for part in split_floating(asm, np.empty((0, 2), dtype=int))] == [[], [0, 2]]


def eq_of(pile, load=None):
    asm, faces = pile
    load = np.random.default_rng(2).normal(size=(4, 6)) if load is None else load
    return equilibrium(asm, faces, load, np.array([0, 2]), np.arange(8))


@pytest.mark.parametrize("laws", [False, True])
def test_a_program_counts_forces_in_mean_weights_and_lengths_in_mean_blocks(pile, laws):
    eq = eq_of(pile)
    rng = np.random.default_rng(3)
    friction, shift, lower, upper = rng.uniform(0.1, 2, (4, 8))
    own = penalty_program(eq, friction, **({"shift": shift, "lower": lower, "upper": upper} if laws else {}))
    length = (eq.length[0] + eq.length[1]) / 2
    units = np.array([1, 1, 1, length, length, length])
    force = sum(np.sqrt(((row / units) ** 2).sum()) for row in eq.load) / 2
    scale = np.tile([1, 1, 1, 1 / length, 1 / length, 1 / length], 2)
    matrix = scale[:, None] * eq.matrix.toarray()
    assert (own.length_unit, own.force_unit) == (pytest.approx(length), pytest.approx(force))
    assert own.total_load == pytest.approx(2.0)
    assert own.matrix.toarray() == pytest.approx(matrix, abs=1e-14)
    load = scale * eq.load.reshape(-1) / force
    if laws:
        for k in range(8):
            load = load - matrix[:, 3 * k] * shift[k] / force
        assert own.lower == pytest.approx(lower / force)
        assert own.upper == pytest.approx(upper / force)
        assert own.shift == pytest.approx(shift / force)
    else:
        assert (own.shift == 0).all()
        assert (own.lower == 0).all()
        assert (own.upper == inf).all()
    assert own.load == pytest.approx(load, abs=1e-13)
    assert own.n_points == 8
    assert own.plane is None


def test_a_program_without_loads_counts_forces_in_newtons(pile):
    own = penalty_program(eq_of(pile, np.zeros((4, 6))), np.ones(8))
    assert (own.force_unit, own.total_load) == (1.0, 1.0)


def test_units_of_blocks_and_points_change_no_force_and_no_motion():
    own, rng = program(), np.random.default_rng(8)
    block, point = rng.uniform(0.1, 5, N), rng.uniform(0.1, 5, M)
    other = own.in_units(block, point)
    force, twist = rng.normal(size=(M, 3)), rng.normal(size=6 * N)
    rest = dense(own) @ (point[:, None] * force).reshape(-1) + own.load
    assert other.matrix @ force.reshape(-1) + other.load == pytest.approx(rest / np.repeat(block, 6), abs=1e-12)
    rates = (dense(own).T @ (twist / np.repeat(block, 6))).reshape(-1, 3)
    assert (other.matrix.T @ twist).reshape(-1, 3) == pytest.approx(point[:, None] * rates, abs=1e-12)
    for name in ("shift", "lower", "upper"):
        assert getattr(other, name) == pytest.approx(getattr(own, name) / point)
    assert other.plane is None


# The conic program.


def by_hand(own, cost, *, penalty=False, offset=None, at_most_one=None, pinned=None, yielding=0.0):
    """M, b, q, P of the doc: rows of triples by component, zeros, half-lines, bounds, border."""
    matrix, mu = dense(own), own.friction
    rough = [k for k in range(M) if 0 < mu[k] < inf]
    stuck, single = [k for k in range(M) if mu[k] == inf], [k for k in range(M) if mu[k] in (0.0, inf)]
    rows = [(k, 0, min(mu[k], 1.0) / mu[k]) for k in rough]
    rows += [(k, c, min(mu[k], 1.0)) for c in (1, 2) for k in rough]
    rows += [(k, c, 1.0) for c in (1, 2) for k in stuck] + [(k, 0, 1.0) for k in single]
    above, below = [k for k in range(M) if own.upper[k] < inf], [k for k in range(M) if own.lower[k] > 0]
    unknowns = [(k, 1.0) for k in above] + [(k, -1.0) for k in below]
    n = 6 * N + len(unknowns)
    lines, bound = [], []
    for k, c, scale in rows:
        line = np.zeros(n)
        line[: 6 * N] = -scale * matrix[:, 3 * k + c]
        if c == 0:
            for j, (point, sign) in enumerate(unknowns):
                if point == k:
                    line[6 * N + j] -= sign * scale
        lines.append(line)
        bound.append(0.0 if offset is None else scale * offset[3 * k + c])
    lines += [-np.eye(n)[6 * N + j] for j in range(len(unknowns))]
    bound += [0.0] * len(unknowns)
    earned = [yielding if sign > 0 and k < own.n_points else 0.0 for k, sign in unknowns]
    if at_most_one is not None:
        lines.append(np.append(at_most_one, earned))
        bound.append(1.0)
    if pinned is not None:
        lines.append(np.append(-pinned, np.zeros(len(unknowns))))
        bound.append(-1.0)
    price = [own.upper[k] if sign > 0 else -own.lower[k] for k, sign in unknowns]
    squares = np.zeros((own.n_points if penalty else 0, n))
    for k in range(len(squares)):
        squares[k, : 6 * N] = matrix[:, 3 * k]
        for j, (point, sign) in enumerate(unknowns):
            if point == k and sign > 0:
                squares[k, 6 * N + j] = 1.0
    counts = len(rough), 2 * len(stuck), len(single) + len(unknowns) + (at_most_one is not None) + (pinned is not None)
    return np.array(lines), np.array(bound), np.concatenate([cost, np.subtract(price, earned)]), squares, counts, rows


OPTIONS = [
    {}, {"penalty": True}, {"offset": True}, {"at_most_one": True, "yielding": 0.7}, {"pinned": True},
    {"penalty": True, "offset": True, "at_most_one": True, "pinned": True, "yielding": 1.3},
]  # fmt: skip


def options_of(names, seed=6):
    rng = np.random.default_rng(seed)
    vectors = {
        "offset": rng.normal(size=3 * M),
        "at_most_one": rng.normal(size=6 * N),
        "pinned": rng.normal(size=6 * N),
    }
    return {name: vectors.get(name, value) for name, value in names.items()}


@pytest.mark.parametrize("names", OPTIONS)
@pytest.mark.parametrize("bounds", ["none", "lower", "upper", "both"])
def test_every_row_of_the_conic_program_is_that_of_its_point(names, bounds):
    own, cost = program(bounds=bounds), np.random.default_rng(9).normal(size=6 * N)
    options = options_of(names)
    conic = conic_program(own, cost, **options)
    matrix, bound, price, squares, counts, rows = by_hand(own, cost, **options)
    assert conic.matrix.toarray() == pytest.approx(matrix, abs=1e-14)
    assert conic.transposed.toarray() == pytest.approx(matrix.T, abs=1e-14)
    assert conic.bound == pytest.approx(bound, abs=1e-14)
    assert conic.cost == pytest.approx(price, abs=1e-14)
    assert conic.penalty.toarray() == pytest.approx(squares, abs=1e-14)
    assert (conic.n_triples, conic.n_zeros, conic.n_half) == counts
    assert conic.pinned is ("pinned" in names)
    assert conic.is_quadratic is ("penalty" in names)
    assert (conic.ridge, conic.compliance, conic.width, conic.n_blocks) == (0.0, 0.0, 6, N)
    assert conic.plane is None
    # The rows of points once more: the three of a triple stand together.
    triples, n = counts[0], len(rows)
    order = [c * triples + k for k in range(triples) for c in range(3)] + list(range(3 * triples, n))
    for line, entries, pair in zip(order, conic.local, conic.pair, strict=False):
        own_row = np.zeros(6 * N)
        for side, block in enumerate(pair):
            if block >= 0:
                own_row[6 * block : 6 * block + 6] += entries[6 * side : 6 * side + 6]
        assert own_row == pytest.approx(-matrix[line, : 6 * N], abs=1e-14)
    rest = conic.pair[n:]
    if "penalty" in names:
        assert rest[:POINTS].tolist() == PAIRS[:POINTS].tolist()
        assert (conic.penalty_local == own.local[[0, 3, 6, 9, 12, 15, 18]]).all()
        rest = rest[POINTS:]
    else:
        assert conic.penalty_local.shape == (0, 12)
    bounded = {"none": (), "lower": (0, 3, 8), "upper": (3, 4, 7), "both": (0, 3, 4, 7, 8)}[bounds]
    assert rest.tolist() == [PAIRS[k].tolist() for k in bounded for _ in range(4)]
    if bounds != "none":
        assert conic.bounds.size == {"lower": 3, "upper": 3, "both": 6}[bounds]
        assert conic.bounds.y.tolist() == [
            list(own.upper_bounded).index(k) if own.upper[k] < inf else -1 for k in bounded
        ]


def test_the_unknowns_of_bounded_points_are_named():
    conic = conic_program(program(), np.zeros(6 * N), penalty=True)
    own = conic.bounds
    # Triples are the points 0, 3, 4, 7, 8; a head counts 1 / mu times where mu is above 1, else once.
    assert own.point.tolist() == [0, 3, 4, 7, 8]
    assert own.row.tolist() == [0, 1, 2, 3, 4]
    assert own.head == pytest.approx([1.0, 1 / 1.6, 1.0, 1.0, 1 / 2.5])
    assert own.penalty.tolist() == [0, 3, 4, -1, -1]
    assert own.y.tolist() == [-1, 0, 1, 2, -1]
    assert own.z.tolist() == [3, 4, -1, -1, 5]
    assert own.size == 6
    assert own.is_triple
    assert conic.has_structure
    bare = conic_program(program(bounds="none"), np.zeros(6 * N))
    assert bare.bounds is None
    assert bare.has_structure
    smooth = replace(program(), upper=np.where(np.arange(M) == 1, 1.0, inf), lower=np.zeros(M))
    assert not conic_program(smooth, np.zeros(6 * N)).has_structure
    with pytest.raises(FrozenInstanceError):
        own.is_triple = False
    with pytest.raises(FrozenInstanceError):
        conic.n_half = 0
    empty = PointBounds(*[np.empty(0, dtype=int)] * 2, True, np.empty(0), *[np.empty(0, dtype=int)] * 3)
    assert empty.size == 0


def test_a_program_is_linear_in_space_and_without_bounds_unless_it_says_otherwise():
    conic = conic_program(program(), np.zeros(6 * N), penalty=True, least_norm=True, pinned=np.ones(6 * N))
    plain = conic.feasibility()
    bare = ConicProgram(**{own.name: getattr(plain, own.name) for own in fields(plain) if own.default is MISSING})
    assert not bare.is_quadratic
    assert bare.has_structure
    assert (bare.plane, bare.bounds, bare.pinned, bare.ridge, bare.compliance) == (None, None, False, 0.0, 0.0)


def test_the_feasibility_of_a_program_has_its_rows_and_its_cost_alone():
    own, cost = program(), np.random.default_rng(9).normal(size=6 * N)
    conic = replace(conic_program(own, cost, penalty=True, pinned=cost), ridge=2.0)
    bare, plain = conic.feasibility(), conic_program(own, cost, pinned=cost)
    for name in ("cost", "bound", "local", "pair", "penalty_local", "friction", "scale", "rows"):
        assert (getattr(bare, name) == getattr(plain, name)).all(), name
    assert abs(bare.matrix - plain.matrix).max() == 0
    assert bare.penalty.shape == (0, len(conic.cost))
    assert not bare.is_quadratic
    assert conic.is_quadratic
    assert bare.bounds.penalty.tolist() == [-1] * 5
    assert conic.bounds.penalty.tolist() == [0, 3, 4, -1, -1]
    assert bare.transposed is conic.transposed
    assert conic_program(own, cost, least_norm=True).ridge == 1.0
    assert conic_program(own, cost, least_norm=True).is_quadratic
    assert conic_program(program(bounds="none"), cost).feasibility().bounds is None


def test_options_of_programs_are_named(pile):
    own = program()
    for call in (
        lambda: conic_program(own, own.load, True), lambda: penalty_program(eq_of(pile), np.ones(8), np.zeros(8)),
    ):  # fmt: skip
        with pytest.raises(TypeError):
            call()


def test_the_penalty_on_a_single_point_is_quadratic_and_gone_in_feasibility():
    whole = program(bounds="none")
    own = replace(whole, local=whole.local[:3], point_blocks=PAIRS[:1], n_points=1, friction=FRICTION[:1],
                  **{name: getattr(whole, name)[:1] for name in ("lower", "upper", "shift")})  # fmt: skip
    conic = conic_program(own, own.load, penalty=True)
    assert conic.is_quadratic
    assert conic.feasibility().ridge == 0.0
    assert replace(conic.feasibility(), ridge=0.5).is_quadratic


def test_twists_forces_rates_and_yielding_are_read_off_the_answer():
    own, rng = program(), np.random.default_rng(11)
    conic = conic_program(own, rng.normal(size=6 * N), pinned=rng.normal(size=6 * N))
    rows = by_hand(own, np.zeros(6 * N))[-1]
    x, z = rng.normal(size=len(conic.cost)), rng.normal(size=len(conic.bound))
    assert (conic.twist(x) == x[:18]).all()
    force, rate = np.zeros((M, 3)), np.zeros((M, 3))
    for value, (k, c, scale) in zip(z, rows, strict=False):
        force[k, c], rate[k, c] = scale * value, value / scale
    assert conic.forces(z) == pytest.approx(force)
    assert conic.rates(z) == pytest.approx(rate)
    values = conic.multipliers(force)
    assert values[: len(rows)] == pytest.approx(z[: len(rows)])
    assert values.shape == z.shape
    assert not values[len(rows) :].any()
    assert conic.yielding(x).tolist() == [0, 0, 0, x[18], x[19], 0, 0, x[20], 0]


@pytest.fixture(scope="module")
def flat():
    """An arch of five voussoirs along y that leans in its plane."""
    own = program_of(arch(5, 0.2).with_(gravity=(0.1, 0, -1), friction=0.6))
    n = len(own.friction)
    return replace(own, friction=_mirrored(own.plane, np.linspace(0.0, 2.5, n)))


def _mirrored(plane, value):
    value = value.copy()
    value[plane.second] = value[plane.first]
    return value


def in_plane(own, rng):
    """Random planar twists, and the normal and in-plane rates of a point of each pair, at both of its ends."""
    planar = rng.normal(size=own.plane.unfold.shape[1])
    twist = own.plane.unfold @ planar
    rates = (dense(own).T @ twist).reshape(-1, 3)
    across = rates[:, 1:] - (rates[:, 1:] * _tangents(own.plane)).sum(axis=1)[:, None] * _tangents(own.plane)
    assert np.abs(across).max() < 1e-12
    assert rates[own.plane.first] == pytest.approx(rates[own.plane.second], abs=1e-12)
    return planar, twist, rates


def _tangents(plane):
    found = np.empty((2 * len(plane.first), 2))
    found[plane.first] = found[plane.second] = plane.tangent
    return found


def test_in_the_plane_every_pair_of_points_is_two_half_lines(flat):
    rng, plane = np.random.default_rng(0), flat.plane
    planar, twist, rates = in_plane(flat, rng)
    offset = rng.normal(size=(len(flat.friction), 3))
    offset[:, 1:] = _tangents(plane) * offset[:, 1:2]
    offset[plane.second] = offset[plane.first]
    push, least = (plane.unfold @ rng.normal(size=plane.unfold.shape[1]) for _ in range(2))
    conic = conic_program(flat, flat.load, penalty=True, offset=offset.reshape(-1), at_most_one=least, pinned=push)
    assert conic.plane is plane
    first, mu = plane.first, flat.friction[plane.first]
    total = rates + offset
    along = (total[first][:, 1:] * plane.tangent).sum(axis=1)
    scale = np.array([1.0 / max(m, 1.0) for m in mu])
    slack = conic.bound - conic.matrix @ planar
    expected = [*(scale * (total[first, 0] + mu * along)), *(scale * (total[first, 0] - mu * along))]
    expected += [1.0 - least @ twist, push @ twist - 1.0]
    assert slack == pytest.approx(np.array(expected), abs=1e-12)
    assert conic.cost @ planar == pytest.approx(flat.load @ twist)
    # Both points of a pair count in the penalty.
    assert ((conic.penalty @ planar) ** 2).sum() == pytest.approx((rates[:, 0] ** 2).sum())
    n = len(first)
    assert (conic.n_triples, conic.n_zeros, conic.n_half, conic.width) == (0, 0, 2 * n + 2, 3)
    assert conic.penalty.shape == (n, len(planar))
    # The same rows in the columns of their blocks.
    rows = [*-conic.matrix[: 2 * n].toarray(), *conic.penalty.toarray()]
    entries = [*conic.local, *conic.penalty_local]
    assert len(rows) == len(entries) == len(conic.pair) == 3 * n
    for row, entry, pair in zip(rows, entries, conic.pair, strict=True):
        own = np.zeros(len(planar))
        for side, block in enumerate(pair):
            if block >= 0:
                own[3 * block : 3 * block + 3] += entry[3 * side : 3 * side + 3]
        assert own == pytest.approx(row, abs=1e-14)
    assert conic.twist(planar) == pytest.approx(twist)
    bare = conic_program(flat, flat.load)
    assert not bare.bound.any()
    assert bare.penalty.shape == (0, len(planar))
    assert bare.penalty_local.shape == (0, 6)
    assert bare.rows.shape == (0,)
    assert not bare.is_quadratic


def test_multipliers_of_half_planes_are_forces_at_both_ends_of_a_joint(flat):
    rng, plane, mu = np.random.default_rng(1), flat.plane, flat.friction
    conic = conic_program(flat, flat.load)
    n = len(plane.first)
    z = rng.uniform(0, 2, len(conic.bound))
    force = conic.forces(z)
    scale = [1.0 / max(mu[k], 1.0) for k in plane.first]
    for j, (one, two) in enumerate(zip(plane.first, plane.second, strict=True)):
        plus, minus = scale[j] * z[j], scale[j] * z[n + j]
        both = [plus + minus, *(mu[one] * (plus - minus) * plane.tangent[j])]
        assert force[one] == pytest.approx(np.array(both) / 2)
        assert force[two] == pytest.approx(np.array(both) / 2)
    back = conic.forces(conic.multipliers(force))
    assert back == pytest.approx(force)
    # What the two ends carry adds up, however it is shared.
    shared = force.copy()
    shared[plane.first] += [0.1, 0.0, 0.0]
    shared[plane.second] -= [0.1, 0.0, 0.0]
    assert conic.multipliers(shared) == pytest.approx(conic.multipliers(force))
    assert conic.multipliers(force)[mu[plane.first].nonzero()] == pytest.approx(z[:n][mu[plane.first] > 0])


def test_a_smooth_point_is_pressed_by_both_of_its_half_lines_alike(flat):
    plane = flat.plane
    own = replace(flat, friction=_mirrored(plane, np.where(np.arange(len(flat.friction)) % 2, 0.5, 0.0)))
    smooth = own.friction[plane.first] == 0
    assert 0 < smooth.sum() < len(smooth)
    force = np.random.default_rng(2).uniform(0, 2, (len(own.friction), 1)) * [1.0, 0, 0]
    conic = conic_program(own, own.load)
    plus, minus = conic.multipliers(force).reshape(2, -1)
    total = force[plane.first, 0] + force[plane.second, 0]
    assert plus[smooth] == pytest.approx(total[smooth] / 2)
    assert minus == pytest.approx(plus)


def test_a_scene_is_folded_only_where_all_of_the_question_is_planar(flat):
    n = len(flat.load)
    across = np.zeros(n)
    across[1] = 1e-3  # along y
    tilted = np.zeros(len(flat.friction) * 3)
    tilted[3 * flat.plane.second[1]] = 1.0  # at one end of a joint alone
    straight = flat.load
    assert conic_program(flat, straight).plane is flat.plane
    assert conic_program(flat, straight, offset=np.zeros(len(tilted)), pinned=straight).plane is flat.plane
    assert conic_program(flat, straight + across).plane is None
    assert conic_program(flat, straight, pinned=across).plane is None
    assert conic_program(flat, straight, at_most_one=across).plane is None
    assert conic_program(flat, straight, offset=tilted).plane is None
    sticky = replace(flat, friction=np.where(np.arange(len(flat.friction)) < 2, inf, flat.friction))
    assert conic_program(sticky, straight).plane is None
    even = replace(flat, friction=np.full(len(flat.friction), 0.6))
    assert conic_program(even, straight, compliance=0.1).plane is None
    assert conic_program(even, straight, compliance=0.1).compliance == 0.1
    assert conic_program(replace(flat, plane=None), straight).plane is None


def test_what_is_planar_is_so_to_rounding(flat):
    plane, n = flat.plane, len(flat.load)
    one = np.zeros(n)
    one[[0, 2, 4]] = [3.0, -2.0, 1.0]
    for k, planar in ((1, False), (3, False), (5, False), (0, True), (2, True), (4, True)):
        for size in (0.9e-12, 1.1e-12):
            other = one.copy()
            other[6 + k] += 3.0 * size
            assert plane.holds(None, one, other) is (planar or size < 1e-12)
    assert plane.holds()
    assert plane.holds(np.zeros(n))
    rate = np.zeros((len(flat.friction), 3))
    rate[:, 0], rate[:, 1:] = 2.0, 0.5 * _tangents(plane)
    assert plane.mirrors(rate.reshape(-1))
    for points in (plane.first, plane.second):
        for size, same in ((1.9e-12, True), (2.2e-12, False)):
            other = rate.copy()
            other[points[2], 0] += size
            assert plane.mirrors(other.reshape(-1)) is same
            assert plane.mirrors(1e-6 * other.reshape(-1)) is same  # whatever the size of the rates
    aside = rate.copy()
    aside[plane.first[1], 1:] += [-0.1 * plane.tangent[1, 1], 0.1 * plane.tangent[1, 0]]
    aside[plane.second[1]] = aside[plane.first[1]]
    assert not plane.mirrors(aside.reshape(-1))


def turned(axis):
    """Three blocks of different form on a support, prismatic along an axis, from 1 to 1.7 there."""
    outlines = [[(-2, -1), (3, -1), (3, 0), (-2, 0)], [(0, 0), (1, 0), (0.8, 0.5), (0, 0.5)]]
    outlines += [[(1.2, 0), (2.5, 0), (2.5, 0.5), (1.2, 0.5)], [(0.3, 0.5), (2.0, 0.5), (1.5, 1.1)]]
    blocks = [prism(outline, 0.7) for outline in outlines]
    order = {0: [1, 0, 2], 1: [0, 1, 2], 2: [2, 0, 1]}[axis]
    if axis == 0:
        order = [1, 2, 0]
    moved = []
    for block in blocks:
        vertices = np.asarray(block.vertices, float) + [0, 1, 0]
        moved.append(type(block)(vertices[:, order], block.faces))
    return assembly(moved, gravity=np.array([0.2, 0, -1.0])[order], friction=0.5)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_prismatic_scene_moves_in_its_plane_alone(axis):
    asm = turned(axis)
    faces = find_interfaces(asm)
    eq = equilibrium(asm, faces, weight(asm), asm.free, np.arange(faces.n_points))
    plane = find_plane(asm, faces, eq)
    assert plane is not None
    unfold = plane.unfold.toarray()
    # Two velocities in the plane and the rotation about its normal, in the order of the axes.
    wanted = [k for k in range(6) if (k < 3 and k != axis) or k == 3 + axis]
    expected = np.zeros((18, 9))
    for block in range(3):
        for j, k in enumerate(wanted):
            expected[6 * block + k, 3 * block + j] = 1.0
    assert (unfold == expected).all()
    one, two = faces.point[plane.first], faces.point[plane.second]
    assert (one[:, axis] < two[:, axis]).all()
    assert np.delete(one, axis, axis=1) == pytest.approx(np.delete(two, axis, axis=1), abs=1e-12)
    assert sorted([*plane.first, *plane.second]) == list(range(faces.n_points))
    k = faces.point_interface
    assert (k[plane.first] == k[plane.second]).all()
    direction = np.einsum("pk,pkj->pj", plane.tangent, faces.frame[k[plane.first], 1:])
    assert np.linalg.norm(direction, axis=1) == pytest.approx(np.ones(len(direction)))
    assert np.abs(direction[:, axis]).max() < 1e-12
    # Along the normal turned by a right angle about the axis.
    assert direction == pytest.approx(np.cross(np.eye(3)[axis], faces.frame[k[plane.first], 0]), abs=1e-12)
    own = penalty_program(eq, np.full(eq.n_columns, 0.5), plane=plane)
    assert own.plane is plane
    planar, _, rates = in_plane(own, np.random.default_rng(axis))
    blocks = own.point_blocks[plane.first]
    normal, along = (in_place(local, blocks, eq.n_blocks).T for local in own.planar_local)
    assert normal @ planar == pytest.approx(rates[plane.first, 0], abs=1e-12)
    assert along @ planar == pytest.approx((rates[plane.first, 1:] * plane.tangent).sum(axis=1), abs=1e-12)


def test_a_scene_is_prismatic_to_a_ten_millionth_of_its_smallest_block():
    asm = turned(1)
    faces = find_interfaces(asm)
    eq = equilibrium(asm, faces, weight(asm), asm.free, np.arange(faces.n_points))
    size = eq.length.min()

    def is_flat(**changes):
        return find_plane(asm, replace(faces, **changes), eq) is not None

    for share, same in ((0.5e-7, True), (2e-7, False)):
        for axis in range(3):
            point = faces.point.copy()
            point[3, axis] += share * size
            assert is_flat(point=point) is same, (axis, share)
        frame = faces.frame.copy()
        frame[1, 0, 1] += share
        assert is_flat(frame=frame) is same
        moved = faces.point + np.where(np.arange(3) == 1, share * size, 0.0)
        assert (find_plane(asm, replace(faces, point=moved), eq) is not None) is same
    assert find_plane(asm, faces, replace(eq, points=eq.points[:0])) is None
    # One point fewer at one end.
    few = equilibrium(asm, faces, weight(asm), asm.free, np.arange(1, faces.n_points))
    assert find_plane(asm, faces, few) is None
    # All points at one height have no two ends.
    level = faces.point.copy()
    level[:, 1] = 1.35
    assert not is_flat(point=level)


@pytest.mark.parametrize("place", [0.5, 4.5, 5.5, 9.5])
def test_points_that_stand_almost_above_each_other_have_their_mirror_images(place):
    # Across an upright joint: the lower corner leaves the line of the upper one, at one end by a little more.
    asm = assembly([box((-1, 0, 0), (0, 1, 1)), box((0, 0, 0), (1, 1, 1))])
    faces = find_interfaces(asm)
    eq = equilibrium(asm, faces, weight(asm), asm.free, np.arange(faces.n_points))
    unit, point = 1e-7 * eq.length.min(), faces.point.copy()
    low, near = point[:, 2] < 0.5, point[:, 1] < 0.5
    point[:, 0] += low * np.where(near, place - 0.1, place + 0.1) * unit
    plane = find_plane(asm, replace(faces, point=point), eq)
    assert plane is not None
    assert (low[plane.first] == low[plane.second]).all()
    assert near[plane.first].all()
    assert not near[plane.second].any()


def test_points_of_one_place_in_two_joints_are_paired_within_their_joint():
    # The corner at x = 1, z = .5 belongs to two joints that meet there.
    asm = assembly(
        [prism([(0, -1), (2, -1), (2, 0), (0, 0)], 1.0), prism([(0, 0), (1, 0), (1, 1), (0, 1)], 1.0),
         prism([(1, 0), (2, 0), (2, 1), (1, 1)], 1.0)], friction=0.5,
    )  # fmt: skip
    own = program_of(asm)
    k = find_interfaces(asm).point_interface
    assert (k[own.plane.first] == k[own.plane.second]).all()
    assert isinstance(own.plane, Plane)


def test_data_is_frozen_and_compared_by_identity(pile, flat):
    own, eq = program(), eq_of(pile)
    conic, columns = conic_program(own, own.load), bond_columns(pile[1], np.array([1]))
    bonds = bond_forces(pile[1], np.array([1]), np.ones((4, 3)))
    for data in (own, eq, conic, conic.bounds, columns, flat.plane, bonds):
        name = fields(data)[0].name
        with pytest.raises(FrozenInstanceError):
            setattr(data, name, None)
        assert replace(data) != data
        assert len({data, replace(data)}) == 2


# Bonds and ties.


def test_bonds_at_the_centre_have_capacities_in_force_and_moment(pile):
    asm, faces = pile
    asm = asm.with_(joints=[JointLaw(("*", "*"), bond=3.0, bond_moment=2.0)])
    rows, capacity = bonded(asm, faces)
    assert rows.tolist() == [0, 1, 2]
    expected = [[3.0, 3.0, 2.0 / np.sqrt(a), 2.0 / np.sqrt(a)] for a in (0.5, 2.0, 1.2)]
    assert capacity == pytest.approx(np.array(expected).reshape(-1))
    assert bonded(asm, replace(faces, area=np.array([0.5, 0.0, 1.2])))[0].tolist() == [0, 2]
    for law, found in (
        ({"bond_moment": 2.0}, [0, 1, 2]), ({"bond": 1.0, "bond_moment": 0.0}, [0, 1, 2]), ({"bond_moment": 0.0}, []),
        ({"bond": 1.0}, []), ({}, []),
    ):  # fmt: skip
        assert bonded(asm.with_(joints=[JointLaw(("*", "*"), **law)]), faces)[0].tolist() == found
    none = bonded(asm.with_(joints=[]), faces)
    assert (len(none[0]), len(none[1])) == (0, 0)


def test_what_bonds_carry_is_the_sum_of_their_columns(pile):
    _, faces = pile
    rows, rng = np.array([2, 1]), np.random.default_rng(1)
    columns, values = bond_columns(faces, rows), rng.normal(size=(8, 3))
    own = bond_forces(faces, rows, values)
    assert columns.pair.tolist() == [[2, 3]] * 4 + [[0, 2]] * 4
    for j, k in enumerate(rows):
        n, one, two = faces.frame[k]
        tension, shear, bending, torsion = values[4 * j : 4 * j + 4]
        arm = np.sqrt(faces.area[k])
        assert own.force[j] == pytest.approx(-tension[0] * n + shear[1] * one + shear[2] * two)
        assert own.moment[j] == pytest.approx(arm * (bending[1] * one + bending[2] * two + torsion[1] * n))
        assert columns.point[4 * j : 4 * j + 4] == pytest.approx(np.tile(columns.point[4 * j], (4, 1)))
    assert own.interface is rows
    corners = faces.point[faces.start[2] : faces.start[3]]
    # The centroid of a triangle is the mean of its corners, in its plane.
    flat = (corners - corners.mean(axis=0)) @ faces.frame[2, 1:].T
    inside = (columns.point[0] - corners.mean(axis=0)) @ faces.frame[2, 1:].T
    assert inside == pytest.approx(np.zeros(2), abs=1e-12)
    assert flat.shape == (3, 2)


def tied(strut=False):
    blocks = [
        box((0, 0, 0), (1, 1, 1), name="a"),
        box((2, 0, 0), (3, 1, 2), name="b"),
        box((5, 5, 0), (6, 6, 1), name="c"),
    ]
    ties = [
        Tie(("b", "a"), ((2.0, 0.3, 1.7), (1.0, 0.6, 0.2)), least=1.0, greatest=3.0, strut=strut, name="bar"),
        Tie((2, "b"), ((5.0, 5.4, 0.4), (3.0, 0.5, 1.0)), least=2.0, greatest=2.0),
    ]
    return assembly(blocks, supports=["c"], ties=ties)


@pytest.mark.parametrize("strut", [False, True])
def test_a_tie_pulls_its_blocks_along_its_line_and_a_strut_pushes_them(strut):
    asm = tied(strut)
    assert tied_pairs(asm).tolist() == [[1, 0], [2, 1]]
    columns = tie_columns(asm, asm.ties)
    assert columns.pair.tolist() == [[1, 0], [2, 1]]
    ends = [np.array(tie.points) for tie in asm.ties]
    for k, (p, q) in enumerate(ends):
        along = (q - p) / np.sqrt(((q - p) ** 2).sum())
        sign = 1.0 if strut and k == 0 else -1.0
        assert columns.force[k, 0] == pytest.approx(sign * along)
        assert not columns.force[k, 1:].any()
        assert columns.point[k].tolist() == q.tolist()
    force = np.array([1.3, 2.0])
    expected = np.zeros((3, 6))
    for k, (p, q) in enumerate(ends):
        a, b = columns.pair[k]
        pull = force[k] * columns.force[k, 0]
        expected[b] += [*pull, *np.cross(q - asm.centroid[b], pull)]
        expected[a] += [*-pull, *np.cross(p - asm.centroid[a], -pull)]  # both ends lie on the line
    assert tie_wrenches(asm, asm.ties, force) == pytest.approx(expected, abs=1e-12)
    check_anchors(asm)
    assert tied_pairs(asm.with_(ties=[])).shape == (0, 2)
    assert tie_columns(asm, []).force.shape == (0, 3, 3)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (((2.0, 0.3, 2.1), (1.0, 0.6, 0.2)), r'tie "bar": the point \[2.0, 0.3, 2.1\] is not on block "b"'),
        (((2.0, 0.3, 1.7), (1.1, 0.6, 0.2)), r'tie "bar": the point \[1.1, 0.6, 0.2\] is not on block "a"'),
    ],
)
def test_the_end_of_a_tie_off_its_block_is_named(points, message):
    asm = tied()
    with pytest.raises(ValueError, match=message):
        check_anchors(asm.with_(ties=[replace(asm.ties[0], points=points)]))
    free = replace(asm.ties[1], points=((9.0, 9.0, 9.0), (3.0, 0.5, 1.0)))  # the ground may be anywhere
    check_anchors(asm.with_(ties=[free]))


def test_a_posed_push_is_the_mean_weight_in_the_program():
    problem = pose(stack(2), friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)
    load = problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    assert load.reshape(2, 6)[:, 0] == pytest.approx([1.0, 1.0])


def test_a_block_on_two_ridges_is_prismatic_along_them_and_not_across():
    # Its points lie at two ends across the ridges, too, but each end is a contact of its own.
    ridges = [prism([(x - 0.1, -0.2), (x + 0.1, -0.2), (x, 0.0)], 0.8) for x in (-0.3, 0.3)]
    asm = assembly([*ridges, box((-0.5, 0, 0), (0.5, 0.8, 1.2))], supports=[0, 1])
    own = program_of(asm)
    assert own.matrix.shape == (6, 12)
    assert own.plane is not None
    assert own.plane.unfold.toarray().nonzero()[0].tolist() == [0, 2, 4]
