"""What a proof is bounded by, what a stable verdict has in reserve, and where coordinates are measured from."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, Interfaces, LoadOutcome, Outcome, assess, box, limit_load
from blockstat.analysis.problem import pose
from blockstat.certificate.check import FORCE_LIMIT, check
from blockstat.contact.interfaces import GAP
from blockstat.solve.penalty import solve_least_force
from evidence.scenes.small import arch, running_bond

UTM = np.array([432100.0, 5412300.0, 250.0])
TILTED = Rotation.from_rotvec(np.deg2rad(30) * np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0]))


def turned(asm, rotation=TILTED):
    return asm.with_(vertices=rotation.apply(asm.vertices.copy()), gravity=rotation.apply(asm.gravity.copy()))


def squeezed(n, friction):
    """A row of n unit cubes in mid air between two walls that cannot move."""
    walls = [box((-1, 0, 0), (0, 1, 3)), box((n, 0, 0), (n + 1, 1, 3))]
    row = [box((i, 0, 1), (i + 1, 1, 2)) for i in range(n)]
    return Assembly.from_blocks([*walls, *row], supports=[0, 1], friction=friction)


def least_force(n, friction):
    """Of n cubes of weight 1/n: n + 1 joints carry one thrust H, and 2 mu H = 1 at the walls."""
    return (n + 1) / (2 * friction)


def by_hand(*contacts):
    """Interfaces of (block a, block b, normal, points, area)."""
    frames = []
    for _, _, normal, _, _ in contacts:
        first = np.cross(normal, [0.3, 0.5, 0.8])
        first /= np.linalg.norm(first)
        frames.append([normal, first, np.cross(normal, first)])
    points = [np.array(contact[3], dtype=float) for contact in contacts]
    start = np.concatenate([[0], np.cumsum([len(p) for p in points])])
    pair = np.array([contact[:2] for contact in contacts])
    area = np.array([contact[4] for contact in contacts], dtype=float)
    return Interfaces(pair, np.array(frames, dtype=float), area, np.zeros(len(pair)), np.concatenate(points), start)


UP = (0.0, 0.0, 1.0)
GROUND = box((-5, -5, -1), (5, 5, 0), name="ground")
ON_GROUND = Assembly.from_blocks([GROUND, box((0, 0, 0), (1, 1, 1), name="cube")], supports=["ground"])


@pytest.mark.parametrize("n", [1, 3, 8])
@pytest.mark.parametrize("rotation", [Rotation.identity(), TILTED], ids=["level", "tilted"])
@pytest.mark.parametrize("share", [1e-3, 0.1, 0.9, 1.1, 2.0, 20.0])
def test_what_needs_more_force_than_the_limit_is_unstable_and_what_needs_less_stands(n, rotation, share):
    asm = turned(squeezed(n, least_force(n, 1.0) / (share * FORCE_LIMIT)), rotation)
    for score in (True, False):
        verdict = assess(asm, score=score)
        assert verdict.outcome is (Outcome.STABLE if share < 1 else Outcome.UNSTABLE)
        if share < 1:
            assert verdict.certificate.total_force <= FORCE_LIMIT
        else:
            assert FORCE_LIMIT <= verdict.certificate.required_force <= 1.01 * share * FORCE_LIMIT


@pytest.mark.parametrize(("n", "friction"), [(1, 1e-5), (3, 1e-6), (8, 1e-4)])
def test_the_last_program_finds_the_least_force_from_both_sides(n, friction):
    asm = squeezed(n, friction)
    program = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None).program
    answer = solve_least_force(program)
    found = check(program, answer.force, answer.twist)
    np.testing.assert_allclose(found.total_force, least_force(n, friction), rtol=1e-4)
    np.testing.assert_allclose(found.required_force, least_force(n, friction), rtol=1e-4)


def test_no_limit_load_rests_on_dead_load_that_is_not_carried_by_bounded_forces():
    found = limit_load(squeezed(3, 1e-7), (1, 0, 0))
    assert found.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE
    carried = limit_load(squeezed(3, 0.5), (0, 0, 1))
    assert carried.outcome is LoadOutcome.UNBOUNDED


def test_the_residual_shown_is_the_one_before_rounding_is_taken_off():
    asm = turned(arch(20, 0.15))
    verdict = assess(asm)
    problem = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=verdict.interfaces)
    program = problem.program
    force = verdict.forces[problem.eq.points] / program.force_unit
    left = (program.matrix @ force.reshape(-1) + program.load).reshape(-1, 6)
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    expected = (np.linalg.norm(left, axis=1) / own).max()
    assert expected > 0
    # Only the change of units comes between the two.
    np.testing.assert_allclose(verdict.certificate.residual, expected, atol=1e-13)
    assert verdict.certificate.residual > 0
    assert verdict.certificate.imbalance == 0


def test_rounding_forgives_no_block_whose_load_it_exceeds():
    asm = squeezed(1, 0.5)
    program = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None).program
    thrust = np.zeros((program.n_points, 3))
    thrust[:, 0] = 1e15  # in balance across, and far from holding the weight
    found = check(program, thrust, 0 * program.load)
    assert found.imbalance >= 1.0
    assert not found.proves_stable


SCENES = {
    "arch": arch(20, 0.15),
    "thin arch": arch(20, 0.05),
    "wall": running_bond(6, 5),
    "corbel": Assembly.from_blocks(
        [box((-1, 0, -1), (0, 1, 0)), box((-0.6, 0, 0), (1, 1, 0.5)), box((-0.5, 0, 0.5), (1.5, 1, 1))], supports=[0]
    ),
    "beside a wall": Assembly.from_blocks([box((-1, 0, 0), (0, 1, 1)), box((0, 0, 0), (1, 1, 1))], supports=[0]),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("friction", [0.6, np.inf])
@pytest.mark.parametrize("rotation", [Rotation.identity(), TILTED], ids=["level", "tilted"])
def test_coordinates_of_a_map_change_nothing(name, friction, rotation):
    here = turned(SCENES[name], rotation).with_(friction=friction)
    there = here.with_(vertices=here.vertices + UTM)
    one, two = assess(here), assess(there)
    assert one.outcome is two.outcome
    assert len(one.interfaces.point) == len(two.interfaces.point)
    # 1e-9 m of coordinates is 1e-8 of these blocks, and forces are some ten weights.
    np.testing.assert_allclose(two.score, one.score, atol=1e-7)
    one, two = limit_load(here, (1, 0, 0)), limit_load(there, (1, 0, 0))
    assert one.outcome is two.outcome
    np.testing.assert_allclose([two.lower, two.upper], [one.lower, one.upper], atol=1e-6)


BALANCED = {
    "on one ridge": by_hand((0, 1, UP, [(0.5, 0, 0), (0.5, 1, 0)], 0)),
    "on one corner": by_hand((0, 1, UP, [(0.5, 0.5, 0)], 0)),
    "on three points of a line": by_hand((0, 1, UP, [(0.5, 0, 0), (0.5, 1, 0)], 0), (0, 1, UP, [(0.5, 0.25, 0)], 0)),
    "with its centroid over the edge of its patch": by_hand(
        (0, 1, UP, [(0.5, 0, 0), (0.5, 1, 0), (0, 1, 0), (0, 0, 0)], 0.5)
    ),
}
FIRM = {
    "on its face": by_hand((0, 1, UP, [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)], 1)),
    "on two ridges": by_hand((0, 1, UP, [(0.2, 0, 0), (0.2, 1, 0)], 0), (0, 1, UP, [(0.8, 0, 0), (0.8, 1, 0)], 0)),
    "on three corners": by_hand(*((0, 1, UP, [p], 0) for p in [(0.1, 0.2, 0), (0.9, 0.2, 0), (0.5, 0.9, 0)])),
}


@pytest.mark.parametrize("name", BALANCED)
def test_a_balanced_block_stands_and_the_verdict_says_that_nothing_resists_a_push(name):
    verdict = assess(ON_GROUND, interfaces=BALANCED[name])
    assert verdict.outcome is Outcome.STABLE
    assert verdict.neutral.tolist() == [1]
    assert 'balanced: in equilibrium without reserve; nothing resists a small push that moves "cube"' in (
        verdict.explain()
    )
    assert verdict.summary()["neutral"] == ["cube"]
    pushed = np.array([[0] * 6, [1e-4 * ON_GROUND.free_weight, 0, 0, 0, 0, 0]])
    assert assess(ON_GROUND, interfaces=BALANCED[name], loads=pushed).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("name", FIRM)
def test_a_block_with_reserve_is_not_called_balanced(name):
    verdict = assess(ON_GROUND, interfaces=FIRM[name])
    assert verdict.outcome is Outcome.STABLE
    assert not len(verdict.neutral)
    assert verdict.warnings == ()


def test_a_cube_on_the_ridge_of_a_roof_is_balanced():
    corners = [(0, 0, -1), (1, 0, -1), (1, 1, -1), (0, 1, -1), (0.5, 0, 0), (0.5, 1, 0)]
    roof = Block(corners, [[0, 3, 2, 1], [0, 1, 4], [2, 3, 5], [1, 2, 5, 4], [3, 0, 4, 5]], name="roof")
    verdict = assess(Assembly.from_blocks([roof, box((0, 0, 0), (1, 1, 1))], supports=["roof"]))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.neutral.tolist() == [1]


def test_what_rests_on_a_balanced_block_is_named_with_it_and_what_stands_beside_is_not():
    blocks = [GROUND, *(box((0, 0, i), (1, 1, i + 1), name=f"stack{i}") for i in range(2)), box((3, 0, 0), (4, 1, 1))]
    asm = Assembly.from_blocks(blocks, supports=["ground"])
    corners = [(1, 0), (1, 1), (0, 1), (0, 0)]
    faces = by_hand(
        (0, 1, UP, [(0.5, 0, 0), (0.5, 1, 0)], 0),
        (1, 2, UP, [(x, y, 1) for x, y in corners], 1),
        (0, 3, UP, [(x + 3, y, 0) for x, y in corners], 1),
    )
    assert assess(asm, interfaces=faces).neutral.tolist() == [1, 2]


def test_at_the_limit_of_friction_a_block_is_balanced_and_above_it_is_not():
    slope = [9.81 * np.sin(np.deg2rad(20)), 0, -9.81 * np.cos(np.deg2rad(20))]
    for factor, neutral in ((1.0, [1]), (1.001, [])):
        verdict = assess(ON_GROUND, gravity=slope, friction=factor * float(np.tan(np.deg2rad(20))))
        assert verdict.outcome is Outcome.STABLE
        assert verdict.neutral.tolist() == neutral


@pytest.mark.parametrize("friction", [0.0, 0.7])
@pytest.mark.parametrize("asm", [running_bond(6, 5), ON_GROUND], ids=["wall", "cube"])
def test_ordinary_scenes_are_not_called_balanced(asm, friction):
    verdict = assess(asm, friction=friction)
    assert verdict.outcome is Outcome.STABLE
    assert not len(verdict.neutral)


@pytest.mark.parametrize(("bearing", "says"), [(5e-4, True), (5e-3, False)])
def test_a_verdict_that_rests_on_slivers_names_them(bearing, says):
    piers = [box((-1, 0, -1), (bearing, 1, 0), name="left"), box((1 - bearing, 0, -1), (2, 1, 0), name="right")]
    asm = Assembly.from_blocks([*piers, box((0, 0, 0), (1, 1, 1), name="lintel")], supports=["left", "right"])
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert ('"left" to "lintel", "right" to "lintel"' in verdict.explain()) is says


def test_a_sliver_that_is_not_needed_is_not_named():
    beside = box((-1, 0, -1), (5e-4, 1, 0), name="beside")
    asm = Assembly.from_blocks(
        [beside, box((0.1, 0, -1), (1, 1, 0), name="pier"), box((0, 0, 0), (1, 1, 1))], supports=["beside", "pier"]
    )
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert verdict.warnings == ()


@pytest.mark.parametrize("rotation", [Rotation.identity(), TILTED], ids=["level", "tilted"])
@pytest.mark.parametrize(("lean", "outcome"), [(1e-3, Outcome.STABLE), (1e-9, Outcome.UNSTABLE)])
def test_shear_without_bound_proves_no_more_than_normal_forces_do(lean, outcome, rotation):
    """A block overhangs two of its three feet by .5, half of how far the third lies behind them.

    The third must pull with half the weight. Its plane leans by a small angle, so with infinite friction a shear force
    of .5 / angle of the weight pulls that much; the other feet push back as much.
    """
    block = box((0, 0, 0), (3, 1, 1), name="block")
    feet = [(0, 1, UP, [(1, 0, 0)], 0), (0, 1, UP, [(1, 1, 0)], 0)]
    normal = rotation.apply([np.sin(lean), 0, np.cos(lean)])
    feet = [(a, b, rotation.apply(n), rotation.apply(p), area) for a, b, n, p, area in feet]
    feet.append((0, 1, normal, rotation.apply([(0, 0.5, 0)]), 0))
    asm = turned(Assembly.from_blocks([GROUND, block], supports=["ground"], friction=np.inf), rotation)
    verdict = assess(asm, interfaces=by_hand(*feet))
    least = 2 * 0.5 / lean
    assert verdict.outcome is outcome
    if outcome is Outcome.STABLE:
        assert verdict.certificate.total_force >= least
    else:
        assert FORCE_LIMIT <= verdict.certificate.required_force <= 1.01 * (least + 2)
    program = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=by_hand(*feet)).program
    answer = solve_least_force(program)
    # Each component may close by the same, so a point by 1 + sqrt(2) times that; a solver's ray is no optimum.
    found = check(program, answer.force, answer.twist)
    assert least / 4 <= found.required_force <= 1.01 * (least + 2)
