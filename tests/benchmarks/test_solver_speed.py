"""Speed of the solve alone under pytest-benchmark; nothing is asserted about time."""

from time import process_time

import pytest

from evidence.benchmarks.cell import SOLVERS, posed


@pytest.mark.benchmark(timer=process_time, min_rounds=1, max_time=2.0, warmup=False)
@pytest.mark.parametrize("scene", ["wall", "vault"])
def test_solve_of_a_thousand_blocks(benchmark, scene):
    problem = posed(scene, 1000)
    raw = benchmark(SOLVERS["structured"], problem)
    assert raw.solver == "interior-point"
    assert raw.status.word == "accepted"
