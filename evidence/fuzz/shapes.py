"""Random scenes of other shapes: rings, keystones, ladders, grooves, ridges, points, crossed keels, concave blocks."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.fuzz.solids import Piece, Solid, box, extruded, hull, separating
from evidence.fuzz.stacks import Parts, Random, about_z, slab

QUARTER = Rotation.from_euler("z", np.pi / 2).as_matrix()


def ring(random: Random) -> Parts:
    """An arch of voussoirs on two supports, or a ring of them that stands on a floor or hangs in a frame."""
    count, inner = int(random.integers(3, 10)), 1.0
    outer = inner + random.uniform(0.05, 0.6)
    if random.random() < 0.3:
        begin, end = -np.pi / 2, 3 * np.pi / 2
    else:
        half = random.uniform(0.2, 0.5) * np.pi
        begin, end = np.pi / 2 - half, np.pi / 2 + half
    angle = np.linspace(begin, end, count + 1)

    def wedge(a: float, b: float) -> Solid:
        corners = [(r * np.cos(t), r * np.sin(t)) for r, t in ((inner, a), (outer, a), (outer, b), (inner, b))]
        return extruded([corners], 0.0, 0.5)

    solids = [wedge(a, b) for a, b in zip(angle[:-1], angle[1:], strict=True)]
    if end - begin > 6:
        low = min(float(solid.vertices[:, 2].min()) for solid in solids)
        frame = [box((-3, -1, low - 1), (3, 1, low))]
        if random.random() < 0.6:
            wide = max(float(solid.vertices[:, 0].max()) for solid in solids)
            frame += [box((wide, -1, low), (3, 1, 2)), box((-3, -1, low), (-wide, 1, 2))]
        return [*frame, *solids], [True] * len(frame) + [False] * count
    step = angle[1] - angle[0]
    return [wedge(begin - step, begin), *solids, wedge(end, end + step)], [True, *[False] * count, True]


def keystone(random: Random) -> Parts:
    """A wedge that hangs between two supports or between wedges, with a block on it or without."""
    lean = random.choice([0.0, 1e-6, 0.05, 0.3, -0.1, random.uniform(-0.2, 0.6)])
    half, height = 0.5, random.uniform(0.5, 1.5)
    low, high = half - lean * height / 2, half + lean * height / 2
    if low < 0.05:
        low = 0.05
    solids, support = [extruded([[(-low, 0), (low, 0), (high, height), (-high, height)]], 0, 1)], [False]
    for side in (-1.0, 1.0):
        cheek = np.array([(low, 0), (2, 0), (2, height), (high, height)])
        points = cheek * [side, 1.0]
        solids.append(extruded([points if side > 0 else points[::-1]], 0, 1))
        support.append(True)
    if random.random() < 0.5:
        solids.append(box((-high, 0.2, height), (high * random.uniform(-0.2, 1), 0.8, height + 0.5)))
        support.append(False)
    return solids, support


def ladder(random: Random) -> Parts:
    """A box that leans with an edge on the floor against a wall, or against a block that may move."""
    length, thick, angle = random.uniform(1.5, 4), random.uniform(0.05, 0.5), np.radians(random.uniform(15, 80))
    x0 = thick * np.sin(angle)
    along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    corners = np.array([(0.0, 0.0), length * along, length * along + thick * up, thick * up])
    wall = float(corners[:, 0].max())
    y0, y1 = 0.0, random.uniform(0.3, 1.0)
    solids = [slab(), box((wall, -2, 0), (wall + 1, 3, 5)), extruded([corners], y0, y1)]
    if random.random() < 0.3:
        solids.append(box((-x0 - 0.5 - 1e-9, 0, 0), (-x0 - 0.2, 1, 0.5)))
    if random.random() < 0.3:
        solids.append(box((random.uniform(0.3, 0.8) * wall, 1.5, 0), (wall, 2.0, 0.5)))
    return solids, [True, bool(random.random() < 0.7)] + [False] * (len(solids) - 2)


def groove(random: Random) -> Parts:
    """A prism of four to eight sides in a V, on its faces or on its edges."""
    beta, sides = np.radians(random.uniform(25, 70)), int(random.choice([4, 6, 8]))
    depth = 2.0
    x, z = depth * np.sin(beta), depth * np.cos(beta)
    # Each piece goes on below the other flank, so that the bottom of the V lies inside the faces of both.
    far = [(x, -x / np.tan(beta))] if x < np.tan(beta) * 3 else [(3 * np.tan(beta), -3.0)]
    left = [(-x, z), (-x, -3.0), *([(x, -3.0)] if far[0][1] > -3 else []), *far]
    right = [(-i, k) for i, k in left[::-1]]
    mouth = [(0, 0), (-x, z), (-x, -3.0), (x, -3.0), (x, z)]
    valley = extruded([left, right], -2, 2, outline=mouth)
    around = random.choice([0.0, np.pi / sides, random.uniform(0, 2 * np.pi)])
    turn = np.pi / 2 - beta if random.random() < 0.4 else 0.0
    corners = 0.5 * np.stack(
        [np.cos(around + turn + 2 * np.pi * np.arange(sides) / sides),
         np.sin(around + turn + 2 * np.pi * np.arange(sides) / sides)], axis=1,
    )  # fmt: skip
    # Lower and shift it until it touches both flanks: its support along both inner normals is zero.
    normals = np.array([[np.cos(beta), np.sin(beta)], [-np.cos(beta), np.sin(beta)]])
    corners = corners - np.linalg.solve(normals, (corners @ normals.T).min(axis=0))
    solids = [valley, extruded([corners], -0.5, random.uniform(0.2, 1.0))]
    top = float(corners[:, 1].max())
    tilted = ((corners[:, 1] < top - 1e-9) & (corners[:, 1] > top - 0.1)).any()
    if random.random() < 0.3 and not tilted:  # a top that is all but level is a question of tolerance
        x = float(corners[corners[:, 1] > top - 1e-9, 0].mean())
        solids.append(box((x - 0.2, -0.3, top), (x + random.uniform(0.1, 0.3), 0.1, top + 0.3)))
    return solids, [True] + [False] * (len(solids) - 1)


def _ridge(x: float, half: float, y0: float, y1: float, *, base: float = -1.0, top: float = 0.0) -> Solid:
    """A post of which the top is a ridge along y."""
    return extruded(
        [[(x - half, base), (x + half, base), (x + half, top - half), (x, top), (x - half, top - half)]], y0, y1
    )


def ridges(random: Random) -> Parts:
    """A block on one to three ridged posts, a part of which stand across, free or fixed."""
    solids = [box((-4, -4, -2), (4, 4, -1))]
    places = random.choice([1, 2, 2, 3])
    for x in [-0.3] if places == 1 else np.linspace(-0.4, random.uniform(0.2, 0.6), places):
        solids.append(_ridge(float(x), 0.08, *sorted(random.uniform(-0.6, 0.6, 2) + [-0.05, 0.05])))
    posts = len(solids)
    low = np.array([random.uniform(-1.0, -0.3), random.uniform(-0.6, -0.2), 0.0])
    solids.append(box(low, low + random.uniform(0.6, 1.5, 3)))
    if random.random() < 0.4:
        top = float(solids[-1].vertices[:, 2].max())
        middle = solids[-1].centroid
        solids.append(box((middle[0] - 0.2, middle[1] - 0.2, top), (middle[0] + 0.3, middle[1] + 0.2, top + 0.4)))
    fixed = random.random() < 0.7
    return solids, [True] + [bool(fixed)] * (posts - 1) + [False] * (len(solids) - posts)


def keels(random: Random) -> Parts:
    """A body with two keels along y on ridges along x: edge across edge."""
    a, c, keel = random.uniform(0.15, 0.4), random.uniform(0.15, 0.6), 0.1
    angle = random.choice([0.0, random.uniform(-0.6, 0.6)])
    count = int(random.choice([1, 2, 2, 2]))
    solids = [box((-4, -4, -2), (4, 4, -1))]
    for y in [0.0] if count == 1 else (-c, c):
        solids.append(_ridge(y, 0.1, -1.5, 1.5).moved((0, 0, 0), QUARTER))
    under = random.choice([1, 2, 2])
    feet = [0.0] if under == 1 else [-a, a]
    top, length = random.uniform(0.3, 1.2), random.uniform(0.5, 1.0)
    plate = [(-0.5, keel), (0.5, keel), (0.5, top), (-0.5, top)]
    wedges = [[(x - keel, keel), (x, 0.0), (x + keel, keel)] for x in feet]
    outline = [(-0.5, keel), *[p for w in wedges for p in w], (0.5, keel), (0.5, top), (-0.5, top)]
    body = extruded([plate, *wedges], -length, length, outline=outline)
    solids.append(body.moved((*random.uniform(-0.1, 0.1, 2), 0.0), about_z(angle)))
    return solids, [True] * (1 + count) + [False]


def points(random: Random) -> Parts:
    """A block with three or four points below it on a floor, on a slab that carries another, or on posts."""
    count, base = int(random.choice([3, 3, 4])), random.uniform(0.3, 0.6)
    angle = 2 * np.pi * np.arange(count) / count + random.uniform(0, 1)
    body = np.stack([base * np.cos(angle), base * np.sin(angle), np.zeros(count)], axis=1)
    tip = np.array([*random.uniform(-0.4, 0.4, 2), random.uniform(0.4, 1.2)])
    if random.random() < 0.5:  # points on the floor: the base between them is pushed in
        centre = np.array([0.0, 0.0, random.uniform(0.02, 0.2)])
        pieces = tuple(np.array([body[i], body[(i + 1) % count], centre, tip]) for i in range(count))
        corners = np.array([*body, centre, tip])
        faces = [(i, (i + 1) % count, count + 1) for i in range(count)]
        faces += [((i + 1) % count, i, count) for i in range(count)]
        return [slab(), Solid(corners, tuple(faces), pieces)], [True, False]
    solids = [box((-4, -4, -2), (4, 4, -1))]
    posts = random.uniform(-0.6, 0.6, (int(random.integers(3, 5)), 2))
    kept = [p for i, p in enumerate(posts) if all(np.abs(p - q).max() > 0.25 for q in posts[:i])]
    for x, y in kept:
        foot = np.array(
            [(x - 0.1, y - 0.1, -1), (x + 0.1, y - 0.1, -1), (x + 0.1, y + 0.1, -1), (x - 0.1, y + 0.1, -1)]
        )
        solids.append(hull(np.array([*foot, (x, y, 0.0)])))
    low = random.uniform(-0.7, -0.4, 2)
    solids.append(box((*low, 0.0), (*(low + random.uniform(0.9, 1.3, 2)), random.uniform(0.2, 0.8))))
    return solids, [True, *[True] * len(kept), False]


def corner(random: Random) -> Parts:
    """An octahedron or a cube in a corner of three planes, its axis vertical."""
    down = Rotation.align_vectors([[0, 0, 1]], [[1, 1, 1]])[0].as_matrix()
    floor = [box((0, 0, -1), (4, 4, 0)), box((0, -1, 0), (4, 0, 4)), box((-1, 0, 0), (0, 4, 4))]
    kind = random.integers(3)
    if kind == 0:
        # Three vertices of it lie on the three planes, at distance r of their common corner's axis.
        r = 0.5
        shape = hull(np.array([*(r * np.eye(3)), *(-r * np.eye(3))])).moved((r, r, r))
    elif kind == 1:
        shape = box((0, 0, 0), (1, random.uniform(0.5, 1), random.uniform(0.5, 1)))
    else:
        cloud = random.uniform(0, 1, (8, 3))
        shape = hull(cloud - cloud.min(axis=0))
    return [solid.moved((0, 0, 0), down) for solid in (*floor, shape)], [True, True, True, False]


def wedge(random: Random) -> Parts:
    """Blocks on a slope, and wedges below blocks."""
    slope = np.radians(random.uniform(5, 50))
    base = extruded([[(0, 0), (3, 0), (3, 3 * np.tan(slope))]], -1, 1)
    turn = Rotation.from_euler("y", -slope).as_matrix()
    length, height = random.uniform(0.3, 1.0), random.uniform(0.2, 1.5)
    start = random.uniform(0.3, 3 / np.cos(slope) - length)
    solids = [base, box((start, -0.4, 0), (start + length, 0.4, height)).moved((0, 0, 0), turn)]
    if random.random() < 0.5:
        solids.append(
            box((start + 0.1 * length, -0.3, height), (start + length, 0.3, height + 0.4)).moved((0, 0, 0), turn)
        )
    if random.random() < 0.3:
        solids.append(box((start - 0.25, -0.4, 0), (start, 0.4, 0.3)).moved((0, 0, 0), turn))
    if random.random() < 0.4:
        return [slab().moved((0, 0, 0)), *solids], [True] + [False] * len(solids)
    return solids, [True] + [False] * (len(solids) - 1)


def heap(random: Random) -> Parts:
    """Convex blocks of four to eight corners, let down one after the other until they touch what is below them."""
    base = [slab(), box((-1, -2, 0), (0, 2, random.uniform(0.1, 1)))]
    base.append(extruded([[(0, 0), (1, 0), (1, random.uniform(0.1, 1))]], -2, 2))
    solids = base[: random.integers(1, 4)]
    fixed = len(solids)
    for _ in range(random.integers(1, 6)):
        if random.random() < 0.5:
            shape = hull(random.uniform(-0.4, 0.4, (int(random.integers(4, 9)), 3)))
        else:
            turn = about_z(random.uniform(0, 3)) if random.random() < 0.5 else Rotation.random(random_state=random)
            turn = turn if isinstance(turn, np.ndarray) else turn.as_matrix()
            half = random.uniform(0.1, 0.5, 3)
            shape = box(-half, half).moved(turn=turn)
        shape = shape.moved((*random.uniform(-0.6, 0.6, 2), 0.0))
        solids.append(shape.moved((0, 0, max(_height(shape, below) for below in solids))))
    return solids, [True] * fixed + [False] * (len(solids) - fixed)


def _height(shape: Solid, below: Solid) -> float:
    """How far a convex solid is raised when it comes down on another; -inf beside it."""
    axes = separating(Piece.of(below.pieces[0]), Piece.of(shape.pieces[0]))
    gap = (shape.pieces[0] @ axes.T).min(axis=0) - (below.pieces[0] @ axes.T).max(axis=0)
    level, rising = np.abs(axes[:, 2]) < 1e-9, axes[:, 2] >= 1e-9
    if (gap[level] >= 0).any():
        return -np.inf
    return float((-gap[rising] / axes[rising, 2]).min())


def concave(random: Random) -> Parts:
    """T, L, U and hooked blocks on walls, floors and on one another."""
    return [hook, nested, tees, stepped][random.integers(4)](random)


def profile(kind: str, w: float, h: float, t: float) -> Solid:
    """An L, T or U of width w, height h and thickness t; its pieces overlap in its corners."""
    rect = lambda x0, z0, x1, z1: [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]  # noqa: E731
    if kind == "L":
        pieces = [rect(0, 0, w, t), rect(0, 0, t, h)]
        outline = [(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)]
    elif kind == "T":
        m = (w - t) / 2
        pieces = [rect(m, 0, m + t, h), rect(0, h - t, w, h)]
        outline = [(m, 0), (m + t, 0), (m + t, h - t), (w, h - t), (w, h), (0, h), (0, h - t), (m, h - t)]
    else:
        pieces = [rect(0, 0, w, t), rect(0, 0, t, h), rect(w - t, 0, w, h)]
        outline = [(0, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0, h)]
    return extruded(pieces, 0, 0.6, outline=outline)


def hook(random: Random) -> Parts:
    """A hook over the edge of a wall, with a load in it or not."""
    t, w, h = random.uniform(0.1, 0.3), random.uniform(0.5, 1.5), random.uniform(0.6, 1.5)
    flip = Rotation.from_euler("y", np.pi).as_matrix()
    piece = profile("L", w, h, t).moved((0, 0, 0), flip).moved((t, 0, t))  # hangs along x in (0, t), lies on x < 0
    solids = [box((-3, -1, -3), (0, 2, 0)), piece]
    if random.random() < 0.5:
        x = random.uniform(t - w, -0.2)
        solids.append(box((x, 0.1, t), (x + 0.4, 0.5, t + 0.4)))
    return solids, [True] + [False] * (len(solids) - 1)


def nested(random: Random) -> Parts:
    """A block in or on a U, that stands or lies upside down."""
    t, w, h = random.uniform(0.1, 0.3), random.uniform(0.8, 1.5), random.uniform(0.4, 1.2)
    solids = [slab(), profile("U", w, h, t)]
    kind = random.integers(3)
    if kind == 0:
        half = Rotation.from_euler("y", np.pi).as_matrix()
        solids[1] = solids[1].moved((0, 0, 0), half).moved((w, 0, h))
        solids.append(box((random.uniform(-0.4, 0.4), 0, h), (random.uniform(0.5, w), 0.5, h + 0.5)))
    elif kind == 1:
        x = random.choice([t, random.uniform(t, w - t - 0.2)])
        right = random.choice([w - t, x + 0.15])
        solids.append(box((x, 0.1, t), (right, 0.5, t + random.uniform(0.2, 2.0))))
    else:
        x = random.uniform(-0.3, 0.3)
        solids.append(box((x, 0, h), (x + random.uniform(w - 0.4, w), 0.5, h + 0.5)))
    return solids, [True, False, False]


def tees(random: Random) -> Parts:
    """A T that stands on its stem or hangs by its bar between two walls, with a load at one side."""
    t, w, h = random.uniform(0.15, 0.3), random.uniform(0.8, 1.5), random.uniform(0.6, 1.2)
    tee = profile("T", w, h, t)
    m = (w - t) / 2
    if random.random() < 0.5:
        solids, support = [slab(), tee], [True, False]
    else:
        inner = random.uniform(0.0, 0.8 * m)
        walls = [
            box((inner - 2, -1, -1), (inner, 2, h - t)),
            box((w - random.uniform(0.0, 0.8 * m), -1, -1), (w + 2, 2, h - t)),
        ]
        solids, support = [*walls, tee], [True, random.random() < 0.8, False]
    if random.random() < 0.6:
        x = random.uniform(-0.1, w - 0.3)
        solids.append(box((x, 0, h), (x + 0.4, 0.5, h + 0.3)))
        support.append(False)
    return solids, support


def stepped(random: Random) -> Parts:
    """Blocks on the steps of a stair, and against them."""
    rise, count = random.uniform(0.3, 0.6), 3
    heights = rise * np.arange(1, count + 1)
    pieces = [[(i, 0), (count, 0), (count, z), (i, z)] for i, z in enumerate(heights)]
    outline = [(0, 0), (count, 0)]
    for i in reversed(range(count)):
        outline += [(i + 1, heights[i]), (i, heights[i])]
    solids = [extruded(pieces, -1, 1, outline=outline)]
    for i in range(count - 1):
        if random.random() < 0.8:
            right = i + 1 if random.random() < 0.5 else i + random.uniform(0.6, 0.95)
            left = i + random.uniform(-0.5, 0.4)
            solids.append(box((left, -0.4, heights[i]), (right, 0.4, heights[i] + random.choice([0.2, 1.0]) * rise)))
    if len(solids) == 1:
        solids.append(box((0.5, -0.3, heights[0]), (1, 0.3, heights[0] + 0.5)))
    return solids, [True] + [False] * (len(solids) - 1)
