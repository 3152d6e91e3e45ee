"""The posed problem: units on the way in and out, what floats, what is crushed, and what is warned of."""

from itertools import count

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Block,
    Imperfections,
    InputError,
    JointLaw,
    Outcome,
    Tie,
    assess,
    find_interfaces,
    friction_limit,
    glued,
    limit_load,
    tilt_limit,
)
from blockstat.analysis.problem import checked_loads, crushes, free_fall, pose, timed
from blockstat.analysis.rims import gap_warnings
from evidence.scenes.edges import prism as extruded
from evidence.scenes.small import assembly, box, prism

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")


def posed(asm, **options):
    given = {"friction": None, "gravity": None, "loads": None, "gap": 0.01, "interfaces": None}
    return pose(asm, **(given | options))


def tower(**options):
    blocks = [GROUND, box((0, 0, 0), (1, 2, 3), name="low"), box((0.2, 0, 3), (1.5, 2, 4), name="high")]
    return Assembly.from_blocks(blocks, supports=["ground"], density=700.0, gravity=(0.5, 0.2, -8.0), **options)


def test_forces_and_twists_of_the_program_are_newtons_and_metres_outside():
    asm = tower()
    problem = posed(asm)
    program, random = problem.program, np.random.default_rng(1)
    twist = random.normal(size=12)
    mechanism = problem.to_blocks(twist)
    assert not mechanism[0].any()
    np.testing.assert_allclose(mechanism[1:, :3], twist.reshape(-1, 6)[:, :3])
    np.testing.assert_allclose(mechanism[1:, 3:] * program.length_unit, twist.reshape(-1, 6)[:, 3:])
    load = random.normal(size=(3, 6))
    # The work of a load on a motion is the same in both units.
    assert problem.scaled(load) @ twist * program.force_unit == pytest.approx((load[1:] * mechanism[1:]).sum())
    assert program.load * program.force_unit == pytest.approx(problem.scaled(problem.load) * program.force_unit)
    force = random.normal(size=(program.n_points, 3))
    np.testing.assert_allclose(problem.to_points(force), force * program.force_unit)
    np.testing.assert_allclose(problem.adhesion_at_points(force[:, 0]), force[:, 0] * program.force_unit)
    assert problem.to_bonds(force) is None
    assert problem.to_ties(force) is None


def test_the_work_of_contact_forces_is_that_of_their_points():
    problem = posed(tower())
    random = np.random.default_rng(2)
    force, twist = random.normal(size=(problem.program.n_points, 3)), random.normal(size=12)
    mechanism, joints = problem.to_blocks(twist), problem.interfaces
    power = 0.0
    for p, (k, own) in enumerate(zip(joints.point_interface, problem.to_points(force), strict=True)):
        push = own @ joints.frame[k]
        for block, sign in zip(joints.pair[k], (-1, 1), strict=True):
            arm = joints.point[p] - problem.assembly.centroid[block]
            power += sign * push @ (mechanism[block, :3] + np.cross(mechanism[block, 3:], arm))
    scaled = (problem.program.matrix @ force.reshape(-1)) @ twist * problem.program.force_unit
    assert scaled == pytest.approx(power, rel=1e-9)


def test_points_of_a_cohesive_joint_carry_their_forces_less_the_shift():
    problem = posed(tower(joints=[JointLaw(("*", "*"), tension=100.0)]))
    force = np.ones((problem.program.n_points, 3))
    joints = problem.interfaces
    found = problem.to_points(force)
    share = 100.0 * joints.area[joints.point_interface] / 4
    np.testing.assert_allclose(found[:, 0], problem.program.force_unit - share)
    np.testing.assert_allclose(found[:, 1:], problem.program.force_unit)


def test_friction_and_gravity_replace_those_of_the_assembly():
    asm = tower()
    problem = posed(asm, friction=0.25, gravity=(0, 0, -2.0), loads=np.ones((3, 6)))
    assert (problem.program.friction == 0.25).all()
    np.testing.assert_allclose(problem.load[1], [1, 1, 1 - 2 * asm.mass[1], 1, 1, 1])
    assert posed(asm).assembly is asm
    bare = asm.with_(support=np.zeros(3, dtype=bool), name="bare")
    with pytest.raises(InputError, match='"bare" has no supports; list the blocks that cannot move under "supports"'):
        posed(bare)


def test_constant_ties_are_loads_and_others_are_unknowns():
    ends = ((-4, 0, 0), (0, 1, 2.0))
    for least, greatest, unknown in ((3.0, 3.0, 0), (1.0, 3.0, 1)):
        problem = posed(tower(ties=[Tie(("ground", "low"), ends, least, greatest)]))
        assert len(problem.ties) == unknown
        plain = posed(tower()).load
        line = np.array([-4.0, -1, -2]) / 21**0.5
        pull = 3.0 * (1 - unknown) * line
        np.testing.assert_allclose(problem.load[1] - plain[1], [*pull, *np.cross((-0.5, 0, 0.5), pull)], atol=1e-9)
        none = problem.to_ties(np.empty((0, 3)))
        assert none == pytest.approx([least])
    force = np.zeros((problem.eq.n_columns, 3))
    force[-1, 0] = 2.0 / problem.program.force_unit
    assert problem.to_ties(force) == pytest.approx([2.0])


def test_ties_of_floating_blocks_are_left_out():
    apart = box((5, 5, 5), (6, 6, 6), name="apart"), box((7, 7, 7), (8, 8, 8), name="far")
    tie = Tie(("apart", "far"), ((6, 6, 6), (7, 7, 7)), 1.0, 2.0)
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="low"), *apart], supports=["ground"], ties=[tie])
    problem = posed(asm)
    assert problem.floating.tolist() == [2, 3]
    assert problem.ties.tolist() == []
    held = asm.with_(ties=[Tie(("low", "far"), ((1, 1, 1), (7, 7, 7)), 1.0, 2.0)])
    assert posed(held).floating.tolist() == [2]
    assert posed(held).ties.tolist() == [0]


def test_bonds_at_the_centres_follow_the_points():
    problem = posed(glued(tower(), 50.0, moment=7.0))
    m = problem.program.n_points
    assert len(problem.bonds) == problem.interfaces.n_interfaces == 2
    force = np.zeros((problem.eq.n_columns, 3))
    assert problem.to_bonds(force) is not None
    assert problem.eq.n_columns > m
    assert posed(glued(tower(), 50.0)).to_bonds(force) is None


@pytest.mark.parametrize(("friction", "slips"), [(0.5, True), (0.0, False), (np.inf, True)])
def test_coulombs_law_needs_a_joint_with_friction(friction, slips):
    assert posed(tower(friction=friction)).slips is slips
    alone = Assembly.from_blocks([GROUND], supports=["ground"])
    assert posed(alone).slips is False
    assert posed(alone).warnings == ("all blocks are supports; there was nothing to check",)


def floating_group():
    """Two cubes that touch each other in the air, of densities 1 and 3, and a plate by itself."""
    blocks = [
        GROUND, box((0, 0, 4), (1, 1, 5), name="a", density=1.0), box((1, 0, 4), (2, 1, 5), name="b", density=3.0),
        box((5, 5, 3), (7, 6, 3.5), name="plate", density=1.0),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["ground"], gravity=(0.3, 0.4, -1.2))


def test_what_nothing_holds_falls_along_its_load():
    asm = floating_group()
    problem = posed(asm)
    assert problem.floating.tolist() == [1, 2, 3]
    down = np.array([0.3, 0.4, -1.2]) / 1.3
    found = free_fall(problem)
    np.testing.assert_allclose(found[1:, :3], [down] * 3, atol=1e-12)
    assert not found[:, 3:].any()
    assert not found[0].any()
    loads = np.zeros((4, 6))
    loads[1, :3] = 3.0, 0.0, 0.0
    together = 4 * np.array([0.3, 0.4, -1.2]) + [3, 0, 0]
    pushed = free_fall(posed(asm, loads=loads))
    np.testing.assert_allclose(pushed[1:3, :3], [together / np.linalg.norm(together)] * 2)
    np.testing.assert_allclose(pushed[3, :3], down)


def test_a_group_whose_forces_cancel_turns_about_its_middle():
    asm = floating_group()
    weight = asm.mass[:, None] * asm.gravity
    loads = np.zeros((4, 6))
    loads[1:, :3] = -weight[1:]
    still = free_fall(posed(asm, loads=loads))
    assert not still.any()
    couple = loads.copy()
    couple[1, :3] += (0, 0, 2.0)
    couple[2, :3] -= (0, 0, 2.0)
    couple[1, 3:] = (0, 1.0, 0)
    found = free_fall(posed(asm, loads=couple))
    # Moment about the middle of the centroids: arms -+.5 along x, so 2 about y, and 1 more: it turns about +y.
    np.testing.assert_allclose(found[1:3, 3:], [[0, 1, 0]] * 2, atol=1e-12)
    np.testing.assert_allclose(found[1:3, :3], [[0, 0, 0.5], [0, 0, -0.5]], atol=1e-12)
    assert not found[3].any()
    verdict = assess(asm, loads=couple)
    assert verdict.outcome is Outcome.UNSTABLE
    assert verdict.score == np.inf
    assert verdict.certificate.work > 0
    assert verdict.certificate.required_force == np.inf
    assert assess(asm, loads=loads).outcome is Outcome.UNDECIDED


def test_a_tie_joins_blocks_that_float_to_one_group():
    asm = floating_group()
    tie = Tie(("b", "plate"), ((2, 1, 4.5), (5, 5, 3.25)), 0.0, 1.0)
    loads = np.zeros((4, 6))
    loads[3, :3] = (40.0, 0.0, 0.0)
    found = free_fall(posed(asm.with_(ties=[tie]), loads=loads))
    total = (asm.mass[1:, None] * asm.gravity).sum(axis=0) + [40, 0, 0]
    np.testing.assert_allclose(found[1:, :3], [total / np.linalg.norm(total)] * 3)


@pytest.mark.parametrize("loads", [np.zeros((2, 6)), np.zeros((3, 5)), np.zeros(18), np.full((3, 6), np.nan), [[1.0]]])
def test_loads_are_a_finite_wrench_on_each_block(loads):
    with pytest.raises(InputError, match=r"loads have shape .*; finite values of shape \(3, 6\) are needed"):
        checked_loads(tower(), loads)


def test_loads_may_be_left_out_and_must_be_numbers():
    assert checked_loads(tower(), None).tolist() == np.zeros((3, 6)).tolist()
    assert checked_loads(tower(), [[1] * 6] * 3).dtype == float
    with pytest.raises(InputError, match=r"loads must be numbers of shape \(3, 6\)"):
        checked_loads(tower(), "abc")
    with pytest.raises(InputError, match=r"loads have shape \(2, 6\)"):
        assess(tower(), loads=np.zeros((2, 6)))


def cubes(places):
    return [box(p, np.add(p, 1), name=f"c{k}") for k, p in enumerate(places)]


def test_blocks_that_touch_nothing_are_named_up_to_five():
    low = box((0, 0, 0), (1, 1, 1), name="low")
    far = [(3 * k, 0, 4 + k) for k in range(7)]
    five = posed(assembly([GROUND, low, *cubes(far[:5])], supports=["ground"])).warnings
    assert list(five) == [f'block "c{k}" touches nothing' for k in range(5)]
    seven = posed(assembly([GROUND, low, *cubes(far)], supports=["ground"])).warnings
    assert seven[5:] == ("2 more blocks touch nothing",)
    one = posed(assembly([GROUND, *cubes(far[:1])], supports=["ground"])).warnings
    assert one == ('block "c0" touches nothing',)


def test_where_no_two_blocks_touch_their_distances_are_told():
    asm = assembly([GROUND, *cubes([(0, 0, 3), (0, 0, 4.25), (3, 0, 2)])], supports=["ground"])
    (told,) = posed(asm).warnings
    assert told == (
        'no two blocks touch: the smallest gap between two of them is 0.25 m ("c0" and "c1"), '
        'and 2 m to a support ("c2" and "ground")'
    )


def edged(compression=5e6, n=1):
    """Wedges on their edges: contacts without area, under a law with compressive strength."""
    ridge = [(-0.5, 0, 1), (0.5, 0, 1), (0.5, 2, 1), (-0.5, 2, 1), (0, 0, 0), (0, 2, 0)]
    faces = [[0, 1, 2, 3], [0, 4, 1], [2, 5, 3], [0, 3, 5, 4], [1, 4, 5, 2]]
    wedges = [Block(np.array(ridge) + [2 * k, 0, 0], faces, f"w{k}", "w") for k in range(n)]
    law = JointLaw(("w", "*"), compression=compression)
    return assembly([GROUND, *wedges], supports=["ground"], joints=[law])


def test_edges_under_a_law_with_strength_carry_nothing_and_are_named():
    problem = posed(edged(n=4))
    assert [faces.n_interfaces for faces in problem.interfaces.crushed] == [4]
    assert problem.interfaces.n_interfaces == 0
    told = [text for text in problem.warnings if "compressive strength" in text]
    pairs = [f'"ground" and "w{k}"' for k in range(4)]
    assert told == [
        f"contacts without area carry nothing under a joint law with compressive strength: {'; '.join(pairs[:3])}; "
        "and 1 more"
    ]
    three = [text for text in posed(edged(n=3)).warnings if "compressive strength" in text]
    assert three[0].endswith('"ground" and "w2"')
    free = posed(edged(None, n=2))
    assert free.interfaces.crushed == ()
    assert free.interfaces.n_interfaces == 2


def test_a_motion_into_a_crushed_edge_proves_no_fall():
    problem = posed(edged())
    motion = np.zeros((2, 6))
    for drive, closes in ((-1.0, True), (-2e-9, True), (-0.5e-9, False), (0.0, False), (1.0, False)):
        motion[1, 2] = drive
        assert crushes(problem, motion) is closes
    motion[1] = 0.0
    motion[0, 2] = 1.0
    assert crushes(problem, motion)
    assert not crushes(posed(edged(None)), -motion)
    assert assess(edged()).outcome is Outcome.UNDECIDED


def block_beside(*others, **options):
    """A block of 1 x 2 x 2 m on the ground beside other supports."""
    blocks = [GROUND, box((0, -1, 0), (1, 1, 2), name="block"), *others]
    return assembly(blocks, supports=["ground", *(other.name for other in others)], **options)


def test_crushed_contacts_stay_in_the_way_where_the_joints_of_an_answer_are_used_again():
    law = JointLaw(("*", "*"), compression=5e6)
    leaning = block_beside(prism([(1, 1), (2, 0.8), (2, 1.2)], 0.5, name="wedge"), joints=[law])
    verdict = assess(leaning, gravity=(0.7, 0, -1))
    again = assess(verdict.assembly, interfaces=verdict.interfaces)
    assert again.outcome is verdict.outcome is Outcome.UNDECIDED
    assert again.warnings == verdict.warnings
    worst = assess(leaning, gravity=(0.7, 0, -1), imperfections=Imperfections(density={"*": (0.9, 1.1)}))
    assert len(set(worst.warnings)) == len(worst.warnings) > 0
    limit = limit_load(leaning, (1, 0, 0))
    second = limit_load(leaning, (1, 0, 0), interfaces=limit.interfaces)
    assert (second.outcome, second.lower, second.upper) == (limit.outcome, pytest.approx(limit.lower), np.inf)


def test_a_fall_past_an_edge_does_not_drive_in_what_is_crushed():
    """Pushed against a vertical edge, the block turns about it, and its back comes round against a wedge there."""
    edge = box((1, -2, 0.5), (2, -1, 1.5), name="edge")
    tips = [(x, y, z) for x, y in ((0.05, 1), (0, 2), (0.1, 2)) for z in (0.7, 1.3)]
    wedge = Block(np.array(tips), [[0, 2, 4], [1, 5, 3], [0, 1, 3, 2], [0, 4, 5, 1], [2, 3, 5, 4]], "wedge", "wedge")
    law = JointLaw(("wedge", "*"), compression=5e6)
    for others, falls in (((edge,), True), ((edge, wedge), False)):
        asm = block_beside(*others, friction=0.2, joints=[law] if len(others) > 1 else [])
        # What it slides away with at first leaves the wedge, and is driven against the edge.
        verdict = assess(asm, gravity=(0.8, -0.08, -1))
        assert verdict.outcome is (Outcome.UNSTABLE if falls else Outcome.UNDECIDED)
        assert np.isfinite(limit_load(asm, (1, -0.1, 0)).upper) == falls


def test_joints_that_are_almost_taken_are_told_where_the_verdict_is_not_stable():
    for gap, near in ((0.011, True), (0.5, False)):
        asm = assembly([GROUND, box((0, 0, gap), (1, 1, 1 + gap), name="up")], supports=["ground"])
        told = [text for text in assess(asm).warnings if "near joints" in text]
        assert bool(told) is near, told
    problem = posed(assembly([GROUND, *cubes([(0, 0, 0.011), (3, 0, 0.012)])], supports=["ground"]))
    assert gap_warnings(problem, more_may_help=False) == []
    (text,) = gap_warnings(problem, more_may_help=True)
    assert text.startswith("near joints that were not taken: 2 (gap tolerance 0.01")
    assert 'the closest "ground" to "c0" with 0.011 m: a larger tolerance may change the answer' in text


NEAR_EDGES = "near edges and corners that were not taken"


def ridge(x, height, name="near"):
    """A roof along y whose ridge is at that place and height."""
    return extruded([(x - 0.25, -1), (x + 0.25, -1), (x, height)], -1, 2, name=name)


@pytest.mark.parametrize(
    ("others", "told"),
    [
        ([ridge(0.9, -0.011)], True),
        ([ridge(0.9, -0.04)], True),
        ([ridge(0.9, -0.06)], False),  # beyond five times the tolerance
        ([ridge(0.1, -0.011)], False),  # the cube turns away from it
    ],
)
def test_edges_that_are_almost_taken_are_told_where_they_are_in_the_way_of_the_fall(others, told):
    """A cube on a ridge left of its middle turns over to the right, where it would come down on the other ridge."""
    blocks = [ridge(0.4, 0.0, "under"), box((0, 0, 0), (1, 1, 1), name="cube"), *others]
    asm = assembly(blocks, supports=["under", "near"], friction=0.5)
    for found in (assess(asm), tilt_limit(asm, "y"), friction_limit(asm)):
        near = [text for text in found.warnings if text.startswith(NEAR_EDGES)]
        assert bool(near) is told
        assert all('the closest "cube" to "near"' in text for text in near)
    assert assess(asm).outcome is Outcome.UNSTABLE
    assert (assess(asm, gap=0.05).outcome is Outcome.STABLE) is told


@pytest.mark.parametrize("left", [(-0.1, -1), (-0.1, 0)], ids=["ridge", "ledge"])
def test_an_edge_of_a_block_that_touches_elsewhere_is_told(left):
    outline = [(-0.1, -2), (1.4, -2), (1.4, -1), (0.9, -0.02), (0.65, -1), (0.4, 0), left]
    blocks = [extruded(outline, -1, 2, name="roofs"), box((0, 0, 0), (1, 1, 1), name="cube")]
    asm = assembly(blocks, supports=["roofs"], friction=0.5)
    (text,) = assess(asm).warnings
    assert text == (
        f"{NEAR_EDGES} and are in the way of the fall: 1 (gap tolerance 0.01 of the block size), the closest "
        '"roofs" to "cube" with 0.02 m: a larger tolerance may change the answer'
    )
    assert assess(asm, gap=0.021).outcome is Outcome.STABLE


@pytest.mark.parametrize(("push", "arm", "wider", "told"), [(1, 0.1, 0.4, True), (-1, 0.5, 0.5, False)])
def test_edges_that_are_almost_taken_are_told_where_they_may_raise_a_limit(push, arm, wider, told):
    """Pushed at mid-height, a cube on a ledge turns over the end of the ledge, or over the ridge if that is taken."""
    ledge = box((-1, -1, -1), (0.6, 2, 0), name="ledge")
    blocks = [ledge, ridge(0.9, -0.011), box((0, 0, 0), (1, 1, 1), name="cube")]
    asm = assembly(blocks, supports=["ledge", "near"], friction=3.0)
    found = limit_load(asm, (push, 0, 0))
    assert found.lower == pytest.approx(arm / 0.5, rel=2e-4)
    assert any(text.startswith(NEAR_EDGES) for text in found.warnings) is told
    assert limit_load(asm, (push, 0, 0), gap=0.02).lower == pytest.approx(wider / 0.5, rel=0.05)


def test_edges_are_looked_for_where_the_tolerance_is_a_length_or_wide():
    blocks = [ridge(0.4, 0.0, "under"), ridge(0.9, -0.011), box((0, 0, 0), (1, 1, 1), name="cube")]
    asm = assembly(blocks, supports=["under", "near"], friction=0.5)
    for gap, told in (("5 mm", True), ("2 mm", False), (0.1, False)):
        assert any(text.startswith(NEAR_EDGES) for text in assess(asm, gap=gap).warnings) is told
    (text,) = [text for text in assess(asm, gap="5 mm").warnings if text.startswith(NEAR_EDGES)]
    assert "(gap tolerance 5 mm)" in text


def test_joints_that_do_not_quite_close_are_counted():
    asm = assembly([GROUND, *cubes([(0, 0, 0.0), (3, 0, 0.004), (6, 0, -0.006)])], supports=["ground"])
    (told,) = [text for text in assess(asm).warnings if "count as touching" in text]
    assert told == "2 of 3 joints do not quite close (up to 6 mm) and count as touching"
    asm = assembly([GROUND, *cubes([(0, 0, 0.00456)])], supports=["ground"])
    (told,) = [text for text in assess(asm).warnings if "count as touching" in text]
    assert told == "1 of 1 joints do not quite close (up to 4.6 mm) and count as touching"


def test_times_are_kept_by_step(monkeypatch):
    timings = {"a": 1.0}
    monkeypatch.setattr("blockstat.analysis.problem.process_time", iter([2.0, 5.5]).__next__)
    with timed(timings, "b"):
        pass
    assert timings == {"a": 1.0, "b": 3.5}
    ticks = count()
    monkeypatch.setattr("blockstat.analysis.problem.process_time", lambda: 2.0 ** next(ticks))
    found = assess(tower()).timings
    # Steps follow each other: the n-th begins at 4^n and takes as long again.
    steps = ("interfaces", "equilibrium", "solve", "certificate")
    assert found == {name: 4.0**n for n, name in enumerate(steps)} | {"total": 85.0}


def test_given_joints_are_taken_as_they_are():
    asm = tower()
    joints = find_interfaces(asm)
    assert posed(asm, interfaces=joints).interfaces is joints
    lone = joints.subset(joints.pair[:, 0] == 0)
    assert posed(asm, interfaces=lone).floating.tolist() == [2]


def test_cells_divide_a_joint_where_a_law_asks_for_them():
    law = JointLaw(("*", "*"), compression=5e6, cells=5)
    problem = posed(tower(joints=[law]))
    plain = posed(tower(joints=[JointLaw(("*", "*"), tension=1.0)]))
    assert problem.interfaces.n_points > plain.interfaces.n_points
    assert problem.interfaces.share is not None
    assert plain.interfaces.share is None
    again = posed(tower(joints=[law]), interfaces=problem.interfaces)
    assert again.interfaces is problem.interfaces


def test_a_prism_in_the_plane_is_solved_in_the_plane_and_in_space_alike():
    blocks = [GROUND, prism([(0, 0), (2, 0), (1.5, 1), (0.2, 1.2)], 1.0, name="p")]
    asm = assembly(blocks, supports=["ground"])
    assert posed(asm).program.plane is not None
    law = asm.with_(joints=[JointLaw(("*", "*"), friction=0.5)])
    assert posed(law).program.plane is not None
    strong = asm.with_(joints=[JointLaw(("*", "*"), compression=1e6)])
    assert posed(strong).program.plane is None
