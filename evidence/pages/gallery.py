"""Draw every element that `blockstat.model` builds and every scene of examples/, and write docs/gallery.md.

    python -m evidence.pages.gallery [--keep-pictures]

Each has four verdicts: by force fields, without dilatancy and self-stress, by Bullet and by LMGC90. They are those of
`python -m evidence.comparisons.coulomb`, which keeps them in docs/results/coulomb.json.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from PIL import Image, ImageChops

from blockstat import Assembly, build, load_scene
from blockstat.view.plot import plot
from evidence.comparisons.coulomb import ON_PAGES, Found, rows_of, verdicts
from evidence.pages.elements import ELEMENTS
from evidence.paths import DOCS, EXAMPLES
from evidence.tables import head, row

HEAD = """# Gallery

Written by `make evidence ONLY=gallery`. The first verdict is of force fields, the second without dilatancy and
self-stress (`flow="coulomb"`), the third of Bullet, the fourth of LMGC90. "-" stands where none was made and "no
verdict" where an engine can not simulate the scene ([reasons](coulomb.md#without-a-verdict)). Friction is 0.7. Grey
blocks are supports.

Where the first says stable and the second does not, blocks are held by a thrust that no load causes. Such are the
flyers between upright faces, also those of the nave, and the arch of vertical joints: they fall freely.

Where both say stable and Bullet says falls, the stones of the vault have warped faces, which Bullet does not get as
they are ([verdicts beside two engines](coulomb.md)).

## Buildings

These are the scenes of `examples/`.

"""
ELEMENTS_HEAD = """
## Elements

These are all elements of `blockstat.model`, on a slab or on fixed springers or plinths.

"""
COLUMNS = head(["", "", "blocks", "interfaces", "force fields", "Coulomb", "Bullet", "LMGC90"]) + "\n"
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


def shown(name: str, words: str, alt: str, assembly: Assembly, options: dict | None, found: Found) -> str:
    """Draw an assembly unless options are None; a row of a table.

    alt : for who does not see the picture; found : nothing of a scene that a quick run left out.
    """
    if options is not None:
        small(plot(assembly, DOCS / "gallery" / f"{name}.png", **options))
    figures = (assembly.n_blocks, found.get("interfaces", "-"), *verdicts(found))
    print(f"{name}:", *figures, flush=True)
    return row([f'<img src="gallery/{name}.png" height="180" alt="{alt}">', words, *figures]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep-pictures", action="store_true")
    asked = parser.parse_args()
    (DOCS / "gallery").mkdir(exist_ok=True)
    found = rows_of(ON_PAGES)
    text = HEAD + COLUMNS
    for path in sorted(EXAMPLES.glob("*.toml")):
        scene = load_scene(path)
        words = f"[{path.stem}](../examples/{path.name}): {scene.description}"
        options = None if asked.keep_pictures else VIEWS.get(path.stem, {})
        alt = f"{path.stem.replace('_', ' ')}: {scene.description}"
        text += shown(f"scene-{path.stem}", words, alt, build(scene), options, found.get(path.stem, {}))
    text += ELEMENTS_HEAD + COLUMNS
    for name, words, build_element, options in ELEMENTS:
        seen = None if asked.keep_pictures else options
        text += shown(name, words, words, build_element(), seen, found.get(name, {}))
    (DOCS / "gallery.md").write_text(text)


if __name__ == "__main__":
    main()
