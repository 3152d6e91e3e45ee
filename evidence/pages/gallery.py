"""Draw every element that `blockstat.model` builds and every scene of examples/, and write docs/gallery.md.

    python -m evidence.pages.gallery [--judge ENGINE [--most BLOCKS]] [--keep-pictures]

Each has three verdicts: by force fields, without dilatancy and self-stress, and by a simulation. Simulations are dear;
their verdicts are kept in docs/gallery/dynamics.json. `--judge ENGINE` makes those that are missing,
of assemblies of up to so many blocks; a run that was interrupted goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from PIL import Image, ImageChops

from blockstat import Assembly, assess, build, load_scene
from blockstat.view.plot import plot
from dynsim import verify
from evidence.pages.elements import ELEMENTS
from evidence.paths import DOCS, EXAMPLES
from evidence.tables import head, row

HEAD = """# Gallery

Written by `make evidence ONLY=gallery`. The first verdict is of force fields, the second without dilatancy and
self-stress (`flow="coulomb"`), the third of a simulation; "-" where none was made. Friction is 0.7. Grey
blocks are supports.

Where the first says stable and the others do not, blocks are held by a thrust that no load causes. Such are the flyers
between upright faces, also those of the nave, and the arch of vertical joints: they fall freely.

## Buildings

These are the scenes of `examples/`.

"""
ELEMENTS_HEAD = """
## Elements

These are all elements of `blockstat.model`, on a slab or on fixed springers or plinths.

"""
COLUMNS = head(["", "", "blocks", "interfaces", "force fields", "Coulomb", "simulated"]) + "\n"
ENGINES = {"bullet": "Bullet", "lmgc90": "LMGC90"}
DYNAMICS = DOCS / "gallery" / "dynamics.json"
#: Options of the pictures of scenes.
VIEWS: dict[str, dict] = {
    "rotunda": {"azimuth": 20.0}, "canopy": {"elevation": 12.0}, "crypt": {"elevation": 18.0},
    "chapter_house": {"elevation": 18.0}, "basilica": {"azimuth": -65.0, "elevation": 32.0},
}  # fmt: skip


def small(path: Path) -> None:
    """Crop the margins of a picture and keep 256 colours."""
    image = Image.open(path).convert("RGB")
    margin = ImageChops.invert(image).getbbox()
    image.crop(margin).quantize(256).save(path, optimize=True)


def simulated(name: str, assembly: Assembly, engine: str | None, most: int) -> str:
    """The verdict of a simulation that is kept, or of a new one where an engine is given."""
    known = json.loads(DYNAMICS.read_text()) if DYNAMICS.exists() else {}
    if name not in known and engine is not None and assembly.n_blocks <= most:
        known[name] = f"{verify(assembly, engine=engine).outcome.word} ({ENGINES[engine]})"
        DYNAMICS.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")
    return known.get(name, "-")


def shown(name: str, words: str, alt: str, assembly: Assembly, options: dict, asked: argparse.Namespace) -> str:
    """Draw an assembly and judge it; a row of a table. alt : for who does not see the picture."""
    verdict = assess(assembly)
    coulomb = assess(assembly, flow="coulomb", interfaces=verdict.interfaces)
    if not asked.keep_pictures:
        small(plot(assembly, DOCS / "gallery" / f"{name}.png", **options))
    said = [outcome.word.replace("_", " ") for outcome in (verdict.outcome, coulomb.outcome)]
    third = simulated(name, assembly, asked.judge, asked.most)
    figures = (assembly.n_blocks, verdict.interfaces.n_interfaces, *said, third)
    print(f"{name}:", *figures, flush=True)
    return row([f'<img src="gallery/{name}.png" height="180" alt="{alt}">', words, *figures]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--judge", choices=ENGINES)
    parser.add_argument("--most", type=int, default=300)
    parser.add_argument("--keep-pictures", action="store_true")
    asked = parser.parse_args()
    (DOCS / "gallery").mkdir(exist_ok=True)
    text = HEAD + COLUMNS
    for path in sorted(EXAMPLES.glob("*.toml")):
        scene = load_scene(path)
        words = f"[{path.stem}](../examples/{path.name}): {scene.description}"
        text += shown(f"scene-{path.stem}", words, path.stem, build(scene), VIEWS.get(path.stem, {}), asked)
    text += ELEMENTS_HEAD + COLUMNS
    for name, words, build_element, options in ELEMENTS:
        text += shown(name, words, words, build_element(), options, asked)
    (DOCS / "gallery.md").write_text(text)


if __name__ == "__main__":
    main()
