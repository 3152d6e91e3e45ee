"""Options are given by name, so that their order may change and a call says what it asks for."""

import inspect
import json

import numpy as np
import pytest

import blockstat
import dynsim
from blockstat import Assembly, InputError, assess, find_interfaces, glued
from blockstat.analysis import assess as assess_room
from blockstat.analysis import coulomb, decision, limit_load, problem, reserve, thrust, verdict
from blockstat.analysis.tilt_friction import friction, tilt
from blockstat.io import files, folder, mesh, native, obj, parts, surface
from blockstat.io.compas import read as compas_read
from blockstat.io.compas import write as compas_write
from blockstat.loading import faces, ground, on_faces
from blockstat.solve.penalty import solve_penalty
from blockstat.studies import two_loads
from evidence.scenes.small import assembly, box, stack

POSE = {"friction": None, "gravity": None, "loads": None, "gap": 0.01, "interfaces": None}


def posed():
    return problem.pose(stack(1), **POSE)


def written(tmp_path):
    asm = assembly([box((0, 0, 0), (1, 1, 1), name="a")])
    for name in ("a.json", "a.obj", "a.stl", "folder"):
        files.write(asm, tmp_path / name)
    files.write(asm, tmp_path / "c.json", format="compas-model")
    mesh.mesh_parts(tmp_path / "a.obj")
    folder.folder_parts(tmp_path / "folder", supports=[0])
    native.native_parts(json.loads((tmp_path / "a.json").read_text()), "a")
    compas_read.compas_parts(json.loads((tmp_path / "c.json").read_text()), "c")
    surface.read_surface(tmp_path / "a.obj")
    parts.doubts(asm)


def solved():
    found = posed()
    answer = decision.decide(found.program, solve_penalty(found.program))
    reserve.neutral_blocks(found, answer)
    decision.solve_margin_locally(found.program)
    coulomb.coulomb_state(found.program)


def pushed():
    asm = stack(1)
    limit_load.limit_load(asm, (1, 0, 0)).joints()
    thrust.thrust_range(asm, ["ground"], (0, 0, -1))
    friction.friction_limit(asm)
    verdict.motion_words(asm, find_interfaces(asm), np.zeros((2, 6)))


def loaded():
    asm = stack(1)
    on_faces.body_load(asm, (1, 0, 0))
    ground.fill_load(asm, 2.0, 1.0)
    faces.free_faces(asm, asm.free)
    blockstat.acceleration(asm, (1, 0, 0))
    glued(asm, 1.0)


def simulated():
    asm = stack(1)
    dynsim.verify(asm, settings=dynsim.Settings(end=0.5))
    still, upright = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    dynsim.find_cracks(asm, (still, upright), (still, upright))


ROOMS = {
    "files": (
        written,
        [files.write, files.read_parts, mesh.mesh_parts, mesh.write_mesh, folder.folder_parts, native.native_parts,
         native.write_json, compas_read.compas_parts, compas_write.write_compas, obj.write_obj, surface.read_surface,
         parts.doubts],
    ),
    "programs": (
        solved,
        [assess, assess_room.judged, problem.pose, decision.decide, decision.solve_margin_locally,
         decision.upper_bound, decision.proven_bounds, decision.narrowed, reserve.neutral_blocks,
         coulomb.coulomb_state, coulomb.settling_share, coulomb.multiplier_brackets],
    ),
    "limits": (
        pushed,
        [limit_load.limit_load, limit_load.bracket, limit_load.LimitLoad.joints, thrust.thrust_range,
         two_loads.load_domain, thrust.standing, tilt.tilt_limit, friction.friction_limit,
         verdict.motion_words, verdict.first_words],
    ),
    "loads": (
        loaded,
        [on_faces.body_load, on_faces.surface_load, on_faces.facing, on_faces.patch_load, on_faces.line_load,
         ground.fluid_pressure, ground.fill_load, ground.dispersed_load, faces.free_faces,
         blockstat.acceleration, glued, Assembly.from_blocks],
    ),
    "runs": (simulated, [dynsim.verify, dynsim.simulate, dynsim.limit, dynsim.sequence, dynsim.find_cracks]),
}  # fmt: skip


@pytest.mark.parametrize("room", ROOMS)
def test_options_are_given_by_name_and_what_comes_first_may_be(room, tmp_path):
    use, functions = ROOMS[room]
    use(tmp_path) if room == "files" else use()
    for function in functions:
        kinds = [parameter.kind for parameter in inspect.signature(function).parameters.values()]
        assert inspect.Parameter.KEYWORD_ONLY in kinds, function.__name__
        assert inspect.Parameter.POSITIONAL_ONLY not in kinds, function.__name__


def test_a_limit_in_bullet_refuses_an_option_by_place():
    with pytest.raises(TypeError):
        dynsim.limit(stack(1), (1, 0, 0), None)
    with pytest.raises(InputError, match="unknown option"):
        dynsim.limit(stack(1), (1, 0, 0), wdth=0.1)
