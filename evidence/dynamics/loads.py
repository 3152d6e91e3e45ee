"""Loads in Bullet against closed forms, Bullet's own limits, forces at rest, and many designs side by side.

    python -m evidence.dynamics.loads [--strips DIRECTORY] [--write FILE]

Seconds are process time. --strips also draws film strips of two runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from blockstat import Tie, limit_load
from dynsim import (
    DynamicOutcome,
    Pulse,
    Push,
    Ramp,
    Removal,
    Settings,
    Settlement,
    Tilt,
    limit,
    simulate,
    verify,
    verify_many,
)
from dynsim.view.film import film_strip
from evidence import results
from evidence.bisection import bisect
from evidence.scenes.arches import barrel_on_piers
from evidence.scenes.small import arch, assembly, box, running_bond, stack
from evidence.tables import head, row

G = 9.81
DOWN = (0, 0, -G)
ARCH = "arch of 15, t / R = .15, pushed"
FAR = Settings(brick_threshold=20.0, roof_threshold=20.0)


def turning_point(make, *, low=0.9, high=1.1, width=0.002):
    """Factor on a load at which an assembly begins to fall, by bisection; make : (assembly, loads) of a factor."""

    def survives(factor: float) -> bool:
        asm, loads = make(factor)
        return verify(asm, loads=loads).outcome is not DynamicOutcome.FALLS

    return sum(bisect(survives, low, high, width)) / 2


def tipping() -> Iterator[str]:
    for width in (0.25, 0.5, 1.0):
        asm, angle = stack(1, width, 2.0, gravity=DOWN, friction=2.0), np.degrees(np.arctan(width / 2))
        tilted = turning_point(lambda f, asm=asm, angle=angle: (asm, [Tilt((0, 1, 0), f * angle, rate=5.0)]))
        pushed = turning_point(lambda f, asm=asm, width=width: (asm, [Ramp((f * width / 2 * G, 0, 0), 2.0)]))
        yield row([f"tilt, block {width:g} x 2", "tan angle = b / h", f"{tilted:.3f}"])
        yield row([f"ramp of acceleration, block {width:g} x 2", "a / g = b / h (West)", f"{pushed:.3f}"])


def overturning() -> Iterator[str]:
    width, height = 0.25, 2.0
    asm = stack(1, width, height, gravity=DOWN, friction=2.0)
    p = np.sqrt(3 * G / (2 * np.hypot(width, height)))
    for strength in (1.5, 2.5, 4.0):
        duration = np.arccosh(1 + 1 / (2 * strength * (strength - 1))) / p
        peak = (strength * width / height * G, 0, 0)
        found = turning_point(lambda f, peak=peak, duration=duration: (asm, [Pulse(peak, f * duration)]), width=0.005)
        name = f"rectangular pulse, {strength:g} times West's, block 0.25 x 2"
        yield row([name, "duration (Housner 1963)", f"{found:.3f}"])


def sliding() -> Iterator[str]:
    for mu, share, duration in ((0.2, 0.5, 0.4), (0.5, 0.8, 0.3)):
        blocks = [box((-50, -50, -1), (50, 50, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2), name="slab")]
        asm, a = assembly(blocks, friction=mu, gravity=DOWN), share * G
        exact = (a * duration) ** 2 / (2 * mu * G) * (1 - mu * G / a)
        moved = -verify(asm, loads=[Pulse((a, 0, 0), duration)], settings=FAR).displacement[1, 0]
        yield row([f"slab, mu = {mu:g}, pulse of {share:g} g", "distance (Newmark 1965)", f"{moved / exact:.3f}"])
        pushed = verify(asm, loads=[Push("slab", velocity=(1.5, 0, 0))], settings=FAR).displacement[1, 0]
        exact = 1.5**2 / (2 * mu * G)
        yield row([f"slab, mu = {mu:g}, pushed at 1.5 m/s", "v^2 / 2 mu g", f"{pushed / exact:.3f}"])


def hinges() -> Iterator[str]:
    asm = arch(15, 0.15, gravity=DOWN)
    for name, path in (("outwards", (0.03, 0, 0)), ("inwards", (-0.03, 0, 0)), ("down", (0, 0, -0.05))):
        verdict = verify(asm, loads=[Settlement("right", path, 0.02)])
        last = verdict.run.rotation[-1]
        turns = [
            Rotation.from_matrix(last[a].T @ last[b]).magnitude() for a, b in pairwise([0, *range(2, asm.n_blocks), 1])
        ]
        order = np.sort(turns)[::-1]
        most = ", ".join(f"{np.degrees(t):.2f}" for t in order[:3])
        moved = f"{name} by {1e3 * np.abs(path).sum():g} mm"
        yield row([moved, verdict.outcome.word, most, f"{np.degrees(order[3]):.3f}"])


def limits() -> Iterator[str]:
    scenes = (
        ("block tipping", stack(1, 0.5, 2.0), (1, 0, 0)),
        (ARCH, arch(15, 0.15), (1, 0, 0)),
        ("wall 8 x 4 out of plane", running_bond(8, 4), (0, 1, 0)),
        ("wall 8 x 4 in plane", running_bond(8, 4), (1, 0, 0)),
    )
    for name, asm, direction in scenes:
        found = limit(asm, direction)
        zero = limit_load(asm, direction, flow="coulomb").coulomb
        assert zero is not None
        middle = (found.lower + found.upper) / 2
        yield row(
            [
                name, f"{found.lower:.4f} to {found.upper:.4f}", f"{found.ratio:.3f}", f"{middle / zero[0]:.3f}",
                len(found.trials), f"{found.process_seconds:.1f}", "; ".join(found.warnings) or "-",
            ]
        )  # fmt: skip
        if name == ARCH:
            thinner = thickness(1 - found.ratio)
    yield "\n" + thinner


def tied() -> Iterator[str]:
    """Limits of tied scenes, whose ties bear so many weights of all free blocks."""
    tower, portal = stack(4, 0.5, 0.5, friction=2.0), barrel_on_piers(0.6, 2.5)
    across = ("pier-1", "pier1"), ((-2.25, 0.5, 2.5), (2.25, 0.5, 2.5))
    scenes = [
        (f"stack of 4 with a central tendon of {f:g} W", tower, tendon(tower, f * tower.free_weight))
        for f in (0.5, 1.0, 2.0)
    ]
    unit = float(portal.density[-1] * np.linalg.norm(portal.gravity))
    yields = 0.36598887
    scenes.append((f"arch on piers, tie that yields at {yields:g} gamma", portal, Tie(*across, greatest=yields * unit)))
    for name, bare, tie in scenes:
        found = limit(bare.with_(ties=[tie]), (1, 0, 0))
        yield row([name, f"{found.lower:.4f} to {found.upper:.4f}", f"{found.ratio:.3f}", len(found.trials)])


def tendon(asm, force: float) -> Tie:
    """A constant force along the axis of a stack, from its top to the ground."""
    top = int(asm.free[-1])
    low, high = asm.vertices[asm.vertex_start[top] : asm.vertex_start[top + 1]].min(axis=0), asm.bounds[1][top]
    middle = (low + high) / 2
    ends = ((middle[0], middle[1], high[2]), (middle[0], middle[1], asm.bounds[0][asm.free].min(axis=0)[2]))
    return Tie((top, int(np.flatnonzero(asm.support)[0])), ends, least=force, greatest=force)


def thickness(lost: float) -> str:
    """How much thinner an arch would be that statics make weaker by that share."""
    thin, thick = (limit_load(arch(15, 0.15 * factor), (1, 0, 0)).lower for factor in (0.99, 1.01))
    share = (thick - thin) / (thick + thin) / 0.01
    return (
        f"The limit of the arch in Bullet is {100 * lost:.1f} percent below the static limit. One percent of the "
        f"thickness changes the static limit by {share:.1f} percent, so the arch acts as if it were "
        f"{100 * lost / share:.1f} percent thinner."
    )


def forces() -> Iterator[str]:
    for name, asm in (("wall 8 x 4", running_bond(8, 4)), ("arch of 15", arch(15, 0.15))):
        run = simulate(asm)
        carried = -sum(run.contacts.on(int(b))[2] for b in np.flatnonzero(asm.support)) / asm.free_weight
        worst = max(
            np.linalg.norm(run.contacts.on(int(b)) + asm.mass[b] * asm.gravity) / asm.mass[b] for b in asm.free
        ) / np.linalg.norm(asm.gravity)
        yield row([name, f"{carried:.5f}", f"{worst:.5f}"])


def side_by_side() -> Iterator[str]:
    designs = [arch(n, t) for n in (9, 15) for t in (0.09, 0.12, 0.2)] + [stack(3), running_bond(4, 3)]

    def bits(jobs):
        return [row.result.run.displacement.tobytes() for row in verify_many(designs, jobs=jobs)]

    alone = [verify(design).run.displacement.tobytes() for design in designs]
    for jobs in (1, 2, 3):
        same = sum(a == b for a, b in zip(alone, bits(jobs), strict=True))
        yield f"- {len(designs)} designs, {jobs} at a time: {same} runs equal the single runs bit by bit"


def strips(directory: Path):
    asm = arch(15, 0.15, gravity=DOWN)
    whole = Settings(brick_threshold=1.2, roof_threshold=1.2)
    film_strip(verify(asm, loads=[Removal("voussoir7", 0.1)], settings=whole).run, directory / "strip-keystone.png")
    wall = running_bond(8, 4, gravity=DOWN)
    film_strip(verify(wall, loads=[Pulse((0, 0.25 * G, 0), 0.5)], settings=whole).run, directory / "strip-wall.png")


#: The lines above those of a part.
HEADS = {
    "closed_forms": [head(["load", "closed form", "Bullet / closed form"])],
    "hinges": [head(["support moves", "verdict", "the three joints that turn most, degrees", "the fourth"])],
    "limits": [head(["scene", "Bullet", "/ associated", "/ zero dilatancy", "runs", "s", "warnings"])],
    "tied": [head(["scene", "Bullet", "/ statics", "runs"])],
    "forces": [head(["at rest", "carried by the supports / weight", "worst balance of a block / its weight"])],
    "side_by_side": [],
}


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--strips", type=Path, metavar="DIRECTORY")
    given = parser.parse_args()
    lines = {
        "closed_forms": [*tipping(), *overturning(), *sliding()], "hinges": [*hinges()], "limits": [*limits()],
        "tied": [*tied()], "forces": [*forces()], "side_by_side": [*side_by_side()],
    }  # fmt: skip
    parts = {name: "\n".join([*HEADS[name], *found]) for name, found in lines.items()}
    results.report(given, lines, parts)
    if given.strips:
        strips(given.strips)


if __name__ == "__main__":
    main()
