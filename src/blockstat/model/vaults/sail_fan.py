"""Fan vaults and sail vaults: bays of curved surfaces cut as freeform vaults are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.quantities import Count, Edge, Length, Lengths, Size, Two
from blockstat.model.solids import below, fuse
from blockstat.model.vaults.freeform import Cells, freeform, height_field, stones
from blockstat.typing import Floats

CORNERS = {"ne": (1, 1), "nw": (-1, 1), "sw": (-1, -1), "se": (1, -1)}


def sail_vault(
    *,
    spans: Lengths,
    rise: Length,
    thickness: Length,
    courses: Two,
    voussoirs: Count,
    supports: Sequence[Edge] = ("south", "north", "west", "east"),
    springers: Size = 0.0,
) -> list[Block]:
    """A sail vault: a sphere over a rectangle through its corners at z = 0, centred on its origin.

    Parameters
    ----------
    spans : tuple of float
        Along x and y [m].
    rise : float
        Of the crown above the corners, less than half the diagonal [m].
    thickness : float
        Normal to the sphere, which is the middle surface [m].
    courses : int
        Their number along y.
    voussoirs : int
        In each course.
    supports : sequence of str
        Edges that have springers: south, north, west and east.
    springers : float
        Length of the blocks beyond these edges, 0 for none [m].

    Returns
    -------
    list of Block
        Groups as those of `freeform`.

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    _check_spans(spans)
    positive(rise=rise)
    reach = float(np.hypot(spans[0], spans[1])) / 2
    if not rise < reach:
        raise InputError(f"rise is {rise!r}; over this bay it must be less than half the diagonal, {reach:.4g} m")
    radius = (reach**2 + rise**2) / (2 * rise)
    x, y = ((-span / 2, span / 2) for span in spans)
    points = height_field(
        lambda x, y: np.sqrt(radius**2 - x**2 - y**2) - (radius - rise), x=x, y=y, courses=courses, voussoirs=voussoirs
    )
    return freeform(points, thickness=thickness, supports=supports, springers=springers)


def fan_vault(
    *, spans: Lengths, rise: Length, thickness: Length, foot: Length, rings: Two, voussoirs: Two, springers: Size = 0.0
) -> list[Block]:
    """A fan vault: four conoids about the corners of a bay, springing at z = 0, centred on its origin.

    Each conoid is a quarter of the surface that a quarter ellipse makes as it turns about the vertical through its
    corner: upright at the springing, level over the middle of the bay. The conoids meet over the middle lines, and bays
    side by side meet plane to plane.

    Parameters
    ----------
    spans : tuple of float
        Between the axes of the conoids, along x and y [m].
    rise : float
        Of the intrados at the middle of the bay [m].
    thickness : float
        Normal to the surface [m].
    foot : float
        Radius of the conoids' intrados at the springing, at least the thickness [m].
    rings : int
        Of each quarter conoid.
    voussoirs : int
        In each ring of a quarter, an even number.
    springers : float
        Height of the blocks under the conoids, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "vault.ne", ... and "springer.ne", ...

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    _check_spans(spans)
    positive(rise=rise, thickness=thickness, foot=foot)
    at_least(2, rings=rings, voussoirs=voussoirs)
    if voussoirs % 2:
        raise InputError(f"voussoirs is {voussoirs}; it must be even, for a joint in the diagonal")
    if not thickness <= foot < min(spans) / 2:
        raise InputError(
            f"foot is {foot!r}; it must be from the thickness, {thickness:g} m, to less than half the smaller span"
        )
    sides = _quarter(np.asarray(spans) / 2, rise, thickness, foot, rings, voussoirs)
    return [block for corner in CORNERS for block in _conoid(sides, corner, springers)]


def _check_spans(spans: Sequence[float]) -> None:
    if not (isinstance(spans, Sequence) and len(spans) == 2):
        raise InputError(f"spans is {spans!r}; it must be the two spans along x and y [m]")
    positive(**{"spans[0]": spans[0], "spans[1]": spans[1]})


def _quarter(half: Floats, rise: float, thickness: float, foot: float, rings: int, voussoirs: int) -> Floats:
    """Intrados and extrados of the conoid about the corner `half`, shape (2, rings + 1, 2 voussoirs + 1, 3) [m].

    Rows go from the springing up, columns from the edge along x to that along y.
    """
    reach = float(np.hypot(half[0], half[1]))
    diagonal = np.arctan2(half[1], half[0])
    angle = np.concatenate(
        [np.linspace(0, diagonal, voussoirs + 1), np.linspace(diagonal, np.pi / 2, voussoirs + 1)[1:]]
    )
    c, d = np.cos(angle), np.sin(angle)
    c[-1] = d[0] = 0.0
    with np.errstate(divide="ignore"):
        last = np.minimum(half[0] / c, half[1] / d)
    last[voussoirs] = reach
    # The ellipse r = reach - (reach - foot) cos a, z = rise sin a; equal lengths of it on each meridian.
    table = np.linspace(0, np.pi / 2, 2049)
    speed = np.hypot((reach - foot) * np.sin(table), rise * np.cos(table))
    length = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(table))])
    whole = np.interp(np.arccos((reach - last) / (reach - foot)), table, length)
    s = np.linspace(0, 1, rings + 1)[:, None]
    # Level at the springing; what a meridian is longer than the shortest is made up towards the crown.
    along = s * whole.min() + s**2 * (whole - whole.min())
    turn = np.interp(along, length, table)
    turn[-1] = np.arccos((reach - last) / (reach - foot))
    radius, height = reach - (reach - foot) * np.cos(turn), rise * np.sin(turn)
    inner = np.stack([half[0] - radius * c, half[1] - radius * d, height], axis=2)
    # Normal to the meridian, towards the axis at the springing and up at the crown.
    normal = np.stack([rise * np.cos(turn) * c, rise * np.cos(turn) * d, (reach - foot) * np.sin(turn)], axis=2)
    normal /= np.linalg.norm(normal, axis=2)[..., None]
    offset = normal.copy()
    # Where conoids meet, their joint is in the upright plane between them.
    for axis, columns in ((0, slice(0, voussoirs + 1)), (1, slice(voussoirs, None))):
        inner[-1, columns, axis] = 0.0
        offset[-1, columns, axis] = 0.0
    offset *= (thickness / (offset * normal).sum(axis=2))[..., None]
    return np.stack([inner, inner + offset])


def _conoid(sides: Floats, corner: str, springers: float) -> Iterator[Block]:
    """The voussoirs of one quarter and its springer."""
    sign = np.array([*CORNERS[corner], 1.0])
    cells = Cells(np.pad(sides * sign, ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge"))
    rows, columns = sides.shape[1] - 1, sides.shape[2] - 1
    for ring in range(rows):
        for i, (a, b) in enumerate(stones(columns, ring)):
            yield cells.block(ring, range(a, b), f"vault.{corner}.{ring}.{i}", f"vault.{corner}")
    if springers:
        positive(springers=springers)
        inner, outer = sides[:, 0] * sign
        parts = [below(np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]), springers) for k in range(columns)]
        yield fuse(parts, name=f"springer.{corner}", group=f"springer.{corner}")
