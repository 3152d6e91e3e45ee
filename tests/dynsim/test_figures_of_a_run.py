"""The figures that docs/bullet.md and the docstrings state are those that judgements are made with.

Nothing of dynsim is imported before the test runs: a figure that is read when a module is imported counts from there.
"""

import numpy as np
import pytest

from blockstat import find_interfaces
from evidence.scenes.small import assembly, box, stack

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")


class Glide:
    """A block on ice that is kept at a velocity after release."""

    each_step = False

    def __init__(self, velocity):
        self.velocity = velocity

    def begin(self, world):
        pass

    def act(self, world, time):
        if time >= 0:
            world.set_velocity(1, np.array(self.velocity), np.zeros(3))


def test_judgements_are_made_with_the_figures_that_are_stated():
    import dynsim
    from dynsim.judge import cracks, criteria, replay, rest, run, stages, static_reserve, verify
    from dynsim.judge.closing import ClosedScene, closed_scene

    # Thresholds: a thirtieth of the median size or a twentieth of the least, and 3e-6 of it for each course squared.
    sizes = (0.2, 0.4, 0.5, 0.6, 0.7)
    blocks = [box((2 * k, 0, 0), (2 * k + s, s, s), name=f"b{k}") for k, s in enumerate(sizes)]
    mixed = assembly([box((-9, -9, -1), (19, 9, 0), name="ground"), *blocks])
    assert criteria.default_threshold(mixed) == pytest.approx(0.5 / 30 + 3e-6 * 0.5, rel=1e-12)
    alike = assembly([GROUND, *(box((2 * k, 0, 0), (2 * k + s, s, s)) for k, s in enumerate((0.5, 0.6)))])
    assert criteria.default_threshold(alike) == pytest.approx(0.5 / 20 + 3e-6 * 0.55, rel=1e-12)
    assert criteria.ARM == 0.5
    # Rest: at a quarter of the velocity of an eighth of a threshold, with two standard errors, of eight looks at least.
    for factor, rests in ((0.98, True), (1.02, False)):
        detection = rest.RestDetection(0.01, 0.5)
        velocity = factor * 2 * (0.01 / 8) / 0.5 / 4
        assert any(detection.look(0.02 * k, np.array([[velocity * 0.02 * k, 0, 0]])) for k in range(60)) is rests
    for share, rests in ((0.98, True), (1.02, False)):
        noise = np.array([1.0, -1, -1, 1] * 8)  # its trend at the end, plus two errors, is just at the least
        times = 0.02 * np.arange(26)
        speed, error = rest.trend(times, noise[:26, None])
        scale = share * 2 * (0.01 / 8) / 0.5 / 4 / (np.abs(speed).max() + 2 * error[0])
        detection = rest.RestDetection(0.01, 0.5)
        looked = [detection.look(t, np.array([[scale * n, 0, 0]])) for t, n in zip(times, noise, strict=False)]
        assert looked[-1] is rests
    few = rest.RestDetection(0.01, 0.5)
    assert [few.look(0.07 * k, np.zeros((1, 3))) for k in range(8)] == [False] * 7 + [True]
    # Loads that end: a run may take three times as long.
    ice = assembly([GROUND, box((0, 0, 0), (1, 1, 0.3)), box((4, 0, 0), (5, 1, 0.3), name="gone")], friction=0.0)
    ice = ice.with_(gravity=(0, 0, -9.81))
    short = dynsim.Settings(end=0.6, settle=0.06, resolution=1e-2)
    slow = dynsim.verify(ice, settings=short, actions=[Glide((3e-2, 0, 0))], loads=[dynsim.Removal("gone")])
    assert slow.outcome.word == "creeps"
    assert slow.run.times[-1] * slow.run.pace == pytest.approx(3 * 0.6, abs=0.05)
    # Iterations: two for each joint of the longest chain, four in the last run; falls are the same within 1.3.
    tall = stack(30)
    found = stages.stages(tall, dynsim.Settings(), find_interfaces(tall))
    assert (found.first.iterations, found.fine.iterations) == (60, 120)
    assert stages.SAME_FALL == 1.3
    assert (found.check is None, found.fine is None) == (False, False)
    # Times grow with the root of the height above 2 m, of blocks of .3 m.
    quick = dynsim.Settings(end=0.1, settle=0.02)
    paces = [dynsim.simulate(pile(n), settings=quick).pace for n in (5, 20)]
    assert paces == pytest.approx([1.0, 1 / (20 * 0.3 / 2) ** 0.5], rel=0.03)
    assert run.OWN_STEP == 0.2
    # Statics: two percent of reserve, and a resolution of 1e-4 without it.
    for width, asked in ((0.0205, 1e-3), (0.0195, 1e-4)):
        pillar = assembly([GROUND, box((0, 0, 0), (width, 0.1, 1.0))])
        reserve = static_reserve.StaticReserve(pillar, find_interfaces(pillar))
        assert reserve.resolution(1e-3) == asked
        assert reserve.sideways == pytest.approx(width, rel=0.01)
    # A crack is a hundredth of the smaller block.
    still, upright = np.zeros((6, 3)), np.tile(np.eye(3), (6, 1, 1))
    none = cracks.find_cracks(mixed, (still, upright), (still, upright))
    assert none.threshold == pytest.approx([s / 100 for s in sizes])
    assert (none.n_cracks, none.outcome.word) == (0, "sound")
    # Gaps are closed from a tenth of the threshold on.
    least = 0.1 * criteria.default_threshold(open_cube(1e-3))
    for factor, closes in ((0.98, False), (1.02, True)):
        cube = open_cube(factor * least)
        assert (closed_scene(cube, find_interfaces(cube)).assembly is not cube) is closes
    scene = ClosedScene(mixed, find_interfaces(mixed))
    assert (scene.closed, scene.moved, scene.left, scene.misfit, scene.trimmed, scene.cut) == (0, 0, 0, 0, 0, 0)
    # Glued blocks settle for .1 s longer.
    assert verify.GLUE_SETTLES == 0.1
    # A step of a plan settles for .06 s, resolves 6e-3 and ends after 2 s.
    assert replay.STEP == {"settle": 0.06, "resolution": 6e-3, "end": 2.0}
    # What a verdict has not been told.
    assert (slow.corners_moved, slow.misfit, slow.falls_alone) == (0.0, 0.0, False)
    assert (none.explain(), len(none.pair)) == ("Cracks: 0 of 5 joints.", 5)


def pile(n):
    return assembly(
        [GROUND, *(box((0, 0, 0.3 * k), (0.3, 0.3, 0.3 * (k + 1))) for k in range(n))], gravity=(0, 0, -9.81)
    )


def open_cube(gap):
    return assembly([GROUND, box((0, 0, gap), (0.3, 0.3, 0.3 + gap))], gravity=(0, 0, -9.81))
