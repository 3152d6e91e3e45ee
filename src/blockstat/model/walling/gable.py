"""The slopes of a gable: planes that end its courses, and coping stones on them."""

from __future__ import annotations

import math

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.walling.row import Gap
from blockstat.model.walling.run import Coping
from blockstat.model.walling.strip import Strip
from blockstat.typing import Floats

FOOT_STONE = 1.05  #: least length of a raked stone, as a multiple of what its upright joint takes from its back


def slopes(strip: Strip, foot: tuple[float, float]) -> tuple[Gap, Gap]:
    """Left and right slope of a gable as ends of the courses above the eaves.

    Parameters
    ----------
    strip : Strip
        The wall with the gable.
    foot : tuple of float
        Where the slopes begin along the strip [m].

    Returns
    -------
    tuple of Gap
        Left and right.
    """
    z0, z1 = strip.levels[strip.top], strip.levels[strip.ridge]
    run = (foot[1] - foot[0]) / 2 / (z1 - z0)  # along the wall for each metre of height
    left = (foot[0] - run * z0, 0.0, run)
    right = (foot[1] + run * z0, 0.0, -run)
    return Gap(left, left, "its slope"), Gap(right, right, "its slope")


def raked_coping(strip: Strip, foot: tuple[float, float], coping: Coping, brick: tuple[float, float]) -> list[Block]:
    """Coping stones on both slopes of a gable.

    Parameters
    ----------
    strip : Strip
        The wall with the gable.
    foot : tuple of float
        Where the slopes begin along the strip [m].
    coping : Coping
        Sizes of the stones.
    brick : tuple of float
        Length and height of a brick, from which default sizes follow [m].

    Returns
    -------
    list of Block
        Group "wall.<run>.coping", from left to right.
    """
    group, over = f"{strip.group}.coping", coping.overhang
    faces = ((strip.right[0] - over, strip.right[1]), (strip.left[0] + over, strip.left[1]))
    sections = _stones(strip, foot, coping.height or brick[1], coping.length, 2 * brick[0])
    return [strip.slab(section, f"{group}.0.{i}", group, faces) for i, section in enumerate(sections)]


def _stones(strip: Strip, foot: tuple[float, float], height: float, asked: float | None, usual: float) -> list[Floats]:
    """Outlines in s, z of coping stones, joints square to the slope; foot and ridge joints are upright."""
    length = usual if asked is None else asked
    if not height > 0 or not length > 0:
        raise InputError(f'wall "{strip.run.name}": height and length of its coping must be above 0')
    z0, z1 = strip.levels[strip.top], strip.levels[strip.ridge]
    low, ridge = np.array([foot[0], z0]), np.array([(foot[0] + foot[1]) / 2, z1])
    along = (ridge - low) / np.linalg.norm(ridge - low)
    normal = np.array([-along[1], along[0]])
    reach, lift = float(np.linalg.norm(ridge - low)), height / along[0]
    # The upright joint at the foot leans over the first stone by the rise of its back there.
    least = FOOT_STONE * height * float(along[1] / along[0])
    number = max(min(round(reach / length), math.floor(reach / least)), 1)
    if asked is not None and asked < min(least, reach):
        raise InputError(
            f'wall "{strip.run.name}": coping.length is {asked:g}; stones of {height:g} m height on this slope must be '
            f"at least {min(least, reach):.3g} m long"
        )
    left = []
    for k in range(number):
        (a, b), up = (low + along * reach * np.array([[k], [k + 1]]) / number), height * normal
        top_a = a + (0.0, lift) if k == 0 else a + up
        top_b = b + (0.0, lift) if k == number - 1 else b + up
        left.append(np.array([a, b, top_b, top_a]))
    mirror = np.array([2 * ridge[0], 0.0])
    return left + [mirror + stone[::-1] * (-1.0, 1.0) for stone in reversed(left)]
