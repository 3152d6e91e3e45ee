"""Flying buttresses: a raking arch between the face of a wall and a pier that stands off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.geometry import clipping as clip
from blockstat.model.arches.column import pier as pier_blocks
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.placing import moved
from blockstat.model.quantities import Count, Length, Lengths, Size, Two
from blockstat.model.solids import box, prism
from blockstat.model.walling.run import one_of
from blockstat.typing import Floats

FORMS = ("arc", "straight")


def flying_buttress(
    form: str = "arc",
    *,
    span: Length,
    low: Size,
    high: Length,
    depth: Length,
    width: Length,
    voussoirs: Two,
    pier: Lengths | None = None,
    pier_height: Length | None = None,
    courses: Count = 1,
    pinnacle: Size = 0.0,
) -> list[Block]:
    """A raking arch in the plane x, z from a wall's face at x = 0 to a pier's face at x = span, centred at y = 0.

    Its ends are the upright planes of those faces.

    Parameters
    ----------
    form : str
        A ring whose soffit is level at the wall ("arc"), or a strut with joints square to it ("straight").
    span : float
        Clear between the faces [m].
    low : float
        Height of the soffit at the pier [m].
    high : float
        Height of the soffit at the wall [m].
    depth : float
        Of the voussoirs, normal to the soffit [m].
    width : float
        Along y [m].
    voussoirs : int
        Their number.
    pier : tuple of float, optional
        Its size along x and y, none by default [m].
    pier_height : float, optional
        By default the top of the flyer there [m].
    courses : int
        Of the pier.
    pinnacle : float
        Height of a block that weighs the pier down, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "flyer" (named from the wall outwards), "pier" and "pinnacle".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not fit the others.
    """
    positive(span=span, high=high, depth=depth, width=width)
    at_least(2, voussoirs=voussoirs)
    one_of("flying_buttress", form=(form, FORMS))
    if not 0 <= low < high:
        raise InputError(f"low is {low!r} and high {high!r}; the soffit must rise from the pier to the wall")
    if form == "arc" and not high - low < span:
        raise InputError(f"high - low is {high - low:g}; that of an arc must be less than the span, {span:g} m")
    of_pier = {"pier_height": pier_height, "courses": courses != 1, "pinnacle": pinnacle}
    if pier is None and any(of_pier.values()):
        given = next(key for key, value in of_pier.items() if value)
        raise InputError(f"{given} says nothing without a pier; give the size of one as pier")
    sections = _arc(span, low, high, depth, voussoirs) if form == "arc" else _strut(span, low, high, depth, voussoirs)
    blocks = []
    for i, section in enumerate(sections):
        x, z = section.T
        near, far = (np.column_stack([x, np.full(len(x), y), z]) for y in (-width / 2, width / 2))
        blocks.append(prism(near, far, name=f"flyer.{i}", group="flyer"))
    top = float(max(z for section in sections for x, z in section if x > span * (1 - 1e-9)))
    return blocks if pier is None else blocks + _pier(span, top, pier, pier_height, courses, pinnacle)


def _pier(
    span: float, top: float, size: Sequence[float], height: float | None, courses: int, pinnacle: float
) -> list[Block]:
    height = top if height is None else height
    if height < top * (1 - 1e-9):
        raise InputError(f"pier_height is {height:g}; the flyer meets the pier up to {top:g} m")
    shaft = pier_blocks(size=(size[0], size[1]), height=height, courses=courses)
    centre = span + size[0] / 2
    blocks = moved(shaft, (centre, 0.0, 0.0))
    if pinnacle:
        positive(pinnacle=pinnacle)
        x, y = size[0] / 2, size[1] / 2
        cap = box((-x, -y, height), (x, y, height + pinnacle), name="pinnacle", group="pinnacle")
        blocks += moved([cap], (centre, 0.0, 0.0))
    return blocks


def _arc(span: float, low: float, high: float, depth: float, number: int) -> list[Floats]:
    """Sections x, z of radial voussoirs with a straight soffit, the last cut off at the pier."""
    rise = high - low
    radius = (span**2 + rise**2) / (2 * rise)
    centre = np.array([0.0, high - radius])
    angle = np.arcsin(span / radius) * np.arange(number + 1) / number
    out = np.column_stack([np.sin(angle), np.cos(angle)])
    inner, outer = centre + radius * out, centre + (radius + depth) * out
    wedges = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]])[::-1] for k in range(number)]
    return _between(wedges, span)


def _strut(span: float, low: float, high: float, depth: float, number: int) -> list[Floats]:
    """Sections of a raking strut, its joints square to it and evenly spaced between the upright ends."""
    along = np.array([span, low - high])
    reach = np.linalg.norm(along)
    along = along / reach
    normal = np.array([-along[1], along[0]])
    # The joints may lean out of the ends: only those are kept that cut soffit and back between the upright planes.
    lean = depth * normal[0] / along[0]
    first, last = 0.0, reach - max(lean, 0.0)
    if last <= 0:
        raise InputError(
            f"depth is {depth:g}; joints square to a straight flyer as steep as this one need less than "
            f"{depth * reach / lean:.3g} m"
        )
    places = [-8 * reach, *np.linspace(first, last, number + 1)[1:-1], 9 * reach]
    start = np.array([0.0, high])
    points = [(start + along * s, start + along * s + depth * normal) for s in places]
    wedges = [np.array([a[0], a[1], b[1], b[0]])[::-1] for a, b in zip(points, points[1:], strict=False)]
    return _between(wedges, span)


def _between(wedges: list[Floats], span: float) -> list[Floats]:
    """Sections cut by the planes of the wall's face and the pier's face."""
    tall = 100 * max(float(np.abs(wedge).max()) for wedge in wedges)
    window = np.array([(0.0, -tall), (span, -tall), (span, tall), (0.0, tall)])
    batch = np.array(wedges)
    polygon, count = clip.clip(batch, np.repeat(window[None], len(batch), axis=0))
    keep = clip.corners(polygon, count, np.full(len(batch), 1e-9 * span))
    return [points[mask] for points, mask in zip(polygon, keep, strict=True)]
