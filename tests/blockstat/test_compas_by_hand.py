"""Objects of COMPAS written by hand: where an element stands, what it is called, and which attribute counts first."""

import copy
import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import InputError, InputWarning, JointLaw, read, write
from blockstat.io.compas.objects import ASSEMBLY, GROUP, MESH, MODEL
from blockstat.io.compas.read import compas_parts
from blockstat.io.compas.write import CompasJoint, write_compas
from evidence.scenes.small import assembly, box

CORNERS = np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 4.0)])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def mesh(attributes=None, dtype=MESH, **changes):
    vertex = {f"k{k}": dict(zip("xyz", corner.tolist(), strict=True)) for k, corner in enumerate(CORNERS)}
    face = {str(k): [f"k{corner}" for corner in face] for k, face in enumerate(FACES)}
    return {"dtype": dtype, "data": {"vertex": vertex, "face": face, "attributes": attributes or {}}, **changes}


def element(name="", **data):
    made = {"name": name, "geometry": mesh(data.pop("mesh", None)), **data}
    return {"dtype": "compas_dem.elements/Block", "data": made}


def matrix(rotvec, shift):
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), shift
    return found


def transformation(found):
    return {"dtype": "compas.geometry/Transformation", "data": {"matrix": found.tolist()}}


def model(elements, children, **data):
    tree = {"root": {"children": children}}
    return {"dtype": MODEL, "data": {"elements": elements, "tree": tree, "graph": {"node": {}}, **data}}


def placed(found):
    return found[:3, :3], found[:3, 3]


def test_an_element_stands_where_the_model_its_groups_and_itself_put_it():
    base, outer = matrix((0.3, 0.2, -0.5), (1, 2, 3)), matrix((-0.4, 0.1, 0.7), (0, 5, -1))
    inner, own = matrix((0.1, 0.9, 0.2), (4, 0, 2)), matrix((0.5, -0.2, 0.3), (-1, 1, 6))
    elements = {
        "stone": element("stone", transformation=transformation(own), is_support=True),
        "wall": {"dtype": GROUP, "data": {"name": "wall", "transformation": transformation(outer)}},
        "north": {"dtype": "my/Group", "data": {"transformation": transformation(inner)}, "name": "north",
                  "inheritance": [GROUP]},
        "loose": element("loose"),
    }  # fmt: skip
    children = [
        {"element": "wall", "children": [{"element": "north", "children": [{"element": "stone"}]}]},
        {"element": "loose"},
    ]  # fmt: skip
    parts = compas_parts(model(elements, children, transformation=transformation(base)), "m")
    assert [(b.name, b.group) for b in parts.blocks] == [("stone", "wall.north"), ("loose", "")]
    assert parts.supports == [0]
    for block, found in zip(parts.blocks, (base @ outer @ inner @ own, base), strict=True):
        turn, shift = placed(found)
        np.testing.assert_allclose(block.vertices, CORNERS @ turn.T + shift, atol=1e-12)
        assert block.faces == FACES
    assert parts.options == {"name": "m"}


def test_a_frame_turns_by_its_axes_although_they_are_neither_unit_nor_square():
    turn = Rotation.from_rotvec((0.4, -0.7, 0.2)).as_matrix()
    x, y = turn[:, 0], 2.5 * turn[:, 1] + 0.3 * turn[:, 0]
    frame = {"dtype": "compas.geometry/Frame", "data": {"point": [1, -2, 3], "xaxis": x.tolist(), "yaxis": y.tolist()}}
    elements = {"a": element("a", transformation=frame, is_support=True)}
    (block,) = compas_parts(model(elements, [{"element": "a"}]), "m").blocks
    np.testing.assert_allclose(block.vertices, CORNERS @ turn.T + [1, -2, 3], atol=1e-12)


@pytest.mark.parametrize("length", [(2, 3), (1e200, 1e-200)])
def test_a_frame_scales_nothing_however_long_its_axes_are(length):
    # COMPAS: x and z = x cross y to unit length, y = z cross x. Here these are the axes of the world.
    data = {"point": [0, 0, 5], "xaxis": [length[0], 0, 0], "yaxis": [0, length[1], 0]}
    frame = {"dtype": "compas.geometry/Frame", "data": data}
    elements = {"a": element("a", transformation=frame, is_support=True)}
    (block,) = compas_parts(model(elements, [{"element": "a"}]), "m").blocks
    np.testing.assert_allclose(block.vertices, CORNERS + [0, 0, 5], atol=1e-12)
    own = {"a": element("a", is_support=True)}
    (block,) = compas_parts(model(own, [{"element": "a"}], transformation=frame), "m").blocks
    np.testing.assert_allclose(block.vertices, CORNERS + [0, 0, 5], atol=1e-12)


@pytest.mark.parametrize(("axes", "words"), [
    (([1, 2, 0], [-2, -4, 0]), r"has the xaxis \[1.0, .*\] and the yaxis \[-2.0, -4.0, 0.0\], which are parallel"),
    (([0, 0, 0], [0, 1, 0]), r"has the xaxis \[0.0, 0.0, 0.0\]; an axis must have a length"),
    (([0, 1, 0], [0, 0, 0]), r"has the yaxis \[0.0, 0.0, 0.0\]; an axis must have a length"),
])  # fmt: skip
@pytest.mark.filterwarnings("error")
def test_axes_that_span_no_plane_are_refused_by_file_and_key(axes, words, tmp_path):
    data = {"point": [0, 0, 0], "xaxis": axes[0], "yaxis": axes[1]}
    frame = {"dtype": "compas.geometry/Frame", "data": data}
    file = tmp_path / "tower.json"
    given = model({"a": element("stone", transformation=frame, is_support=True)}, [{"element": "a"}])
    file.write_text(json.dumps(given))
    words = rf'tower\.json.*element "stone": transformation: a "compas\.geometry/Frame" {words}'
    with pytest.raises(InputError, match=words):
        read(file)


@pytest.mark.parametrize("given", [
    {"matrix": np.full((4, 4), np.nan).tolist()}, {"matrix": np.eye(3).tolist()}, {"matrix": "abc"},
    {"point": [0, 0, 0]},
    {"point": [0, 0], "xaxis": [1, 0, 0], "yaxis": [0, 1, 0]},
    {"point": [0, 0], "xaxis": [1, 0], "yaxis": [0, 1]},
    {"point": [0, 0, 0], "xaxis": [np.nan] * 3, "yaxis": [0, 1, 0]},
])  # fmt: skip
def test_what_is_neither_a_matrix_nor_a_frame_is_named(given):
    elements = {"a": element("stone", transformation={"dtype": "x/Y", "data": given}, is_support=True)}
    with pytest.raises(InputError, match='element "stone": a "x/Y" is neither a 4 by 4 matrix nor a frame'):
        compas_parts(model(elements, [{"element": "a"}]), "m")


@pytest.mark.parametrize("row", [[0, 0, 0, 2], [0.1, 0, 0, 1], [0, 0, 0, 0]])
def test_a_matrix_that_projects_is_refused(row):
    found = matrix((0.1, 0.2, 0.3), (1, 2, 3))
    found[3] = row
    elements = {"a": element("stone", transformation=transformation(found), is_support=True)}
    words = r'element "stone": the last row of a "compas\.geometry/Transformation" is \[0\..*\]; it must be 0, 0, 0, 1'
    with pytest.raises(InputError, match=words):
        compas_parts(model(elements, [{"element": "a"}]), "m")
    found[3] = [0, 0, 0, 1 + 1e-12]
    elements["a"] = element("stone", transformation=transformation(found), is_support=True)
    assert len(compas_parts(model(elements, [{"element": "a"}]), "m").blocks) == 1


@pytest.mark.parametrize("mark", ["false", "True", 2, {"a": 1}])
def test_a_mark_of_a_support_that_is_no_truth_value_is_refused(mark):
    elements = {"a": element("stone", is_support=mark), "b": element(is_support=mark), "c": element(is_support=True)}
    with pytest.raises(InputError) as caught:
        compas_parts(model(elements, [{"element": key} for key in elements]), "m")
    allowed = "it must be true, false, 0 or 1"
    assert list(caught.value.args) == [f'block "{name}": is_support is {mark!r}; {allowed}' for name in ("stone", "b")]


def test_an_attribute_of_an_element_counts_before_its_material_and_its_mesh():
    materials = {"m": {"dtype": "x/M", "data": {"density": 2.0}}}
    elements = {
        "a": element("a", material="m", mesh={"density": 1.0, "group": "g"}, is_support=1),
        "b": element("b", mesh={"density": 1.0, "is_support": True}),
        "c": element("c", material="m", density=3.0), "d": element("d"),
    }  # fmt: skip
    children = [{"element": key} for key in elements]
    parts = compas_parts(model(elements, children, materials=materials), "m")
    assert [b.density for b in parts.blocks] == [2.0, 1.0, 3.0, None]
    assert [b.group for b in parts.blocks] == ["g", "", "", ""]
    assert parts.supports == [0, 1]
    assert compas_parts(model(elements, children, materials=materials), "m", supports=["d"]).supports == ["d"]
    elements["d"] = element("d", material="none")
    with pytest.raises(InputError, match='element "d": no material "none" in the model'):
        compas_parts(model(elements, children, materials=materials), "m")


def test_a_node_counts_before_its_mesh_and_the_defaults_of_the_graph():
    nodes = {
        "1": {"block": mesh({"density": 5.0, "is_support": True}), "is_support": False},
        "'key'": {"block": mesh({"density": 5.0}, name="named", dtype="compas_assembly.datastructures/Block")},
        "(1, 2)": {"block": mesh({"density": 6.0}), "density": 7.0, "is_support": True},
        "odd key": {"block": mesh({"is_support": True})},
    }  # fmt: skip
    graph = {"node": nodes, "default_node_attributes": {"density": 1.0, "group": "all"}}
    data = {
        "graph": {"dtype": "compas.datastructures/Graph", "data": graph},
        "attributes": {"friction": 0.3, "name": "n"},
    }
    given = {"dtype": "my/Assembly", "data": data, "inheritance": [ASSEMBLY]}
    parts = compas_parts(given, "stem")
    assert [b.name for b in parts.blocks] == ["1", "named", "(1, 2)", "odd key"]
    assert [b.density for b in parts.blocks] == [5.0, 5.0, 7.0, 1.0]
    assert {b.group for b in parts.blocks} == {"all"}
    assert parts.supports == [2, 3]
    assert parts.options == {"name": "n", "friction": 0.3}
    assert compas_parts(given | {"name": "top"}, "stem").options["name"] == "top"


def test_defaults_of_a_mesh_stand_for_coordinates_that_are_missing():
    shape = mesh()
    del shape["data"]["vertex"]["k0"]["x"]
    shape["data"]["default_vertex_attributes"] = {"x": -1.0, "y": 9.0, "z": 9.0}
    elements = {"a": {"dtype": "x/B", "data": {"geometry": shape, "is_support": True}}}
    (block,) = compas_parts(model(elements, [{"element": "a"}]), "m").blocks
    np.testing.assert_allclose(block.vertices[0], [-1, 0, 0])
    np.testing.assert_allclose(block.vertices[1:], CORNERS[1:])
    shape["data"]["vertex"]["k2"]["y"] = None
    shape["data"]["face"]["3"] = ["k1", "gone", "k3"]
    with pytest.raises(InputError) as caught:
        compas_parts(model(elements, [{"element": "a"}]), "m")
    texts = caught.value.args
    assert len(texts) == 2
    assert all(text.startswith('block "a": the mesh has a bad vertex or corner') for text in texts)
    assert "(vertex k2)" in texts[0]
    assert "'gone' (face 3)" in texts[1]


def test_a_tree_names_every_element_once_and_none_that_there_is_not():
    elements = {"a": element("stone", is_support=True), "g": {"dtype": GROUP, "data": {}}}
    assert len(compas_parts(model(elements, [{"element": "a"}]), "m").blocks) == 1  # a group may be lost
    with pytest.raises(InputError, match='element "stone": is not in the tree of the model'):
        compas_parts(model(elements, [{"element": "g"}]), "m")
    with pytest.raises(InputError) as caught:
        compas_parts(model(elements, [{"element": "b", "children": [{"element": "c"}]}]), "m")
    assert sorted(caught.value.args) == ['tree: no element "b"', 'tree: no element "c"']
    empty = copy.deepcopy(elements)
    empty["a"]["data"]["geometry"] = None
    with pytest.raises(InputError, match=r'element "stone": a "compas_dem.elements/Block" stores no mesh'):
        compas_parts(model(empty, [{"element": "a"}]), "m")
    with pytest.raises(InputError, match='dtype is "x/Y"; known are: '):
        compas_parts({"dtype": "x/Y", "data": {}}, "m")
    with pytest.raises(InputError, match="written by COMPAS 1"):
        compas_parts({"dtype": MODEL, "value": {}}, "m")


def test_modifiers_are_warned_of_where_the_file_is_read():
    elements = {"a": element("a", is_support=True)}
    edges = {"0": {"1": {"modifiers": [], "x": 1}}, "1": {"2": {}}}
    given = model(elements, [{"element": "a"}], graph={"node": {}, "edge": edges})
    assert compas_parts(given, "m").blocks
    edges["1"]["2"]["modifiers"] = [1]
    with pytest.warns(InputWarning, match="the modifiers between elements are not applied"):
        compas_parts(given, "m")


@pytest.fixture
def tower():
    blocks = [
        box((0, 0, 0), (3, 3, 1), name="base"), box((0, 0, 1), (1, 1, 2), name="a", group="wall", density=2.0),
        box((0, 0, 2), (1, 1, 3), name="b", group="wall.north", density=3.0),
        box((0, 0, 3), (1, 1, 4), name="c", group="roof.east", density=2.0),
    ]  # fmt: skip
    return assembly(blocks, friction=0.4, gravity=(1, 2, -3), name="tower")


JOINTS = [
    CompasJoint((0, 1), [[0.0, 0, 1], [1, 0, 1], [1, 1, 1]], [[0.0, 0, 1], [1, 0, 0], [0, 1, 0]], 1.5, [{"c_np": 1.0}]),
    CompasJoint((0, 1), [[0.0, 0, 1]], [[0.0, 0, 1], [1, 0, 0], [0, 1, 0]], 0.5, [{"c_np": 2.0}]),
    CompasJoint((1, 2), [[0.0, 0, 2]], [[0.0, 0, 1], [1, 0, 0], [0, 1, 0]], 2.5, [{"c_np": 3.0}]),
]


@pytest.mark.parametrize("format", ["compas-assembly", "compas-model"])
def test_what_is_written_for_compas_is_where_compas_looks_for_it(tower, tmp_path, format):
    path, motion = tmp_path / "t.json", np.arange(24.0).reshape(4, 6).tolist()
    write_compas(tower, path, format, joints=JOINTS, attributes={"more": 1}, motion=motion)
    data = json.loads(path.read_text())
    graph = data["data"]["graph"]
    graph = graph["data"] if format == "compas-assembly" else graph
    key = "interfaces" if format == "compas-assembly" else "contacts"
    assert [len(graph["edge"]["0"]["1"][key]), len(graph["edge"]["1"]["2"][key]), graph["edge"]["2"]] == [2, 1, {}]
    joint = graph["edge"]["0"]["1"][key][0]["data"]
    np.testing.assert_allclose(joint["frame"]["data"]["point"], [2 / 3, 1 / 3, 1])
    assert (joint["frame"]["data"]["xaxis"], joint["frame"]["data"]["yaxis"]) == ([1, 0, 0], [0, 1, 0])
    assert (joint["size"], joint["forces"], len(joint["points"])) == (1.5, [{"c_np": 1.0}], 3)
    assert ("holes" in joint) is (format == "compas-model")
    assert [graph["node"][str(k)]["displacement"] for k in range(4)] == motion
    attributes = data["data"]["attributes"] if format == "compas-assembly" else graph["attributes"]
    assert (attributes["friction"], attributes["gravity"], attributes["more"]) == (0.4, [1, 2, -3], 1)
    assert graph["max_node"] == len(graph["node"]) - 1
    back = read(path)
    for field in ("vertices", "support", "density", "gravity"):
        np.testing.assert_array_equal(getattr(back, field), getattr(tower, field))
    assert (back.names, back.groups, back.friction, back.name) == (tower.names, tower.groups, 0.4, "tower")


def test_a_model_has_a_material_for_each_density_and_a_node_for_each_group(tower, tmp_path):
    data = json.loads(write(tower, tmp_path / "t.json", format="compas-model").read_text())["data"]
    assert sorted(material["data"]["density"] for material in data["materials"].values()) == [1.0, 2.0, 3.0]
    assert {material["data"]["poisson"] for material in data["materials"].values()} == {0.2}
    elements = data["elements"]
    root = data["tree"]["root"]["children"]
    names = [elements[node["element"]]["name"] for node in root]
    assert names == ["base", "wall", "roof"]
    wall = [elements[node["element"]]["name"] for node in root[1]["children"]]
    assert wall == ["a", "north"]
    nodes = [elements[node["element"]]["name"] for node in data["graph"]["node"].values()]
    assert nodes == ["base", "a", "b", "c", "wall", "north", "roof", "east"]
    assert [e["data"].get("is_support") for e in elements.values() if e["name"] in ("base", "a")] == [True, False]
    guids = [e["guid"] for e in elements.values()] + [e["data"]["geometry"]["guid"] for e in elements.values()
                                                       if "geometry" in e["data"]]  # fmt: skip
    assert len(set(guids)) == len(guids)
    shape = elements[data["graph"]["node"]["1"]["element"]]["data"]["geometry"]["data"]
    assert (shape["max_vertex"], shape["max_face"]) == (7, 5)
    assert shape["vertex"]["0"] == dict(zip("xyz", tower.block_vertices(1)[0].tolist(), strict=True))
    nowhere = {"x": 0.0, "y": 0.0, "z": 0.0}  # where COMPAS puts what has no place of its own
    assert shape["default_vertex_attributes"] == nowhere
    assert nowhere.items() <= data["graph"]["default_node_attributes"].items()


def test_an_assembly_has_densities_and_groups_as_attributes_of_its_meshes(tower, tmp_path):
    law = tower.with_(joints=[JointLaw(("wall", "*"), friction=0.1)])
    data = json.loads(write(law, tmp_path / "t.json", format="compas-assembly").read_text())["data"]
    nodes = data["graph"]["data"]["node"]
    assert [node["block"]["name"] for node in nodes.values()] == list(tower.names)
    assert [node["is_support"] for node in nodes.values()] == [True, False, False, False]
    assert nodes["2"]["block"]["data"]["attributes"] == {"density": 3.0, "group": "wall.north", "node": 2}
    assert nodes["2"]["block"]["inheritance"] == [MESH]
    assert data["graph"]["data"]["default_edge_attributes"] == {"interfaces": None}
