"""COMPAS JSON, on files that the COMPAS packages wrote (tests/crosscheck/test_compas.py runs the packages)."""

import json

import numpy as np
import pytest

from blockstat import Assembly, InputError, InputWarning, assess, box, build, load_scene, read, write, write_verdict
from compas_files import FILES, assert_same
from evidence.scenes.small import arch


@pytest.fixture
def files(root):
    return root / "tests" / "data" / "compas"


@pytest.mark.parametrize("name", FILES)
def test_files_of_compas_are_read_as_compas_reads_them(files, name):
    expected = json.loads((files / f"{name}.expected.json").read_text())
    assert_same(read(files / f"{name}.json"), expected)


def test_what_the_fixtures_hold(files):
    """Against numbers worked out by hand, so that the two readers cannot be wrong in the same way."""
    asm = read(files / "assembly.json")
    assert asm.names == ("the ground", "камень/1", "top")
    assert asm.support.tolist() == [True, False, False]
    assert asm.density.tolist() == [2691.0, 2691.0, 1800.0]
    np.testing.assert_allclose(asm.volume, [16, 1, 0.5])
    turned = read(files / "model.json")
    assert turned.groups == ("wall", "wall.north")
    # The group is moved by (2, 0, 0), and the model is turned by 30 degrees about z after that.
    np.testing.assert_allclose(turned.centroid, [[3**0.5, 1, 0], [3**0.5, 1, 1]], atol=1e-14)
    assert read(files / "bare_assembly.json").names == ("0", "tip")


@pytest.mark.parametrize("format", ["compas-assembly", "compas-model"])
def test_our_compas_files_are_exact(tmp_path, root, format):
    chapel = build(load_scene(root / "examples" / "chapel.toml"))
    back = read(write(chapel, tmp_path / "chapel.json", format=format))
    assert (back.name, back.names, back.groups, back.friction) == (
        chapel.name,
        chapel.names,
        chapel.groups,
        chapel.friction,
    )
    for field in ("vertices", "face_vertices", "face_start", "support", "gravity", "density"):
        np.testing.assert_array_equal(getattr(back, field), getattr(chapel, field))


def test_the_same_assembly_makes_the_same_file(tmp_path):
    one = write(arch(3, 0.2), tmp_path / "one.json", format="compas-model").read_text()
    assert write(arch(3, 0.2), tmp_path / "two.json", format="compas-model").read_text() == one


def test_a_frame_stands_for_a_transformation(files, tmp_path):
    data = json.loads((files / "model.json").read_text())
    data["data"]["transformation"] = {
        "dtype": "compas.geometry/Frame",
        "data": {"point": [0, 0, 7], "xaxis": [0, 1, 0], "yaxis": [-1, 0, 0]},
    }
    path = tmp_path / "framed.json"
    path.write_text(json.dumps(data))
    np.testing.assert_allclose(read(path).centroid, [[0, 2, 7], [0, 2, 8]], atol=1e-14)


def _of_an_older_version(data, renamed):
    """A file without lists of bases, with some classes of another name."""
    if isinstance(data, dict):
        kept = {key: _of_an_older_version(own, renamed) for key, own in data.items() if key != "inheritance"}
        return kept | ({"dtype": renamed.get(data["dtype"], data["dtype"])} if "dtype" in data else {})
    return [_of_an_older_version(own, renamed) for own in data] if isinstance(data, list) else data


@pytest.mark.parametrize(
    ("name", "renamed"),
    [
        ("assembly", {"compas_assembly.datastructures/Assembly": "compas_cra.datastructures/CRA_Assembly"}),
        ("bare_assembly", {"compas_assembly.datastructures/Block": "compas_cra.datastructures/CRA_Block"}),
        ("plain_model", {"compas_model.models/Model": "compas_grid.models/GridModel"}),
        ("model", {"compas.datastructures/Mesh": "compas_dem.elements/BlockMesh"}),
    ],
)
def test_derived_classes_of_files_without_a_list_of_bases_are_read(files, tmp_path, name, renamed):
    data = _of_an_older_version(json.loads((files / f"{name}.json").read_text()), renamed)
    text = json.dumps(data)
    assert "inheritance" not in text
    assert all(own in text for own in renamed.values())
    (tmp_path / f"{name}.json").write_text(text)
    assert_same(read(tmp_path / f"{name}.json"), json.loads((files / f"{name}.expected.json").read_text()))


def test_a_graph_of_something_else_is_no_assembly(files, tmp_path):
    data = _of_an_older_version(
        json.loads((files / "assembly.json").read_text()),
        {"compas_assembly.datastructures/Assembly": "mine.datastructures/Truss"},
    )
    nodes = data["data"]["graph"]["data"]["node"]
    del next(iter(nodes.values()))["block"]
    (tmp_path / "truss.json").write_text(json.dumps(data))
    with pytest.raises(InputError, match=r'dtype is "mine\.datastructures/Truss"; known are: '):
        read(tmp_path / "truss.json")


def test_modifiers_are_not_applied_silently(files, tmp_path):
    data = json.loads((files / "model.json").read_text())
    data["data"]["graph"]["edge"]["0"] = {"1": {"modifiers": [{"dtype": "x/Y", "data": {}}]}}
    path = tmp_path / "modified.json"
    path.write_text(json.dumps(data))
    with pytest.warns(InputWarning, match="modifiers between elements are not applied"):
        read(path)


def test_a_truncated_file_names_the_line(files, tmp_path):
    text = (files / "model.json").read_text()
    path = tmp_path / "cut.json"
    path.write_text(text[: len(text) // 2])
    with pytest.raises(InputError, match=r"cut\.json: line 1, column \d+: not valid JSON"):
        read(path)


def _elements(data):
    return data["data"]["elements"].values()


def _unknown(data):
    data |= {"dtype": "compas.geometry/Box", "inheritance": []}


def _first_version(data):
    data["value"] = data.pop("data")


def _no_tree(data):
    del data["data"]["tree"]


def _beam(data):
    element = next(e for e in _elements(data) if e["name"] == "top")
    element["dtype"] = "compas_model.elements/BeamElement"
    del element["data"]["geometry"]


def _brep(data):
    next(e for e in _elements(data) if e["name"] == "top")["data"]["geometry"]["dtype"] = "compas.geometry/Brep"


def _lost_corner(data):
    del next(e for e in _elements(data) if e["name"] == "top")["data"]["geometry"]["data"]["vertex"]["3"]


def _no_number(data):
    next(e for e in _elements(data) if e["name"] == "top")["data"]["geometry"]["data"]["vertex"]["3"]["x"] = "far"


def _open(data):
    del next(e for e in _elements(data) if e["name"] == "top")["data"]["geometry"]["data"]["face"]["3"]


def _bad_matrix(data):
    data["data"]["transformation"]["data"]["matrix"] = [[1, 0], [0, 1]]


def _lost_element(data):
    data["data"]["tree"]["root"]["children"][0]["element"] = "nobody"


def _no_supports(data):
    for element in _elements(data):
        element["data"]["is_support"] = False


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (_unknown, 'dtype is "compas.geometry/Box"; known are: compas_assembly.datastructures/Assembly, '),
        (_first_version, "written by COMPAS 1 or an older version; load it in COMPAS 2"),
        (_no_tree, "compas_dem.models/BlockModel: tree is missing; keys here are: elements, tree,"),
        (_beam, 'element "top": a "compas_model.elements/BeamElement" stores no mesh'),
        (_brep, 'element "top": geometry is a "compas.geometry/Brep"; only meshes'),
        (_lost_corner, "block \"top\": the mesh has a bad vertex or corner: '3'"),
        (_no_number, 'block "top": the mesh has a bad vertex or corner: could not convert string'),
        (_open, 'block "top": its surface is open'),
        (_bad_matrix, 'model: a "compas.geometry/Rotation" is neither a 4 by 4 matrix nor a frame'),
        (_lost_element, 'tree: no element "nobody"'),
        (_no_supports, "the file does not say which blocks are supports; give their names or numbers"),
    ],
)
def test_bad_compas_files(files, tmp_path, spoil, expected):
    data = json.loads((files / "model.json").read_text())
    spoil(data)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: {expected}")
    assert "\n" not in str(error.value)


def test_unknown_formats(tmp_path):
    with pytest.raises(InputError, match=r'cannot be written as "ifc"; it can be: native, compas-assembly'):
        write(arch(3, 0.2), tmp_path / "a.json", format="ifc")
    with pytest.raises(InputError, match='cannot be written as "compas-model"'):
        write(arch(3, 0.2), tmp_path / "a.obj", format="compas-model")


def net_force(data, block):
    """Force on a block by the joints of a COMPAS file: those that point into it, less those that point out."""
    graph = data["data"]["graph"]
    net = np.zeros(3)
    for u, others in graph.get("data", graph)["edge"].items():
        for v, edge in others.items():
            for joint in next(value for key, value in edge.items() if key in ("interfaces", "contacts")):
                own = joint["data"]
                x, y = (np.array(own["frame"]["data"][axis]) for axis in ("xaxis", "yaxis"))
                for f in own["forces"]:
                    force = (f["c_np"] - f["c_nn"]) * np.cross(x, y) + f["c_u"] * x + f["c_v"] * y
                    net += force * ((int(v) == block) - float(int(u) == block))
    return net


@pytest.mark.parametrize("format", ["compas-assembly", "compas-model"])
@pytest.mark.parametrize("shift", [0.2, 0.7])
def test_a_verdict_travels_with_joints_forces_and_motion(tmp_path, format, shift):
    blocks = [
        box((-2, -2, -1), (2, 2, 0), name="ground"),
        box((0, 0, 0), (1, 1, 1), name="base", group="wall.north"),
        box((shift, 0, 1), (1 + shift, 1, 2), name="top", group="wall"),
    ]
    asm = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, gravity=(0.0, 0.0, -10.0))
    path = write_verdict(assess(asm), tmp_path / "tower.json", format=format)
    data = json.loads(path.read_text())
    # Residual tension counts as a force: with it the upper block balances even where nothing admissible holds it.
    np.testing.assert_allclose(net_force(data, 1), [0, 0, 10e3], atol=1e-3)
    np.testing.assert_allclose(net_force(data, 2), [0, 0, 10e3], atol=1e-3)
    graph = data["data"]["graph"].get("data", data["data"]["graph"])
    tip = np.array(graph["node"]["2"]["displacement"])
    attributes = data["data"]["attributes"] if format == "compas-assembly" else graph["attributes"]
    if shift < 0.5:
        assert attributes["verdict"]["outcome"] == "stable"
        assert not tip.any()
    else:
        assert attributes["verdict"]["outcome"] == "unstable"
        assert tip[4] > 0  # it tips about y, over the edge on the side of +x
    assert read(path).names == asm.names


def test_a_verdict_is_written_in_formats_of_compas_only(tmp_path):
    verdict = assess(arch(3, 0.2))
    with pytest.raises(InputError, match="format is 'native'; it must be one of: compas-assembly, compas-model"):
        write_verdict(verdict, tmp_path / "a.json", format="native")
    with pytest.raises(InputError, match="no such directory"):
        write_verdict(verdict, tmp_path / "none" / "a.json")
