"""The bracket of a limit load that is proven while the solve runs.

Exact values: a stack of width b and height h tips at b / h, and slides at mu; a wall out of its plane tips at its depth
over its height, since no course can hold another back (Ferris & Tin-Loi 2001 use both as checks).
"""

import numpy as np
import pytest

from blockstat import Assembly, LoadOutcome, limit_load
from blockstat.analysis.problem import pose
from blockstat.certificate.bracket import Bracket
from blockstat.certificate.check import check, power
from blockstat.loads import as_load
from blockstat.program.conic import conic_program
from blockstat.solve import interior_point
from blockstat.solve.answer import EarlyEnd, Status
from evidence.scenes.sized import BRICK, wall
from evidence.scenes.small import arch, box, stack

#: Scene, load and exact multiplier.
WALL = wall(100)
SCENES = {
    "stack that tips": (stack(8, width=2.0, friction=2.0), (1, 0, 0), 0.25),
    "stack that slides": (stack(5, width=4.0, friction=0.4), (1, 0, 0), 0.4),
    "wall out of its plane": (WALL, (0, 1, 0), BRICK[1] / float(WALL.vertices[:, 2].max())),
}
#: Proofs hold to a tolerance of their own (`FORCE_TOLERANCE`), relative to the load of a block.
PROOF = 1e-8


@pytest.mark.parametrize("tolerance", [10.0**-k for k in range(1, 11)])
@pytest.mark.parametrize("name", SCENES)
def test_the_bracket_holds_the_exact_value_and_is_as_narrow_as_asked_for(name, tolerance):
    asm, load, exact = SCENES[name]
    found = limit_load(asm, load, tolerance=tolerance, solver="interior-point")
    assert found.outcome is LoadOutcome.LIMIT
    assert found.lower - PROOF <= exact <= found.upper + PROOF
    assert found.upper - found.lower <= max(tolerance * found.upper, 2e-9)


def iterates(asm, load):
    """The proven brackets after every iterate, as (lower, upper, field, mechanism), with the program and the load."""
    problem = pose(asm, friction=None, gravity=None, loads=None, gap=1e-2, interfaces=None)
    program = problem.program
    live = problem.scaled(as_load(problem.assembly, load))
    dead = limit_load(asm, load)  # stands
    assert dead.lower > 0
    inside = interior_point.solve(
        conic_program(program, -program.load), EarlyEnd(guess=np.tile([1.0, 0, 0], (len(program.friction), 1)),
                                                        forces=lambda force: True)
    ).force  # fmt: skip
    bracket, seen = Bracket(program, live, inside, 1e-6, problem.motions), []

    def noted(twist, force, multiplier):
        closed = bracket.narrow(twist, force, multiplier)
        bracket.close()
        seen.append((bracket.lower, bracket.upper, bracket.force, bracket.twist))
        return closed

    conic = conic_program(program, -program.load, pinned=live)
    assert interior_point.solve(conic, EarlyEnd(pair=noted, inside=inside)).status is Status.ACCEPTED
    return program, live, seen


@pytest.mark.parametrize("name", SCENES)
def test_every_bracket_on_the_way_is_proven_and_lies_within_the_one_before(name):
    asm, load, exact = SCENES[name]
    program, live, seen = iterates(asm, load)
    assert len(seen) > 3
    for before, after in zip(seen, seen[1:], strict=False):
        assert before[0] <= after[0] <= after[1] + PROOF
        assert after[1] <= before[1]
    for lower, upper, force, twist in seen:
        assert lower - PROOF <= exact <= upper + PROOF
        loaded = program.__class__(**{**_fields(program), "load": program.load + lower * live})
        assert check(loaded, force, np.zeros_like(live)).proves_stable
        if np.isfinite(upper):
            work, closing = power(program, twist)
            assert closing == 0.0
            assert -work / float(live @ twist) == pytest.approx(upper, rel=1e-12)
    # Bounds come long before the end.
    assert sum(np.isfinite(upper) and lower > 0 for lower, upper, *_ in seen) >= len(seen) - 2


def _fields(program):
    return {name: getattr(program, name) for name in program.__dataclass_fields__}


def test_a_stop_keeps_the_bracket_that_was_reached():
    asm, load, exact = SCENES["wall out of its plane"]

    def stop(iteration, reached, upper):
        if iteration == 5:
            raise KeyboardInterrupt

    found = limit_load(asm, load, solver="interior-point", progress=stop)
    assert found.outcome is LoadOutcome.STOPPED
    assert 0 < found.lower < exact < found.upper < np.inf
    assert found.upper - found.lower > 1e-4 * exact
    assert found.summary()["outcome"] == "stopped"
    assert "<= multiplier <=" in found.explain()


def test_progress_tells_of_every_iteration():
    told = []
    asm, load, exact = SCENES["stack that tips"]
    limit_load(asm, load, solver="interior-point", progress=lambda *what: told.append(what))
    assert [k for k, *_ in told] == list(range(1, len(told) + 1))
    uppers = [upper for *_, upper in told]
    assert uppers == sorted(uppers, reverse=True)
    assert uppers[-1] == pytest.approx(exact, rel=1e-4)


def test_a_looser_bracket_takes_fewer_iterations():
    asm, load, _ = SCENES["wall out of its plane"]
    count = [limit_load(asm, load, tolerance=t, solver="interior-point").iterations for t in (1e-1, 1e-3, 1e-5)]
    assert count == sorted(count)
    assert count[0] < count[-1]


def corners(asm):
    return [asm.vertices[a:b] for a, b in zip(asm.vertex_start, asm.vertex_start[1:], strict=False)]


@pytest.mark.parametrize("change", ["order", "millimetres", "UTM", "turned"])
def test_the_bracket_does_not_hang_on_how_the_scene_is_written(change):
    asm, load, exact = SCENES["wall out of its plane"]
    load = np.array(load, dtype=float)
    if change == "order":
        order = np.random.default_rng(1).permutation(asm.n_blocks)
        blocks = [box(*np.array([v.min(axis=0), v.max(axis=0)]), name=str(k)) for k, v in enumerate(corners(asm))]
        asm = Assembly.from_blocks([blocks[k] for k in order], supports=[int(np.flatnonzero(order == 0)[0])])
    elif change == "millimetres":
        asm = asm.with_(vertices=1e3 * asm.vertices)
    elif change == "UTM":
        asm = asm.with_(vertices=asm.vertices + np.array([431_000.0, 4_582_000.0, 312.0]))
    else:
        c, s = np.cos(0.4), np.sin(0.4)
        turn = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
        asm, load = asm.with_(vertices=asm.vertices @ turn.T), turn @ load
    found = limit_load(asm, load, tolerance=1e-4)
    assert found.outcome is LoadOutcome.LIMIT
    assert found.lower - PROOF <= exact <= found.upper + 1e-6


def test_no_bracket_is_closed_where_any_multiple_is_carried():
    # The load presses the wall down: it grows with the friction that holds it.
    found = limit_load(WALL, (0, 0, -1), solver="interior-point")
    assert found.outcome is LoadOutcome.UNBOUNDED


def test_the_optimum_stays_available():
    wide = limit_load(arch(100, 0.15), (1, 0, 0), solver="interior-point")
    sharp = limit_load(arch(100, 0.15), (1, 0, 0), solver="interior-point", optimum=True)
    assert sharp.gap < 1e-7
    assert wide.lower - PROOF <= sharp.lower
    assert sharp.upper <= wide.upper + PROOF
