"""Random scenes that stand or fall by their glue, shared by tests and benchmarks."""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, LoadOutcome, glued, limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP
from blockstat.program.penalty import PenaltyProgram
from evidence.scenes.small import arch, assembly, box, running_bond


def cluster(rng: np.random.Generator) -> Assembly:
    """Boxes of a grid with uneven spacing, grown one by one on a fixed one, under gravity from anywhere."""
    edges = [np.concatenate([[0.0], np.cumsum(rng.uniform(0.6, 1.6, 7))]) for _ in range(3)]
    cells = [(3, 3, 3)]
    for _ in range(int(rng.integers(1, 7))):
        while True:
            cell = np.array(cells[rng.integers(len(cells))])
            cell[rng.integers(3)] += rng.choice([-1, 1])
            if tuple(cell) not in cells and cell.min() >= 0 and cell.max() <= 6:
                cells.append(tuple(cell))
                break
    axes = np.arange(3)
    corners = [(np.array(edges)[axes, cell], np.array(edges)[axes, np.add(cell, 1)]) for cell in cells]
    gravity = rng.normal(size=3)
    return assembly(
        [box(*pair, group="cell") for pair in corners],
        gravity=gravity / np.linalg.norm(gravity), friction=rng.uniform(0.4, 1.0),
    )  # fmt: skip


def beam(rng: np.random.Generator) -> Assembly:
    """A row of boxes out of a wall."""
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(0.4, 1.2, rng.integers(1, 5)))])
    depth, height = rng.uniform(0.4, 1.2, 2)
    blocks = [box((-1, -1, -2), (0, 3, 2), name="wall")]
    blocks += [box((a, 0, 0), (b, depth, height)) for a, b in zip(x[:-1], x[1:], strict=True)]
    return assembly(blocks, friction=rng.uniform(0.5, 1.0))


def thin_arch(rng: np.random.Generator) -> Assembly:
    """An arch too thin to stand dry."""
    n = int(rng.integers(7, 16))
    return arch(n, rng.uniform(0.05, 0.08))


def leaning_wall(rng: np.random.Generator) -> Assembly:
    """A wall in running bond under an acceleration out of its plane that tips it when dry."""
    courses = int(rng.integers(3, 7))
    wall = running_bond(courses, 3)
    return wall.with_(gravity=(0.0, rng.uniform(1.3, 2.0) * 0.2 / (courses * 0.175), -1.0))


FAMILIES = {"cluster": cluster, "beam": beam, "arch": thin_arch, "wall": leaning_wall}


def bonded_scene(seed: int) -> tuple[str, Assembly, float]:
    """A family, a glued scene, and its strength over the least that holds: .5 to .9, or 1.1 to 2.

    The least strength is that of statics. Weight and glue scale together, so with the limit of a multiple of the weight
    one program gives it.
    """
    rng = np.random.default_rng(seed)
    name = list(FAMILIES)[seed % len(FAMILIES)]
    ratio = rng.uniform(0.5, 0.9) if rng.random() < 0.5 else rng.uniform(1.1, 2.0)
    arm = rng.uniform(0.1, 0.6) if rng.random() < 0.5 else None  # of the moment capacity over the force, in block sizes
    while True:
        dry = FAMILIES[name](rng)
        free = ~dry.support
        strength = 20.0 * float(dry.mass.sum() if free.all() else dry.mass[free].sum()) * np.linalg.norm(dry.gravity)
        size = float(np.median(dry.size[free]))
        moment = None if arm is None else arm * strength * size
        limit = limit_load(glued(dry, strength, moment=moment), dry.gravity / np.linalg.norm(dry.gravity))
        if limit.outcome is LoadOutcome.LIMIT and limit.lower > 0 and limit.gap < 1e-3:
            share = ratio / (1.0 + limit.lower)
            return name, glued(dry, share * strength, moment=moment and share * moment), ratio


def program_of(asm: Assembly) -> PenaltyProgram:
    """Its equilibrium as `blockstat.analysis.coulomb` takes it."""
    program = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None).program
    assert program is not None
    return program
