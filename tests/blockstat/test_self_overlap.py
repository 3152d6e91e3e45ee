"""Blocks whose surface passes through itself are refused: their volume and centroid would count stone twice.

The criterion is the winding number of a closed surface: 1 in stone, 0 elsewhere. The depth of an overlap is the
diameter of the largest ball with another number.
"""

import json
import subprocess
import sys
import warnings
from itertools import combinations

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, assess, box, read, repair, write
from blockstat.contact.tolerance import GAP, THIN
from blockstat.geometry.polyhedron import merged_vertices
from blockstat.geometry.self_overlap import depth as measure

pytestmark = pytest.mark.filterwarnings("ignore::blockstat.InputWarning")


def joined(*shells, name="beam"):
    """Several shells as one object, as a join without a boolean union leaves them."""
    vertices, faces = [], []
    for shell in shells:
        faces += [[corner + len(vertices) for corner in face] for face in shell.faces]
        vertices += np.asarray(shell.vertices, dtype=float).tolist()
    return Block(vertices, faces, name=name)


def prism(outline, low=0.0, high=1.0, name="beam"):
    """A prism over an outline in x and z, from y = low to y = high; z up and x to the right, it runs clockwise."""
    n = len(outline)
    vertices = [(x, y, z) for y in (low, high) for x, z in outline]
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return Block(vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides], name=name)


def triangulated(block):
    return Block(block.vertices, [[f[0], *f[k : k + 2]] for f in block.faces for k in range(1, len(f) - 1)])


def moved(block, turn=None, by=(0.0, 0.0, 0.0), scale=1.0):
    place = scale * np.asarray(block.vertices, dtype=float)
    return Block((place if turn is None else place @ turn.T) + by, block.faces, name=block.name)


def found(block):
    """The self-overlap of a closed block, None without one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("blockstat.geometry.validity.self_overlaps", lambda *_: [])
        assembly = Assembly.from_blocks([block])
    overlaps = measure.self_overlaps(assembly, merged_vertices(assembly), np.array([0]))
    return overlaps[0] if overlaps else None


def turn_of(seed):
    q = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


SUPPORTS = [box((-2, -2, -0.3), (4, 3, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")]
WEST, EAST = box((0, 0, 1), (1.2, 1, 1.5)), box((0.1, 0, 1), (2.2, 1, 1.5))
HALF, REST = box((0, 0, 1), (1, 1, 1.5)), box((1, 0, 1), (2.2, 1, 1.5))
STAR = [(np.sin(a), np.cos(a)) for a in 4 * np.pi / 5 * np.arange(5)]
SWAPPED = box((0, 0, 1), (2, 1, 1.5))
SWAPPED = Block(np.asarray(SWAPPED.vertices)[[0, 1, 2, 3, 5, 4, 6, 7]], SWAPPED.faces, name="beam")
LID = box((0, 0, 1), (2.2, 1, 1.5))
DENT = Block(
    [*LID.vertices, (1.6, 0.5, 0.6)],
    [f for f in LID.faces if min(np.asarray(LID.vertices)[list(f), 2]) < 1.5]
    + [[a, b, 8] for f in LID.faces if min(np.asarray(LID.vertices)[list(f), 2]) == 1.5
       for a, b in zip(f, [*f[1:], f[0]], strict=True)],
    name="beam",
)  # fmt: skip

#: Block, diameter of the largest ball with a wrong number [m], and that number.
OVERLAPPING = {
    "two solids": (joined(WEST, EAST), 0.5, 2),
    "a copy": (joined(HALF, HALF, REST), 0.5, 2),
    "a copy cut into triangles": (joined(HALF, triangulated(HALF), REST), 0.5, 2),
    "a copy 1 um away": (joined(HALF, moved(HALF, by=(1e-6, 1e-6, 1e-6)), REST), 0.5, 2),
    "three solids": (joined(WEST, EAST, box((0.5, 0.2, 1.1), (0.9, 1.5, 1.4))), None, None),
    "partly nested": (joined(LID, box((0, 0, 1), (0.9, 0.9, 1.4))), 0.4, 2),
    "a cross": (joined(box((0, 0, 0), (3, 0.2, 0.2)), box((1, -1, 0.05), (1.3, 1, 0.15))), 0.1, 2),
    # The incircle of the inner pentagon has the radius cos 72.
    "a pentagram": (prism(STAR), 2 * np.cos(np.deg2rad(72)), 2),
    "an outline round twice": (
        prism([(0, 1), (0, 1.5), (1, 1.5), (1, 1), (0.05, 1), (0.05, 1.45), (0.95, 1.45), (0.95, 1)]), 0.45, 2
    ),
    # The small lobe has an area of 0.5, and the diameter of an incircle is four times the area over the perimeter.
    "a bow tie": (prism([(0, 0), (0, 3), (4, 0), (4, 1)]), 2 / (1 + 1.25 + np.sqrt(17) / 4), -1),
    "two corners exchanged": (SWAPPED, None, -1),
    "a dent deeper than the block": (DENT, None, -1),
}  # fmt: skip


@pytest.mark.parametrize("what", OVERLAPPING)
def test_stone_that_a_surface_encloses_twice_or_inside_out_is_measured(what):
    block, depth, times = OVERLAPPING[what]
    own = found(block)
    assert own is not None
    if depth is not None:
        assert own.depth == pytest.approx(depth, rel=0.02)
    if times is not None:
        assert own.times == times
    with pytest.raises(InputError, match=r'^block "beam": .* m near \(.*\)'):
        Assembly.from_blocks([block])


def test_the_messages_say_where_and_what_to_do():
    with pytest.raises(InputError) as error:
        Assembly.from_blocks([*SUPPORTS, joined(WEST, EAST)])
    text = str(error.value)
    assert 'block "beam": its solids overlap by 0.5 m near (' in text
    assert "join them with a boolean union, or give each a name of its own" in text
    with pytest.raises(InputError, match=r"its surface passes through itself and is inside out by .* m near \("):
        Assembly.from_blocks([OVERLAPPING["a bow tie"][0]])
    with pytest.raises(InputError, match=r"overlaps itself by 0\.618 m near \(.*goes round 2 times"):
        Assembly.from_blocks([OVERLAPPING["a pentagram"][0]])
    with pytest.raises(InputError) as error:
        Assembly.from_blocks([joined(WEST, EAST, name="one"), joined(WEST, EAST, name="two")])
    assert len(error.value.args) == 2


def test_a_beam_whose_centroid_is_beyond_its_support_falls_however_it_is_drawn(tmp_path):
    # Drawn as one solid, or as two that meet at x = 1: the centroid is at 1.1, the support ends at 1.
    for beam in (box((0, 0, 1), (2.2, 1, 1.5), name="beam"), joined(HALF, REST)):
        assembly = Assembly.from_blocks([*SUPPORTS, beam], supports=["ground"])
        assert assembly.volume[2] == pytest.approx(1.1)
        assert assembly.centroid[2, 0] == pytest.approx(1.1)
        assert assess(assembly).outcome.word == "unstable"
    # Two that overlap would weigh half as much again, with the centroid at (0.6 * 0.6 + 1.05 * 1.15) / 1.65 = 0.95.
    with pytest.raises(InputError, match=r"its solids overlap by 0\.5 m"):
        Assembly.from_blocks([*SUPPORTS, joined(WEST, EAST)], supports=["ground"])
    lines, first = [], 1
    for block in (*SUPPORTS, joined(WEST, EAST)):
        lines += [f"o {block.name}", *("v {} {} {}".format(*v) for v in np.asarray(block.vertices).tolist())]
        lines += ["f " + " ".join(str(corner + first) for corner in face) for face in block.faces]
        first += len(block.vertices)
    path = tmp_path / "joined.obj"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r'block "beam": its solids overlap by 0\.5 m'):
        read(path, supports=["ground"])
    with pytest.raises(InputError, match=r'block "beam": its solids overlap by 0\.5 m'):
        repair(path, supports=["ground"])


@pytest.mark.parametrize("command", ["check", "limit"])
def test_the_command_line_refuses_them_too(tmp_path, command):
    whole = Assembly.from_blocks([*SUPPORTS, box((0, 0, 1), (2.2, 1, 1.5), name="beam")], supports=["ground"])
    write(whole, tmp_path / "whole.json")
    data = json.loads((tmp_path / "whole.json").read_text())
    beam = next(own for own in data["blocks"] if own["name"] == "beam")
    two = joined(WEST, EAST)
    beam["vertices"], beam["faces"] = np.asarray(two.vertices).tolist(), [list(map(int, face)) for face in two.faces]
    (tmp_path / "joined.json").write_text(json.dumps(data))
    load = ["--load", "1,0,0"] if command == "limit" else []
    code = "from blockstat.cli.commands import main; main()"
    call = [sys.executable, "-c", code, command, str(tmp_path / "joined.json"), *load]
    answer = subprocess.run(call, capture_output=True, text=True, check=False)
    assert answer.returncode == 2
    assert "its solids overlap by 0.5 m near (" in answer.stderr


@pytest.mark.parametrize("what", ["two solids", "a copy cut into triangles", "a pentagram", "a bow tie"])
@pytest.mark.parametrize("seed", range(3))
def test_depth_does_not_depend_on_the_frame_the_unit_or_the_order(what, seed):
    block = OVERLAPPING[what][0]
    one, rng, turn = found(block), np.random.default_rng(seed), turn_of(seed)
    by = np.array([512_345.25, 5_403_210.5, 120.75])
    there = found(moved(block, turn, by))
    assert there is not None
    assert there.depth == pytest.approx(one.depth, rel=0.03)
    assert there.times == one.times
    small = found(moved(block, turn, scale=1e-3))
    assert small is not None
    assert small.depth == pytest.approx(1e-3 * one.depth, rel=0.03)
    flipped = Block(np.asarray(block.vertices) * [1, -1, 1], [list(f)[::-1] for f in block.faces])
    assert found(flipped).depth == pytest.approx(one.depth, rel=0.03)
    order = rng.permutation(len(block.vertices))
    place = np.argsort(order)
    faces = [np.roll(place[list(block.faces[k])], rng.integers(9)).tolist() for k in rng.permutation(len(block.faces))]
    assert found(Block(np.asarray(block.vertices)[order], faces)).depth == pytest.approx(one.depth, rel=0.03)


def slit():
    """A cube with a cut of no width from its middle to one side."""
    outline = [(0, 0), (0, 1), (1, 1), (1, 0.5), (0.5, 0.5), (1, 0.5), (1, 0)]
    return prism(outline)


def fan_of_an_angle():
    """An angle whose concave faces are fans about a corner from which one triangle looks the other way."""
    outline = [(0, 0), (0, 2), (1, 2), (1, 1), (2, 1), (2, 0)]
    return triangulated(prism(outline[2:] + outline[:2]))


SPIKE = Block([(0, 0, 0), (1, 0, 1), (0, 1, 1), (-1, -1, 1)], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
VOID = Block(box((1, 1, 1), (2, 2, 2)).vertices, [list(f)[::-1] for f in box((1, 1, 1), (2, 2, 2)).faces])
ACCEPTED = {
    "side by side": joined(HALF, REST),
    "a small one on a large one": joined(box((0, 0, 0), (2, 2, 1)), box((0.5, 0.3, 1), (1, 0.8, 2))),
    "turned on a large one": joined(
        box((-2, -2, 0), (2, 2, 1)),
        moved(box((0, 0, 1), (1, 1, 2)), np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])),
    ),
    "apart": joined(HALF, moved(REST, by=(0.5, 0, 0))),
    "edge along edge": joined(box((0, 0, 0), (1, 1, 1)), box((1, 0, 1), (2, 1, 2))),
    "corner at corner": joined(box((0, 0, 0), (1, 1, 1)), box((1, 1, 1), (2, 2, 2))),
    "corner on a face": joined(box((-2, -2, -1), (2, 2, 0)), SPIKE),
    "a void": joined(box((0, 0, 0), (3, 3, 3)), VOID),
    "a slit": slit(),
    "an angle": prism([(0, 0), (0, 2), (1, 2), (1, 1), (2, 1), (2, 0)]),
    "an angle of fans": fan_of_an_angle(),
    "a warped bed": Block(np.asarray(LID.vertices) + [[0, 0, 0.05 * (k == 3)] for k in range(8)], LID.faces),
    "overlap of a thousandth": joined(HALF, moved(REST, by=(-1e-3, 0, 0))),
}  # fmt: skip


@pytest.mark.parametrize("what", ACCEPTED)
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_shells_that_touch_voids_slits_and_notches_are_accepted(what, seed):
    block = ACCEPTED[what]
    block = moved(block, None if seed is None else turn_of(seed), (0, 0, 0) if seed != 1 else (4e5, 5e6, 100.0))
    assert found(block) is None
    Assembly.from_blocks([block])


@pytest.mark.parametrize("seed", range(60))
def test_two_boxes_as_one_block_are_refused_exactly_if_they_overlap_by_more_than_a_joint_may(seed):
    rng = np.random.default_rng(seed)
    side = rng.uniform(0.3, 1.5, (2, 3))
    # Their boxes overlap by a depth along one axis that is about the tolerance, and along the others by much.
    low = np.zeros((2, 3))
    low[1] = rng.uniform(-0.2, 0.2, 3)
    axis, deep = rng.integers(3), 10 ** rng.uniform(-3, -1)
    low[1, axis] = side[0, axis] - deep
    high = low + side
    block = joined(*(box(a, b) for a, b in zip(low, high, strict=True)))
    common = (high.min(axis=0) - low.max(axis=0)).min()
    volume = side.prod(axis=1).sum()
    surface = 2 * sum(side[:, i] @ side[:, j] for i, j in combinations(range(3), 2))
    allowed = min(GAP * np.cbrt(volume), THIN * 2 * volume / surface)
    own = found(moved(block, turn_of(seed)))
    if common > allowed:
        assert own is not None
        assert own.depth == pytest.approx(common, rel=1e-6)
    else:
        assert own is None
        # What is accepted is wrong by no more than the depth over half the surface.
        twice = np.maximum(high.min(axis=0) - low.max(axis=0), 0).prod()
        assert twice <= allowed * surface / 2


def test_both_outcomes_occur_among_the_random_boxes():
    depths = [10 ** np.random.default_rng(seed).uniform(-3, -1) for seed in range(60)]
    assert min(depths) < 0.002
    assert max(depths) > 0.05


def sphere(n, rough, seed):
    """A ball of 2 n**2 triangles or so whose corners are off by a random share of the radius."""
    rng = np.random.default_rng(seed)
    around, up = 2 * np.pi * np.arange(2 * n) / (2 * n), np.pi * np.arange(1, n) / n
    ring = np.array([(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)) for t in up for p in around])
    place = np.vstack([[0, 0, 1], ring, [0, 0, -1]])
    place *= 1 + rough * rng.standard_normal((len(place), 1))
    at, last = lambda i, k: 1 + i * 2 * n + k % (2 * n), len(place) - 1
    faces = [[0, at(0, k), at(0, k + 1)] for k in range(2 * n)]
    faces += [[last, at(n - 2, k + 1), at(n - 2, k)] for k in range(2 * n)]
    for i, k in np.ndindex(n - 2, 2 * n):
        faces += [[at(i, k), at(i + 1, k), at(i + 1, k + 1)], [at(i, k), at(i + 1, k + 1), at(i, k + 1)]]
    return Block(place, faces)


@pytest.mark.parametrize("rough", [0.0, 0.02, 0.05])
def test_rough_stones_are_accepted_and_two_of_them_in_one_block_are_not(rough):
    stone = sphere(8, rough, 1)
    assert found(stone) is None
    other = moved(sphere(8, rough, 2), by=(1.5, 0.1, 0.2))
    own = found(joined(stone, other))
    # Two unit balls whose centres are d apart share a lens of the thickness 2 - d.
    assert own.depth == pytest.approx(2 - np.linalg.norm([1.5, 0.1, 0.2]), abs=0.1 + 2 * rough)
    # Beside each other, with corners that meet by chance only.
    assert found(joined(stone, moved(other, by=(0.8, 0, 0)))) is None


def test_the_tolerance_is_that_of_overlaps_between_blocks():
    assert measure.ALLOWED == GAP
    assert measure.SHARE == THIN


def test_a_solid_in_a_solid_is_told_by_the_way_it_looks():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(InputError, match="one of its surfaces looks the wrong way"):
            Assembly.from_blocks([joined(LID, box((0.1, 0.1, 1.1), (0.9, 0.9, 1.4)))])
