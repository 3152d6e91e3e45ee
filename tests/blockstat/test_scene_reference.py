"""docs/scenes.md and docs/scenes are what the scene language says, and the scene language is what the builders take."""

import re

import msgspec
import pytest

from blockstat import assess, build, load_case, load_scene
from blockstat.loading.cases import KINDS
from blockstat.model import kinds
from blockstat.model.quantities import Length, Three
from blockstat.model.walling.run import Run
from blockstat.sequence.stages import Stage
from blockstat.spec import elements
from blockstat.spec.element import Element
from blockstat.spec.meanings import meanings
from evidence.pages import fill, scene_language


def test_reference_is_up_to_date(root):
    pages = scene_language.pages()
    shown = {name: fill.without_foot((root / "docs" / name).read_text()) for name in pages}
    assert shown == pages, "run make evidence ONLY=scenes"
    written = {f"scenes/{path.name}" for path in (root / "docs" / "scenes").iterdir()}
    assert written == {name for name in pages if "/" in name}


def test_every_kind_of_element_is_on_one_page():
    shown = [kind for _, kinds in scene_language.ELEMENTS.values() for kind in kinds]
    assert sorted(shown) == sorted(elements.KINDS)


def test_every_key_of_a_stage_is_shown():
    shown = re.findall(r"^\| `(\w+)`", scene_language.STAGES, re.M)
    assert tuple(shown) == Stage.__struct_fields__


def cairn(shape: str = "round", *, stones: Three, height: Length = 2.0, **options) -> list:
    """A heap of stones.

    Parameters
    ----------
    shape : str
        Of its plan.
    stones : int
        Their number,
        in all.
    height : float
        Of the heap [m].
    **options
        Those of `Run`.
    """
    return [shape, stones, height, options]


def test_a_builder_is_all_that_a_kind_of_element_needs(monkeypatch):
    kind = kinds.Kind(cairn, more=Run, without=("name", "path", "thickness", "present"))
    monkeypatch.setitem(kinds.KINDS, "cairn", kind)
    table = elements._table("cairn", kind)
    monkeypatch.setitem(elements.KINDS, "cairn", table)
    own = [field for field in msgspec.structs.fields(table) if field.name not in Element.__struct_fields__]
    assert [field.name for field in own][:4] == ["shape", "stones", "height", "align"]
    assert [field.required for field in own][:3] == [False, True, False]
    assert table.__doc__ == "A heap of stones."
    assert meanings(table)["stones"] == "their number, in all"
    assert meanings(table)["leaves"] == meanings(Run)["leaves"]
    found = msgspec.convert({"kind": "cairn", "stones": 3, "leaves": 2}, table)
    assert elements.blocks_of(found)[:3] == ["round", 3, 2.0]
    assert elements.blocks_of(found)[3]["leaves"] == 2
    for bad in ({"stones": 2}, {"stones": 3, "height": 0.0}, {"stones": 3, "colour": 1}, {}):
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert({"kind": "cairn"} | bad, table)


@pytest.mark.parametrize("tag", elements.KINDS)
def test_every_key_of_an_element_has_a_meaning(tag):
    table = elements.KINDS[tag]
    words = meanings(table)
    assert [field.name for field in msgspec.structs.fields(table) if not words.get(field.name)] == []


def test_the_wall_of_the_page_has_a_window_and_two_buttresses_named_as_the_page_says(root, tmp_path):
    page = (root / "docs" / "scenes" / "walls.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "wall.toml").write_text(text)
    wall = build(load_scene(tmp_path / "wall.toml"))
    assert {"front.wall.south.0.3", "front.wall.south.lintel.0.0", "front.buttress.south.2.0.0"} <= set(wall.names)
    assert assess(wall).outcome.word == "stable"


def test_every_key_of_a_load_has_a_meaning_and_the_tied_wall_stands_by_its_tie(root, tmp_path):
    assert scene_language.load_kinds().count("### kind") == len(KINDS)
    page = (root / "docs" / "scenes" / "loads.md").read_text()
    (tied,) = (text for text in re.findall(r"```toml\n(.*?)```", page, re.DOTALL) if "[ties." in text)
    (tmp_path / "tied.toml").write_text(tied)
    wall = build(load_scene(tmp_path / "tied.toml"))
    thrust = load_case(wall, "thrust").loads
    assert assess(wall, loads=thrust).outcome.word == "stable"
    assert assess(wall.with_(ties=()), loads=thrust).outcome.word == "unstable"
