"""Blocks on edges and corners with exact limits: each with a direction of push and the acceleration it carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat import Assembly, Block
from evidence.scenes.small import assembly, box


@dataclass(frozen=True)
class Pushed:
    """An assembly, a horizontal direction, and the acceleration [g] along it up to which it stands."""

    name: str
    scene: Assembly
    direction: tuple[float, float, float]
    limit: float
    along_groove: bool = False  #: Bullet's pyramid of friction holds more

    def at(self, share: float) -> Assembly:
        """The scene under this share of its limit, as tilted gravity."""
        g = self.scene.gravity
        push = share * self.limit * np.linalg.norm(g) * np.array(self.direction)
        return self.scene.with_(gravity=g + push)


def prism(outline, y0: float, y1: float, **options) -> Block:
    """A polygon in the plane x, z, counter-clockwise seen from -y, drawn out along y."""
    n = len(outline)
    front, back = [(x, y0, z) for x, z in outline], [(x, y1, z) for x, z in outline]
    sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    ends = [list(range(n)), list(range(2 * n - 1, n - 1, -1))]
    return Block(np.array(front + back), ends + sides, **options)


def turned(block: Block, rotation, shift=(0.0, 0.0, 0.0), **options) -> Block:
    """A block turned about the origin and shifted."""
    return Block(np.asarray(block.vertices) @ np.asarray(rotation).T + shift, block.faces, **options)


FLOOR = box((-5, -5, -1), (5, 5, 0), name="floor")


def tetrahedron(depth: float, mu: float, over: str = "side") -> Pushed:
    """A regular tetrahedron of edge 1 whose base is pushed in to a point at some height: three vertices on a floor."""
    rho = 1 / np.sqrt(3)
    base = [(rho * np.cos(a), rho * np.sin(a), 0.0) for a in np.deg2rad((0, 120, 240))]
    corners = np.array([*base, (0, 0, np.sqrt(2 / 3)), (0, 0, depth)])
    below = [[1, 0, 4], [2, 1, 4], [0, 2, 4]] if depth else [[2, 1, 0]]
    block = Block(corners if depth else corners[:4], [[0, 1, 3], [1, 2, 3], [2, 0, 3], *below], name="tetrahedron")
    centroid = (np.sqrt(2 / 3) + depth) / 4
    sign, delta = (-1.0, 0.0) if over == "side" else (1.0, np.pi / 3)
    limit = min(mu, rho / (2 * centroid * np.cos(delta)))
    name = f"tetrahedron, base in by {depth:g}, over a {over}, mu {mu:g}"
    return Pushed(name, assembly([FLOOR, block], friction=mu), (sign, 0, 0), limit)


def two_ridges(offset: float, mu: float, direction) -> Pushed:
    """A box on two ridges along y."""
    c, b, d, h = 0.3, 1.0, 0.8, 1.2
    ridges = [
        prism([(x - 0.6, -1.2), (x + 0.6, -1.2), (x, 0)], -0.6, 0.6, name=f"ridge{k}") for k, x in enumerate((-c, c))
    ]
    block = box((offset - b / 2, -d / 2, 0), (offset + b / 2, d / 2, h), name="box")
    scene = assembly([*ridges, block], supports=[0, 1], friction=mu)
    limit = {(1, 0): 2 * (c - offset) / h, (-1, 0): 2 * (c + offset) / h, (0, 1): d / h}[direction]
    name = f"box on two ridges, centroid at {offset:g}, towards {direction}, mu {mu:g}"
    return Pushed(name, scene, (*direction, 0), min(mu, limit))


def crossed_keels(psi: float, mu: float = 1.0) -> Pushed:
    """A body with two keels along y across two fixed ridges along x; its centroid is about 0.5 above their edges."""
    a, c, half = 0.2, 0.35, 0.5
    keels = [(-a - 0.1, 0.15), (-a, 0), (-a + 0.1, 0.15), (a - 0.1, 0.15), (a, 0), (a + 0.1, 0.15)]
    body = prism([(-half, 0.15), *keels, (half, 0.15), (half, 0.85), (-half, 0.85)], -half, half, name="body")
    turn = np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)])
    ridge = prism([(-0.1, -0.3), (0.1, -0.3), (0, 0)], -1, 1)
    ridges = [turned(ridge, turn, (0, y, 0), name=f"ridge{k}") for k, y in enumerate((-c, c))]
    scene = assembly([*ridges, body], supports=[0, 1], friction=mu)
    z = float(scene.centroid[2, 2])
    cosine, sine = np.abs((np.cos(psi), np.sin(psi)))
    limit = min(mu, *(reach / (z * part) for reach, part in ((a, cosine), (c, sine)) if part > 1e-9))
    return Pushed(f"crossed keels, towards {np.rad2deg(psi):g} deg", scene, (np.cos(psi), np.sin(psi), 0), limit)


def ladder(mu: float, slope: float = np.pi / 3) -> Pushed:
    """A plank against a wall, on a floor: underside edges touch, pushed away from the wall."""
    length, t = 4.0, 0.2
    s, c = np.sin(slope), np.cos(slope)
    foot = np.array([(0, 0), (-length * c, length * s), (-length * c + t * s, length * s + t * c), (t * s, t * c)])
    plank = prism(foot[[0, 3, 2, 1]], -0.5, 0.5, name="plank")
    wall = box((-length * c - 1, -2, 0), (-length * c, 2, 6), name="wall")
    scene = assembly([FLOOR, wall, plank], supports=[0, 1], friction=mu)
    arm = length * (s + mu * c) / (1 + mu**2)
    x, z = (length * c - t * s) / 2, (length * s + t * c) / 2
    return Pushed(f"ladder at 60 deg, mu {mu:g}", scene, (1, 0, 0), min((mu * arm - x) / (arm - z), x / z))


def prism_in_groove(mu: float, direction: str, beta: float = np.pi / 4) -> Pushed:
    """An octagonal prism with two of its edges on the flanks of a V of half angle beta; along it with Coulomb's law."""
    r = 0.5
    octagon = [(r * np.cos(a), r * np.sin(a)) for a in np.arange(8) * np.pi / 4]
    apex = np.array((0.0, -r / np.sin(beta)))
    up, out = np.array((np.sin(beta), np.cos(beta))), np.array((np.cos(beta), -np.sin(beta)))
    right = [apex, apex + 0.8 * out, apex + 0.8 * out + 2 * up, apex + 2 * up]
    left = [(-x, z) for x, z in right][::-1]
    flanks = [prism(side, -2, 2, name=name) for side, name in ((right, "right"), (left, "left"))]
    scene = assembly([*flanks, prism(octagon, -0.6, 0.6, name="prism")], supports=[0, 1], friction=mu)
    if direction == "across":
        return Pushed(f"octagonal prism in a V, across, mu {mu:g}", scene, (1, 0, 0), 1 / np.tan(beta))
    return Pushed(f"octagonal prism in a V, along, mu {mu:g}", scene, (0, 1, 0), mu / np.sin(beta), True)


def octahedron_in_corner(mu: float, towards: float = 1.0) -> Pushed:
    """An octahedron with three vertices on three faces at right angles, axis vertical, pushed towards a face."""
    r = 0.5
    ends = np.concatenate([r * np.eye(3), -r * np.eye(3)]) + r
    faces = [[0, 1, 2], [1, 0, 5], [2, 1, 3], [0, 2, 4], [4, 3, 5], [3, 4, 2], [5, 3, 1], [4, 5, 0]]
    low, high = -0.5, 2.0
    slabs = []
    for axis in range(3):
        lower, upper = np.full(3, 0.0), np.full(3, high)
        lower[axis], upper[axis] = low, 0.0
        slabs.append(box(lower, upper, name=f"slab{axis}"))
    down = -np.ones(3) / np.sqrt(3)
    scene = assembly(
        [*slabs, Block(ends, faces, name="octahedron")], supports=[0, 1, 2], friction=mu, gravity=tuple(down)
    )
    normal = np.array((1.0, 0, 0)) - down * down[0]
    push = -towards * normal / np.linalg.norm(normal)
    name = f"octahedron in a corner, {'towards' if towards > 0 else 'away from'} a face, mu {mu:g}"
    return Pushed(name, scene, tuple(push.tolist()), np.sqrt(0.5) if towards < 0 else np.sqrt(2.0))


def references() -> list[Pushed]:
    """Every scene of this module with a limit by push."""
    return [
        *(tetrahedron(depth, 3.0, over) for depth in (0.0, 0.1) for over in ("side", "vertex")),
        tetrahedron(0.1, 0.5),
        *(two_ridges(e, 0.8, way) for e in (0.0, 0.1) for way in ((1, 0), (-1, 0), (0, 1))),
        two_ridges(0.0, 0.4, (1, 0)),
        *(crossed_keels(np.deg2rad(psi)) for psi in (0, 30, 60, 90)),
        *(ladder(mu) for mu in (0.5, 0.7)),
        *(prism_in_groove(mu, way) for mu in (0.2, 0.5) for way in ("across", "along")),
        *(octahedron_in_corner(mu, way) for mu in (0.1, 0.3) for way in (1.0, -1.0)),
    ]
