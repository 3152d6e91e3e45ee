"""Motion past the verdict, and moving pictures."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import Assembly, InputError, box, find_interfaces, write
from dynsim import Removal, past_verdict, read_run, verify, write_run
from dynsim.cli.commands import app


@pytest.fixture(scope="module")
def leaning():
    """A pillar that hangs over the edge of its ground by more than half."""
    blocks = [box((-1, -1, -1), (0.2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    return verify(Assembly.from_blocks(blocks, supports=["ground"]))


def test_a_film_goes_on_where_the_verdict_ended_and_the_fall_is_seen(leaning):
    film = past_verdict(leaning, 0.4)
    known = len(leaning.run.times)
    assert leaning.outcome.word == "falls"
    assert film.times[-1] == pytest.approx(leaning.run.times[-1] + 0.4, abs=0.05)
    # The same motion, bit by bit, up to the verdict; then it falls on.
    assert np.array_equal(film.displacement[:known], leaning.run.displacement)
    # What is seen after the verdict is about as fast as a fall: it speeds up.
    speed = np.diff(np.linalg.norm(film.since_release[:, 1], axis=1))
    assert speed[-1] > 2 * speed[known - 2]


def test_loads_act_in_the_film_too():
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="foot")]
    blocks += [box((0, 0, 1), (1, 1, 2), name="head")]
    tower = Assembly.from_blocks(blocks, supports=["ground"])
    loads = [Removal("foot")]
    verdict = verify(tower, loads=loads)
    assert np.isfinite(past_verdict(verdict, 0.2, loads=loads).removed[1])


def test_the_film_of_joints_that_were_given_has_their_friction():
    """A block on a slope of 1 : 2 rests by the friction of the blocks, and slides by that of its joint."""
    blocks = [box((-1, -1, -1), (3, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 0.5), name="block")]
    slope = Assembly.from_blocks(blocks, supports=["ground"], friction=0.7, gravity=(4, 0, -8))
    faces = find_interfaces(slope)
    smooth = replace(faces, friction=np.full(faces.n_interfaces, 0.1))
    verdict = verify(slope, interfaces=smooth)
    assert verdict.outcome.word == "falls"
    after = past_verdict(verdict, 0.2, interfaces=smooth)
    # Along the slope it gains (4 - .1 x 8) m/s2.
    assert after.since_release[-1, 1, 0] == pytest.approx(1.6 * after.times[-1] ** 2, rel=0.1)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_a_film_of_no_length_is_refused(leaning, seconds):
    with pytest.raises(InputError, match=r"^film: .*(positive|finite) number"):
        past_verdict(leaning, seconds)


def test_a_gif_has_the_length_of_the_run_and_shows_motion(leaning, tmp_path):
    from PIL import Image

    film = past_verdict(leaning, 0.4)
    with Image.open(write_run(film, tmp_path / "fall.gif")) as picture:
        shown = []
        for frame in range(picture.n_frames):
            picture.seek(frame)
            shown.append(np.asarray(picture.convert("L"), dtype=float))
        assert picture.n_frames == pytest.approx(25 * film.times[-1], abs=2)
    assert max(picture.size) == pytest.approx(600, abs=20)
    assert abs(shown[-1] - shown[0]).mean() > 1.0
    assert [path.name for path in tmp_path.iterdir()] == ["fall.gif"]


def test_an_mp4_without_its_package_says_what_to_install(leaning, tmp_path):
    try:
        import imageio_ffmpeg  # noqa: F401
    except ImportError:
        with pytest.raises(InputError, match="pip install imageio-ffmpeg"):
            write_run(leaning.run, tmp_path / "fall.mp4")
        assert not list(tmp_path.iterdir())
    else:
        assert write_run(leaning.run, tmp_path / "fall.mp4").stat().st_size > 1000


def test_what_falls_past_its_supports_comes_to_lie_on_a_floor(leaning):
    film = past_verdict(leaning, 4.0)
    assembly = film.assembly
    corners = assembly.block_vertices(1) - assembly.centroid[1]
    low = (corners @ film.rotation[-1, 1].T)[:, 2].min() + assembly.centroid[1, 2] + film.displacement[-1, 1, 2]
    # The ground is 1 m deep, and the floor lies below it by the threshold.
    assert low == pytest.approx(-1.0 - leaning.brick_threshold - leaning.settling, abs=0.01)
    assert film.kinetic[-1] < 1e-3 * film.kinetic.max()


def test_the_film_of_a_verdict_is_of_its_joints(tmp_path):
    """Over a slit of 6 mm a pillar that no joint holds falls through the slit; one with a joint has it closed."""
    slit, fall = 6e-3, {}
    blocks = [box((-1, -1, -1), (0.2, 2, 0), name="ground"), box((0, 0, slit), (0.5, 0.5, 2), name="pillar")]
    pillar = Assembly.from_blocks(blocks, supports=["ground"])
    file = write(pillar, tmp_path / "pillar.json")
    for gap in (1e-3, 1e-2):
        verdict = verify(pillar, gap=gap)
        arguments = ["verify", file, "--gap", gap, "--film", 0.1, "-o", tmp_path / "run.npz"]
        app(list(map(str, arguments)), standalone_mode=False)
        film, known = read_run(tmp_path / "run.npz"), len(verdict.run.times)
        assert len(film.times) > known
        np.testing.assert_array_equal(film.displacement[:known], verdict.run.displacement.astype(np.float32))
        fall[gap] = -verdict.run.displacement[0, 1, 2]  # while settling
    assert fall[1e-3] == pytest.approx(slit, rel=0.1)
    assert fall[1e-2] < slit / 10
