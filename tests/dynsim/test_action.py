"""Actions reach the blocks in the scene's own units, at every look or every step."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from blockstat import InputError
from dynsim import Settings, simulate
from evidence.scenes.small import assembly, box


@dataclass
class Push:
    """A constant force on block 1 after release."""

    force: tuple[float, float, float]
    each_step: bool
    times: list[float] = field(default_factory=list)

    def begin(self, world):
        self.centre = world.assembly.centroid[1]

    def act(self, world, time):
        self.times.append(time)
        if time >= 0:
            world.push([1], np.array([self.force]), (self.centre + world.poses()[0][1])[None])


@pytest.mark.parametrize("each_step", [False, True])
@pytest.mark.parametrize("length", [0.01, 1.0, 50.0])
def test_a_push_accelerates_a_sliding_block(each_step, length):
    # Newton: a = F/m - mu g on level ground, whatever the units.
    g, mu = 9.81, 0.2
    asm = assembly([box((-9, -9, -1), (9, 9, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2))], friction=mu)
    asm = asm.with_(vertices=length * asm.vertices, gravity=(0, 0, -g))
    push = Push((0.5 * g * asm.mass[1], 0.0, 0.0), each_step)
    run = simulate(asm, settings=Settings(end=1.0), actions=[push])
    late = run.times > 0.5 * run.times[-1]
    expected = 0.5 * (0.5 - mu) * g * run.times[late] ** 2
    np.testing.assert_allclose(run.since_release[late, 1, 0], expected, rtol=0.03)
    assert push.times[0] < 0
    assert len(push.times) == pytest.approx((1.0 + Settings().settle) / 0.02 * (20 if each_step else 1), rel=0.02)


class Burst:
    """Gives block 1 a velocity that no number can hold."""

    each_step = False

    def begin(self, world):
        pass

    def act(self, world, time):
        world.set_velocity(1, np.array([np.inf, 0, 0]), np.zeros(3))


def test_a_block_that_bullet_loses_is_named_and_costs_its_own_verdict_alone():
    asm = assembly([box((-9, -9, -1), (9, 9, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2), name="slab")])
    with pytest.raises(InputError, match='block "slab" was lost in the simulation'):
        simulate(asm, actions=[Burst()])
