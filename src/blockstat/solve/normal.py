"""Normal equations of a conic program whose rows each touch two blocks.

Every row of the constraint belongs to one contact point and has entries in the columns of its two blocks only, so

    S = sum over rows t of t t'

is a matrix of small blocks with the pattern of the contact graph: one block a pair of touching blocks and one on the
diagonal for each. The pattern, its ordering and the places of all entries are found once; each update is a batched
product and a numeric factorisation.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from scipy import sparse

from blockstat.polyhedron import Floats, Ints
from blockstat.solve.factor import Factor, make_factor

#: Added to the diagonal relative to itself: a block that turns freely about two points leaves S singular.
REGULARISATION = 1e-15
#: Patterns kept for the next program with the same pairs of blocks, and the most blocks of one worth keeping.
KEPT, KEPT_BLOCKS = 6, 20_000
_pool: OrderedDict[tuple, BlockNormal] = OrderedDict()


@contextmanager
def borrowed(pair: Ints, n_blocks: int, width: int) -> Iterator[BlockNormal]:
    """The normal equations of a pattern: those of an earlier program with the same pairs, if nobody else has them."""
    key = (n_blocks, width, hashlib.sha256(np.ascontiguousarray(pair).tobytes()).digest())
    normal = _pool.pop(key, None) or BlockNormal(pair, n_blocks, width)
    try:
        yield normal
    finally:
        if n_blocks <= KEPT_BLOCKS:
            _pool[key] = normal
            while len(_pool) > KEPT:
                _pool.popitem(last=False)


class BlockNormal:
    """S of one pattern: rows of pairs of blocks, `width` unknowns a block."""

    def __init__(self, pair: Ints, n_blocks: int, width: int) -> None:
        """pair : blocks a and b of each row, -1 for a support, shape (n_rows, 2)."""
        low, high = np.minimum(pair[:, 0], pair[:, 1]), np.maximum(pair[:, 0], pair[:, 1])
        key = (low + 1) * (n_blocks + 1) + high + 1
        _, first, member, count = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
        # Pairs with as many rows stand together, so that each batch is one product of stacked matrices.
        by_count = np.argsort(count, kind="stable")
        rank = np.empty_like(by_count)
        rank[by_count] = np.arange(len(by_count))
        self._order = np.argsort(rank[member], kind="stable")
        self._pairs = pair[first[by_count]]
        self._width, self._n = width, n_blocks
        sizes, starts = np.unique(count[by_count], return_index=True)
        self._batches = list(zip(sizes.tolist(), starts.tolist(), [*starts[1:].tolist(), len(count)], strict=True))
        a, b = self._pairs.T
        self._both = np.flatnonzero((a >= 0) & (b >= 0))
        self._swapped = np.flatnonzero((a > b)[self._both])
        self._upper, self._place = self._pattern()
        self._sum = self._diagonal_sum()
        self.factor: Factor = make_factor()

    def update(self, rows: Floats, ridge: float = 0.0) -> None:
        """Form and factor S + ridge I from rows of shape (n_rows, 2 width). Raises ArithmeticError if it fails."""
        w = self._width
        products = np.empty((len(self._pairs), 2 * w, 2 * w))
        ordered = np.take(rows, self._order, axis=0)
        done = 0
        for count, first, last in self._batches:
            part = ordered[done : done + count * (last - first)].reshape(last - first, count, 2 * w)
            np.matmul(part.swapaxes(1, 2), part, out=products[first:last])
            done += count * (last - first)
        own = np.concatenate([products[:, :w, :w], products[:, w:, w:]]).reshape(-1, w * w)
        diagonal = self._sum @ own
        middle = np.arange(w) * (w + 1)
        scale = float(np.max(diagonal[:, middle], initial=1e-300))
        diagonal[:, middle] += ridge + REGULARISATION * diagonal[:, middle] + REGULARISATION**2 * scale
        across = np.take(products[:, :w, w:], self._both, axis=0)
        across[self._swapped] = across[self._swapped].swapaxes(1, 2)
        values = np.concatenate([diagonal.reshape(-1), across.reshape(-1)])
        np.take(values, self._place, out=self._upper.data)
        self.factor.update(self._upper)

    def _pattern(self) -> tuple[sparse.csr_array, Ints]:
        """The upper triangle with its entries' places among the values of the diagonal and off-diagonal blocks."""
        n, w = self._n, self._width
        low, high = (part[self._both] for part in (self._pairs.min(axis=1), self._pairs.max(axis=1)))
        row = np.concatenate([np.arange(n), low])
        column = np.concatenate([np.arange(n), high])
        order = np.lexsort((column, row))
        start = np.searchsorted(row[order], np.arange(n + 1))
        # Numbered from 1 so that no place is lost as an explicit zero.
        place = 1.0 + (order[:, None] * w * w + np.arange(w * w)).reshape(-1, w, w)
        blocks = sparse.bsr_array((place, column[order], start), shape=(n * w, n * w))
        upper = sparse.csr_array(sparse.triu(blocks.tocsr(), format="csr"))
        upper.sort_indices()
        return upper, (upper.data - 1).astype(np.int64)

    def _diagonal_sum(self) -> sparse.csr_array:
        """Sums the products of a and of b of all pairs into the diagonal blocks."""
        side = np.concatenate(self._pairs.T)
        live = np.flatnonzero(side >= 0)
        return sparse.csr_array((np.ones(len(live)), (side[live], live)), shape=(self._n, len(side)))


def local_rows(matrix: sparse.csr_array, pair: Ints, width: int) -> Floats:
    """Entries of rows in the columns of their blocks a and b, shape (n_rows, 2 width)."""
    entries = matrix.tocoo()
    row, column = entries.coords[0], entries.coords[1]
    second = column // width == pair[row, 1]
    local = np.zeros((len(pair), 2 * width))
    local[row, width * second + column % width] = entries.data
    return local
