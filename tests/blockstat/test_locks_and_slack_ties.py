"""Paths that end because blocks lock each other, solves that prove nothing, and ties that go slack."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from blockstat import Assembly, InputError, JointLaw, PathOutcome, Tie, box, capacity, settle_to_collapse
from blockstat.assembly import Block
from blockstat.contact.interfaces import find_interfaces
from blockstat.large_displacement.capacity_curve import CapacityOutcome
from blockstat.large_displacement.displaced.contact_pairs import pairs_at_rest
from blockstat.large_displacement.displaced.control import conjugate_control
from blockstat.large_displacement.displaced.loads import read_loads
from blockstat.large_displacement.displaced.pose import Pose, rest_pose
from blockstat.large_displacement.displaced.structure import Configuration, Structure
from blockstat.large_displacement.finite_steps.fall import without_blocks
from blockstat.large_displacement.linkage.linkage import linkage_at_rest
from blockstat.large_displacement.linkage.path import PathEnd, end_at
from blockstat.large_displacement.statics import limit_state as of_load
from blockstat.large_displacement.statics import settling_state as of_settlement
from blockstat.solve.answer import Status

ALONG = (1, 0, 0)
GROUND = box((-2, -2, -1), (3, 5, 0), name="ground")


def prism(outline, low, high, name):
    """A block whose section in the plane xz is given, counter-clockwise, from y = low to y = high."""
    n = len(outline)
    corners = [(x, y, z) for y in (low, high) for x, z in outline]
    sides = [[(i + 1) % n, i, n + i, n + (i + 1) % n] for i in range(n)]
    faces = [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]
    return Block(np.array(corners, dtype=float), faces, name=name, group=name)


def hook(*others):
    """A stem with a hook, tied to the ground at its toe (.3, 0), on a smooth shelf below the hook.

    The top of the shelf is the line z = 1.6 + .235 (x + .1), which the corner (-.1, 1.6) of the hook is on.
    """
    stem = prism([(0, 0), (0.3, 0), (0.3, 2), (-0.1, 2), (-0.1, 1.6), (0, 1.75)], 0, 1, "hook")
    top = [1.6 + 0.235 * (x + 0.1) for x in (-0.03, -0.6)]
    shelf = prism([(-0.6, 1.0), (-0.03, 1.0), (-0.03, top[0]), (-0.6, top[1])], -0.5, 1.5, "shelf")
    names = ["ground", "shelf", *(block.name for block in others)]
    tie = Tie(("ground", "hook"), ((0.3, 0.5, 0), (0.2, 0.5, 0.5)))
    smooth = [JointLaw((name, "hook"), friction=0.0) for name in names[1:]]
    return Assembly.from_blocks([GROUND, shelf, stem, *others], supports=names, friction=0.7, joints=smooth, ties=[tie])


#: The corner is at (-.4, 1.6) from the toe: it leaves at a slope of .25, and is back on the line of the slope .235 when
#: the chord of its arc has this slope.
TURN_THAT_LOCKS = 2 * (np.arctan(0.25) - np.arctan(0.235))


def turn_of(pose):
    return np.arcsin(pose.rotation[2][0, 2])


def test_a_curve_locks_where_a_hook_catches():
    curve = capacity(hook(), ALONG, control="hook", steps=10)
    assert curve.outcome is CapacityOutcome.LOCKED
    assert turn_of(curve.points[-1].pose) == pytest.approx(TURN_THAT_LOCKS, rel=1e-9)
    assert np.isinf(curve.events[-1].after)
    assert "any multiple of the load" in curve.explain().splitlines()[0]
    assert "no admissible state" not in curve.explain()
    assert curve.summary()["events"][-1]["after"] is None


def test_a_curve_by_finite_steps_locks_where_a_hook_catches(monkeypatch):
    monkeypatch.setattr("blockstat.large_displacement.linkage.follower.MAX_STEPS", 0)
    curve = capacity(hook(), ALONG, control="hook", steps=40)
    assert curve.outcome is CapacityOutcome.LOCKED
    assert turn_of(curve.points[-1].pose) == pytest.approx(TURN_THAT_LOCKS, rel=0.1)


def test_a_settlement_that_jams_is_no_collapse():
    pusher = box((-0.5, -0.5, 0.5), (0, 1.5, 0.9), name="pusher", group="pusher")
    # Not by way of the independent check of `tests/conftest.py`: of a corner and a face, of which each has gaps, it
    # takes the widest for the opening of the joint.
    found = settle_to_collapse.__wrapped__(hook(pusher), {"pusher": ALONG}, displacement=0.1, steps=10)
    assert found.outcome is PathOutcome.LOST
    assert found.collapse is None
    assert "jams" in found.explain()
    assert turn_of(found.poses[-1]) == pytest.approx(TURN_THAT_LOCKS, rel=1e-9)


def test_a_structure_that_locks_at_rest_has_no_curve():
    walls = [box((x, 0, 0), (x + 1, 1, 1), name=name) for x, name in ((-1, "left"), (1, "right"))]
    between = [GROUND, *walls, box((0, 0, 0), (1, 1, 1), name="block")]
    with pytest.raises(InputError, match="carries any multiple of the load: no mechanism to follow"):
        capacity(Assembly.from_blocks(between, supports=["ground", "left", "right"]), ALONG)


def test_a_structure_that_falls_at_rest_has_no_curve():
    blocks = [box((-2, 0, -1), (0.4, 1, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")]
    with pytest.raises(InputError, match=r"no limit load to start from\. Infeasible under dead load"):
        capacity(Assembly.from_blocks(blocks, supports=["ground"]), ALONG)


def configuration(assembly, lean=0.0):
    """A wall that has turned about its toe (.5, 0), with the contacts there, or all contacts where it has not."""
    loads = read_loads(assembly, None), read_loads(assembly, ALONG, live=True)
    structure = Structure(assembly, find_interfaces(assembly), *loads, "auto", np.zeros((assembly.n_blocks, 6)))
    contacts, pose = pairs_at_rest(assembly, structure.interfaces), rest_pose(assembly)
    rotation, displacement = pose.rotation.copy(), pose.displacement.copy()
    rotation[1] = [[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]]
    displacement[1] = rotation[1] @ (-0.25, 0, 1.0) - (-0.25, 0, 1.0)
    closed = (contacts.anchor[:, 0, 0] > 0.49) | (lean == 0)
    return Configuration(structure, contacts, closed, Pose(rotation, displacement), 0.0)


@pytest.mark.parametrize("status", [Status.STALLED, Status.PRIMAL_INFEASIBLE])
def test_a_solve_that_proves_nothing_is_lost(monkeypatch, status):
    """The wall stands, and tips at 1/4, whatever a solver says that has lost its way."""
    here = configuration(tied())
    assert of_load.limit_state(here).multiplier == pytest.approx(0.25, rel=1e-6)
    solve, exact = of_load.solve, of_load.clarabel.solve
    monkeypatch.setattr(of_load, "solve", lambda *given, **options: replace(solve(*given, **options), status=status))
    assert end_at(of_load.limit_state(here)) is PathEnd.LOST

    def noise(program):
        answer = exact(program)
        return replace(answer, twist=answer.twist + 1e-3, status=Status.STALLED)

    monkeypatch.setattr(of_load.clarabel, "solve", noise)
    assert end_at(of_load.limit_state(here)) is PathEnd.LOST
    assert end_at(of_settlement.settling_state(here)) is PathEnd.LOST


def test_blocks_that_fall_are_proven_to_fall_though_the_solver_stalls(monkeypatch):
    """With its centroid beyond its toe the wall falls on a ground that rests."""
    assert end_at(of_settlement.settling_state(configuration(tied()))) is None
    there, exact = configuration(tied(), 0.3), of_load.clarabel.solve
    assert end_at(of_settlement.settling_state(there)) is PathEnd.COLLAPSE
    monkeypatch.setattr(of_load.clarabel, "solve", lambda program: replace(exact(program), status=Status.STALLED))
    assert end_at(of_settlement.settling_state(there)) is PathEnd.COLLAPSE


def tied(*ties):
    """A wall of 0.5 m by 2 m, which turns about its toe (.5, 0)."""
    wall = box((0, 0, 0), (0.5, 1, 2), name="wall")
    return Assembly.from_blocks([GROUND, wall], supports=["ground"], friction=0.7, ties=ties)


def test_a_tie_that_goes_slack_does_not_hold_a_wall():
    """A tie on the side to which the wall turns shortens: the curve is that of the wall without it."""
    tie = Tie(("ground", "wall"), ((2.5, 0.5, 0), (0.5, 0.5, 2)))
    curve, free = (capacity(wall, ALONG, control="wall") for wall in (tied(tie), tied()))
    assert curve.outcome is CapacityOutcome.ZERO
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-9)
    for there in (0.05, 0.15, 0.24):
        exact = (0.25 - there) / np.sqrt(17 / 16 - (0.25 - there) ** 2)
        assert curve.at(there) == pytest.approx((exact, exact), rel=2e-4)
        assert curve.at(there) == pytest.approx(free.at(there), rel=2e-4)


@pytest.mark.parametrize("greatest", [np.inf, 2e5])
def test_a_slack_tie_pulls_with_its_least_force(greatest):
    """It pulls the top (.5, 2) to (2.5, 0), whatever it could bear: a moment about the toe beside the weight's."""
    force, least = tied().free_weight, 1000.0
    curve = capacity(
        tied(Tie(("ground", "wall"), ((2.5, 0.5, 0), (0.5, 0.5, 2)), least, greatest)), ALONG, control="wall"
    )

    def exact(turn):
        centre = np.sqrt(17) / 4 * np.array([-np.sin(np.arctan(0.25) - turn), np.cos(np.arctan(0.25) - turn)])
        top = 2 * np.array([np.sin(turn), np.cos(turn)])
        line = (2.0, 0.0) - top
        pull = least * line / np.linalg.norm(line)
        return (force * -centre[0] - (top[1] * pull[0] - top[0] * pull[1])) / (force * centre[1])

    assert curve.lower[0] == pytest.approx(exact(0.0), rel=1e-6)
    end = brentq(exact, 0, 0.3)
    moved = 0.25 - np.sqrt(17) / 4 * np.sin(np.arctan(0.25) - end)
    assert curve.outcome is CapacityOutcome.ZERO
    assert curve.displacement[-1] == pytest.approx(moved, rel=1e-6)


def test_a_slack_tie_that_is_taut_again_holds():
    """It goes from the top (.5, 2), above the toe, to an anchor 2.1 m from the toe, .05 rad further on.

    So it is shortest after a turn of .05, and as long as at rest after .1; the top has then moved by 2 sin .1.
    """
    anchor = (0.5 + 2.1 * np.sin(0.05), 0.5, 2.1 * np.cos(0.05))
    wall = tied(Tie(("ground", "wall"), (anchor, (0.5, 0.5, 2))))
    curve = capacity(wall, ALONG, control=("wall", (0.5, 0.5, 2)), displacement=0.22, steps=10)
    event = curve.events[0]
    assert (event.kind, event.shut) == ("closing", ())
    assert event.parameter == pytest.approx(2 * np.sin(0.1), rel=1e-8)
    assert event.before == pytest.approx(np.tan(np.arctan(0.25) - 0.1), rel=1e-6)
    assert event.after > event.before
    last = curve.points[-1].pose
    length = np.linalg.norm(wall.centroid[1] + last.displacement[1] + last.rotation[1] @ (0.25, 0, 1) - anchor)
    assert length <= np.linalg.norm(np.subtract((0.5, 0.5, 2), anchor)) * (1 + 1e-4)


def test_a_tie_to_a_stone_that_has_fallen_holds_nothing():
    """The wall tips at 1/4 away from a stone; the tie between them holds it while the stone is there."""
    wall, stone = box((0, 0, 0), (0.5, 1, 2), name="wall"), box((-1.5, 0, 0), (-1, 1, 0.5), name="stone")
    held = Tie(("wall", "stone"), ((0.25, 0.5, 2), (-1.25, 0.5, 0.5)))
    scene = Assembly.from_blocks([GROUND, wall, stone], supports=["ground"], friction=0.7, ties=[held])
    here = configuration(scene)
    assert of_load.limit_state(here).multiplier > 0.3
    structure = here.structure
    linkage = linkage_at_rest(structure, np.zeros((3, 6)), conjugate_control(structure))
    assert linkage.ties.tolist() == [0]
    rest = without_blocks(linkage, np.array([2]))
    assert rest.ties.tolist() == rest.slack.tolist() == []
    assert of_load.limit_state(rest.configuration(here.pose, 0.0)).multiplier == pytest.approx(0.25, rel=1e-6)
