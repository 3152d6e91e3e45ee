"""One, two, n blocks: closed forms from the statics of rigid blocks with Coulomb friction.

Overhang: the harmonic series. Slab between a slab and a wall: associated P = mu (W_A + 2 W_B / (1 - mu^2)), least Coulomb
P = mu (W_A + 2 W_B / (1 + mu^2)). Flat arch of n blocks: the thrust line under a uniform load, and W / 2 = mu H at the
abutments. Torsion: four corner points at the half diagonal, each with a quarter of the pressure.
"""

import math

import numpy as np

from blockstat import assess, friction_limit, thrust_range
from evidence.references.row import INF, Row, Value, between, limit, stands, tilt, zero_dilatancy
from evidence.scenes.small import assembly, box, flat_arch, overhanging, pulled_slab, slab, stack, trilith

SIDE = (1, 0, 0)


def direction(degrees: float):
    return (math.cos(math.radians(degrees)), math.sin(math.radians(degrees)), 0)


def least_friction() -> Value:
    found = friction_limit(stack(1), gravity=(0.3, 0, -1))
    return Value(found.stands, found.stands - found.falls)


def corner_force() -> Value:
    normal = assess(assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))])).forces[:, 0]
    return Value(normal.max(), normal.max() - normal.min())


def offset_cube(what: str) -> Value:
    verdict = assess(assembly([box((-0.5, 0, 0), (0.5, 1, 1)), box((0.25, 0, 1), (1.25, 1, 2))]))
    inner = np.isclose(verdict.interfaces.point[:, 0], 0.25)
    net = verdict.forces[:, 0] - verdict.adhesion
    return Value({"tension": -net[inner].sum(), "pressure": net[~inner].sum(), "energy": verdict.score**2}[what])


def flat_thrust(n: int, mu: float, which: str) -> Value:
    return Value(getattr(thrust_range(flat_arch(n, friction=mu), ["right"], SIDE), which))


def torsion() -> Value:
    asm = assembly([box((-1, -1, -1), (1, 1, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 1))], friction=0.6)
    twist = np.zeros((2, 6))
    twist[1, 5] = 0.6
    return limit(asm, twist)


ROWS = [
    Row("E", "block 1 x 2 tips, lambda = b/h", "moments about the foot", 0.5, lambda: limit(stack(1, 1.0, 2.0), SIDE)),
    Row("E", "block 2 x .5 slides, lambda = mu", "Coulomb", 0.7, lambda: limit(stack(1, 2.0, 0.5), (0.6, 0.8, 0))),
    *(Row("E", f"slab slides towards {a} deg, mu .5", "Coulomb", 0.5, lambda a=a: limit(slab(), direction(a), friction=0.5)) for a in (0, 11.25, 22.5, 45, 100)),
    Row("E", "slab on an incline, mu .5 [deg]", "atan(mu)", math.degrees(math.atan(0.5)), lambda: tilt(slab(), direction(22.5), friction=0.5)),
    *(Row("E", f"stack of {n} blocks 1 x .5, lambda = min(mu, b/(n a))", "moments about the foot", min(0.7, 2 / n), lambda n=n: limit(stack(n, 1.0, 0.5), SIDE)) for n in (2, 5, 12)),
    *(Row("E", f"trilith, lintel {d:g} times as dense, lambda = b/h", "four hinges", 0.25, lambda d=d: limit(trilith(d), SIDE)) for d in (1, 1e3, 1e6)),
    Row("E", "trilith on slippery ground, lambda = mu", "Coulomb", 0.1, lambda: limit(trilith(), SIDE, friction=0.1)),
    *(Row("E", f"overhang of {n} blocks", "1/2 sum 1/k", text, lambda n=n: between(0.8 * float(n > 0), 2.0, lambda x: stands(overhanging(n, x)), 1e-9)) for n, text in ((3, ".9166667"), (5, "1.1416667"), (10, "1.4644841"))),
    Row("E", "cube on cube, force at a corner / W", "symmetry", 0.25, corner_force),
    Row("E", "offset cube, least tension / W", "moments", 1.0, lambda: offset_cube("tension")),
    Row("E", "offset cube, pressure / W", "moments", 2.0, lambda: offset_cube("pressure")),
    Row("E", "offset cube, sum s^2 / W^2", "moments, two corners an edge", 0.5, lambda: offset_cube("energy")),
    Row("E", "slab pulled from under a slab, associated", "mu (W_A + 2 W_B / (1 - mu^2))", "1.833333", lambda: limit(*pulled_slab())),
    Row("E", "the same, least Coulomb", "mu (W_A + 2 W_B / (1 + mu^2))", "1.3", lambda: zero_dilatancy(*pulled_slab()), within=1e-3),
    *(Row("E", f"flat arch of {n} blocks, mu {mu}, least thrust", "max(W L / 8 h (1 - odd(n) / n^2), W / 2 mu)", max(0.5 * (1 - n % 2 / n**2), 1 / mu), lambda n=n, mu=mu: flat_thrust(n, mu, "least")) for n, mu in ((4, INF), (5, INF), (9, INF), (8, 0.7), (8, 0.05))),
    Row("E", "flat arch, mu .05, greatest thrust", "jammed between its abutments", INF, lambda: flat_thrust(8, 0.05, "greatest")),
    Row("E", "torsion on four corner points / mu N a", "mu N a / sqrt 2", ".707107", torsion),
    Row("E", "least friction on a slope of .3", "tan of the slope", 0.3, least_friction, within=1e-6),
]  # fmt: skip
