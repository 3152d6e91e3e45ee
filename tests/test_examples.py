"""The scripts of examples/ print the verdicts that their texts promise; its scenes are sound and stand."""

import importlib.util
from pathlib import Path

import msgspec
import numpy as np
import pytest

from blockstat import assess, build, find_interfaces, load_scene, scene_from
from blockstat.contact.overlap.penetration import convex_blocks, overlaps


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("dome", ["stable", "stable", "unstable", "stable"]),
        ("cross_vault", ["unstable", "unstable", "stable", "stable"]),
        ("freeform", ["unstable", "stable", "stable"]),
    ],
)
def test_example(root, capsys, name, words):
    spec = importlib.util.spec_from_file_location(f"example_{name}", root / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main()
    assert [line.split()[-1] for line in capsys.readouterr().out.splitlines()] == words


#: Scenes with stones of curved faces, which are triangles or hollow; all others are of convex blocks.
CURVED = {"canopy", "chapter_house", "crypt", "nave", "rotunda", "shell", "tower"}
#: Number of blocks of each scene in hundreds, so that a slip in a builder is seen.
HUNDREDS = {
    "aqueduct": 31, "arcade": 11, "barn": 13, "basilica": 114, "bridge": 5, "canopy": 2, "chapel": 2,
    "chapter_house": 9, "crypt": 6, "nave": 20, "rotunda": 11, "shell": 2, "tower": 19,
}  # fmt: skip


def test_every_scene_is_listed(root):
    assert {path.stem for path in (root / "examples").glob("*.toml")} == set(HUNDREDS)


def noted(root: Path, name: str) -> list[str]:
    """Blocks, interfaces and verdict of a scene in the gallery."""
    line = next(li for li in (root / "docs" / "gallery.md").read_text().splitlines() if f"scene-{name}.png" in li)
    return [cell.strip() for cell in line.split("|")[3:6]]


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n == "basilica" else ()) for n in HUNDREDS])
def test_scene_is_sound_and_its_verdict_is_as_noted(root, name):
    scene = load_scene(root / "examples" / f"{name}.toml")
    assert scene.description.endswith(".")
    assembly = build(scene)
    assert assembly.n_blocks // 100 == HUNDREDS[name]
    faces = find_interfaces(assembly)
    assert faces.gap.max() < 1e-9 * assembly.size.max()
    assert np.unique(faces.pair).tolist() == list(range(assembly.n_blocks))
    assert len(overlaps(assembly, gap=1e-9)[0]) == 0
    assert convex_blocks(assembly).all() == (name not in CURVED)
    verdict = assess(assembly)
    assert verdict.outcome.word == "stable"
    assert noted(root, name) == [str(assembly.n_blocks), str(faces.n_interfaces), verdict.outcome.word]


def test_the_nave_needs_its_flying_buttresses(root):
    scene = load_scene(root / "examples" / "nave.toml")
    data = msgspec.to_builtins(scene)
    data["elements"]["flyers"]["present"] = False
    assert assess(build(scene_from(data))).outcome.word == "unstable"
