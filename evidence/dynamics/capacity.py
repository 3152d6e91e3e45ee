"""Capacity curves beside Bullet: released on either side of a point of the curve, do the blocks go back or on?

    python -m evidence.dynamics.capacity [--scenes N] [--places N] [--large N] [--json] [--write FILE]

Random arches, arches on piers, walls in running bond pushed in and out of their plane, and facades in bond with side
walls. A point of the curve is taken half-way down, by its multiplier. Under that multiplier, held constant, the blocks
at nine tenths of its displacement must not go on, as the curve there is higher, and at eleven tenths they must. They
are released at rest. Which way they go is told by the mean of their displacements weighted by the load, the control.
Blocks that stay are held by friction or by less than Bullet resolves: on the near side that is no contradiction.

`--write` also follows wall W1 of Ferris & Tin-Loi, with the multipliers that Bullet brackets at the poses of the curve,
and arches and facades up to 700 blocks, with their seconds, and the work of the load beside the rise of the weights.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import pairwise
from time import process_time

import numpy as np

from blockstat import Assembly, CapacityCurve, InputError, capacity, find_interfaces
from blockstat.large_displacement.displaced.pose import displaced_assembly, displaced_points
from dynsim import Settings, simulate
from evidence import results
from evidence.references.walls import wall
from evidence.scenes.small import arch, assembly, box, running_bond, slice_, u_wall
from evidence.tables import table

SEED = 23
#: Mean motion along the load at which a run is ended, relative to the mean size of the blocks. What moves less in the
#: time of a run stays: it is held by friction, or moves as slowly as contacts creep.
SEEN = 0.01
#: A pose this near to the one asked for, relative to its displacement, is taken for it.
NEAR = 0.02
#: What stays is run once more like this: near the limit the sweeps of coarse steps hold what fine ones let go.
FINER = Settings(time_step=2.5e-4, quick_step=2.5e-4, fine_step=2.5e-4, iterations=200)
#: Voussoirs of arches, and blocks along the front, the sides and the height of facades, whose curves are timed.
ARCHES = (10, 30, 100)
FACADES = ((5, 3, 7), (5, 3, 10), (9, 5, 16), (13, 9, 22))
#: Facades up to so many blocks are released in Bullet, too.
MOST_RELEASED = 350
#: W1: displacements of its top right corner [m] at which its multiplier is looked for in Bullet.
PLACES = (0.05, 0.1, 0.2)


def portal(span: float, thickness: float, width: float, height: float, voussoirs: int) -> Assembly:
    """A semicircular arch on two piers of one block each."""
    angles, inner = np.linspace(np.pi, 0, voussoirs + 1), span / 2
    blocks = [box((-9, 0, -1), (9, 1, 0), name="ground")]
    for side, name in ((-1, "left"), (1, "right")):
        low, high = sorted((side * inner, side * (inner + width)))
        blocks.append(box((low, 0, 0), (high, 1, height), name=name))

    def joint(angle: float) -> list[tuple[float, float]]:
        return [(r * np.cos(angle), r * np.sin(angle) + height) for r in (inner, inner + thickness)]

    blocks += [
        slice_([*joint(a)[::-1], *joint(b)], 1.0, name=f"voussoir{k}") for k, (a, b) in enumerate(pairwise(angles))
    ]
    return assembly(blocks)


def bonded_facade(front: int, side: int, courses: int) -> Assembly:
    """Like `u_wall`, of so many whole blocks along the facade and along each side wall."""
    length = 2 * front
    blocks = [box((-2, -2, -1), (length + 2, 2 * side + 4, 0), name="ground")]
    for z in range(courses):
        shift = z % 2
        plans = [((x, 0), (x + 2, 1)) for x in range(shift, length - shift, 2)]
        for x in (0, length - 1):
            plans += [((x, y), (x + 1, y + 2)) for y in range(1 - shift, 2 * side + 1 - shift, 2)]
            plans += [((x, 2 * side), (x + 1, 2 * side + 1))] * shift
        blocks += [box((*low, z), (*high, z + 1)) for low, high in plans]
    return assembly(blocks)


def scenes(number: int) -> list[tuple[str, Assembly, tuple[float, float, float]]]:
    """So many random scenes, the five kinds by turns, each with the direction of its load."""
    random = np.random.default_rng(SEED)
    found: list[tuple[str, Assembly, tuple[float, float, float]]] = []
    while len(found) < number:
        kind = ("arch", "portal", "wall", "panel", "facade")[len(found) % 5]
        name, friction = f"{kind} {len(found)}", float(random.uniform(0.5, 0.8))
        if kind == "arch":
            made = arch(int(random.integers(9, 22)), float(random.uniform(0.14, 0.25)))
        elif kind == "portal":
            span, thickness = random.uniform(2, 4), random.uniform(0.4, 0.6)
            made = portal(
                span, thickness, thickness + random.uniform(0.5, 1.0), random.uniform(1, 4), int(random.integers(9, 20))
            )
        elif kind in ("wall", "panel"):
            made = running_bond(int(random.integers(4, 9)), int(random.integers(3, 6)))
        else:
            made = u_wall(int(random.integers(3, 7)))
        direction = {"wall": (0.0, 1.0, 0.0), "facade": (0.0, -1.0, 0.0)}.get(kind, (1.0, 0.0, 0.0))
        found.append((name, made.with_(friction=friction), direction))
    return found


@dataclass(frozen=True)
class Row:
    """One scene."""

    name: str
    blocks: int
    points: int
    outcome: str
    multiplier: float  #: at rest
    displacement: float  #: of the point that is taken [m]
    held: float  #: its multiplier
    contrast: tuple[float, ...]  #: how much more than that the poses on both sides carry, relative
    before: str  #: "back", "stays", "on" or "overlap", from nine tenths of the displacement
    after: str
    seconds: float  #: process time of the curve


def goes(curve: CapacityCurve, point: int, multiplier: float, direction: tuple[float, float, float]) -> float:
    """Which way Bullet goes from a pose of the curve under a multiple of the load: -1 back, 1 on, 0 where it stays."""
    asm, pose = curve.assembly, curve.points[point].pose
    there = displaced_assembly(asm, pose)
    mass = asm.mass * ~asm.support
    weight = float(np.linalg.norm(asm.gravity)) * mass
    loads = np.zeros((asm.n_blocks, 6))
    loads[:, :3] = multiplier * weight[:, None] * np.array(direction)
    seen = SEEN * float(asm.size[~asm.support].mean())
    # Hinges have opened by little; with the usual tolerance they would count as closed, and be closed.
    joints = find_interfaces(there, gap=1e-6)
    along = np.outer(mass / mass.sum(), direction)

    def mean(moved: np.ndarray) -> float:
        return float((moved * along).sum())

    moved = 0.0
    for settings in (Settings(), FINER):
        run = simulate(
            there, settings=settings, loads=loads, interfaces=joints, stop=lambda _, moved, __: abs(mean(moved)) > seen
        )
        moved = mean(run.since_release[-1])
        if abs(moved) > seen:
            return float(np.sign(moved))
    return 0.0


def row(name: str, asm: Assembly, direction: tuple[float, float, float]) -> Row:
    """The curve of a scene, and which way Bullet goes from either side of a point half-way down."""
    begin = process_time()
    curve = capacity(asm, direction, control="mean", steps=40)
    seconds = process_time() - begin
    there, value = curve.displacement, curve.lower
    half = 0.5 * (value[0] + value[-1])
    last = int(np.argmax(value <= half))
    middle = float(np.interp(half, value[[last, last - 1]], there[[last, last - 1]]))

    def at(displacement: float, rows: np.ndarray) -> tuple[CapacityCurve, int]:
        """A point of the curve: followed by steps the path depends on their length, so one of the same if there is."""
        point = int(rows[np.argmin(np.abs(there[rows] - displacement))])
        if abs(there[point] - displacement) <= NEAR * middle:
            return curve, point
        return capacity(asm, direction, control="mean", steps=40, displacement=displacement), -1

    side, point = at(middle, np.array([last - 1, last]))
    held = float(side.lower[point])
    words: list[str] = []
    contrast: list[float] = []
    for part, rows in ((0.9, np.arange(last + 1)), (1.1, np.arange(last, len(there)))):
        side, point = at(part * middle, rows)
        try:
            words.append({-1.0: "back", 0.0: "stays", 1.0: "on"}[goes(side, point, held, direction)])
        except InputError:  # blocks that had no joint at rest have run into each other
            words.append("overlap")
        contrast.append(float(side.lower[point]) / held - 1.0)
    return Row(
        name, asm.n_blocks, len(there), curve.outcome.word, float(value[0]), middle, held, tuple(contrast), *words,
        seconds,
    )  # fmt: skip


def panel(places: int) -> list[list[object]]:
    """W1: the curve, and the multipliers between which Bullet's blocks go back and on at its poses."""
    asm = wall("W1")
    curve = capacity(asm, (1, 0, 0), steps=60)
    corner = int(np.argmax(asm.vertices @ np.array([1.0, 0.0, 1.0])))
    block, corners = asm.vertex_block[[corner]], asm.vertices[[corner]]
    top = np.array([(displaced_points(asm, point.pose, block, corners) - corners)[0, 0] for point in curve.points])
    lines: list[list[object]] = []
    for there in PLACES[:places]:
        point = int(np.argmin(np.abs(top - there)))
        low, high = 0.0, 1.2 * float(curve.upper[point])
        for _ in range(7):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if goes(curve, point, middle, (1, 0, 0)) > 0 else (middle, high)
        bracket = f"{curve.lower[point]:.3f} to {curve.upper[point]:.3f}"
        lines.append([f"{1e3 * top[point]:.0f}", bracket, f"{low:.3f} to {high:.3f}"])
    return lines


def work_and_rise(curve: CapacityCurve) -> tuple[np.ndarray, np.ndarray]:
    """Work of the load along a curve of the control "mean", and rise of the weights, relative to the weight [m]."""
    asm = curve.assembly
    share = asm.mass * ~asm.support / asm.mass[~asm.support].sum()
    gained = 0.5 * (curve.lower[1:] + curve.lower[:-1]) * np.diff(curve.displacement)
    rise = np.array([share @ point.pose.displacement[:, 2] for point in curve.points])
    return np.concatenate([[0.0], np.cumsum(gained)]), rise


def large(number: int) -> list[list[object]]:
    """Arches and facades by size: seconds of a limit load and of the whole curve, and which way Bullet goes."""
    made = [(f"arch {n}", arch(n, 0.2), (1.0, 0.0, 0.0)) for n in ARCHES]
    made += [
        (f"facade {size[-1]} high", bonded_facade(*size).with_(friction=0.6), (0.0, -1.0, 0.0)) for size in FACADES
    ]
    lines: list[list[object]] = []
    for name, asm, direction in made[:number]:
        begin = process_time()
        curve = capacity(asm, direction, control="mean")
        seconds, limit = process_time() - begin, curve.timings["limit"]
        ways = ["", ""]
        if name.startswith("facade") and asm.n_blocks <= MOST_RELEASED:
            released = row(name, asm, direction)
            ways = [released.before, released.after]
        last = f"{curve.lower[-1] / curve.lower[0]:.3f}"
        each = f"{seconds / len(curve.points) / limit:.1f}"
        work, rise = (float(sums[-1]) for sums in work_and_rise(curve))
        lines.append(
            [name, asm.n_blocks, len(curve.points), curve.outcome.word, last, f"{limit:.2f}", f"{seconds:.1f}", each,
             f"{work / rise:.2f}", *ways]
        )  # fmt: skip
        print(lines[-1], flush=True)
    return lines


def main() -> None:
    """Print and write the tables."""
    parser = results.parser(__doc__)
    parser.add_argument("--scenes", type=int, default=30, metavar="N")
    parser.add_argument("--places", type=int, default=len(PLACES), metavar="N", help="of W1, so many alone")
    parser.add_argument(
        "--large", type=int, default=len(ARCHES) + len(FACADES), metavar="N", help="so many sizes alone"
    )
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = []
    for scene in scenes(options.scenes):
        rows.append(row(*scene))
        print(rows[-1], flush=True)
    right = sum(one.before in ("back", "stays") and one.after == "on" for one in rows)
    head = [
        "",
        "blocks",
        "points",
        "end",
        "multiplier",
        "displacement [mm]",
        "held",
        "beside it [%]",
        "from .9",
        "from 1.1",
        "seconds",
    ]
    cells = [
        [one.name, one.blocks, one.points, one.outcome, f"{one.multiplier:.4f}", f"{1e3 * one.displacement:.1f}",
         f"{one.held:.4f}", ", ".join(f"{100 * part:+.1f}" for part in one.contrast), one.before, one.after,
         f"{one.seconds:.1f}"] for one in rows
    ]  # fmt: skip
    summary = f"- From both sides of the point Bullet goes as the curve says in {right} of {len(rows)} scenes."
    w1 = table(["top right corner [mm]", "curve", "Bullet at that pose"], panel(options.places))
    sizes = table(["", "blocks", "points", "end", "last / first", "limit load [s]", "curve [s]", "limit loads a point",
                   "work / rise", "from .9", "from 1.1"], large(options.large))  # fmt: skip
    parts = {"summary": summary, "scenes": table(head, cells), "w1": w1, "large": sizes}
    results.report(options, [one.__dict__ for one in rows], parts)


if __name__ == "__main__":
    main()
