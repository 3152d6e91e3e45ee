"""Prismatic scenes solved in their plane against the same scenes solved in space."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import Block, acceleration, thrust_range
from blockstat.analysis.problem import pose
from blockstat.analysis.thrust import extreme, standing
from blockstat.certificate.check import balance, check
from blockstat.program.conic import conic_program
from blockstat.solve.dispatch import solve
from blockstat.solve.penalty import solve_penalty
from evidence.scenes.small import FERRIS, SCENES, arch, assembly, box, ferris_wall, running_bond


def program_of(asm, **options):
    problem = pose(
        asm, **({"friction": None, "gravity": None, "loads": None, "gap": 1e-2, "interfaces": None} | options)
    )
    return problem, problem.program


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_energy_and_a_valid_answer_in_space(scene):
    _, make, options = scene
    _problem, program = program_of(make(), **options)
    assert program.plane is not None
    flat, solid = solve_penalty(program), solve_penalty(replace(program, plane=None))
    assert np.linalg.norm(flat.adhesion) == pytest.approx(np.linalg.norm(solid.adhesion), rel=1e-8, abs=1e-8)
    # The unfolded answer is judged by the certificate of the whole scene.
    proofs = [check(program, balance(program, raw.force), raw.twist) for raw in (flat, solid)]
    assert proofs[0].proves_stable == proofs[1].proves_stable
    assert proofs[0].proves_unstable == proofs[1].proves_unstable


def test_forces_fold_into_the_plane_and_back():
    _problem, program = program_of(arch(9, 0.3))
    plane = program.plane
    given = np.random.default_rng(1).normal(size=(2, len(plane.first)))
    force = plane.unfold_forces(*given, len(program.friction))
    np.testing.assert_allclose(plane.fold_forces(force), given, atol=1e-15)
    np.testing.assert_allclose(force[plane.first], force[plane.second])


@pytest.mark.parametrize(
    "make",
    [lambda: arch(20, 0.2), lambda: arch(20, 0.3, friction=0.35), lambda: arch(9, 0.3, friction=np.inf),
     lambda: running_bond(8, 4), lambda: ferris_wall(FERRIS["W3"][0])],
)  # fmt: skip
def test_same_limit_load_to_nine_digits(make):
    problem, program = program_of(make())
    load = problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    flat = solve(conic_program(program, -program.load, pinned=load))
    solid = solve(conic_program(replace(program, plane=None), -program.load, pinned=load))
    assert program.plane is not None
    assert flat.multiplier == pytest.approx(solid.multiplier, rel=1e-9, abs=1e-9)


def test_a_load_out_of_the_plane_is_solved_in_space():
    problem, program = program_of(running_bond(4, 3))
    across = problem.scaled(acceleration(problem.assembly, (0, 1, 0)))
    answer = solve(conic_program(program, -program.load, pinned=across))
    assert answer.multiplier == pytest.approx(0.2 / (4 * 0.175), rel=1e-7)


def turned(asm):
    """The scene with x and y exchanged, mirrored back to right-handed blocks."""
    blocks = [
        Block(asm.block_vertices(i)[:, [1, 0, 2]], [f[::-1] for f in asm.faces_of(i)], asm.names[i])
        for i in range(asm.n_blocks)
    ]
    return assembly(blocks, supports=[asm.names[i] for i in np.flatnonzero(asm.support)])


def test_the_axis_is_found_whichever_it_is():
    _, program = program_of(turned(arch(12, 0.2)))
    assert program.plane is not None
    _, unturned = program_of(arch(12, 0.2))
    assert np.linalg.norm(solve_penalty(program).force) == pytest.approx(
        np.linalg.norm(solve_penalty(unturned).force), rel=1e-6
    )


@pytest.mark.parametrize(
    "odd",
    [box((0.4, 0, 0.7), (0.8, 0.1, 0.875)), box((0.4, -0.1, 0.7), (0.8, 0.2, 0.875)),
     box((0.4, 0.05, 0.7), (0.8, 0.15, 0.8))],
    ids=["shorter", "longer", "inside"],
)  # fmt: skip
def test_one_block_that_sticks_out_makes_the_scene_solid(odd):
    wall = running_bond(4, 3)
    blocks = [Block(wall.block_vertices(i), wall.faces_of(i)) for i in range(wall.n_blocks)]
    assert program_of(assembly(blocks))[1].plane is not None
    assert program_of(assembly([*blocks, odd]))[1].plane is None


@pytest.mark.parametrize("direction", [(0, 1, 0), (1, 1, 0), (1, 0, 0)])
def test_a_thrust_out_of_the_plane_is_not_reduced_to_it(direction):
    asm = arch(12, 0.2)
    problem, inside = standing(asm, solver="auto", friction=None, gravity=None, loads=None, gap=1e-2, interfaces=None)
    found = thrust_range(asm, ["right"], direction)
    # The same scene in space: the ends of the thrust, from the program without its plane.
    solid = replace(problem, program=replace(problem.program, plane=None))
    unit = np.array(direction) / np.linalg.norm(direction)
    (columns,) = problem.eq.columns
    sign = (columns.pair[:, 1] == 1).astype(float) - (columns.pair[:, 0] == 1)
    row = (sign[:, None] * (columns.force @ unit)).reshape(-1)
    greatest, least = (extreme(solid, sign * row, inside, "auto").value for sign in (1, -1))
    assert (found.least, found.greatest) == pytest.approx((-least, greatest), rel=1e-6)
    assert problem.program.plane.mirrors(row) == (direction[1] == 0)
    if direction == (0, 1, 0):
        assert found.greatest == pytest.approx(-found.least, rel=1e-6)  # the arch has no front and no back
        assert found.greatest > 0.01
