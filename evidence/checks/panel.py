"""Wall W1 of Ferris & Tin-Loi in its plane: its capacity curve beside one by linear programs, and a published one.

    python -m evidence.checks.panel [--step M] [--draws N] [--json] [--write FILE]

The published curve is a figure of a program that others have made after Portioli et al. (2021). From its source: head
joints without friction, a linear program a step of 10 mm of the top right corner, and normals of joints that stay those
of rest. The scheme is written here anew, in the plane and with nothing of blockstat but the numbers of the wall:

    min -w'u    subject to    l'u = 1,    g + N u - mu |T u| >= 0,

g the gaps at the corners of the blocks, N u and T u how fast they open and slip. The pose moves on along u by the step.
It is run with the normals of rest, as published, and with normals that turn with the blocks, as they do. Several
motions have nearly the same work. Which one is taken hangs on less than can be known of a wall, so the programs with
turning normals are run several times, with the weight of each brick changed at random by 1e-6 of it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from blockstat import CapacityCurve, capacity
from blockstat.large_displacement.displaced.pose import displaced_points
from blockstat.typing import Floats
from evidence import results
from evidence.references.walls import wall
from evidence.tables import table

#: Displacement of the top right corner [m] and multiplier, read off the figure.
PUBLISHED = ((0.05, 0.571), (0.1, 0.491), (0.15, 0.406), (0.2, 0.314), (0.25, 0.222))
#: The wall: half a brick [m], height of a course [m], half bricks a course, courses, friction.
HALF, HEIGHT, HALVES, COURSES, FRICTION = 0.2, 0.175, 10, 6, 0.65
#: Change of the weights, relative; where the curves are compared, and where the programs stop [m].
NOISE = 1e-6
PLACES, END = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25), 0.27
Joint = tuple[int, int, tuple[float, float], tuple[float, float], bool]


def bricks() -> list[tuple[int, int, int]]:
    """Course from the top, first and last half brick of each."""
    whole = [(2 * k, 2 * k + 2) for k in range(HALVES // 2)]
    bonded = [(0, 1), *((2 * k + 1, 2 * k + 3) for k in range(HALVES // 2 - 1)), (HALVES - 1, HALVES)]
    return [(course, *ends) for course in range(COURSES) for ends in (bonded if course % 2 else whole)]


def joints(found: list[tuple[int, int, int]]) -> Iterator[Joint]:
    """The brick above or to the right, the other or -1 for the ground, both ends in the plane, and whether it is a bed.

    Bed joints are half a brick long: the published bricks have a corner in the middle too.
    """
    for i, (course, left, right) in enumerate(found):
        bottom = (COURSES - 1 - course) * HEIGHT
        if course == COURSES - 1:
            yield from ((i, -1, (k * HALF, 0.0), ((k + 1) * HALF, 0.0), True) for k in range(left, right))
        for j, (other, first, last) in enumerate(found):
            if other == course + 1:
                for k in range(max(left, first), min(right, last)):
                    yield i, j, (k * HALF, bottom), ((k + 1) * HALF, bottom), True
            if other == course and first == right:
                yield j, i, (right * HALF, bottom), (right * HALF, bottom + HEIGHT), False


@dataclass(frozen=True)
class Panel:
    """The wall, and how its joints are taken."""

    head_friction: float
    turning: bool  #: whether normals turn with the blocks
    seed: int | None = None  #: of the changes of weight; none for None

    def rows(self, pose: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Rates of opening and of slip times friction, gaps, all shape (n, ...), and the rate of the corner."""
        found = bricks()
        centre = np.array([((a + b) / 2 * HALF, (COURSES - c - 0.5) * HEIGHT) for c, a, b in found])

        def turn(body: int) -> Floats:
            c, s = (1.0, 0.0) if body < 0 else (np.cos(pose[body, 2]), np.sin(pose[body, 2]))
            return np.array([[c, -s], [s, c]])

        def place(body: int, point: tuple[float, float]) -> Floats:
            if body < 0:
                return np.array(point)
            return centre[body] + pose[body, :2] + turn(body) @ (np.array(point) - centre[body])

        def rate(body: int, point: Floats, along: Floats) -> Floats:
            row = np.zeros((len(found), 3))
            if body >= 0:
                x, z = point - centre[body] - pose[body, :2]
                row[body] = along[0], along[1], x * along[1] - z * along[0]
            return row.reshape(-1)

        opening, slip, gaps = [], [], []
        for a, b, *ends, bed in joints(found):
            of_a, of_b = ([place(body, end) for end in ends] for body in (a, b))
            mu = FRICTION if bed else self.head_friction
            for point, owner, line in ((0, b, of_b), (1, b, of_b), (0, a, of_a), (1, a, of_a)):
                tangent, normal = np.array([[1.0, 0.0], [0.0, 1.0]] if bed else [[0.0, 1.0], [1.0, 0.0]])
                here = of_a[point] if owner == b else of_b[point]
                if self.turning:
                    tangent, normal = turn(owner) @ tangent, turn(owner) @ normal
                    gaps.append(float(normal @ (of_a[point] - of_b[point])))
                else:  # as published: the distance from the line where it is
                    x, z = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
                    gaps.append(abs(float(np.array([-z, x]) @ (here - line[0]))))
                opening.append(rate(a, here, normal) - rate(b, here, normal))
                slip.append(mu * (rate(a, here, tangent) - rate(b, here, tangent)))
        corner = HALVES * HALF, COURSES * HEIGHT
        last = HALVES // 2 - 1  # of the top course
        return np.array(opening), np.array(slip), np.array(gaps), rate(last, place(last, corner), np.array([1.0, 0.0]))

    def curve(self, step: float) -> Floats:
        """Displacement of the corner [m] and multiplier, a row a step."""
        mass = np.array([b - a for _, a, b in bricks()]) / 2.0
        live, weight = np.zeros((len(mass), 3)), np.zeros((len(mass), 3))
        live[:, 0], weight[:, 1] = mass, mass
        if self.seed is not None:
            weight[:, 1] *= 1.0 + NOISE * np.random.default_rng(self.seed).standard_normal(len(mass))
        pose, there, found = np.zeros((len(mass), 3)), 0.0, []
        while there < END:
            opening, slip, gaps, corner = self.rows(pose)
            answer = linprog(
                weight.reshape(-1), A_ub=np.vstack([slip - opening, -slip - opening]), b_ub=np.tile(gaps, 2),
                A_eq=live.reshape(1, -1), b_eq=[1.0], bounds=(None, None),
            )  # fmt: skip
            found.append((there, float(answer.fun)))
            pose = pose + (answer.x * step / float(corner @ answer.x)).reshape(-1, 3)
            there += step
        return np.array(found)


def ours(head_friction: float | None) -> Floats:
    """Displacement of the top right corner and multiplier along the capacity curve."""
    asm = wall("W1", head_friction=head_friction)
    curve: CapacityCurve = capacity(asm, (1, 0, 0), steps=60)
    corner = int(np.argmax(asm.vertices @ np.array([1.0, 0.0, 1.0])))
    block, point = asm.vertex_block[[corner]], asm.vertices[[corner]]
    moved = [float((displaced_points(asm, at.pose, block, point) - point)[0, 0]) for at in curve.points]
    return np.stack([moved, curve.upper], axis=1)


def main() -> None:
    """Print and write the table."""
    parser = results.parser(__doc__)
    parser.add_argument("--step", type=float, default=0.01, metavar="M", help="of the programs, by the corner [m]")
    parser.add_argument("--draws", type=int, default=12, metavar="N", help="of the weights of the bricks")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    numbers = range(options.draws)
    turned = {mu: [Panel(mu, turning=True, seed=k).curve(options.step) for k in numbers] for mu in (0.0, FRICTION)}
    rest, free, rubbing = Panel(0.0, turning=False).curve(options.step), ours(0.0), ours(None)

    def at(curve: Floats, there: float) -> float:
        return float(np.interp(there, *curve.T, left=np.nan))

    def told(curve: Floats, there: float) -> str:
        return "-" if np.isnan(at(curve, there)) else f"{at(curve, there):.3f}"

    def span(curves: list[Floats], there: float) -> str:
        values = [at(curve, there) for curve in curves]
        return f"{min(values):.3f} to {max(values):.3f}"

    head = [
        "corner [mm]", "published", "normals of rest", "normals turn", "`capacity`", "normals turn, heads rub",
        "`capacity`, heads rub",
    ]  # fmt: skip
    cells = [
        [f"{1e3 * x:.0f}", told(np.array(PUBLISHED), x), told(rest, x), span(turned[0.0], x),
         told(free, x), span(turned[FRICTION], x), told(rubbing, x)] for x in PLACES
    ]  # fmt: skip
    results.report(options, [dict(zip(head, row, strict=True)) for row in cells], {"w1": table(head, cells)})


if __name__ == "__main__":
    main()
