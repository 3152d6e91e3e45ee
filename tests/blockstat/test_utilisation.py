"""Use of joints against statics by hand."""

import numpy as np
import pytest
import shapely

from blockstat import JointLaw, assess, find_interfaces
from blockstat.view.utilisation import eccentricity, plot_utilisation, utilisation
from evidence.references.arches import POLY
from evidence.scenes.small import arch, assembly, box, hexahedron, stack


@pytest.mark.parametrize(
    ("width", "height", "push", "friction", "expected"),
    [
        # A block under a slanting weight: the centre of pressure is h/2 tan from the middle of w, friction is tan/mu.
        (1.0, 2.0, 0.3, 0.7, 0.6),
        (2.0, 0.5, 0.6, 0.7, 0.6 / 0.7),
        (2.0, 0.5, 0.6, np.inf, 0.15),
        (1.0, 1.0, 0.0, 0.7, 0.0),
    ],
)
def test_one_block(width, height, push, friction, expected):
    verdict = assess(stack(1, width, height, friction=friction), gravity=(push, 0, -1))
    assert utilisation(verdict) == pytest.approx([expected], abs=1e-6)


def test_joints_higher_up_a_stack_use_less():
    # Above joint k of n cubes the resultant falls (n - k)/2 tan from the middle.
    verdict = assess(stack(3), gravity=(0.2, 0, -1))
    order = np.argsort(verdict.interfaces.pair[:, 0])
    np.testing.assert_allclose(utilisation(verdict)[order], [0.6, 0.4, 0.2 / 0.7], atol=1e-6)


def test_an_arch_near_its_limit_hinges():
    # Half a per cent above its least thickness five joints are all but hinges, as in Heyman's arch: crown, haunches
    # and springings.
    verdict = assess(arch(20, 1.005 * float(POLY[20])))
    assert verdict.outcome.word == "stable"
    near = np.sort(utilisation(verdict))
    assert (near[-5:] > 0.98).all()
    assert near[-6] < 0.95
    assert utilisation(assess(arch(20, 0.3))).max() < 0.9


def test_tension_gives_room():
    # A joint that holds T at each of its four points acts as if pressed by 4 T more: N = 1 + 4 T in both ratios.
    law = JointLaw(("*", "*"), bond=1.0)
    asm = assembly([box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 2))], joints=[law])
    verdict = assess(asm, gravity=(0.5, 0, -1))
    # Weight 2 with the bond of 1: the moment 0.5 x 2 x 1 at the pressure 3 is 1/3 off the middle of a half.
    assert utilisation(verdict) == pytest.approx([(1 / 3) / 0.5], abs=1e-6)


def test_joints_without_force_use_nothing_and_missing_glue_uses_all():
    # Two bricks side by side, nothing pressing them together.
    side = assembly([box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))], friction=0.0)
    verdict = assess(side)
    idle = verdict.interfaces.pair[:, 0] == 1
    assert idle.sum() == 1
    np.testing.assert_allclose(utilisation(verdict), 0.0, atol=1e-6)
    overhang = assembly([box((0, 0, -1), (1, 1, 0)), box((0.8, 0, 0), (2.8, 1, 1))])
    falling = assess(overhang)
    assert falling.outcome.word == "unstable"
    assert utilisation(falling) == pytest.approx([1.0])


def test_eccentricity_is_the_factor_by_which_the_patch_may_shrink():
    # A block on a quadrilateral, against scaling by shapely.
    plan = [(0, 0), (2, 0.1), (2.2, 1.0), (0.7, 1.6)]
    asm = assembly([box((-5, -5, -1), (5, 5, 0)), hexahedron([(*p, 0) for p in plan], [(*p, 1) for p in plan])])
    faces = find_interfaces(asm)
    patch = shapely.Polygon(plan)
    middle = patch.centroid
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, y = middle.x + rng.normal(scale=0.4), middle.y + rng.normal(scale=0.4)
        value = eccentricity(faces, np.array([[x, y, 0.0]]))[0]
        shrunk = shapely.affinity.scale(patch, value, value, origin=middle)
        assert shrunk.exterior.distance(shapely.Point(x, y)) == pytest.approx(0.0, abs=1e-9)
    assert eccentricity(faces, np.array([[middle.x, middle.y, 0.0]])) == pytest.approx([0.0], abs=1e-9)


def test_pictures_of_utilisation(tmp_path):
    from matplotlib.image import imread

    for name, asm in (("stands", arch(12, 0.2)), ("falls", arch(12, 0.08))):
        path = plot_utilisation(assess(asm), tmp_path / f"{name}.png", azimuth=30.0)
        pixels = imread(path)[..., :3]
        assert (np.ptp(pixels, axis=2) > 0.3).mean() > 0.01
