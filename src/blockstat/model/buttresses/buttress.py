"""Buttresses as stems that meet a wall, with a far end that steps or slopes back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.walling.brickwork import SLIVER, brickwork
from blockstat.model.walling.levels import bed_levels, nearest
from blockstat.model.walling.pattern import fitted
from blockstat.model.walling.row import Gap, Row
from blockstat.model.walling.run import Buttress, Run, one_of, spaced
from blockstat.model.walling.strip import Line, Strip, upright


def buttress_strips(strips: Sequence[Strip], buttresses: Sequence[Buttress]) -> Iterator[tuple[int, Strip, bool]]:
    """Stems of buttresses as (index of the strip they stand at, stem, whether bonded into it).

    Groups "buttress.<run>.<k>", k from 1 in the order given along each run.
    """
    count: dict[str, int] = {}
    for number, spec in enumerate(buttresses):
        label = f'buttresses[{number}] of wall "{spec.wall}"'
        host = _host(strips, spec, label)
        strip = strips[host]
        _check(spec, label)
        length = strip.axis.length
        places = spaced(length, spec.number) if spec.at is None else [float(s) for s in spec.at]
        for s in places:
            if not spec.width / 2 <= s <= length - spec.width / 2:
                raise InputError(f"{label}: a width of {spec.width:g} m at {s:g} m does not fit {length:g} m of wall")
        nearby = np.diff(np.sort(places))
        if len(nearby) and nearby.min() < spec.width * (1 - 1e-9):
            raise InputError(f"{label}: {len(places)} of {spec.width:g} m width do not fit {length:g} m of wall")
        for s in places:
            k = count[spec.wall] = count.get(spec.wall, 0) + 1
            yield host, _stem(strip, spec, s, k, label), spec.bonded


def _host(strips: Sequence[Strip], spec: Buttress, label: str) -> int:
    found = [i for i, strip in enumerate(strips) if strip.run.name == spec.wall]
    if not found:
        known = ", ".join(dict.fromkeys(strip.run.name for strip in strips))
        raise InputError(f"{label}: there is no such wall; walls are: {known}")
    if not 0 <= spec.segment < len(found):
        raise InputError(f"{label}: segment is {spec.segment}; its path has {len(found)} stretches")
    return found[spec.segment]


def _check(spec: Buttress, label: str) -> None:
    positive(
        **{f"{label}: width": spec.width, f"{label}: projection": spec.projection, f"{label}: height": spec.height}
    )
    one_of(label, side=(spec.side, ("left", "right")))
    at_least(0, **{f"{label}: number": spec.number})
    if not 0 <= spec.weathering or not 0 <= spec.rake:
        raise InputError(f"{label}: weathering and rake must be at least 0")


def _stem(host: Strip, spec: Buttress, s: float, k: int, label: str) -> Strip:
    """One buttress; its axis begins on the middle of the wall."""
    assert isinstance(host.axis, Line)
    axis, middle = host.axis, (host.right[0] + host.left[0]) / 2
    sign = 1.0 if spec.side == "left" else -1.0
    face = (host.left[0] - host.right[0]) / 2
    origin = axis.origin + s * axis.along + middle * axis.across
    run = Run(name=f"{spec.wall}.buttress.{k}", path=[(0, 0), (1, 0)], thickness=spec.width, height=spec.height)
    top = nearest(host.levels, spec.height)
    if spec.height > host.levels[-1] + (host.levels[-1] - host.levels[-2]) / 2:
        raise InputError(f"{label}: height is {spec.height:g} m; the walls reach {host.levels[-1]:g} m")
    ends = far_end(host.levels[: top + 1], spec, face, label)
    stem = Line(origin, sign * axis.across, ends[0][1])
    half = spec.width / 2
    group = f"buttress.{spec.wall}.{k}"
    return Strip(run, stem, (-half, 0.0), (half, 0.0), host.levels, top, top, group, ends=ends)


def far_end(levels: Sequence[float], spec: Buttress, face: float, label: str) -> tuple[tuple[float, float], ...]:
    """Outline (z, s) of the far end from the ground up, corners on beds, over s = face at its foot [m]."""
    outline = [(0.0, spec.projection)]
    before = spec.projection
    for height, projection in spec.steps:
        low = levels[nearest(levels, height)]
        high = levels[nearest(levels, low + spec.weathering)]
        if not outline[-1][0] <= low < levels[-1] or not 0 <= projection < before:
            raise InputError(f"{label}: steps is {list(spec.steps)!r}; heights must grow and projections decrease")
        outline += [(low, before), (high, projection)]
        before = projection
    outline.append((levels[-1], before))
    ends = [(z, face + p - spec.rake * z) for z, p in outline]
    if min(s for _, s in ends) < face - 1e-9 * spec.projection:
        raise InputError(f"{label}: its outer face slopes back into the wall; reduce rake or raise the projection")
    return tuple((float(z), float(s)) for z, s in ends)


def buttress(
    *,
    width: float,
    projection: float,
    height: float,
    steps: Sequence[tuple[float, float]] = (),
    weathering: float = 0.0,
    rake: float = 0.0,
    brick: tuple[float, float] = (0.5, 0.25),
) -> list[Block]:
    """One buttress that stands against an upright face in the plane y = 0, centred at x = 0, towards y > 0.

    Parameters as those of `Buttress`; brick : nominal length and height of its stones [m]. Group "buttress", names
    "buttress.<course>.<i>". Buttresses bonded into a wall are made with the wall, by `blockstat.model.walling.walls`.
    """
    spec = Buttress(
        wall="", width=width, projection=projection, height=height, steps=steps, weathering=weathering, rake=rake
    )
    _check(spec, "buttress")
    positive(**{"brick[0]": brick[0], "brick[1]": brick[1]})
    levels = bed_levels([height], brick[1], SLIVER)
    ends = far_end(levels, spec, 0.0, "buttress")
    run = Run(name="buttress", path=[(0, 0), (0, 1)], thickness=width, height=height)
    axis = Line(np.zeros(2), np.array([0.0, 1.0]), projection)
    top = len(levels) - 1
    strip = Strip(run, axis, (-width / 2, 0.0), (width / 2, 0.0), levels, top, top, "buttress", ends=ends)
    pattern = fitted(run, brick[0], (0.0, None), (projection, None))
    foot = Gap(upright(0.0), upright(0.0), "the wall")
    rows = []
    for course in range(top):
        end = strip.far_end(course)
        rows.append(Row(strip, course, foot, Gap(end, end, "its end"), pointed=True))
    return brickwork(rows, pattern, SLIVER, {})
