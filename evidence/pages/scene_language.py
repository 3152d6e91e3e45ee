"""Write docs/scenes.md and docs/scenes, the reference of the scene language, from the structs that read it."""

import inspect
from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

import msgspec

import blockstat
from blockstat.loading.cases import KINDS, OURS
from blockstat.model.expression import CONSTANTS, FUNCTIONS
from blockstat.model.walling import run
from blockstat.spec import Composition, Joint, Material, Range, chapel, elements, material
from blockstat.spec.element import Element, Repeat
from blockstat.spec.meanings import meanings, said
from evidence.paths import DOCS
from evidence.tables import table

HEAD = f"""# Scene files

Written by `make evidence ONLY=scenes` from the tables in `blockstat.spec`. Lengths are in metres and densities in
kg/m3. The z axis points up, and the ground is at z = 0. An unknown key is an error that lists the allowed keys.

A scene has one of two forms: a **composition** of elements, or the **short form** for a rectangular building with a
barrel vault. `parameters`, `with_values`, `build`, the search and the command lines accept both.

```toml
description = "A gate."

[parameters]                                 # the search changes ranges
t = {{ value = 0.5, min = 0.3, max = 0.5, step = 0.1 }}
span = 2.0

[elements.piers]
kind = "pier"
size = ["= t", 0.8]                          # arithmetic over the parameters
height = 1.5
courses = 3
at = ["= -(span + t) / 2", 0, 0]
repeat = {{ number = 2, by = ["= span + t", 0, 0] }}

[elements.ring]
kind = "arch"
span = "= span"
thickness = "= t"
depth = 0.8
voussoirs = 9
at = [0, 0, 1.5]
```

- A string that begins with `=` is arithmetic over the parameters: `+ - * / // % **`, parentheses, comparisons (1 or 0),
  {", ".join(f"`{name}`" for name in [*FUNCTIONS, *CONSTANTS])}. Angles are in radians. Arithmetic
  may replace any number of a composition, also in a parameter, but not the ends and the step of a range.
- A range `{{value, min, max, step}}` may replace any number. The search changes it. Its name is its path in the file,
  such as `parameters.t` or `elements.ring.thickness`.
- `present` of an element, a run, an opening or a buttress is `true`, `false` or `"search"`. The last is a range of 1
  (present, the default) and 0. The search keeps such an element only if the building does not stand without it. A
  joint law or a support that names its groups is void where it is absent.
- The groups of the blocks of an element begin with its name, as in `ring.arch`. If the element is repeated, the number
  of the copy follows, as in `piers.1.pier` and `piers.2.pier`.
- The name of a block is its element, its part and its numbers: `front.wall.south.0.3` is a brick of the run `south` of
  the element `front`. The numbers of walls, piers, barrel vaults and domes are course and stone; of arches and columns
  the stone; of lintels and arches over openings the opening and the stone; of buttresses of a wall the buttress, the
  course and the stone. Buttresses and copies are counted from 1, all else from 0. `blockstat build FILE -o FILE.json`
  writes the names.
- Elements that overlap are an error that names them.

| page | subject |
|---|---|
| this page | the keys of a composition and of every element, ranges |
{{pages}}

In Python the same tables are dicts: `blockstat.build(blockstat.scene_from({{"name": ..., "elements": {{...}}}}))`. You
may also call the builders of `blockstat.model`, and compose their blocks with `moved` and `assemble`.
"""
WRITTEN = "Written by `make evidence ONLY=scenes`. [Scene files](../scenes.md) has the forms of a scene.\n"
#: Kinds of element by the page that has them, with the subject of the page.
ELEMENTS = {
    "walls": ("Walls and buttresses", ("walls", "arc_wall", "buttress", "flying_buttress")),
    "arches": ("Arches, piers and columns", ("arch", "jack_arch", "rib", "pier", "column", "box")),
    "vaults": (
        "Vaults, domes and meshes",
        ("barrel", "groin", "pavilion", "dome", "drum", "sail", "fan", "freeform", "mesh_vault", "mesh"),
    ),
}
#: The other pages: title and subject.
OTHERS = {
    "loads": ("Material, joints, loads, ties and stages", "what both forms of a scene have"),
    "short_form": ("The short form", "a rectangular building with a barrel vault"),
}

LOADS = """## `loads.NAME`

A load has a `kind` and the parameters of the function of `blockstat` that makes it. It acts only in cases that name it.
Coordinates are those of the whole building, in metres with z up; so are those in a file of loads for blocks that
`--units` and `--up` convert. `group` takes groups inside a group along.
"""

CASES = """## `cases.NAME`

A combination of loads, for `--case NAME` and `blockstat cases`.

| key | default | |
|---|---|---|
| `factors` | none | a number by the name of each load that stays |
| `live` | none | a number by the name of each load that a limit analysis multiplies |
| `weight` | 1 | factor on the weight of the blocks |
| `description` | none | one line |
"""

STAGES = """## `stages`

In which stages the building is made, for `blockstat sequence --stages`; one table each, in their order.

| key | default | |
|---|---|---|
| `name` | needed | of the stage |
| `place` | none | groups put in at its beginning |
| `centring` | none | groups that rest on a centring at its end |
| `courses` | false | whether it is judged after each course |
"""

TIED = """A wall with a tie between two anchor plates, and the thrust of a roof:

```toml
description = "A tied wall."

[elements.wall]
kind = "walls"
brick = [0.5, 0.25]

[elements.wall.runs.front]
path = [[0, 0.25], [3, 0.25]]
thickness = 0.5
height = 2.5

[elements.wall.runs.back]
path = [[0, 3.75], [3, 3.75]]
thickness = 0.5
height = 2.5

[elements.plates]
kind = "box"                                 # steel against the outer faces
size = [0.5, 0.03, 0.5]
density = 7850
at = [1.5, -0.015, 1.75]
repeat = { number = 2, by = [0, 4.03, 0] }

[ties.cross]
between = ["plates.1", "plates.2"]
points = [[1.5, -0.03, 2.0], [1.5, 4.03, 2.0]]
greatest = 40e3

[loads.roof]
kind = "line"
start = [0, 0.25, 2.5]
end = [3, 0.25, 2.5]
force = [0, -500, -2000]

[cases.thrust]
factors = { roof = 1.0 }
```

Nothing stands under the plates: the pull of the tie holds them on the wall by friction.
`blockstat limit tied.toml --load 0,-1,0 --case thrust` says what the wall carries.
"""

WALL = """`openings` of a run and `buttresses` are lists of tables, in double brackets. `at` is a list with one number
for each opening or buttress:

```toml
description = "A wall with a window and two buttresses."

[elements.front]
kind = "walls"
brick = [0.5, 0.25]

[elements.front.runs.south]
path = [[0, 0], [6, 0]]
thickness = 0.4
height = 3.0

[[elements.front.runs.south.openings]]
width = 0.9
height = 1.0
sill = 1.0
at = [3.0]

[[elements.front.buttresses]]
wall = "south"
width = 0.5
projection = 0.5
height = 2.0
at = [1.0, 5.0]
```
"""
#: What docstrings call a work, and what the pages do; the first on a page is a link.
WORK = "the procedural-masonry paper"
PAPER, LINK = "the paper", "the paper ([Fita 2017](../bibliography.md#fita-2017))"


#: The public functions that kinds of loads stand for, beside `point_load` for "point" and so on.
FUNCTIONS_OF_LOADS = {"pressure": "fluid_pressure", "acceleration": "acceleration"}


def load_kinds() -> str:
    """Keys of the loads, by kind."""
    parts = [LOADS]
    for name in KINDS:
        make = getattr(blockstat, FUNCTIONS_OF_LOADS.get(name, f"{name}_load"))
        words = said(make)
        rows = [
            [f"`{key}`", "needed" if own.default is own.empty else shown(own.default), words[key]]
            for key, own in inspect.signature(make).parameters.items()
            if key not in OURS
        ]
        first = (inspect.getdoc(make) or "").split("\n\n")[0]
        parts.append(f'### kind = "{name}"\n\n{first}\n\n{table(["key", "default", ""], rows)}\n')
    return "\n".join(parts)


def keys(kind: type, without: frozenset[str] = frozenset()) -> str:
    """Keys of a struct, their defaults and what they mean."""
    words = meanings(kind)
    rows = []
    for field in msgspec.structs.fields(kind):
        if field.name in without:
            continue
        if not words.get(field.name):
            raise SystemExit(f"{kind.__name__}.{field.name} has no comment")
        rows.append([f"`{field.name}`", default(field), words[field.name] + allowed(field.type, words[field.name])])
    return table(["key", "default", ""], rows)


def allowed(kind: Any, said: str) -> str:
    """The words that a key may have, if they are few and not yet said."""
    words = get_args(kind) if get_origin(kind) is Literal else ()
    return "" if all(word in said for word in words) else f": {', '.join(words)}"


def default(field: msgspec.structs.FieldInfo) -> str:
    if field.required:
        return "needed"
    value = field.default
    if value is msgspec.NODEFAULT:
        value = field.default_factory()
    return "a table" if isinstance(value, msgspec.Struct) else shown(value)


def shown(value: Any) -> str:
    """A default in the words of a scene file."""
    if value is None or value in ((), [], {}, ""):
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in value) + "]"
    return str(value)


def section(title: str, kind: type, level: int = 3, **options) -> str:
    return f"{'#' * level} {title}\n\n{inspect.getdoc(kind)}\n\n{keys(kind, **options)}\n"


def first_page() -> str:
    """The forms of a scene, and what every element has."""
    rows = [f"| [{title}](scenes/{name}.md) | {', '.join(f'`{kind}`' for kind in kinds)} |"
            for name, (title, kinds) in ELEMENTS.items()]  # fmt: skip
    loads, short = OTHERS["loads"][0], OTHERS["short_form"][0]
    rows.append(f"| [{loads}](scenes/loads.md) | both forms: material, joints, loads, cases, ties, chance, stages |")
    rows.append(f"| [{short}](scenes/short_form.md) | a rectangular building with a barrel vault |")
    parts = [HEAD.replace("{pages}", "\n".join(rows)), section("Compositions", Composition, 2)]
    parts += [section("Every element", Element, 2), section("`repeat`", Repeat), section("A range", Range, 2)]
    below = "\n".join(f"scenes/{name}" for name in (*ELEMENTS, *OTHERS))
    return "\n".join([*parts, f"```{{toctree}}\n:hidden:\n\n{below}\n```\n"])


def elements_page(title: str, kinds: Sequence[str]) -> str:
    """The keys of some kinds of element."""
    parts = [f"# {title}\n\n{WRITTEN}"]
    for tag in kinds:
        parts.append(section(f'kind = "{tag}"', elements.KINDS[tag], 2, without=frozenset(Element.__struct_fields__)))
        if tag == "walls":
            parts.append(WALL)
            parts.append(section("`runs.NAME`", run.Run, without=frozenset({"name"})))
            shared = (("buttresses", run.Buttress), ("openings", run.Opening), ("coping", run.Coping))
            parts += [section(f"`{name}`", own) for name, own in (*shared, ("through", run.Through))]
    return "\n".join(parts)


def loads_page() -> str:
    """The keys that both forms of a scene have."""
    parts = [f"# {OTHERS['loads'][0]}\n\n{WRITTEN}"]
    parts += [section("`material`", Material, 2), section("`joints`", Joint, 2)]
    parts += [load_kinds(), CASES, section("`ties.NAME`", material.TieTable, 2), TIED]
    parts += [section("`uncertain.KEY`", material.Uncertain, 2), STAGES]
    return "\n".join(parts)


def short_form_page() -> str:
    """The keys of a rectangular building with a barrel vault."""
    parts = [f"# {OTHERS['short_form'][0]}\n\n{WRITTEN}", section("The building", chapel.Building, 2)]
    short = (("brick", chapel.Brick), ("wall", chapel.Wall), ("doors.WALL, windows.WALL", chapel.Opening),
             ("buttresses.WALL", chapel.Buttress), ("vault", chapel.Vault))  # fmt: skip
    return "\n".join([*parts, *(section(f"`{name}`", kind, 2) for name, kind in short)])


def pages() -> dict[str, str]:
    """The whole reference, by file in docs."""
    return {name: text.replace(WORK, LINK, 1).replace(WORK, PAPER) for name, text in _pages().items()}


def _pages() -> dict[str, str]:
    """The same in the words of the docstrings."""
    found = {"scenes.md": first_page()}
    found |= {f"scenes/{name}.md": elements_page(title, kinds) for name, (title, kinds) in ELEMENTS.items()}
    return found | {"scenes/loads.md": loads_page(), "scenes/short_form.md": short_form_page()}


if __name__ == "__main__":
    for name, text in pages().items():
        (DOCS / name).parent.mkdir(exist_ok=True)
        (DOCS / name).write_text(text)
