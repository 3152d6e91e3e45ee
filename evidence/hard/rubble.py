"""Rubble: irregular polyhedra that fill a trough or stand free, and what the judge of the random scenes says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull, Voronoi
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block
from evidence.fuzz.judge import Judgement, judge
from evidence.fuzz.limits import SIDES, carried
from evidence.fuzz.programs import Points
from evidence.fuzz.scene import Place, Scene
from evidence.fuzz.solids import Array, Solid, box, hull
from evidence.hard.cases import STABLE, UNSTABLE, Case, pushed
from evidence.hard.figures import Figure, Section, limit
from evidence.hard.places import UTM

TROUGH = np.array([1.5, 1.0, 1.2])  #: sides of what is filled [m]
WALL = np.array([2.0, 0.5, 1.5])  #: sides of what stands free [m]
THICK = 0.3  #: of the sides of the trough [m]
POLYGONS = 1e-3  #: by how much what the judge's polygons of 64 sides carry may differ from what cones carry


def cells(seed: int, number: int, sides: Array) -> list[Solid]:
    """Voronoi cells of random points in a box: their mirror images in its faces close those at the rim."""
    points = np.random.default_rng(seed).uniform(0, 1, (number, 3)) * sides
    images = [points]
    for axis in range(3):
        for face in (0.0, sides[axis]):
            image = points.copy()
            image[:, axis] = 2 * face - image[:, axis]
            images.append(image)
    found = Voronoi(np.concatenate(images))
    return [hull(np.clip(found.vertices[found.regions[found.point_region[i]]], 0, sides)) for i in range(number)]


def slices(seed: int, number: int, sides: Array) -> list[Solid]:
    """Pieces of a box, the largest of which is cut by a random plane again and again: corners meet on faces."""
    random, pieces = np.random.default_rng(seed), [box((0, 0, 0), sides.tolist()).vertices]
    while len(pieces) < number:
        largest = int(np.argmax([ConvexHull(piece).volume for piece in pieces]))
        piece, normal = pieces.pop(largest), random.normal(size=3)
        pieces += [_below(piece, sign * normal / np.linalg.norm(normal)) for sign in (1, -1)]
    return [hull(piece) for piece in pieces]


def _below(corners: Array, normal: Array) -> Array:
    """The corners of what lies below a plane through the middle of a convex piece."""
    height = (corners - corners.mean(axis=0)) @ normal
    triangles = ConvexHull(corners).simplices
    edges = {tuple(sorted(t[[i, j]].tolist())) for t in triangles for i, j in ((0, 1), (1, 2), (2, 0))}
    cut = [
        corners[i] + (corners[j] - corners[i]) * height[i] / (height[i] - height[j])
        for i, j in edges
        if height[i] * height[j] < 0
    ]
    kept = np.concatenate([corners[height <= 0], cut])
    return kept[np.unique(ConvexHull(kept).vertices)]


def in_a_trough(stones: list[Solid], *, closed: bool = True) -> Assembly:
    """Stones without friction that fill a trough up to its rim; it is open at its right end unless closed."""
    (x, y, z), t = TROUGH, THICK
    sides = [box((-t, -t, -t), (x + t, y + t, 0)), box((-t, -t, 0), (0, y + t, z))]
    sides += [box((0, -t, 0), (x, 0, z)), box((0, y, 0), (x, y + t, z))]
    sides += [box((x, -t, 0), (x + t, y + t, z))] if closed else []
    blocks = [Block(solid.vertices, solid.faces, name=f"side{k}") for k, solid in enumerate(sides)]
    blocks += [Block(stone.vertices, stone.faces, name=f"stone{k}") for k, stone in enumerate(stones)]
    supports = list(range(len(sides)))
    return Assembly.from_blocks(blocks, supports=supports, density=1.0, gravity=(0, 0, -1), friction=0.0)


@dataclass(frozen=True)
class Heap:
    """A wall of Voronoi cells on a floor, perhaps with open joints, and what the judge knows of it."""

    seed: int
    stones: int = 15
    friction: float = 0.6
    shrunk: float = 0.0  #: by how much of itself each stone is smaller than its cell

    def scene(self) -> Scene:
        """For the judge."""
        stones = [
            replace(
                stone,
                vertices=(small := stone.centroid + (1 - self.shrunk) * (stone.vertices - stone.centroid)),
                pieces=(small,),
            )
            for stone in cells(self.seed, self.stones, WALL)
        ]
        solids = (box((-3, -3, -1), (5, 4, 0)), *stones)
        support = (True, *[False] * self.stones)
        return Scene("rubble", solids, support, (1.0,) * len(solids), self.friction, np.array([0.0, 0.0, -1.0]))

    def assembly(self) -> Assembly:
        """For the statics."""
        return self.scene().assembly(Place())

    def judgement(self) -> Judgement:
        """Whether it stands, by the judge."""
        return judge(self.scene())

    def carries(self) -> float:
        """The largest push to the right, in weights: between what friction polygons in and about the cones carry."""
        scene, push = self.scene(), np.array([1.0, 0.0, 0.0])
        points = Points.of(scene, [touch for touch in judge(scene).touches if touch.certain])
        around = 2 * np.pi * np.arange(SIDES) / SIDES
        points = replace(points, angles=(around,) * len(points.point))
        inner, outer = (carried(points, push, outer=about) for about in (False, True))
        assert 0 <= outer - inner <= 2 * POLYGONS * inner
        return (inner + outer) / 2


def far(make: Callable[[], Assembly]) -> Callable[[], Assembly]:
    """A scene turned about all axes and moved to UTM coordinates."""

    def made() -> Assembly:
        asm, turn = make(), Rotation.from_euler("xyz", (0.3, 0.7, 1.1)).as_matrix()
        return asm.with_(vertices=asm.vertices @ turn.T + UTM, gravity=turn @ asm.gravity)

    return made


FILLS = (("Voronoi cells", cells, (30, 100, 300)), ("slices", slices, (30, 100)))
#: Walls with the word of the judge.
STANDS = (Heap(2), Heap(3), Heap(0, shrunk=1e-3, friction=0.9), Heap(5, friction=0.8))
FALLS = (Heap(0), Heap(6), Heap(8, shrunk=1e-3), Heap(9, friction=1.0))
PUSHED = tuple(Heap(seed) for seed in (2, 3, 4, 5))


def named(heap: Heap) -> str:
    """A wall in words."""
    gaps = f", {heap.shrunk:.0e} smaller than their cells" if heap.shrunk else ""
    return f"wall of {heap.stones} stones{gaps}, mu {heap.friction:g}, seed {heap.seed}"


CASES = (
    *(
        Case("in a trough", f"{number} {kind} without friction",
             lambda fill=fill, number=number: in_a_trough(fill(0, number, TROUGH)), STABLE, "hydrostatic pressure")
        for kind, fill, numbers in FILLS for number in numbers
    ),
    *(
        Case("in a trough", f"30 {kind}, turned at UTM coordinates",
             far(lambda fill=fill: in_a_trough(fill(0, 30, TROUGH))), STABLE, "hydrostatic pressure")
        for kind, fill, _ in FILLS
    ),
    *(
        Case("in a trough", f"30 {kind}, one end open, pushed out by {push:.0e} of their weight",
             pushed(lambda fill=fill: in_a_trough(fill(0, 30, TROUGH), closed=False), push), UNSTABLE,
             "nothing holds them along the floor")
        for kind, fill, _ in FILLS for push in (1e-6,)
    ),
    *(
        Case("free-standing", named(heap), heap.assembly, right, "the judge")
        for heaps, right in ((STANDS, STABLE), (FALLS, UNSTABLE)) for heap in heaps
    ),
    *(
        Case("free-standing", f"{named(heap)}, turned at UTM coordinates", far(heap.assembly), right, "the judge")
        for heap, right in ((STANDS[0], STABLE), (FALLS[0], UNSTABLE))
    ),
)  # fmt: skip
FIGURES = (
    *(
        Figure(f"{number} {kind} in a trough, pulled up",
               limit(lambda fill=fill, number=number: in_a_trough(fill(0, number, TROUGH)), (0, 0, 1)), 1.0,
               "up to their weight")
        for kind, fill, numbers in FILLS for number in numbers[1:2]
    ),
    *(
        Figure(f"{named(heap)}: limit of a push", limit(heap.assembly, (1, 0, 0)), heap.carries,
               "the judge's linear programs", POLYGONS, slow=True)
        for heap in PUSHED
    ),
)  # fmt: skip
SECTION = Section(
    "Rubble",
    """Stones of any shape that fill a trough up to a level rim stand without any friction: the pressure of a liquid of
their density balances each of them (Archimedes), and a pressure that grows evenly over a face is a sum of forces at
its corners. Pulled up, they follow as soon as the pull is their weight. With one end of the trough open, the smallest
push towards it is balanced by nothing. Free-standing walls of Voronoi cells have no closed form. The truth about them
is that of the judge of the [random scenes](fuzz.md), which finds contacts by separating axes and solves linear
programs. What polygons in the friction cones and about them carry holds the limit of a push to 1e-3.""",
    CASES,
    FIGURES,
)
