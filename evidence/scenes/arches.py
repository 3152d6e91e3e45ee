"""Arches other than the round one of radial joints, and round ones with other weights."""

from __future__ import annotations

import math

import numpy as np

from blockstat import Assembly, Block
from evidence.scenes.small import arch, assembly, box, slice_


def pointed_arch(n: int, eccentricity: float, thickness: float, *, depth: float = 0.5) -> Assembly:
    """Two arcs of radius 1, centres at +-eccentricity on the springing line, n voussoirs each, meeting at the crown."""
    top = math.acos(eccentricity)  # the left arc has its centre on the right

    def ring(angle):
        c, s = math.cos(angle), math.sin(angle)
        return [(eccentricity - r * c, r * s) for r in (1 - thickness / 2, 1 + thickness / 2)]

    rings = [ring(a) for a in np.linspace(0, top, n + 1)]
    # The joint at the crown is vertical: both ends of the last radial joint are moved along the arcs onto x = 0.
    rings[-1] = [(0.0, math.sqrt(r**2 - eccentricity**2)) for r in (1 - thickness / 2, 1 + thickness / 2)]
    left = [[*a[::-1], *b] for a, b in zip(rings[:-1], rings[1:], strict=True)]
    plans = left + [[(-x, z) for x, z in plan[::-1]] for plan in left]
    blocks = [slice_(plan, depth, name=f"voussoir{i}") for i, plan in enumerate(plans)]
    reach = 1 + thickness - eccentricity
    ground = [
        box((-2 * reach, 0, -0.2), (-0.2, depth, 0), name="left"),
        box((0.2, 0, -0.2), (2 * reach, depth, 0), name="right"),
    ]
    return assembly([*ground, *blocks], supports=[0, 1])


def vertical_arch(n: int, thickness: float, *, foot: float = 0.02, depth: float = 0.5) -> Assembly:
    """A semicircular arch of radius 1 cut by vertical planes that divide the intrados evenly.

    The feet begin where the intrados has risen by `foot` half turns; each stands on the ground in one piece.
    """
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    cuts = -inner * np.cos(math.pi * np.linspace(foot, 1 - foot, n + 1))

    def cut(x):
        return [(x, math.sqrt(r**2 - x**2)) for r in (inner, outer)]

    blocks = [slice_([*cut(a)[::-1], *cut(b)], depth) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]
    turns = np.linspace(0, math.acos(cuts[-1] / outer), 20)
    profile = [cut(cuts[-1])[0], (inner, 0.0), *((outer * math.cos(a), outer * math.sin(a)) for a in turns)]
    m = len(profile)
    for side in (-1, 1):
        corners = [(side * x, y, z) for y in (0.0, depth) for x, z in profile]
        faces = [list(range(m)), list(range(2 * m - 1, m - 1, -1))]
        faces += [[(i + 1) % m, i, m + i, m + (i + 1) % m] for i in range(m)]
        blocks.append(Block(corners, faces if side > 0 else [face[::-1] for face in faces], f"foot{side}"))
    ground = [box((side * 2 - 1.5, 0, -1), (side * 2 + 1.5, depth, 0), name=f"ground{side}") for side in (-1, 1)]
    return assembly([*ground, *blocks], supports=[0, 1])


def barrel_on_piers(
    width: float, height: float, *, radius: float = 2.5, thickness: float = 0.5, n: int = 20
) -> Assembly:
    """A barrel vault one metre long on two piers whose inner faces continue the intrados."""
    inner, outer = radius - thickness / 2, radius + thickness / 2
    blocks = [box((-9, 0, -1), (9, 1, 0), name="ground")]
    for side in (-1, 1):
        low, high = sorted((side * inner, side * (inner + width)))
        blocks.append(box((low, 0, 0), (high, 1, height), name=f"pier{side}"))

    def joint(angle):
        return [(r * math.cos(angle), r * math.sin(angle) + height) for r in (inner, outer)]

    angles = np.linspace(math.pi, 0, n + 1)
    blocks += [slice_([*joint(a)[::-1], *joint(b)], 1.0) for a, b in zip(angles[:-1], angles[1:], strict=True)]
    return assembly(blocks, friction=0.7)


def round_arch(n: int, thickness: float, *, embrace: float = math.pi, lune: bool = False):
    """`arch` with the weights of truly curved voussoirs: the assembly and the masses and centroids of its voussoirs.

    Of annular sectors, or with `lune` of the slices of a hemispherical dome between two meridians and two cones, whose
    meridian sides carry nothing. The joints are those of `arch`; only weights and their lines of action differ.
    """
    asm = arch(n, thickness, embrace=embrace)
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    ends = math.pi / 2 + embrace / 2 - np.linspace(0, embrace, n + 1)
    a, b = ends[1:], ends[:-1]
    if lune:  # weight r^2 |cos a| dr da
        side = np.sign(np.cos((a + b) / 2))
        mass = side * (np.sin(b) - np.sin(a)) * (outer**3 - inner**3) / 3
        x = side * ((b - a) / 2 + (np.sin(2 * b) - np.sin(2 * a)) / 4) * (outer**4 - inner**4) / 4
        z = side * (np.sin(b) ** 2 - np.sin(a) ** 2) / 2 * (outer**4 - inner**4) / 4
    else:  # weight r dr da
        mass = (b - a) * (outer**2 - inner**2) / 2
        x = (np.sin(b) - np.sin(a)) * (outer**3 - inner**3) / 3
        z = (np.cos(a) - np.cos(b)) * (outer**3 - inner**3) / 3
    centroid = asm.centroid.copy()
    total = np.zeros(asm.n_blocks)
    index = [asm.names.index(f"voussoir{i}") for i in range(n)]
    total[index] = mass
    centroid[index, 0], centroid[index, 2] = x / mass, z / mass
    return asm, total, centroid


def weights_instead(asm: Assembly, mass, centroid, acceleration=(0.0, 0.0, -1.0)) -> np.ndarray:
    """Wrenches that take off the blocks' own weight and put on other masses at other places, for `assess(loads=)`."""
    wrench = np.zeros((asm.n_blocks, 6))
    wrench[:, :3] = np.outer(mass, acceleration)
    wrench[:, 3:] = np.cross(centroid - asm.centroid, wrench[:, :3])
    wrench[:, :3] -= np.outer(asm.mass, asm.gravity)
    return wrench
