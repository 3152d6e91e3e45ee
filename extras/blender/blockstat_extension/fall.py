"""Let it fall: Blender's own rigid bodies, with what masonry needs, baked to keyframes."""

from contextlib import contextmanager

import bpy
import numpy as np
from mathutils import Matrix

from .blocks import Cannot, assembly, keyed, objects, remember, restore, settings

#: Steps a frame and iterations a step; Blender's defaults are 10 and 10.
STEPS, ITERATIONS = 20, 60
#: A block that moved by more than this share of its size has fallen.
FALLEN = 0.1


@contextmanager
def simulated(context, made):
    """Stand-ins of all blocks as rigid bodies in a world of their own; all of it is gone afterwards.

    Blender takes the origin of an object for its centre of mass, so each stand-in has its origin at its centroid.
    """
    scene = context.scene
    if scene.rigidbody_world is not None:
        raise Cannot("the scene has a rigid body world already; remove it first")
    bodies, constraints = bpy.data.collections.new("blockstat bodies"), bpy.data.collections.new("blockstat joints")
    world_of(scene, bodies, constraints)
    owned = []
    try:
        for number in range(made.n_blocks):
            owned.append(stand_in(context, made, number))
            body(bodies, owned[-1], made, number)
        context.view_layer.update()
        yield owned
    finally:
        scene.frame_set(scene.frame_start)
        remove_world(context)
        for obj in owned:
            bpy.data.meshes.remove(obj.data)


def stand_in(context, made, number):
    """An object with the shape of a block, and its origin at the centroid."""
    scale = context.scene.unit_settings.scale_length
    mesh = bpy.data.meshes.new("blockstat")
    corners = (made.block_vertices(number) - made.centroid[number]) / scale
    mesh.from_pydata(corners.tolist(), [], [face.tolist() for face in made.faces_of(number)])
    obj = bpy.data.objects.new(made.names[number], mesh)
    obj.location = made.centroid[number] / scale
    context.scene.collection.objects.link(obj)
    return obj


def world_of(scene, bodies, constraints):
    """A rigid body world with steps fine enough for masonry."""
    with bpy.context.temp_override(scene=scene):
        bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection, world.constraints = bodies, constraints
    world.substeps_per_frame, world.solver_iterations = STEPS, ITERATIONS
    world.point_cache.frame_start = scene.frame_start


def remove_world(context):
    """Remove the rigid body world and its collections; the objects stay."""
    world = context.scene.rigidbody_world
    owned = [own for own in (world.collection, world.constraints) if own is not None]
    for own in owned:
        for obj in list(own.objects):
            own.objects.unlink(obj)
    with bpy.context.temp_override(scene=context.scene):
        bpy.ops.rigidbody.world_remove()
    for own in owned:
        bpy.data.collections.remove(own)


def body(bodies, obj, made, number):
    """Make a block a rigid body."""
    bodies.objects.link(obj)
    own = obj.rigid_body
    own.type = "PASSIVE" if made.support[number] else "ACTIVE"
    own.collision_shape = "CONVEX_HULL" if is_convex(made, number) else "MESH"
    own.use_margin, own.collision_margin = True, 0.0
    # Blender multiplies the frictions of two bodies.
    own.friction, own.restitution = float(np.sqrt(made.friction)), 0.0
    own.mass = float(made.mass[number])
    own.use_deactivation = False
    own.linear_damping = own.angular_damping = 0.04


def is_convex(made, number):
    """Whether a block fills its convex hull."""
    from scipy.spatial import ConvexHull

    return ConvexHull(made.block_vertices(number)).volume <= made.volume[number] * (1 + 1e-3)


def run(context, found, frames):
    """Where the blocks are at each frame, shape (frames + 1, n_blocks, 4, 4)."""
    scene, poses = context.scene, []
    for frame in range(scene.frame_start, scene.frame_start + frames + 1):
        scene.frame_set(frame)
        poses.append([np.array(obj.matrix_world) for obj in found])
    return np.array(poses)


def fallen(context, made, poses):
    """Numbers of the blocks whose centroid moved by more than a share of their size, or that turned by as much."""
    moved = np.linalg.norm(poses[-1, :, :3, 3] - poses[0, :, :3, 3], axis=1)
    change = poses[-1, :, :3, :3] @ np.linalg.inv(poses[0, :, :3, :3])
    turned = np.arccos(np.clip((np.trace(change, axis1=1, axis2=2) - 1) / 2, -1, 1))
    size = np.cbrt(made.volume[: poses.shape[1]]) / context.scene.unit_settings.scale_length
    return np.flatnonzero(np.maximum(moved / size, turned) > FALLEN)


class BLOCKSTAT_OT_fall(bpy.types.Operator):
    """Simulate the blocks in Blender, and bake their motion to keyframes."""

    bl_idname = "blockstat.fall"
    bl_label = "Let it fall"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            for obj in objects(context):
                restore(obj)
            context.view_layer.update()
            made, found = assembly(context)
            with simulated(context, made) as bodies:
                poses = run(context, bodies[: len(found)], settings(context).frames)
        except Cannot as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        bake(context, found, poses)
        down = [found[number].name for number in fallen(context, made, poses)]
        some = ", ".join(down[:5]) + (f" and {len(down) - 5} more" if len(down) > 5 else "")
        seconds = settings(context).frames / (context.scene.render.fps / context.scene.render.fps_base)
        words = f"fell within {seconds:.1f} s: {some}" if down else f"nothing fell within {seconds:.1f} s"
        settings(context).answer = words
        self.report({"INFO"}, words)
        return {"FINISHED"}


def bake(context, found, poses):
    """Keyframes of blocks that move as their stand-ins did; those that do not move get none."""
    scene = context.scene
    still = np.abs(poses - poses[0]).max(axis=(0, 2, 3)) < 1e-6
    change = poses @ np.linalg.inv(poses[0])
    for number in np.flatnonzero(~still):
        obj = found[number]
        place = obj.matrix_world.copy()
        remember(obj)
        for step, matrix in enumerate(change[:, number].tolist()):
            keyed(obj, scene.frame_start + step, Matrix(matrix) @ place)
    scene.frame_end = max(scene.frame_end, scene.frame_start + len(poses) - 1)
    scene.frame_set(scene.frame_start)


CLASSES = (BLOCKSTAT_OT_fall,)


def register():
    for own in CLASSES:
        bpy.utils.register_class(own)


def unregister():
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
