"""Sparse Cholesky factorisation behind one small protocol: MKL Pardiso when it is there, else SuperLU from scipy.

Pardiso (Schenk & Gaertner 2004) keeps the ordering and the symbolic factor between matrices of one pattern; SuperLU
orders and factors anew each time. `backend()` says which one answers.
"""

from __future__ import annotations

import os
import sys
from copy import copy
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from blockstat.polyhedron import Floats

#: Matrices with fewer rows are factored by one thread: waking the others costs more than they bring.
THREADED = 30_000


class Factor(Protocol):
    """A symmetric positive definite matrix of a fixed pattern, factored for some values."""

    def update(self, upper: sparse.csr_array) -> None:
        """Factor a matrix given by its upper triangle, diagonal included. Raises ArithmeticError if it fails."""
        ...

    def solve(self, right: Floats) -> Floats:
        """Solve for one or more right-hand sides, shape (n,) or (n, k)."""
        ...


def backend() -> str:
    """The factorisation in use: "pardiso" or "superlu"; BLOCKSTAT_FACTOR=superlu asks for the fallback."""
    return "pardiso" if _pardiso() is not None and os.environ.get("BLOCKSTAT_FACTOR") != "superlu" else "superlu"


def make_factor() -> Factor:
    """A factor of the backend in use."""
    return Pardiso() if backend() == "pardiso" else SuperLU()


class SuperLU:
    """The fallback that scipy brings along."""

    def __init__(self) -> None:
        self._lu: Any = None

    def update(self, upper: sparse.csr_array) -> None:
        from scipy.sparse.linalg import splu

        full = sparse.csc_array(upper + sparse.triu(upper, 1).T)
        options = {"SymmetricMode": True}
        try:
            self._lu = splu(full, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from None

    def solve(self, right: Floats) -> Floats:
        return self._lu.solve(right)


class Pardiso:
    """MKL Pardiso for positive definite matrices; the analysis is made once."""

    def __init__(self) -> None:
        solver = _pardiso()
        assert solver is not None
        self._solver = copy(solver)
        self._solver.pt = np.zeros_like(solver.pt)
        self._solver.iparm = solver.iparm.copy()
        self._upper: sparse.csr_array | None = None

    def update(self, upper: sparse.csr_array) -> None:
        fresh = self._upper is None
        self._upper = upper
        self._solver.libmkl.MKL_Set_Num_Threads(1 if len(upper.indptr) <= THREADED else (os.cpu_count() or 1))
        self._call(12 if fresh else 22, np.zeros(len(upper.indptr) - 1))

    def solve(self, right: Floats) -> Floats:
        return self._call(33, np.asfortranarray(right))

    def _call(self, phase: int, right: Floats) -> Floats:
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._solver.set_phase(phase)
        try:
            return self._solver._call_pardiso(self._upper, right)
        except PyPardisoError as error:
            raise ArithmeticError(str(error)) from None

    def __del__(self) -> None:
        if self._upper is not None and not sys.is_finalizing():
            self._call(-1, np.zeros(len(self._upper.indptr) - 1))


@cache
def _pardiso() -> Any:
    """A solver of pypardiso to copy (it looks for the library on the disk when it is made), or None."""
    # Left to itself pypardiso searches the whole environment for the library, which takes a second.
    library = sorted([*Path(sys.prefix, "lib").glob("libmkl_rt*"), *Path(sys.prefix, "Library", "bin").glob("mkl_rt*")])
    if library:
        os.environ.setdefault("PYPARDISO_MKL_RT", str(library[-1]))
    try:
        from pypardiso.pardiso_wrapper import PyPardisoSolver

        return PyPardisoSolver(mtype=2)
    except (ImportError, OSError):
        return None
