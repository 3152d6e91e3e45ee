"""Speed under pytest-benchmark (`pytest tests/benchmarks --benchmark-only`); nothing is asserted about time."""

from time import process_time

import pytest

from blockstat import assess, find_interfaces
from evidence.scenes.sized import wall


@pytest.mark.benchmark(timer=process_time, min_rounds=1, max_time=2.0, warmup=False)
@pytest.mark.parametrize("blocks", [100, 1000])
def test_assess_wall(benchmark, blocks):
    verdict = benchmark(assess, wall(blocks))
    assert verdict.outcome.word == "stable"


@pytest.mark.benchmark(timer=process_time, min_rounds=1, max_time=2.0, warmup=False)
def test_interfaces_of_a_wall(benchmark):
    asm = wall(1000)
    faces = benchmark(find_interfaces, asm)
    # Of each course: every brick but the half ones lies on two; heads one fewer than bricks.
    assert faces.n_interfaces == sum(2 * 32 - 1 for _ in range(31)) + 32 + 32 * 31
