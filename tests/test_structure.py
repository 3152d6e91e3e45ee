"""The counts of `evidence.structure`, on small sources with known answers and on this one."""

import ast

import pytest

from evidence import structure

DOCUMENTED = '''
def area(width, height):
    """Of a rectangle.

    Parameters
    ----------
    width, height : float
        Of its sides [m].
    """
'''


def written(folder, files):
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


@pytest.fixture
def source(tmp_path):
    """Two rooms that import each other, one of the imports lazy and one for types alone; a module that none imports."""
    return written(
        tmp_path / "src",
        {
            "house/__init__.py": "from house.hall.door import enter\n",
            "house/roof.py": "import house.hall\n",
            "house/hall/__init__.py": "",
            "house/hall/door.py": "def enter():\n    from house.yard.gate import OPEN\n",
            "house/hall/mat.py": "from . import door\n",
            "house/yard/__init__.py": "",
            "house/yard/gate.py": "if TYPE_CHECKING:\n    from ..hall.mat import Mat\n",
        },
    )


def test_a_circle_is_found_through_lazy_and_type_only_imports(source):
    graph = structure.imports(structure.modules(source))
    assert structure.circles(graph) == [["house.hall.door", "house.hall.mat", "house.yard.gate"]]
    assert structure.circles(structure.rooms_graph(graph)) == [["house.hall", "house.yard"]]


def test_rooms_can_be_a_circle_where_modules_are_none(source):
    (source / "house/hall/mat.py").write_text("")
    graph = structure.imports(structure.modules(source))
    assert structure.circles(graph) == []
    assert structure.circles(structure.rooms_graph(graph)) == [["house.hall", "house.yard"]]


def test_two_circles_are_two():
    graph = {"a": {"b"}, "b": {"a", "c"}, "c": {"d"}, "d": {"c"}, "e": {"a"}}
    assert structure.circles(graph) == [["a", "b"], ["c", "d"]]


def test_modules_of_rooms_are_counted(source):
    assert structure.folders(source) == {"house": 2, "house/hall": 2, "house/yard": 1}


def test_functions_without_docstring_and_without_sections_are_counted(tmp_path):
    text = DOCUMENTED + "def bare(x): ...\ndef told(x):\n    'x : given'\ndef nothing(): ...\ndef _own(x): ...\n"
    text += "class Door:\n    def opened(self): ...\n    def turned(self, angle): ...\n"
    written(tmp_path, {"house/roof.py": text})
    found = structure.undocumented(structure.modules(tmp_path))
    assert found["all"] == [f"house.roof.{name}" for name in ("area", "bare", "told", "Door.turned")]
    assert found["no_docstring"] == ["house.roof.bare", "house.roof.Door.turned"]
    assert found["no_parameters"] == ["house.roof.bare", "house.roof.told", "house.roof.Door.turned"]


def test_arguments_of_a_static_method_count():
    (node,) = ast.parse("class A:\n    @staticmethod\n    def f(x): ...\n").body[0].body
    assert structure.takes_arguments(node, method=True)


def test_fields_of_a_spec_that_its_builder_repeats_are_counted(tmp_path):
    written(
        tmp_path,
        {
            "blockstat/spec/kinds.py": "class Arch:\n    present: bool\n    span: float\n    rise: float\n"
            "class Dome:\n    span: float\n    rings: int\n",
            "blockstat/model/arch.py": "def arch(*, span, rise): ...\ndef dome(keys): ...\n",
        },
    )
    assert structure.repeated_fields(tmp_path) == {"kinds.Arch": ["rise", "span"]}


@pytest.mark.parametrize("edit", [".insert(0, 'x')", "[:0] = ['x']", " += ['x']", " = ['x']"])
def test_edits_of_the_path_are_found(tmp_path, edit):
    line = "sys.path" + edit
    written(tmp_path, {"a.py": f"import sys\n{line}\n", "b.py": "sys.path == []\n", ".venv/c.py": f"{line}\n"})
    assert structure.path_edits(tmp_path) == ["a.py:2"]


def test_calls_of_a_librarys_function_are_found(tmp_path):
    text = "from scipy.sparse import csgraph\ncsgraph.connected_components(1)\ncsgraph.other(2)\n"
    inside = "def f():\n    from scipy.sparse.csgraph import connected_components\n    connected_components(1)\n"
    own = "from house.graph import connected_components\nconnected_components(1)\n"
    written(tmp_path, {"house/roof.py": text, "house/door.py": inside, "house/yard.py": own})
    found = structure.calls(structure.modules(tmp_path), "connected_components", "scipy")
    assert found == ["house.door:3", "house.roof:2"]


def test_the_walk_goes_from_the_scene_to_the_verdict(root):
    found = structure.counts(root)
    walk = found["walk"]
    names = [name.rpartition(".")[2] for name in walk["types"]]
    way = [names.index(name) for name in ("PenaltyProgram", "Problem", "ConicProgram", "Answer", "Verdict")]
    assert way == sorted(way)
    assert len(walk["types"]) == len(set(walk["types"]))
    assert set(walk["assess_files"]) < set(walk["files"])
    assert all((root / "src" / file).is_file() for file in walk["files"])
    assert "blockstat.assess" in found["public"]["functions"]
    assert "blockstat.Verdict.summary" in found["public"]["methods"]
    assert structure.page(found).startswith(f"modules: {found['modules']}\n")
