"""Where a search for a limit begins, by what its steps grow and where it ends, as its docstrings state.

Nothing of dynsim is imported before the test runs: a figure that is read when a module is imported counts from there.
"""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import find_interfaces
from evidence.scenes.small import assembly, box


def foot(factor):
    """A block of 1 x 2 m that tips at .5, and joints of which the foot is wider or narrower than it is."""
    asm = assembly([box((-9, -9, -1), (9, 9, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="b")], friction=3.0)
    joints = find_interfaces(asm)
    middle = asm.centroid[1] * [1, 1, 0]
    return asm, replace(joints, point=middle + factor * (joints.point - middle))


def test_a_search_takes_the_steps_that_are_stated():
    from dynsim import Settings, limit
    from dynsim.judge.limit import DynamicLimit

    quick = Settings(time_step=2e-3, quick_step=2e-3, fine_step=2e-3, end=1.0)

    def tried(factor, **options):
        asm, joints = foot(factor)
        found = limit(asm, (1, 0, 0), settings=quick, interfaces=joints, **options)
        return found, np.array([trial.multiplier for trial in found.trials]) / found.static[1]

    # From above: .98 of the static limit, then .025, .05, .1, .2, .4 less.
    found, down = tried(2.0, width=0.9, check=False)
    assert down[:5] == pytest.approx([0.98, 0.955, 0.905, 0.805, 0.605])
    assert found.outcome.word == "limit"
    # From below: .98 and 1.005 of it, then .025, .05, .1 more.
    found, up = tried(0.5, width=0.9, check=False)
    assert up[:5] == pytest.approx([0.98, 1.005, 1.03, 1.08, 1.18])
    # As far as the block tips, at a hundred times the static limit of such a foot.
    found, far = tried(0.01, width=0.9, check=False)
    assert found.outcome.word == "limit"
    assert far.max() == pytest.approx(1.005 + 0.025 * (2**12 - 1))
    # Beside the bracket, a twentieth off.
    found, _ = tried(1.0, width=0.5)
    beside = [trial.multiplier for trial in found.trials[-2:]]
    assert beside == pytest.approx([0.95 * found.lower, 1.05 * found.upper])
    assert isinstance(found, DynamicLimit)
    coarse = "in steps of 2 ms joints creep near their limit; the default preset has finer ones"
    assert found.warnings == (coarse,)
