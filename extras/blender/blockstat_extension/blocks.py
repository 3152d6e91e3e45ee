"""From objects of Blender to blocks, and what the user says of them."""

import warnings

import bpy
import numpy as np
from mathutils import Matrix

#: Custom properties of an object: where it was before it was animated, its velocity in the mechanism, and its demand.
REST, MODE, MOTION, DEMAND = "blockstat_rest", "blockstat_mode", "blockstat_motion", "blockstat_demand"
GROUND = "ground (blockstat)"


class Cannot(Exception):
    """What the user asks for cannot be done; the message says why."""


class Settings(bpy.types.PropertyGroup):
    """What the user says of a scene."""

    collection: bpy.props.PointerProperty(
        type=bpy.types.Collection, name="Blocks", description="Its meshes are the blocks; empty for those selected"
    )
    density: bpy.props.FloatProperty(name="Density", default=2400.0, min=1.0, max=30e3, description="kg/m3")
    friction: bpy.props.FloatProperty(name="Friction", default=0.7, min=0.0, soft_max=2.0)
    gap: bpy.props.FloatProperty(
        name="Gap", default=0.01, min=1e-6, max=0.2, precision=4,
        description="Largest gap or overlap of a joint, relative to the size of the smaller block",
    )  # fmt: skip
    ground: bpy.props.BoolProperty(
        name="Ground",
        default=True,
        description="Where no block is marked, they stand on a plane below the lowest",
    )
    coulomb: bpy.props.BoolProperty(
        name="Without self-stress", default=False, description="Coulomb friction without dilatancy and self-stress"
    )
    frames: bpy.props.IntProperty(name="Frames", default=72, min=8, max=10_000)
    amplitude: bpy.props.FloatProperty(
        name="Amplitude", default=0.1, min=0.0, subtype="DISTANCE", description="How far the fastest corner moves"
    )
    answer: bpy.props.StringProperty(name="Answer")


def settings(context):
    return context.scene.blockstat


def objects(context):
    """The meshes that are blocks, in the order of their names."""
    own = settings(context)
    found = own.collection.all_objects if own.collection else context.selected_objects
    found = sorted((obj for obj in found if obj.type == "MESH"), key=lambda obj: obj.name)
    if not found:
        where = f'the collection "{own.collection.name}" holds no meshes' if own.collection else "no mesh is selected"
        raise Cannot(f"{where}; select the blocks, or choose their collection")
    return found


def assembly(context):
    """The blocks in metres, and their objects; a ground below them has no object."""
    from blockstat import Assembly, Block, box
    from blockstat.errors import InputError, InputWarning

    own, found = settings(context), objects(context)
    scale = context.scene.unit_settings.scale_length
    depsgraph = context.evaluated_depsgraph_get()
    solids = []
    for obj in found:
        vertices, faces = _mesh(obj.evaluated_get(depsgraph))
        solids.append(Block(vertices * scale, faces, obj.name))
    supports = [i for i, obj in enumerate(found) if obj.blockstat_support]
    if not supports:
        if not own.ground:
            raise Cannot("no block is marked as a support; mark some, or let the blocks stand on the ground")
        corners = np.concatenate([solid.vertices for solid in solids])
        lower, upper = corners.min(axis=0), corners.max(axis=0)
        size = float((upper - lower).max())
        slab = box(lower - size * np.array([1, 1, 0.1]), [*(upper + size)[:2], lower[2]], name=GROUND)
        supports, solids = [len(solids)], [*solids, slab]
    gravity = np.array(context.scene.gravity) * scale if context.scene.use_gravity else np.zeros(3)
    if not gravity.any():
        raise Cannot("the scene has no gravity")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            made = Assembly.from_blocks(
                solids, supports=supports, name=context.scene.name,
                density=own.density, friction=own.friction, gravity=gravity,
            )  # fmt: skip
    except InputError as error:
        raise Cannot(str(error)) from None
    return made, found


def _mesh(obj):
    """Corners in world coordinates, and faces with their normals outwards."""
    mesh = obj.to_mesh()
    try:
        vertices, loops = np.empty(3 * len(mesh.vertices)), np.empty(len(mesh.loops), dtype=np.int32)
        starts = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.vertices.foreach_get("co", vertices)
        mesh.loops.foreach_get("vertex_index", loops)
        mesh.polygons.foreach_get("loop_start", starts)
    finally:
        obj.to_mesh_clear()
    world = np.array(obj.matrix_world)
    faces = [face.tolist() for face in np.split(loops, starts[1:])] if len(starts) else []
    if np.linalg.det(world[:3, :3]) < 0:  # a mirrored object shows its inside
        faces = [face[::-1] for face in faces]
    return vertices.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3], faces


def remember(obj):
    """Keep where an object is before it is animated; what was kept first counts."""
    if REST not in obj:
        obj[REST] = [value for row in obj.matrix_world for value in row]
        obj[MODE] = obj.rotation_mode


def rest(obj):
    """Where an object was before it was animated."""
    kept = obj.get(REST)
    return obj.matrix_world.copy() if kept is None else Matrix(np.array(kept).reshape(4, 4).tolist())


def restore(obj):
    """Put an object back where it was, without the animation of this extension."""
    if REST in obj:
        obj.animation_data_clear()
        obj.matrix_world = rest(obj)
        obj.rotation_mode = obj[MODE]
    for key in (REST, MODE):
        if key in obj:
            del obj[key]


def keyed(obj, frame, matrix):
    """Set where an object is at a frame."""
    obj.rotation_mode = "QUATERNION"
    before = obj.rotation_quaternion.copy()
    obj.matrix_world = matrix
    obj.rotation_quaternion.make_compatible(before)
    obj.keyframe_insert("location", frame=frame)
    obj.keyframe_insert("rotation_quaternion", frame=frame)


class BLOCKSTAT_OT_support(bpy.types.Operator):
    """Mark the selected blocks as supports, which cannot move."""

    bl_idname = "blockstat.support"
    bl_label = "Mark as supports"
    bl_options = {"REGISTER", "UNDO"}

    support: bpy.props.BoolProperty(name="Support", default=True)

    def execute(self, context):
        found = [obj for obj in context.selected_objects if obj.type == "MESH"]
        for obj in found:
            obj.blockstat_support = self.support
        self.report({"INFO"}, f"{len(found)} blocks {'are supports' if self.support else 'are free'}")
        return {"FINISHED"}


class BLOCKSTAT_OT_clear(bpy.types.Operator):
    """Put all blocks back where they were, and remove colours, keyframes and joints of this extension."""

    bl_idname = "blockstat.clear"
    bl_label = "Clear"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        from .joints import remove_joints

        remove_joints(context)
        for obj in context.scene.objects:
            if obj.type == "MESH":
                if DEMAND in obj:
                    obj.color = (1.0, 1.0, 1.0, 1.0)
                restore(obj)
                for key in (MOTION, DEMAND):
                    if key in obj:
                        del obj[key]
        settings(context).answer = ""
        return {"FINISHED"}


CLASSES = (Settings, BLOCKSTAT_OT_support, BLOCKSTAT_OT_clear)


def register():
    for own in CLASSES:
        bpy.utils.register_class(own)
    bpy.types.Scene.blockstat = bpy.props.PointerProperty(type=Settings)
    bpy.types.Object.blockstat_support = bpy.props.BoolProperty(
        name="Support", description="This block cannot move", default=False
    )


def unregister():
    del bpy.types.Scene.blockstat
    del bpy.types.Object.blockstat_support
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
