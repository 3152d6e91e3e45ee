"""The judge's programs: linear ones with friction polygons inside or outside the cones, checked on the cones.

Forces are sums of rays. A polygon inside a cone has its corners on it, one outside has its sides on it, both at the
same angles, of which each point has its own; `refined` adds the angles that matter. Rows are in weights of their block,
moments also in its length, so that a light block beside a heavy one counts as much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, csc_matrix, hstack, identity

from evidence.fuzz.scene import Scene
from evidence.fuzz.solids import Array
from evidence.fuzz.touch import Touch

FORCES = 1e6  #: forces of more weights than this hold nothing
SIDES = 16  #: of a friction polygon at first
EXACT = 1e-9  #: of a block's weight: what a checked balance may lack
LACK = 1e-8  #: of a block's weight: a lack that the programs can tell from none


@dataclass(frozen=True, eq=False)
class Points:
    """Contact points with frames, and the program's scaled equilibrium."""

    scene: Scene
    point: Array  #: shape (n, 3)
    frame: Array  #: shape (n, 3, 3), rows n, t1, t2
    pair: Array  #: shape (n, 2)
    angles: tuple[Array, ...]  #: of each point, ascending
    smooth: Array  #: of each point, whether nothing resists sliding: contacts without a normal of their own

    @classmethod
    def of(cls, scene: Scene, touches: list[Touch]) -> Points:
        """All points of some contacts."""
        point, frame, pair = [np.empty((0, 3))], [np.empty((0, 3, 3))], [np.empty((0, 2), int)]
        for touch in touches:
            n = len(touch.points)
            _, _, across = np.linalg.svd(touch.normal[None])
            point.append(touch.points)
            frame.append(np.tile(np.stack([touch.normal, across[1], across[2]]), (n, 1, 1)))
            pair.append(np.tile([touch.a, touch.b], (n, 1)))
        points = np.concatenate(point)
        smooth = np.repeat([not touch.unique for touch in touches], [len(touch.points) for touch in touches]).astype(
            bool
        )
        around = 2 * np.pi * np.arange(SIDES) / SIDES
        return cls(scene, points, np.concatenate(frame), np.concatenate(pair), (around,) * len(points), smooth)

    @cached_property
    def friction(self) -> Array:
        """Coefficient of each point."""
        return np.where(self.smooth, 0.0, self.scene.friction_of(self.pair))

    @cached_property
    def free(self) -> Array:
        """Blocks that can move."""
        return np.flatnonzero(~np.array(self.scene.support, dtype=bool))

    @cached_property
    def length(self) -> Array:
        """Of each block, the unit of its moments."""
        return np.array([np.cbrt(solid.volume) for solid in self.scene.solids])

    @cached_property
    def centroid(self) -> Array:
        """Of each block."""
        return np.array([solid.centroid for solid in self.scene.solids])

    @cached_property
    def unit(self) -> Array:
        """Unit of force of each point: the weight of the lighter block that can move."""
        weight = np.where(np.array(self.scene.support, dtype=bool), np.inf, self.scene.weights)
        return weight[self.pair].min(axis=1, initial=np.inf)

    @cached_property
    def matrix(self) -> csc_matrix:
        """Equilibrium of the free blocks by forces in frames and units of the points, shape (6 n_free, 3 n_points)."""
        rows, columns, values = [np.empty(0, int)], [np.empty(0, int)], [np.empty(0)]
        place = np.full(len(self.scene.solids), -1)
        place[self.free] = np.arange(len(self.free))
        for side, sign in ((0, -1.0), (1, 1.0)):
            block = self.pair[:, side]
            live = np.flatnonzero(place[block] >= 0)
            block = block[live]
            share = (sign * self.unit[live] / self.scene.weights[block])[:, None, None]
            push = self.frame[live] * share
            turn = np.cross((self.point[live] - self.centroid[block])[:, None], push) / self.length[block, None, None]
            value = np.concatenate([push, turn], axis=2)  # point, component of force, row
            rows.append(np.broadcast_to(6 * place[block][:, None, None] + np.arange(6), value.shape).ravel())
            columns.append(np.broadcast_to(3 * live[:, None, None] + np.arange(3)[:, None], value.shape).ravel())
            values.append(value.ravel())
        shape = (6 * len(self.free), 3 * len(self.point))
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return coo_matrix(entries, shape).tocsc()

    @cached_property
    def load(self) -> Array:
        """Weight of the free blocks in the rows' units."""
        down = self.scene.gravity / np.linalg.norm(self.scene.gravity)
        return np.tile(np.concatenate([down, np.zeros(3)]), len(self.free))

    def rays(self, *, outer: bool) -> csc_matrix:
        """Extreme forces of the polygons, shape (3 n_points, n_rays)."""
        groups = [_rays(angle, mu, outer=outer) for angle, mu in zip(self.angles, self.friction, strict=True)]
        rows = np.concatenate([np.repeat(3 * i + np.arange(3), g.shape[1]) for i, g in enumerate(groups)] or [[]])
        first = np.cumsum([0] + [g.shape[1] for g in groups])
        columns = np.concatenate(
            [np.tile(np.arange(first[i], first[i + 1]), 3) for i in range(len(groups))] or [np.empty(0)]
        )
        values = np.concatenate([g.ravel() for g in groups] or [np.empty(0)])
        return coo_matrix((values, (rows.astype(int), columns.astype(int))), (3 * len(groups), first[-1])).tocsc()

    def refined(self, force: Array) -> Points:
        """The same with the angles of these forces, shape (n, 3), among those of the polygons."""
        around = np.arctan2(force[:, 2], force[:, 1]) % (2 * np.pi)
        used = np.hypot(force[:, 1], force[:, 2]) > 1e-9
        angles = tuple(
            np.unique(np.append(own, new)) if use else own
            for own, new, use in zip(self.angles, around, used, strict=True)
        )
        return replace(self, angles=angles)

    def slack(self, force: Array) -> Array:
        """How far forces are inside their cones, in units of the points."""
        slides = np.isfinite(self.friction)
        tangent = np.hypot(force[:, 1], force[:, 2])
        spare = np.where(slides, self.friction, 0.0) * force[:, 0] - tangent
        return np.minimum(force[:, 0], np.where(slides, spare, np.inf))


@dataclass(frozen=True)
class Answer:
    """What a program found and what was checked of it."""

    lack: float  #: least sum of unbalanced loads, in weights of their blocks; inf where the solver failed
    force: Array  #: shape (n, 3), in units of the points
    stands: bool  #: the forces balance every block inside the exact cones
    falls: bool  #: the mechanism is driven by the loads, and no forces of bounded size resist it


def _rays(angle: Array, mu: float, *, outer: bool) -> Array:
    """Extreme forces of a point, shape (3, k): those of a polygon unless there is no friction or no sliding."""
    if mu == 0.0:
        return np.array([[1.0], [0.0], [0.0]])
    if np.isinf(mu):
        return np.array([[1.0, 0, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
    radius = np.full(len(angle), mu)
    if outer:
        half = (np.roll(angle, -1) - angle) % (2 * np.pi) / 2
        angle, radius = angle + half, mu / np.cos(half)
    rays = np.stack([np.ones(len(angle)), radius * np.cos(angle), radius * np.sin(angle)])
    return rays / max(1.0, mu)


def least_lack(points: Points, *, outer: bool, shift: Array | None = None, most: float = FORCES) -> Answer:
    """Forces in the polygons that leave the least load unbalanced, and the mechanism that is their dual.

    No ray is larger than `most` weights of all free blocks. Jammed blocks may press on each other as hard as that.
    """
    load = points.load if shift is None else points.load + shift
    rays = points.rays(outer=outer)
    n, m = rays.shape[1], len(load)
    whole = hstack([points.matrix @ rays, identity(m), -identity(m)], format="csc")
    cost = np.concatenate([np.zeros(n), np.ones(2 * m)])
    most *= points.scene.weights[points.free].sum() / points.unit.min(initial=np.inf)
    bounds = np.column_stack([np.zeros(len(cost)), np.append(np.full(n, most), np.full(2 * m, np.inf))])
    for tolerance in (1e-10, 1e-9, 1e-7):  # what is found is checked, whatever the tolerance
        options = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance}
        found = linprog(cost, A_eq=whole, b_eq=-load, bounds=bounds, method="highs-ds", options=options)
        if found.x is not None:
            break
    else:
        return Answer(np.inf, np.zeros((len(points.point), 3)), False, False)
    force = (rays @ found.x[:n]).reshape(-1, 3)
    force, stands = _balanced(points, force, load) if found.fun < LACK else (force, False)
    falls = found.fun > LACK and _falls(points, -found.eqlin.marginals, load)
    return Answer(float(found.fun), force, stands, falls)


def _balanced(points: Points, force: Array, load: Array) -> tuple[Array, bool]:
    """Forces corrected onto equilibrium, and whether they are in the exact cones and bounded then."""
    matrix = points.matrix.toarray()
    flat = force.ravel()
    # Corrections next to what a force already is keep small forces in their cones.
    slip = np.minimum(points.friction, 1.0)
    scale = ((np.linalg.norm(force, axis=1) + 1e-6) * np.array([np.ones_like(slip), slip, slip])).T.ravel()
    flat = flat - scale * np.linalg.lstsq(matrix * scale, matrix @ flat + load, rcond=1e-13)[0]
    force = flat.reshape(-1, 3)
    total = (np.linalg.norm(force, axis=1) * points.unit).sum()
    rounding = 1e-14 * (np.abs(matrix) @ np.abs(flat)).max(initial=0.0)
    balanced = np.abs(matrix @ flat + load).max(initial=0.0) <= EXACT + rounding
    inside = points.slack(force).min(initial=0.0) >= -EXACT
    return force, bool(balanced and inside and total <= FORCES * points.scene.weights[points.free].sum())


def _falls(points: Points, twist: Array, load: Array) -> bool:
    """Whether a mechanism works under the loads, and any forces against it would need to be too large."""
    work = float(twist @ load)
    rate = (points.matrix.T @ twist).reshape(-1, 3)
    slide = np.hypot(rate[:, 1], rate[:, 2])
    slips = np.isfinite(points.friction)
    closing = np.where(
        slips, np.where(slips, points.friction, 0.0) * slide - rate[:, 0], np.maximum(-rate[:, 0], slide)
    )
    resisted = float((np.maximum(closing, 0.0) / points.unit).max(initial=0.0))  # per newton of normal force
    return work > LACK and work >= FORCES * resisted * points.scene.weights[points.free].sum()
