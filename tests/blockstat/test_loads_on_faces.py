"""Loads on free faces, of fluids and of fill, against quadrature over faces that are cut here by other means."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
import shapely

from blockstat import (
    Assembly,
    Block,
    InputError,
    InputWarning,
    build,
    dispersed_load,
    fill_load,
    find_interfaces,
    fluid_pressure,
    limit_load,
    line_load,
    load_case,
    load_cases,
    moving_load,
    patch_load,
    scene_from,
    surface_load,
)
from blockstat.loading.faces import Face, integrated
from evidence.scenes.small import arch, assembly, box, prism

TILTED = np.array([0.4, -0.7, -3.0])
UP = -TILTED / np.linalg.norm(TILTED)
#: A wall with a battered face, a slanted top and a back that overhangs, in the plane x, z.
BATTERED = [(0.0, 0.0), (1.6, 0.1), (1.9, 2.2), (0.5, 3.1)]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def wall(**options):
    low = prism(BATTERED, 1.3, name="wall", group="dam.a")
    other = box((7, 0, 0), (8, 2, 3), name="other", group="dam.b")
    return Assembly.from_blocks([box((-1, -1, -9), (2, 2, -8), name="far"), low, other], supports=["far"], **options)


def integral(assembly, block, polygons, traction):
    """Force and moment about the centroid of a block, by products of Gauss points over fans of triangles."""
    found = np.zeros(6)
    s, weight = (NODES + 1) / 2, WEIGHTS / 2
    for polygon in polygons:
        for b, c in zip(polygon[1:-1], polygon[2:], strict=True):
            a = polygon[0]
            area = np.linalg.norm(np.cross(b - a, c - a))
            for u, wu in zip(s, weight, strict=True):
                for v, wv in zip(s, weight, strict=True):
                    point = a + u * (b - a) + u * v * (c - b)
                    force = area * u * wu * wv * traction(point)
                    found[:3] += force
                    found[3:] += np.cross(point - assembly.centroid[block], force)
    return found


def faces_of(assembly, block):
    """Corners and outward normal of each face of a convex block."""
    corners = assembly.block_vertices(block)
    for face in assembly.faces_of(block):
        polygon = corners[face]
        normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[1])
        yield polygon, normal / np.linalg.norm(normal)


def below(polygon, up, level):
    """The part of a convex polygon below a level, corner by corner."""
    kept = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        da, db = level - a @ up, level - b @ up
        if da >= 0:
            kept.append(a)
        if da * db < 0:
            kept.append(a + da / (da - db) * (b - a))
    return np.array(kept) if len(kept) > 2 else None


@pytest.mark.parametrize("gravity", [TILTED, np.array([0.0, 0.0, -9.81])])
@pytest.mark.parametrize("towards", [(-1, 0, 0), (0.9, -0.2, 0.1), (0, 0, 1)])
@pytest.mark.parametrize("level", [1.4, 2.6, 40.0])
def test_a_fluid_presses_normal_to_all_that_looks_into_it_below_its_level(gravity, towards, level):
    asm, up = wall(gravity=gravity), -gravity / np.linalg.norm(gravity)
    found = fluid_pressure(asm, level, 7.0, towards, coefficient=0.4, surcharge=3.0)
    assert not found[0].any()
    for block in (1, 2):
        expected = np.zeros(6)
        for polygon, normal in faces_of(asm, block):
            part = below(polygon, up, level)
            if normal @ towards > 1e-9 and part is not None:
                expected += integral(
                    asm, block, [part], lambda p, n=normal: -0.4 * (7.0 * (level - p @ up) + 3.0) * n
                )  # fmt: skip
        np.testing.assert_allclose(found[block], expected, rtol=1e-9, atol=1e-9 * np.abs(found).max())


def test_a_fluid_loads_the_blocks_or_the_group_that_it_is_given():
    asm = wall()
    whole = fluid_pressure(asm, 2.0, 7.0, (-1, 0, 0))
    for options, blocks in (({"group": "dam"}, [1, 2]), ({"group": "dam.b"}, [2]), ({"blocks": ["wall"]}, [1])):
        found = fluid_pressure(asm, 2.0, 7.0, (-1, 0, 0), **options)
        np.testing.assert_allclose(found[blocks], whole[blocks], rtol=1e-12, atol=1e-12)
        assert np.flatnonzero(found.any(axis=1)).tolist() == blocks
    plain = fluid_pressure(asm, 2.0, 7.0, (-1, 0, 0), blocks="other")[2]
    assert plain[0] == pytest.approx(7.0 * 2.0**2 / 2 * 2)


def test_a_fluid_that_reaches_no_face_is_refused():
    asm = wall()
    with pytest.raises(InputError, match=r"looks towards \[-1, 0, 0\] below the level -0\.5"):
        fluid_pressure(asm, -0.5, 7.0, (-1, 0, 0))
    assert fluid_pressure(asm, 1e-3, 7.0, (-1, 0, 0)).any()
    with pytest.raises(InputError, match="towards is zero; it must be a direction"):
        fluid_pressure(asm, 1.0, 7.0, (0, 0, 0))
    flat = Assembly.from_blocks([box((0, 0, 0), (1, 2, 3))])
    with pytest.raises(InputError, match="below the level 3"):  # a level face at the surface is dry
        fluid_pressure(flat, 3.0, 7.0, (0, 0, 1))
    assert fluid_pressure(flat, 3.0 + 1e-9, 7.0, (0, 0, 1))[0, 2] == pytest.approx(-7e-9 * 2, rel=1e-6)


def test_faces_along_the_direction_are_dry():
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 2, 3))])
    assert fluid_pressure(asm, 9.0, 1.0, (0.9e-2, 0, 1))[0, 0] == 0.0
    assert fluid_pressure(asm, 9.0, 1.0, (1.1e-2, 0, 1))[0, 0] < 0.0


def turned(asm, degrees):
    """Blocks turned in plan, and the directions along and across that x and y become."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    along, across = np.array([c, s, 0.0]), np.array([-s, c, 0.0])
    return asm.with_(vertices=asm.vertices @ np.stack([along, across, [0.0, 0.0, 1.0]])), along, across


def single(vertices):
    return vertices.astype(np.float32).astype(float)


@pytest.mark.parametrize("stored", [np.copy, single, lambda vertices: vertices.round(6)])
@pytest.mark.parametrize("towards", [(-np.cos(np.pi / 6), -0.5, 0.0), (-0.866, -0.5, 0.0)])
def test_water_presses_along_its_direction_however_that_and_the_coordinates_are_rounded(stored, towards):
    """gamma h2 / 2 a metre along, and nothing across."""
    dam, along, across = turned(Assembly.from_blocks([box((0, 0, 0), (1, 1, 3))]), 30)
    load = fluid_pressure(dam.with_(vertices=stored(dam.vertices)), 2.0, 9810.0, towards)[0, :3]
    assert load @ along == pytest.approx(9810 * 2.0**2 / 2, rel=1e-5)
    assert load @ across == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("stored", [np.copy, single, lambda vertices: vertices.round(6)])
def test_an_arch_however_its_coordinates_are_rounded_carries_the_fill_of_the_arch_along_the_axes(stored):
    ring = arch(21, 0.4)
    whole = fill_load(ring, 3.0, 18000.0)
    for degrees in range(0, 360, 30):
        there, along, across = turned(ring, degrees)
        there = there.with_(vertices=stored(there.vertices))
        np.testing.assert_allclose(fill_load(there, 3.0, 18000.0)[:, 2], whole[:, 2], rtol=1e-5, atol=1.0)
        place = 0.3 * along + 0.25 * across + [0, 0, 3.0]
        assert dispersed_load(there, place, 1000.0, spread=0.1)[:, 2].sum() == pytest.approx(-1000.0, rel=1e-9)


def test_what_rounding_leaves_of_a_covered_face_is_not_free():
    """A strip is free that is wider than a joint may be open: a hundredth of the smaller block, of 0.5 m here."""
    for width, free in ((0.0051, True), (0.0049, False)):
        top = 1 + 0.125 / (1 - width)
        low, high = box((0, 0, 0), (1, 1, 1), name="low"), box((width, 0, 1), (1, 1, top), name="high")
        load = surface_load(assembly([low, high], supports=[]), (0, 0, -1.0), (0, 0, 1))
        assert load[0, 2] == pytest.approx(-width * free, abs=1e-12)


def test_a_small_window_in_a_covered_face_is_free():
    slab = box((-10, -10, 0), (10, 10, 1), name="slab")
    around = [(-10, -10, 10, 0), (-10, 0.15, 10, 10), (-10, 0, 0, 0.15), (0.15, 0, 10, 0.15)]
    lids = [box((x0, y0, 1), (x1, y1, 2)) for x0, y0, x1, y1 in around]
    load = surface_load(assembly([slab, *lids], supports=[]), (0, 0, -1.0), (0, 0, 1), blocks=["slab"])
    assert load[0, 2] == pytest.approx(-(0.15**2))


def test_fill_around_a_post_lies_on_what_it_stands_on_and_on_the_post():
    """The top of the post lies above a hole in the free part of the slab, not above the slab."""
    slab, post = box((0, 0, 0), (4, 4, 1), name="slab"), box((1.5, 1.5, 1), (2.5, 2.5, 2), name="post")
    load = fill_load(assembly([slab, post], supports=[]), 3.0, 18.0)
    np.testing.assert_allclose(load[:, 2], [-18.0 * 15 * 2, -18.0])


@pytest.mark.parametrize(("name", "values"), [
    ("unit_weight", (0.0, -1.0, np.nan, "7", True)), ("level", (np.inf, None, True)), ("coefficient", (np.nan, "1")),
    ("surcharge", (np.inf, [1.0])),
])  # fmt: skip
def test_numbers_of_a_fluid_are_checked_by_name(name, values):
    asm = wall()
    given = {"level": 2.0, "unit_weight": 7.0, "towards": (-1, 0, 0)}
    words = {"unit_weight": "above 0( and finite)?", "level": "a finite number"}
    for value in values:
        allowed = words.get(name, "a number of at least 0")
        with pytest.raises(InputError, match=rf"^{name} is .*; it must be {allowed}$"):
            fluid_pressure(asm, **(given | {name: value}))
    assert fluid_pressure(asm, **given, coefficient=0.5, surcharge=0.0).any()


@pytest.mark.parametrize("gravity", [TILTED, np.array([0.0, 0.0, -9.81])])
@pytest.mark.parametrize("level", [2.3, 2.75, 50.0])
def test_fill_weighs_as_the_columns_above_the_faces(gravity, level):
    asm, up = wall(gravity=gravity), -gravity / np.linalg.norm(gravity)
    found = fill_load(asm, level, 18.0, blocks="wall")
    expected = np.zeros(6)
    for polygon, normal in faces_of(asm, 1):
        part = below(polygon, up, level)
        if normal @ up > 1e-9 and part is not None:
            expected += integral(
                asm, 1, [part], lambda p, n=normal: -18.0 * (level - p @ up) * (n @ up) * up
            )  # fmt: skip
    np.testing.assert_allclose(found[1], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    assert not found[[0, 2]].any()


def test_a_face_that_hardly_slopes_carries_all_of_the_fill_high_above_it():
    asm = Assembly.from_blocks([prism([(0, 0), (2, 0), (2, 1.002), (0, 1.0)], 1.5)])
    found = fill_load(asm, 400.0, 2.0)
    assert found[0, 2] == pytest.approx(-2.0 * (400.0 - 1.001) * 2 * 1.5, rel=1e-9)
    part = fill_load(asm, 1.0005, 2.0)[0]  # it covers a quarter of the face as a wedge
    assert part[2] == pytest.approx(-2.0 * 0.5 * 0.0005 * 0.5 * 1.5, rel=1e-6)


def test_fill_above_nothing_or_above_two_faces_is_refused():
    asm = assembly([box((0, 0, 0), (2, 1, 1), name="low"), box((0.5, 0, 3), (1.5, 1, 4), name="shelf")], supports=[])
    with pytest.raises(InputError, match=r"no free face of these blocks lies below the level 0.9"):
        fill_load(asm, 0.9, 1.0)
    with pytest.raises(InputError, match='free faces of "low" and "shelf" lie above each other'):
        fill_load(asm, 5.0, 1.0)
    small = [box((0, 0, 0), (0.2, 0.1, 0.1), name="low"), box((0.05, 0, 0.3), (0.15, 0.1, 0.4), name="shelf")]
    with pytest.raises(InputError, match='free faces of "low" and "shelf" lie above each other'):
        fill_load(assembly(small, supports=[]), 0.5, 1.0)
    assert fill_load(asm, 3.5, 1.0)[:, 2] == pytest.approx([-2.5 * 2, 0.0])  # the shelf is above the fill
    assert fill_load(asm, 5.0, 1.0, blocks="shelf")[:, 2] == pytest.approx([0.0, -1.0])
    beside = assembly([box((0, 0, 0), (2, 1, 1)), box((2, 0, 0), (3, 1, 2))], supports=[])
    assert fill_load(beside, 3.0, 1.0)[:, 2] == pytest.approx([-4.0, -1.0])
    with pytest.raises(InputError, match=r"unit_weight is 0\.0; it must be above 0"):
        fill_load(asm, 5.0, 0.0)
    with pytest.raises(InputError, match="level is nan"):
        fill_load(asm, np.nan, 1.0)


def slabs(**options):
    """Two slabs side by side along x whose tops lie 0.5 m apart, and a support below."""
    blocks = [
        box((-9, -9, -9), (9, 9, -8), name="far"), box((0, 0, 0), (3, 5, 1), name="high", group="deck.a"),
        box((3, 0, -1), (8, 4, 0.5), name="low", group="deck.b"),
    ]  # fmt: skip
    return assembly(blocks, **options)


@pytest.mark.parametrize(("point", "footprint", "spread"), [
    ((2.6, 1.7, 2.2), (0.7, 0.2), 0.5), ((3.3, 0.4, 1.9), (0.0, 0.0), 0.8), ((1.0, 4.5, 1.6), (0.3, 1.1), 0.0),
    ((3.0, 2.0, 1.4), (0.2, 0.6), 1.0), ((5.0, 2.0, 0.5), (0.4, 0.6), 1.0),
])  # fmt: skip
def test_a_load_spreads_over_the_rectangle_at_the_depth_of_the_face_below(point, footprint, spread):
    asm, (x, y, z) = slabs(), point
    tops = [1.0] * (0 <= x <= 3) + [0.5] * (3 <= x <= 8)
    sides = [side + 2 * spread * min(z - top for top in tops) for side in footprint]
    areas = {}
    for block, (x0, x1, y0, y1) in {1: (0, 3, 0, 5), 2: (3, 8, 0, 4)}.items():
        a, b = max(x0, x - sides[0] / 2), min(x1, x + sides[0] / 2)
        c, d = max(y0, y - sides[1] / 2), min(y1, y + sides[1] / 2)
        if a < b and c < d:
            areas[block] = (b - a) * (d - c), np.array([(a + b) / 2, (c + d) / 2, 1.0 if block == 1 else 0.5])
    expected = np.zeros((3, 6))
    for block, (area, middle) in areas.items():
        force = np.array([0, 0, -7.0 * area / sum(own for own, _ in areas.values())])
        expected[block] = [*force, *np.cross(middle - asm.centroid[block], force)]
    found = dispersed_load(asm, point, 7.0, spread=spread, footprint=footprint)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("gravity", [(-3, 0, 0), (3, 0, 0), (0, 2, 0), (0, -2, 0), TILTED, (-3, 0.3, -0.5)])
def test_a_spread_load_points_along_gravity_whatever_is_down(gravity):
    asm = assembly([box((0, 0, 0), (2, 3, 4), name="block")], supports=[], gravity=gravity)
    up = -np.array(gravity) / np.linalg.norm(gravity)
    point = asm.centroid[0] + 3.5 * up
    load = dispersed_load(asm, point, 5.0, spread=0.1, footprint=(0.1, 0.1))[0]
    np.testing.assert_allclose(load[:3], -5.0 * up, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(load[3:]), 0.0, atol=0.05)


def test_a_spread_load_on_a_slope_is_even_in_plan():
    asm = assembly([prism([(0, 0), (4, 0), (4, 3), (0, 1)], 2.0)], supports=[])
    load = dispersed_load(asm, (2.5, 1.2, 4.0), 6.0, spread=0.5, footprint=(0.1, 0.2))[0]
    side = np.array([0.1, 0.2]) + (4.0 - 2.25)
    x0, x1 = 2.5 - side[0] / 2, 2.5 + side[0] / 2
    y0, y1 = max(1.2 - side[1] / 2, 0), min(1.2 + side[1] / 2, 2)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2, 0])
    np.testing.assert_allclose(
        load, [0, 0, -6, *np.cross(middle - asm.centroid[0], (0, 0, -6))], rtol=1e-9, atol=1e-9
    )  # fmt: skip


def test_a_spread_load_beside_or_below_all_faces_is_refused():
    asm = slabs()
    options = {"spread": 0.5, "footprint": (0.1, 0.2)}
    for point in ((-1, 1, 2), (1, 6, 2), (1, 1, 0.9), (9, 1, 2)):
        with pytest.raises(InputError, match=r"no free face of these blocks lies below the point \["):
            dispersed_load(asm, point, 1.0, **options)
    assert dispersed_load(asm, (1, 1, 1.0), 1.0, **options)[1, 2] == pytest.approx(-1.0)
    assert dispersed_load(asm, (1, 1, 1.0 - 1e-7), 1.0, **options)[1, 2] == pytest.approx(-1.0)
    assert dispersed_load(asm, (5, 1, 0.9), 1.0, **options)[2, 2] == pytest.approx(-1.0)
    assert dispersed_load(asm, (2.9, 1, 2.0), 1.0, group="deck.a", **options)[:, 2] == pytest.approx([0, -1, 0])
    for footprint in ((0.0, 0.0), (0.1, 0.0), (0.1, -0.2)):
        with pytest.raises(InputError, match=r"the load at .* has an area of .* both must be above 0"):
            dispersed_load(asm, (1, 1, 1.0), 1.0, spread=0.5, footprint=footprint)
    for footprint in (0.1, (0.1, 0.1, 0.1), (0.1, np.inf), "ab"):
        with pytest.raises(InputError, match=r"footprint is .*; the two sides of the loaded area are needed"):
            dispersed_load(asm, (1, 1, 1.0), 1.0, spread=0.5, footprint=footprint)
    shelf = assembly([box((0, 0, 0), (2, 1, 1), name="low"), box((0, 0, 3), (2, 1, 4), name="shelf")], supports=[])
    with pytest.raises(InputError, match='free faces of "low" and "shelf" lie above each other'):
        dispersed_load(shelf, (1, 0.5, 5), 1.0, **options)
    for wrong, message in (
        ({"force": 0.0}, "force is 0.0; it must be above 0"),
        ({"spread": -0.1}, "spread is -0.1; it must be a number of at least 0"),
        ({"spread": np.nan}, "spread is nan; it must be a number of at least 0"),
        ({"point": (1, 2)}, "point is"),
    ):
        with pytest.raises(InputError, match=message):
            dispersed_load(asm, **({"point": (1, 1, 2), "force": 1.0} | options | wrong))


def test_a_spread_that_may_be_an_angle_is_doubted(recwarn):
    # tan 30 degrees is 1 / sqrt(3).
    asm = assembly([box((0, 0, 0), (4, 4, 1))], supports=[])
    told = "spread is 30; it is the tangent of an angle: 30 degrees are 0.577"
    for spread in (0.0, 0.5, 3.0):
        dispersed_load(asm, (2, 2, 2), 1.0, spread=spread, footprint=(0.1, 0.1))
    assert not recwarn
    with pytest.warns(InputWarning, match=f"^{told}$"):
        dispersed_load(asm, (2, 2, 2), 1.0, spread=30)
    truck = {"kind": "dispersed", "point": [2, 2, 2], "force": 1.0, "spread": 30}
    with pytest.warns(InputWarning, match=rf"^loads\.truck\.{told}$"):
        load_case(asm, "traffic", {"truck": truck}, {"traffic": {"live": {"truck": 1}}})


def leaning(degrees):
    """A block of which the upper right face looks so many degrees away from up."""
    angle = np.deg2rad(degrees)
    return assembly([prism([(0, 0), (3, 0), (1, 2 * np.tan(angle)), (0, 2 * np.tan(angle))], 1.0)], supports=[])


def test_faces_within_45_degrees_of_a_direction_are_loaded():
    for degrees, loaded in ((44.9, True), (45.0, True), (45.1, False)):
        load = surface_load(leaning(degrees), (0, 0, -2.0), (0, 0, 1))[0]
        slope = 2 / np.cos(np.deg2rad(degrees))
        assert load[2] == pytest.approx(-2.0 * (1.0 + loaded * slope), rel=1e-9)
    with pytest.raises(InputError, match=r"no free face of these blocks looks towards \[1\.0, -1\.0, -1\.0\]"):
        surface_load(leaning(40.0), (0, 0, 1), (1, -1, -1))
    np.testing.assert_array_equal(
        surface_load(leaning(40.0), (1, 2, 3), (0, 0, 9)), surface_load(leaning(40.0), (1, 2, 3), (0, 0, 1e-3))
    )  # fmt: skip


def test_a_joint_leaves_the_face_around_it_free():
    """A post off the middle of a slab: what is free is the slab less the foot, with the moments of both."""
    slab, post = box((0, 0, 0), (5, 4, 1), name="slab"), box((3, 1, 1), (4, 3, 2.5), name="post")
    asm = assembly([slab, post], supports=[])
    pressure = np.array([1.0, -2.0, -3.0])
    found = surface_load(asm, pressure, (0, 0, 1))
    whole, foot = 20.0 * pressure, 2.0 * pressure
    arms = np.array([2.5, 2.0, 1.0]), np.array([3.5, 2.0, 1.0])
    moment = sum(np.cross(arm - asm.centroid[0], f) for arm, f in zip(arms, (whole, -foot), strict=True))
    np.testing.assert_allclose(found[0], [*(whole - foot), *moment], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found[1, :3], 2.0 * pressure, rtol=1e-9)
    under = surface_load(asm, pressure, (0, 0, -1))
    np.testing.assert_allclose(under[:, :3], [whole, 0 * pressure], atol=1e-9)
    joints = find_interfaces(asm)
    np.testing.assert_array_equal(surface_load(asm, pressure, (0, 0, 1), interfaces=joints), found)
    bare = surface_load(asm, pressure, (0, 0, 1), interfaces=joints.subset(np.zeros(1, dtype=bool)))
    np.testing.assert_allclose(bare[0, :3], whole, rtol=1e-9)
    alone = surface_load(asm, pressure, (0, 0, 1), blocks="slab")
    np.testing.assert_array_equal(alone[0], found[0])
    assert not alone[1].any()


def test_a_joint_with_a_gap_covers_both_of_its_faces_and_no_other():
    for gap in (0.0, 0.002, -0.002):
        asm = assembly([box((0, 0, 0), (2, 1, 1)), box((0, 0, 1 + gap), (1.5, 1, 2))], supports=[])
        assert find_interfaces(asm).n_interfaces == 1
        up, down = (surface_load(asm, (0, 0, 1), (0, 0, way))[:, 2] for way in (1, -1))
        np.testing.assert_allclose(up, [0.5, 1.5], rtol=1e-9)
        np.testing.assert_allclose(down, [2.0, 0.0], atol=1e-9)


def test_a_patch_is_shared_by_the_blocks_that_it_lies_on():
    asm = assembly([box((0, 0, 0), (2, 3, 1), name="one"), box((2, 0, 0), (5, 3, 1), name="two")], supports=[])
    pressure = np.array([1.0, 2.0, -4.0])
    for corners in ([(1.5, 1, 1), (4, 1, 1), (4, 2, 1), (1.5, 2, 1)], [(4, 2, 1), (4, 1, 1), (1.5, 1, 1), (1.5, 2, 1)]):
        found = patch_load(asm, corners, pressure)
        for block, area, middle in ((0, 0.5, (1.75, 1.5, 1)), (1, 2.0, (3, 1.5, 1))):
            force = area * pressure
            expected = [*force, *np.cross(np.array(middle) - asm.centroid[block], force)]
            np.testing.assert_allclose(found[block], expected, rtol=1e-9, atol=1e-9)
    with pytest.raises(InputError, match=r"2 of 2\.5 m2 of the patch lie on free faces \(of two\); all of it must"):
        patch_load(asm, corners, pressure, blocks="two")


def test_a_patch_on_a_slope_has_its_own_area():
    asm = assembly([prism([(0, 0), (4, 0), (4, 3), (0, 1)], 2.0)], supports=[])
    corners = np.array([(1, 0.2, 1.5), (3, 0.2, 2.5), (3, 1.7, 2.5), (1, 1.7, 1.5)])
    force = 5**0.5 * 1.5 * np.array([0.5, 1, -2])
    expected = [*force, *np.cross(corners.mean(axis=0) - asm.centroid[0], force)]
    np.testing.assert_allclose(patch_load(asm, corners, (0.5, 1, -2))[0], expected, rtol=1e-9)
    triangle = patch_load(asm, corners[:3], (0.5, 1, -2))[0]
    np.testing.assert_allclose(triangle[:3], force / 2, rtol=1e-9)


def test_a_patch_off_its_face_or_of_no_shape_is_refused():
    asm = assembly([box((0, 0, 0), (2, 3, 1), name="one")], supports=[])
    corners = np.array([(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1.0)])
    ragged = [(0, 0, 1), (1, 0, 1), (1, 1)]
    for wrong in (corners[:2], corners[:, :2], corners.ravel(), np.where(corners == 1, np.nan, corners), ragged, "abc"):
        with pytest.raises(InputError, match="patch: a list of points of three finite numbers is needed, 3"):
            patch_load(asm, wrong, (0, 0, -1))
    for line in ([(0, 0, 1), (0.5, 0, 1), (1, 0, 1)], [(0, 0, 1), (1 / 3, 0.1, 1), (1, 0.3, 1)], [(1, 1, 1)] * 3):
        with pytest.raises(InputError, match="its corners lie on a line; they must enclose an area"):
            patch_load(asm, line, (0, 0, -1))
    with pytest.raises(InputError, match="its edges cross"):
        patch_load(asm, corners[[0, 2, 1, 3]], (0, 0, -1))
    size = asm.size[0]
    assert patch_load(asm, corners + [0, 0, 0.9e-6 * size], (0, 0, -1))[0, 2] == pytest.approx(-1.0)
    for shift in ([0, 0, 1.2e-6 * size], [0, 0, -1.2e-6 * size], [5, 0, 0]):
        with pytest.raises(InputError, match="0 of 1 m2 of the patch lie on free faces; all"):
            patch_load(asm, corners + shift, (0, 0, -1))
    assert patch_load(asm, corners - [0.9e-5, 0, 0], (0, 0, -1))[0, 2] == pytest.approx(-1.0, rel=2e-5)
    with pytest.raises(InputError, match=r"of 1 m2 of the patch lie on free faces \(of one\)"):
        patch_load(asm, corners - [1.2e-5, 0, 0], (0, 0, -1))


def test_a_patch_or_a_line_where_two_faces_lie_in_one_plane_counts_none_twice():
    asm = assembly([box((0, 0, 0), (2, 3, 1), name="low"), box((0, 0, 1), (2, 3, 2), name="top")], supports=[])
    bare = find_interfaces(asm).subset(np.zeros(1, dtype=bool))
    corners = [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    with pytest.raises(InputError, match=r"2 of 1 m2 of the patch lie on free faces \(of low, top\)"):
        patch_load(asm, corners, (0, 0, -1), interfaces=bare)
    line = line_load(asm, (0.5, 0.5, 1), (1.5, 2, 1), (0, 0, -2), interfaces=bare)
    assert line[:, 2].sum() == pytest.approx(-2 * np.hypot(1, 1.5))
    with pytest.raises(InputError, match="0 of 1 m2 of the patch"):
        patch_load(asm, corners, (0, 0, -1))


def test_a_line_is_shared_by_the_blocks_that_it_crosses():
    asm = assembly([box((0, 0, 0), (2, 3, 1), name="one"), box((2, 0, 0), (5, 3, 1), name="two")], supports=[])
    start, end, force = np.array([1.0, 0.5, 1]), np.array([4.0, 2.0, 1]), np.array([1.0, 2.0, -4.0])
    length = np.linalg.norm(end - start)
    for one, two in ((start, end), (end, start)):
        found = line_load(asm, one, two, force)
        for block, (low, high) in ((0, (0, 1 / 3)), (1, (1 / 3, 1))):
            middle, push = start + (low + high) / 2 * (end - start), (high - low) * length * force
            expected = [*push, *np.cross(middle - asm.centroid[block], push)]
            np.testing.assert_allclose(found[block], expected, rtol=1e-9, atol=1e-9)
    with pytest.raises(InputError, match=r"1\.118\d* of 3\.354\d* m of the line lie on free faces \(of one\)"):
        line_load(asm, start, end, force, group=None, blocks="one")


def test_a_line_over_a_notch_is_refused_and_along_its_edge_it_is_carried_once():
    notched = prism([(0, 0), (4, 0), (4, 3), (2.5, 3), (2.5, 1), (1, 1), (1, 3), (0, 3)], 2.0)
    asm = assembly([notched], supports=[])
    with pytest.raises(InputError, match=r"2\.5 of 4 m of the line lie on free faces"):
        line_load(asm, (0, 0, 2), (4, 0, 2), (0, 1, 0))
    low = line_load(asm, (0, 0, 0.5), (4, 0, 0.5), (0, 1.5, 0))[0]
    np.testing.assert_allclose(low[:3], [0, 6, 0], atol=1e-9)
    edge = line_load(asm, (1, 0.5, 3), (1, 1.5, 3), (0, 0, -2))[0]
    np.testing.assert_allclose(edge[:3], [0, 0, -2], atol=1e-9)
    np.testing.assert_allclose(edge[3:], np.cross(np.array([1, 1, 3]) - asm.centroid[0], (0, 0, -2)), atol=1e-9)


def test_lines_need_a_length_and_numbers():
    asm = assembly([box((0, 0, 0), (2, 3, 1))], supports=[])
    with pytest.raises(InputError, match=r"line from \[1\.0, 1\.0, 1\.0\] to \[1\.0, 1\.0, 1\.0\] has no length"):
        line_load(asm, (1, 1, 1), (1, 1, 1), (0, 0, 1))
    for key in ("start", "end", "force"):
        given = {"start": (0, 0, 1), "end": (1, 1, 1), "force": (0, 0, -1)}
        with pytest.raises(InputError, match=f"^{key} is"):
            line_load(asm, **(given | {key: (0, 0)}))
    size = asm.size[0]
    assert line_load(asm, (0, 0, 1 + 0.9e-6 * size), (1, 1, 1), (0, 0, -1)).any()
    with pytest.raises(InputError, match=r"0 of 1\.41421 m of the line lie on free faces; all"):
        line_load(asm, (0, 0, 1 + 1.2e-6 * size), (1, 1, 1), (0, 0, -1))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("off", "carried"), [(0.0, True), (1e-6, True), (1.01e-6, False)])
def test_a_line_is_on_a_face_up_to_a_millionth_of_the_size_of_its_block(axis, off, carried):
    asm = assembly([box((0, 0, 0), (1, 1, 1)), box((9, 9, 9), (10, 10, 10))], supports=[])
    start, end = np.full(3, 0.25), np.full(3, 0.75)
    start[axis] = end[axis] = -off
    if carried:
        load = line_load(asm, start, end, (1, 2, 3))
        np.testing.assert_allclose(load[:, :3], [np.sqrt(0.5) * np.array([1, 2, 3]), np.zeros(3)], rtol=1e-9)
    else:
        with pytest.raises(InputError, match=r"0 of 0\.707107 m of the line lie on free faces; all of it must"):
            line_load(asm, start, end, (1, 2, 3))


def test_a_face_has_its_own_axes_does_not_change_and_is_compared_by_identity():
    frame = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])
    own = Face(3, frame, np.array([1.0, 2.0, 3.0]), shapely.box(0, 0, 2, 1))
    points = [(1.5, 2.0, 3.0), (1.0, 2.6, 3.8), (1.0, 2.8, 2.4)]
    np.testing.assert_array_equal(own.normal, frame[0])
    np.testing.assert_allclose(own.flat(points), [(0.5, 0), (0, 0), (0, 1)], atol=1e-12)
    np.testing.assert_allclose(own.height(points), [0, 1, 0], atol=1e-12)
    part = own.within(shapely.box(1, 0.5, 9, 9))
    assert (part.block, part.region.bounds) == (3, (1.0, 0.5, 2.0, 1.0))
    with pytest.raises(FrozenInstanceError):
        own.block = 4
    assert replace(own) != own
    assert len({own, replace(own)}) == 2


def test_a_face_of_which_nothing_is_free_carries_nothing():
    asm = assembly([box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (4, 1, 1))], supports=[])
    frame = np.array([(0, 0, 1.0), (1, 0, 0), (0, 1, 0)])
    faces = [Face(0, frame, np.array([0, 0, 1.0]), shapely.Polygon()),
             Face(1, frame, np.array([2, 0, 1.0]), shapely.box(0, 0, 2, 1))]  # fmt: skip
    found = integrated(asm, faces, lambda points, normal: -3.0 * normal).wrenches(asm)
    np.testing.assert_allclose(found, [[0] * 6, [0, 0, -6, 0, 0, 0]], atol=1e-12)


def test_a_spread_load_stays_below_where_it_acts():
    """A parapet beside the axle carries none of it; the deck tips about the edge of its pier, .5 m from its end."""
    blocks = [
        box((0, 0, -1), (2, 1, 0), name="pier"),
        box((0, 0, 0), (3, 1, 0.5), name="deck"),
        box((1.5, 0, 0.5), (2, 1, 1.5), name="parapet"),
    ]
    asm = Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)
    load = dispersed_load(asm, (2.4, 0.5, 0.9), 1000.0, spread=2.0)
    assert load[:, 2] == pytest.approx([0.0, -1000.0, 0.0])
    assert limit_load(asm, load).lower == pytest.approx((14715 * 0.5 + 4905 * 0.25) / 500, rel=1e-4)


def quay(*, bridged: bool) -> Assembly:
    """A pier, and beside it a slab on a narrow post; fill of 1 m over the pier, and a footbridge 3 m higher."""
    blocks = [
        box((-1, -1, -3), (5, 2, -2), name="ground"),
        box((0, 0, -2), (2, 1, 0), name="pier"),
        box((2.65, 0.3, -2), (2.95, 0.7, -0.3), name="post"),
        box((2.05, 0, -0.3), (3.55, 1, 0), name="slab"),
    ]
    if bridged:
        for x, y in ((0.5, -0.5), (3.5, -0.5), (0.5, 1.1), (3.5, 1.1)):
            blocks.append(box((x, y, -2), (x + 0.5, y + 0.4, 4), name=f"leg {x:g} {y:g}"))
        blocks.append(box((0.5, -0.5, 4), (4, 1.5, 4.2), name="deck"))
    return Assembly.from_blocks(blocks, supports=["ground"], density=2200.0, friction=0.7)


@pytest.mark.parametrize("bridged", [False, True])
def test_a_load_under_a_footbridge_spreads_as_without_it(bridged):
    """A wheel of .3 x .3 m at 1 m over the pier covers 1.3 m: .9 m of the pier and .35 m of the slab, which bears .28.

    The slab, 1.5 x 1 x .3 m, tips about the edge of its post, at .15 m from its middle and .425 m from the load.
    """
    assembly = quay(bridged=bridged)
    load = dispersed_load(assembly, (1.75, 0.5, 1.0), 10e3, spread=0.5, footprint=(0.3, 0.3))
    slab = assembly.names.index("slab")
    np.testing.assert_allclose(load[slab, 2], -2800.0)
    assert load[:, 2].sum() == pytest.approx(-10e3)
    limit = limit_load(assembly, load)
    expected = 1.5 * 0.3 * 2200 * 9.81 * 0.15 / (2800 * 0.425)
    assert expected == pytest.approx(1.22419, abs=1e-5)
    assert limit.lower == pytest.approx(expected, rel=2e-4)
    wheels = moving_load(
        assembly, [(0, 10e3)], [(1.75, 0.5, 1.0), (1.8, 0.5, 1.0)], positions=2, spread=0.5, footprint=(0.3, 0.3)
    )
    np.testing.assert_allclose(wheels.lower[0], expected, rtol=2e-4)


def test_a_wheel_that_has_nothing_but_a_footbridge_over_it_presses_on_nothing():
    """Past the slab, at x = 3.7 m, lies the deck at 4.2 m alone; the ground is fixed and carries no load."""
    assembly = quay(bridged=True)
    with pytest.raises(InputError, match=r"no free face of these blocks lies below the point \[3\.7, 0\.5, 1\.0\]"):
        dispersed_load(assembly, (3.7, 0.5, 1.0), 10e3, spread=0.5, footprint=(0.3, 0.3))
    options = {"positions": 2, "spread": 0.5, "footprint": (0.3, 0.3)}
    there = moving_load(assembly, [(0, 10e3), (0.1, 10e3)], [(1.75, 0.5, 1.0), (3.7, 0.5, 1.0)], **options)
    alone = moving_load(quay(bridged=False), [(0, 10e3), (0.1, 10e3)], [(1.75, 0.5, 1.0), (3.7, 0.5, 1.0)], **options)
    np.testing.assert_allclose(there.lower, alone.lower, rtol=1e-6)


@pytest.mark.parametrize("side", [6.0, 1e4])
def test_a_face_just_above_a_load_carries_none_of_it_however_large_the_ground_is(side):
    """A slab 5 mm higher than the load, beside the one that it stands on, is above it whatever the ground measures."""
    blocks = [
        box((-side, -side, -side), (side, side, 0), name="ground"),
        box((0, 0, 0), (1, 1, 0.3), name="low"),
        box((1, 0, 0), (2, 1, 0.305), name="high"),
    ]
    assembly = Assembly.from_blocks(blocks, supports=["ground"])
    load = dispersed_load(assembly, (0.9, 0.5, 0.3), 1e3, spread=0.5, footprint=(0.4, 0.4))
    np.testing.assert_allclose(load[:, 2], (0, -1e3, 0))


@pytest.mark.parametrize(("key", "value"), [("coefficient", -0.3), ("surcharge", -5000.0)])
def test_earth_does_not_pull(key, value):
    """A pressure presses on what it touches: its coefficient and its surcharge are at least 0."""
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 1, 3), name="wall")])
    with pytest.raises(InputError, match=f"^{key} is {value}; it must be a number of at least 0$"):
        fluid_pressure(asm, 2.0, 18000.0, (-1, 0, 0), **{key: value})
    table = {"kind": "pressure", "level": 2.0, "unit_weight": 18000.0, "towards": [-1, 0, 0], key: value}
    with pytest.raises(InputError, match=f"^loads.earth: {key} is {value}; it must be a number of at least 0$"):
        load_cases(asm, {"earth": table}, {"all": {"factors": {"earth": 1.0}}})


def test_earth_without_pressure_or_surcharge_presses_by_the_rest():
    """K (gamma h^2 / 2 + q h) a metre: nothing at K = 0, and 18 x 4 / 2 kN at q = 0."""
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 1, 3), name="wall")])
    nothing = fluid_pressure(asm, 2.0, 18000.0, (-1, 0, 0), coefficient=0.0, surcharge=5000.0)
    np.testing.assert_array_equal(nothing, np.zeros((1, 6)))
    assert fluid_pressure(asm, 2.0, 18000.0, (-1, 0, 0), surcharge=0.0)[0, 0] == pytest.approx(36000.0)


def sail(**more):
    """A sail vault on springers along two sides; its joints are warped by up to a millimetre."""
    element = {"kind": "sail", "spans": [4.0, 4.0], "rise": 0.8, "thickness": 0.25, "courses": 8, "voussoirs": 8,
               "springers": 0.3, "supports": ["south", "north"]}  # fmt: skip
    return build(scene_from({"name": "sail", "elements": {"v": element | more}, "supports": ["v.springer"]}))


def outer_faces(asm):
    """Faces without a twin of the same corners: those that are no joint, where stones have their corners in common."""
    rings = [asm.face_vertices[a:b] for a, b in zip(asm.face_start, asm.face_start[1:], strict=False)]
    keys = [tuple(sorted(map(tuple, asm.vertices[ring].round(6).tolist()))) for ring in rings]
    return [f for f, key in enumerate(keys) if keys.count(key) == 1 and not asm.support[asm.face_block[f]]]


@pytest.mark.parametrize("turn", [0, 30])
def test_nothing_presses_inside_the_warped_joints_of_a_vault(turn):
    """Water 0.5 m above the crown presses on each outer face that looks up with its depth at the centroid."""
    asm = sail(turn=turn)
    level = float(asm.vertices[:, 2].max()) + 0.5
    area = np.zeros((asm.n_blocks, 3))
    for f in outer_faces(asm):
        normal = asm.planes.normal[f]
        if normal[2] > 0.01:
            # Pressure is linear, so that the centroid of each triangle about the first corner tells its mean.
            ring = asm.vertices[asm.face_vertices[asm.face_start[f] : asm.face_start[f + 1]]]
            for one, two in zip(ring[1:-1], ring[2:], strict=True):
                own = np.linalg.norm(np.cross(one - ring[0], two - ring[0])) / 2
                depth = level - (ring[0] + one + two)[2] / 3
                area[asm.face_block[f]] -= 9810.0 * depth * own * normal
    load = fluid_pressure(asm, level, 9810.0, (0, 0, 1))
    np.testing.assert_allclose(load[:, :3], area, atol=1e-6 * np.abs(area).max())
    assert fill_load(asm, level, 9810.0)[:, 2].sum() == pytest.approx(area[:, 2].sum(), rel=1e-6)


@pytest.mark.parametrize("degrees", [20, 33, 71])
def test_a_turned_wall_of_corners_of_a_millimetre_is_loaded_as_the_drawn_one(degrees):
    """Water on the end of a wall of stones: gamma h2 / 2 times its thickness; fill of 0.2 m on its top: 0.3 m3."""
    runs = {"a": {"path": [[0, 0], [3, 0]], "thickness": 0.5, "height": 1.8}}
    walls = {"kind": "walls", "brick": [0.6, 0.3], "runs": runs}
    drawn = build(scene_from({"name": "wall", "elements": {"w": walls}}))
    asm, along, across = turned(drawn, degrees)
    asm = asm.with_(vertices=asm.vertices.round(3))
    end = fluid_pressure(asm, 1.8, 9810.0, -along)[:, :3].sum(axis=0)
    assert end @ along == pytest.approx(9810.0 * 1.8**2 / 2 * 0.5, rel=5e-3)
    assert end @ across == pytest.approx(0.0, abs=5e-3 * (end @ along))
    face = fluid_pressure(asm, 1.8, 9810.0, -across)[:, :3].sum(axis=0)
    assert face @ across == pytest.approx(9810.0 * 1.8**2 / 2 * 3.0, rel=5e-3)
    assert fill_load(asm, 2.0, 1000.0)[:, 2].sum() == pytest.approx(-300.0, rel=5e-3)


def test_strips_count_for_nothing_beside_their_own_joint_alone():
    """A slab of 12 m by 6 m bears a tower and, metres away, cubes of .2 m with 30 mm between them, which are free."""
    slab, tower = box((0, 0, -1), (12, 6, 0), name="slab"), box((0, 0, 0), (5, 6, 6), name="tower")
    corners = [(7 + 0.23 * i, 1 + 0.23 * j) for i in range(4) for j in range(4)]
    cubes = [box((x, y, 0), (x + 0.2, y + 0.2, 0.2), name=f"{x:g} {y:g}") for x, y in corners]
    load = surface_load(assembly([slab, tower, *cubes], supports=[]), (0, 0, -1.0), (0, 0, 1))
    assert load[0, 2] == pytest.approx(-(12 * 6 - 5 * 6 - len(cubes) * 0.04), rel=1e-9)


def test_a_narrow_arm_far_from_a_joint_is_free():
    """A slab of 6 m by 5 m with an arm of 30 mm by 1 m, under a tower of 4.5 m by 4.5 m."""
    plan = [(0, 0), (6, 0), (6, 6), (5.97, 6), (5.97, 5), (0, 5)]
    vertices = [(x, y, z) for z in (-1.0, 0.0) for x, y in plan]
    sides = [[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
    slab = Block(vertices, [list(range(5, -1, -1)), list(range(6, 12)), *sides], name="slab")
    tower = box((0, 0, 0), (4.5, 4.5, 5), name="tower")
    load = surface_load(assembly([slab, tower], supports=[]), (0, 0, -1.0), (0, 0, 1))
    assert load[0, 2] == pytest.approx(-(6 * 5 + 0.03 * 1 - 4.5**2), rel=1e-9)
