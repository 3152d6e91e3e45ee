"""Every way to a limit load, by its error and its seconds: one table and one picture, in one run.

    python -m evidence.benchmarks.speed_error [--json] [--write] [--no-bullet]

The error is against reference values (`evidence.references`) and, for the chapels, against the proven bracket, which is
narrower than what it judges. Seconds are process time of everything from the assembly in memory to the multiplier.
Bullet's figure is the middle of its own bracket; it is another model and not associated, so part of its distance is
physics. `--write` writes docs/speed_error.md and docs/speed-error.png.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy import sparse

from blockstat import Assembly, limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP
from blockstat.loads import as_load
from evidence.paths import DOCS
from evidence.plotting import panels, save, shades
from evidence.scenes.sized import chapel
from evidence.scenes.small import FERRIS, arch, ferris_wall, u_wall
from evidence.tables import table

LEAST = 1e-10  #: errors below this are drawn here
DIGITS = 5e-6  #: errors below this are those of the references
BULLET_MOST = 150  #: blocks of a scene that Bullet is asked for


@dataclass(frozen=True)
class Scene:
    """One limit load with its reference; None: the proven bracket is the reference."""

    family: str
    name: str
    assembly: Assembly
    load: tuple[float, float, float]
    reference: float | None


@dataclass(frozen=True)
class Point:
    """One way to one scene."""

    family: str
    scene: str
    blocks: int
    way: str
    value: float
    error: float
    seconds: float


def turned(asm: Assembly, degrees: float) -> Assembly:
    """The assembly about the vertical; nothing of it stands along an axis any more."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return asm.with_(vertices=asm.vertices @ np.array([(c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)]))


def scenes() -> Iterator[Scene]:
    for ratio, value in ((0.15, 0.149350), (0.20, 0.285646), (0.30, 0.456126)):
        yield Scene("arches in their plane", f"t/R {ratio}", arch(20, ratio, friction=0.7), (1, 0, 0), value)
    for name, data in FERRIS.items():
        yield Scene("walls in their plane", name, ferris_wall(data[0]), (1, 0, 0), data[4])
    c, s = np.cos(np.deg2rad(25.0)), np.sin(np.deg2rad(25.0))
    for courses, value in ((4, 0.552372), (8, 0.389499), (12, 0.277391)):
        asm = turned(u_wall(courses), 25.0)
        yield Scene("bonded corners out of plane", f"{courses} courses", asm, (s, -c, 0), value)
    for blocks in (100, 300, 1000):
        yield Scene("chapels across the nave", f"{blocks} blocks", chapel(blocks), (0, 1, 0), None)


def middle(scene: Scene, **options: Any) -> float:
    found = limit_load(scene.assembly, scene.load, **options)
    return (found.lower + found.upper) / 2


def in_space(scene: Scene) -> float:
    """Without the planar reduction: the same scene, turned so that no axis is its own."""
    c, s = np.cos(np.deg2rad(25.0)), np.sin(np.deg2rad(25.0))
    x, y, z = scene.load
    moved = replace(scene, assembly=turned(scene.assembly, 25.0), load=(c * x - s * y, s * x + c * y, z))
    return middle(moved)


def primal(scene: Scene) -> tuple[sparse.csr_array, np.ndarray, np.ndarray, np.ndarray]:
    """A, w, l and mu of max lambda with A f + w + lambda l = 0, f in the cones."""
    problem = pose(scene.assembly, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)
    program = problem.program
    assert program is not None
    return program.matrix, program.load, problem.scaled(as_load(problem.assembly, scene.load)), program.friction


def clarabel(scene: Scene, tolerance: float, sides: int = 0) -> float:
    """The primal program through Clarabel, with the exact cone or a polygon about it."""
    import clarabel as solver

    matrix, load, push, mu = primal(scene)
    m = len(mu)
    if sides:
        angle = 2.0 * np.pi * np.arange(sides) / sides
        point, side = np.divmod(np.arange(m * sides), sides)
        entries = np.column_stack([-mu[point], np.cos(angle)[side], np.sin(angle)[side]]).reshape(-1)
        rows = np.repeat(np.arange(m * sides), 3)
        columns = (3 * point[:, None] + np.arange(3)).reshape(-1)
        into = sparse.csr_array((entries, (rows, columns)), shape=(m * sides, 3 * m))
        normal = sparse.csr_array((-np.ones(m), (np.arange(m), 3 * np.arange(m))), shape=(m, 3 * m))
        into = sparse.vstack([into, normal])
        cones = [solver.NonnegativeConeT(m * sides + m)]
    else:
        into = -sparse.diags_array(np.column_stack([mu, np.ones(m), np.ones(m)]).reshape(-1))
        cones = [solver.SecondOrderConeT(3)] * m
    settings = solver.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    rows = sparse.block_array([[matrix, push[:, None]], [into, None]]).tocsc()
    bound = np.concatenate([-load, np.zeros(into.shape[0])])
    nothing = sparse.csc_array((3 * m + 1, 3 * m + 1))
    cost = np.append(np.zeros(3 * m), -1.0)
    answer = solver.DefaultSolver(nothing, cost, rows, bound, [solver.ZeroConeT(len(load)), *cones], settings).solve()
    return float(answer.x[-1])


def literal(scene: Scene) -> float:
    """As one would write it in cvxpy, at its defaults."""
    import cvxpy as cp

    matrix, load, push, mu = primal(scene)
    force, multiplier = cp.Variable((len(mu), 3)), cp.Variable()
    balance = matrix @ cp.reshape(force, (3 * len(mu),), order="C") + load + multiplier * push == 0
    cone = cp.SOC(cp.multiply(mu, force[:, 0]), force[:, 1:].T, axis=0)
    cp.Problem(cp.Maximize(multiplier), [balance, cone]).solve(solver="CLARABEL")
    return float(multiplier.value)


def bullet(scene: Scene, step: float, iterations: int) -> float:
    from dynsim import Settings
    from dynsim.judge.limit import limit

    settings = Settings(time_step=step, quick_step=max(step, 2e-3), fine_step=step, iterations=iterations)
    found = limit(scene.assembly, scene.load, settings=settings, check=False)
    return (found.lower + found.upper) / 2


#: Name, its way, and the most blocks it is asked for.
WAYS: tuple[tuple[str, Callable[[Scene], float], int], ...] = (
    ("blockstat", middle, 10**6),
    ("blockstat in space", in_space, 10**6),
    ("blockstat by Clarabel's dual", lambda scene: middle(scene, solver="clarabel"), 10**6),
    *(
        (f"Clarabel primal, {tolerance:.0e}", lambda scene, t=tolerance: clarabel(scene, t), 10**6)
        for tolerance in (1e-3, 1e-5, 1e-8)
    ),
    ("cvxpy literal", literal, 10**6),
    *((f"{sides}-gon", lambda scene, k=sides: clarabel(scene, 1e-8, k), 10**6) for sides in (4, 8, 16, 32)),
)
#: Time steps [s] and iterations of the contact solver.
BULLET = tuple(
    (f"Bullet, {1e3 * step:g} ms x {number}", lambda scene, s=step, n=number: bullet(scene, s, n), BULLET_MOST)
    for step, number in ((2e-3, 30), (1e-3, 50), (1e-3, 200), (5e-4, 50))
)
MARKERS = "o*sPX<>^vDdph8H"


def measure(with_bullet: bool, largest: int) -> Iterator[Point]:
    for scene in scenes():
        if scene.assembly.n_blocks > largest:
            continue
        reference = scene.reference
        if reference is None:
            found = limit_load(scene.assembly, scene.load)
            reference = (found.lower + found.upper) / 2
        for way, compute, most in (*WAYS, *(BULLET if with_bullet else ())):
            if scene.assembly.n_blocks > most:
                continue
            if not way.startswith("Bullet"):
                compute(scene)  # imports and first calls are not part of any row
            begin = process_time()
            value = compute(scene)
            seconds = process_time() - begin
            error = abs(value / reference - 1)
            yield Point(scene.family, scene.name, scene.assembly.n_blocks, way, value, error, seconds)


def dominated(points: list[Point]) -> list[str]:
    """For each scene the ways that are both faster and nearer than blockstat by more than the reference's digits."""
    lines = []
    for scene in dict.fromkeys((p.family, p.scene) for p in points):
        own = [p for p in points if (p.family, p.scene) == scene]
        (default,) = [p for p in own if p.way == "blockstat"]
        better = [p.way for p in own if p.seconds < default.seconds and p.error < max(default.error, DIGITS)]
        lines.append(f"- {scene[0]}, {scene[1]}: {'; '.join(better) or 'none'}")
    return lines


def points_table(points: list[Point]) -> str:
    return table(
        ["scene", "blocks", "way", "multiplier", "error", "s"],
        (
            [f"{p.family}, {p.scene}", p.blocks, p.way, f"{p.value:.6f}", f"{p.error:.1e}", f"{p.seconds:.3f}"]
            for p in points
        ),
    )


def _look(way: str, colour: tuple[float, ...]) -> dict[str, Any]:
    """Marks of blockstat are hollow, so that they hide none."""
    if way.startswith("blockstat"):
        return {"markerfacecolor": "none", "markeredgecolor": colour, "markeredgewidth": 1.5}
    return {"markerfacecolor": colour, "markeredgecolor": "black", "markeredgewidth": 0.5}


def draw(points: list[Point], path: Path) -> None:
    """Error over seconds, a panel a family."""
    from matplotlib.lines import Line2D

    families = list(dict.fromkeys(p.family for p in points))
    ways = list(dict.fromkeys(p.way for p in points))
    figure, axes = panels((11, 8), 2, 2)
    colours = shades("cividis", len(ways))
    for axis, family in zip(axes, families, strict=False):
        for way, colour, marker in zip(ways, colours, MARKERS[: len(ways)], strict=True):
            own = [p for p in points if (p.family, p.way) == (family, way)]
            size = 11 if way.startswith("blockstat") else 7
            seconds, errors = [p.seconds for p in own], [max(p.error, LEAST) for p in own]
            axis.plot(seconds, errors, marker, markersize=size, **_look(way, colour))
        axis.set(title=family, xscale="log", yscale="log", xlabel="process seconds", ylabel="relative error")
        axis.grid(alpha=0.3)
    handles = [
        Line2D([], [], linestyle="", marker=marker, label=way, **_look(way, colour))
        for way, colour, marker in zip(ways, colours, MARKERS[: len(ways)], strict=True)
    ]
    figure.legend(handles=handles, loc="outside right upper", frameon=False)
    save(figure, path)


PAGE = """# Speed against error

Written by `python -m evidence.benchmarks.speed_error --write`. Each method computes the limit load multiplier of each
scene once. Seconds are process time from the assembly in memory to the multiplier, with the search for joints.
[How exact, for how long](choosing.md) has the same for numbers that you choose: tolerances, steps, resolutions, draws.

- The references have six digits, so they cause errors of a few 1e-6. The reference of the chapels is the proven bracket
  of blockstat, so its own error there says nothing.
- Polygons are circumscribed about the friction cone, as is usual, so their exact limits are not below the true one. One
  that is below has the error of its solver.
- Bullet is another model. Its friction does not dilate, so its limits are mostly below the associated ones, and part of
  its error is physics. It takes part in scenes of up to {bullet} blocks.
- compas_cra assesses whether an assembly stands, and computes no limit load.

![four plots of dots, error over seconds, one for each family of scenes](speed-error.png)

*Error against process seconds of every method, on axes with powers of ten: down and to the left is better. Errors
below {least:.0e} are drawn there.*

{advice}

These methods were faster than blockstat and as accurate, scene by scene. Errors below {digits:.0e} count as equal:

{better}

{table}
"""
ADVICE = """**Which method to choose.** The default has exact cones, a reduction of prismatic scenes to their plane, and
a bracket that is proven from both sides. Below a hundred blocks any exact cone serves as well. For larger scenes few
methods are faster, as the list below shows. {tail}"""


def advice(points: list[Point]) -> str:
    def worst(way: str) -> float:
        return max(p.error for p in points if p.way == way)

    return ADVICE.format(
        tail="Polygons lose accuracy wherever the motion is not along their sides: the error of the octagon is up to "
        f"{100 * worst('8-gon'):.2g} %, and that of blockstat up to {worst('blockstat'):.1e}. A loose tolerance loses "
        f"accuracy everywhere: the error at 1e-3 is up to {worst('Clarabel primal, 1e-03'):.2g}. Bullet is the most "
        "expensive, and answers another question."
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--no-bullet", action="store_true")
    parser.add_argument("--largest", type=int, default=10**6, metavar="N", help="scenes of so many blocks at most")
    options = parser.parse_args()
    points = []
    for point in measure(not options.no_bullet, options.largest):
        points.append(point)
        print(f"{point.family}, {point.scene}: {point.way} {point.error:.1e} {point.seconds:.3f} s", file=sys.stderr)
    if options.write:
        page = PAGE.format(advice=advice(points), better="\n".join(dominated(points)), table=points_table(points),
                           bullet=BULLET_MOST, least=LEAST, digits=DIGITS)  # fmt: skip
        (DOCS / "speed_error.md").write_text(page)
        draw(points, DOCS / "speed-error.png")
    print(json.dumps([asdict(p) for p in points]) if options.json else points_table(points))


if __name__ == "__main__":
    main()
