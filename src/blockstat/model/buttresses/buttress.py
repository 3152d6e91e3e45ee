"""A buttress by itself, against a face that is not a wall's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.model.arches.profile import positive
from blockstat.model.quantities import Ends, Length, Lengths, Size
from blockstat.model.walling.brickwork import SLIVER
from blockstat.model.walling.run import Buttress
from blockstat.model.walling.stems import against_face, check_buttress
from blockstat.model.walling.strip import Line, bed_levels


def buttress(
    *,
    width: Length,
    projection: Length,
    height: Length,
    steps: Sequence[Ends] = (),
    weathering: Size = 0.0,
    rake: Size = 0.0,
    brick: Lengths = (0.5, 0.25),
) -> list[Block]:
    """A buttress that stands against an upright face in the plane y = 0, centred on its origin, towards y > 0.

    The buttresses of a wall are made with the wall, by `blockstat.model.walls`.

    Parameters
    ----------
    width : float
        Along x [m].
    projection : float
        Along y [m].
    height : float
        Above its foot [m].
    steps : sequence of tuple
        Height and projection above it, lowest first [m].
    weathering : float
        Height over which a step slopes back [m].
    rake : float
        Slope of the outer face [m per m of height].
    brick : tuple of float
        Nominal length and height of its stones [m].

    Returns
    -------
    list of Block
        Group "buttress", names "buttress.<course>.<i>".

    Raises
    ------
    InputError
        Naming the option that cannot be built.
    """
    spec = Buttress(
        wall="", width=width, projection=projection, height=height, steps=steps, weathering=weathering, rake=rake
    )
    check_buttress(spec, "buttress")
    positive(**{"brick[0]": brick[0], "brick[1]": brick[1]})
    levels = bed_levels([height], brick[1], SLIVER)
    place = Line(np.zeros(2), np.array([0.0, 1.0]), projection)
    return against_face(spec, place, levels, "buttress", brick[0], "buttress")
