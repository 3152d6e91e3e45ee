"""The Blender extension without a window, in a Python that has bpy (4.2, 4.5 or 5.0 from PyPI) and blockstat:

python3.11 -m venv blender && blender/bin/pip install . pytest hypothesis "bpy==4.5.*"
blender/bin/python -m pytest tests/blender
"""

import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import tomllib

pytest.importorskip("bpy")

import blockstat_extension
import bpy
from mathutils import Matrix

BUILD = Path(__file__).parents[2] / "extras" / "blender" / "build.py"
FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.fixture
def scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    blockstat_extension.register()
    yield bpy.context.scene
    blockstat_extension.unregister()


def brick(name, lower, upper):
    mesh = bpy.data.meshes.new(name)
    ends = (lower, upper)
    corners = [[ends[x][0], ends[y][1], ends[z][2]] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    mesh.from_pydata(corners, [], FACES)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.select_set(True)
    return obj


def tower(shift, count=2):
    """Cubes of 1 m, each shifted against the one below."""
    made = [brick(f"cube.{k}", (k * shift, 0, k), (k * shift + 1, 1, k + 1)) for k in range(count)]
    bpy.context.view_layer.update()
    return made


def places(objects):
    return np.array([np.array(obj.matrix_world) for obj in objects])


def corners(obj):
    return np.array([(obj.matrix_world @ vertex.co)[:] for vertex in obj.data.vertices])


@pytest.mark.parametrize(("shift", "word"), [(0.45, "Stable"), (0.55, "Unstable")])
def test_a_cube_falls_when_its_centre_is_beyond_the_edge(scene, shift, word):
    tower(shift)
    assert bpy.ops.blockstat.assess() == {"FINISHED"}
    assert scene.blockstat.answer.startswith(word)
    assert bpy.data.texts["blockstat"].as_string().startswith(word)


def test_the_cube_that_tips_is_red_and_turns_about_its_edge(scene):
    base, top = tower(0.6)
    bpy.ops.blockstat.assess()
    assert top.color[0] > 0.8 > base.color[0]
    scene.blockstat.amplitude, scene.blockstat.frames = 0.2, 40
    before = corners(top)
    assert bpy.ops.blockstat.mechanism() == {"FINISHED"}
    scene.frame_set(scene.frame_start + 20)
    moved = corners(top) - before
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(0.2, rel=0.02)  # a chord of the arc
    edge = np.isclose(before[:, 0], 0.6) & np.isclose(before[:, 2], 1.0)
    # It turns about the edge of the base, x = 1: its own lower edge at x = 0.6 rises.
    assert (moved[edge, 2] > 0.05).all()
    np.testing.assert_allclose(corners(base).min(axis=0), [0, 0, 0], atol=1e-6)
    scene.frame_set(scene.frame_start + 40)
    np.testing.assert_allclose(corners(top), before, atol=1e-5)
    bpy.ops.blockstat.clear()
    assert top.animation_data is None
    assert tuple(top.color) == (1, 1, 1, 1)


def test_objects_count_as_they_stand_whatever_their_transformation(scene):
    """Turned, scaled, mirrored, parented and modified objects, in a scene in millimetres."""
    scene.unit_settings.scale_length = 0.001
    base, top = tower(0.0)
    for obj in (base, top):
        obj.data.transform(Matrix.Scale(1000, 4))
    top.data.transform(Matrix.Translation((0, 0, -1000)))
    top.parent = base
    top.matrix_parent_inverse = Matrix.Translation((0, 0, 1000))
    base.matrix_world = Matrix.Rotation(0.5, 4, "Z") @ Matrix.Diagonal((-2, 1, 1, 1))
    bpy.context.view_layer.update()
    made, found = blockstat_extension.blocks.assembly(bpy.context)
    assert [obj.name for obj in found] == ["cube.0", "cube.1"]
    np.testing.assert_allclose(made.volume[:2], 2.0, rtol=1e-5)
    np.testing.assert_allclose(made.gravity, [0, 0, -9.81 * 0.001], rtol=1e-6)
    assert bpy.ops.blockstat.assess() == {"FINISHED"}
    assert scene.blockstat.answer.startswith("Stable")


def test_blocks_fall_as_newton_says_and_go_back(scene):
    (cube,) = tower(0.0, 1)
    ground = brick("plate", (-2, -2, -6), (2, 2, -5))
    ground.blockstat_support = True
    before = places([cube])
    scene.blockstat.frames, scene.render.fps = 24, 24
    assert bpy.ops.blockstat.fall() == {"FINISHED"}
    assert scene.rigidbody_world is None
    assert len(scene.objects) == 2
    scene.frame_set(scene.frame_start + 12)
    fall = 9.81 * 0.5**2 / 2
    assert before[0, 2, 3] - cube.matrix_world.translation.z == pytest.approx(fall, rel=0.05)  # damped a little
    assert scene.blockstat.answer == "fell within 1.0 s: cube.0"
    bpy.ops.blockstat.clear()
    np.testing.assert_array_equal(places([cube]), before)


@pytest.mark.parametrize(("shift", "words"), [(0.3, "nothing fell within 2.0 s"), (0.6, "fell within 2.0 s: cube.1")])
def test_what_blender_simulates_is_what_statics_say(scene, shift, words):
    tower(shift)
    scene.blockstat.frames, scene.render.fps = 48, 24
    bpy.ops.blockstat.fall()
    assert scene.blockstat.answer == words


def test_joints_hold_what_would_fall_until_it_is_hit(scene):
    """The upper cube stands out by 0.6: without a joint it falls. A heavy ball breaks the joint that is found."""
    cubes = tower(0.6)
    scene.blockstat.frames, scene.render.fps = 48, 24
    assert bpy.ops.blockstat.joints() == {"FINISHED"}
    world = scene.rigidbody_world
    assert len(world.constraints.objects) == 2
    assert all(own.rigid_body_constraint.use_breaking for own in world.constraints.objects)

    def last():
        for frame in range(scene.frame_start, scene.frame_start + 49):
            scene.frame_set(frame)
        return places(cubes)

    scene.frame_set(scene.frame_start)
    start = places(cubes)
    np.testing.assert_allclose(last(), start, atol=0.05)
    scene.frame_set(scene.frame_start)
    ball = brick("ball", (-6, 0.3, 1.3), (-5.6, 0.7, 1.7))
    bpy.ops.object.select_all(action="DESELECT")
    ball.select_set(True)
    bpy.context.view_layer.objects.active = ball
    bpy.ops.object.origin_set(type="ORIGIN_CENTER_OF_VOLUME")
    world.collection.objects.link(ball)
    ball.rigid_body.mass, ball.rigid_body.kinematic = 5000.0, True
    ball.keyframe_insert("location", frame=scene.frame_start)
    ball.location.x += 12.0
    ball.keyframe_insert("location", frame=scene.frame_start + 24)
    scene.frame_set(scene.frame_start)
    world.point_cache.frame_start = scene.frame_start
    assert np.abs(last() - start).max() > 0.5
    bpy.ops.blockstat.clear()
    assert scene.rigidbody_world is None


def test_refusals_say_what_to_do(scene):
    def refused(name):
        with pytest.raises(RuntimeError) as found:
            getattr(bpy.ops.blockstat, name)()
        return str(found.value)

    assert "no mesh is selected; select the blocks, or choose their collection" in refused("assess")
    base, top = tower(0.0)
    assert 'nothing moves; ask "Does it stand?" first' in refused("mechanism")
    scene.blockstat.ground = False
    assert "no block is marked as a support" in refused("assess")
    bpy.ops.object.select_all(action="DESELECT")
    base.select_set(True)
    bpy.ops.blockstat.support()
    top.select_set(True)
    assert bpy.ops.blockstat.assess() == {"FINISHED"}
    scene.gravity = (0, 0, 0)
    assert "the scene has no gravity" in refused("assess")
    scene.gravity = (0, 0, -9.81)
    top.data.clear_geometry()
    top.data.from_pydata([(0, 0, 1), (1, 0, 1), (0, 1, 1), (0, 0, 2)], [], [(0, 1, 2), (0, 1, 3), (0, 2, 3)])
    assert 'block "cube.1"' in refused("assess")
    bpy.ops.rigidbody.world_add()
    top.select_set(False)
    assert "the scene has a rigid body world already; remove it first" in refused("fall")


def test_blocks_of_a_collection(scene):
    tower(0.0)
    kept = bpy.data.collections.new("kept")
    scene.collection.children.link(kept)
    scene.blockstat.collection = kept
    with pytest.raises(RuntimeError, match='the collection "kept" holds no meshes'):
        bpy.ops.blockstat.assess()
    kept.objects.link(scene.objects["cube.0"])
    bpy.ops.blockstat.assess()
    assert "blockstat_demand" in scene.objects["cube.0"]
    assert "blockstat_demand" not in scene.objects["cube.1"]


def wall(columns, courses):
    for k in range(courses):
        for i in range(columns):
            x = 0.25 * i + 0.125 * (k % 2)
            brick(f"brick.{k}.{i}", (x, 0, 0.08 * k), (x + 0.25, 0.12, 0.08 * k + 0.08))


def test_each_of_a_thousand_bricks_has_its_demand(scene):
    wall(25, 40)
    bpy.ops.blockstat.assess()
    assert scene.blockstat.answer.startswith("Stable")
    assert sum("blockstat_demand" in obj for obj in scene.objects) == 1000


def test_blender_accepts_the_zip(tmp_path):
    words = ["--without-wheels", "--platforms", "linux-x64", "-o", tmp_path]
    subprocess.run([sys.executable, BUILD, *words], check=True)
    path = next(tmp_path.glob("*.zip"))
    tool = next(Path(bpy.utils.resource_path("LOCAL")).rglob("blender_ext.py"))
    said = subprocess.run([sys.executable, tool, "validate", path], capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr
    with zipfile.ZipFile(path) as made:
        kept = tomllib.loads(made.read("blender_manifest.toml").decode())
        assert {"__init__.py", "LICENSE"} <= set(made.namelist())
    assert kept["platforms"] == ["linux-x64"]
    assert kept["blender_version_min"] == "4.2.0"
