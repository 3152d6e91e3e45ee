"""Sparse Cholesky factorisation behind one small protocol: MKL Pardiso when it is there, else SuperLU from scipy.

Pardiso (Schenk & Gaertner 2004) keeps the ordering and the symbolic factor between matrices of one pattern; SuperLU
orders and factors anew each time. `backend()` says which one answers.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from blockstat.typing import Floats

#: Matrices with fewer rows are factored by one thread: waking the others costs more than they bring.
THREADED = 30_000
#: Pardiso's matrix type, and its options that are not zero: these and no defaults, nested dissection, indices from 0.
#: No refinement: the solvers refine on the whole system, and Pardiso's own two rounds make each solve twice as long.
POSITIVE_DEFINITE, OPTIONS = 2, {0: 1, 1: 2, 34: 1}
#: Matrices with fewer rows are ordered by minimum degree: it fills in more, and is found sooner.
ORDERING, MINIMUM_DEGREE, SMALL = 1, 0, 10_000


class Factor(Protocol):
    """A symmetric positive definite matrix of a fixed pattern, factored for some values."""

    def update(self, upper: sparse.csr_array) -> None:
        """Factor a matrix.

        Parameters
        ----------
        upper
            Its upper triangle, diagonal included, of the pattern of the matrices before it.

        Raises
        ------
        ArithmeticError
            When the matrix is not positive definite, or its values are not finite.
        """
        ...

    def solve(self, right: Floats) -> Floats:
        """Solve with the last matrix.

        Parameters
        ----------
        right
            One or more right-hand sides, shape (n,) or (n, k).

        Returns
        -------
        Floats
            The solutions, of the same shape.
        """
        ...


def backend() -> str:
    """Return the name of the factorisation in use.

    The environment variable BLOCKSTAT_FACTOR=superlu asks for the fallback.

    Returns
    -------
    str
        "pardiso" or "superlu".
    """
    return "pardiso" if _pardiso() is not None and os.environ.get("BLOCKSTAT_FACTOR") != "superlu" else "superlu"


def make_factor() -> Factor:
    """Return a factor of the backend in use.

    Returns
    -------
    Factor
        A new factor, without a matrix.
    """
    return Pardiso() if backend() == "pardiso" else SuperLU()


class SuperLU:
    """The fallback that scipy brings along."""

    def __init__(self) -> None:
        self._lu: Any = None
        self._full: Any = None

    def update(self, upper: sparse.csr_array) -> None:
        """Factor a matrix; see `Factor.update`.

        Parameters
        ----------
        upper
            Its upper triangle.
        """
        from scipy.sparse.linalg import splu

        _check_finite(upper)
        full = self._full = sparse.csc_array(upper + sparse.triu(upper, 1).T)
        if len(upper.indptr) == 1:  # it has no rows, which SuperLU refuses
            return
        options = {"SymmetricMode": True}
        try:
            self._lu = splu(full, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from None

    def solve(self, right: Floats) -> Floats:
        """Solve with the last matrix; see `Factor.solve`.

        Parameters
        ----------
        right
            Right-hand sides, shape (n,) or (n, k).

        Returns
        -------
        array of float
            Solutions, of the shape of the right-hand sides.
        """
        if not len(right):
            return np.zeros_like(right)
        found = self._lu.solve(right)
        # One round of refinement, because there was no pivoting.
        better = found + self._lu.solve(right - self._full @ found)
        return better if np.isfinite(better).all() else found


class Pardiso:
    """MKL Pardiso for positive definite matrices; the analysis is made once."""

    def __init__(self) -> None:
        self._index: tuple[Any, Any] | None = None  # rows' starts and columns in 32 bits
        solver = _pardiso()
        assert solver is not None
        self._library, self._run = solver.libmkl, solver._mkl_pardiso
        self._pt = np.zeros_like(solver.pt)
        self._options = np.zeros(64, dtype=np.int32)
        self._options[list(OPTIONS)] = list(OPTIONS.values())
        self._values = np.empty(0)

    def update(self, upper: sparse.csr_array) -> None:
        """Factor a matrix; see `Factor.update`.

        Parameters
        ----------
        upper
            Its upper triangle.
        """
        _check_finite(upper)
        fresh = self._index is None
        if fresh:
            self._index = upper.indptr.astype(np.int32), upper.indices.astype(np.int32)
            if len(upper.indptr) <= SMALL:
                self._options[ORDERING] = MINIMUM_DEGREE
        self._values = upper.data
        self._library.MKL_Set_Num_Threads(1 if len(upper.indptr) <= THREADED else _threads())
        self._call(12 if fresh else 22, np.zeros(len(upper.indptr) - 1))

    def solve(self, right: Floats) -> Floats:
        """Solve with the last matrix; see `Factor.solve`.

        Parameters
        ----------
        right
            Right-hand sides, shape (n,) or (n, k).

        Returns
        -------
        array of float
            Solutions, of the shape of the right-hand sides.
        """
        return self._call(33, np.asfortranarray(right))

    def _call(self, phase: int, right: Floats) -> Floats:
        assert self._index is not None
        if not len(right):  # a matrix without rows, which Pardiso refuses
            return np.zeros_like(right)
        start, column = (part.ctypes.data_as(ctypes.POINTER(ctypes.c_int32)) for part in self._index)
        found = np.zeros_like(right)
        one, kind, what, size, columns, quiet, error = map(
            ctypes.c_int32, (1, POSITIVE_DEFINITE, phase, len(right), right.size // len(right), 0, 0)
        )
        self._run(
            self._pt.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)), one, one, kind, what, size,
            self._values.ctypes.data, start, column, None, columns,
            self._options.ctypes.data_as(ctypes.POINTER(ctypes.c_int32)), quiet,
            right.ctypes.data, found.ctypes.data, error,
        )  # fmt: skip
        if error.value:
            raise ArithmeticError(f"Pardiso error {error.value}")
        return np.ascontiguousarray(found)

    def __del__(self) -> None:
        if self._index is not None and not sys.is_finalizing():
            self._call(-1, np.zeros(len(self._index[0]) - 1))


def _check_finite(upper: sparse.csr_array) -> None:
    """Raise ArithmeticError for values that are not finite, which would end the process inside Pardiso."""
    if not np.isfinite(upper.data).all():
        raise ArithmeticError("the matrix has values that are not finite")


def _threads() -> int:
    """Threads for a large matrix: as many as the user grants, else all there are."""
    granted = os.environ.get("MKL_NUM_THREADS") or os.environ.get("OMP_NUM_THREADS") or ""
    return int(granted) if granted.isdigit() else os.cpu_count() or 1


@cache
def _pardiso() -> Any:
    """A solver of pypardiso with the library (it looks for the library on the disk when it is made), or None."""
    # Left to itself pypardiso searches the whole environment for the library, which takes a second.
    library = sorted([*Path(sys.prefix, "lib").glob("libmkl_rt*"), *Path(sys.prefix, "Library", "bin").glob("mkl_rt*")])
    if library:
        os.environ.setdefault("PYPARDISO_MKL_RT", str(library[-1]))
    # Idle threads of MKL sleep instead of spinning through what runs on one thread.
    os.environ.setdefault("KMP_BLOCKTIME", "0")
    try:
        from pypardiso.pardiso_wrapper import PyPardisoSolver

        return PyPardisoSolver(mtype=POSITIVE_DEFINITE)
    except (ImportError, OSError):
        return None
