import numpy as np
import pytest

from blockstat import InputError, assess
from blockstat.plot import (
    _view,
    mechanism_pose,
    paint_order,
    picture,
    picture_of_forces,
    picture_of_verdict,
    resultants,
)
from problems import arch, assembly, box, running_bond


def test_nearer_blocks_are_painted_later():
    # Seen from the front right above: along each axis the block nearer to the eye hides the other.
    view = _view(-45.0, 30.0)
    for step in np.eye(3):
        blocks = [box(2.0 * step * k, 2.0 * step * k + 1) for k in range(4)]
        asm = assembly(blocks)
        order = paint_order(asm, asm.vertices, asm.planes, view)
        nearer = (asm.centroid @ view[2])[order]
        assert (np.diff(nearer) > 0).all()


@pytest.mark.parametrize("azimuth", [-55, 20, 130, 250])
def test_no_brick_is_painted_over_one_that_hides_it(azimuth):
    asm = running_bond(6, 4)
    view = _view(azimuth, 25.0)
    rank = np.empty(asm.n_blocks, dtype=int)
    rank[paint_order(asm, asm.vertices, asm.planes, view)] = np.arange(asm.n_blocks)
    # Walk from points inside each block towards the eye: every block met on the way must be painted later.
    lower, upper = asm.bounds
    rng = np.random.default_rng(0)
    for block in range(asm.n_blocks):
        for point in lower[block] + rng.random((20, 3)) * (upper[block] - lower[block]):
            path = point + np.linspace(0, 3, 400)[:, None] * view[2]
            inside = (path[:, None] > lower + 1e-9) & (path[:, None] < upper - 1e-9)
            for other in np.flatnonzero(inside.all(axis=2).any(axis=0)):
                assert other == block or rank[other] > rank[block]


def test_pictures_have_something_on_them(tmp_path):
    from matplotlib.image import imread

    stands, falls = arch(12, 0.2), arch(12, 0.08)
    for name, asm in (("stands", stands), ("falls", falls)):
        path = picture_of_verdict(assess(asm), tmp_path / f"{name}.png")
        pixels = imread(path)[..., :3]
        assert (pixels < 0.99).any(axis=2).mean() > 0.02
    plain = picture(stands, tmp_path / "plain.png")
    assert plain.stat().st_size > 5000


def test_bad_picture_paths(tmp_path):
    with pytest.raises(InputError, match="no such directory"):
        picture(arch(4, 0.2), tmp_path / "gone" / "x.png")
    with pytest.raises(InputError, match=r"x\.xyz"):
        picture(arch(4, 0.2), tmp_path / "x.xyz")


def test_the_mechanism_is_drawn_at_the_amplitude_asked_for():
    verdict = assess(running_bond(4, 3), gravity=(0, 0.6, -1))
    shift, turn = mechanism_pose(verdict, amplitude=1e-3)
    asm = verdict.assembly
    block = np.repeat(np.arange(asm.n_blocks), np.diff(asm.vertex_start))
    arm = asm.vertices - asm.centroid[block]
    moved = shift[block] + np.einsum("nij,nj->ni", turn[block], arm) - arm
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(1e-3, rel=1e-3)


def test_the_thrust_line_stays_inside_the_arch_and_carries_its_weight():
    verdict = assess(arch(20, 0.15))
    asm = verdict.assembly
    point, force, tension = resultants(verdict)
    assert len(point) == verdict.interfaces.n_interfaces
    assert not tension.any()
    radius = np.linalg.norm(point[:, [0, 2]], axis=1)
    assert (np.abs(radius - 1.0) <= 0.075 + 1e-9).all()
    # Between two joints only the weight of one voussoir is added.
    order = np.argsort(point[:, 0])
    pair = verdict.interfaces.pair[order]
    assert len(pair) == 21
    springing = [k for k in range(21) if asm.support[verdict.interfaces.pair[k]].any()]
    signs = [1.0 if asm.support[verdict.interfaces.pair[k, 0]] else -1.0 for k in springing]
    lifted = sum(sign * force[k] for k, sign in zip(springing, signs, strict=True))
    np.testing.assert_allclose(lifted, [0, 0, asm.mass[asm.free].sum()], atol=1e-9)


def test_pictures_of_forces(tmp_path):
    for name, asm in (("stands", arch(12, 0.2)), ("falls", arch(12, 0.08))):
        path = picture_of_forces(assess(asm), tmp_path / f"{name}.png")
        assert path.read_bytes()[:4] == b"\x89PNG"
