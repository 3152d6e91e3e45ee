"""A buttress by itself, against a face that is not a wall's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.model.arches.profile import positive
from blockstat.model.walling.brickwork import SLIVER
from blockstat.model.walling.run import Buttress
from blockstat.model.walling.stems import against_face, check_buttress
from blockstat.model.walling.strip import Line, bed_levels


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
    check_buttress(spec, "buttress")
    positive(**{"brick[0]": brick[0], "brick[1]": brick[1]})
    levels = bed_levels([height], brick[1], SLIVER)
    place = Line(np.zeros(2), np.array([0.0, 1.0]), projection)
    return against_face(spec, place, levels, "buttress", brick[0], "buttress")
