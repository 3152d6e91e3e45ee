"""Cracks of poses made by hand, and of runs."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dynsim import Removal, Settings, verify
from dynsim.judge.cracks import find_cracks
from evidence.scenes.small import arch, assembly, box, stack


def still(asm):
    return np.zeros((asm.n_blocks, 3)), np.tile(np.eye(3), (asm.n_blocks, 1, 1))


def pillar():
    return assembly(
        [
            box((-2, -2, -1), (2, 2, 0), group="ground"),
            box((0, 0, 0), (1, 1, 1), group="wall.north"),
            box((0, 0, 1), (1, 1, 2), group="wall.north"),
        ]
    )


def test_a_lifted_and_shifted_block_opens_and_slides():
    asm = pillar()
    moved, turned = still(asm)
    moved[2] = [0.03, 0.04, 0.02]
    found = find_cracks(asm, still(asm), (moved, turned))
    upper = int(np.flatnonzero((found.pair == [1, 2]).all(axis=1))[0])
    assert found.opening[upper] == pytest.approx(0.02)
    assert found.slip[upper] == pytest.approx(0.05)
    assert found.n_cracks == 1
    assert found.per_group() == {"wall.north": 1}


def test_a_tipped_block_opens_by_its_width_times_the_sine():
    asm = pillar()
    moved, turned = still(asm)
    rotation = Rotation.from_rotvec([0, 0.05, 0]).as_matrix()
    for block in (1, 2):  # both turn about the edge x = 1 of the ground
        arm = asm.centroid[block] - [1, 0.5, 0]
        moved[block], turned[block] = rotation @ arm - arm, rotation
    found = find_cracks(asm, still(asm), (moved, turned))
    assert found.per_group() == {"ground | wall.north": 1}
    assert found.opening[found.cracked] == pytest.approx(np.sin(0.05), rel=1e-6)


def test_a_threshold_may_be_absolute():
    asm = pillar()
    moved, turned = still(asm)
    moved[2, 0] = 0.004
    assert find_cracks(asm, still(asm), (moved, turned)).n_cracks == 0
    assert find_cracks(asm, still(asm), (moved, turned), threshold=0.003).n_cracks == 1


def test_a_verdict_tells_its_cracks():
    # A block that tips opens its foot alone; one that rests has none.
    asm = stack(2, 0.5, 1.0)
    assert verify(asm).cracks.n_cracks == 0
    verdict = verify(asm.with_(gravity=(0.28, 0, -1)), settings=Settings.named("fast"))
    assert verdict.cracks.n_cracks >= 1
    assert sum(verdict.summary()["cracks"].values()) == verdict.cracks.n_cracks
    assert "Cracks:" in verdict.explain()
    assert str(verdict) == verdict.explain()
    assert "Cracks:" in verdict._repr_html_()


def test_joints_of_blocks_that_were_taken_out_are_gone_and_not_cracked():
    asm = pillar()
    moved, turned = still(asm)
    moved[2] = [0.5, 0.0, -1.0]  # what lay on the block falls
    assert find_cracks(asm, still(asm), (moved, turned)).n_cracks == 1
    assert len(find_cracks(asm, still(asm), (moved, turned), removed=np.array([1])).pair) == 0
    ring = arch(9, 0.2)
    cracks = verify(ring, loads=[Removal("voussoir4")], settings=Settings.named("fast")).cracks
    assert cracks.n_cracks >= 1
    assert not (cracks.pair == ring.names.index("voussoir4")).any()
