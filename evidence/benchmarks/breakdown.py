"""Where the time of the structured solver goes: process seconds by part, each without what it calls of the others.

python -m evidence.benchmarks.breakdown SCENE SIZE     (prints JSON)
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import process_time
from typing import Any

from blockstat.analysis.decision import decide
from blockstat.linear_algebra import factor
from blockstat.linear_algebra import normal_equations as normal
from blockstat.solve import cones, interior_point, kkt, penalty
from evidence.benchmarks.cell import posed, solvable

#: Assessments of which the shortest counts, as in the table of solvers.
REPEATS = 3

BACKEND = factor.Pardiso if factor.backend() == "pardiso" else factor.SuperLU

#: Owner, method, part of the solve it counts for.
PARTS: tuple[tuple[Any, str, str], ...] = (
    (penalty, "conic_program", "set-up of the program"),
    (normal.BlockNormal, "__init__", "pattern"),
    (normal.BlockNormal, "update", "assembly"),
    (kkt.KktSolver, "update", "scaled rows"),
    (BACKEND, "update", "factorisation"),
    (BACKEND, "solve", "triangular solves"),
    (kkt.KktSolver, "solve", "products and refinement"),
    (kkt.KktSolver, "__init__", "set-up of the program"),
    (interior_point, "_residuals", "residuals"),
    (interior_point, "_convergence", "residuals"),
    (interior_point, "_step", "steps"),
    (interior_point, "_start", "steps"),
    (interior_point, "find_forces", "steps"),
    (penalty, "load_path_guess", "first forces"),
    (cones.Cones, "scaling", "cones"),
    (cones.Cones, "longest_step", "cones"),
    (cones.Cones, "product", "cones"),
    (cones.Cones, "quotient", "cones"),
    *((cones.Scaling, name, "cones") for name in ("apply", "inverse", "squared", "inverse_squared")),
)


class Clock:
    """Seconds and calls of nested parts, each part without those inside it."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.calls: defaultdict[str, list[float]] = defaultdict(list)
        self._inside = [0.0]

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        begin = process_time()
        self._inside.append(0.0)
        try:
            yield
        finally:
            whole = process_time() - begin
            self.seconds[name] += whole - self._inside.pop()
            self.calls[name].append(whole)
            self._inside[-1] += whole

    def watch(self, owner: Any, method: str, name: str) -> None:
        """Count the calls of a method as a part."""
        plain: Callable = getattr(owner, method)

        def counted(*args: Any, **options: Any) -> Any:
            with self.part(name):
                return plain(*args, **options)

        setattr(owner, method, counted)


def breakdown(scene: str, size: int) -> dict:
    """Seconds of each part of one assessment, the shortest of some that know nothing of each other."""
    clock = Clock()
    for owner, method, name in PARTS:
        clock.watch(owner, method, name)
    return min((once(clock, scene, size) for _ in range(REPEATS)), key=lambda found: found["total"])


def once(clock: Clock, scene: str, size: int) -> dict:
    """Seconds of each part of one assessment, from the assembly on."""
    clock.reset()
    normal.known.normals.clear()
    normal.known.graphs.clear()
    problem = posed(scene, size)
    program, options = solvable(problem), {"solver": "interior-point", "motions": problem.motions}
    begin = process_time()
    with clock.part("rest"):
        raw = penalty.solve_penalty(program, **options)
    solve = process_time() - begin
    parts = dict(clock.seconds)
    first, *others = clock.calls["factorisation"]
    # Once more, with the ordering of the first: a wall may have needed a single factorisation.
    penalty.solve_penalty(program, **options)
    again = clock.calls["factorisation"][1 + len(others) :]
    numeric = sorted(others + again)[(len(others) + len(again)) // 2]
    parts["factorisation"] -= first - numeric
    parts["ordering and symbolic factorisation"] = first - numeric
    begin = process_time()
    decide(program, raw, **options)
    steps = {**problem.timings, "solve": solve, "certificate": process_time() - begin}
    return {
        "scene": scene, "size": size, "blocks": problem.eq.n_blocks, "backend": factor.backend(),
        "iterations": raw.iterations, "numeric": numeric, "steps": steps, "parts": parts,
        "total": sum(steps.values()), "factorisations": len(others) + 1,
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(breakdown(sys.argv[1], int(sys.argv[2]))))
