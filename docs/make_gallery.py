"""Draw every element that `blockstat.model` builds and write docs/gallery.md: `make gallery`."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops

from blockstat import Assembly, assess
from blockstat.model import (
    arch,
    assemble,
    barrel_vault,
    column,
    dome,
    freeform,
    groin_vault,
    height_field,
    jack_arch,
    pavilion_vault,
    pier,
)
from blockstat.plot import picture

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))

import cross_vault
import freeform as waving

ARCH = {"span": 3.0, "depth": 0.6, "springers": 0.5}
BAY = {"spans": (4.0, 4.0), "thickness": 0.4, "brick": 0.7, "springers": 0.4}
HEAD = """# Gallery

Every element of `blockstat.model`, its size and its static verdict with friction 0.7, on fixed springers or plinths
(grey). Made by `docs/make_gallery.py`.

| | element | blocks | interfaces | verdict |
|---|---|---|---|---|
"""


def sail() -> Assembly:
    """A sphere over a square."""
    points = height_field(
        lambda x, y: np.sqrt(3.4**2 - x**2 - y**2), x=(-2, 2), y=(-2, 2), courses=13, voussoirs=7
    )  # fmt: skip
    return assemble(freeform(points, thickness=0.25, supports=("south", "north", "west", "east"), springers=0.3))


def saddle() -> Assembly:
    points = height_field(lambda x, y: 0.25 * (x**2 - y**2), x=(-2, 2), y=(-2, 2), courses=12, voussoirs=6)
    return assemble(freeform(points, thickness=lambda x, y: 0.2 + 0.08 * np.abs(y), springers=0.4))


def wave() -> Assembly:
    points = height_field(waving.height, x=(-3, 3), y=(-2, 2), courses=13, voussoirs=8)
    return assemble(freeform(points, thickness=0.3, springers=0.4))


#: File, what it is, how it is built, and options of `picture`.
ELEMENTS: list[tuple[str, str, Callable[[], Assembly], dict]] = [
    ("arch-semicircular", "semicircular arch", lambda: assemble(arch(thickness=0.4, voussoirs=15, **ARCH)), {}),
    ("arch-segmental", "segmental arch",
     lambda: assemble(arch("segmental", rise=0.8, thickness=0.4, voussoirs=13, **ARCH)), {}),
    ("arch-pointed", "pointed arch",
     lambda: assemble(arch("pointed", rise=2.3, thickness=0.4, voussoirs=16, **ARCH)), {}),
    ("arch-elliptic", "elliptic arch",
     lambda: assemble(arch("elliptic", rise=1.0, thickness=0.5, voussoirs=15, **ARCH)), {}),
    ("arch-horseshoe", "horseshoe arch",
     lambda: assemble(arch("horseshoe", rise=1.95, thickness=0.5, voussoirs=19, **ARCH)), {}),
    ("arch-flat", "flat (jack) arch", lambda: assemble(jack_arch(thickness=0.6, voussoirs=11, **ARCH)), {}),
    ("arch-vertical", "segmental arch of vertical joints",
     lambda: assemble(arch("segmental", rise=0.8, thickness=0.4, voussoirs=13, joints="vertical", **ARCH)), {}),
    ("vault-barrel", "barrel vault, pointed",
     lambda: assemble(barrel_vault("pointed", span=4, rise=2.8, length=5, thickness=0.4, voussoirs=16, brick=0.8,
                                   springers=0.4)), {"azimuth": -25.0}),
    ("vault-groin", "groin (cross) vault", lambda: assemble(groin_vault(voussoirs=15, **BAY)), {}),
    ("vault-groin-below", "the same from below", lambda: assemble(groin_vault(voussoirs=15, **BAY)),
     {"elevation": -30.0}),
    ("vault-groin-bay", "groin vault over a rectangular bay, pointed, mitred groins",
     lambda: assemble(groin_vault("pointed", rise=2.9, voussoirs=16, groins="mitred",
                                  **BAY | {"spans": (5.0, 3.5)})), {}),
    ("vault-groin-piers", "groin vault on piers 1.2 m wide", lambda: cross_vault.on_piers(1.2), {"elevation": 15.0}),
    ("vault-groin-piers-thin", "groin vault on piers 0.6 m wide", lambda: cross_vault.on_piers(0.6),
     {"elevation": 15.0}),
    ("vault-pavilion", "pavilion (cloister) vault", lambda: assemble(pavilion_vault(voussoirs=15, **BAY)), {}),
    ("dome", "hemispherical dome",
     lambda: assemble(dome(span=5, thickness=0.4, rings=9, voussoirs=20, springers=0.4)), {"elevation": 35.0}),
    ("dome-oculus", "pointed dome with an oculus",
     lambda: assemble(dome("pointed", span=5, rise=3.2, thickness=0.35, rings=9, voussoirs=20, oculus=1.2,
                           springers=0.4)), {"elevation": 35.0}),
    ("freeform-sail", "sail vault, a sphere over a square", sail, {}),
    ("freeform-wave", "waving barrel", wave, {}),
    ("freeform-saddle", "saddle, thicker towards its supports", saddle, {}),
    ("column", "round column",
     lambda: assemble(column(diameter=0.8, top=0.65, height=4.0, drums=6, sides=24, plinth=0.3), supports="plinth"),
     {"elevation": 12.0}),
    ("pier", "square pier in bond",
     lambda: assemble(pier(size=(0.8, 0.8), height=3.0, courses=9, bond="halves", plinth=0.3), supports="plinth"),
     {"elevation": 12.0}),
]  # fmt: skip


def small(path: Path) -> None:
    """Crop the margins of a picture and keep 256 colours."""
    image = Image.open(path).convert("RGB")
    margin = ImageChops.invert(image).getbbox()
    image.crop(margin).quantize(256).save(path, optimize=True)


def main() -> None:
    folder = HERE / "gallery"
    folder.mkdir(exist_ok=True)
    rows = []
    for name, words, build, options in ELEMENTS:
        verdict = assess(build())
        small(picture(verdict.assembly, folder / f"{name}.png", **options))
        figures = f"{verdict.assembly.n_blocks} | {verdict.interfaces.n_interfaces} | {verdict.outcome.word}"
        rows.append(f'| <img src="gallery/{name}.png" height="180" alt="{words}"> | {words} | {figures} |')
        print(f"{name}: {figures}")
    (HERE / "gallery.md").write_text(HEAD + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
