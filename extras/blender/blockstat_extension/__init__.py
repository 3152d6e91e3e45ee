"""The Blender extension: does it stand, how does it fall, and joints that hold until they are hit.

Blocks are mesh objects, each one closed solid: those selected, or those of a collection. Supports are marked, or are
the ground. The statics are those of the package blockstat, which the extension brings as a wheel; the simulations are
those of Blender itself.
"""

from . import blocks, fall, joints, panel, verdict

MODULES = (blocks, verdict, fall, joints, panel)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
