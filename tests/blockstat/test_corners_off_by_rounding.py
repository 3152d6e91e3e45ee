"""Paths of blocks whose corners are off by what files and far coordinates round, against those of plane joints."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, box, capacity, find_interfaces, repair, settle_to_collapse
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


def bonded_wall(bricks=3, courses=6):
    """In running bond: 0.5 x 0.3 x 0.25 m, half bricks at the ends of every second course; friction .7."""
    blocks = [box((-1, -1, -1), (0.5 * bricks + 1, 1.3, 0), name="ground")]
    for k in range(courses):
        inner = [0.5 * (j + 0.5 * (k % 2)) for j in range(1 - k % 2, bricks)]
        ends = [0.0, *inner, 0.5 * bricks]
        blocks += [box((a, 0, 0.25 * k), (b, 0.3, 0.25 * (k + 1)), name=f"{k}.{a}") for a, b in pairwise(ends)]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.7)


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


def share(size, thickness):
    """By how much the end of a noisy arch may differ from that of the exact one, relative to it.

    Two corners that are off along two axes change a thickness by 2 sqrt(2) of that. The end changes by up to 3.3 times
    the share of the thickness: so do exact arches that are 2 mm thinner and thicker than those here.
    """
    return 1e-6 + 3.3 * 2.0 * np.sqrt(2.0) * size / thickness


def same_as_exact(scene, off, load=(1, 0, 0), control="arch"):
    """The curves of a scene and of one whose corners are slightly off, which ends as the exact one does."""
    exact, curve = (capacity(one, load, control=control) for one in (scene, off))
    assert curve.outcome.word == exact.outcome.word == "zero"
    assert [event.kind for event in curve.events] == [event.kind for event in exact.events]
    return exact, curve


@pytest.mark.parametrize(("size", "seed"), [(1e-7, 0), (1e-7, 1), (1e-6, 1), (1e-5, 2), (1e-4, 3), (1e-3, 20)])
def test_an_arch_with_corners_slightly_off_carries_to_where_the_exact_arch_does(size, seed):
    """Its four hinges are not quite parallel, so that taken literally it is rigid; the exact arch is a linkage."""
    ring = assemble(arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3), friction=0.7)
    exact, curve = same_as_exact(ring, noisy(ring, size, seed))
    assert curve.displacement[-1] == pytest.approx(exact.displacement[-1], rel=share(size, 0.15))
    assert curve.lower[0] == pytest.approx(exact.lower[0], rel=share(size, 0.15))


@pytest.mark.parametrize(("voussoirs", "thickness", "span"), [(14, 0.18, 2.0), (9, 0.16, 1.5), (7, 0.4, 3.0)])
@pytest.mark.parametrize(("size", "seed"), [(5e-6, 11), (5e-6, 12), (1e-4, 12), (1e-3, 11)])
def test_arches_of_other_proportions_do_as_well(voussoirs, thickness, span, size, seed):
    ring = assemble(arch(span=span, thickness=thickness, depth=0.4, voussoirs=voussoirs, springers=0.3), friction=0.7)
    exact, curve = same_as_exact(ring, noisy(ring, size, seed))
    assert curve.displacement[-1] == pytest.approx(exact.displacement[-1], rel=share(size, thickness))
    told = any("miss planes with parallel edges" in warning for warning in curve.warnings)
    assert told == (size >= 1e-4)


def test_an_arch_that_is_turned_and_rounded_to_millimetres_carries_to_where_the_exact_arch_does():
    """Blocks share their corners, so that joints are nearly plane, but their edges are not parallel."""
    ring = assemble(arch(span=3.0, thickness=0.4, depth=0.6, voussoirs=7, springers=0.3), friction=0.7)
    plan = Rotation.from_rotvec([0, 0, 0.37]).as_matrix()
    exact, curve = same_as_exact(ring, ring.with_(vertices=(ring.vertices @ plan.T).round(3) @ plan))
    assert curve.displacement[-1] == pytest.approx(exact.displacement[-1], rel=share(0.5e-3, 0.4))


@pytest.mark.parametrize("away", [(1.0, 0, 0), (0, 0, -1.0)])
@pytest.mark.parametrize(("size", "seed"), [(1e-6, 1), (1e-4, 2)])
def test_an_arch_with_corners_slightly_off_is_spread_as_far_as_the_exact_one(size, seed, away):
    """A support moves out by .3 m, or down by .7 m, until the arch falls: by as much as the exact arch and its flaw."""
    ring = assemble(arch(span=2.0, thickness=0.25, depth=0.4, voussoirs=10, springers=0.3), friction=0.7)
    moved = {ring.names[np.flatnonzero(ring.support)[-1]]: away}
    exact, path = (settle_to_collapse(scene, moved) for scene in (ring, noisy(ring, size, seed)))
    assert path.collapse == pytest.approx(exact.collapse, rel=share(size, 0.25))
    assert path.reaction[0] == pytest.approx(exact.reaction[0], rel=share(size, 0.25))


@pytest.mark.parametrize(("size", "seed"), [(1e-6, 1), (1e-4, 2), (1e-3, 3)])
def test_a_wall_of_bricks_with_corners_slightly_off_turns_over_by_its_thickness(size, seed):
    """Four bricks a course in running bond, .3 m thick and 1.5 m high: .3 / 1.5 at rest, zero at .3 m at its top."""
    blocks = [box((-1, -1, -1), (3, 1.3, 0), name="ground")]
    for course in range(6):
        ends = [0.0, *np.arange(0.25 if course % 2 else 0.5, 2.0, 0.5), 2.0]
        low, high = course * 0.25, course * 0.25 + 0.25
        blocks += [box((a, 0, low), (b, 0.3, high), name=f"{course}.{a}") for a, b in pairwise(ends)]
    wall = noisy(Assembly.from_blocks(blocks, supports=["ground"], friction=0.7), size, seed)
    curve = capacity(wall, (0, 1, 0), steps=10)
    assert curve.outcome.word == "zero"
    assert curve.lower[0] == pytest.approx(0.2, abs=(1 + 0.2) * 2 * size / 1.5 + 1e-6)
    assert curve.displacement[-1] == pytest.approx(0.3, abs=4 * size + 1e-6)


def flaw_of(scene):
    return FaceOutlines(scene, find_interfaces(scene)).flaw


def test_the_flaw_of_faces_is_what_their_corners_are_off():
    """Each coordinate is off by size at most; a plane through four corners of a bearing of .3 m x 1 m is, too."""
    assert max(flaw_of(lintel())) < 1e-14
    found = flaw_of(noisy(lintel(), 1e-6, 5))
    assert 1e-7 < found.distance < 1e-5
    assert 1e-7 < found.tilt < 2e-5


def test_what_a_support_is_off_by_beyond_a_joint_is_no_flaw_of_it():
    """The ground is 40 m wide: a corner is off by 0.1 m in plan, and one by 10 mm in height, 28 m from the joint.

    A warp of 10 mm on 40 m is one of at most 2 x 10 / 40 mm a metre on the block, whose half diagonal is 0.56 m.
    """
    ground, block = box((-20, -20, -1), (20, 20, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="block")
    for far, most in (((0.1, 0, 0), 1e-12), ((0, 0, -0.01), 2 * 2 * 0.01 / 40 * 0.56)):
        corners = np.array(ground.vertices, dtype=float)
        corners[np.argmax(corners.sum(axis=1))] += far
        scene = Assembly.from_blocks([Block(corners, ground.faces, "ground"), block], supports=["ground"])
        assert flaw_of(scene).distance <= most
        curve = capacity(scene, (1, 0, 0), control="block")
        assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-4, abs=most)


def test_faces_that_are_far_from_plane_are_meant_so():
    """A plane through corners of a bearing of .3 m that are off by a tenth of it is tilted by about as much."""
    assert flaw_of(noisy(lintel(), 0.3 * 2 * LARGEST_TILT, 5)) == (0.0, 0.0, 0.0, 0.0)


def test_a_path_by_steps_whose_joints_miss_planes_is_doubted():
    """Where bearings go down the lintel turns and slides at once, which is no linkage."""
    path = settle_to_collapse(noisy(lintel(), 1e-4, 3), {"right": (0.0, 0.0, -1.0)}, displacement=0.1, steps=8)
    assert any("finite steps" in warning for warning in path.warnings)
    doubted = next(warning for warning in path.warnings if "faces of joints miss planes by up to" in warning)
    assert "`repair`" in doubted


def test_steps_along_a_curved_path_of_plane_joints_are_not_doubted():
    path = settle_to_collapse(lintel(), {"right": (0.0, 0.0, -1.0)})
    assert any("finite steps" in warning for warning in path.warnings)
    assert not any("miss planes" in warning for warning in path.warnings)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_wall_that_slides_in_its_plane_is_followed_to_zero_once_it_is_repaired(seed):
    """Corners off by 1e-4 m.

    Plane joints carry the same at rest but for the corners: a brick's arm of half its height, 0.125 m, is longer or
    shorter by two corners, and so is that of its weight.
    """
    size, scene = 1e-4, bonded_wall()
    repaired, _ = repair(noisy(scene, size, seed))
    curve = capacity(repaired, (1, 0, 0))
    assert curve.outcome.word == "zero"
    assert any("finite steps" in warning for warning in curve.warnings)
    assert curve.lower[0] == pytest.approx(capacity(scene, (1, 0, 0)).lower[0], rel=2 * 2 * size / 0.125)


def test_finite_steps_that_begin_below_the_limit_load_are_told_of():
    """An arch whose corners are off by a tenth of a millimetre carries what the limit load at rest says.

    The limit load of plane joints is .4879. A curve that is at less than half of it a little way from rest has lost it
    by the corners alone, and says so.
    """
    scene = assemble(arch(span=2, thickness=0.4, depth=0.5, voussoirs=7, springers=0.3), friction=0.7)
    random = np.random.default_rng(1)
    random.normal(0, 1e-4, scene.vertices.shape)
    blocks = []
    for k, name in enumerate(scene.names):
        corners = scene.block_vertices(k)
        blocks.append(Block(corners + random.normal(0, 1e-4, corners.shape), scene.faces_of(k), name=name))
    supports = [name for name in scene.names if "springer" in name]
    curve = capacity(
        Assembly.from_blocks(blocks, supports=supports, friction=0.7), (1, 0, 0), control="mean", displacement=2e-4
    )
    assert curve.lower[0] == pytest.approx(0.4879, rel=1e-3)
    told = [warning for warning in curve.warnings if "the finite steps begin near rest at" in warning]
    assert bool(told) == bool((curve.lower < 0.48).any())
