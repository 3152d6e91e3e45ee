"""Paths of blocks whose corners are off by what files and far coordinates round, against those of plane joints."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, box, capacity, find_interfaces, settle_to_collapse
from blockstat.large_displacement.displaced.face_outlines import LARGEST_TILT, FaceOutlines
from blockstat.model import arch, assemble

TURN = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()


def noisy(scene, size, seed):
    off = np.random.default_rng(seed).uniform(-size, size, scene.vertices.shape)
    return scene.with_(vertices=scene.vertices + off)


def lintel(left=0.3, right=0.4):
    """2.2 m long, on bearings of two piers; friction .6."""
    ends = {"left": ((-0.5, 0, 0), (left, 1, 2)), "right": ((2.2 - right, 0, 0), (2.7, 1, 2))}
    ends["lintel"] = ((0, 0, 2), (2.2, 1, 2.4))
    blocks = [box(*corners, name=name) for name, corners in ends.items()]
    return Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.6)


def falls_at(scene, away=(1.0, 0, 0)):
    path = settle_to_collapse(scene, {"right": away}, displacement=0.4, steps=8)
    assert any("may be shared by several joints" in warning for warning in path.warnings)
    return path.collapse


@pytest.mark.parametrize(("size", "seed"), [(1e-9, 3), (1e-8, 4), (1e-7, 11), (1e-6, 12), (1e-5, 13)])
def test_a_lintel_with_corners_slightly_off_slides_on_its_shorter_bearing_alone(size, seed):
    """It falls when .3 m is used up. Were the slip shared, it would fall at .6 m.

    A bearing is longer or shorter by two corners, and its centre of pressure may be at an edge that is off by as much
    once more.
    """
    assert falls_at(noisy(lintel(), size, seed)) == pytest.approx(0.3, abs=4 * size + 1e-6)


@pytest.mark.parametrize(("offset", "digits"), [((5e5, 4.6e6, 0.0), None), ((0.0, 0.0, 0.0), 6)])
def test_a_lintel_that_is_turned_and_rounded_or_far_from_the_origin_falls_as_before(offset, digits):
    scene = lintel()
    vertices = scene.vertices @ TURN.T
    vertices = vertices + offset if digits is None else vertices.round(digits)
    turned = scene.with_(vertices=vertices, gravity=TURN @ scene.gravity)
    assert falls_at(turned, tuple(TURN @ (1.0, 0, 0))) == pytest.approx(0.3, abs=4e-6)


@pytest.mark.parametrize(("size", "seed"), [(1e-7, 0), (1e-6, 0), (1e-5, 1)])
def test_the_top_of_a_stack_slides_although_the_tilts_of_faces_make_a_lower_joint_weaker(size, seed):
    """Friction .3: the top block tips over the edge when its centre has moved by half its width.

    Each joint slides at .3. The tilt of its face, up to two corners over half the width, adds to that or takes away.
    """
    blocks = [box((-2, -2, -1), (4, 3, 0), name="ground")]
    blocks += [box((0, 0, k), (1, 1, k + 1), name=f"b{k}") for k in range(2)]
    stack = noisy(Assembly.from_blocks(blocks, supports=["ground"], friction=0.3), size, seed)
    curve = capacity(stack, (1, 0, 0), control="b1", steps=8)
    assert curve.outcome.word == "zero"
    assert curve.lower[0] == pytest.approx(0.3, abs=4 * size * (1 + 0.3**2) + 1e-6)
    assert curve.displacement[-1] == pytest.approx(0.5, abs=4 * size)
    assert any('"b0" and "b1" alone' in warning for warning in curve.warnings)


@pytest.mark.parametrize(("size", "seed"), [(1e-7, 0), (1e-7, 1), (1e-6, 1)])
def test_an_arch_with_corners_slightly_off_carries_to_where_the_exact_arch_does(size, seed):
    """Its four hinges are not quite parallel, so that taken literally it is rigid; the exact arch is a linkage."""
    ring = assemble(arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3), friction=0.7)
    exact, curve = (capacity(scene, (1, 0, 0), control="arch") for scene in (ring, noisy(ring, size, seed)))
    assert curve.outcome.word == exact.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(exact.displacement[-1], rel=1e-3)
    assert curve.lower[0] == pytest.approx(exact.lower[0], rel=1e-4)


def flaw_of(scene):
    return FaceOutlines(scene, find_interfaces(scene)).flaw


def test_the_flaw_of_faces_is_what_their_corners_are_off():
    """Each coordinate is off by size at most; a plane through four corners of a bearing of .3 m x 1 m is, too."""
    assert max(flaw_of(lintel())) < 1e-14
    found = flaw_of(noisy(lintel(), 1e-6, 5))
    assert 1e-7 < found.distance < 1e-5
    assert 1e-7 < found.tilt < 2e-5


def test_faces_that_are_far_from_plane_are_meant_so():
    assert flaw_of(noisy(lintel(), 100 * LARGEST_TILT, 5)) == (0.0, 0.0)


def test_a_path_by_steps_whose_joints_miss_planes_is_doubted():
    """The exact arch is a linkage."""
    ring = assemble(arch(span=1.5, thickness=0.16, depth=0.4, voussoirs=9, springers=0.3), friction=0.6)
    doubt = "faces of joints miss planes by up to"
    exact, curve = (capacity(scene, (1, 0, 0), control="arch") for scene in (ring, noisy(ring, 5e-6, 11)))
    assert not any(doubt in warning for warning in exact.warnings)
    right = curve.displacement[-1] == pytest.approx(exact.displacement[-1], rel=1e-2)
    assert right or any(doubt in warning for warning in curve.warnings)


def test_steps_along_a_curved_path_of_plane_joints_are_not_doubted():
    path = settle_to_collapse(lintel(), {"right": (0.0, 0.0, -1.0)})
    assert any("finite steps" in warning for warning in path.warnings)
    assert not any("miss planes" in warning for warning in path.warnings)
