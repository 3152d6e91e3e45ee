"""The one conic program that every solver reads, as plain arrays, and how a question about an assembly becomes one.

Twists u of the blocks, with A the equilibrium matrix of a `PenaltyProgram`, w its load and K* the dual cones:

    minimise 1/2 u'P u + cost'u   subject to   A'u + offset in K*,   at_most_one'u <= 1,   pinned'u = 1.

Here g = A'u + offset are the rates of the contact points, with a normal part g_n and tangential parts g_1 and g_2, and
P is the square of those rates that the penalty counts. Every point becomes one triple of a second-order cone,
(g_n / mu, g_1, g_2). Without friction it becomes a half-line g_n >= 0; with infinite friction, zeros g_t = 0 are added.
In a prismatic scene every pair of points becomes two half-lines, g_n + mu g_t >= 0 and g_n - mu g_t >= 0. The upper
bound of a point's force is an unknown y >= 0 and the lower bound is an unknown z >= 0, with g + (y - z) n in K*.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from blockstat.program.equilibrium import in_place
from blockstat.program.penalty import PenaltyProgram
from blockstat.program.planar import Plane
from blockstat.typing import Floats, Ints


@dataclass(frozen=True, eq=False)
class PointBounds:
    """Unknowns y and z >= 0 of single points, which enter the head of the point's cone with +head and -head.

    They follow the twists in x, all y before all z. Their half-lines -y <= 0, -z <= 0 follow the rows of points.
    """

    row: Ints  #: row of the point's head in M, shape (n,)
    point: Ints  #: the point, shape (n,)
    is_triple: bool  #: whether all these points have friction, neither nothing nor infinite
    head: Floats  #: shape (n,)
    penalty: Ints  #: the point's row of the penalty, -1 for none, shape (n,)
    y: Ints  #: place of y among the unknowns after the twists, -1 for none, shape (n,)
    z: Ints  #: place of z, likewise

    @cached_property
    def size(self) -> int:
        """The number of unknowns."""
        return int((self.y >= 0).sum() + (self.z >= 0).sum())


@dataclass(frozen=True, eq=False)
class ConicProgram:
    """min 1/2 x'P x + q'x subject to M x + s = b, s in the cones.

    The rows are the heads of all triples, their second and their third components, zeros, half-lines of two blocks,
    half-lines of the bounds, and half-lines of all blocks (the border).
    """

    cost: Floats  #: q, shape (n,)
    matrix: sparse.csr_array  #: M, shape (n_rows, n)
    bound: Floats  #: b, shape (n_rows,)
    n_triples: int  #: second-order cones of dimension 3
    n_zeros: int
    n_half: int  #: half-lines
    #: Entries of the rows of two blocks in the columns of a and b, signs aside, shape (n_local, 2 width). The three of
    #: a triple stand together here, while M has all heads first.
    local: Floats
    pair: Ints  #: blocks of these rows, then of those of the penalty, then four more for each bounded point
    n_blocks: int
    width: int  #: unknowns a block: 6, or 3 in the plane
    penalty: sparse.csr_array  #: Q with P = Q'Q, shape (n_penalty, n)
    penalty_local: Floats  #: its entries, shape (n_penalty, 2 width)
    friction: Floats  #: mu of each point, shape (m,)
    scale: Floats  #: factor of the rows of points
    rows: Ints  #: the rows' places among the three rates of each point; empty in the plane
    upper_bounded: Ints  #: the points of the first unknowns after the twists
    plane: Plane | None = None  #: the plane that the program is folded into
    pinned: bool = False  #: whether the last half-line holds with equality at every optimum
    ridge: float = 0.0  #: P = Q'Q + ridge I, I the identity on the twists
    bounds: PointBounds | None = None
    #: c of `c/2 |f|^2` in the cost of the forces f of the multipliers z. A solver may count shear 1/mu^2 times;
    #: then all rows have the same compliance, M x + s - c z = b.
    compliance: float = 0.0

    @property
    def is_quadratic(self) -> bool:
        """Whether P is more than zero."""
        return len(self.penalty_local) > 0 or self.ridge > 0

    @property
    def has_structure(self) -> bool:
        """Whether all bounds are those of points with friction, neither none nor infinite."""
        return self.bounds is None or self.bounds.is_triple

    @cached_property
    def transposed(self) -> sparse.csr_array:
        """M', by rows."""
        return sparse.csr_array(self.matrix.T)

    def feasibility(self) -> ConicProgram:
        """Return the same rows and cost without P.

        Returns
        -------
        ConicProgram
            A program whose multipliers balance the cost, M'z + q = 0.
        """
        first = len(self.local)
        last = first + len(self.penalty_local)
        bounds = self.bounds and replace(self.bounds, penalty=np.full_like(self.bounds.penalty, -1))
        bare = replace(
            self,
            pair=np.concatenate([self.pair[:first], self.pair[last:]]),
            penalty=sparse.csr_array((0, len(self.cost))),
            penalty_local=self.penalty_local[:0],
            ridge=0.0,
            bounds=bounds,
        )
        bare.__dict__["transposed"] = self.transposed  # the same; not to be made again
        return bare

    def twist(self, x: Floats) -> Floats:
        """Read twists off the unknowns.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        Floats
            Twists of all blocks, shape (6 n_blocks,), unfolded where the program is planar.
        """
        own = x[: self.width * self.n_blocks]
        return own if self.plane is None else self.plane.unfold @ own

    def forces(self, z: Floats) -> Floats:
        """Read contact forces off the multipliers.

        Parameters
        ----------
        z
            Multipliers of the rows, shape (n_rows,).

        Returns
        -------
        Floats
            Forces on block b in the frame of each joint, shape (m, 3), in units of the program.
        """
        if self.plane is not None:
            return self.plane.forces_of_half_planes(self.friction, self.scale * z[: len(self.scale)])
        force = np.zeros(3 * len(self.friction))
        force[self.rows] = self.scale * z[: len(self.rows)]
        return force.reshape(-1, 3)

    def rates(self, slack: Floats) -> Floats:
        """Read relative velocities off the slack of a program in space.

        Parameters
        ----------
        slack
            s of the rows, shape (n_rows,).

        Returns
        -------
        Floats
            Velocities of block b against block a at each point, shape (m, 3).
        """
        rate = np.zeros(3 * len(self.friction))
        rate[self.rows] = slack[: len(self.rows)] / self.scale
        return rate.reshape(-1, 3)

    def multipliers(self, force: Floats) -> Floats:
        """Write contact forces as multipliers.

        Parameters
        ----------
        force
            Shape (m, 3), in units of the program.

        Returns
        -------
        Floats
            Multipliers of the rows, shape (n_rows,); those of the bounds and of the border are 0.
        """
        if self.plane is not None:
            own = self.plane.half_planes_of_forces(self.friction, force) / self.scale
        else:
            own = force.reshape(-1)[self.rows] / self.scale
        return np.pad(own, (0, len(self.bound) - len(own)))

    def yielding(self, x: Floats) -> Floats:
        """Read y off the unknowns, the closing that the upper bounds of forces allow.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        Floats
            y of each point, 0 where there is no bound, shape (m,).
        """
        closing = np.zeros(len(self.friction))
        closing[self.upper_bounded] = x[self.width * self.n_blocks :][: len(self.upper_bounded)]
        return closing


def conic_program(
    program: PenaltyProgram,
    cost: Floats,
    *,
    penalty: bool = False,
    least_norm: bool = False,
    offset: Floats | None = None,
    at_most_one: Floats | None = None,
    pinned: Floats | None = None,
    yielding: float = 0.0,
    compliance: float = 0.0,
) -> ConicProgram:
    """Write a question about twists as a conic program, in the plane where all of it is planar.

    Parameters
    ----------
    program
        The equilibrium, the friction and the bounds of the points.
    cost
        Linear cost of the twists, shape (6 n,).
    penalty
        Whether P is that of the penalty program, E E' in the rates A'u (at points with an upper bound on g_n + y).
    least_norm
        Whether P is the identity. It is zero without `penalty` and `least_norm`.
    offset
        Rates added to A'u, shape (3 m,).
    at_most_one, pinned
        Vectors with at_most_one'u <= 1 and pinned'u = 1, shape (6 n,).
    yielding
        Closing at the upper bounds of contact points that counts in `at_most_one` and earns as much in the cost, each
        so many times.
    compliance
        c, with `c/2 |f|^2` added to the cost of forces; for positive finite friction, and without P.

    Returns
    -------
    ConicProgram
        Its unknowns are the twists, then y and z of the bounds. Its multipliers are the contact forces, scaled.
    """
    plane = program.plane
    if plane is not None:
        can_slip = not compliance and np.isfinite(program.friction).all()
        folds = can_slip and plane.holds(cost, at_most_one, pinned) and (offset is None or plane.mirrors(offset))
        plane = plane if folds else None
    conic = _in_space(program, cost, offset) if plane is None else _in_plane(program, plane, cost, offset)
    if penalty:
        conic = _with_penalty(conic, program)
    conic = replace(_with_border(conic, at_most_one, pinned), ridge=float(least_norm), compliance=compliance)
    return _with_bounds(conic, program, yielding, at_most_one is not None)


def _in_space(program: PenaltyProgram, cost: Floats, offset: Floats | None) -> ConicProgram:
    """Each point is a triple (g_n / mu, g_1, g_2), times mu where that is below 1, or half-lines and zeros."""
    mu = program.friction
    rough = np.flatnonzero((mu > 0) & np.isfinite(mu))
    no_slip, frictionless_or_no_slip = np.flatnonzero(np.isinf(mu)), np.flatnonzero((mu == 0) | np.isinf(mu))
    slip = np.minimum(mu[rough], 1.0)
    size = np.ones((len(mu), 3))
    size[rough] = np.column_stack([slip / mu[rough], slip, slip])
    single = np.concatenate([3 * no_slip + 1, 3 * no_slip + 2, 3 * frictionless_or_no_slip])
    rows = np.concatenate([*(3 * rough + k for k in range(3)), single])
    grouped = np.concatenate([(3 * rough[:, None] + np.arange(3)).reshape(-1), single])
    scale = size.reshape(-1)[rows]
    matrix = program.matrix.T.tocsr()[rows]
    matrix.data *= -np.repeat(scale, np.diff(matrix.indptr))
    return ConicProgram(
        cost=cost,
        matrix=matrix,
        bound=np.zeros(len(rows)) if offset is None else scale * offset[rows],
        n_triples=len(rough),
        n_zeros=2 * len(no_slip),
        n_half=len(frictionless_or_no_slip),
        local=size.reshape(-1, 1)[grouped] * program.local[grouped],
        pair=program.point_blocks[grouped // 3],
        n_blocks=len(program.load) // 6,
        width=6,
        penalty=sparse.csr_array((0, len(cost))),
        penalty_local=np.empty((0, 12)),
        friction=mu,
        scale=scale,
        rows=rows,
        upper_bounded=program.upper_bounded,
    )


def _in_plane(program: PenaltyProgram, plane: Plane, cost: Floats, offset: Floats | None) -> ConicProgram:
    """Each pair of points is two half-planes, g_n + mu g_t >= 0 and g_n - mu g_t >= 0."""
    mu = program.friction[plane.first]
    scale = np.tile(1.0 / np.maximum(mu, 1.0), 2)
    bound = np.zeros(2 * len(mu))
    if offset is not None:
        head, tangent = plane.offsets(offset)
        bound = scale * np.concatenate([head + mu * tangent, head - mu * tangent])
    head, tangent = program.planar_local
    tangent = mu[:, None] * tangent
    local = scale[:, None] * np.concatenate([head + tangent, head - tangent])
    pair = np.tile(program.point_blocks[plane.first], (2, 1))
    n_blocks = len(program.load) // 6
    return ConicProgram(
        cost=plane.unfold.T @ cost,
        matrix=in_place(-local, pair, n_blocks).T,
        bound=bound,
        n_triples=0,
        n_zeros=0,
        n_half=2 * len(mu),
        local=local,
        pair=pair,
        n_blocks=n_blocks,
        width=3,
        penalty=sparse.csr_array((0, len(cost) // 2)),
        penalty_local=np.empty((0, 6)),
        friction=program.friction,
        scale=scale,
        rows=np.empty(0, dtype=np.int64),
        upper_bounded=program.upper_bounded,
        plane=plane,
    )


def _with_penalty(conic: ConicProgram, program: PenaltyProgram) -> ConicProgram:
    """Add P = Q'Q, Q the rows of the normal rates."""
    if conic.plane is None:
        penalty, local = sparse.csr_array(program.normal_columns.T), program.local[: 3 * program.n_points : 3]
        owners = program.point_blocks[: program.n_points]
    else:
        # Two points a pair, so the penalty on a pair counts twice.
        local = np.sqrt(2.0) * program.planar_local[0]
        owners = program.point_blocks[conic.plane.first]
        penalty = in_place(local, owners, conic.n_blocks).T
    return replace(conic, penalty=penalty, penalty_local=local, pair=np.concatenate([conic.pair, owners]))


def _with_border(conic: ConicProgram, at_most_one: Floats | None, pinned: Floats | None) -> ConicProgram:
    """Append the half-lines that touch all blocks."""
    border, bounds = [], []
    for vector, sign in ((at_most_one, 1.0), (pinned, -1.0)):
        if vector is not None:
            # A load does as little work as it can, so l'u = 1 may be relaxed to l'u >= 1.
            own = vector if conic.plane is None else conic.plane.unfold.T @ vector
            border.append(sparse.csr_array(sign * own[None, :]))
            bounds.append(sign)
    if not border:
        return conic
    return replace(
        conic,
        matrix=sparse.csr_array(sparse.vstack([conic.matrix, *border])),
        bound=np.concatenate([conic.bound, bounds]),
        n_half=conic.n_half + len(bounds),
        pinned=pinned is not None,
    )


def _with_bounds(conic: ConicProgram, program: PenaltyProgram, yielding: float, counts: bool) -> ConicProgram:
    """Append the unknowns y and z, their columns in the cones, the penalty and the border, and their half-lines.

    counts : whether the border holds the row of `at_most_one`.
    """
    bounds = _point_bounds(conic, program)
    if bounds is None:
        return conic
    earned = np.zeros(bounds.size)
    earned[: len(program.upper_bounded)] = yielding * (program.upper_bounded < program.n_points)
    price = np.concatenate([program.upper[program.upper_bounded], -program.lower[program.lower_bounded]]) - earned
    n_penalty, n_local = len(conic.penalty_local), len(conic.local)
    has_y, has_z = bounds.y >= 0, bounds.z >= 0
    values = np.concatenate([-bounds.head[has_y], bounds.head[has_z]])
    rows = np.concatenate([bounds.row[has_y], bounds.row[has_z]])
    places = np.append(bounds.y[has_y], bounds.z[has_z])
    if counts:
        values = np.concatenate([values, earned])
        rows = np.concatenate([rows, np.full(bounds.size, n_local)])
        places = np.concatenate([places, np.arange(bounds.size)])
    heads = sparse.csr_array((values, (rows, places)), shape=(len(conic.bound), bounds.size))
    bent = has_y & (bounds.penalty >= 0) & (n_penalty > 0)
    ones = (np.ones(bent.sum()), (bounds.penalty[bent], bounds.y[bent]))
    matrix = sparse.csr_array(sparse.hstack([conic.matrix, heads]))
    own = sparse.hstack([sparse.csr_array((bounds.size, len(conic.cost))), -sparse.eye_array(bounds.size)])
    more = sparse.csr_array(ones, shape=(n_penalty, bounds.size))
    return replace(
        conic,
        cost=np.concatenate([conic.cost, price]),
        matrix=sparse.csr_array(sparse.vstack([matrix[:n_local], own, matrix[n_local:]])),
        bound=np.insert(conic.bound, n_local, np.zeros(bounds.size)),
        n_half=conic.n_half + bounds.size,
        pair=np.concatenate([conic.pair, np.repeat(program.point_blocks[bounds.point], 4, axis=0)]),
        penalty=sparse.csr_array(sparse.hstack([conic.penalty, more])),
        bounds=bounds,
    )


def _point_bounds(conic: ConicProgram, program: PenaltyProgram) -> PointBounds | None:
    """The points whose force has an upper or a lower bound; a plane holds none."""
    points = np.union1d(program.upper_bounded, program.lower_bounded)
    if not len(points):
        return None
    place = np.empty(3 * len(program.friction), dtype=np.int64)
    place[conic.rows] = np.arange(len(conic.rows))
    row = place[3 * points]
    y, z = (np.full(len(points), -1) for _ in range(2))
    y[np.searchsorted(points, program.upper_bounded)] = np.arange(len(program.upper_bounded))
    z[np.searchsorted(points, program.lower_bounded)] = len(program.upper_bounded) + np.arange(
        len(program.lower_bounded)
    )
    penalty = np.where(points < program.n_points, points, -1)
    return PointBounds(row, points, bool((row < conic.n_triples).all()), conic.scale[row], penalty, y, z)
