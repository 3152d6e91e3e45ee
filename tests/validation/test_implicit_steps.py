"""Capacity curves by implicit steps: against closed forms, linkages, virtual work, and other lengths of steps."""

import numpy as np
import pytest

from blockstat import Assembly, Tie, box, capacity
from blockstat.large_displacement.finite_steps import whole_path
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd
from evidence.dynamics.capacity import bonded_facade, work_and_rise
from evidence.references.walls import wall
from evidence.scenes.small import running_bond, u_wall

GROUND = box((-9, -5, -1), (9, 5, 0), name="ground", group="ground")
OUTWARDS = (0, -1, 0)


@pytest.fixture
def small(monkeypatch):
    """Structures of any size are followed by implicit steps from the beginning."""
    monkeypatch.setattr(whole_path, "IMPLICIT_ABOVE", 0)
    monkeypatch.setattr(LinkageFollower, "_pieces", lambda self, state: iter([PathEnd.LOST]))


@pytest.fixture(scope="module")
def facade():
    return capacity(u_wall(10), OUTWARDS, control="mean", steps=20)


@pytest.mark.usefixtures("small")
def test_one_block_is_tan_of_what_is_left_of_its_diagonal():
    block = Assembly.from_blocks([GROUND, box((0, 0, 0), (0.5, 1, 2), name="block")], supports=["ground"], friction=0.9)
    curve = capacity(block, (1, 0, 0), control="block")
    left = 0.25 - curve.displacement
    exact = left / np.sqrt(4.25 / 4 - left**2)
    assert curve.lower == pytest.approx(exact, abs=1e-6)
    assert curve.lower == pytest.approx(curve.upper, abs=1e-6)
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-4)


@pytest.mark.usefixtures("small")
def test_a_block_that_slides_does_not_rise():
    # With associated flow it would rise by friction times slip; it is open by that of one step at most.
    block = Assembly.from_blocks([GROUND, box((0, 0, 0), (2, 1, 1), name="block")], supports=["ground"], friction=0.4)
    curve = capacity(block, (1, 0, 0), control="block", displacement=0.5)
    assert curve.outcome.word == "reached"
    assert curve.lower == pytest.approx(np.full(len(curve.points), 0.4), abs=1e-6)
    assert np.abs([point.pose.displacement[1, 2] for point in curve.points]).max() < 1e-6


@pytest.mark.usefixtures("small")
def test_a_tie_carries_as_it_does_on_the_linkage(monkeypatch):
    blocks = [box((0, 0, 0), (0.5, 1, 2), name="left"), box((3, 0, 0), (3.3, 1, 1.8), name="right")]
    pair = Assembly.from_blocks([GROUND, *blocks], supports=["ground"], friction=0.9)
    pair = pair.with_(ties=[Tie(("left", "right"), ((0.5, 0.5, 1.9), (3, 0.5, 1.7)))])
    curve = capacity(pair, (1, 0, 0), control="right")
    monkeypatch.undo()
    exact = capacity(pair, (1, 0, 0), control="right")
    there = np.linspace(0, 0.9 * exact.displacement[-1], 10)
    found, known = ([of.at(one)[1] for one in there] for of in (curve, exact))
    assert found == pytest.approx(known, abs=1e-3 * exact.upper[0])


def test_the_load_does_the_work_that_lifts_a_facade_and_friction_takes_little_of_it(facade):
    # Its halves turn as two bodies, so that hardly a joint slides.
    assert facade.outcome.word == "zero"
    work, rise = work_and_rise(facade)
    assert (work[1:] > rise[1:]).all()
    assert work[-1] == pytest.approx(rise[-1], rel=0.02)


def test_where_bricks_slide_friction_takes_the_rest():
    sheared = capacity(bonded_facade(5, 3, 7).with_(friction=0.6), OUTWARDS, control="mean", displacement=0.3)
    work, rise = work_and_rise(sheared)
    assert (np.diff(work - rise) > 0).all()  # in every step: friction gives nothing back


def test_a_wall_in_its_plane_is_followed_to_its_end():
    # Close to the end a shorter step finds contacts open that close in a longer one, and no multiplier.
    curve = capacity(running_bond(10, 7).with_(friction=0.65), (1, 0, 0))
    assert curve.outcome.word in ("zero", "collapse")
    assert 0 <= curve.lower[-1] < 0.1 * curve.lower[0]
    assert np.isfinite(curve.displacement).all()


def test_bounds_keep_their_order_and_forces_prove_some_of_them(facade):
    proven = [text for text in facade.warnings if "balance to the solver's tolerance only" in text]
    assert len(facade.points) > 15
    assert not proven or int(proven[0].split()[1]) < len(facade.points)
    assert (facade.lower <= facade.upper + 1e-9).all()
    assert (np.diff(facade.displacement) > 0).all()


def test_other_lengths_of_steps_lead_to_the_same_end(facade):
    finer = capacity(u_wall(10), OUTWARDS, control="mean", steps=40)
    assert finer.displacement[-1] == pytest.approx(facade.displacement[-1], rel=0.01)
    there = np.linspace(0.1, 1.2, 6)
    found, known = ([of.at(one)[0] for one in there] for of in (facade, finer))
    assert found == pytest.approx(known, abs=0.01 * finer.upper[0])


def test_the_default_control_of_a_facade_moves_its_mechanism():
    # The linkage of its limit mechanism is lost at rest; the corner that moves most was said not to move it.
    curve = capacity(bonded_facade(9, 5, 16), OUTWARDS, displacement=0.05, steps=2)
    assert curve.outcome.word == "reached"
    assert curve.lower[0] == pytest.approx(curve.limit.lower, rel=1e-4)


@pytest.mark.usefixtures("small")
def test_a_wall_in_its_plane_leaves_rest_as_by_other_steps(monkeypatch):
    implicit = capacity(wall("W1"), (1, 0, 0), control="mean", displacement=0.02)
    monkeypatch.undo()
    explicit = capacity(wall("W1"), (1, 0, 0), control="mean", displacement=0.02)
    there = np.linspace(0.002, 0.019, 5)
    found, known = (np.array([of.at(one)[0] for one in there]) for of in (implicit, explicit))
    assert found == pytest.approx(known, rel=0.05)
