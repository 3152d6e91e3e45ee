"""Statics and Bullet see the same closed joints: gaps within the joint tolerance do not decide a verdict."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import Assembly, Block, InputError, assess, find_interfaces, overlaps, repair, write
from blockstat.model import arch, assemble
from dynsim import Settings, compare, simulate, verify
from dynsim.cli.commands import app
from dynsim.judge.closing import closed_scene
from evidence.scenes.edges import two_ridges
from evidence.scenes.sized import vault
from evidence.scenes.small import assembly, box, pitted, prism

GROUND = box((-5, -5, -1), (5, 5, 0), name="ground")


def stack(n: int, gap: float, height: float = 0.3):
    """Blocks on top of each other, each joint open by so much."""
    low = [(height + gap) * k + gap for k in range(n)]
    return assembly([GROUND, *(box((0, 0, z), (0.3, 0.3, z + height)) for z in low)])


def wall(bed: float, head: float, courses: int = 8, across: int = 4):
    """Running bond with open beds and heads."""
    bricks = [
        box((x, 0, z), (x + 0.3, 0.15, z + 0.1))
        for k in range(courses)
        for z in [k * (0.1 + bed) + bed]
        for x in np.arange(across) * (0.3 + head) - 0.15 * (k % 2)
    ]
    return assembly([GROUND, *bricks])


def ring(gap: float):
    """An arch of voussoirs that are smaller on all sides, so that its joints open by about so much."""
    scene = assemble(arch(span=2.0, thickness=0.2, depth=0.5, voussoirs=15, springers=0.3), friction=0.7)
    vertices = scene.vertices.copy()
    for block in scene.free:
        own = slice(*scene.vertex_start[block : block + 2])
        local = vertices[own] - scene.centroid[block]
        thinnest = np.ptp(local @ np.linalg.svd(local)[2].T, axis=0).min()
        vertices[own] -= gap / thinnest * local
    return scene.with_(vertices=vertices)


def short_of_its_ridges(rise=6e-3):
    """A box above the two ridges it is to lie on: no faces that could be brought into one plane."""
    scene = two_ridges(0.0, 0.8, (1, 0)).scene
    vertices = scene.vertices.copy()
    vertices[scene.vertex_start[2] :] += (0, 0, rise)
    return scene.with_(vertices=vertices)


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(stack(12, 2e-3), id="stack, open"),
        pytest.param(stack(12, -2e-3), id="stack, overlapping"),
        pytest.param(wall(1e-3, 1e-3), id="wall, beds and heads open"),
        pytest.param(wall(-1e-3, 1e-3), id="wall, beds overlapping, heads open"),
        pytest.param(ring(1e-3), id="arch, 1 mm"),
        pytest.param(ring(2e-3), id="arch, 2 mm"),
        pytest.param(ring(-2e-3), id="arch, overlapping"),
    ],
)
def test_what_statics_prove_stable_across_gaps_stands_in_bullet_without_settling_by_them(scene):
    gap = find_interfaces(scene).gap.max()
    dynamic = verify(scene)
    assert (assess(scene).outcome.word, dynamic.outcome.word) == ("stable", "stands")
    assert dynamic.settling < 0.1 * gap
    # Nothing adds up from course to course: a corner moves by a gap at most in each of three joints.
    assert 0.4 * gap < dynamic.corners_moved < np.sqrt(3) * gap
    assert any("closed for Bullet by moving corners" in text for text in dynamic.warnings)


@pytest.mark.slow
def test_sixty_courses_with_gaps_of_two_millimetres_stand():
    row = compare(stack(60, 2e-3, height=0.1), jobs=1)[0]
    assert (row.static, row.dynamic, row.cause) == ("stable", "stands", "")


def test_closing_does_not_hold_what_statics_prove_to_fall():
    # A wall of 0.3 m x 0.15 m bricks under gravity tilted by 40 degrees across it, with open beds.
    scene = wall(1e-3, 0.0).with_(gravity=(0.0, 9.81 * np.sin(0.7), -9.81 * np.cos(0.7)))
    assert (assess(scene).outcome.word, verify(scene).outcome.word) == ("unstable", "falls")


def test_closed_blocks_keep_their_masses_and_statics_find_the_joints_where_they_were():
    scene = wall(1e-3, 1e-3)
    before = find_interfaces(scene)
    closed = closed_scene(scene, before)
    after = find_interfaces(closed.assembly, gap=1e-6)
    assert closed.assembly.mass == pytest.approx(scene.mass, rel=1e-12)
    assert {*map(tuple, before.pair.tolist())} == {*map(tuple, after.pair.tolist())}
    assert (closed.closed, closed.left) == (before.n_interfaces, 0)


def test_the_blocks_are_those_of_repair():
    scene = stack(3, 2e-3)
    closed = closed_scene(scene, find_interfaces(scene))
    assert np.array_equal(closed.assembly.vertices, repair(scene)[0].vertices)


def test_a_scene_with_closed_joints_is_simulated_as_it_is():
    for scene in (stack(3, 0.0), stack(3, 1e-7), ring(0.0)):
        found = find_interfaces(scene)
        closed = closed_scene(scene, found)
        assert closed.assembly is scene
        assert not closed.warnings


def test_a_run_closes_joints_as_a_verdict_does():
    run = simulate(stack(4, 2e-3), settings=Settings(end=0.5))
    assert np.abs(run.displacement).max() < 2e-4


def test_what_cannot_be_closed_is_refused_by_name_with_the_size_of_the_gap():
    scene = short_of_its_ridges()
    assert assess(scene).outcome.word == "stable"
    with pytest.raises(InputError, match=r'blocks "ridge0" and "box" do not meet .* off by 6 mm.*`blockstat repair`'):
        verify(scene)
    row = compare(scene, jobs=1)[0]
    assert row.dynamic is None
    assert "do not meet" in row.note


def test_a_block_that_hangs_on_joints_which_no_corner_can_close_is_not_held():
    # Ridges 40 mm below: joints to statics that were asked for such gaps, and none to a search with the default gap.
    scene = short_of_its_ridges(40e-3)
    with pytest.raises(
        InputError, match=r'"ridge0" and "box" do not meet .* by 40 mm.* nothing would hold "box"; draw'
    ):
        closed_scene(scene, find_interfaces(scene, gap=0.1))


def test_a_block_without_any_joint_falls_and_is_no_reason_to_refuse_the_others():
    scene = stack(3, 2e-3)
    blocks = [*(box(*np.sort(scene.block_vertices(k), axis=0)[[0, -1]]) for k in range(4)), box((2, 2, 2), (3, 3, 3))]
    loose = assembly(blocks)
    closed = closed_scene(loose, find_interfaces(loose))
    assert (closed.closed, closed.left) == (3, 0)


def test_what_a_chain_of_closed_joints_holds_is_simulated_as_drawn_and_said_to_be():
    # The same box with a post that holds it up: the ridges are 6 mm below, and cannot be closed.
    scene = short_of_its_ridges()
    post = box((-0.1, -0.3, -1), (0.1, 0.3, 6e-3), name="post")
    blocks = [*(scene.block_vertices(k) for k in range(3))]
    faces = [[f.tolist() for f in scene.faces_of(k)] for k in range(3)]
    built = [post, *(Block(v, f) for v, f in zip(blocks, faces, strict=True))]
    dynamic = verify(assembly(built, supports=[0, 1, 2], friction=0.8))
    assert dynamic.outcome.word == "stands"
    assert (dynamic.corners_moved, dynamic.misfit) == (0.0, pytest.approx(6e-3))
    assert "2 joints that statics count as closed were simulated as drawn" in dynamic.warnings[0]


def test_the_command_line_tells_the_largest_move(tmp_path):
    path = tmp_path / "stack.json"
    write(stack(6, 2e-3), path)
    answer = CliRunner().invoke(app, ["verify", str(path), "--json"])
    told = json.loads(answer.stdout)
    assert (answer.exit_code, told["verdict"]) == (0, "stands")
    assert told["corners_moved"] == pytest.approx(2e-3, rel=0.1)
    assert "moving corners by up to 2 mm" in told["warnings"][0]


def overlapping(depth, support=False):
    """Two cubes of 1 m on a ground, the upper one sunk into the lower one, or the lower one into the ground."""
    low = -depth if support else 0.0
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, low), (1, 1, low + 1), name="low")]
    top = low + 1 - (0.0 if support else depth)
    blocks += [box((0, 0, top), (1, 1, top + 1), name="high")]
    return Assembly.from_blocks(blocks, supports=["ground"])


@pytest.mark.parametrize("support", [False, True])
def test_deep_overlaps_are_cut_back_to_one_plane_and_masses_stay(support):
    given = overlapping(0.12, support)
    scene = closed_scene(given, find_interfaces(given))
    assert scene.assembly.mass == pytest.approx(given.mass)
    assert not len(overlaps(scene.assembly, gap=1e-6)[0])
    # Each loses half of the overlap, but a support none of it.
    cut = given.volume - scene.assembly.volume
    assert cut == pytest.approx([0, 0.12, 0] if support else [0, 0.06, 0.06])
    dynamic = verify(given)
    assert dynamic.outcome.word == "stands"
    assert dynamic.settling < 1e-3
    assert any("cut back by up to" in text for text in dynamic.warnings)


def test_an_overlap_that_would_make_another_block_of_one_is_refused_with_what_to_do():
    with pytest.raises(InputError, match=r'"low" and "high" .* would lose 300 mm of 1,000 mm: draw them'):
        verify(overlapping(0.6))


@pytest.mark.parametrize("seed", range(3))
def test_a_ring_with_corners_moved_by_thirty_millimetres_gets_a_verdict_that_says_what_was_cut(seed):
    drawn = assemble(arch(span=4.0, thickness=0.5, depth=1.0, voussoirs=13, springers=0.3), friction=0.7)
    move = np.random.default_rng(seed).uniform(-0.03, 0.03, drawn.vertices.shape)
    move[drawn.support[drawn.vertex_block]] = 0.0
    moved = drawn.with_(vertices=drawn.vertices + move)
    dynamic = verify(moved)
    assert any("cut back by up to" in text for text in dynamic.warnings)
    assert dynamic.settling < dynamic.brick_threshold
    assert 0.01 < dynamic.corners_moved < 0.06


def shaken_vault(shift, seed):
    """A vault of 60 voussoirs whose corners are moved at random by up to so much in each direction [m]."""
    drawn = vault(60)
    move = np.random.default_rng(seed).uniform(-shift, shift, drawn.vertices.shape)
    move[drawn.support[drawn.vertex_block]] = 0.0
    return drawn.with_(vertices=drawn.vertices + move)


@pytest.mark.parametrize("seed", range(3))
def test_a_vault_with_corners_moved_by_thirty_millimetres_becomes_blocks_that_do_not_overlap(seed):
    moved = shaken_vault(0.03, seed)
    scene = closed_scene(moved, find_interfaces(moved))
    assert any("cut back by up to" in text for text in scene.warnings)
    assert 0 < scene.moved <= 2 * np.sqrt(3) * 0.03  # two corners are apart by no more than both moved
    assert not len(overlaps(scene.assembly, gap=0.01)[0])


@pytest.mark.parametrize("seed", range(3))
def test_a_vault_with_corners_moved_by_ten_millimetres_is_refused_with_two_blocks_and_what_to_do(seed):
    moved = shaken_vault(0.01, seed)
    with pytest.raises(InputError, match=r'"vault\.\S+" and "vault\.\S+" do not meet .* draw them so that they touch'):
        closed_scene(moved, find_interfaces(moved))


@pytest.mark.slow
def test_a_vault_with_corners_moved_by_thirty_millimetres_gets_a_verdict():
    found = verify(shaken_vault(0.03, 0))
    assert any("cut back by up to" in text for text in found.warnings)
    assert found.settling < found.brick_threshold


@pytest.mark.parametrize(("sunk", "into"), [(0.01, -0.1), (0.01, 0.01)])
def test_what_is_sunk_into_a_support_with_a_kerb_is_cut_by_the_faces_there(sunk, into):
    # A kerb of 50 mm at x = 1: its corner is in no face of the support's hull. A cube before it, and one that runs
    # into it, lose 10 mm at each face that they are sunk into.
    outline = [(-3, -1), (3, -1), (3, 0), (1.1, 0), (1.1, 0.05), (1, 0.05), (1, 0), (-3, 0)]
    cube = box((0.4 + into, 0, -sunk), (1.0 + into, 0.6, 0.6 - sunk), name="cube")
    given = Assembly.from_blocks([prism(outline, 3.0, name="ground"), cube], supports=["ground"])
    scene = closed_scene(given, find_interfaces(given))
    assert (scene.trimmed, scene.cut) == (1, pytest.approx(sunk))
    low, high = (bound[1] for bound in scene.assembly.bounds)
    assert low == pytest.approx([0.4 + into, 0, 0])
    assert high == pytest.approx([min(1.0 + into, 1.0), 0.6, 0.6 - sunk])
    found = verify(given)
    assert found.outcome.word == "stands"
    assert found.max_displacement < 1e-3
    assert any("cut back by up to 10 mm" in text for text in found.warnings)


@pytest.mark.parametrize("x", [-0.5, -0.11, -0.099, 0.0])
def test_a_block_beside_a_pedestal_of_its_support_loses_nothing_at_its_sides(x):
    # The sides of the pedestal, 0.2 m wide, go on as planes below the cube, and are no faces of the support there.
    ground = pitted(3.0, 1.0, 0.1, -0.05, name="ground")
    given = Assembly.from_blocks([ground, box((x, 0.3, -0.01), (x + 0.6, 0.9, 0.59), name="cube")], supports=["ground"])
    scene = closed_scene(given, find_interfaces(given))
    assert scene.cut == pytest.approx(0.01)
    assert scene.assembly.volume[1] == pytest.approx(0.6 * 0.6 * 0.59)


@pytest.mark.parametrize("gap", ["0.5 mm", 1e-3])
def test_an_overlap_is_cut_that_is_none_by_default_but_by_the_gap_that_is_stated(gap):
    """A cube in the air between two walls that reach 2 mm into it: nothing carries it."""
    walls = [box((-1, -1, 0), (0, 1.6, 3), name="left"), box((0.6, -1, 0), (1.6, 1.6, 3), name="right")]
    scene = Assembly.from_blocks([*walls, box((-0.002, 0, 1.5), (0.602, 0.6, 2.1), name="cube")], supports=[0, 1])
    assert verify(scene, gap=gap).outcome.word == "falls"
    closed = closed_scene(scene, find_interfaces(scene, gap=gap))
    assert closed.cut == pytest.approx(2e-3)
    assert not len(overlaps(closed.assembly, gap=gap)[0])
