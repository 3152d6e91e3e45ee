"""Problems and analyses of compas_dem in files, written by hand: friction, supports and loads against hand statics."""

import json

import numpy as np
import pytest

from blockstat import InputError, InputWarning, Outcome, assess, limit_load, load_case, read
from blockstat.io.compas.objects import ANALYSIS, BLOCK_MODEL, MESH, PROBLEM

FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
TOP = 1  #: of FACES
DENSITY, G = 2000.0, 10.0
WEIGHT = DENSITY * 2 * G  #: of the stone of 1 x 1 x 2 m


def mesh(low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    corners = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    vertex = {str(i): dict(zip("xyz", map(float, own), strict=True)) for i, own in enumerate(corners)}
    return {"dtype": MESH, "data": {"vertex": vertex, "face": {str(i): own for i, own in enumerate(FACES)}}}


def made(dtype, data, **more):
    return {"dtype": dtype, "data": data, **more}


def model(marked=True):
    """A stone of 1 x 1 x 2 m on a support, at the nodes 7 and 3 of the graph."""
    stones = {"u": ("ground", mesh((-5, -5, -1), (5, 5, 0)), marked), "s": ("stone", mesh((0, 0, 0), (1, 1, 2)), False)}
    elements = {
        guid: made("compas_dem.elements/Block",
                   {"name": name, "geometry": solid, "is_support": held, "material": "m"})
        for guid, (name, solid, held) in stones.items()
    }  # fmt: skip
    return made(BLOCK_MODEL, {
        "elements": elements, "materials": {"m": made("compas_dem.material/Stone", {"density": DENSITY})},
        "tree": {"root": {"children": [{"element": guid} for guid in elements]}},
        "graph": {"node": {"7": {"element": "u"}, "3": {"element": "s"}}},
    })  # fmt: skip


def contacts(**law):
    own = made("compas_dem.interactions/MohrCoulomb", {"phi": None, "mu": None, "c": None, "t_c": None, **law})
    return made("compas_dem.interactions/ContactProperties", {"contact_model": own, "joint_model": None})


def old_problem(marked=True, law=None, **conditions):
    """As version 0.5 writes it: one set of boundary conditions, whose entries are tables."""
    kept = {"gravity": False, "g": G, "body_forces": [], "point_loads": [], "surface_loads": [], "displacements": []}
    own = made("compas_dem.problem/BoundaryConditions", {**kept, **conditions}, name="Snow")
    held = {"model": model(marked), "boundary_conditions": own, "contact_properties": contacts(**(law or {"mu": 0.5}))}
    return made(PROBLEM, held, name="Problem")


def analysis(*groups, mu=(0.5,)):
    """As version 0.6 writes it: several sets, whose entries are objects, in problems without their model."""
    problems = [
        made(PROBLEM, {"name": f"P{i}", "model_id": "x", "boundary_conditions": list(groups), "solver": None,
                       "contact_properties": contacts(mu=own)})
        for i, own in enumerate(mu)
    ]  # fmt: skip
    return made(ANALYSIS, {"name": "tower", "model": model(), "problems": problems})


def group(name, **entries):
    kinds = {"body_forces": "BodyForce", "point_loads": "PointLoad", "surface_loads": "SurfaceLoad",
             "displacements": "Translation"}  # fmt: skip
    data = {key: [made(f"compas_dem.problem/{kind}", own) for own in entries.get(key, [])]
            for key, kind in kinds.items()}  # fmt: skip
    return made("compas_dem.problem/BoundaryConditionGroup", {"name": name, "g": G, **data})


def stored(tmp_path, data):
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(data))
    return path


def stone_of(assembly, case):
    return load_case(assembly, case).loads[list(assembly.names).index("stone")]


@pytest.mark.parametrize("law", [{"mu": 0.3}, {"phi": np.degrees(np.arctan(0.3))}])
def test_friction_and_gravity_are_those_of_the_problem(tmp_path, law):
    """Under a horizontal push at half height the stone slides at .3 of its weight; it would tip at .5."""
    assembly = read(stored(tmp_path, old_problem(law=law)))
    assert assembly.friction == pytest.approx(0.3)
    assert assembly.free_weight == pytest.approx(WEIGHT)
    assert limit_load(assembly, (1, 0, 0)).lower == pytest.approx(0.3, rel=1e-4)
    assert not {"loads", "cases"} & set(assembly.metadata)


def test_blocks_whose_six_displacements_are_zero_are_supports(tmp_path):
    fixed = {"block_index": 7, "translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0]}
    assembly = read(stored(tmp_path, old_problem(marked=False, displacements=[fixed])))
    assert [assembly.names[i] for i in np.flatnonzero(assembly.support)] == ["ground"]
    assert assess(assembly).outcome is Outcome.STABLE


def test_displacements_that_are_prescribed_are_told_and_not_applied(tmp_path):
    moved = {"block_index": 7, "translation": [0.0, 0.0, -0.02], "rotation": [0.0, 0.0, 0.0]}
    with pytest.warns(InputWarning, match=r"not applied.*settle.*block_index 7"):
        assembly = read(stored(tmp_path, old_problem(marked=False, displacements=[moved])))
    assert assembly.support.sum() == 1


def test_a_block_that_is_held_in_part_is_refused(tmp_path):
    part = {"block_index": 3, "translation": [0.0, None, None], "rotation": None}
    with pytest.raises(InputError, match=r"some directions only.*block_index 3"):
        read(stored(tmp_path, old_problem(displacements=[part])))


def test_loads_of_an_older_problem_are_one_case(tmp_path):
    """A force at a corner of the top, one at the centroid, a pressure on half of the top, and a body force."""
    square = made("compas.geometry/Polygon", {"points": [[0, 0, 2], [0.5, 0, 2], [0.5, 1, 2], [0, 1, 2]]})
    problem = old_problem(
        point_loads=[
            {"block_index": 3, "force": [0, 0, -300], "moment": None, "point": [1, 1, 2], "loading_type": "ramp"},
            {"block_index": 3, "force": [40, 0, 0], "moment": None, "point": None, "loading_type": "ramp"},
            {"block_index": 7, "force": [1, 1, 1], "moment": [1, 0, 0], "point": None, "loading_type": "ramp"},
        ],
        surface_loads=[{"block_index": 3, "polygon": square, "magnitude": -100.0, "direction": None}],
        body_forces=[[0.0, 2.0, 0.0]],
    )
    assembly = read(stored(tmp_path, problem))
    # The normal of the square points up, so a pressure of -100 N/m2 presses: 50 N at x = .25, .25 beside the centroid.
    expected = [40, 2 * DENSITY * 2, -300 - 50, -300 * 0.5, 300 * 0.5 - 50 * 0.25, 0]
    assert stone_of(assembly, "Snow") == pytest.approx(expected)


def test_each_set_of_a_newer_analysis_is_a_case(tmp_path):
    live = group(
        "Live", point_loads=[{"block_index": 3, "force": [0, 0, -500], "point": [0.5, 0.5, 2], "moment": None}]
    )
    wind = group("Wind", surface_loads=[{"block_index": 3, "face_index": 5, "load": [250, 0, 0]}],
                 body_forces=[{"acceleration": [1, 0, 0]}])  # fmt: skip
    assembly = read(stored(tmp_path, analysis(live, wind)))
    assert list(assembly.metadata["cases"]) == ["Live", "Wind"]
    assert assembly.friction == 0.5
    assert stone_of(assembly, "Live") == pytest.approx([0, 0, -500, 0, 0, 0])
    assert stone_of(assembly, "Wind") == pytest.approx([250 * 2 + DENSITY * 2, 0, 0, 0, 0, 0])


def test_sets_of_one_name_are_all_kept(tmp_path):
    push = group("Live", point_loads=[{"block_index": 3, "force": [9, 0, 0], "point": None, "moment": None}])
    assembly = read(stored(tmp_path, analysis(push, push, mu=(0.5, 0.5))))
    assert list(assembly.metadata["cases"]) == ["P0.Live", "P0.Live 2", "P1.Live", "P1.Live 2"]
    assert stone_of(assembly, "P1.Live 2") == pytest.approx([9, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (analysis(mu=(0.5, 0.6)), r"differ in friction \(0\.[56], 0\.[56]\)"),
        (made(PROBLEM, {"name": "P", "model_id": "x", "contact_properties": None}), "does not hold its model"),
        (old_problem(point_loads=[{"block_index": 4, "force": [0, 0, 1]}]),
         r"Snow point load 0: block_index: no block .4.*7, 3"),
        (old_problem(point_loads=[{"block_index": 3, "force": [0, 0, 1], "moment": [0, 1, 0]}]), "moment.*is not read"),
        (old_problem(point_loads=[{"block_index": 3, "force": [0, 0]}]), "Snow point load 0: force"),
        (analysis(group("Live", surface_loads=[{"block_index": 3, "face_index": 6, "load": [1, 0, 0]}])),
         'face_index of a face of "stone"'),
    ],
)  # fmt: skip
def test_what_cannot_be_read_in_full_is_refused(tmp_path, data, words):
    with pytest.raises(InputError, match=words):
        read(stored(tmp_path, data))


def test_cohesion_is_told_and_not_applied(tmp_path):
    with pytest.warns(InputWarning, match="cohesion and tension .* not applied"):
        read(stored(tmp_path, old_problem(law={"mu": 0.5, "c": 1e5})))


def test_models_that_list_their_elements_and_lists_of_meshes_are_read(tmp_path):
    """As versions before 0.5 wrote models, with the mesh as the shape of a block and materials beside the elements."""
    new = model()["data"]
    listed = [made("compas_dem.elements/BlockElement", {"name": own["data"]["name"], "shape": own["data"]["geometry"],
                   "is_support": own["data"]["is_support"]}, guid=guid)
              for guid, own in new["elements"].items()]  # fmt: skip
    materials = [{**new["materials"]["m"], "guid": "m"}]
    old = {**new, "elements": listed, "materials": materials, "element_material": {"s": "m", "u": "m"}}
    assembly = read(stored(tmp_path, made(BLOCK_MODEL, old)))
    assert list(assembly.names) == ["ground", "stone"]
    assert assembly.free_weight == pytest.approx(DENSITY * 2 * 9.81)
    meshes = [{"data": own["data"]["shape"]["data"]} for own in listed]
    again = read(stored(tmp_path, meshes), supports=[0])
    np.testing.assert_array_equal(again.vertices, assembly.vertices)
    nested = read(stored(tmp_path, [[meshes[0]], [[meshes[1]]]]), supports=[0])
    np.testing.assert_array_equal(nested.vertices, assembly.vertices)
    with pytest.raises(InputError, match="mesh 0"):
        read(stored(tmp_path, [{"data": {}}]), supports=[0])
    with pytest.raises(InputError, match=r"mesh 1\.0"):
        read(stored(tmp_path, [[meshes[0]], [{"data": {}}]]), supports=[0])
