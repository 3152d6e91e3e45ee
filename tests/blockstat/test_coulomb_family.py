"""The search for a Coulomb state: when slips grow, how they are relaxed, when it ends and what it says then."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat.analysis.coulomb import (
    FAMILY,
    MOST_SOLVES,
    _bisection,
    _Member,
    _search,
    _unclosed,
    coulomb_state,
    multiplier_brackets,
    settling_share,
)
from blockstat.analysis.problem import pose
from blockstat.certificate.coulomb_state import RATE_ACCURACY
from blockstat.loads import acceleration, point_load
from blockstat.solve import coulomb
from blockstat.solve.coulomb import Iterate
from evidence.scenes.small import assembly, box, flat_arch, stack


def posed(asm):
    return pose(asm, friction=None, gravity=None, loads=None, gap=0.01, interfaces=None)


def member(changes=(), lost=False):
    return _Member(np.ones(2), 1e-3, np.zeros(2), changes=list(changes), lost=lost)


@pytest.mark.parametrize(("changes", "grows"), [
    ([1, 1, 1, 1, 1], False), ([9, 9, 2, 2, 2, 2], True), ([9, 9, 2, 2, 2, 1.9], False), ([0, 0, 2, 2, 3, 1, 2], True),
    ([0, 0, 2, 2, 3, 1, 1.9], False), ([9, 9, 9, 3, 3, 3, 1.76, 1.76, 1.76], True),
    ([9, 9, 9, 3, 3, 3, 1.75, 1.75, 1.75], False), ([9, 9, 3, 3, 1.76, 1.76, 1.76, 1.76], False),
    (1 / np.arange(1.0, 31.0), True), (1 / np.arange(1.0, 31.0) ** 1.2, False), (0.8 ** np.arange(12.0), False),
])  # fmt: skip
def test_slips_grow_where_their_changes_shrink_no_faster_than_a_harmonic_series(changes, grows):
    assert member(changes).grows is grows
    assert member(changes).ends is grows


@pytest.mark.parametrize(
    ("changes", "grows"), [([], False), ([1], False), ([1, 1], False), ([1, 2], True), ([2, 1], False)]
)
def test_where_no_forces_are_left_slips_grew_if_the_last_change_was_the_larger(changes, grows):
    assert member(changes, lost=True).grows is grows
    assert member(changes, lost=True).ends
    assert not member(changes).ends


def test_slips_that_go_back_and_forth_take_the_share_of_the_secant():
    one = _Member(np.ones(1), 1e-3, np.zeros(1))
    for step, slip, share in (
        (2.0, 2.0, 1.0), (-1.0, 1.0, 1.0),  # once back is no reason
        (1.0, 1.5, 0.5),  # the secant of -1 and 1 is half way
        (-4.0, 1.1, 0.1),  # a fifth of half
        (-1.0, 0.9, 0.2), (-1.0, 0.5, 0.4), (-1.0, -0.3, 0.8), (-1.0, -1.3, 1.0), (1.0, -0.3, 1.0),
        (-19.0, -2.2, 0.1),  # never less than a tenth
    ):  # fmt: skip
        one._relax(np.array([step]))
        assert one.slip == pytest.approx([slip])
        assert one.share == pytest.approx(share)
    many = _Member(np.ones(3), 1e-3, np.zeros(3))
    for step in ([1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 1.0]):
        many._relax(np.array(step))
    assert many.slip == pytest.approx([0.5, 3.0, 1.0])


def test_what_falls_leaves_no_forces():
    program = posed(stack(1).with_(gravity=(1.5, 0, -1))).program
    m = len(program.friction)
    one = _Member(np.ones(m), 1e-3, np.zeros(m))
    assert one.solve(program, "auto") is False
    assert one.lost
    assert one.ends
    assert one.last is None
    lost = _search(program, [_Member(np.ones(m), 1e-3, np.zeros(m))], "auto")
    assert lost.settles is None
    assert lost.solves == 1
    assert not lost.force.any()
    assert not lost.opposed


def test_what_settles_is_found_in_every_kind_of_joints():
    program = posed(stack(2).with_(gravity=(0.05, 0, -1))).program
    for kind in FAMILY:
        found = coulomb_state(program, kinds=[kind])
        assert found.settles is True
        assert found.certificate.proves_settled
        assert len(found.changes) == 1
        assert len(found.changes[0]) == found.solves
        assert np.isnan(found.tightness)
    both = coulomb_state(program, tightnesses=3)
    assert both.tightness == 1.0
    assert settling_share(program, tries=2, seed=5) == 1.0


def test_a_search_ends_after_so_many_programs():
    program = posed(flat_arch(6, friction=0.1)).program
    m = len(program.friction)
    members = [_Member(np.full(m, t), c, np.zeros(m)) for t, c in FAMILY]
    found = _search(program, members, "auto", 4)
    assert found.solves == 4
    assert found.settles is None
    assert [len(own) for own in found.changes] == [2, 1, 1]


def test_a_flat_arch_grows_in_all_kinds_of_joints():
    asm = flat_arch(6, friction=0.1)
    problem = posed(asm)
    found = coulomb_state(problem.program)
    assert found.settles is False
    assert found.opposed
    assert 0 < found.share <= 1.0
    assert len(found.held)
    assert found.solves <= MOST_SOLVES
    assert found.solves > sum(len(own) for own in found.changes)  # stiff joints of unequal openings were tried
    assert all(own[-1] > 0 for own in found.changes)
    normal = found.force[: problem.program.n_points, 0]
    assert (normal[found.held] > 0).all()
    assert found.share == pytest.approx(normal[found.held].sum() / normal[normal > 0].sum())
    one = coulomb_state(problem.program, kinds=[FAMILY[0]])
    assert one.settles is False
    assert one.solves == len(one.changes[0])  # of one kind alone no others are tried
    assert settling_share(problem.program, tries=2) == 0.0


def test_a_bracket_of_a_sliding_block_is_as_narrow_as_said_from_the_top():
    asm = assembly([box((-9, -9, -1), (9, 9, 0)), box((0, 0, 0), (1, 1, 0.5))], friction=0.4)
    problem = posed(asm)
    load = problem.scaled(acceleration(asm, (1, 0, 0)))
    steps = list(_bisection(problem.program, load, 0.5, FAMILY[0], "auto"))
    assert steps[0] == (0.0, 0.5)
    assert steps[1] == (0.0, pytest.approx(0.5 * (1 - 5e-4)))
    assert steps[2] == (pytest.approx(0.25 * (1 - 5e-4)), steps[1][1])
    for (low, high), (lower, upper) in zip(steps[1:], steps[2:], strict=False):
        assert (lower, upper) in ((low, pytest.approx((low + high) / 2)), (pytest.approx((low + high) / 2), high))
    low, high = steps[-1]
    assert 0.5 * 2e-4 < high - low <= 0.5 * 5e-4
    assert low <= 0.4 * (1 + 1e-6)
    assert high >= 0.4 * (1 - 1e-3)
    told = []
    found, stopped = multiplier_brackets(problem.program, load, 0.5, progress=lambda *step: told.append(step))
    assert not stopped
    assert len(found) == 3
    assert found[0] == steps[-1]
    assert [step for step in told if step[0] == 0] == [(0, 0.0, 0.5)] * 3


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e9])
def test_a_loaded_point_closes_or_does_not_whatever_the_scale_of_the_displacements(scale):
    """A cube that sinks presses on all four corners; one that leans lifts two of them, and one that rises all."""
    problem = posed(stack(1))
    program = problem.program
    forces = np.zeros((4, 3))
    forces[:, 0] = 0.25

    def unclosed(*twist):
        return _unclosed(program, Iterate(forces, scale * np.array(twist), np.zeros(4), 0.0, None)).tolist()

    assert unclosed(0, 0, -1, 0, 0, 0) == [False] * 4
    assert unclosed(0, 0, 1, 0, 0, 0) == [True] * 4
    tilts = unclosed(0, 0, 0, 0, problem.program.length_unit, 0)  # about y: the corners at large x go down
    right = problem.interfaces.point[:, 0] > problem.assembly.centroid[1][0]
    assert tilts == (~right).tolist()
    assert unclosed(0, 0, -1e-3, 1e3, 0, 0) != [False] * 4
    assert unclosed(1, 0, 0, 0, 0, 0) == [True] * 4  # it slides, and closes nothing
    for sinks, open_ in ((0.5 * RATE_ACCURACY, True), (2 * RATE_ACCURACY, False)):
        assert unclosed(1, 0, -sinks, 0, 0, 0) == [open_] * 4
    forces[:2] = 0.0
    assert unclosed(0, 0, 1, 0, 0, 0) == [False, False, True, True]  # what carries nothing need not close


def test_a_cube_closes_its_joint_by_the_opening_and_by_what_gives_under_its_weight():
    """Each of four points carries a quarter of the weight, of both cubes in the lower joint."""
    one, two = (posed(stack(n)).program for n in (1, 2))
    for opening, compliance in ((1.0, 1e-3), (0.1, 1.0), (1.0, 1.0)):
        assert (opening, compliance) in FAMILY
    for kind in FAMILY:
        opening, compliance = kind
        found = coulomb_state(one, kinds=[kind])
        assert found.force[:, 0] == pytest.approx([0.25] * 4)
        sinks = -found.displacement.reshape(-1, 6)[:, 2]
        assert sinks == pytest.approx([opening + compliance / 4], rel=1e-6)
        sinks = -coulomb_state(two, kinds=[kind]).displacement.reshape(-1, 6)[:, 2]
        low = opening + compliance * 2 / 4
        assert sinks == pytest.approx([low, low + opening + compliance / 4], rel=1e-6)


@pytest.mark.parametrize("push", [0.2, 0.22, 0.24])
@pytest.mark.parametrize("seed", range(4))
def test_a_state_does_not_hang_on_the_last_digits_of_its_displacements(push, seed, monkeypatch):
    """A brick pushed aside of its middle slips at some corners first, by the little that stiff joints give before.

    A solver's displacements are good to 1e-8 of the largest; the slips are 1e-4 of it.
    """
    asm = assembly([box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 0.5))], friction=0.3)
    loads = point_load(asm, 1, (0, 0.9, 0.25), (push * asm.free_weight, 0, 0))
    program = pose(asm, friction=None, gravity=None, loads=loads, gap=0.01, interfaces=None).program
    noise, plain = np.random.default_rng(seed).uniform(-1, 1, len(program.load)), coulomb.solve

    def rough(*given, **options):
        found = plain(*given, **options)
        return replace(found, twist=found.twist + 3e-8 * np.abs(found.twist).max() * noise)

    monkeypatch.setattr(coulomb, "solve", rough)
    m = len(program.friction)
    found = coulomb.solve_state(program, np.zeros(m), opening=np.ones(m), compliance=FAMILY[0][1])
    assert found.certificate.proves_settled


def test_a_stiff_table_stands_on_the_diagonal_whose_legs_are_open_by_less():
    """It leans by .5, and friction is 1 on one diagonal and .1 on the other, so it stands on the first alone."""
    table = assembly([box((-9, -9, -1), (9, 9, 0)), box((0, 0, 0), (1, 1, 0.01))], friction=1.0, gravity=(0.5, 0, -1))
    problem = posed(table)
    corners = problem.interfaces.point[:, :2]
    first = np.abs(corners[:, 0] - corners[:, 1]) < 0.5
    program = replace(problem.program, friction=np.where(first, 1.0, 0.1))
    openings = 10.0 ** np.random.default_rng(49).uniform(-1.0, 1.0, (12, 4))
    share = settling_share(program, seed=49)  # of twelve tries
    assert 12 * share == pytest.approx(round(12 * share))
    assert np.mean(openings @ np.where(first, 1.0, -1.0) < 0) <= share < 1.0


def test_openings_are_assumed_unless_they_are_stated():
    member = _Member(np.ones(2), 1e-3, np.zeros(2))
    assert (member.known, bool(member.ends), bool(member.grows)) == (False, False, False)
