"""COMPAS objects in memory: what `blockstat.compas` writes is in balance by COMPAS' own numbers, as compas_cra has it.

Run it with a Python that has both blockstat and the COMPAS packages:

    python3.11 -m venv compas && compas/bin/pip install . pytest hypothesis compas==2.15.1 compas_assembly==0.7.1 \
        compas_model==0.9.3 compas_dem==0.6.0 compas_cra==0.8.0
    compas/bin/python -m pytest tests/crosscheck/test_compas_objects.py
"""

import contextlib
import io
import re

import numpy as np
import pytest

pytest.importorskip("compas_cra")
pytest.importorskip("compas_dem")

import compas_cra.equilibrium as theirs
from compas.geometry import Box, Frame
from compas_assembly.datastructures import Block
from compas_cra.algorithms import assembly_interfaces_numpy
from compas_cra.datastructures import CRA_Assembly
from compas_dem.elements import Block as Element
from compas_dem.material import Stone
from compas_dem.models import BlockModel
from compas_dem.problem import Problem
from compas_dem.templates import ArchTemplate

import blockstat
import blockstat.compas as ours
import compas
from blockstat import InputError, InputWarning

G = 9.81


def tower(shift=0.25):
    """Ground, a cube and half a cube that stands out by so much: it falls beyond 0.5."""
    made = CRA_Assembly()
    for node, (size, centre) in enumerate(
        [((4, 4, 1), (0, 0, -0.5)), ((1, 1, 1), (0, 0, 0.5)), ((1, 1, 0.5), (shift, 0, 1.25))]
    ):
        made.add_block(Block.from_shape(Box(*size, frame=Frame(centre, [1, 0, 0], [0, 1, 0]))), node=node)
    made.set_boundary_conditions([0])
    return made


def with_joints(made):
    assembly_interfaces_numpy(made)
    return made


def joints(made):
    return [(edge, joint) for edge in made.graph.edges() for joint in made.graph.edge_attribute(edge, "interfaces")]


def on_blocks(made):
    """Forces and moments about the centre of each block, by the convention of compas_cra."""
    net = {node: np.zeros(6) for node in made.graph.nodes()}
    for (u, v), joint in joints(made):
        axes = np.array([list(joint.frame.zaxis), list(joint.frame.xaxis), list(joint.frame.yaxis)])
        for point, force in zip(joint.points, joint.forces, strict=True):
            whole = np.array([force["c_np"] - force["c_nn"], force["c_u"], force["c_v"]]) @ axes
            for node, sign in ((v, 1.0), (u, -1.0)):
                arm = np.array(list(point)) - np.array(made.node_block(node).center())
                net[node] += sign * np.concatenate([whole, np.cross(arm, whole)])
    return net


def least(made):
    """Sum of residual tension."""
    return sum(force["c_nn"] for _, joint in joints(made) for force in joint.forces)


@pytest.mark.parametrize("shift", [0.25, 0.6])
@pytest.mark.parametrize("solver", ["rbe_solve", "cra_penalty_solve"])
def test_a_drop_in_has_the_forces_of_compas_cra(solver, shift):
    one, two = with_joints(tower(shift)), with_joints(tower(shift))
    assert getattr(ours, solver)(one, mu=0.7, density=2.0) is one
    getattr(theirs, solver)(two, mu=0.7, density=2.0)
    weights = {1: 2.0, 2: 1.0}
    for node, weight in weights.items():
        for made in (one, two):
            np.testing.assert_allclose(on_blocks(made)[node], [0, 0, weight, 0, 0, 0], atol=1e-6)
    assert least(one) == pytest.approx(least(two), abs=1e-6)
    # Half a cube of weight 1 whose centre is 0.1 beyond the edge, on points 0.4 apart: 1 x 0.1 / 0.4 pulls at the back.
    assert least(one) == pytest.approx(0.25 if shift == 0.6 else 0.0, abs=1e-9)
    assert one.attributes["verdict"]["outcome"] == ("unstable" if shift == 0.6 else "stable")


def test_signatures_are_those_of_compas_cra():
    from inspect import signature

    for name in ("rbe_solve", "cra_penalty_solve"):
        own, other = (signature(getattr(place, name)).parameters for place in (ours, theirs))
        assert [(key, own[key].default) for key in own] == [(key, other[key].default) for key in other]


def test_displacements_open_the_joint_that_tips_by_d_bnd_at_most():
    made = ours.cra_penalty_solve(with_joints(tower(0.6)), d_bnd=1e-3)
    tip = np.array(made.graph.node_attribute(2, "displacement"))
    np.testing.assert_allclose(made.graph.node_attribute(1, "displacement"), np.zeros(6), atol=1e-9)
    points = [np.array(list(p)) for (edge, joint) in joints(made) if 2 in edge for p in joint.points]
    centre = np.array(made.node_block(2).center())
    lift = [(tip[:3] + np.cross(tip[3:], p - centre))[2] for p in points]
    assert max(lift) == pytest.approx(1e-3)
    assert min(lift) == pytest.approx(0.0, abs=1e-9)
    assert tip[4] > 0  # about y, towards +x


def test_joints_are_found_where_there_are_none_and_travel_in_json(tmp_path):
    made = ours.solve(tower(), density=2000.0)
    again = compas.json_loads(compas.json_dumps(made))
    for own in (made, again):
        np.testing.assert_allclose(on_blocks(own)[2], [0, 0, 1000 * G, 0, 0, 0], atol=20)  # 9.80665
        assert own.attributes["verdict"]["outcome"] == "stable"
    bare = ours.from_compas(tower(), density=2000.0)
    path = blockstat.write_verdict(blockstat.assess(bare), tmp_path / "tower.json")
    np.testing.assert_allclose(on_blocks(compas.json_load(path))[2], on_blocks(made)[2], rtol=1e-9, atol=1e-6)


def test_blocks_that_touch_without_a_joint_are_named():
    made = with_joints(tower())
    for edge in list(made.graph.edges()):
        if 2 in edge:
            made.graph.delete_edge(edge)
    with pytest.warns(InputWarning, match=r'touch without a recorded joint, which joints="found" would add'):
        ours.solve(made)
    assert made.attributes["verdict"]["outcome"] == "unstable"
    assert ours.solve(made, joints="found").attributes["verdict"]["outcome"] == "stable"


def test_a_frame_that_points_back_is_refused():
    made = with_joints(tower())
    (u, v), joint = joints(made)[0]
    made.graph.edge_attribute((u, v), "interfaces")[0]._frame = Frame(
        joint.frame.point, joint.frame.yaxis, joint.frame.xaxis
    )
    with pytest.raises(InputError, match=f"edge \\({u}, {v}\\) points from {v} to {u}"):
        ours.solve(made)


def model(shift=0.25):
    made, stone = BlockModel(name="tower"), Stone.from_predefined_material("LIMESTONE")
    made.add_material(stone)
    for node in (nodes := tower(shift)).graph.nodes():
        made.add_element(Element.from_mesh(nodes.node_block(node)), material=stone)
    made.add_support(0)
    return made, stone.density


@pytest.mark.parametrize("recorded", [True, False])
def test_a_model_has_forces_at_its_contacts(recorded):
    made, density = model()
    if recorded:
        made.compute_contacts()
    assert ours.solve(made, gravity=(0, 0, -G)) is made
    again = compas.json_loads(compas.json_dumps(made))
    for own in (made, again):
        assert own.graph.attributes["verdict"]["outcome"] == "stable"
        lengths = sorted(contact.resultantforce[0].length for contact in own.contacts())
        np.testing.assert_allclose(lengths, [0.5 * density * G, 1.5 * density * G], rtol=1e-9)
        assert all(contact.resultantpoint[0] > 0 for contact in own.contacts())  # towards the block that stands out


@pytest.mark.parametrize(("push", "outcome"), [(0.45, "stable"), (0.55, "unstable")])
def test_a_problem_brings_loads_and_friction_and_gets_results(push, outcome):
    """Coulomb: the upper block slides when pushed by more than mu times its weight; mu is 0.5."""
    made, density = model(0.0)
    weight = 0.5 * density * G
    problem = Problem(made)
    problem.set_contact_model("MohrCoulomb", mu=0.5)
    live = problem.add_boundary_condition("live")
    problem.add_point_load_at_centroid(2, [push * weight, 0, 0], boundary_condition=live)
    results = compas.json_loads(compas.json_dumps(ours.solve(problem, gravity=(0, 0, -G), motion=0.2)))
    assert (results.metadata["verdict"]["outcome"], results.metadata["mu"]) == (outcome, 0.5)
    np.testing.assert_allclose(results.resultant_global((1, 2)), [-push * weight, 0, weight], rtol=1e-6, atol=1e-3)
    moved = np.array(results.displacement(2))
    if outcome == "stable":
        assert not moved.any()
    else:
        assert moved[2] == pytest.approx(0.5 * moved[0])  # dilatant: it rises by mu times its slip
        assert np.linalg.norm(moved) == pytest.approx(0.2)
    assert made.graph.node_attribute(2, "displacement") is None  # the model stays as it is


def test_a_model_in_groups_comes_back_with_forces_on_its_blocks(tmp_path, root):
    chapel = blockstat.build(blockstat.load_scene(root / "examples" / "chapel.toml"))
    verdict = blockstat.assess(chapel)
    made = compas.json_load(blockstat.write_verdict(verdict, tmp_path / "chapel.json", format="compas-model"))
    weight = {name: mass * 9.80665 for name, mass in zip(chapel.names, chapel.mass, strict=True)}
    up = dict.fromkeys(weight, 0.0)
    for u, v in made.graph.edges():
        for contact in made.graph.edge_attribute((u, v), "contacts"):
            axes = contact.frame
            for f in contact.forces:
                own = axes.zaxis * (f["c_np"] - f["c_nn"]) + axes.xaxis * f["c_u"] + axes.yaxis * f["c_v"]
                up[made.graph.node_element(v).name] += own[2]
                up[made.graph.node_element(u).name] -= own[2]
    free = [chapel.names[block] for block in chapel.free]
    np.testing.assert_allclose([up[name] for name in free], [weight[name] for name in free], rtol=1e-3)
    ours.solve(made)
    assert made.graph.attributes["verdict"]["outcome"] == verdict.outcome.word


def test_an_arch_of_a_plain_model():
    made = compas.json_loads(compas.json_dumps(_plain_arch()))
    made.compute_contacts()
    ours.solve(made, flow="coulomb")
    assert made.graph.attributes["verdict"]["outcome"] == "stable"
    assert {type(contact).__name__ for contact in made.contacts()} == {"FrictionContact"}
    crown = made.graph.node_attribute(9, "displacement")
    assert crown[2] < 0  # it sinks as its joints close


def _plain_arch():
    from compas_model.models import Model

    made = Model(name="arch")
    for number, mesh in enumerate(ArchTemplate(rise=1, span=2, thickness=0.3, depth=0.5, n=20).blocks()):
        made.add_element(Element.from_mesh(mesh, is_support=number in (0, 19)))
    return made


def test_other_objects_are_refused_with_their_type():
    with pytest.raises(
        InputError, match="a Box is neither an Assembly of compas_assembly, a Model of compas_model nor"
    ):
        ours.solve(Box(1))
    bare = tower()
    bare.unset_boundary_conditions()
    with pytest.raises(InputError, match="does not say which blocks are supports"):
        ours.solve(bare)
    with pytest.raises(InputError, match="joints is 'all'; it must be one of: recorded, found"):
        ours.solve(tower(), joints="all")
    made, _ = model()
    problem = Problem(made)
    problem.add_displacement(0, [0, 0, -0.1], boundary_condition=problem.add_boundary_condition("sinks"))
    with pytest.raises(InputError, match="the problem prescribes displacements; blockstat"):
        ours.solve(problem)


def test_the_guide_prints_what_it_shows(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page, scope = (root / "docs" / "howto" / "compas.md").read_text(), {}
    blocks = re.findall(r"```py\n(.*?)```(?:\s+```output\n(.*?)```)?", page, re.DOTALL)
    assert blocks
    for code, shown in blocks:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(code, "compas.md", "exec"), scope)
        assert printed.getvalue() == shown
