"""Random scenes of blocks on blocks: piles, towers, sizes, slivers, gaps, corbels, sheets, and supports in mid air."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.fuzz.solids import Array, Solid, box, brick

Random = np.random.Generator
Parts = tuple[list[Solid], list[bool]]


def about_z(angle: float) -> Array:
    """A turn about the vertical."""
    return Rotation.from_euler("z", angle).as_matrix()


def slab() -> Solid:
    """A wide floor, its top at height 0."""
    return box((-8, -8, -1), (8, 8, 0))


def pile(random: Random) -> Parts:
    """Courses of bricks of random length and place on a floor."""
    solids, bottom = [slab()], 0.0
    for _ in range(random.integers(1, 4)):
        height, start = random.choice([0.5, 1.0]), random.uniform(-2, 0)
        for _ in range(random.integers(1, 4)):
            length, y = random.choice([0.5, 1.0, 2.0]), random.choice([0.0, 0.0, 0.5, -0.25])
            solids.append(box((start, y, bottom), (start + length, y + 1, bottom + height)))
            start += length + random.choice([0.0, 0.0, 0.3, 1.0])
        bottom += height
    return solids, [True] + [False] * (len(solids) - 1)


def tower(random: Random) -> Parts:
    """Blocks one above the other, each turned and shifted."""
    solids, bottom = [slab()], 0.0
    for _ in range(random.integers(2, 8)):
        size = random.uniform(0.3, 1.5, 3)
        at = (*random.uniform(-0.3, 0.3, 2), bottom + size[2] / 2)
        solids.append(brick(*size).moved(at, about_z(random.uniform(0, np.pi))))
        bottom += size[2]
    return solids, [True] + [False] * (len(solids) - 1)


def sizes(random: Random) -> Parts:
    """Blocks of sizes 1 to 1,000 in one stack, or feet of a large one.

    A foot of less than a joint's tolerance is a gap that counts as closed, so feet are no smaller than 1 : 30.
    """
    ratio = 10.0 ** random.uniform(0, 3)
    if random.random() < 0.6:
        widths = 10.0 ** -random.uniform(0, np.log10(ratio), random.integers(2, 5))
        widths = np.sort(np.append(widths, 1 / ratio))[::-1].tolist()
        if ratio < 30 and random.random() < 0.5:
            widths = widths[::-1]
        solids, bottom = [slab()], 0.0
        for width in widths:
            at = (*(0.3 * random.uniform(-1, 1, 2) * width), bottom + width / 2)
            solids.append(brick(width, width, width).moved(at))
            bottom += width
        return solids, [True] + [False] * len(widths)
    foot = ratio ** (-0.5)
    places = random.uniform(-0.5 + foot / 2, 0.5 - foot / 2, (random.integers(2, 5), 2))
    feet = [box((x - foot / 2, y - foot / 2, 0), (x + foot / 2, y + foot / 2, foot)) for x, y in _apart(places, foot)]
    solids = [slab(), *feet, box((-0.5, -0.5, foot), (0.5, 0.5, foot + random.uniform(0.2, 1.0)))]
    return solids, [True] + [False] * (len(solids) - 1)


def _apart(places: Array, width: float) -> list[Array]:
    kept: list[Array] = []
    for place in places:
        if all(np.abs(place - other).max() > 1.5 * width for other in kept):
            kept.append(place)
    return kept


def slivers(random: Random) -> Parts:
    """A beam on ledges, one or both as narrow as 1e-9 to 1e-2 of it, but not about the least width of a joint."""
    width = 10.0 ** (random.uniform(-9, -6.7) if random.random() < 0.25 else random.uniform(-5.3, -2))
    solids = [box((-2, -1, -1), (0, 1, 0)), box((2, -1, -1), (4, 1, 0))]
    left = random.choice([0.3, width])
    solids.append(box((-left, -0.5, 0), (2 + width, 0.5, random.uniform(0.2, 1.0))))
    if random.random() < 0.5:
        top = solids[-1].vertices[:, 2].max()
        x = random.uniform(-left, 1.5)
        solids.append(box((x, -0.4, top), (x + 0.5, 0.4, top + 0.5)))
    if random.random() < 0.3:
        solids.append(box((0, -0.5, -0.5), (2, 0.5, -1e-3 if random.random() < 0.5 else -0.2)))
        return solids, [True, True] + [False] * (len(solids) - 2)
    return solids, [True, True] + [False] * (len(solids) - 2)


def gaps(random: Random) -> Parts:
    """A pile whose joints are open by 1e-6 to 3e-3 of a block, or clearly open by more than 2.5e-2."""
    solids, bottom = [slab()], 0.0
    for _ in range(random.integers(1, 4)):
        count, height = random.integers(1, 4), random.uniform(0.4, 1.0)
        start = random.uniform(-1, 0)
        clear = random.random() < 0.08
        bottom += 10.0 ** random.uniform(-6, -3) if not clear else random.uniform(0.04, 0.1)
        for _ in range(count):
            length = random.uniform(0.7, 1.5)
            solids.append(box((start, -0.5, bottom), (start + length, 0.5, bottom + height)))
            start += length + (10.0 ** random.uniform(-6, -3) if random.random() < 0.7 else 0.0)
        bottom += height
    return solids, [True] + [False] * (len(solids) - 1)


def corbels(random: Random) -> Parts:
    """Blocks that lean out step by step, with or without weight on their tails."""
    solids = [box((-4, -1, -1), (0, 1, 0))]
    reach, bottom, step = 0.0, 0.0, random.uniform(0.05, 0.4)
    for _ in range(random.integers(2, 6)):
        reach += step * random.uniform(0.7, 1.3)
        length = random.choice([1.0, 1.0, 1.5])
        solids.append(box((reach - length, -0.5, bottom), (reach, 0.5, bottom + 0.4)))
        if random.random() < 0.5:
            solids.append(box((reach - length - 0.8, -0.5, bottom), (reach - length, 0.5, bottom + 0.4)))
        bottom += 0.4
    return solids, [True] + [False] * (len(solids) - 1)


def sheets(random: Random) -> Parts:
    """A cube on a slip sheet, on pads or on a membrane with a hole, thinner than a joint may be open."""
    thick = float(random.choice([5e-4, 2e-3, 5e-3]))
    solids = [slab()]
    kind = random.integers(3)
    if kind == 0:
        solids.append(box((-0.6, -0.6, 0), (0.6, 0.6, thick)))
    elif kind == 1:
        for x in (-0.5, 0.3):
            solids += [box((x, y, 0), (x + 0.2, y + 0.2, thick)) for y in (-0.5, 0.3)]
    else:
        solids += [box((-0.6, -0.6, 0), (0.1, 0.6, thick)), box((0.1, -0.6, 0), (0.6, 0.6, thick))]
    solids.append(box((-0.5, -0.5, thick), (0.5, 0.5, thick + random.uniform(0.5, 1.5))))
    if random.random() < 0.3:
        top = solids[-1].vertices[:, 2].max()
        solids.append(box((-0.4, -0.4, top), (0.4, 0.4, top + 0.6)))
    return solids, [True] + [False] * (len(solids) - 1)


def thin(solids: list[Solid]) -> tuple[int, ...]:
    """Numbers of the sheets among the solids."""
    return tuple(i for i, solid in enumerate(solids) if np.ptp(solid.vertices[:, 2]) < 0.01)


def midair(random: Random) -> Parts:
    """Supports that hang in the air: beside, above and below blocks, some of which nothing carries."""
    solids, support = [], []
    for _ in range(random.integers(1, 4)):
        x, z = 2 * random.integers(-1, 2), 2.0 * random.integers(0, 2)
        low = np.array([x, -0.5, z], dtype=float)
        if all(np.abs(low - solid.vertices.min(axis=0)).max() > 0.1 for solid in solids):
            solids.append(box(low, low + 1.0))
            support.append(True)
    for _ in range(random.integers(1, 6)):
        low = np.array([random.integers(-2, 4), -0.5, random.integers(-1, 4)], dtype=float)
        low[1] += random.choice([0.0, 0.0, 0.4, -0.3])
        long = np.array([float(random.choice([1.0, 1.0, 2.0, 3.0])), 1.0, 1.0])
        if all(
            (low + long <= s.vertices.min(axis=0) + 1e-9).any() or (low >= s.vertices.max(axis=0) - 1e-9).any()
            for s in solids
        ):
            solids.append(box(low, low + long))
            support.append(False)
    if all(support):
        solids.append(box((-0.5, -0.5, 6), (0.5, 0.5, 7)))
        support.append(False)
    return solids, support
