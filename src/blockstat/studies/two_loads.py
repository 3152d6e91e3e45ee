"""Domains of two loads: limit loads along rays from the dead load, put together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.overlap.searched import searched_joints
from blockstat.errors import InputError, check_count, known_options
from blockstat.loads import as_load
from blockstat.result import Result, Sentence
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Two loads whose cosine is nearer to one than this are one load.
PARALLEL = 1e-9


class DomainOutcome(Sentence):
    """The answer of `load_domain`; the value is the sentence a user reads."""

    BOUNDED = "Bounded: every pair of multipliers in the inner polygon is carried, none outside the outer one."


@dataclass(frozen=True, eq=False)
class LoadDomain(Result):
    """Pairs of multipliers (x, y) of two loads that are carried: between two polygons."""

    inner: Floats  #: shape (n, 2), proven by force fields, counter-clockwise
    outer: Floats  #: shape (n, 3), rows (a, b, c) of half-planes a x + b y <= c, proven by mechanisms
    warnings: tuple[str, ...] = ()

    @property
    def outcome(self) -> DomainOutcome:
        """The domain is bounded; `load_domain` refuses others."""
        return DomainOutcome.BOUNDED

    def explain(self) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        (x0, y0), (x1, y1) = self.inner.min(axis=0), self.inner.max(axis=0)
        return "\n".join(
            [
                self.outcome.value,
                f"Inner polygon: {len(self.inner)} corners, x from {x0:.6g} to {x1:.6g}, y from {y0:.6g} to {y1:.6g}.",
                f"Outer polygon: {len(self.outer)} half-planes.",
                *(f"Warning: {text}" for text in self.warnings),
            ]
        )

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "inner": self.inner.tolist(),
            "outer": self.outer.tolist(),
            "warnings": list(self.warnings),
        }


@known_options
def load_domain(
    assembly: Assembly,
    one: Any,
    two: Any,
    *,
    directions: int = 32,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> LoadDomain:
    """Find the pairs of multipliers of two loads that an assembly carries, along rays from the dead load.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    one, two : array_like
        The two loads, each as in `blockstat.limit_load`.
    directions : int, optional
        Number of rays, evenly spread; at least 3.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    LoadDomain
        A polygon inside the domain and one around it.

    Raises
    ------
    InputError
        When the assembly does not stand, carries a combination without end, when the two loads are one, or for an
        option that does not exist.

    Notes
    -----
    Every ray is a limit analysis. Its force field is a corner of the inner polygon, its mechanism a half-plane of the
    outer one; the domain is convex because the friction is associated.

    Examples
    --------
    A pillar of 0.5 x 0.5 x 2 m tips at a quarter of its weight, to either side.

    >>> import numpy as np
    >>> from blockstat import Assembly, box, load_domain
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = load_domain(pillar, (1, 0, 0), (0, 1, 0), directions=4)
    >>> found.outcome.word, np.abs(found.inner).max().round(4).item()
    ('bounded', 0.25)
    """
    assembly = assembly if gravity is None else assembly.with_(gravity=gravity)
    first, second = as_load(assembly, one), as_load(assembly, two)
    check_count("directions", directions, least=3)
    told: tuple[str, ...] = ()
    if interfaces is None:
        interfaces, _, told = searched_joints(assembly, gap)
    free, other = (load[assembly.free] for load in (first, second))
    cosine = float((free * other).sum() / np.sqrt((free**2).sum() * (other**2).sum()))
    if abs(cosine) > 1 - PARALLEL:
        raise InputError("the two loads are the same but for their size; they span no domain")
    inner, outer = [], []
    for angle in np.linspace(0, 2 * np.pi, directions, endpoint=False):
        x, y = np.cos(angle), np.sin(angle)
        limit = limit_load(
            assembly, x * first + y * second,
            friction=friction, loads=loads, gap=gap, interfaces=interfaces, solver=solver, optimum=True,
        )  # fmt: skip
        if limit.outcome is not LoadOutcome.LIMIT:
            raise InputError(f"along ({x:.3g}, {y:.3g}): {limit.outcome.value}")
        told = (*told, *limit.warnings)
        inner.append((limit.lower * x, limit.lower * y))
        a, b = (float((load * limit.mechanism).sum()) for load in (first, second))
        outer.append((a, b, limit.upper * (a * x + b * y)))
    return LoadDomain(np.array(inner), np.array(outer), tuple(dict.fromkeys(told)))
