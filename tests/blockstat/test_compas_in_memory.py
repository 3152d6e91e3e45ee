"""Objects of COMPAS in memory, by stand-ins with the methods that are used: what is refused, warned of and written."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import InputError, InputWarning, assess
from blockstat.compas import cra_penalty_solve, from_compas, rbe_solve, solve
from evidence.scenes.small import box

WEIGHT = 2.0  #: of the stone, 1 x 1 x 2, of density 1 under a gravity of 1
DOWN, LEANING, TIPPING = (0, 0, -1), (0.25, 0, -1), (0.6, 0, -1)


class Graph:
    def __init__(self, nodes):
        self.node, self.joints, self.attributes = {node: {} for node in nodes}, {}, {}
        self.default_node_attributes = {}

    def nodes(self):
        return list(self.node)

    def edges(self):
        return list(self.joints)

    def node_attribute(self, node, name, value):
        self.node[node][name] = value

    def edge_attribute(self, edge, key, value=None):
        if value is not None:
            self.joints[edge][key] = value
        return self.joints[edge].get(key)

    def has_edge(self, edge, directed=True):
        return edge in self.joints or (not directed and edge[::-1] in self.joints)

    def add_edge(self, u, v):
        self.joints[u, v] = {}

    def delete_edge(self, edge):
        del self.joints[edge]


class Group:
    def __init__(self, name, parent):
        self._name, self.parent = name, parent


class Mesh:
    def __init__(self, block, name=None, **attributes):
        self._block, self._name, self.attributes = block, name, attributes

    def to_vertices_and_faces(self):
        return self._block.vertices, self._block.faces


MESHES = {
    "ground": Mesh(box((-5, -5, -1), (5, 5, 0)), is_support=True),
    "stone": Mesh(box((0, 0, 0), (1, 1, 2))),
    "other": Mesh(box((2, 0, 0), (3, 1, 2))),
}
BASE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
UP = SimpleNamespace(zaxis=(0, 0, 1), xaxis=(1, 0, 0), yaxis=(0, 1, 0))
UNDER = SimpleNamespace(zaxis=(0, 0, -1), xaxis=(1, 0, 0), yaxis=(0, -1, 0))


def assembled(*nodes, **edges):
    """An assembly of compas_assembly, with joints at its edges."""
    graph = Graph(nodes or ("ground", "stone"))
    for edge, joints in edges.items():
        graph.joints[tuple(edge.split("_"))] = {"interfaces": joints}
    return SimpleNamespace(graph=graph, node_block=MESHES.get, attributes={}, name="tower")


def joint(frame=UP, scale=1.0):
    return SimpleNamespace(points=scale * np.array(BASE), frame=frame, size=1.0, forces=None)


def element(name, mesh, *groups, **options):
    parent = None
    for group in groups:
        parent = Group(group, parent)
    return SimpleNamespace(_name=name, modelgeometry=mesh, graphnode=name, parent=parent, material=None, **options)


def model(*elements):
    """A model of compas_model."""
    graph = Graph([own.graphnode for own in elements])
    return SimpleNamespace(graph=graph, elements=lambda: elements, name="model", guid="m")


def tower_model():
    made = model(
        element("ground", MESHES["ground"], is_support=True), element("stone", MESHES["stone"], "wall", "north")
    )
    made.graph.joints["ground", "stone"] = {
        "contacts": [SimpleNamespace(points=BASE, frame=UP, size=1.0)]  # a contact has no place for forces
    }
    return made


def total(forces):
    return {name: sum(own[name] for own in forces) for name in forces[0]}


class Brep:
    pass


@pytest.mark.parametrize(
    ("thing", "words"),
    [
        (object(), "a object is neither an Assembly of compas_assembly, a Model of compas_model"),
        (model(element("ground", MESHES["ground"]), element("vault", Brep())), '"vault": its geometry is a Brep; only'),
        (assembled(ground_gone=[joint()]), "a joint ends at node 'gone', which has no block"),
        (assembled(ground_stone=[joint(UNDER)]), r"edge \(ground, stone\) points from stone to ground; its z axis"),
        (assembled(ground_stone=[SimpleNamespace(points=[], frame=UP)]), r"edge \(ground, stone\) lacks points"),
        (assembled(ground_stone=[SimpleNamespace(points=BASE, frame=None)]), r"\(ground, stone\) lacks a frame"),
        (assembled(ground_stone=[joint(scale=1000)]), r"joint on the edge \(ground, stone\) are not between the two"),
        (assembled(stone_stone=[joint()]), r"edge \(stone, stone\) lacks a second node"),
        (assembled(stone_ground=[joint(UP)]), r"edge \(stone, ground\) points from ground to stone; its z axis"),
    ],
)
def test_what_cannot_be_read_is_refused_by_its_name(thing, words):
    with pytest.raises(InputError, match=words):
        solve(thing)


def test_blocks_keep_names_groups_and_supports_of_the_object():
    read = from_compas(tower_model())
    assert read.names == ("ground", "stone")
    assert read.groups == ("", "wall.north")
    assert read.support.tolist() == [True, False]


@pytest.mark.parametrize("made", [lambda: assembled(ground_stone=[joint()]), tower_model], ids=["assembly", "model"])
def test_an_object_that_states_friction_and_gravity_is_judged_by_them(made):
    """Under a gravity that leans by .4 the stone of 1 x 1 x 2 m slides at friction .3 and stands at .45."""
    thing = made()
    own = thing.graph.attributes if made is tower_model else thing.attributes
    own.update(friction="inf", gravity=[0.4, 0, -1])
    read = from_compas(thing)
    assert (read.friction, read.gravity.tolist()) == (np.inf, [0.4, 0, -1])
    assert from_compas(thing, friction=0.2, gravity=DOWN).gravity.tolist() == [0, 0, -1]
    for friction, outcome in ((0.3, "unstable"), (0.45, "stable")):
        own["friction"] = friction
        assert assess(from_compas(thing)).outcome.word == outcome
        if made is not tower_model:
            assert solve(thing).attributes["verdict"]["outcome"] == outcome


def test_marks_of_a_mesh_count_where_an_element_has_none_and_only_groups_make_a_group():
    block = box((0, 0, 0), (1, 1, 2))
    meshes = [Mesh(block, density=1500.0, group="own"), Mesh(box((0, 0, 2), (1, 1, 3)))]
    stone, top = (element(name, mesh) for name, mesh in zip(("stone", "top"), meshes, strict=True))
    top.parent = SimpleNamespace(_name="stone", parent=Group("wall", Group(None, None)))
    read = from_compas(model(element("ground", MESHES["ground"]), stone, top), density=2000.0)
    assert read.density.tolist() == [2000.0, 1500.0, 2000.0]
    assert read.groups == ("", "own", "wall")
    assert read.support.tolist() == [True, False, False]


def test_a_mirrored_element_is_a_solid():
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    block = box((0, 0, 0), (1, 1, 2))
    image = Mesh(SimpleNamespace(vertices=block.vertices * (-1, 1, 1), faces=block.faces))
    stone = element("stone", image, modeltransformation=SimpleNamespace(matrix=mirror))
    read = from_compas(model(element("ground", MESHES["ground"], is_support=True), stone))
    assert read.volume[1] == pytest.approx(2.0)


def test_names_that_blocks_of_an_object_share_are_numbered_past_those_that_are_taken():
    meshes = {0: Mesh(box((0, 0, -1), (9, 1, 0)), "a.1", is_support=True)}
    meshes |= {k: Mesh(box((2 * k, 0, 0), (2 * k + 1, 1, 1)), "a") for k in (1, 2)}
    thing = SimpleNamespace(graph=Graph(meshes), node_block=meshes.get, attributes={}, name="row")
    with pytest.warns(InputWarning, match=r'several blocks share a name \("a"\)'):
        assert from_compas(thing).names == ("a.1", "a.0", "a.2")
    with pytest.raises(InputError, match='supports: 2 blocks are named "a"; give their indices'):
        from_compas(thing, supports=["a"])


@pytest.mark.parametrize("mark", ["false", 2])
def test_a_mark_of_a_support_of_an_object_is_a_truth_value(mark):
    meshes = {"g": Mesh(box((0, 0, 0), (1, 1, 1)), is_support=mark)}
    thing = SimpleNamespace(graph=Graph(meshes), node_block=meshes.get, attributes={}, name="one")
    made = model(element("g", MESHES["stone"], is_support=mark))
    for given in (thing, made):
        with pytest.raises(InputError, match=f'block "g": is_support is {mark!r}; it must be true, false, 0 or 1'):
            from_compas(given)


@pytest.mark.parametrize(("edge", "frame", "side"), [("ground_stone", UP, -1), ("stone_ground", UNDER, 1)])
def test_forces_are_written_on_the_block_that_the_frame_points_into(edge, frame, side):
    own = joint(frame)
    thing = solve(assembled(**{edge: [own]}), density=1.0, gravity=LEANING)
    assert thing.attributes["verdict"]["outcome"] == "stable"
    # The ground holds the stone back against x; the stone drags the ground along.
    expected = {"c_np": WEIGHT, "c_nn": 0.0, "c_u": side * 0.25 * WEIGHT, "c_v": 0.0}
    assert total(own.forces) == pytest.approx(expected, abs=1e-6)


def test_a_motion_is_written_for_blocks_that_can_move_and_is_as_large_as_asked():
    thing = solve(assembled(ground_stone=[joint()]), density=1.0, gravity=TIPPING, motion=0.25)
    assert thing.attributes["verdict"]["outcome"] == "unstable"
    assert "displacement" not in thing.graph.node["ground"]
    moved = np.array(thing.graph.node["stone"]["displacement"])
    arms = MESHES["stone"].to_vertices_and_faces()[0] - np.array([0.5, 0.5, 1.0])
    assert np.linalg.norm(moved[:3] + np.cross(moved[3:], arms), axis=1).max() == pytest.approx(0.25, rel=1e-6)


def test_forces_alone_are_written_by_the_stand_in_for_compas_cra_and_said_where_asked(capsys):
    for options in ({}, {"verbose": True}, {"timer": True}):
        own = joint()
        thing = rbe_solve(assembled(ground_stone=[own]), **options)
        assert "displacement" not in thing.graph.node["stone"]
        assert total(own.forces)["c_np"] == pytest.approx(WEIGHT)
        out = capsys.readouterr().out
        assert ("Stable: " in out) is ("verbose" in options)
        assert ("--- solving time: " in out) is ("timer" in options)


def test_the_stand_in_for_cra_penalty_scales_a_mechanism_to_the_largest_slip_or_opening_asked_for():
    overhanging = {"ground": Mesh(box((-5, -5, -1), (0.25, 5, 0)), is_support=True), "stone": MESHES["stone"]}
    edge = [[0, 0, 0], [0.25, 0, 0], [0.25, 1, 0], [0, 1, 0]]
    own = SimpleNamespace(points=edge, frame=UP, size=0.25, forces=None)
    thing = assembled(ground_stone=[own])
    thing.node_block = overhanging.get
    cra_penalty_solve(thing, d_bnd=0.02)
    assert thing.attributes["verdict"]["outcome"] == "unstable"
    # The stone turns about the edge at x = 1/4, so the joint opens by 0.02 at x = 0.
    turn = np.array(thing.graph.node["stone"]["displacement"][3:])
    assert turn == pytest.approx([0, 0.02 / 0.25, 0], abs=1e-6)
    assert "displacement" not in thing.graph.node["ground"]


def test_blocks_that_touch_without_a_recorded_joint_are_named():
    with pytest.warns(InputWarning, match=r'joints="found" would add: ground \| other$'):
        thing = solve(assembled("ground", "stone", "other", ground_stone=[joint()]), density=1.0, gravity=DOWN)
    verdict = thing.attributes["verdict"]
    assert verdict["outcome"] == "unstable"
    assert any("ground | other" in text for text in verdict["warnings"])


def stand_ins(monkeypatch, **modules):
    for name, module in modules.items():
        full = name.replace("__", ".")
        for k in range(1, full.count(".") + 1):
            parent = ".".join(full.split(".")[:k])
            monkeypatch.setitem(sys.modules, parent, SimpleNamespace(__path__=[]))
        monkeypatch.setitem(sys.modules, full, module)


@pytest.mark.parametrize("edges", [{}, {"ground_stone": []}, {"stone_ground": []}])
def test_joints_that_were_found_go_along_the_edge_from_the_first_block_to_the_second(monkeypatch, edges):
    stand_ins(
        monkeypatch,
        compas__geometry=SimpleNamespace(Frame=lambda point, x, y: (point, x, y)),
        compas_assembly__datastructures=SimpleNamespace(Interface=SimpleNamespace),
    )
    thing = solve(assembled(**edges), density=1.0, gravity=DOWN)
    assert thing.graph.edges() == [("ground", "stone")]
    [made] = thing.graph.joints["ground", "stone"]["interfaces"]
    assert made.size == pytest.approx(1.0)
    assert total(made.forces)["c_np"] == pytest.approx(WEIGHT)


def test_a_contact_of_a_model_becomes_one_that_holds_forces_or_says_what_to_install(monkeypatch):
    stand_ins(monkeypatch, compas_dem__interactions=None)
    with pytest.raises(InputError, match="pip install compas_dem"):
        solve(tower_model(), density=1.0)
    stand_ins(monkeypatch, compas_dem__interactions=SimpleNamespace(FrictionContact=SimpleNamespace))
    thing = solve(tower_model(), density=1.0, gravity=DOWN)
    [made] = thing.graph.joints["ground", "stone"]["contacts"]
    assert total(made.forces)["c_np"] == pytest.approx(WEIGHT)
    assert thing.graph.attributes["verdict"]["outcome"] == "stable"


def problem(contact_model=None):
    """A problem of compas_dem; its loads are those of `compas_dem`."""
    contact = SimpleNamespace(contact_model=contact_model)
    return SimpleNamespace(model=tower_model(), boundary_conditions=[], contact_properties=contact, guid="p")


class Results(SimpleNamespace):
    def set_node(self, node, name, value):
        self.nodes = {**getattr(self, "nodes", {}), node: value}

    def set_edge(self, edge, name, value):
        self.edges = {**getattr(self, "edges", {}), name: value}


def compas_dem(push, prescribed=()):
    return {
        "compas__geometry": SimpleNamespace(
            Frame=lambda *parts: parts, Transformation=SimpleNamespace(from_matrix=np.array)
        ),
        "compas_dem__analysis__resolve": SimpleNamespace(
            resolve_centroidal_displacements=lambda _: prescribed,
            resolve_centroidal_loads=lambda *_: {
                "stone": {"force": [push * WEIGHT, 0, 0], "moment": [0, 0, 0]},
                "ground": {"force": [9, 9, 9], "moment": [0, 0, 0]},
            },
        ),
        "compas_dem__problem__results": SimpleNamespace(Results=lambda **ids: Results(metadata={}, **ids)),
        "compas_dem__interactions": SimpleNamespace(FrictionContact=lambda **own: SimpleNamespace(polygon=None, **own)),
    }


@pytest.mark.parametrize(
    ("law", "option", "friction", "outcome"),
    [
        (None, None, 0.7, "stable"),
        (SimpleNamespace(mu=0.2), None, 0.2, "unstable"),
        (SimpleNamespace(mu=0.2), 0.3, 0.3, "stable"),
    ],
)
def test_a_problem_brings_its_loads_and_friction_and_gets_results(monkeypatch, law, option, friction, outcome):
    prescribed = []
    stand_ins(monkeypatch, **compas_dem(0.25, prescribed))
    options = {} if option is None else {"friction": option}
    found = solve(problem(law), density=1.0, gravity=DOWN, **options)
    assert found.metadata["mu"] == friction
    assert found.metadata["verdict"]["outcome"] == outcome
    assert found.nodes["ground"] == pytest.approx(np.eye(4))
    if outcome == "stable":
        assert found.edges["resultant_global"] == pytest.approx([-0.25 * WEIGHT, 0, WEIGHT], abs=1e-6)
        assert found.edges["face_contact"] is True
    prescribed.append("the ground sinks")
    with pytest.raises(InputError, match=r"the problem prescribes displacements; blockstat\.settle"):
        solve(problem(law))


@pytest.mark.parametrize("order", [1, -1])
def test_of_two_joints_between_two_blocks_the_one_that_carries_more_is_the_result(monkeypatch, order):
    stand_ins(monkeypatch, **compas_dem(0.4))
    asked = problem()
    halves = [[[x, 0, 0], [x + 0.5, 0, 0], [x + 0.5, 1, 0], [x, 1, 0]] for x in (0.0, 0.5)]
    joints = [SimpleNamespace(points=points, frame=UP, size=0.5, forces=None) for points in halves]
    asked.model.graph.joints["ground", "stone"]["contacts"] = joints[::order]
    found = solve(asked, density=1.0, gravity=DOWN)
    # The resultant is at x = 0.5 + 0.4, so the right half carries four fifths of the weight at least.
    assert found.edges["contact_points"] == halves[1]
    assert found.edges["force_magnitude"] >= 0.8 * WEIGHT


def test_results_hold_the_joints_that_were_found_where_the_model_has_none(monkeypatch):
    stand_ins(monkeypatch, **compas_dem(0.25))
    asked = problem()
    del asked.model.graph.joints["ground", "stone"]
    found = solve(asked, density=1.0, gravity=DOWN)
    assert found.edges["resultant_local"][2] == pytest.approx(WEIGHT)
    assert asked.model.graph.edges() == []


def test_a_recorded_sheet_holds_its_neighbours_apart(recwarn):
    # Found alone, the two cubes would be a joint 2 mm open.
    blocks = {
        "bottom": Mesh(box((0, 0, 0), (1, 1, 1)), is_support=True),
        "sheet": Mesh(box((0, 0, 1), (1, 1, 1.002))),
        "top": Mesh(box((0, 0, 1.002), (1, 1, 2.002))),
    }
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    joints = [
        SimpleNamespace(points=[[x, y, z] for x, y in ring], frame=UP, size=1.0, forces=None) for z in (1.0, 1.002)
    ]
    thing = assembled(*blocks, bottom_sheet=joints[:1], sheet_top=joints[1:])
    thing.node_block = blocks.get
    assert solve(thing, density=1.0, gravity=DOWN).attributes["verdict"]["outcome"] == "stable"
    assert not [w for w in recwarn if "recorded joint" in str(w.message)]


def test_no_density_at_all_is_refused():
    with pytest.raises(InputError, match="density"):
        solve(assembled(ground_stone=[joint()]), density=0, gravity=DOWN)
