"""A slab that overhangs its table, and props of edges and corners without which it falls."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block
from evidence.scenes.small import box, prism

FORWARDS, BACKWARDS = (0, 1, 2), (2, 1, 0)
#: Turned about the vertical, a hundredth in size, far from the origin.
PLACES = [(0.0, 1.0, (0, 0, 0)), (0.4, 1e-2, (0, 0, 0)), (1.1, 1.0, (5e5, 5.4e6, 300)), (2.3, 1e-2, (5e5, 5.4e6, 300))]


def overhanging(prop, *, ends=0.8, place=PLACES[0], order=(0, 1, 2)):
    """A slab of 1.2 x 1 x 1 on a table, which ends at .8: its centroid is at .9 and falls without the prop at 1.5."""
    turn, scale, away = place
    table, slab = box((-1, -1, -1), (ends, 2, 0), name="table"), box((0.3, 0, 0), (1.5, 1, 1), name="slab")
    rotation = Rotation.from_rotvec([0, 0, turn]).as_matrix()
    blocks = [
        replace(block, vertices=scale * np.asarray(block.vertices) @ rotation.T + away)
        for block in (table, slab, replace(prop, name="prop"))
    ]
    asm = Assembly.from_blocks([blocks[k] for k in order], supports=["table", "prop"], density=2000.0, friction=0.7)
    return asm, rotation @ (1.0, 0, 0)


def apex(x, y=0.5, slope=1.0, depth=1.0):
    """A pillar whose pyramid of a roof has its tip at a place below the slab."""
    r = depth / slope
    roof = [(x + a * r, y + b * r, -depth) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corners = np.array([(x, y, 0), *roof, *(np.array(roof) - (0, 0, 1))])
    sides = [[1 + k, 5 + k, 5 + (k + 1) % 4, 1 + (k + 1) % 4] for k in range(4)]
    return Block(corners, [[8, 7, 6, 5], *sides, *([0, 1 + k, 1 + (k + 1) % 4] for k in range(4))])


def rising(inside, y=0.5):
    """A wedge whose ridge begins so far below the slab, crosses its lower edge at a place and rises beyond it."""
    first, last = (1.5 - inside, y, -0.5 * inside), (2.5, y, 0.5)
    foot = [(1.5 - inside, y - 0.3, -1), (1.5 - inside, y + 0.3, -1), (2.5, y - 0.3, -1), (2.5, y + 0.3, -1)]
    faces = [[3, 2, 0], [1, 4, 5], [2, 4, 1, 0], [1, 5, 3, 0], [3, 5, 4, 2]]
    return Block(np.array([first, last, *foot], dtype=float), faces)


def beside(angle, place=0.5):
    """A box whose upper edge crosses the lower edge of the slab at an angle and a place along it."""
    axis = np.array([1, 0, -1]) / np.sqrt(2)
    at = np.array([1.5, place, 0.0])
    block = box((1.5, 0, -1), (2.5, 1, 0))
    turn = Rotation.from_rotvec(angle * axis).as_matrix()
    return replace(block, vertices=(np.asarray(block.vertices) - at) @ turn.T + at)


def ridge(x):
    """A pillar whose roof has a ridge across the slab at a place below it."""
    corners = [(x + a, y, z) for y in (0, 1) for a, z in ((0, 0), (0.3, -1), (-0.3, -1))]
    return Block(np.array(corners, dtype=float), [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]])


def one_support(inside, *, edge):
    """The slab on a foot and, so far from its far rim, on a ridge of the same support, or on its tip: one joint."""
    tip = 1.5 - inside
    foot = [(-1, -1), (1.8, -1), (1.8, -0.6), (tip + 0.2, -0.6), (tip, 0), (tip - 0.2, -0.6)]
    bed = prism([*foot, (0.8, -0.6), (0.8, 0), (-1, 0)], 1.0, name="bed")
    if not edge:  # one end of the ridge is lower
        corners = np.array(bed.vertices)
        corners[4, 2] = -0.3
        halves = [[face] if len(face) > 4 else [face[:3], [face[0], *face[2:]]] for face in map(list, bed.faces)]
        bed = replace(bed, vertices=corners, faces=[half for own in halves for half in own])
    slab = box((0.3, -0.5, 0), (1.5, 1.5, 1), name="slab")
    return Assembly.from_blocks([bed, slab], supports=["bed"], density=2000.0, friction=0.7)
