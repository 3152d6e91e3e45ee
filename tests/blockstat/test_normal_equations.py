"""Normal equations of pairs of blocks: whose factor it is, and which are kept for the next program."""

import numpy as np
import pytest

from blockstat.linear_algebra import normal_equations as normal

ONE_ROW = np.array([(0, -1), (0, 1)])
TWO_ROWS = ONE_ROW.repeat(2, axis=0)


def rows_of(pair, seed):
    return np.random.default_rng(seed).normal(size=(len(pair), 2)) * (pair >= 0)


def dense(pair, rows):
    full = np.zeros((len(pair), 2))
    for row, blocks, values in zip(full, pair, rows, strict=True):
        for block, value in zip(blocks, values, strict=True):
            if block >= 0:
                row[block] += value
    return full.T @ full


def test_a_factor_that_another_program_has_updated_is_refused_until_it_is_updated_again():
    right = np.array([1.0, -2.0])
    one, two = (normal.normal_equations(pair, 2, 1) for pair in (ONE_ROW, TWO_ROWS))
    for equations, pair, other in ((one, ONE_ROW, two), (two, TWO_ROWS, one)):
        rows = rows_of(pair, seed=len(pair))
        equations.update(rows)
        assert equations.solve(right) == pytest.approx(np.linalg.solve(dense(pair, rows), right), rel=1e-9)
        with pytest.raises(RuntimeError, match="these normal equations were updated by another program"):
            other.solve(right)


def test_equations_of_many_blocks_are_not_kept():
    few, many = normal.KEPT_BLOCKS, normal.KEPT_BLOCKS + 1
    assert normal.normal_equations(ONE_ROW, few, 1) is normal.normal_equations(ONE_ROW, few, 1)
    assert normal.normal_equations(ONE_ROW, many, 1) is not normal.normal_equations(ONE_ROW, many, 1)
    assert all(key[0] != many for key in normal.known.normals)
