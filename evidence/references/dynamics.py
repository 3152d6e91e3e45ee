"""What Bullet must give: closed forms of one block, and limits of assemblies that statics know.

Slip at tan(angle) = mu in every direction; tipping at b/h. Rocking (Housner, Bull. Seismol. Soc. Am. 53, 1963): a block of
half-diagonal R and slenderness alpha has p^2 = 3g/4R, theta'' = -p^2 sin(alpha - theta), and keeps 1 - 1.5 sin^2(alpha) of
its angular velocity at an impact. Limits are given as factors: 1 is the exact limit, more is less safe. Arches: least
thickness by static bisection. Walls out of plane: t/H. Walls in plane: zero dilatancy (blockstat, flow="coulomb"; the
associated limit is an upper bound that dry friction does not reach). Harmonic stack: overhang of sum L/2k.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from math import atan2, cos, hypot, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from blockstat import Assembly, limit_load
from dynsim import Settings, simulate, verify
from evidence.bisection import bisect
from evidence.scenes.small import arch, assembly, box, running_bond, stack

G = 9.81
DIRECTIONS = 16


@dataclass(frozen=True)
class Limit:
    """A family of scenes and the factor at which it stops standing."""

    name: str
    scene: Callable[[float], Assembly]
    source: str
    within: float  #: error of the factor that is accepted
    slow: bool = False

    def stands(self, factor: float, settings: Settings | None = None) -> bool:
        return verify(self.scene(factor), settings=settings).outcome.word == "stands"

    def bracket(self, settings: Settings | None = None) -> tuple[float, float]:
        """Largest factor seen to stand and smallest seen not to, a quarter of the tolerance apart."""
        low, high = 1 - 3 * self.within, 1 + 3 * self.within
        return bisect(partial(self.stands, settings=settings), low, high, self.within / 4 * (1 + 1e-9))


def pushed(asm: Assembly, limit: Callable[[], float], direction: tuple[float, float], factor: float) -> Assembly:
    push = limit() * factor
    return asm.with_(gravity=G * np.array([direction[0] * push, direction[1] * push, -1.0]))


@cache
def in_plane(courses: int, bricks: int) -> float:
    found = limit_load(running_bond(courses, bricks), (1, 0, 0), flow="coulomb").coulomb_kinds
    return sum(found[-1]) / 2  # open and elastic joints, as in `evidence.references.row.zero_dilatancy`


def harmonic(n: int, factor: float) -> Assembly:
    """n blocks of length 1 that overhang the edge x = 0 by the harmonic series times a factor."""
    tips = np.cumsum([0.5 / k for k in range(n, 0, -1)]) * factor
    blocks = [box((tip - 1, -0.25, 0.25 * i), (tip, 0.25, 0.25 * (i + 1))) for i, tip in enumerate(tips)]
    return assembly([box((-3, -0.5, -1), (0, 0.5, 0)), *blocks])


def out_of_plane(courses: int, factor: float) -> Assembly:
    return pushed(running_bond(courses, 4), lambda: 0.2 / (courses * 0.175), (0, 1), factor)


def wall(courses: int, factor: float) -> Assembly:
    return pushed(running_bond(courses, 4), lambda: in_plane(courses, 4), (1, 0), factor)


def thinner_arch(n: int, least: float, factor: float) -> Assembly:
    return arch(n, least / factor)


LIMITS = [
    Limit("block tipping", lambda f: pushed(stack(1, 0.5, 2.0), lambda: 0.25, (1, 0), f), "b/h", 0.002),
    Limit("harmonic stack of 10", partial(harmonic, 10), "sum L/2k", 0.015),
    Limit("wall of 6 courses, out of plane", partial(out_of_plane, 6), "t/H", 0.015),
    Limit("wall of 10 courses, out of plane", partial(out_of_plane, 10), "t/H", 0.015, slow=True),
    Limit("wall of 8 x 4, in plane", partial(wall, 8), "zero dilatancy", 0.03, slow=True),
    Limit("arch of 15, 1 / thickness", partial(thinner_arch, 15, 0.10705), "static bisection", 0.03),
    Limit("arch of 31, 1 / thickness", partial(thinner_arch, 31, 0.10736), "static bisection", 0.03, slow=True),
    Limit("arch of 61, 1 / thickness", partial(thinner_arch, 61, 0.10740), "static bisection", 0.03, slow=True),
]

#: Scenes that must rest.
RESTS: dict[str, Callable[[], Assembly]] = {
    "wall of 60 courses": lambda: running_bond(60, 2),
    "arch of 100 voussoirs, t/R .15": lambda: arch(100, 0.15),
}


def slab(hull: bool) -> Assembly:
    """A slab on a plane; as hulls, a corner of the ground is cut so that it is no box."""
    ground = box((-5, -5, -1), (5, 5, 0))
    if hull:
        ground = _cut_corner(ground)
    return assembly([ground, box((-0.5, -0.5, 0), (0.5, 0.5, 0.2))], friction=0.7)


def _cut_corner(block):
    """The block without a small convex corner at its foot."""
    from scipy.spatial import ConvexHull

    from blockstat import Block

    corners = block.vertices.astype(float)
    lowest = corners[np.argmin(corners.sum(axis=1))]
    points = np.vstack([corners[(corners != lowest).any(axis=1)], lowest + 0.4 * np.eye(3)])
    hull = ConvexHull(points)
    faces = []
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = points[simplex]
        faces.append(simplex if np.cross(b - a, c - a) @ equation[:3] > 0 else simplex[::-1])
    return Block(points, [face.tolist() for face in faces])


def slips_rightly(hull: bool, direction: int, within: float = 0.005) -> bool:
    """Whether the slab rests at mu (1 - within) and slides at mu (1 + within) in one of 16 directions."""
    angle = 2 * np.pi * direction / DIRECTIONS + 0.1
    asm = slab(hull)
    words = []
    for factor in (1 - within, 1 + within):
        push = 0.7 * factor
        words.append(verify(asm.with_(gravity=G * np.array([push * cos(angle), push * sin(angle), -1]))).outcome.word)
    return words == ["stands", "falls"]


@dataclass(frozen=True)
class Rocking:
    """One swing of a free rocking block against Housner's theory."""

    quarter: float  #: time from release to the impact over the exact one
    restitution: float  #: share of the angular velocity that an impact leaves, over 1 - 1.5 sin^2 alpha


def rocking(width: float, height: float, share: float = 0.5, settings: Settings | None = None) -> Rocking:
    """Release a block from a share of its slenderness alpha and watch it through one impact."""
    alpha, radius = atan2(width, height), hypot(width, height) / 2
    p = sqrt(3 * G / (4 * radius))
    ground = box((-5, -5, -1), (5, 5, 0))
    block = box((0, -0.5, 0), (width, 0.5, height))
    tilt = Rotation.from_rotvec([0, share * alpha, 0])  # about the edge x = width
    corner = np.array([width, 0, 0])
    tilted = type(block)((tilt.apply(block.vertices - corner) + corner), block.faces)
    asm = assembly([ground, tilted], friction=5.0, gravity=(0, 0, -G))
    settings = settings or Settings(look_every=0.005, settle=0.005, end=1.5)
    run = simulate(asm, settings=settings)
    angle = share * alpha + Rotation.from_matrix(run.rotation[:, 1]).as_rotvec()[:, 1]
    hit = int(np.argmax(angle <= 0))
    crossing = np.interp(0, [angle[hit], angle[hit - 1]], [run.times[hit], run.times[hit - 1]])
    exact = _quarter(p, alpha, angle[0])
    peak = -angle[: hit + int(np.argmax(np.diff(angle[hit:]) > 0)) + 1].min()
    lost = (cos(alpha - peak) - cos(alpha)) / (cos(alpha - angle[0]) - cos(alpha))
    return Rocking(crossing / exact, sqrt(lost) / (1 - 1.5 * sin(alpha) ** 2))


def _quarter(p: float, alpha: float, start: float) -> float:
    """Time in which a block released at an angle comes down on its base [s]."""

    def down(_: float, state: np.ndarray) -> float:
        return state[0]

    down.terminal = True
    found = solve_ivp(
        lambda _, s: [s[1], -(p**2) * sin(alpha - s[0])], (0, 20 / p), [start, 0.0], events=down, rtol=1e-10, atol=1e-12
    )
    return float(found.t_events[0][0])


BLOCKS = [(0.2, 0.6), (0.2, 1.0), (0.4, 0.8)]
