"""Motions of the ground: what is refused, what is scaled and how one alone is named."""

import numpy as np
import pytest

from blockstat import InputError
from dynsim import Pulse, Ramp, Record
from dynsim.earthquake.motion import named_motions, scaled
from dynsim.loads.ground import SHAPES


@pytest.mark.parametrize(
    ("times", "values", "words"),
    [
        ([0.0, np.nan], [[1, 0, 0], [0, 0, 0]], "a time or an acceleration is not a finite number"),
        ([0.0, 1.0], [[1, 0, np.inf], [0, 0, 0]], "a time or an acceleration is not a finite number"),
        ([0.0, 1.0], np.zeros((2, 3)), "the acceleration is 0 throughout"),
        ([0.0, 1.0], [[1, 0], [0, 0]], r"\(k,\) and \(k, 3\) are needed"),
        ([1.0, 1.0], [[1, 0, 0], [0, 0, 0]], "times must grow from one point to the next"),
    ],
)
def test_a_record_made_of_bad_arrays_is_refused(times, values, words):
    with pytest.raises(InputError, match=f"^record: .*{words}"):
        Record(times, values)


def test_a_record_that_is_scaled_keeps_its_times():
    double = scaled(Record([0.0, 1.0, 3.0], [[0, 0, 0], [2.0, -1.0, 0.5], [0, 0, 0]]), 2.0)
    assert double.times.tolist() == [0.0, 1.0, 3.0]
    assert double.at(1.0).tolist() == [4.0, -2.0, 1.0]


@pytest.mark.parametrize("motion", [Pulse((1.0, 0, 0), 0.5), Record([0.0, 1.0], [[1.0, 0, 0], [0, 0, 0]])])
def test_one_motion_alone_is_a_list_of_one(motion):
    assert named_motions(motion) == {"record 1": motion}
    assert list(named_motions([motion, motion])) == ["record 1", "record 2"]


RECORD = Record([0.2, 0.5, 0.9, 1.4], [[1.0, 0, 0], [-2.0, 1, 0], [0, 3.0, 0], [1.5, 0, 1]])
MOTIONS = [Pulse((2.0, -1.0, 0.5), 0.9, shape, start=0.25) for shape in SHAPES]


@pytest.mark.parametrize("motion", [*MOTIONS, RECORD, Ramp((1.0, 2.0, 0), 0.7)])
def test_the_velocity_of_the_ground_is_the_integral_of_its_acceleration(motion):
    times = np.linspace(0.0, 2.0, 20_001)
    values = np.array([motion.at(time) for time in (times[1:] + times[:-1]) / 2])
    gained = np.vstack([np.zeros(3), np.cumsum(values * np.diff(times)[:, None], axis=0)])
    np.testing.assert_allclose([motion.velocity(time) for time in times[::50]], gained[::50], atol=3e-4)
