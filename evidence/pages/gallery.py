"""Draw every element that `blockstat.model` builds and every scene of examples/, and write docs/gallery.md."""

from __future__ import annotations

from pathlib import Path

from PIL import Image, ImageChops

from blockstat import Assembly, assess, build, load_scene
from blockstat.view.plot import plot
from evidence.pages.elements import ELEMENTS
from evidence.paths import DOCS, EXAMPLES
from evidence.tables import head, row

HEAD = """# Gallery

Written by `make evidence ONLY=gallery`. The verdicts are static, with friction 0.7. Grey blocks are supports.

## Buildings

These are the scenes of `examples/`.

"""
ELEMENTS_HEAD = """
## Elements

These are all elements of `blockstat.model`, on a slab or on fixed springers or plinths.

"""
COLUMNS = head(["", "", "blocks", "interfaces", "verdict"]) + "\n"
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


def shown(name: str, words: str, alt: str, assembly: Assembly, options: dict) -> str:
    """Draw an assembly and judge it; a row of a table. alt : for who does not see the picture."""
    verdict = assess(assembly)
    small(plot(assembly, DOCS / "gallery" / f"{name}.png", **options))
    figures = (assembly.n_blocks, verdict.interfaces.n_interfaces, verdict.outcome.word)
    print(f"{name}:", *figures, flush=True)
    return row([f'<img src="gallery/{name}.png" height="180" alt="{alt}">', words, *figures]) + "\n"


def main() -> None:
    (DOCS / "gallery").mkdir(exist_ok=True)
    text = HEAD + COLUMNS
    for path in sorted(EXAMPLES.glob("*.toml")):
        scene = load_scene(path)
        words = f"[{path.stem}](../examples/{path.name}): {scene.description}"
        text += shown(f"scene-{path.stem}", words, path.stem, build(scene), VIEWS.get(path.stem, {}))
    text += ELEMENTS_HEAD + COLUMNS
    for name, words, build_element, options in ELEMENTS:
        text += shown(name, words, words, build_element(), options)
    (DOCS / "gallery.md").write_text(text)


if __name__ == "__main__":
    main()
