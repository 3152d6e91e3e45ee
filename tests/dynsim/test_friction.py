"""The friction of blocks in an engine that multiplies one number a block."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import InputError, JointLaw, assess, find_interfaces
from blockstat.contact.point_law import joint_friction
from dynsim import Settings, simulate, verify
from dynsim.engine.friction import block_friction
from evidence.scenes.small import assembly, box


def slab_and_block():
    """A slab on the ground and a block on the slab."""
    blocks = [
        box((-5, -5, -1), (5, 5, 0), group="ground"),
        box((0, 0, 0), (1, 1, 0.3), group="slab"),
        box((0.2, 0.2, 0.3), (0.8, 0.8, 0.6), group="block"),
    ]
    return assembly(blocks, friction=0.5, gravity=(2.0, 0, -9.81))


def ice(one, two):
    return JointLaw((one, two), friction=0.0)


@pytest.mark.parametrize("laws", [[("ground", "*")], [("slab", "*")], [("*", "*")]])
def test_the_product_of_two_blocks_is_the_friction_of_their_joint(laws):
    asm = slab_and_block().with_(joints=[ice(*law) for law in laws])
    faces = find_interfaces(asm)
    wanted = joint_friction(asm, faces)
    assert wanted.min() == 0
    np.testing.assert_allclose(np.prod(block_friction(asm, faces)[faces.pair], axis=1), wanted, rtol=1e-9, atol=0)


def test_a_slab_on_ice_slides_and_takes_along_what_stands_on_it():
    asm = slab_and_block().with_(joints=[ice("ground", "slab")])
    run = simulate(asm, hold=0.5)
    assert run.since_release[-1, 1, 0] == pytest.approx(0.5 * 2.0 * run.times[-1] ** 2, rel=0.1)
    assert run.since_release[-1, 2, 0] == pytest.approx(run.since_release[-1, 1, 0], rel=0.05)


def pushed(friction):
    """A slab on the ground that is pushed by 3 m/s2 sideways."""
    blocks = [box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 0.3))]
    return assembly(blocks, friction=friction, gravity=(3.0, 0, -9.81))


@pytest.mark.parametrize(
    ("given", "own", "words"), [(0.7, 0.1, ("unstable", "falls")), (0.1, 0.7, ("stable", "stands"))]
)
def test_a_friction_of_the_interfaces_counts_before_that_of_the_assembly(given, own, words):
    asm = pushed(given)
    joints = replace(find_interfaces(asm), friction=np.array([own]))
    assert (assess(asm, interfaces=joints).outcome.word, verify(asm, interfaces=joints).outcome.word) == words
    if words[1] == "falls":
        run = simulate(asm, interfaces=joints, settings=Settings(end=1.0))
        acceleration = 3.0 - own * 9.81
        assert run.since_release[-1, 1, 0] == pytest.approx(0.5 * acceleration * run.times[-1] ** 2, rel=0.02)


def test_a_friction_of_interfaces_is_not_lost_where_blocks_are_cut():
    ground = box((-5, -5, -1), (5, 5, 0))
    deep = assembly([ground, box((0, 0, -0.015), (1, 1, 0.985)), box((3, 0, 0), (4, 1, 1))], gravity=(0, 0, -9.81))
    joints = find_interfaces(deep)
    with pytest.raises(InputError, match="are cut for Bullet, so the friction of its interfaces is lost"):
        verify(deep, interfaces=replace(joints, friction=np.full(joints.n_interfaces, 0.3)))
    assert verify(deep).outcome.word == "stands"


def test_frictions_that_no_products_make_are_refused():
    # A joint without friction between two blocks that both rub on a third one.
    blocks = [box((-5, -5, -1), (5, 5, 0), group="ground"), box((0, 0, 0), (1, 1, 1), group="left")]
    blocks += [box((1, 0, 0), (2, 1, 1), group="right")]
    asm = assembly(blocks, friction=0.5, joints=[ice("left", "right")])
    with pytest.raises(InputError, match="none fit all joint laws"):
        block_friction(asm, find_interfaces(asm))


def test_a_later_law_without_a_friction_has_that_of_the_assembly_in_both_engines():
    """At 3 m/s2 beside a friction of .2 x 9.81 the slab slides, whatever the friction .9 of the law before is."""
    laws = [JointLaw(("*", "*"), friction=0.9), JointLaw(("slab", "*"), cells=2)]
    blocks = [box((-5, -5, -1), (5, 5, 0), group="ground"), box((0, 0, 0), (1, 1, 0.3), group="slab")]
    asm = assembly(blocks, friction=0.2, gravity=(3.0, 0, -9.81), joints=laws)
    assert (assess(asm).outcome.word, verify(asm).outcome.word) == ("unstable", "falls")
    first = asm.with_(joints=laws[:1])
    assert (assess(first).outcome.word, verify(first).outcome.word) == ("stable", "stands")
