"""Irregular stones: traced dry walls and a mortared wall (see rubble/README.md beside the cases), and curved joints.

Expected: the pairs of contacts.json, measured on the outlines with shapely; 6.56 mm as the smallest gap between two
stones of the mortared wall, measured there by other code. The walls have no known verdict.
"""

import itertools
import json

import numpy as np
import pytest
import shapely

from blockstat import Assembly, Block, assess, find_interfaces, limit_load, read
from blockstat.surface.distance import smallest_gap
from evidence.comparisons import rubble

WALLS = ["thangavelu_noise10", "thangavelu_noise40", "thangavelu_noise70"]
MM = 1e-3


@pytest.fixture
def folder(cases):
    if not (cases / "rubble").is_dir():
        pytest.skip("no directory of irregular stones")
    return cases / "rubble"


def moved(assembly, rng, *, rotation=None, offset=(0, 0, 0)):
    """The same blocks in another order and, with their gravity, in another place."""
    rotation = np.eye(3) if rotation is None else rotation
    order = rng.permutation(assembly.n_blocks)
    return Assembly.from_blocks(
        [
            Block(assembly.block_vertices(i) @ rotation.T + offset, assembly.faces_of(i), name=assembly.names[i])
            for i in order
        ],
        supports=[assembly.names[i] for i in np.flatnonzero(assembly.support)],
        density=float(assembly.density[0]), friction=assembly.friction, gravity=rotation @ assembly.gravity,
    )  # fmt: skip


def test_all_measured_pairs_are_found_at_two_millimetres(folder):
    rows = rubble.compared("2 mm", folder)
    faces, others = [r for r in rows if r.faces], [r for r in rows if not r.faces]
    assert (len(faces), len(others)) == (105, 51)
    assert [row for row in faces if row.found != "contact"] == []
    assert sum(row.found != "" for row in others) >= 0.95 * len(others)
    # Without a normal are only corners that are next to each other, within the gap along and across a side: edges along
    # edges of the stones.
    outlines = {name: outlines_of(read(folder / f"{name}.json")) for name in WALLS}
    for row in others:
        if row.found != "contact":
            ends = [shapely.MultiPoint(outlines[row.wall][name].exterior.coords) for name in (row.a, row.b)]
            assert ends[0].distance(ends[1]) <= np.sqrt(2) * 2 * MM


def outlines_of(wall):
    """Outlines in the plane of the wall: the stones are prisms along y, their corners of one end come first."""
    return {
        name: shapely.Polygon(shapely.MultiPoint(wall.block_vertices(i)[:, [0, 2]]).convex_hull)
        if name == "ground"
        else shapely.Polygon(wall.block_vertices(i)[: np.diff(wall.vertex_start)[i] // 2][:, [0, 2]])
        for i, name in enumerate(wall.names)
    }


@pytest.mark.parametrize("wall", WALLS)
def test_contacts_lie_on_both_outlines(folder, wall):
    assembly = read(folder / f"{wall}.json")
    outlines = outlines_of(assembly)
    found = find_interfaces(assembly, gap="2 mm")
    for point, k in zip(found.point, found.point_interface, strict=True):
        for block in found.pair[k]:
            side = outlines[assembly.names[block]].exterior
            # Half the gap, and what a face that is flat to a quarter of the gap may leave its plane.
            assert side.distance(shapely.Point(point[0], point[2])) <= 1.0 * MM + 0.5 * MM + 1e-9


@pytest.mark.parametrize("wall", WALLS)
def test_the_verdict_on_a_rough_wall_does_not_depend_on_order_or_place(folder, wall):
    assembly, rng = read(folder / f"{wall}.json"), np.random.default_rng(7)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    first = assess(assembly, gap="2 mm")
    for other in (
        moved(assembly, rng),
        moved(assembly, rng),
        moved(assembly, rng, rotation=turn),
        moved(assembly, rng, offset=(512_345.0, 5_412_345.0, 312.0)),
    ):
        verdict = assess(other, gap="2 mm")
        assert verdict.outcome is first.outcome
        assert verdict.score == pytest.approx(first.score, abs=1e-6)


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("gap", [0.01, 0.05, "1 mm", "2 mm", "3 mm"])
def test_a_verdict_on_joints_that_a_tolerance_made_says_so(folder, wall, gap):
    verdict = assess(read(folder / f"{wall}.json"), gap=gap)
    words = {"stable": "do not quite close", "unstable": "a larger tolerance may change the answer"}
    assert verdict.outcome.word == "undecided" or any(words[verdict.outcome.word] in text for text in verdict.warnings)


def mortared_outlines(folder):
    """Outlines of the mortared wall: its blocks are prisms along z with the same ends, as far apart as these."""
    data = json.loads((folder / "oneleaf39.json").read_text())
    outlines = {}
    for block in data["blocks"]:
        vertices = np.array(block["vertices"])
        ends = [shapely.Polygon(vertices[face][:, :2]) for face in block["faces"] if np.ptp(vertices[face][:, 2]) == 0]
        outlines[block["name"]] = shapely.union_all([end for end in ends if end.area > 0], grid_size=1e-9)
    return outlines


def least_distance(outlines):
    return min(a.distance(b) for a, b in itertools.combinations(outlines, 2))


def test_a_mortared_wall_is_told_its_gaps_at_once(folder):
    wall = read(folder / "oneleaf39.json")
    outlines = mortared_outlines(folder)
    ground = outlines.pop("ground")
    to_support = min(outline.distance(ground) for outline in outlines.values())
    stones = np.array([i for i, name in enumerate(wall.names) if name.startswith("stone")])
    gap, a, b = smallest_gap(wall, stones, stones)
    assert gap == pytest.approx(6.56 * MM, abs=0.005 * MM)
    assert {a, b} <= set(stones.tolist())
    verdict = assess(wall)
    assert verdict.outcome.word == "unstable"
    told = next(text for text in verdict.warnings if text.startswith("no two blocks touch"))
    # The beam is nearer to its stones than they are to each other, and the ground nearer still.
    assert to_support < least_distance(outlines.values()) < gap
    assert f"is {least_distance(outlines.values()):.3g} m" in told
    assert f"{to_support:.3g} m to a support" in told
    assert not find_interfaces(wall, gap=f"{to_support / MM - 0.01} mm").n_interfaces
    assert find_interfaces(wall, gap=f"{to_support / MM + 0.01} mm").n_interfaces


def test_the_nearest_corners_of_the_mortared_wall_are_no_nearer_than_its_gap(folder):
    stones = [outline for name, outline in mortared_outlines(folder).items() if name.startswith("stone")]
    assert least_distance(stones) == pytest.approx(6.56 * MM, abs=0.005 * MM)


def arc(n, low, high):
    angle = np.deg2rad(np.linspace(low, high, n + 1))
    return np.column_stack([np.cos(angle), np.sin(angle)]).tolist()


def prism(outline, depth):
    n = len(outline)
    vertices = [(x, y, z) for y in (0.0, depth) for x, z in outline]
    sides = [[(i + 1) % n, i, i + n, (i + 1) % n + n] for i in range(n)]
    return Block(vertices, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides])


def trough(n, m, low=240, high=300):
    """A stone whose round side of m facets lies in a trough of n facets, on a cylinder of radius 1 m."""
    side, z = arc(n, low, high), float(np.sin(np.deg2rad(high)))
    bed = prism([(-1.2, -1.3), (1.2, -1.3), (1.2, z), *side[::-1], (-1.2, z)], 0.5)
    return Assembly.from_blocks([bed, prism(arc(m, low, high), 0.5)], supports=[0], friction=0.5)


@pytest.mark.parametrize(("n", "m", "gap"), [(7, 5, "10 mm"), (4, 6, "10 mm"), (11, 13, 0.01), (40, 23, "2 mm")])
def test_a_curved_joint_cut_differently_on_its_two_sides_is_one_joint(n, m, gap):
    assembly = trough(n, m)
    found = find_interfaces(assembly, gap=gap)
    assert found.area.sum() == pytest.approx(np.deg2rad(60) * 0.5, rel=2e-3)
    # It covers the whole arc without a hole: no reason to drop a part of it.
    assert found.dropped == ()
    assert assess(assembly, gap=gap).outcome.word == "stable"
    # The coarser a cut, the better its facets hold the stone: the limit load is between those of two cuts that agree.
    finest, coarsest = (limit_load(trough(k, k), (1, 0, 0)).upper for k in (100, min(n, m)))
    load = limit_load(assembly, (1, 0, 0), gap=gap)
    assert 0.99 * finest <= load.lower <= load.upper <= 1.01 * coarsest
