"""Groups that do not touch: solved together or apart, the same."""

import numpy as np
import pytest

from blockstat import Block, assess
from blockstat.analysis.problem import pose
from blockstat.solve.components import parts, solve_by_components
from blockstat.solve.penalty import solve_whole
from evidence.scenes.small import arch, assembly, box, running_bond


def village(lean):
    """A wall, an arch and three stacks on one ground, pushed out of their planes."""
    found = [box((-50, -50, -1), (50, 50, 0), name="ground")]
    for k, (asm, place) in enumerate(((running_bond(6, 5), (5, 0, 0)), (arch(12, 0.3), (-5, 3, 0)))):
        for i in range(asm.n_blocks):
            if asm.names[i] != "ground":
                name = f"{k}.{asm.names[i]}"
                found.append(Block(asm.block_vertices(i) + place, asm.faces_of(i), name=name))
    for s in range(3):
        found += [box((s, 9, z), (s + 0.4, 9.4 + 0.1 * s, z + 0.5), name=f"stack{s}.{z}") for z in (0.0, 0.5, 1.0)]
    springers = [i for i, block in enumerate(found) if block.name in ("1.left", "1.right")]
    return assembly(found, supports=[0, *springers], gravity=(0.01, lean, -1))


@pytest.mark.parametrize("lean", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("most", [2, 3, 100])
def test_together_or_apart(lean, most):
    asm = village(lean)
    program = pose(asm, friction=None, gravity=None, loads=None, gap=0.01, interfaces=None).program
    assert program is not None
    found = parts(program, most)
    assert len(found) == min(most, 5)
    assert sorted(np.concatenate(found)) == list(range(len(program.load) // 6))
    whole, split = solve_whole(program), solve_by_components(program, solve_whole, most=most)
    assert whole.bounded == split.bounded
    assert np.linalg.norm(split.adhesion) == pytest.approx(np.linalg.norm(whole.adhesion), rel=1e-6, abs=1e-9)
    # And the verdict of the parts is that of the whole.
    assert assess(asm).outcome.word == ("stable" if lean < 0.1 else "unstable")


def test_one_piece_stays_one():
    program = pose(running_bond(4, 3), friction=None, gravity=None, loads=None, gap=0.01, interfaces=None).program
    assert program is not None
    assert len(parts(program, 8)) == 1
