"""Capacity curves by finite steps: against closed forms, against linkages, a published wall, and Bullet.

A step moves the fastest corner by about a thirtieth of the way, and what should touch is closed again; so on a linkage
the pose is exact, and only changes of mechanism are located to the length of a step.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import Assembly, JointLaw, Tie, box, capacity, find_interfaces, limit_load
from blockstat.large_displacement.displaced.pose import displaced_assembly, displaced_points
from blockstat.large_displacement.finite_steps import follower, whole_path
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd
from blockstat.model import Run, walls
from dynsim import simulate
from evidence.dynamics.capacity import scenes
from evidence.references.walls import ZERO_DILATANCY, wall
from evidence.scenes.small import arch, u_wall
from walls import grounded

GROUND = box((-9, -5, -1), (9, 5, 0), name="ground", group="ground")


@pytest.fixture
def stepped(monkeypatch):
    """The linkage is lost at once, so that steps have to follow all of the curve."""
    monkeypatch.setattr(LinkageFollower, "_pieces", lambda self, state: iter([PathEnd.LOST]))


@pytest.mark.usefixtures("stepped")
def test_one_block_is_tan_of_what_is_left_of_its_diagonal_by_steps_too():
    block = Assembly.from_blocks([GROUND, box((0, 0, 0), (0.5, 1, 2), name="block")], supports=["ground"], friction=0.9)
    curve = capacity(block, (1, 0, 0), control="block")
    there = np.linspace(0, 0.225, 10)
    exact = (0.25 - there) / np.sqrt(4.25 / 4 - (0.25 - there) ** 2)
    assert np.array([curve.at(one)[1] for one in there]) == pytest.approx(exact, abs=1e-3 * exact[0])
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-5)
    assert curve.lower == pytest.approx(curve.upper, abs=1e-9)


def test_steps_keep_the_length_of_a_tie(monkeypatch):
    blocks = [box((0, 0, 0), (0.5, 1, 2), name="left"), box((3, 0, 0), (3.3, 1, 1.8), name="right")]
    pair = Assembly.from_blocks([GROUND, *blocks], supports=["ground"], friction=0.9)
    tie = Tie(("left", "right"), ((0.5, 0.5, 1.9), (3, 0.5, 1.7)))
    pair = pair.with_(ties=[tie])
    exact = capacity(pair, (1, 0, 0), control="right")
    monkeypatch.setattr(LinkageFollower, "_pieces", lambda self, state: iter([PathEnd.LOST]))
    curve = capacity(pair, (1, 0, 0), control="right")
    there = np.linspace(0, 0.9 * exact.displacement[-1], 10)
    found, known = ([of.at(one)[1] for one in there] for of in (curve, exact))
    assert found == pytest.approx(known, abs=1e-5 * exact.upper[0])
    ends = np.array(tie.points)
    for point in curve.points:
        now = displaced_points(pair, point.pose, np.array([1, 2]), ends)
        assert np.linalg.norm(now[1] - now[0]) == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=1e-7)


def test_steps_find_the_jumps_of_an_arch_and_the_hinges_after_them(monkeypatch):
    exact = capacity(arch(21, 0.25), (1, 0, 0), control="mean")
    monkeypatch.setattr(LinkageFollower, "_pieces", lambda self, state: iter([PathEnd.LOST]))
    curve = capacity(arch(21, 0.25), (1, 0, 0), control="mean", steps=120)
    assert [event.kind for event in exact.events] == [event.kind for event in curve.events] == ["jump"] * 4
    for event, other in zip(curve.events, exact.events, strict=True):
        assert event.parameter == pytest.approx(other.parameter, abs=2e-3 * exact.displacement[-1])
    # Away from the jumps, which a step passes by up to its length.
    jumps = np.array([event.parameter for event in exact.events])
    there = np.linspace(0, curve.displacement[-1], 40)
    there = there[np.abs(there[:, None] - jumps).min(axis=1) > 0.01 * exact.displacement[-1]]
    found, known = (np.array([of.at(one)[1] for one in there]) for of in (curve, exact))
    assert found == pytest.approx(known, abs=1e-3 * exact.upper[0])


@pytest.fixture(scope="module")
def ferris():
    return capacity(wall("W1"), (1, 0, 0))


def top(curve, point):
    """Displacement of the top right corner [m]."""
    asm = curve.assembly
    corner = int(np.argmax(asm.vertices @ np.array([1.0, 0.0, 1.0])))
    block = np.array([asm.vertex_block[corner]])
    moved = displaced_points(asm, point.pose, block, asm.vertices[[corner]]) - asm.vertices[corner]
    return float(moved[0, 0])


def test_a_wall_in_its_plane_is_followed_through_its_stepped_crack(ferris):
    # Portioli 2021, displacement of the top right corner [m]; explicit steps of .01 m, read off a figure.
    place = np.array([top(ferris, point) for point in ferris.points])
    for there, published in ((0.01, 0.626), (0.05, 0.571), (0.10, 0.491)):
        assert np.interp(there, place, ferris.lower) == pytest.approx(published, abs=0.05 * 0.64)
    assert not any("tolerance" in text for text in ferris.warnings)  # all forces are proven
    assert ferris.upper[-1] < 0.5 * ferris.upper[0]


@pytest.mark.parametrize(("share", "sign"), [(0.9, -1), (1.1, 1)])
def test_bullet_goes_back_below_the_curve_and_on_above_it(ferris, share, sign):
    pytest.importorskip("pybullet")
    # At its weight of one the wall is slow; what is seen is the way it goes.
    asm = ferris.assembly
    point = min(ferris.points, key=lambda point: abs(top(ferris, point) - 0.1))
    there = displaced_assembly(asm, point.pose)
    loads = np.zeros((asm.n_blocks, 6))
    loads[:, 0] = share * point.lower * asm.mass * ~asm.support * np.linalg.norm(asm.gravity)
    joints = find_interfaces(there, gap=1e-6)
    run = simulate(there, loads=loads, interfaces=joints, stop=lambda _, moved, __: bool(np.abs(moved).max() > 0.02))
    free = asm.mass * ~asm.support
    assert sign * (run.since_release[-1][:, 0] @ free) / free.sum() > 1e-4


@pytest.mark.parametrize("implicit", [False, True])
def test_a_lintel_that_slides_off_its_bearing_leaves_and_the_curve_goes_on_without_it(monkeypatch, implicit):
    # The pier tips away below the lintel, which bears on it by .1 m. Without it, F / W = tan(45 deg - turn).
    blocks = [
        GROUND,
        box((-1, 0, 0), (-0.5, 1, 1), name="abutment", group="abutment"),
        box((0, 0, 0), (1, 1, 1), name="pier", group="pier"),
        box((-0.9, 0, 1), (0.1, 1, 1.1), name="lintel", group="lintel"),
    ]
    slippery = [JointLaw(("lintel", "pier"), friction=0.02), JointLaw(("lintel", "abutment"), friction=0.02)]
    asm = Assembly.from_blocks(
        blocks, supports=["ground", "abutment"], friction=2.0, density=1 / 9.80665, joints=slippery
    )
    if implicit:
        monkeypatch.setattr(whole_path, "IMPLICIT_ABOVE", 0)
        monkeypatch.setattr(LinkageFollower, "_pieces", lambda self, state: iter([PathEnd.LOST]))
    curve = capacity(asm, [("pier", (0.5, 0.5, 0.5), (1, 0, 0))], control="pier")
    assert any('"lintel": fallen out' in text for text in curve.warnings)
    bearings = [k for k, pair in enumerate(curve.limit.interfaces.pair) if asm.names.index("lintel") in pair]
    assert set(bearings) <= set(curve.points[-1].opened.tolist())
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.5, rel=1e-3)  # the centroid is above the toe
    left = np.linspace(0.25, 0.45, 5)
    alone = (0.5 - left) / np.sqrt(0.5 - (0.5 - left) ** 2)
    assert np.array([curve.at(one)[1] for one in left]) == pytest.approx(alone, abs=2e-3)


def test_a_curve_by_steps_says_so_and_how_wide_open_contacts_touch(ferris):
    assert any("no linkage from" in text for text in ferris.warnings)
    dilating = capacity(ferris.assembly, (1, 0, 0), flow="associated", displacement=0.1)
    text = next(text for text in dilating.warnings if "no linkage from" in text)
    assert float(text.split("open by up to ")[1].split()[0]) < 2.0  # mm, of bricks of .4 m
    exact = capacity(arch(21, 0.25), (1, 0, 0), control="mean")
    assert not any("no linkage" in text for text in exact.warnings)


def test_a_bonded_facade_leaves_rest_at_its_limit_load():
    # Its mechanism is no linkage: it went on at no displacement without end, at two thirds of the multiplier.
    runs = [
        Run(name="front", path=[(0.15, 0.15), (3.85, 0.15)], thickness=0.3, height=3),
        Run(name="west", path=[(0.15, 0.15), (0.15, 2)], thickness=0.3, height=3),
        Run(name="east", path=[(3.85, 0.15), (3.85, 2)], thickness=0.3, height=3),
    ]
    asm = grounded(walls(runs, brick=(0.6, 0.25))).with_(friction=0.6)
    limit = limit_load(asm, (0, -1, 0))
    curve = capacity(asm, (0, -1, 0), control="mean", displacement=0.05)
    assert curve.outcome.word == "reached"
    assert curve.lower[0] <= limit.lower
    assert curve.upper[0] == pytest.approx(limit.upper, rel=1e-3)
    assert not curve.events
    assert (np.diff(curve.displacement) > 0).all()


@pytest.mark.parametrize("name", ["W1", "W3"])
def test_joints_that_slide_without_opening_carry_what_ferris_and_tin_loi_found(name):
    # Ferris & Tin-Loi 2001, by a complementarity program; the multiplier without dilatancy is not unique.
    published = float(ZERO_DILATANCY[name])
    curve = capacity(wall(name), (1, 0, 0), control="mean", displacement=0.002)
    assert curve.lower[0] == pytest.approx(published, rel=0.02)
    assert curve.lower[0] < curve.upper[0]


def test_long_steps_along_a_straight_curve_lead_where_short_ones_do():
    # With 120 steps the longest is a quarter as long, and those through changes of the mechanism too.
    asm, there = u_wall(5).with_(friction=0.6), 0.1
    few, many = (capacity(asm, (0, -1, 0), control="mean", displacement=there, steps=n) for n in (30, 120))
    assert len(few.points) < 0.5 * len(many.points)
    where = np.linspace(0.01, 0.099, 10)
    assert [few.at(x)[0] for x in where] == pytest.approx([many.at(x)[0] for x in where], abs=0.01 * few.upper[0])


def test_an_arch_that_slides_and_jumps_ends_where_it_does_with_other_steps():
    scene, direction = next((asm, push) for name, asm, push in scenes(16) if name == "arch 15")
    curves = [capacity(scene, direction, control="mean", steps=steps) for steps in (20, 40)]
    for curve in curves:
        assert [event.kind for event in curve.events] == [event.kind for event in curves[0].events]
        assert curve.outcome.word == "zero"
    assert curves[0].displacement[-1] == pytest.approx(curves[1].displacement[-1], rel=1e-6)


@pytest.mark.parametrize(("leap", "end"), [(0.3, PathEnd.COLLAPSE), (0.0, PathEnd.ZERO)])
def test_a_multiplier_that_leaps_below_zero_is_no_zero(monkeypatch, leap, end):
    """Over a step of 1 the multiplier falls from .2 to -.2 - leap; half-way it is zero, or leaps."""

    def state(_, length):
        return SimpleNamespace(limit=SimpleNamespace(multiplier=0.2 - 0.4 * length - leap * (length > 0.4)))

    monkeypatch.setattr(follower, "stepped", state)
    monkeypatch.setattr(follower, "path_state", lambda trial: trial.limit.multiplier)
    steps = follower.StepFollower(None, end=1.0, step=1.0, longest=1.0, change=0.1, tolerance=1e-6)
    *states, last = steps._located_end(state(None, 0.0), state(None, 1.0), 1.0, 0.2, PathEnd.ZERO)
    assert last is end
    assert states == pytest.approx([0.0] if end is PathEnd.ZERO else [], abs=1e-6)
