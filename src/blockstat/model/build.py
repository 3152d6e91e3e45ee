"""A scene of either form to an assembly."""

from __future__ import annotations

from blockstat.assembly import Assembly
from blockstat.model.chapel import build_chapel
from blockstat.model.compose import compose
from blockstat.spec import Composition, Scene


def build(scene: Scene) -> Assembly:
    """The assembly of a scene.

    Of a `Building`: groups "ground" (the support), "wall.<side>", "buttress.<side>.<k>", "vault". Of a `Composition`:
    each element's groups under its name, and "ground". Raises InputError naming the key when the parts do not fit
    together.
    """
    return compose(scene) if isinstance(scene, Composition) else build_chapel(scene)
