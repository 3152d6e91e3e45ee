"""Joints that break: Blender's constraints at the joints that the statics find, as weak as they may be."""

import bpy
import numpy as np
from mathutils import Matrix

from .blocks import GROUND, Cannot, objects, restore, settings
from .fall import STEPS, body, fallen, remove_world, run, stand_in, world_of
from .verdict import judge

PREFIX = "blockstat joint"
#: Factors on the forces of the statics between which the least one is searched, and how closely.
LEAST, MOST, RATIO = 0.125, 1024.0, 1.25


def forces_at_joints(verdict):
    """Pairs of blocks, middles of their joints [m], and the forces that they carry [N], tension included."""
    joints = verdict.interfaces
    k = joints.point_interface
    world = np.einsum("pi,pij->pj", verdict.forces - np.outer(verdict.adhesion, [1.0, 0, 0]), joints.frame[k])
    total = np.zeros((joints.n_interfaces, 3))
    np.add.at(total, k, world)
    count = np.diff(joints.start)
    middle = np.add.reduceat(joints.point, joints.start[:-1]) / count[:, None]
    pairs, which = np.unique(joints.pair, axis=0, return_inverse=True)
    which = which.ravel()
    area = np.maximum(joints.area, 1e-12)
    weight = np.bincount(which, area)
    place = np.column_stack([np.bincount(which, area * axis) / weight for axis in middle.T])
    force = np.column_stack([np.bincount(which, axis) for axis in total.T])
    return pairs, place, np.linalg.norm(force, axis=1)


def add_joints(context, verdict, found):
    """A world with the blocks and a breakable constraint at each joint; the constraints and their forces [N]."""
    scene, made = context.scene, verdict.assembly
    scale = scene.unit_settings.scale_length
    pairs, place, force = forces_at_joints(verdict)
    bodies, holders = bpy.data.collections.new("blockstat bodies"), bpy.data.collections.new(PREFIX + "s")
    world_of(scene, bodies, holders)
    blocks = list(found)
    if len(made.names) > len(found):
        blocks.append(stand_in(context, made, len(found)))
        blocks[-1].hide_render = True
    centred(context, found)
    for number, obj in enumerate(blocks):
        body(bodies, obj, made, number)
    holder = bpy.data.collections.new(PREFIX + " holders")
    scene.collection.children.link(holder)
    made_joints = []
    # A joint that carries next to nothing still has the weight of a tenth of the lighter block.
    mass = np.where(made.support, np.inf, made.mass)
    floor = 0.1 * mass[pairs].min(axis=1) * np.linalg.norm(made.gravity)
    for (a, b), where in zip(pairs.tolist(), (place / scale).tolist(), strict=True):
        empty = bpy.data.objects.new(PREFIX, None)
        empty.empty_display_size = 0.05
        empty.matrix_world = Matrix.Translation(where)
        holder.objects.link(empty)
        holders.objects.link(empty)
        own = empty.rigid_body_constraint
        own.type = "FIXED"
        own.object1, own.object2 = blocks[a], blocks[b]
        own.use_breaking, own.disable_collisions = True, False
        made_joints.append(own)
    context.view_layer.update()
    return made_joints, np.maximum(force, floor)


def centred(context, found):
    """Move the origins of objects to their centroids, which Blender takes for the centres of mass."""
    with context.temp_override(selected_objects=found, selected_editable_objects=found, active_object=found[0]):
        bpy.ops.object.origin_set(type="ORIGIN_CENTER_OF_VOLUME")


def set_strength(context, joints, force, factor):
    """Breaking thresholds, which Blender compares with the impulse of one step [N s]."""
    step = context.scene.render.fps_base / context.scene.render.fps / STEPS
    for own, value in zip(joints, (factor * force * step).tolist(), strict=True):
        own.breaking_threshold = value
    context.scene.frame_set(context.scene.frame_start)
    context.scene.rigidbody_world.point_cache.frame_start = context.scene.frame_start  # drops what was simulated


def remove_joints(context):
    """Remove the constraints, the ground and the world that this extension made."""
    holder = bpy.data.collections.get(PREFIX + " holders")
    if holder is None:
        return
    remove_world(context)
    for obj in list(holder.objects):
        bpy.data.objects.remove(obj)
    bpy.data.collections.remove(holder)
    if (ground := bpy.data.objects.get(GROUND)) is not None:
        bpy.data.meshes.remove(ground.data)


def least_factor(context, joints, force, verdict, found):
    """The least factor on the forces at which nothing falls, to a ratio; None if MOST is too weak."""

    def stands(factor):
        set_strength(context, joints, force, factor)
        poses = run(context, found, settings(context).frames)
        return not len(fallen(context, verdict.assembly, poses))

    high = LEAST
    while not stands(high):
        high *= 4.0
        if high > MOST:
            return None
    low = high / 4.0
    if high == LEAST:
        return high
    while high / low > RATIO:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if stands(middle) else (middle, high)
    return high


class BLOCKSTAT_OT_joints(bpy.types.Operator):
    """Join the blocks by constraints that break, as weak as they may be for the blocks to stand until they are hit."""

    bl_idname = "blockstat.joints"
    bl_label = "Joints that break"
    bl_options = {"REGISTER", "UNDO"}

    margin: bpy.props.FloatProperty(name="Margin", default=1.5, min=1.0, description="Factor on the least strength")

    def execute(self, context):
        try:
            remove_joints(context)
            if context.scene.rigidbody_world is not None:
                raise Cannot("the scene has a rigid body world already; remove it first")
            for obj in objects(context):
                restore(obj)
            verdict, found = judge(context)
            joints, force = add_joints(context, verdict, found)
            factor = least_factor(context, joints, force, verdict, found)
            if factor is None:
                remove_joints(context)
                raise Cannot(f"the blocks fall even where joints hold {MOST:g} times what they carry")
        except Cannot as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        set_strength(context, joints, force, factor * self.margin)
        words = f"{len(joints)} joints; they stand from {factor:.3g} times the forces of the statics"
        settings(context).answer = words
        self.report({"INFO"}, words)
        return {"FINISHED"}


CLASSES = (BLOCKSTAT_OT_joints,)


def register():
    for own in CLASSES:
        bpy.utils.register_class(own)


def unregister():
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
