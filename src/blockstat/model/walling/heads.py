"""What spans an opening: a lintel, a flat arch, or a voussoir arch, and the void it leaves in each course.

The extrados of an arch is a convex polygon with its corners on beds, so that in every course one plane a side cuts the
bricks beside it: bricks and voussoirs are convex and share the planes between them.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from blockstat.errors import InputError, InputWarning, with_article
from blockstat.geometry import clipping as clip
from blockstat.model.arches.profile import at_least, half_joints, positive, profile, whole_joints
from blockstat.model.walling.row import Gap
from blockstat.model.walling.run import Opening, spaced
from blockstat.model.walling.strip import Strip, nearest, upright
from blockstat.typing import Floats

FLATTEST = 1.0  #: slope of the top facets of an extrados: the feather edge of a brick over it has at least 45 degrees
SKEWBACK = 0.5  #: sine of the least slope of a skewback (30 degrees); flatter springing joints are made level
DRAWN = 5e-4  #: half of the millimetre to which drawings are rounded: what moves by less is not told [m]
SKEW = 20.0  #: of a flat arch by default [degrees]
KEY = 0.5  #: least half width of the flat top of an extrados, as a fraction of the depth of the arch


@dataclass(frozen=True, eq=False)
class Head:
    """An opening of a strip with what spans it."""

    gaps: dict[int, Gap]  #: by course
    stones: list[Floats] = field(default_factory=list)  #: outlines in s, z, shape (k, 2)
    kind: str = "arch"  #: "arch" or "lintel", the group of the stones


def heads(strip: Strip, brick: float, nominal: float) -> list[Head]:
    """All openings of a strip with what spans them, in the order given.

    Parameters
    ----------
    strip : Strip
        A stretch of a run.
    brick : float
        Length of a brick [m].
    nominal : float
        Nominal height of a course [m].

    Returns
    -------
    list of Head
        One for each opening; several where an opening is repeated.
    """
    found: list[Head] = []
    for k, opening in enumerate(strip.run.openings):
        if opening.segment != strip.segment or not opening.present:
            continue
        label = f'wall "{strip.run.name}": openings[{k}]'
        places = centres(opening, strip, label)
        if not places:
            continue
        bottom, top = _beds(opening, strip, nominal, label)
        chain, stones = _spanning(opening, strip, top, brick, nominal, label)
        found += [_head(opening, strip, (bottom, top), centre, chain, stones, label) for centre in places]
    return found


def centres(opening: Opening, strip: Strip, label: str) -> list[float]:
    """Where the centres of an opening are along its strip.

    Parameters
    ----------
    opening : Opening
        One or several equal ones.
    strip : Strip
        The stretch of wall that they are in.
    label : str
        What messages call the opening.

    Returns
    -------
    list of float
        Distances from the beginning of the strip [m].

    Raises
    ------
    InputError
        For a place beyond the wall, or more openings than fit.
    """
    length = strip.axis.length
    if opening.at is None:
        number = opening.count
        if number * opening.width > length * (1 - 1e-9):
            what = "an opening" if number == 1 else f"{number} openings"
            fit = f"{'does' if number == 1 else 'do'} not fit {length:.3g} m of wall"
            raise InputError(f"{label}: {what} of {opening.width:.3g} m width {fit}")
        return spaced(length, number)
    places = [float(s) for s in opening.at]
    if not all(0 < s < length for s in places):
        raise InputError(f"{label}: at is {opening.at!r}; the wall is {length:g} m long")
    return places


def tell_moved(
    label: str, asked: Sequence[float], built: Sequence[float], moves: str = "sill and top go to the nearest bed"
) -> None:
    """Warn where something is built at other heights than asked, for its lower and its upper end lie on beds.

    Parameters
    ----------
    label : str
        What messages call it.
    asked, built : sequence of two floats
        Lower and upper end [m]; of an opening its sill and its top.
    moves : str
        What goes where, as the message ends.

    Warns
    -----
    InputWarning
        With both heights, where one of them moves by more than `DRAWN`.
    """
    if any(abs(a - b) > DRAWN for a, b in zip(asked, built, strict=True)):
        low, high = (" to ".join(f"{z:.4g}" for z in ends) for ends in (asked, built))
        text = f"{label}: asked from {low} m, built from {high} m: {moves}"
        warnings.warn(InputWarning(text), stacklevel=2)


def _beds(opening: Opening, strip: Strip, nominal: float, label: str) -> tuple[int, int]:
    """Numbers of the beds on which sill and springing of an opening lie."""
    levels = np.array(strip.levels[: strip.ridge + 1])
    bottom = nearest(levels, opening.sill)
    top = max(nearest(levels, opening.sill + opening.height), bottom + 1)
    if top >= len(levels):
        top = len(levels) - 1
    if top <= bottom or levels[top] < opening.sill + opening.height - nominal:
        raise InputError(f"{label}: sill and height reach beyond the wall of {levels[-1]:.3g} m")
    tell_moved(label, (opening.sill, opening.sill + opening.height), (levels[bottom], levels[top]))
    return bottom, top


def _spanning(
    opening: Opening, strip: Strip, top: int, brick: float, nominal: float, label: str
) -> tuple[Floats, list[Floats]]:
    """Right side of what spans an opening and its stones, over the middle of its soffit on the bed `top`."""
    levels = np.array(strip.levels[top : strip.ridge + 1])
    beds = levels - levels[0]
    if opening.head == "lintel":
        chain, stones = _lintel(opening, beds, brick, nominal)
    else:
        chain, stones = _arch(opening, beds, nominal, label)
    if chain is None or stones is None:
        deep = "" if opening.depth is None else f" of {opening.depth:g} m depth"
        raise InputError(
            f"{label}: sill and height reach {levels[0]:.3g} m; {with_article(opening.head)} head{deep} over it "
            f"reaches above the wall of {levels[-1]:.3g} m"
        )
    if opening.head == "lintel" and opening.depth is not None:
        asked, built = (levels[0], levels[0] + opening.depth), (levels[0], levels[0] + chain[-1, 1])
        tell_moved(f"{label}: depth", asked, built, "the top of a lintel goes to the nearest bed")
    return chain, stones


def _head(
    opening: Opening,
    strip: Strip,
    ends: tuple[int, int],
    centre: float,
    chain: Floats,
    stones: list[Floats],
    label: str,
) -> Head:
    """An opening about its centre, in each course a gap as wide as the jambs or the head."""
    levels, (bottom, top) = strip.levels[: strip.ridge + 1], ends
    half = opening.width / 2
    jambs = Gap(upright(centre - half), upright(centre + half), label)
    gaps = dict.fromkeys(range(bottom, top), jambs)
    x, z = chain.T
    for course in range(top, len(levels) - 1):
        low, high = (levels[k] - levels[top] for k in (course, course + 1))
        if low > z[-1] - 1e-9 * (high - low):
            break
        a, b = np.interp([low, high], z, x)
        slope = (b - a) / (high - low)
        foot = a - slope * levels[course]
        gaps[course] = Gap((centre - foot, 0.0, -slope), (centre + foot, 0.0, slope), label)
    kind = "lintel" if opening.head == "lintel" else "arch"
    return Head(gaps, [stone + (centre, levels[top]) for stone in stones], kind)


def bearing_of(opening: Opening, brick: float) -> float:
    """Length of the wall that a lintel bears on at each side.

    Parameters
    ----------
    opening : Opening
        The one that it spans.
    brick : float
        Length of a brick [m].

    Returns
    -------
    float
        As asked, or half a brick [m].
    """
    return brick / 2 if opening.bearing is None else opening.bearing


def _lintel(opening: Opening, beds: Floats, brick: float, nominal: float) -> tuple[Floats | None, list[Floats] | None]:
    """Right side of a lintel and its outline, over the middle of the soffit."""
    bearing = bearing_of(opening, brick)
    depth = nominal if opening.depth is None else opening.depth
    positive(bearing=bearing, depth=depth)
    if len(beds) < 2 or (opening.depth is not None and depth > beds[-1] + nominal / 2):
        return None, None
    high = beds[max(nearest(beds, depth), 1)]
    x = opening.width / 2 + bearing
    return np.array([(x, 0.0), (x, high)]), [np.array([(-x, 0.0), (x, 0.0), (x, high), (-x, high)])]


def _arch(opening: Opening, beds: Floats, nominal: float, label: str) -> tuple[Floats | None, list[Floats] | None]:
    """Right side of the extrados of an arch, from the springing up, and the outlines of its voussoirs."""
    depth = nominal if opening.depth is None else opening.depth
    positive(**{f"{label}: depth": depth})
    try:
        inner, outward = _flat(opening, depth, nominal) if opening.head == "flat" else _round(opening, depth, nominal)
    except InputError as error:
        raise InputError(f"{label}: {error}") from None
    crown = depth if opening.head == "flat" else inner[:, 1].max() + depth
    if opening.head in ("pointed",):
        crown = profile(opening.head, opening.width, opening.rise).extrados(np.zeros(1), depth)[0]
    above = np.flatnonzero(beds >= crown - 1e-9 * nominal)
    if not len(above):
        return None, None
    chain = _extrados(opening, inner[-1], outward[-1], depth, beds[: above[0] + 1])
    if chain is None:
        return None, None
    foot = chain if abs(chain[0, 0] - inner[-1, 0]) < 1e-9 * depth else np.vstack([inner[-1], chain])
    outline = np.vstack([foot, foot[::-1] * (-1.0, 1.0)])
    return chain, _voussoirs(inner, outward, outline)


def _round(opening: Opening, depth: float, nominal: float) -> tuple[Floats, Floats]:
    """Joints of a voussoir arch from left to right: their points on the intrados and unit vectors out of it."""
    half = profile(opening.head, opening.width, opening.rise)
    number = opening.voussoirs
    if number is None:
        number = max(round(2 * half.length / nominal), 3)
        number += (number % 2 == 1) if half.crown_joint else (number % 2 == 0)
    at_least(2, voussoirs=number)
    joints = whole_joints(half_joints(opening.head, opening.width, opening.rise, depth, number, "radial"), number)
    across = joints[:, 1] - joints[:, 0]
    if half.crown_joint:
        across[number // 2] = (0.0, 1.0)
    across = across / np.linalg.norm(across, axis=1)[:, None]
    if across[-1, 1] < SKEWBACK:
        across[0], across[-1] = (-1.0, 0.0), (1.0, 0.0)
    return joints[:, 0], across


def _flat(opening: Opening, depth: float, nominal: float) -> tuple[Floats, Floats]:
    """Joints of a flat arch, as `_round`; they point to one place below."""
    skew = SKEW if opening.skew is None else opening.skew
    if not 0 <= skew <= 60:
        raise InputError(f"skew is {skew!r}; it must be an angle from 0 to 60 degrees")
    number = opening.voussoirs
    if number is None:
        number = 2 * (max(round(opening.width / nominal), 3) // 2) + 1
    at_least(2, voussoirs=number)
    x = opening.width / 2 * (2 * np.arange(number + 1) / number - 1)
    across = np.column_stack([x * np.tan(np.deg2rad(skew)) / (opening.width / 2), np.ones_like(x)])
    return np.column_stack([x, np.zeros_like(x)]), across / np.linalg.norm(across, axis=1)[:, None]


def _extrados(opening: Opening, foot: Floats, out: Floats, depth: float, beds: Floats) -> Floats | None:
    """Right side of the extrados, corners on beds, shape (k, 2), heights ascending; the last is the end of its top.

    foot : springing on the intrados; out : direction of the springing joint. A sloping one is a skewback and goes on to
    the first bed above the depth of the arch.
    """
    top = float(beds[-1])
    if out[1] > 1e-9:
        above = np.flatnonzero(beds >= min(depth * out[1], top) - 1e-9 * depth)
        first = max(int(above[0]), 1)
        start = foot + out * (beds[first] - foot[1]) / out[1]
        chain = [(float(foot[0]), 0.0), (float(start[0]), float(beds[first]))]
    else:
        first, chain = 0, [(float(foot[0] + depth), 0.0)]
    if first == len(beds) - 1:
        return np.array(chain)
    chain += _curve(opening, depth, beds[first + 1 : -1], chain[-1][0], KEY * depth)
    least = 1 if out[1] > 1e-9 else 0
    for last in range(len(chain) - 1, least - 1, -1):
        x, z = chain[last]
        key = min(KEY * depth, x / 2)
        end = max(x - (top - z) / FLATTEST, key)
        steep = np.inf if last == least else (z - chain[last - 1][1]) / (chain[last - 1][0] - x)
        if (top - z) / (x - end) < steep * (1 - 1e-9):
            return np.array([*chain[: last + 1], (end, top)])
    return None


def _curve(opening: Opening, depth: float, beds: Floats, widest: float, narrowest: float) -> list[tuple[float, float]]:
    """Where the curve of an extrados meets beds, on its right side between two half widths."""
    if opening.head == "flat" or not len(beds):
        return []
    half = profile(opening.head, opening.width, opening.rise)
    s = np.linspace(0.0, 1.0, 1025)
    x, z = (half.curve(s) + depth * half.normal(s)).T
    found, before = [], widest
    for bed in beds[(beds > z[0]) & (beds < z[-1])]:
        place = float(np.interp(bed, z, x))
        if narrowest < place < before * (1 - 1e-9):
            found.append((place, float(bed)))
            before = place
    return found


def _voussoirs(inner: Floats, outward: Floats, outline: Floats) -> list[Floats]:
    """Wedges between joints and chords of the intrados, inside an outline, each a convex polygon."""
    far = inner + outward * 8 * np.ptp(outline)
    window = np.stack([inner[:-1], inner[1:], far[1:], far[:-1]], axis=1)
    polygon, count = clip.clip(np.repeat(outline[None], len(window), axis=0), window)
    size = np.full(len(window), 1e-9 * np.ptp(outline))
    keep = clip.corners(polygon, count, size)
    return [points[mask] for points, mask in zip(polygon, keep, strict=True)]
