"""Piers that begin to tip about several edges at once: the corner between them is a ridge."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, box, capacity

HEIGHT = 2.0


def pier(width, depth, courses=1):
    """On the ground, away from the origin, turned about the vertical by .4."""
    step = HEIGHT / courses
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground")]
    for k in range(courses):
        blocks.append(box((0.37, 0.185, k * step), (0.37 + width, 0.185 + depth, (k + 1) * step), name=f"drum{k}"))
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.9)


@pytest.mark.parametrize("courses", [1, 4])
@pytest.mark.parametrize("turn", [0.0, 0.4, 2.1])
@pytest.mark.parametrize(("width", "depth"), [(0.5, 0.5), (0.8, 0.4), (0.4, 0.8)])
def test_a_pier_pushed_along_its_diagonal_tips_about_the_edge_that_gives_way_first(width, depth, turn, courses):
    """About either edge it tips at diagonal / height, as a / cos = b / sin along the diagonal of a by b.

    It is over the edge when its centroid has moved by a / 2 across it: the control, along the push, by a / 2 cos for
    one edge and b / 2 sin for the other. On the corner between them it would be so at half the diagonal.
    """
    diagonal = np.hypot(width, depth)
    for push in ((width, depth, 0), (-width, depth, 0)):
        whole = Rotation.from_rotvec([0, 0, turn]).as_matrix()
        scene = pier(width, depth, courses)
        scene = scene.with_(vertices=scene.vertices @ whole.T)
        curve = capacity(scene, whole @ push, control="mean")
        assert curve.lower[0] == pytest.approx(diagonal / HEIGHT, rel=1e-4)
        assert curve.outcome.word == "zero"
        assert curve.displacement[-1] == pytest.approx(0.5 * min(width, depth) ** 2 / diagonal, rel=1e-3)


def test_beside_the_diagonal_one_edge_alone_is_the_mechanism():
    """Nearer to the long side the pier tips over the long edge, at its width over its height by the cosine."""
    push = np.array([0.8, 0.4 - 1e-3, 0.0])
    curve = capacity(pier(0.8, 0.4), push, control="mean")
    cosine = push[0] / np.linalg.norm(push)
    assert curve.lower[0] == pytest.approx(0.8 / HEIGHT / cosine, rel=1e-4)
    assert curve.displacement[-1] == pytest.approx(0.4 * cosine, rel=1e-3)


def test_of_two_equal_piers_the_one_that_is_the_control_rolls_off_its_corner():
    """The other one is left at rest, and told. By hand as for one pier: half of .5 by half of the square root of 2."""
    blocks = [box((-5, -5, -1), (9, 9, 0), name="ground")]
    blocks += [box((x, 0, 0), (x + 0.5, 0.5, HEIGHT), name=name) for x, name in ((0, "one"), (4, "other"))]
    scene = Assembly.from_blocks(blocks, supports=["ground"], friction=0.9)
    curve = capacity(scene, (1, 1, 0), control="one")
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.25 / np.sqrt(2), rel=1e-3)
    (told,) = [text for text in curve.warnings if "same multiplier" in text]
    assert told.endswith('are left at rest: "other"')
    assert not curve.points[-1].pose.displacement[2].any()
