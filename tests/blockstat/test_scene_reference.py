"""docs/scenes.md is what the structs say, and the structs say what the builders take."""

import inspect

import msgspec
import pytest

from blockstat.model import kinds
from blockstat.model.walling import run
from blockstat.model.walling.arc_wall import arc_wall
from blockstat.model.walling.walls import walls
from blockstat.spec import elements
from blockstat.spec import walls as keys
from blockstat.spec.element import Element
from evidence.pages import scene_language


def test_reference_is_up_to_date(root):
    assert (root / "docs" / "scenes.md").read_text() == scene_language.page(), "run make evidence ONLY=scenes"


def given(kind) -> dict[str, object]:
    """Defaults of the keys of a struct, `...` for those that are needed."""
    found = {}
    for field in msgspec.structs.fields(kind):
        default = (
            field.default_factory() if field.default is msgspec.NODEFAULT and not field.required else field.default
        )
        found[field.name] = ... if field.required else default
    return found


def taken(builder) -> dict[str, object]:
    options = inspect.signature(builder).parameters.values()
    return {o.name: ... if o.default is o.empty else o.default for o in options if o.kind is not o.VAR_KEYWORD}


@pytest.mark.parametrize("kind", kinds.PLAIN, ids=lambda kind: kind.__struct_config__.tag)
def test_keys_of_an_element_are_the_options_of_its_builder(kind):
    own = {key: value for key, value in given(kind).items() if key not in Element.__struct_fields__}
    assert own == taken(kinds.PLAIN[kind])


@pytest.mark.parametrize(
    ("kind", "record", "more"),
    [
        (keys.Run, run.Run, {"name"}),
        (keys.WallOpening, run.Opening, set()),
        (keys.Coping, run.Coping, set()),
        (keys.Through, run.Through, set()),
        (keys.WallButtress, run.Buttress, set()),
    ],
)
def test_keys_of_walls_are_those_of_the_builder(kind, record, more):
    own = {key: value for key, value in given(kind).items() if key != "present"}
    options = {key: value for key, value in taken(record).items() if key not in more}
    assert own == options


def test_keys_of_the_walls_themselves():
    assert set(given(keys.Walls)) - set(Element.__struct_fields__) == set(taken(walls))
    own = {key: value for key, value in given(keys.ArcWall).items() if key not in Element.__struct_fields__}
    options = taken(arc_wall) | taken(run.Run)
    assert {key: options[key] for key in own if key not in ("thickness", "height")} == {
        key: value for key, value in own.items() if key not in ("thickness", "height")
    }


def test_every_kind_has_a_builder():
    assert set(elements.KIND_LIST) == set(kinds.PLAIN) | set(kinds._SPECIAL)
