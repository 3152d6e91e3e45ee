"""The linear systems of the interior-point method, [P + rho I, M'; M, -(W'W + (c + delta) I)], c the compliance.

rho and delta are proximal terms (Friedlander & Orban: A primal-dual regularized interior-point method for convex
quadratic programs, 2012): they leave the optimum where it is, since the steps that they act on vanish there, and keep
the normal equations from losing the blocks whose joints are all about to open.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from blockstat.linear_algebra.normal_equations import normal_equations
from blockstat.program.conic import ConicProgram, PointBounds
from blockstat.solve.cones import Cones, Scaling
from blockstat.typing import Floats

#: Proximal terms; lengths, forces and rates of the programs are of the order of one.
PROXIMAL, DUAL_PROXIMAL = 1e-3, 1e-9
#: Refinement stops when the residual is this small relative to the right-hand side, or stops shrinking.
MOST_REFINEMENTS, REFINED, STALLED = 6, 1e-10, 0.7

Pair = tuple[Floats, Floats]


class KktSolver:
    """Solves the system of one program for one scaling after another."""

    def __init__(self, program: ConicProgram) -> None:
        self._p, self._normal = program, normal_equations(program.pair, program.n_blocks, program.width)
        self.cones = Cones(program.n_triples, program.n_zeros, program.n_half)
        self._penalty_t = sparse.csr_array(program.penalty.T)
        self._twists = program.width * program.n_blocks
        border = len(program.local) + (program.bounds.size if program.bounds else 0)
        self._border = program.matrix[border:].toarray()
        self._rows = np.empty((len(program.pair), program.local.shape[1]))
        self._rows[len(program.local) : len(program.local) + len(program.penalty_local)] = program.penalty_local
        self._scaling: Scaling | None = None
        self._shift, self._pull, self._refined = DUAL_PROXIMAL, PROXIMAL, REFINED

    def hessian(self, x: Floats) -> Floats:
        """Return P x.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        Floats
            Shape (n,).
        """
        curved = self._penalty_t @ (self._p.penalty @ x)
        curved[: self._twists] += self._p.ridge * x[: self._twists]
        return curved

    def transposed(self, z: Floats) -> Floats:
        """Return M'z.

        Parameters
        ----------
        z
            Multipliers, shape (n_rows,).

        Returns
        -------
        Floats
            Shape (n,).
        """
        return self._p.transposed @ z

    def inverse_squared(self, z: Floats) -> Floats:
        """Return (W'W + (c + delta) I)^-1 z of the last update.

        Parameters
        ----------
        z
            Shape (n_rows,).

        Returns
        -------
        Floats
            Shape (n_rows,).
        """
        assert self._scaling is not None
        return self._scaling.inverse_squared(z, self._shift)

    def update(
        self, scaling: Scaling, *, pull: float = PROXIMAL, shift: float = DUAL_PROXIMAL, refined: float = REFINED
    ) -> None:
        """Factor for another scaling.

        Parameters
        ----------
        scaling
            W of the iterate.
        pull, shift
            The proximal terms rho and delta.
        refined
            The residual that solves leave, relative to the right-hand side.

        Raises
        ------
        ArithmeticError
            When the factorisation fails.
        """
        self._pull, self._shift, self._refined = pull, self._p.compliance + shift, refined
        program, cones = self._p, self.cones
        self._scaling = scaling
        rows, n_local, n_soc = self._rows, len(program.local), 3 * cones.n_soc
        n_flat = n_soc + cones.n_zero
        half = np.sqrt(scaling.half**2 + self._shift)
        triples = rows[:n_soc].reshape(cones.n_soc, 3, rows.shape[1])
        root = scaling.root(self._shift)
        np.matmul(root, program.local[:n_soc].reshape(triples.shape), out=triples)
        np.divide(program.local[n_soc:n_flat], np.sqrt(self._shift), out=rows[n_soc:n_flat])
        np.divide(program.local[n_flat:], half[: n_local - n_flat, None], out=rows[n_flat:n_local])
        if program.bounds is not None:
            kept = program.penalty_local.copy()
            heads = root[program.bounds.row, :, 0] * program.bounds.head[:, None]
            extra = self._without_bounds(program.bounds, heads, triples, kept, half[n_local - n_flat :])
            rows[n_local:] = np.concatenate([kept, extra])
        self._normal.update(rows, program.ridge + self._pull)
        self._border_scaled = np.empty((0, 0))
        if len(self._border):
            scaled = self._border / half[len(half) - len(self._border) :, None]
            solved = self._solve_local(list(scaled))
            self._border_solved = np.column_stack(solved)
            self._held = np.eye(len(scaled)) + scaled @ self._border_solved
            self._border_scaled = scaled

    def _without_bounds(
        self, bounds: PointBounds, heads: Floats, turned: Floats, penalty: Floats, half: Floats
    ) -> Floats:
        """Eliminate y and z: rows are projected, point by point, off their columns, in place; returns further rows."""
        n, width = len(bounds.head), turned.shape[2]
        has_y, has_z = bounds.y >= 0, bounds.z >= 0
        rows, columns = np.zeros((n, 6, width)), np.zeros((n, 6, 2))
        rows[:, :3] = turned[bounds.row]
        columns[:, :3, 0] = heads * has_y[:, None]
        columns[:, :3, 1] = -heads * has_z[:, None]
        bent = (bounds.penalty >= 0) & (len(penalty) > 0)
        rows[bent, 3] = penalty[bounds.penalty[bent]]
        columns[bent & has_y, 3, 0] = 1.0
        # A missing unknown is one of its own that nothing moves.
        columns[:, 4, 0] = np.where(has_y, 1.0 / half[np.maximum(bounds.y, 0)], 1.0)
        columns[:, 5, 1] = np.where(has_z, 1.0 / half[np.maximum(bounds.z, 0)], 1.0)
        across = columns.swapaxes(1, 2)
        square = across @ columns
        square[:, [0, 1], [0, 1]] += self._pull
        self._inverse = np.linalg.inv(square)
        coupling = across @ rows
        self._coupling = self._spread(bounds, coupling)
        # Square root of R'R - C' square^-1 C: the residual of the rows, and what the proximal term leaves of y and z.
        taken = self._inverse @ coupling
        rows = rows - columns @ taken
        left = np.sqrt(self._pull) * taken
        turned[bounds.row] = rows[:, :3]
        if len(penalty):
            penalty[bounds.penalty[bent]] = rows[bent, 3]
        return np.concatenate([rows[:, 4:], left], axis=1).reshape(-1, width)

    def _spread(self, bounds: PointBounds, coupling: Floats) -> sparse.csr_array:
        """The coupling of y and z of each point (two rows a point) with the twists as a matrix."""
        w = self._p.width
        pair = self._p.pair[3 * bounds.row]
        column = np.concatenate([w * pair[:, :1] + np.arange(w), w * pair[:, 1:] + np.arange(w)], axis=1)
        column = np.broadcast_to(column[:, None], coupling.shape).reshape(-1)
        row = np.repeat(np.arange(2 * len(pair)), 2 * w)
        live = np.broadcast_to(np.repeat(pair >= 0, w, axis=1)[:, None], coupling.shape).reshape(-1)
        shape = (2 * len(pair), self._twists)
        return sparse.csr_array((coupling.reshape(-1)[live], (row[live], column[live])), shape=shape)

    def _solve_local(self, right: list[Floats]) -> list[Floats]:
        """Solve without the bordering rows, several vectors at once, which costs little more than one."""
        bounds = self._p.bounds
        if bounds is None:
            return self._factored(right)
        own = []
        for vector in right:
            after = np.append(vector[self._twists :], 0.0)
            both = np.column_stack([after[bounds.y], after[bounds.z]])  # -1 takes the zero
            own.append((self._inverse @ both[:, :, None])[:, :, 0])
        tops = [v[: self._twists] - self._coupling.T @ part.reshape(-1) for v, part in zip(right, own, strict=True)]
        found = []
        for twist, part in zip(self._factored(tops), own, strict=True):
            moved = (self._coupling @ twist).reshape(-1, 2)
            both = part - (self._inverse @ moved[:, :, None])[:, :, 0]
            after = np.empty(bounds.size)
            for column, place in enumerate((bounds.y, bounds.z)):
                after[place[place >= 0]] = both[place >= 0, column]
            found.append(np.concatenate([twist, after]))
        return found

    def _factored(self, right: list[Floats]) -> list[Floats]:
        solve = self._normal.solve
        if len(right) == 1:
            return [solve(right[0])]
        return [np.ascontiguousarray(column) for column in solve(np.column_stack(right)).T]

    def _solve_normal(self, right: list[Floats]) -> list[Floats]:
        found = self._solve_local(right)
        if not len(self._border):
            return found
        return [x - self._border_solved @ np.linalg.solve(self._held, self._border_scaled @ x) for x in found]

    def _once(self, right: list[Pair]) -> list[tuple[Floats, Floats, Floats]]:
        """x, z and M x - bottom = (W^2 + (c + delta) I) z."""
        tops = [top + self.transposed(self.inverse_squared(bottom)) if bottom.any() else top for top, bottom in right]
        moved = self._solve_normal(tops)
        rates = [self._p.matrix @ x - bottom for x, (_, bottom) in zip(moved, right, strict=True)]
        return [(x, self.inverse_squared(r), r) for x, r in zip(moved, rates, strict=True)]

    def _residual(self, top: Floats, found: tuple[Floats, Floats, Floats]) -> Pair:
        assert self._scaling is not None
        x, z, rate = found
        upper = top - self.hessian(x) - self._pull * x - self.transposed(z)
        return upper, self._scaling.squared(z, self._shift) - rate

    def solve(self, *right: Pair) -> list[Pair]:
        """Solve for right-hand sides (top, bottom), refined on the whole system.

        Parameters
        ----------
        *right
            Pairs of shape (n,) and (n_rows,).

        Returns
        -------
        list of Pair
            x and z of each.
        """
        found = self._once(list(right))
        size = np.inf
        for _ in range(MOST_REFINEMENTS):
            rest = [self._residual(top, answer) for (top, _), answer in zip(right, found, strict=True)]
            now = max(largest(*left) / max(largest(*side), 1e-300) for left, side in zip(rest, right, strict=True))
            if now <= self._refined or not now < STALLED * size:
                break
            size = now
            refined = [(x + dx, z + dz) for (x, z, _), (dx, dz, _) in zip(found, self._once(rest), strict=True)]
            found = [(x, z, self._p.matrix @ x - bottom) for (x, z), (_, bottom) in zip(refined, right, strict=True)]
        return [(x, z) for x, z, _ in found]


def largest(*vectors: Floats) -> float:
    """Return the largest magnitude in some vectors.

    Parameters
    ----------
    *vectors
        Of any shape; 0 where there is nothing.

    Returns
    -------
    float
        The largest magnitude, 0 for no entries at all.
    """
    return max(float(np.abs(vector).max(initial=0.0)) for vector in vectors)
