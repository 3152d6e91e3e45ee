"""Does it stand? The verdict, its colours, and the mechanism as keyframes."""

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .blocks import DEMAND, MOTION, REST, Cannot, assembly, keyed, objects, remember, rest, restore, settings

#: Colours of a block that carries little, that is at its limit, that moves, and of a support.
EASY, LIMIT, MOVING, SUPPORT = (0.25, 0.45, 0.75), (0.95, 0.75, 0.1), (0.85, 0.15, 0.1), (0.35, 0.35, 0.35)
KEYS = 9  #: of the way there
TEXT = "blockstat"  #: the text block with the whole verdict


def judge(context):
    """The verdict on the blocks as they were before they were animated, and their objects."""
    import blockstat
    from blockstat.errors import InputError

    own = settings(context)
    for obj in objects(context):
        if REST in obj:
            restore(obj)
    context.view_layer.update()
    made, found = assembly(context)
    try:
        flow = "coulomb" if own.coulomb else "associated"
        return blockstat.assess(made, gap=own.gap, flow=flow), found
    except InputError as error:
        raise Cannot(str(error)) from None


def coloured(context, verdict, found):
    """Colour each block by its demand, or by its speed where it moves, and keep both as custom properties."""
    from blockstat.analysis.verdict import Outcome

    moves = verdict.outcome is Outcome.UNSTABLE
    demand, speed = verdict.demand(), verdict.motion
    for number, obj in enumerate(found):
        if verdict.assembly.support[number]:
            colour = np.array(SUPPORT)
        else:
            share = speed[number] if moves else demand[number]
            colour = (1 - share) * np.array(EASY) + share * np.array(MOVING if moves else LIMIT)
        obj.color = (*colour, 1.0)
        obj[DEMAND] = float(demand[number])
        obj[MOTION] = [*verdict.assembly.centroid[number].tolist(), *verdict.mechanism[number].tolist()]
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.shading.color_type = "OBJECT"


class BLOCKSTAT_OT_assess(bpy.types.Operator):
    """Say whether the blocks stand, colour them, and show how they would move."""

    bl_idname = "blockstat.assess"
    bl_label = "Does it stand?"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            verdict, found = judge(context)
        except Cannot as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        coloured(context, verdict, found)
        words = verdict.explain()
        text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
        text.from_string(words + "\n")
        settings(context).answer = words
        self.report({"INFO"}, verdict.outcome.value)
        return {"FINISHED"}


class BLOCKSTAT_OT_mechanism(bpy.types.Operator):
    """Animate how the blocks begin to move: there and back within the frames."""

    bl_idname = "blockstat.mechanism"
    bl_label = "Mechanism as keyframes"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            found = objects(context)
        except Cannot as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        moving = [obj for obj in found if MOTION in obj and np.any(np.array(obj[MOTION])[3:])]
        if not moving:
            self.report({"ERROR"}, 'nothing moves; ask "Does it stand?" first')
            return {"CANCELLED"}
        animate(context, moving)
        return {"FINISHED"}


def animate(context, moving):
    """Keyframes of blocks along their twists, there and back."""
    own, scene = settings(context), context.scene
    scale = scene.unit_settings.scale_length
    first, last = scene.frame_start, scene.frame_start + own.frames
    shares = np.sin(np.linspace(0, np.pi, 2 * KEYS - 1)) ** 2
    frames = np.round(np.linspace(first, last, 2 * KEYS - 1)).astype(int)
    for obj in moving:
        place = rest(obj)
        restore(obj)
        obj.matrix_world = place
        remember(obj)
        kept = np.array(obj[MOTION])
        centre, shift, turn = Vector(kept[:3] / scale), kept[3:6], Vector(kept[6:9])
        for frame, share in zip(frames.tolist(), shares.tolist(), strict=True):
            # The verdict moves the fastest corner by 1 m; the amplitude is in units of the scene.
            factor = share * own.amplitude
            rotation = Matrix.Rotation(turn.length * factor * scale, 4, turn) if turn.length else Matrix()
            moved = Matrix.Translation(centre + Vector(shift * factor)) @ rotation @ Matrix.Translation(-centre)
            keyed(obj, frame, moved @ place)
    scene.frame_end = max(scene.frame_end, last)
    scene.frame_set(first)


CLASSES = (BLOCKSTAT_OT_assess, BLOCKSTAT_OT_mechanism)


def register():
    for own in CLASSES:
        bpy.utils.register_class(own)


def unregister():
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
