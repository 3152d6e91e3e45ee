"""Compute every reference value again and write docs/validation.md: `make validation`.

Tags: P published, D derived from first principles by two methods, E exact. The same references are tests in
tests/validation, where the sources stand in full.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from blockstat import Outcome, assess, friction_limit, limit_load, point_load, thrust_range, tilt_limit
from problems import FERRIS, arch, assembly, box, ferris_wall, stack

INF = math.inf
Value = tuple[float, float]  # what we answer, and the width of what is proven about it
Row = tuple[str, str, float, Callable[[], Value]]


def limit(asm, load, **options) -> Value:
    found = limit_load(asm, load, **options)
    return found.lower, found.upper - found.lower


def coulomb(asm, load) -> Value:
    low, high = limit_load(asm, load, flow="coulomb").coulomb or (math.nan, math.nan)
    return low, high - low


def tilt(asm, axis, **options) -> Value:
    found = tilt_limit(asm, axis, **options)
    return found.stands, found.falls - found.stands


def thrust(t: float, which: str) -> Value:
    asm = arch(20, t)
    found = thrust_range(asm, ["right"], (1, 0, 0), friction=INF)
    return getattr(found, which) / asm.mass[asm.free].sum(), math.nan


def least_thickness(n: int, mu: float) -> Value:
    low, high = 0.08, 0.3
    while high - low > 1e-8:
        middle = (low + high) / 2
        outcome = assess(arch(n, middle), friction=mu).outcome
        if outcome is Outcome.UNDECIDED:
            break
        low, high = (low, middle) if outcome is Outcome.STABLE else (middle, high)
    return high, high - low


def least_friction(asm) -> Value:
    found = friction_limit(asm)
    return found.stands, found.stands - found.falls


def voussoir_load(block: int) -> Value:
    asm = arch(20, 0.2)
    corners = asm.block_vertices(asm.names.index(f"voussoir{block}"))
    outer = corners[np.linalg.norm(corners[:, [0, 2]], axis=1) > 1.0].mean(axis=0)
    force = (0, 0, -asm.mass[asm.free].sum())
    return limit(asm, point_load(asm, f"voussoir{block}", outer, force), friction=INF)


def u_wall(courses: int):
    blocks = [box((-2, -2, -1), (8, 7, 0))]
    for z in range(courses):
        if z % 2 == 0:
            plans = [((x, 0), (x + 2, 1)) for x in (0, 2, 4)] + [
                ((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (1, 3)
            ]
        else:
            plans = [((x, 0), (x + 2, 1)) for x in (1, 3)] + [((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (0, 2)]
            plans += [((x, 4), (x + 1, 5)) for x in (0, 5)]
        blocks += [box((*low, z), (*high, z + 1)) for low, high in plans]
    return assembly(blocks)


def rows() -> list[Row]:
    side = (1, 0, 0)
    found: list[Row] = [
        ("E", "block 1 x 2 tips, lambda = b/h", 0.5, lambda: limit(stack(1, 1.0, 2.0), side)),
        ("E", "block 2 x .5 slides, lambda = mu", 0.7, lambda: limit(stack(1, 2.0, 0.5), (0.6, 0.8, 0))),
        ("E", "stack of 12, lambda = b/(n a)", 1 / 6, lambda: limit(stack(12, 1.0, 0.5), side)),
        ("E", "least friction on a slope of .3", 0.3, lambda: least_friction(stack(1).with_(gravity=np.array([0.3, 0, -1])))),
    ]  # fmt: skip
    for n, exact in ((4, 0.097361), (5, 0.094980), (6, 0.104134), (8, 0.099972), (10, 0.107011), (12, 0.104857),
                     (16, 0.107076), (20, 0.107348), (24, 0.107096), (27, 0.106721), (36, 0.107424), (100, 0.1074556)):  # fmt: skip
        found.append(("D", f"least t/R, {n} voussoirs, no sliding", exact, lambda n=n: least_thickness(n, 2.0)))
    for mu, exact in ((0.39, 0.111630), (0.38, 0.121124), (0.36, 0.140891), (0.34, 0.161767), (0.32, 0.183845), (0.31, 0.195995)):  # fmt: skip
        found.append(("D", f"least t/R, 27 voussoirs, mu = {mu}", exact, lambda mu=mu: least_thickness(27, mu)))
    for t, mu, exact in ((0.12, INF, 0.048631), (0.15, 0.6, 0.149350), (0.2, 0.7, 0.285646), (0.3, INF, 0.518602),
                         (0.3, 0.7, 0.456126), (0.3, 0.6, 0.365081)):  # fmt: skip
        found.append(
            (
                "D",
                f"lambda, 20 voussoirs, t/R {t}, mu {mu}",
                exact,
                lambda t=t, mu=mu: limit(arch(20, t), side, friction=mu),
            )
        )
    wide = math.radians(157.5)
    found += [
        (
            "D",
            "De Lorenzis arch, 7 voussoirs",
            0.373612,
            lambda: limit(arch(7, 0.15, embrace=wide), side, friction=INF),
        ),
        ("D", "157.5 deg, t/R .25, mu .6", 0.575291, lambda: limit(arch(20, 0.25, embrace=wide), side, friction=0.6)),
        ("D", "point load on voussoir 4 of 20, P/W", 3.018464, lambda: voussoir_load(4)),
        ("D", "point load on voussoir 9 of 20, P/W", 0.422907, lambda: voussoir_load(9)),
        ("D", "tilt of 100 voussoirs, t/R .20 [deg]", 15.8444, lambda: tilt(arch(100, 0.2), "y", friction=INF)),
        ("D", "tilt of 36 voussoirs, t/R .15 [deg]", 8.2464, lambda: tilt(arch(36, 0.15), "y", friction=INF)),
        ("D", "least thrust / weight, t/R .15", 0.175635, lambda: thrust(0.15, "least")),
        ("D", "greatest thrust / weight, t/R .30", 0.299956, lambda: thrust(0.3, "greatest")),
        ("D", "U-shaped wall, 12 courses", 0.277391, lambda: limit(u_wall(12), (0, -1, 0))),
    ]
    for name, (layout, _, _, published, derived) in FERRIS.items():
        found.append(
            ("D", f"Ferris & Tin-Loi {name}, associated", derived, lambda r=layout: limit(ferris_wall(r), side))
        )
        found.append(
            ("P", f"Ferris & Tin-Loi {name}, associated", published, lambda r=layout: limit(ferris_wall(r), side))
        )
    for name, published in (("W1", 0.640), ("W3", 0.356), ("W4", 0.264)):
        found.append(
            (
                "P",
                f"Ferris & Tin-Loi {name}, zero dilatancy",
                published,
                lambda n=name: coulomb(ferris_wall(FERRIS[n][0]), side),
            )
        )
    return found


def main() -> None:
    lines = [
        "# Validation", "",
        "Written by `make validation`. Value: the reference, P published, D derived by two independent methods, E exact.",
        "Bracket: the distance between what is proven to stand and what is proven to fall (for zero dilatancy: the",
        "bisection). The tests in `tests/validation` hold the same references with their sources.", "",
        "| | reference | value | ours | bracket | error | s |", "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    print("\n".join(lines[-2:]))
    for tag, name, value, compute in rows():
        begin = process_time()
        ours, width = compute()
        seconds = process_time() - begin
        bracket = "" if math.isnan(width) else f"{abs(width):.0e}"
        lines.append(f"| {tag} | {name} | {value:.7g} | {ours:.7g} | {bracket} | {ours - value:+.0e} | {seconds:.2f} |")
        print(lines[-1], flush=True)
    (Path(__file__).parent / "validation.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
