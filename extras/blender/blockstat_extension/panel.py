"""The panel in the sidebar of the 3D view."""

import bpy

from .blocks import settings


class BLOCKSTAT_PT_panel(bpy.types.Panel):
    """Does it stand?"""

    bl_label = "blockstat"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "blockstat"

    def draw(self, context):
        own, layout = settings(context), self.layout
        layout.use_property_split = True
        layout.prop(own, "collection")
        row = layout.row(align=True)
        row.operator("blockstat.support").support = True
        row.operator("blockstat.support", text="Free").support = False
        for name in ("ground", "density", "friction", "gap", "coulomb"):
            layout.prop(own, name)
        layout.operator("blockstat.assess", icon="CHECKMARK")
        for line in own.answer.splitlines()[:6]:
            layout.label(text=line)
        layout.prop(own, "frames")
        layout.prop(own, "amplitude")
        for name in ("mechanism", "fall", "joints", "clear"):
            layout.operator(f"blockstat.{name}")


CLASSES = (BLOCKSTAT_PT_panel,)


def register():
    for own in CLASSES:
        bpy.utils.register_class(own)


def unregister():
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
