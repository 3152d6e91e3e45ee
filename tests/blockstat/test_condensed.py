"""Blocks that move as one: the condensed program against the whole one."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP
from blockstat.large_displacement.statics.macro_blocks import common_refinement
from blockstat.program.condensed import Bodies, moving_as_one
from evidence.scenes.small import u_wall


@pytest.fixture
def problem():
    return pose(u_wall(4), friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)


def bodies(problem, body):
    return Bodies(
        problem.program, np.array(body), problem.assembly.centroid[problem.eq.blocks] / problem.program.length_unit
    )


def test_a_motion_of_bodies_does_the_work_and_opens_the_joints_that_it_does_as_one_of_the_blocks(problem):
    n = len(problem.eq.blocks)
    some = bodies(problem, np.arange(n) % 5 - 1)
    random = np.random.default_rng(4)
    twist, load = random.normal(size=6 * some.number), random.normal(size=6 * n)
    whole = some.twists(twist)
    assert some.loads(load) @ twist == pytest.approx(load @ whole, rel=1e-12)
    columns = (3 * some.columns[:, None] + np.arange(3)).reshape(-1)
    rates = problem.program.matrix.T @ whole
    assert some.program.matrix.T @ twist == pytest.approx(rates[columns], abs=1e-12)
    assert np.delete(rates, columns) == pytest.approx(0.0, abs=1e-12)
    assert not whole.reshape(-1, 6)[some.body < 0].any()


def test_each_block_a_body_is_the_program_itself(problem):
    own = bodies(problem, np.arange(len(problem.eq.blocks)))
    assert abs(own.program.matrix - replace(problem.program, plane=None).matrix).max() < 1e-15
    assert own.program.load == pytest.approx(problem.program.load, abs=1e-15)


def test_bodies_are_compared_by_identity_and_do_not_change(problem):
    own = bodies(problem, np.zeros(len(problem.eq.blocks), dtype=int))
    assert own.number == 1
    assert replace(own) != own
    assert len({own, replace(own)}) == 2
    with pytest.raises(FrozenInstanceError):
        own.body = own.body + 1


def test_blocks_move_as_one_where_no_point_of_their_joint_moves():
    support, pair = np.array([False, True, False, False, False]), np.array([[0, 1], [0, 1], [0, 2], [2, 3], [3, 4]])
    rate = np.array([[0, 0, 0], [0, 0, 2e-4], [0, 0, -1.0], [0, 1e-4, 0], [-0.5, 0, 0]])
    assert moving_as_one(support, pair, rate, 3e-4).tolist() == [-1, -1, 0, 0, 1]
    assert moving_as_one(support, pair, rate, 1.5e-4).tolist() == [0, -1, 1, 1, 2]


def test_macro_blocks_of_a_common_refinement_are_of_blocks_that_are_one_in_both_and_rest_where_both_rest():
    assert common_refinement(np.array([-1, -1, 0, 0, 1]), np.array([-1, 0, 0, 1, 1])).tolist() == [-1, 0, 1, 2, 3]
    assert common_refinement(np.array([0, 0, 1]), np.array([1, 1, 0])).tolist() == [0, 0, 1]
