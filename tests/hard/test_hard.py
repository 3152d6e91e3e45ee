"""No wrong verdict, no silent NaN on scenes that break solvers; the truth of each is in `evidence.hard`."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import Assembly, Block, assess
from blockstat.certificate.check import FORCE_TOLERANCE
from evidence.fuzz.compare import Category, compare
from evidence.fuzz.judge import judge
from evidence.fuzz.scene import Scene
from evidence.fuzz.solids import Solid
from evidence.hard import edges, rubble
from evidence.hard.cases import CASES, STABLE, TOLERANCE, UNDECIDED
from evidence.hard.figures import figure_row, stages_row
from evidence.hard.outcome import outcome
from evidence.hard.piles import pile
from evidence.pages.hard import SECTIONS

VERDICTS = [*CASES, *(case for section in SECTIONS for case in section.cases)]
FIGURES = [figure for section in SECTIONS for figure in section.figures]
STAGES = [stages for section in SECTIONS for stages in section.stages]


@pytest.mark.parametrize("case", VERDICTS, ids=lambda case: f"{case.family}: {case.name}")
def test_hard_case(case):
    row = outcome(case)
    assert row.right, f"{row.word} where {case.right} is right ({case.why}): {row.told}"
    assert row.finite
    if row.word == STABLE:
        assert row.imbalance <= TOLERANCE


def marks(figure):
    """A figure that is known to fall short is expected to; where rounding decides it may do well."""
    found = [pytest.mark.slow] if figure.slow else []
    return [*found, pytest.mark.xfail(reason=figure.flaw, strict=False)] if figure.flaw else found


@pytest.mark.parametrize(
    "figure", [pytest.param(figure, marks=marks(figure)) for figure in FIGURES], ids=lambda figure: figure.name
)
def test_hard_figure(figure):
    row = figure_row(figure)
    assert row.judged == "right", f"{row.found} where {figure.value} is right ({figure.why}): off by {row.off:.1e}"


@pytest.mark.parametrize("stages", STAGES, ids=lambda stages: stages.name)
def test_hard_plan(stages):
    row = stages_row(stages)
    assert row.judged == "right", f"{row.words} where {stages.right} is right ({stages.why})"


def test_names_are_unique():
    for kind in (VERDICTS, FIGURES, STAGES):
        names = [getattr(one, "family", "") + one.name for one in kind]
        assert len(set(names)) == len(names)


def test_the_tolerance_of_the_cases_is_that_of_the_certificate():
    assert TOLERANCE == FORCE_TOLERANCE


def as_seen_by_the_judge(asm):
    """A scene of convex blocks, in the judge's terms."""
    blocks = [(asm.block_vertices(i), tuple(map(tuple, asm.faces_of(i)))) for i in range(asm.n_blocks)]
    solids = tuple(Solid(vertices, faces, (vertices,)) for vertices, faces in blocks)
    return Scene(
        "hard", solids, tuple(asm.support.tolist()), tuple(asm.density.tolist()), asm.friction, np.array(asm.gravity)
    )


@pytest.mark.parametrize(
    "case",
    [
        case
        for case in edges.CASES
        if case.family != "on edges" and "keel" not in case.name and "ridge" not in case.name
    ],
    ids=lambda case: case.name,
)
def test_the_judge_says_the_same_of_scenes_on_edges(case):
    scene = as_seen_by_the_judge(case.make())
    assert compare(scene, judge(scene), case.right) in (Category.RIGHT, Category.NO_NORMAL)


@pytest.mark.parametrize("heap", [*rubble.STANDS, *rubble.FALLS], ids=rubble.named)
def test_the_judge_says_the_same_of_rubble(heap):
    right = {case.name: case.right for case in rubble.CASES}[rubble.named(heap)]
    assert heap.judgement().truth.name.lower() == right


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
