"""What a run keeps, and the files it is written to."""

import json
import struct
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import InputError, write
from dynsim import Pulse, Removal, Settings, read_run, simulate, verify, write_run
from dynsim.view.film import film_strip
from evidence.scenes.small import arch, assembly, box, running_bond, stack

DOWN = (0, 0, -9.81)


@pytest.fixture(scope="module")
def falling():
    asm = arch(9, 0.2, gravity=DOWN, metadata={"architect": "nobody"})
    far = Settings(brick_threshold=1.0, roof_threshold=1.0)
    return verify(asm, loads=[Removal("voussoir4", 0.1)], settings=far).run


def test_contact_forces_carry_the_weight():
    run = simulate(running_bond(6, 4, gravity=DOWN))
    asm, weight = run.assembly, run.assembly.free_weight
    np.testing.assert_allclose(run.contacts.on(0), [0, 0, -weight], atol=1e-3 * weight)
    for block in asm.free:
        own = asm.mass[block] * 9.81
        np.testing.assert_allclose(run.contacts.on(block), [0, 0, own], atol=1e-2 * own)
    between = run.contacts.between()
    assert all(a < b for a, b in between)
    down = sum(force for (a, b), force in between.items() if a == 0)
    np.testing.assert_allclose(down, [0, 0, weight], atol=1e-3 * weight)


@pytest.mark.parametrize("stepwise", [False, True])
def test_friction_has_the_right_sign(stepwise):
    asm = stack(1, 1.0, 0.5, gravity=(0.2, 0.1, -1))
    loads = [Pulse((1e-9, 0, 0), 1e-3, start=50.0)] if stepwise else []
    run = simulate(asm, loads=loads, settings=Settings(end=1.0))
    np.testing.assert_allclose(run.contacts.on(1), -asm.mass[1] * asm.gravity, atol=1e-3 * asm.mass[1])
    assert run.contacts.point[:, 2] == pytest.approx(0.0, abs=1e-3)


def test_an_arch_thrusts_within_its_exact_range():
    # t/R = .15, 15 voussoirs: thrust over weight between .174 and .228 from statics of the half arch.
    run = simulate(arch(15, 0.15))
    thrust = np.abs(run.contacts.on(0)[0]) / run.assembly.free_weight
    assert 0.17 < thrust < 0.23
    assert run.contacts.on(1)[0] / run.assembly.free_weight == pytest.approx(thrust, rel=0.02)


def test_energy_is_kept_in_free_fall_and_lost_at_rest():
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 1, 1))], gravity=DOWN)
    run = simulate(asm, settings=Settings(end=1.0))
    total = run.kinetic + run.potential
    assert run.kinetic[-1] > 100 * asm.mass[1] * 9.81 * 0.01
    # Bullet's semi-implicit steps are first order.
    np.testing.assert_allclose(total, total[0], atol=0.01 * run.kinetic[-1])
    assert simulate(stack(3, gravity=DOWN)).kinetic[-1] < 1e-9


def test_kinetic_energy_counts_rotation():
    # A block that starts to tip about its edge: kinetic energy = weight times the drop of its centre.
    asm = stack(1, 0.5, 2.0, gravity=(0.27 * 9.81, 0, -9.81), friction=5.0)
    run = simulate(asm, settings=Settings(end=2.0))
    late = run.kinetic > 0.05 * run.kinetic.max()
    np.testing.assert_allclose(run.kinetic[late], (run.potential[0] - run.potential)[late], rtol=0.05)


def test_npz_there_and_back(falling, tmp_path):
    back = read_run(write_run(falling, tmp_path / "run.npz"))
    size = falling.assembly.size.max()
    np.testing.assert_allclose(back.displacement, falling.displacement, atol=1e-6 * size)
    np.testing.assert_allclose(back.rotation, falling.rotation, atol=1e-6)
    for name in ("times", "kinetic", "removed", "initial_overlap", "process_seconds", "time_step", "pace"):
        np.testing.assert_array_equal(getattr(back, name), getattr(falling, name))
    for name in ("pairs", "point", "force"):
        np.testing.assert_array_equal(getattr(back.contacts, name), getattr(falling.contacts, name))
    one, two = falling.assembly, back.assembly
    np.testing.assert_array_equal(one.vertices, two.vertices)
    np.testing.assert_array_equal(one.support, two.support)
    assert (one.names, one.metadata, one.friction) == (two.names, two.metadata, two.friction)
    plain = falling.displacement.nbytes + falling.rotation.nbytes
    assert (tmp_path / "run.npz").stat().st_size < 0.5 * plain


def glb(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    content, binary = json.loads(data[20 : 20 + length]), data[28 + length :]

    def array(index):
        accessor = content["accessors"][index]
        view = content["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view["byteOffset"] + accessor["byteOffset"]
        return np.frombuffer(binary, "<f4", accessor["count"] * width, start).reshape(-1, width)

    return content, array


def test_glb_opens_and_goes_where_the_blocks_went(falling, tmp_path):
    import trimesh

    path = write_run(falling, tmp_path / "run.glb")
    scene = trimesh.load(path)
    assert len(scene.geometry) == falling.assembly.n_blocks
    content, array = glb(path)
    animation = content["animations"][0]
    channels = {
        (content["nodes"][c["target"]["node"]]["name"], c["target"]["path"]): animation["samplers"][c["sampler"]]
        for c in animation["channels"]
    }
    name = "voussoir5"
    block = falling.assembly.names.index(name)
    path_of, turn_of = channels[name, "translation"], channels[name, "rotation"]
    times = array(path_of["input"])[:, 0]
    np.testing.assert_allclose(times[-1], falling.times[-1], rtol=1e-6)
    place = falling.assembly.centroid[block] + falling.displacement[-1, block]
    np.testing.assert_allclose(array(path_of["output"])[-1], place, atol=1e-5)
    turned = Rotation.from_quat(array(turn_of["output"])).as_matrix()
    np.testing.assert_allclose(turned[-1], falling.rotation[-1, block], atol=1e-5)
    # Neighbouring keys never go the long way round.
    quaternion = array(turn_of["output"])
    assert (np.einsum("ti,ti->t", quaternion[1:], quaternion[:-1]) > 0).all()
    scale = channels["voussoir4", "scale"]
    assert scale["interpolation"] == "STEP"
    np.testing.assert_allclose(array(scale["input"])[:, 0], [0, falling.removed[6], falling.times[-1]], rtol=1e-6)
    np.testing.assert_array_equal(array(scale["output"]), [[1, 1, 1], [0, 0, 0], [0, 0, 0]])
    assert [key for key in channels if key[1] == "scale"] == [("voussoir4", "scale")]


def test_a_still_run_has_no_channels_to_trouble_viewers(tmp_path):
    run = simulate(stack(1), settings=Settings(end=1.0))
    content, _ = glb(write_run(run, tmp_path / "still.glb"))
    for animation in content.get("animations", []):
        assert animation["channels"]


def test_film_strips(falling, tmp_path):
    from matplotlib.image import imread

    three = imread(film_strip(falling, tmp_path / "three.png", frames=3))
    five = imread(write_run(falling, tmp_path / "five.png"))
    assert five.shape[1] > 1.4 * three.shape[1]
    # What has moved is dark red; the scale beside the picture always has some of it.
    width = five.shape[1] // 6
    red = (five[..., 0] > 0.3) & (five[..., 1] < 0.2)
    assert not red[:, :width].any()
    assert red[:, 4 * width : 5 * width].sum() > 100
    assert film_strip(falling, tmp_path / "strip.svg").read_text().startswith("<?xml")


def test_a_film_strip_shows_foundations_whole_and_cuts_a_slab(tmp_path):
    # The view is level, along y: a post of 1 x 4 on a foundation of 2 x 1, or on a slab of 40 x 1.
    from dynsim.view.film import MARGIN, _window

    for half, depth in ((1.0, 1.0), (20.0, 0.0)):
        blocks = [box((-half, -1, -1), (half, 1, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 4))]
        run = simulate(assembly(blocks, gravity=DOWN), settings=Settings(end=0.5))
        lower, upper = _window(run, np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), np.array([0]))
        assert lower[1] == pytest.approx(-depth - MARGIN * 4.0, abs=1e-3)
        assert upper[1] == pytest.approx(4.0 + MARGIN * 4.0, abs=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run, d: write_run(run, d / "run.avi"), r'cannot write "\.avi"; a run is written as: \.glb, \.npz'),
        (lambda run, d: write_run(run, d / "no" / "run.glb"), "no such directory"),
        (lambda run, d: film_strip(run, d / "x.png", frames=0), "frames is 0"),
        (lambda run, d: film_strip(run, d / "x.png", times=[-1.0]), "must lie between 0 and"),
        (lambda run, d: read_run(d / "gone.npz"), r"gone\.npz: No such file"),
        (lambda run, d: read_run(d / "text.npz"), "not an NPZ file"),
        (lambda run, d: read_run(d / "other.npz"), "not a run of this version"),
    ],
)
def test_bad_files(falling, tmp_path, call, message):
    (tmp_path / "text.npz").write_text("hello")
    np.savez(tmp_path / "other.npz", a=1)
    with pytest.raises(InputError, match=message):
        call(falling, tmp_path)


def test_a_damaged_file_is_no_run(tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(b"")
    with pytest.raises(InputError, match="not an NPZ file"):
        read_run(path)
    np.savez_compressed(path, values=np.random.default_rng(0).integers(9, size=4000))
    whole = path.read_bytes()
    for at in range(60, len(whole) - 200, 50):  # in the data of the array
        path.write_bytes(whole[:at] + b"\xff" * 8 + whole[at + 8 :])
        with pytest.raises(InputError, match=r"not an? "):
            read_run(path)


def command(*arguments):
    code = "from dynsim.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_loads_and_files_on_the_command_line(tmp_path):
    path = write(stack(1, 0.5, 2.0, gravity=DOWN), tmp_path / "stack.json")
    motion = tmp_path / "motion.csv"
    motion.write_text("t,a\n" + "\n".join(f"{0.01 * i},{5.0}" for i in range(60)))
    answer = command("shake", path, "--record", motion, "--json", "-o", tmp_path / "run.npz")
    assert answer.returncode == 0, answer.stderr
    data = json.loads(answer.stdout)
    assert (data["verdict"], data["first_block"]) == ("falls", "stone0")
    assert read_run(data["output"]).displacement[-1, 1, 0] < -0.5
    weak = command("shake", path, "--record", motion, "--scale", "0.4", "--direction", "1,1,0", "--json")
    assert json.loads(weak.stdout)["verdict"] == "stands"
    motion.write_text("0,1\n0.1,oops\n")
    bad = command("shake", path, "--record", motion)
    assert bad.returncode == 2
    assert 'motion.csv, line 2: "oops" is not a finite number' in bad.stderr
    limit = json.loads(command("limit", path, "--load", "1,0,0", "--no-check", "--json").stdout)
    assert limit["lower"] == pytest.approx(0.25, rel=0.01)
    assert limit["runs"] == len(limit["trials"])


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--remove", "voussoir4@0.1"], "falls"),
        (["--settle", "right:0.02,0,0@0.05"], "stands"),
        (["--push", "voussoir4:0,0,-0.02@0.1"], "stands"),
        (["--tilt-to", "y,40,40"], "falls"),
    ],
)
def test_load_options(tmp_path, options, word):
    path = write(arch(9, 0.2, gravity=DOWN), tmp_path / "arch.json")
    answer = command("verify", path, *options, "--json")
    assert answer.returncode == 0, answer.stderr
    assert json.loads(answer.stdout)["verdict"] == word


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--remove", "key"], 'no block "key"'),
        (["--remove", "voussoir4@soon"], '--remove is "voussoir4@soon"; it must read NAME'),
        (["--settle", "right"], '--settle is "right"; it must read NAME'),
        (["--tilt-to", "w,3"], "AXIS one of x, y, z"),
        (["-o", "run.avi"], "a run is written as"),
    ],
)
def test_bad_load_options(tmp_path, options, message):
    path = write(arch(9, 0.2), tmp_path / "arch.json")
    answer = command("verify", path, *options)
    assert answer.returncode == 2
    assert message in answer.stderr
