"""No wrong verdict, no silent NaN on scenes that break solvers; the truth of each is in `evidence.hard.cases`."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import Assembly, Block, assess
from blockstat.certificate.check import FORCE_TOLERANCE
from evidence.hard.cases import CASES, STABLE, TOLERANCE, UNDECIDED
from evidence.hard.outcome import outcome
from evidence.hard.piles import pile


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.family}: {case.name}")
def test_hard_case(case):
    row = outcome(case)
    assert row.right, f"{row.word} where {case.right} is right ({case.why}): {row.told}"
    assert row.finite
    if row.word == STABLE:
        assert row.imbalance <= TOLERANCE


def test_the_tolerance_of_the_cases_is_that_of_the_certificate():
    assert TOLERANCE == FORCE_TOLERANCE


def again(seed):
    """The word for the same pile with its blocks in another order, by the other solver."""
    asm = pile(seed)
    random = np.random.default_rng(seed)
    order = random.permutation(asm.n_blocks)
    blocks = [Block(asm.block_vertices(i), asm.faces_of(i), asm.names[i], density=float(asm.density[i])) for i in order]
    supports = [int(np.flatnonzero(order == i)[0]) for i in np.flatnonzero(asm.support)]
    other = Assembly.from_blocks(blocks, supports=supports, friction=asm.friction, gravity=asm.gravity)
    return assess(other, solver="interior-point").outcome.word


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_random_piles(seed):
    # The independent check behind `assess` rejects a wrong proof; a right one does not depend on the order.
    # One order in a few hundred is left undecided; `test_ten_thousand_piles` counts them.
    words = {assess(pile(seed)).outcome.word, again(seed)} - {UNDECIDED}
    assert len(words) <= 1


@pytest.mark.slow
def test_ten_thousand_piles():
    undecided = [seed for seed in range(10_000) if assess(pile(seed)).outcome.word == UNDECIDED]
    assert len(undecided) <= 20, undecided
