"""Parts of the contact search against plain geometry: tolerances, laws, cells, patches, overlaps."""

from dataclasses import FrozenInstanceError, fields, replace
from math import cos, inf, nan, nextafter, pi, radians, sqrt

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, Interfaces, JointLaw, find_interfaces
from blockstat.contact.cells import centres, patches_of, refine
from blockstat.contact.coplanar import (
    Patch,
    Patches,
    corner_shares,
    in_one_plane,
    joined,
    merge_coplanar,
    shares_of_parts,
)
from blockstat.contact.faces import (
    INSIDE,
    OUTSIDE,
    RIM,
    as_searched,
    concave_patches,
    convex_faces,
    convex_polygons,
    frames,
    joined_convex,
    outline_hull,
    planar,
    position,
)
from blockstat.contact.features import Features, crossings, together
from blockstat.contact.interfaces import WIDTH, Dropped, near_blocks
from blockstat.contact.known_contacts import Contacts, Tolerances, search_of
from blockstat.contact.overlap.penetration import (
    check_copies,
    check_overlaps,
    convex_blocks,
    face_separation,
    overlaps,
    tell,
)
from blockstat.contact.point_law import joint_friction, last_law, laws_of, point_law
from blockstat.contact.tolerance import (
    GAP,
    ROUNDING,
    allowed_gap,
    beyond,
    gap_lengths,
    gap_words,
    read_gap,
    stated_length,
)
from blockstat.contact.unresolved import Unresolved, unresolved_contacts
from blockstat.model.solids import prism as solid_prism
from evidence.scenes.small import assembly, box, prism
from tests.point_bodies import hull

TURN = Rotation.from_rotvec([0.4, -0.9, 0.7]).as_matrix()


# Tolerances.


@pytest.mark.parametrize(
    ("text", "length"),
    [("2 mm", 0.002), ("1.5cm", 0.015), (" .25 m ", 0.25), ("3e-3m", 0.003), ("12mm", 0.012), ("1E+1 mm", 0.01)],
)
def test_a_gap_is_read_in_its_unit(text, length):
    assert stated_length(text) == pytest.approx(length, rel=1e-12)
    assert read_gap(text) == text
    assert gap_words(text) == text.strip()


@pytest.mark.parametrize("text", ["0 mm", "-1 mm", "2 km", "2", "mm", "1e999 m", "", "2 mm thick", "nan m"])
def test_a_text_that_is_no_length_is_refused(text):
    with pytest.raises(InputError, match=f'gap is "{text}"; it must be a share of the block size, or a length'):
        stated_length(text)


@pytest.mark.parametrize("share", [0.0, 0.2, -0.01, 1.0, inf, nan, None, [0.1]])
def test_a_share_outside_its_bounds_is_refused(share):
    with pytest.raises(InputError, match=r"must be between 0 and 0\.2 of the block size"):
        stated_length(share)


def test_a_share_within_its_bounds_is_no_length():
    assert stated_length(nextafter(0.2, 0)) is None
    assert stated_length(nextafter(0.0, 1)) is None
    assert read_gap("0.02") == 0.02
    assert read_gap(None) == 0.01 == GAP
    assert gap_words(0.025) == "0.025 of the block size"
    with pytest.raises(InputError):
        read_gap("0.2")
    with pytest.raises(InputError):
        read_gap("wide")


def test_a_gap_is_a_share_of_each_block_or_a_length_with_the_rounding_of_single_precision():
    asm = assembly([box((-1, -2, -3), (1, 2, 1)), box((4, 0, 0), (5, 0.5, 2))])
    assert gap_lengths(asm, 0.03) == pytest.approx([0.03 * 32 ** (1 / 3), 0.03])
    extent = 6.0  # along x
    assert gap_lengths(asm, "4 mm") == pytest.approx([0.004 + extent * ROUNDING] * 2, rel=1e-12)
    assert pytest.approx(sqrt(3) * 2.0**-23, rel=1e-12) == ROUNDING


def test_no_gap_is_more_than_a_quarter_of_the_mean_thickness():
    asm = assembly([box((0, 0, 0), (3, 2, 0.01)), box((0, 0, 1), (1, 2, 4))])
    thick = [2 * 0.06 / (2 * (6 + 0.03 + 0.02)), 2 * 6 / (2 * (2 + 3 + 6))]
    assert allowed_gap(asm, "5 cm")[0] == pytest.approx(0.25 * thick[0])
    assert allowed_gap(asm, "5 cm")[1] == pytest.approx(0.05 + 4.0 * ROUNDING, rel=1e-12)
    assert allowed_gap(asm, 0.19)[1] == pytest.approx(0.25 * thick[1])
    assert allowed_gap(asm, 0.01)[1] == pytest.approx(0.01 * 6 ** (1 / 3))


@pytest.mark.parametrize(
    ("value", "limit", "text"),
    [
        (0.0034567, 0.002, "0.0035"), (0.0020011, 0.002, "0.002001"), (0.3, 0.29, "0.3"), (2.0, 1.0, "2"),
        (0.1 + 0.2, 0.3, "0.30000000000000004"), (0.0123, 0.012, "0.0123"), (0.0126, 0.012, "0.013"),
    ],
)  # fmt: skip
def test_a_length_has_as_many_digits_as_tell_it_from_its_limit(value, limit, text):
    assert beyond(value, limit) == text


# Joint laws at points.


def joints(laws, *, friction=0.5, groups=("a", "b", "b.x"), share=None):
    blocks = [box((k, 0, 0), (k + 0.5, 1, 1), group=name) for k, name in enumerate(groups)]
    asm = assembly(blocks, friction=friction, joints=laws)
    faces = Interfaces(
        pair=np.array([[0, 1], [1, 2], [0, 2]]), frame=frames(np.eye(3)), area=np.array([2.0, 0.0, 3.0]),
        gap=np.zeros(3), point=np.zeros((7, 3)), start=np.array([0, 4, 5, 7]), share=share,
    )  # fmt: skip
    return asm, faces


def by_hand(asm, faces):
    """Friction, apex, floor and cap of each point by the law that counts for its joint."""
    rows = []
    for k, (i, j) in enumerate(faces.pair.tolist()):
        one, two = asm.groups[i], asm.groups[j]
        mu, tension, cohesion, cap = asm.friction, 0.0, None, inf

        def fits(name, group):
            return name == "*" or group == name or group.startswith(name + ".")

        for law in asm.joints:
            p, q = law.between
            if (fits(p, one) and fits(q, two)) or (fits(q, one) and fits(p, two)):
                mu = asm.friction if law.friction is None else law.friction
                area = float(faces.area[k])
                tension = law.tension * area + (law.bond if area and law.bond_moment is None else 0.0)
                cohesion = None if law.cohesion is None else law.cohesion * area
                cap = inf if law.compression is None else law.compression * area
        apex = tension if cohesion is None or mu in (0.0, inf) else cohesion / mu
        points = range(faces.start[k], faces.start[k + 1])
        for i in points:
            share = faces.share[i] if faces.share is not None else 1.0 / len(points)
            rows.append((mu, share * apex, share * max(apex - tension, 0.0), share * (cap + apex)))
    return np.array(rows)


LAWS = {
    "none": [],
    "tension": [JointLaw(("b", "a"), tension=5.0)],
    "bond": [JointLaw(("a", "b"), bond=4.0, friction=0.9)],
    "bond at the centre": [JointLaw(("*", "*"), bond=4.0, bond_moment=1.0, tension=0.5)],
    "cohesion": [JointLaw(("*", "b"), cohesion=3.0, tension=1.0, friction=0.25)],
    "little cohesion": [JointLaw(("*", "*"), cohesion=0.1, tension=4.0)],
    "no friction": [JointLaw(("*", "*"), cohesion=0.0, tension=4.0, friction=0.0)],
    "infinite friction": [JointLaw(("*", "*"), cohesion=2.0, tension=4.0, friction=inf)],
    "strength": [JointLaw(("*", "*"), compression=7.0, tension=2.0)],
    "the last one": [
        JointLaw(("*", "*"), compression=7.0, tension=2.0, friction=0.3), JointLaw(("b.x", "b"), bond=2.0),
        JointLaw(("b.x", "a"), cohesion=1.0),
    ],
}  # fmt: skip


@pytest.mark.parametrize("share", [None, np.array([0.1, 0.2, 0.3, 0.4, 1.0, 0.25, 0.75])])
@pytest.mark.parametrize("name", LAWS)
def test_the_law_of_a_point_is_its_share_of_that_of_its_joint(name, share):
    asm, faces = joints(LAWS[name], share=share)
    law, expected = point_law(asm, faces), by_hand(asm, faces)
    found = np.column_stack([law.friction, law.shift, law.floor, law.cap])
    assert found == pytest.approx(expected, rel=1e-12)
    assert joint_friction(asm, faces) == pytest.approx(expected[[0, 4, 5], 0])
    with pytest.raises(FrozenInstanceError):
        law.cap = law.floor


def test_the_last_law_that_fits_counts():
    laws = LAWS["the last one"]
    asm, faces = joints(laws)
    assert last_law(asm, faces) == [laws[0], laws[1], laws[2]]
    assert [rows.tolist() for _, rows in laws_of(asm, faces)] == [
        [True] * 3,
        [False, True, False],
        [False, False, True],
    ]
    assert last_law(asm.with_(joints=laws[1:]), faces) == [None, laws[1], laws[2]]


def test_the_friction_of_a_law_ends_where_a_later_law_without_one_fits():
    """The laws beside "the last one": friction .3 by the first, and the assembly's .6 where the others count."""
    asm, faces = joints(LAWS["the last one"], friction=0.6)
    assert joint_friction(asm, faces).tolist() == [0.3, 0.6, 0.6]


def test_the_friction_of_interfaces_counts_before_that_of_laws():
    asm, faces = joints(LAWS["bond"])
    own = np.array([0.1, 0.2, 0.3])
    assert joint_friction(asm, replace(faces, friction=own)) is own
    assert point_law(asm, replace(faces, friction=own)).friction.tolist() == [0.1] * 4 + [0.2] + [0.3] * 2


@pytest.mark.parametrize(("friction", "ok"), [(1e-3, True), (0.9e-3, False), (0.0, False)])
def test_cohesion_needs_a_cone_with_an_apex(friction, ok):
    asm, faces = joints([JointLaw(("a", "b"), cohesion=1.0, friction=friction), JointLaw(("b", "b.x"), friction=0.0)])
    if ok:
        assert point_law(asm, faces).shift[0] == pytest.approx(0.25 * 2.0 / friction)
    else:
        with pytest.raises(
            InputError, match=r"joint law between a and b: cohesion needs a friction of at least 0\.001"
        ):
            point_law(asm, faces)
    elsewhere = [JointLaw(("b", "b.x"), friction=0.0), JointLaw(("a", "b"), cohesion=1.0, friction=0.5)]
    assert point_law(asm.with_(joints=elsewhere), faces).friction[4] == 0.0


def test_a_later_law_takes_the_cohesion_with_the_friction():
    # The law of the part counts on its joint: it slides freely, and the cohesion of the law before it is gone there.
    asm, faces = joints([JointLaw(("a", "b"), cohesion=1.0), JointLaw(("a", "b"), friction=0.0)])
    assert point_law(asm, faces).friction[0] == 0.0
    assert point_law(asm, faces).shift[0] == 0.0


# Cells.


def cell_sums(corners, cells):
    """Area and centroid of each cell of a convex outline, with the rectangle and the clipping of shapely."""
    outline = shapely.MultiPoint(corners).convex_hull
    x, y = np.array(shapely.minimum_rotated_rectangle(outline).exterior.coords)[:-1].T
    origin, one, two = (
        np.array([x[0], y[0]]),
        np.array([x[1] - x[0], y[1] - y[0]]),
        np.array([x[3] - x[0], y[3] - y[0]]),
    )
    bound = [(1 - cos(pi * k / cells)) / 2 for k in range(cells + 1)]
    found = []
    for i in range(cells):
        for j in range(cells):
            window = [origin + one * u + two * v for u, v in ((bound[i], bound[j]), (bound[i + 1], bound[j]),
                      (bound[i + 1], bound[j + 1]), (bound[i], bound[j + 1]))]  # fmt: skip
            part = outline.intersection(shapely.Polygon(window))
            if part.area > 1e-9 * outline.area:
                found.append((part.area, part.centroid.x, part.centroid.y))
    return np.array(found)


OUTLINES = {
    "triangle": [(0, 0), (3, 0.2), (0.4, 1.1)],
    "quadrilateral": [(0, 0), (2, -0.3), (2.6, 1.5), (0.1, 0.9)],
    "hexagon": [(0, 0), (1, -0.6), (2.2, -0.2), (2.5, 0.7), (1.4, 1.3), (0.2, 0.9)],
}


def patch_interfaces(outlines, *, patches=None, area=None):
    """Interfaces in a leaning plane over the outlines."""
    frame = np.array([TURN[2], TURN[0], TURN[1]])
    corners = [np.array(o, float) @ frame[1:] + [1.0, -2.0, 0.5] for o in outlines]
    n = len(corners)
    own = [shapely.Polygon(o).area if len(o) > 2 else 0.0 for o in outlines] if area is None else area
    return Interfaces(
        pair=np.array([[0, k + 1] for k in range(n)]), frame=np.tile(frame, (n, 1, 1)), area=np.array(own),
        gap=np.zeros(n), point=np.concatenate(corners), start=np.cumsum([0, *map(len, corners)]), patches=patches,
    )  # fmt: skip


def flat(points, frame):
    return (points - [1.0, -2.0, 0.5]) @ frame[1:].T


def same_cells(points, shares, expected):
    """Whether cells are those expected, in any order."""
    found = np.column_stack([shares * expected[:, 0].sum(), points])
    assert len(found) == len(expected)
    for row in expected:
        assert np.abs(found - row).max(axis=1).min() < 1e-9


@pytest.mark.parametrize("cells", [1, 2, 5])
@pytest.mark.parametrize("name", OUTLINES)
def test_cells_are_the_parts_of_a_patch_between_the_bounds_of_its_smallest_rectangle(name, cells):
    faces = patch_interfaces([OUTLINES["triangle"], OUTLINES[name], [(0, 0), (1, 1)]])
    fine = refine(faces, np.array([0, cells, 3]))
    count = np.diff(fine.start)
    assert fine.point[:3] == pytest.approx(faces.point[:3])
    assert fine.point_share[:3] == pytest.approx([1 / 3] * 3)
    own = slice(fine.start[1], fine.start[2])
    same_cells(flat(fine.point[own], faces.frame[1]), fine.point_share[own], cell_sums(OUTLINES[name], cells))
    assert fine.point_share[own].sum() == pytest.approx(1.0)
    # An edge has no cells.
    assert count[2] == 2
    assert fine.point_share[-2:].tolist() == [0.5, 0.5]
    assert [len(fine.outline(k)) for k in range(3)] == [3, len(OUTLINES[name]), 2]
    assert centres(fine, np.array([2, 1])) == pytest.approx(centres(faces, np.array([2, 1])))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", OUTLINES)
def test_the_windows_of_the_rectangle_that_miss_the_patch_are_no_cells_and_divide_nothing(name):
    fine = refine(patch_interfaces([OUTLINES[name]]), np.array([9]))
    assert len(fine.point) == len(cell_sums(OUTLINES[name], 9)) < 81
    assert np.isfinite(fine.point).all()


def test_centres_are_centroids_of_patches_middles_of_edges_and_corners_themselves():
    faces = patch_interfaces([OUTLINES["hexagon"], [(0.2, 0.3), (1.0, 0.5)], [(0.7, 0.1)], OUTLINES["triangle"]])
    found = flat(centres(faces, np.array([3, 0, 1, 2])), faces.frame[0])
    hexagon = shapely.Polygon(OUTLINES["hexagon"]).centroid
    triangle = np.mean(OUTLINES["triangle"], axis=0)
    assert found == pytest.approx(np.array([triangle, (hexagon.x, hexagon.y), (0.6, 0.4), (0.7, 0.1)]))


FEET = [[(0, 0), (1, 0), (1, 1), (0, 1)], [(3, 0.2), (3.5, 0.2), (3.4, 1.4), (3, 1.2)]]


def on_two_feet():
    """One joint of two patches whose hull is larger than they are, and two whole ones, one of them higher."""
    hull_ = [(0, 0), (3.5, 0.2), (3.4, 1.4), (0, 1)]
    faces = patch_interfaces(
        [OUTLINES["triangle"], hull_, FEET[0]],
        area=[shapely.Polygon(OUTLINES["triangle"]).area, sum(shapely.Polygon(f).area for f in FEET), 1.0],
    )
    faces = replace(faces, pair=np.array([[0, 1], [0, 1], [2, 3]]))
    n, frame, origin = faces.frame[0, 0], faces.frame[0], np.array([1.0, -2.0, 0.5])
    lifted = faces.point.copy()
    lifted[:3] += 0.4 * n
    faces = replace(faces, point=lifted)
    shift = np.array([0.3, 0.8])
    rows = [(np.array([0, 1]), np.array(f, float) - shift, origin + shift @ frame[1:]) for f in FEET]
    rows += [(np.array([0, 1]), np.array(OUTLINES["triangle"], float), origin + 0.4 * n)]
    rows += [(np.array([2, 3]), np.array(FEET[0], float), origin)]
    patches = Patches(
        np.array([r[0] for r in rows]), np.tile(frame, (4, 1, 1)), np.array([r[2] for r in rows]), np.ones(4),
        np.zeros(4),
        np.concatenate([r[1] for r in rows]), np.array([len(r[1]) for r in rows]), np.zeros(4),
    )  # fmt: skip
    return replace(faces, patches=patches)


def test_a_joint_on_two_feet_has_cells_on_each_and_none_between():
    faces = on_two_feet()
    fine = refine(faces, np.array([0, 3, 0]))
    own = slice(fine.start[1], fine.start[2])
    expected = np.concatenate([cell_sums(foot, 3) for foot in FEET])
    same_cells(flat(fine.point[own], faces.frame[1]), fine.point_share[own], expected)
    area, x, y = np.sum([(a, a * x, a * y) for a, x, y in np.concatenate([cell_sums(f, 1) for f in FEET])], axis=0)
    assert flat(centres(faces, np.array([1])), faces.frame[1])[0] == pytest.approx([x / area, y / area])


@pytest.mark.parametrize("place", np.random.default_rng(0).uniform(-6e6, 6e6, (12, 3)).round())
def test_where_a_joint_stands_on_a_map_does_not_say_whether_its_patches_fill_their_hull(place):
    faces = on_two_feet()
    two, whole = faces.patches.take(np.array([0, 1])), faces.patches.take(np.array([3, 3]))
    # The square foot as its left and its right part.
    halves = np.array([(0, 0), (0.3, 0), (0.3, 1), (0, 1), (0.3, 0), (1, 0), (1, 1), (0.3, 1)])
    for k, patches, expected in ((1, two, FEET), (2, replace(whole, corner=halves), FEET[:1])):
        far = replace(faces, point=faces.point + place, patches=replace(patches, origin=patches.origin + place))
        found = patches_of(far, k)
        assert len(found) == len(expected)
        for corners, foot in zip(found, expected, strict=True):
            assert flat(corners - place, faces.frame[k]) == pytest.approx(np.array(foot), abs=1e-8)


def test_the_patches_of_a_joint_are_those_that_do_not_fill_their_hull():
    faces = on_two_feet()
    plane = replace(faces, patches=faces.patches.take(np.array([0, 1, 3])))
    found = patches_of(plane, 1)
    assert len(found) == 2
    for corners, foot in zip(found, FEET, strict=True):
        assert flat(corners, faces.frame[1]) == pytest.approx(np.array(foot))
    (whole,) = patches_of(faces, 2)
    assert (whole == faces.outline(2)).all()
    (alone,) = patches_of(replace(faces, patches=None), 1)
    assert (alone == faces.outline(1)).all()
    (high,) = patches_of(faces, 0)
    assert (high == faces.outline(0)).all()


# Patches of one plane.


def patch(number, corners, *, pair=(0, 1), normal=(0, 0, 1), height=0.0, gap=0.0):
    frame = frames(np.array([normal], float) / np.linalg.norm(normal))[0]
    corners = np.array(corners, float)
    origin = height * frame[0] + number * frame[1]
    area = shapely.MultiPoint(corners).convex_hull.area
    return Patch(np.array(pair), frame, origin, area, gap, corners - [number, 0])


def listed(patches):
    empty = Patches(
        np.empty((0, 2), int), np.empty((0, 3, 3)), np.empty((0, 3)), np.empty(0), np.empty(0), np.empty((0, 2)),
        np.empty(0, int), np.empty(0),
    )  # fmt: skip
    return empty.with_more(patches)


THREE = [
    patch(0, [(0, 0), (1, 0), (0, 1)], pair=(2, 3), gap=0.1),
    patch(1, [(2, 0), (3, 0), (3, 1), (2, 2)], pair=(0, 1), gap=0.3),
    patch(2, [(5, 0), (6, 0), (6, 1), (5.5, 2), (5, 1)], pair=(0, 1), gap=0.2),
]


def test_patches_are_taken_and_listed_with_their_own_corners():
    own = listed(THREE)
    for rows in ([2, 0], [1], [0, 1, 2]):
        for found, k in zip(own.take(np.array(rows)), rows, strict=True):
            for one, two in zip(found, THREE[k], strict=True):
                assert np.array_equal(one, two)
    assert [len(p.polygon) for p in own] == [3, 4, 5]
    more = own.with_more(THREE[:1])
    assert more.count.tolist() == [3, 4, 5, 3]
    assert own.columns()[-2] is own.count
    assert own.columns()[-1] is own.overlap
    with pytest.raises(FrozenInstanceError):
        own.gap = own.area


@pytest.mark.parametrize(
    "pairs", [[(0, 1), (2, 3), (2, 3)], [(0, 1), (1, 2), (1, 2), (1, 3)], [(0, 1), (1, 1), (0, 1)]]
)
def test_patches_are_joined_whichever_pair_they_belong_to(pairs):
    squares = [
        patch(k, [(2 * k, 0), (2 * k + 1, 0), (2 * k + 1, 1), (2 * k, 1)], pair=pair) for k, pair in enumerate(pairs)
    ]
    own = merge_coplanar(listed(squares), np.full(4, 1e-3))
    assert [tuple(pair) for pair in own.pair.tolist()] == sorted(set(pairs))
    for found in own:
        number = [k for k, pair in enumerate(pairs) if pair == tuple(found.pair.tolist())]
        assert found.area == pytest.approx(len(number))
        x = (found.origin + found.polygon @ found.frame[1:]) @ squares[0].frame[1]
        assert (x.min(), x.max()) == pytest.approx((2 * number[0], 2 * number[-1] + 1))


def test_patches_of_one_plane_and_pair_are_joined():
    own = merge_coplanar(listed(THREE), np.full(4, 1e-3))
    assert own.pair.tolist() == [[0, 1], [2, 3]]
    assert own.area == pytest.approx([THREE[1].area + THREE[2].area, THREE[0].area])
    assert own.gap.tolist() == [0.3, 0.1]
    corners = [p.origin + p.polygon @ p.frame[1:] for p in THREE]
    for found, expected in zip(own, (np.concatenate(corners[1:]), corners[0]), strict=True):
        points = found.origin + found.polygon @ found.frame[1:]
        one, two = (shapely.MultiPoint(np.round(p[:, :2], 12)).convex_hull for p in (points, expected))
        assert one.symmetric_difference(two).area == pytest.approx(0.0, abs=1e-9)
        assert np.abs(points[:, 2]).max() < 1e-12
    few = listed(THREE[:2])
    assert merge_coplanar(few, np.full(4, 1e-3)).pair.tolist() == [[0, 1], [2, 3]]
    none = few.take(np.empty(0, dtype=int))
    assert merge_coplanar(none, np.ones(4)) is none


@pytest.mark.parametrize(
    ("change", "one"),
    [
        ({}, True), ({"height": 0.9e-3}, False), ({"height": 0.9e-3, "gap": 1.7e-3}, False),
        ({"height": 0.9e-3, "gap": 1.9e-3}, True), ({"height": -0.9e-3, "gap": 1.9e-3}, True),
        ({"height": 1.1e-3, "gap": 3e-3}, False), ({"height": -1.1e-3, "gap": 3e-3}, False),
        ({"normal": (0, 0.9e-4, 1)}, True), ({"normal": (0, 1.1e-4, 1)}, False), ({"normal": (0, 0, -1)}, False),
        ({"pair": (0, 2)}, False), ({"pair": (2, 1)}, False),
    ],
)  # fmt: skip
def test_patches_lie_in_one_plane_as_far_as_their_gaps_explain_and_to_that_of_the_smaller_block(change, one):
    other = patch(0, [(5, 0), (6, 0), (6, 1)], **change)
    own = listed([patch(0, [(0, 0), (1, 0), (0, 1)]), other, patch(0, [(0, 0), (1, 0), (1, 1)], height=0.5)])
    allowed = np.array([1e-3, 2e-3, 3e-3])
    assert len(merge_coplanar(own, allowed).pair) == (2 if one else 3)


def test_the_plane_of_a_patch_is_asked_by_its_normal_and_its_origin():
    normal, origin = np.array([0.0, 0.6, 0.8]), np.array([1.0, 2.0, 3.0])
    origins = origin + np.array([[5, 0, 0], [0, 0.6e-3, 0.8e-3], [0, -0.6e-3, -0.8e-3], [0, 6e-3, 8e-3]])
    gaps = np.array([0.0, 2e-3, 2e-3, 2e-2])
    found = in_one_plane(normal, origin, 0.0, np.tile(normal, (4, 1)), origins, gaps, 1.0001e-3)
    assert found.tolist() == [True, True, True, False]
    found = in_one_plane(normal, origin, 0.0, np.tile(normal, (4, 1)), origins, 0 * gaps, 1.0001e-3)
    assert found.tolist() == [True, False, False, False]  # a step that no gap explains
    assert in_one_plane(normal, origin, 0.0, np.tile(-normal, (4, 1)), origins, gaps, 1.0).tolist() == [False] * 4


def test_patches_with_other_frames_are_joined_where_they_lie():
    one = patch(0, [(0, 0), (2, 0), (0, 1)])
    turned = one._replace(
        frame=np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]]), origin=np.array([3.0, 1.0, 0.0]), gap=0.4
    )
    found = joined(one, [one, turned])
    points = found.origin + found.polygon @ found.frame[1:]
    own = [p.origin + p.polygon @ p.frame[1:] for p in (one, turned)]
    assert own[1] == pytest.approx(np.array([(3, 1, 0), (3, 3, 0), (2, 1, 0)]))
    hulls = [shapely.MultiPoint(p[:, :2]).convex_hull for p in (points, np.concatenate(own))]
    assert hulls[0].equals(hulls[1])
    assert (found.area, found.gap) == (one.area + turned.area, 0.4)


# Faces.


def test_frames_are_right_handed_about_their_normals():
    normal = np.concatenate([np.eye(3), -np.eye(3), TURN, [[0.6, 0.8, 0.0]]])
    found = frames(normal)
    assert (found[:, 0] == normal).all()
    assert found @ found.swapaxes(1, 2) == pytest.approx(np.tile(np.eye(3), (len(normal), 1, 1)), abs=1e-12)
    assert np.linalg.det(found) == pytest.approx(np.ones(len(normal)))


@pytest.mark.parametrize(("dent", "convex"), [(-0.1, True), (0.0, True), (0.5e-6, True), (3e-6, False), (0.2, False)])
def test_a_face_is_convex_to_a_millionth(dent, convex):
    # The middle of one of five sides is pushed in by so much of half its length.
    outline = [(0, 0), (1, dent), (2, 0), (2.2, 1.3), (-0.3, 1.0)]
    asm = assembly([box((5, 0, 0), (6, 1, 1)), prism(outline, 1.0)])
    assert convex_faces(asm).tolist() == [True] * 6 + [convex] * 2 + [True] * 5


def test_corners_of_faces_in_a_plane_repeat_their_last_one():
    asm = assembly([prism([(0, 0), (1, 0), (0.3, 0.8)], 1.0), box((2, 0, 0), (3, 1, 1))])
    face, frame, origin = np.array([0, 6]), np.tile(TURN, (2, 1, 1)), np.array([[0.1, 0.2, 0.3], [1, -1, 2]])
    found = planar(asm, face, frame, origin, 5)
    for k, f in enumerate(face):
        corners = asm.vertices[asm.face_vertices[asm.face_start[f] : asm.face_start[f + 1]]]
        expected = [[(p - origin[k]) @ TURN[1], (p - origin[k]) @ TURN[2]] for p in corners]
        expected += [expected[-1]] * (5 - len(expected))
        assert found[k] == pytest.approx(np.array(expected))


def test_concave_faces_have_a_patch_for_each_part_that_they_share():
    comb = prism(
        [(0, 0), (5, 0), (5, 1), (4, 1), (4, 0.5), (3, 0.5), (3, 1), (2, 1), (2, 0.5), (1, 0.5), (1, 1), (0, 1)], 1.0
    )
    plank = box((0.25, -2, 0.75), (4.5, 0, 0.9))
    asm = assembly([comb, plank])
    comb_face = int(np.flatnonzero(~convex_faces(asm))[0])
    plank_face = 6 * 0 + int(np.flatnonzero(asm.face_block == 1)[4])
    frame, origin = np.array([[[0, -1.0, 0], [1, 0, 0], [0, 0, 1.0]]]), np.array([[0.5, 0.0, 0.25]])
    rows, polygons, counts, pieces = concave_patches(
        asm, np.array([comb_face]), np.array([plank_face]), frame, origin, np.array([0]), WIDTH
    )
    found = sorted(
        (p[:n].min(axis=0).round(9).tolist(), p[:n].max(axis=0).round(9).tolist())
        for p, n in zip(polygons, counts, strict=True)
    )
    assert rows.tolist() == [0, 0, 0]
    assert pieces == {}  # each part is convex
    expected = [(0.25, 1), (2, 3), (4, 4.5)]
    assert found == [([a - 0.5, 0.5], [b - 0.5, 0.65]) for a, b in expected]
    for p, n in zip(polygons, counts, strict=True):
        assert shapely.Polygon(p[:n]).exterior.is_ccw
        assert len(p) >= n
    nothing = np.empty(0, dtype=int)
    none = concave_patches(asm, np.array([comb_face]), np.array([plank_face]), frame, origin, nothing, WIDTH)
    assert [len(part) for part in none] == [0, 0, 0, 0]
    assert none[1].shape == (0, 3, 2)


def test_the_hull_of_points_is_walked_counter_clockwise_once():
    points = np.array([(0, 0), (2, 0), (1, 0.5), (2, 1), (0, 1)])
    found = outline_hull(points)
    assert len(found) == 4
    assert shapely.Polygon(found).exterior.is_ccw
    assert sorted(map(tuple, found.tolist())) == [(0, 0), (0, 1), (2, 0), (2, 1)]


@pytest.mark.parametrize("seed", range(8))
def test_points_are_outside_on_a_rim_or_inside_of_any_outline(seed):
    # Stars with notches, some sides of which are rims; two corners are repeated as those of shorter outlines are.
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * pi, 7))
    corners = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.4, 1.5, 7)[:, None]
    polygon = np.concatenate([corners, corners[-1:], corners[-1:]])
    rim = rng.random(9) < 0.5
    rim[6:8] = True  # of sides without length
    rim[8] = seed % 2
    rounding, reach = 0.02, 0.15
    sides = [(k, shapely.LineString([polygon[k], polygon[(k + 1) % 9]])) for k in (0, 1, 2, 3, 4, 5, 8)]
    outline = shapely.Polygon(corners)
    points = np.concatenate([rng.uniform(-1.6, 1.6, (200, 2)), corners, (corners + np.roll(corners, -1, axis=0)) / 2])

    def expected(point, beyond):
        here = shapely.Point(point)
        distance = {k: side.distance(here) for k, side in sides}
        near = [k for k in distance if distance[k] <= rounding]
        inside = outline.contains(here) or bool(near)
        if any(rim[k] for k in near) or (not inside and any(rim[k] and distance[k] <= beyond for k in distance)):
            return RIM
        return INSIDE if inside else OUTSIDE

    both = np.tile(points, (2, 1, 1))
    shapes, rims = np.array([polygon, polygon]), np.array([rim, ~rim])
    with np.errstate(all="raise"):  # sides without length divide nothing
        found = position(both, shapes, rims, np.full(2, rounding))
    assert found[0].tolist() == [expected(p, 0.0) for p in points]
    found = position(both, shapes, rims, np.array([rounding, rounding]), np.array([reach, 0.0]))
    assert found[0].tolist() == [expected(p, reach) for p in points]
    rim = ~rim
    rim[6:8] = False
    assert found[1].tolist() == [expected(p, 0.0) for p in points]
    assert len({*found[0].tolist(), *found[1].tolist()}) == 3


def test_points_far_beside_an_outline_are_outside_though_they_are_level_with_a_corner_to_the_last_bit():
    rng = np.random.default_rng(3)
    polygon = rng.uniform(-1, 1, (200, 5, 2))
    points = polygon - (10.0, 0.0)
    points[..., 1] += np.spacing(points[..., 1]) * rng.integers(-2, 3, points.shape[:2])
    found = position(points, polygon, np.ones((200, 5), dtype=bool), np.full(200, 1e-6))
    assert (found == OUTSIDE).all()


def test_a_block_beside_a_concave_one_rests_on_its_bed_alone():
    """An L in y and z from x = 0 to 1 meets a block from x = 1 on in one upright line, in sheared scenes.

    The block slides on its bed at friction .1. Points of contact lie where both are, which is at x = 1 as drawn.
    """
    corner = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    foot = solid_prism(*(np.array([(x, y, z) for y, z in corner], dtype=float) for x in (0, 1)), name="S")
    drawn = [foot, box((1, 1, 0), (3, 3, 1), name="T"), box((1, 1, 1), (2, 1.4, 2), name="B")]
    for seed in range(60):
        rng = np.random.default_rng(seed)
        shear = np.eye(3) + rng.uniform(-0.3, 0.3, (3, 3))
        shear[2, :2] = 0  # beds stay level
        offset = rng.uniform(-3, 3, 3)
        blocks = [Block(np.asarray(b.vertices) @ shear.T + offset, b.faces, name=b.name) for b in drawn]
        scene = Assembly.from_blocks(blocks, supports=["S", "T"], friction=0.1)
        joints = find_interfaces(scene)
        for k in np.flatnonzero((joints.pair == (0, 2)).all(axis=1)):
            points = joints.point[joints.start[k] : joints.start[k + 1]]
            assert np.linalg.solve(shear, (points - offset).T)[0] == pytest.approx(1.0, abs=1e-6)


# Interfaces as data.


def test_some_interfaces_keep_all_that_is_theirs():
    rng = np.random.default_rng(0)
    whole = Interfaces(
        pair=np.array([[0, 1], [1, 2], [0, 3]]), frame=frames(np.eye(3)), area=np.array([1.0, 0.0, 2.0]),
        gap=np.array([0.1, 0.2, 0.3]), point=rng.normal(size=(9, 3)), start=np.array([0, 4, 6, 9]),
        dropped=(Dropped(0, 2, "gap", 2.0, 1.0),), outlines=tuple(rng.normal(size=(3, 4, 3))),
        share=rng.uniform(size=9),
        kind=np.array([0, 1, 2]), friction=np.array([0.4, 0.5, 0.6]), searched="2 mm",
    )  # fmt: skip
    for rows in (np.array([2, 0]), np.array([True, False, True]), np.array([1])):
        numbers = np.arange(3)[rows]
        own = whole.subset(rows)
        for k, number in enumerate(numbers):
            for name in ("pair", "frame", "area", "gap", "kind", "friction"):
                assert np.array_equal(getattr(own, name)[k], getattr(whole, name)[number])
            points, mine = slice(whole.start[number], whole.start[number + 1]), slice(own.start[k], own.start[k + 1])
            assert (own.point[mine] == whole.point[points]).all()
            assert (own.share[mine] == whole.share[points]).all()
            assert own.outline(k) is whole.outlines[number]
        assert (own.dropped, own.searched) == (whole.dropped, "2 mm")
        assert own.n_interfaces == len(numbers)
    bare = replace(whole, outlines=None, share=None, kind=None, friction=None).subset(np.array([2, 1]))
    assert (bare.outlines, bare.share, bare.kind, bare.friction) == (None, None, None, None)
    assert bare.point_share == pytest.approx([1 / 3] * 3 + [1 / 2] * 2)
    assert bare.kinds.tolist() == [0, 0]
    assert bare.contact_words == ""
    assert whole.contacts == {"face": 1, "edge": 1, "corner": 1, "crossing": 0}
    assert whole.contact_words == "1 face, 1 edge, 1 corner"
    assert whole.point_interface.tolist() == [0] * 4 + [1] * 2 + [2] * 3
    with pytest.raises(FrozenInstanceError):
        whole.gap = whole.area
    with pytest.raises(FrozenInstanceError):
        whole.dropped[0].a = 3


@pytest.mark.parametrize(("gap", "near"), [(0.049, True), (0.051, False)])
def test_blocks_are_near_within_five_gaps_and_two_supports_never(gap, near):
    # The smaller block is a cube of .5 whose gap is a hundredth, that of the larger twice as much.
    blocks = [box((0, 0, 0), (1, 1, 1)), box((0.3, 0.2, 1 + gap), (0.8, 0.7, 1.5 + gap)), box((1, 0, 0), (2, 1, 1))]
    assert near_blocks(assembly(blocks, supports=[0, 2])).tolist() == ([[0, 1]] if near else [])
    assert [0, 2] in near_blocks(assembly(blocks, supports=[0])).tolist()
    assert near_blocks(assembly(blocks, supports=[0, 2]), gap=0.02).tolist() == [[0, 1]]


def wedge(degrees):
    """A large block on another with a part of its underside, .3 wide, that leans about the edge at x = 0."""
    rise = 0.3 * np.tan(radians(degrees))
    upper = prism([(0, 0), (0.3, rise), (5, 4), (5, 6), (0, 6)], 5.0)
    return assembly([prism([(-5, -5), (5, -5), (5, 0), (-5, 0)], 5.0), upper])


@pytest.mark.parametrize(("degrees", "joint"), [(13.0, True), (14.9, True), (15.1, False)])
def test_faces_up_to_fifteen_degrees_from_opposed_may_be_one_joint(degrees, joint):
    found = find_interfaces(wedge(degrees), gap=0.05)
    faces = found.area > 0.5
    assert faces.sum() == joint
    if joint:
        half = radians(degrees) / 2
        assert found.frame[faces][0, 0] == pytest.approx([-np.sin(half), 0, np.cos(half)], abs=1e-9)


def test_a_joint_that_is_missed_says_by_how_much():
    for gap, dropped in ((0.0099, []), (0.0101, [(0, 1, "gap")]), (0.0499, [(0, 1, "gap")]), (0.0501, [])):
        found = find_interfaces(assembly([box((0, 0, 0), (1, 1, 1)), box((0.3, 0.4, 1 + gap), (1.3, 1.4, 2 + gap))]))
        assert found.n_interfaces == (gap < 0.01)
        assert [(d.a, d.b, d.reason) for d in found.dropped] == dropped
        for d in found.dropped:
            assert (d.value, d.limit) == (pytest.approx(gap), pytest.approx(0.01))


@pytest.mark.parametrize(("width", "reason"), [(2e-6, None), (0.5e-6, "sliver"), (0.5e-9, "nothing")])
def test_a_patch_narrower_than_a_millionth_of_the_smaller_block_is_a_sliver(width, reason):
    found = find_interfaces(assembly([box((0, 0, 0), (1, 1, 1)), box((1 - width, 0.1, 1), (2, 1.1, 2))]))
    assert (len(found.area) > 0 and found.area.max() > 0) == (reason is None)
    slivers = [d for d in found.dropped if d.reason == "sliver"]
    assert len(slivers) == (reason == "sliver")
    for d in slivers:
        size = min(1.0, (1.0 + width) ** (1 / 3))
        assert (d.a, d.b) == (0, 1)
        assert d.value == pytest.approx(width, rel=0.01)
        assert d.limit == pytest.approx(1e-6 * size)


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
def test_a_patch_has_the_area_the_frame_and_the_corners_of_what_two_faces_share(turn):
    lower = Block(np.asarray(box((0, 0, 0), (2, 1, 1)).vertices, float) @ turn.T, box((0, 0, 0), (2, 1, 1)).faces)
    upper_box = prism([(0.5, 1.0), (2.5, 1.0), (2.0, 1.8)], 0.6)
    upper = Block((np.asarray(upper_box.vertices, float) + [0, 0.7, 0.004]) @ turn.T, upper_box.faces)
    found = find_interfaces(assembly([lower, upper]))
    assert found.pair.tolist() == [[0, 1]]
    assert found.area == pytest.approx([1.5 * 0.3])
    assert found.gap == pytest.approx([0.004])
    assert found.frame[0, 0] == pytest.approx(turn[:, 2], abs=1e-12)
    corners = sorted(map(tuple, (found.point @ turn).round(9).tolist()))
    assert corners == [(x, y, 1.002) for x in (0.5, 2.0) for y in (0.7, 1.0)]


# Blocks that run into each other.


@pytest.mark.parametrize("seed", range(4))
def test_face_separation_is_the_height_of_the_lowest_corner_over_the_best_face(seed):
    rng = np.random.default_rng(seed)
    blocks = [hull(rng.normal(size=(rng.integers(5, 9), 3)) + rng.normal(size=3)) for _ in range(4)]
    asm = assembly(blocks)
    pairs = np.array([[0, 1], [1, 0], [3, 2], [0, 3], [2, 3]])
    some = rng.random(len(asm.face_block)) < 0.6
    some[asm.face_block == 2] = False
    for faces in (None, some):
        expected = []
        for a, b in pairs:
            best = -inf
            for f in np.flatnonzero(asm.face_block == a):
                if faces is None or faces[f]:
                    height = (asm.block_vertices(b) - asm.planes.centre[f]) @ asm.planes.normal[f]
                    best = max(best, float(height.min()))
            expected.append(best)
        found = face_separation(asm.vertices, asm.vertex_start, asm.planes, asm.face_block, pairs, faces)
        assert found.tolist() == pytest.approx(expected, rel=1e-12)
    assert face_separation(asm.vertices, asm.vertex_start, asm.planes, asm.face_block, pairs[:0]).shape == (0,)


@pytest.mark.parametrize(("dent", "convex"), [(0.3e-6, True), (4e-6, False), (-1.0, True)])
def test_blocks_are_convex_to_a_share_of_their_size(dent, convex):
    outline = [(0, 0), (1, dent), (2, 0), (2, 1), (0, 1)]
    asm = assembly([prism(outline, 0.5), box((3, 0, 0), (4, 1, 1))])
    assert convex_blocks(asm).tolist() == [convex, True]
    assert convex_blocks(asm, tolerance=1e-3).tolist() == [True, True]
    assert convex_blocks(asm, tolerance=np.array([0.0, 1.0])).tolist() == [dent < 0, True]


def sunk(*depths, size=1.0):
    """Cubes side by side, each sunk into the one before by a depth."""
    x, blocks = 0.0, [box((0, 0, 0), (1, 1, 1), name="c0")]
    for k, depth in enumerate(depths, 1):
        x += 1.0 - depth
        blocks.append(box((x, 0.1 * k, 0), (x + size, 0.1 * k + size, size), name=f"c{k}"))
        x += size - 1.0
    return assembly(blocks)


def test_overlaps_beyond_a_tenth_of_the_smaller_block_are_refused_and_the_worst_for_its_size_is_named():
    pairs, shallow = check_overlaps(sunk(0.03, 0.099), gap=0.01)
    assert pairs.tolist() == [[0, 1], [1, 2]]
    assert shallow == ['2 pairs of blocks overlap, the worst "c1" and "c2" by 0.099 m']
    with pytest.raises(
        InputError, match=r'blocks "c1" and "c2" overlap by 0\.101 m; rigid blocks may touch but not overlap'
    ):
        check_overlaps(sunk(0.03, 0.101), gap=0.01)
    assert check_overlaps(sunk(0.009, 0.0), gap=0.01)[1] == []
    near = np.array([[0, 1]])
    assert check_overlaps(sunk(0.03, 0.3), gap=0.01, near=near)[1] == [
        '1 pairs of blocks overlap, the worst "c0" and "c1" by 0.03 m'
    ]
    # .06 of a cube of .5 is worse than .09 of a cube of 1.
    asm = assembly([box((0, 0, 0), (1, 1, 1), name="a"), box((0.91, 0, 0), (1.91, 1, 1), name="b"),
                    box((0, 0, 0.945), (0.5, 0.5, 1.445), name="c")])  # fmt: skip
    with pytest.raises(InputError, match=r'blocks "a" and "c" overlap by 0\.055 m'):
        check_overlaps(asm, gap=0.01)
    assert tell(asm, *overlaps(asm, gap=0.01)) == '2 pairs of blocks overlap, the worst "a" and "c" by 0.055 m'


def test_among_very_many_pairs_the_one_that_overlaps_most_for_its_size_is_named():
    # .6 of a cube of 1 is worse than 5 of a cube of 10, whose centroids are closer for all that cubes of 10 extend.
    asm = assembly([
        box((0, 0, 0), (10, 10, 10), name="a"), box((5, 0, 0), (15, 10, 10), name="b"),
        box((50, 0, 0), (51, 1, 1), name="c"), box((50.4, 0, 0), (51.4, 1, 1), name="d"),
    ])  # fmt: skip
    for order in (1, -1):
        near = np.repeat([[0, 1], [2, 3]], 150, axis=0)[::order]
        with pytest.raises(InputError, match=r'blocks "c" and "d" overlap by 0\.6 m'):
            check_overlaps(asm, gap=0.01, near=near)


def test_an_overlap_counts_beyond_the_gap_of_the_smaller_block():
    for gap, size in ((0.02, 0.02), ("15 mm", 0.015)):
        for share, pairs in ((0.98, 0), (1.02, 1)):
            found, depth = overlaps(sunk(share * size), gap=gap)
            assert len(found) == len(depth) == pairs
    small = sunk(0.012, size=0.5)
    assert overlaps(small, gap=0.02)[0].tolist() == [[0, 1]]  # .01 of the smaller one
    assert overlaps(small, gap=0.03)[0].tolist() == []
    fixed = replace(small, support=np.array([True, True]))
    assert overlaps(fixed, gap=0.001)[0].shape == (0, 2)
    assert overlaps(small, gap=0.001, near=np.empty((0, 2), dtype=int))[1].shape == (0,)


def test_a_block_inside_another_is_named_whichever_is_larger():
    for order in (1, -1):
        blocks = [box((0, 0, 0), (3, 3, 3), name="big"), box((1, 1, 1), (1.5, 1.6, 1.7), name="small")][::order]
        with pytest.raises(InputError, match='block "small" lies inside block "big"; rigid blocks'):
            check_overlaps(assembly(blocks), gap=0.01)


def test_copies_are_counted_and_named_in_order():
    stone = np.asarray(box((0, 0, 0), (1, 2, 3)).vertices, float)
    faces = box((0, 0, 0), (1, 2, 3)).faces

    def at(x, name, points=stone):
        return Block(points + [x, 0, 0], faces, name)

    check_copies(assembly([at(0, "a"), at(5, "b"), at(9, "c")]))
    with pytest.raises(InputError, match=r'^blocks "b" and "d" are copies at one place; rigid blocks'):
        check_copies(assembly([at(0, "a"), at(5, "b"), at(9, "c"), at(5, "d")]))
    with pytest.raises(
        InputError, match=r'blocks "a" and "c" are copies at one place \(2 blocks are copies of others\)'
    ):
        check_copies(assembly([at(0, "a"), at(5, "b"), at(0, "c"), at(5, "d")]))
    # Two supports may be copies, a support and a free block may not.
    check_copies(assembly([at(0, "a"), at(0, "b")], supports=[0, 1]))
    with pytest.raises(InputError, match='blocks "a" and "b"'):
        check_copies(assembly([at(0, "a"), at(0, "b")], supports=[1]))
    size = 6 ** (1 / 3)
    for share, copy in ((0.5e-6, True), (3e-6, False)):
        moved = assembly([at(0, "a"), at(share * size, "b")])
        if copy:
            with pytest.raises(InputError, match="copies"):
                check_copies(moved)
        else:
            check_copies(moved)


def test_a_copy_is_looked_for_with_the_first_one_only():
    stone = box((0, 0, 0), (1, 1, 1))
    beside = box((0.5, 0.2, 0.1), (1.5, 1.2, 1.1))
    asm = assembly([beside, stone, stone, stone])
    assert sorted(map(tuple, overlaps(asm, gap=0.01)[0].tolist())) == [(0, 1), (1, 2), (1, 3)]


def test_contact_data_is_frozen_and_compared_by_identity():
    asm, faces = joints([])
    none = np.empty(0, dtype=int)
    unresolved = Unresolved(np.empty((0, 2), int), np.empty((0, 3)), (), np.empty((0, 3)), none, np.empty((0, 2), int))
    pairs = np.array([[0, 1]])
    search = search_of(asm, pairs, Tolerances(np.ones(3), 1e-6, 0.2), rims=False)
    contacts = Contacts(none, none, listed(THREE).take(none))
    for data in (faces, point_law(asm, faces), unresolved, search, together([crossings(search)]), contacts):
        name = fields(data)[0].name
        with pytest.raises(FrozenInstanceError):
            setattr(data, name, None)
        assert replace(data) != data
        assert len({data, replace(data)}) == 2
    for data in (Tolerances(np.ones(3), 1e-6, 0.2), listed(THREE)):
        with pytest.raises(FrozenInstanceError):
            setattr(data, fields(data)[0].name, None)


def test_options_of_overlaps_are_named():
    assert face_separation(None, None, None, None, []).shape == (0,)
    whole = assembly([box((0, 0, 0), (1, 1, 1))])
    for call in (overlaps, check_overlaps, convex_blocks):
        with pytest.raises(TypeError):
            call(whole, 0.01)


def test_options_of_the_search_are_named():
    whole = assembly([box((0, 0, 0), (1, 1, 1))])
    assert as_searched(whole, 0.01) is whole
    for call in (find_interfaces, near_blocks):
        with pytest.raises(TypeError):
            call(whole, 0.01)
    _, faces = joints([])
    assert unresolved_contacts(None, faces).reason == ()
    with pytest.raises(TypeError):
        unresolved_contacts(None, faces, 0.01)
    none = np.empty(0, dtype=int)
    contacts = Contacts(none, none, None)
    assert contacts.with_more(1, Features(none, *[np.empty((0, 3))] * 2, *[none] * 4), none) is contacts
    with pytest.raises(TypeError):
        search_of(None, none, None, False)


def test_copies_are_found_among_blocks_that_differ_by_the_order_of_their_axes():
    places = [(a, b, 3 - a - b) for a in range(3) for b in range(3) if a != b]
    blocks = [box(np.multiply(p, 5), np.multiply(p, 5) + 1, name=f"b{k}") for k, p in enumerate(places * 2)]
    with pytest.raises(InputError, match=r'blocks "b0" and "b6" are copies at one place \(6 blocks are copies'):
        check_copies(assembly(blocks))
    check_copies(assembly(blocks[:6]))


@pytest.mark.parametrize(("width", "reported"), [(0.0045, True), (0.0035, False)])
def test_what_is_more_than_five_times_as_open_as_wide_is_no_near_miss(width, reported):
    # Two centimetres open, two gaps.
    blocks = [box((0, 0, 0), (1, 1, 1)), box((1.02, 0.1, 1 - width), (2.02, 1.1, 2 - width))]
    dropped = find_interfaces(assembly(blocks)).dropped
    assert [(d.a, d.b, d.reason) for d in dropped] == [(0, 1, "narrow")] * reported
    for d in dropped:
        assert d.value == pytest.approx(0.02)
        assert d.limit == pytest.approx(width, rel=1e-4)


def test_faces_of_three_to_nine_corners_have_each_the_area_and_the_corners_that_they_share():
    floor, blocks, expected = [(0, 0), (11, 0), (11, 40), (0, 40)], [], []
    for k, n in enumerate((3, 4, 5, 6, 7, 8, 9)):
        angle = 2 * pi * np.arange(n) / n + 0.3
        ring = np.column_stack([np.cos(angle) + 1.5 * k, np.sin(angle) * 0.8 + 5 * k + 4])
        foot = np.column_stack([ring, np.zeros(n)])
        faces = [
            list(range(n))[::-1],
            list(range(n, 2 * n)),
            *[[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)],
        ]
        blocks.append(Block(np.concatenate([foot, foot + [0, 0, 1]]), faces))
        common = shapely.Polygon(ring).intersection(shapely.Polygon(floor))
        expected.append((common.area, len(common.exterior.coords) - 1))
    found = find_interfaces(assembly([box((0, 0, -1), (11, 40, 0)), *blocks]))
    assert found.pair.tolist() == [[0, k] for k in range(1, 8)]
    assert found.area == pytest.approx([area for area, _ in expected])
    assert np.diff(found.start).tolist() == [corners for _, corners in expected]


@pytest.mark.filterwarnings("error")
def test_faces_of_many_forms_beside_each_other_divide_nothing_by_nothing():
    # A floor with a notch, and on it, beside it and in its notch feet of three to six corners; some only touch.
    floor = prism([(0, -1), (9, -1), (9, 0), (6, 0), (6, -0.3), (5, -0.3), (5, 0), (0, 0)], 2.0)
    rings = [
        [(0.5, 0.5), (1.5, 0.4), (1.0, 1.4)], [(2, 0.3), (3, 0.3), (3, 1.2), (2, 1.0)],
        [(3.5, -1.0), (4.5, -1.0), (4.8, 0.2), (4.0, 0.6), (3.2, 0.0)],
        [(7, 2), (7.5, 1.8), (8, 2), (8, 2.5), (7.5, 2.8), (7, 2.5)], [(9, 0.5), (9.5, 0.2), (9.5, 0.9)],
    ]  # fmt: skip
    feet = [hull([*[(x, y, 0) for x, y in ring], (*np.mean(ring, axis=0), 1.0)]) for ring in rings]
    asm = assembly([floor, *feet, box((5.2, 0.4, -0.3), (5.8, 1.5, 0.4))])
    found = find_interfaces(asm)
    area = [shapely.Polygon(ring).intersection(shapely.box(0, 0, 9, 2)).area for ring in rings]
    on_floor = {b: size for (a, b), size in zip(found.pair.tolist(), found.area.tolist(), strict=True) if a == 0}
    assert [on_floor.get(k, 0.0) for k in range(1, 7)] == pytest.approx([*area, 0.6 * 1.1])
    unresolved_contacts(asm, found)


@pytest.mark.filterwarnings("error")
def test_a_face_with_two_corners_at_one_place_is_as_convex_as_without():
    stone, dented = box((0, 0, 0), (1, 1, 1)), prism([(0, 0), (1, 0.4), (2, 0), (2, 1), (0, 1)], 0.5)
    for block in (stone, dented):
        corners = np.asarray(block.vertices, float)
        for number in range(len(block.faces)):
            faces = [list(face) for face in block.faces]
            faces[number].insert(1, len(corners))
            twice = Block(np.concatenate([corners, corners[[faces[number][0]]]]), faces)
            assert convex_faces(assembly([twice])).tolist() == convex_faces(assembly([block])).tolist()


def random_hull(rng, size=1.0):
    return outline_hull(rng.normal(size=(9, 2)) * [size, 0.3 * size])


@pytest.mark.parametrize("seed", range(6))
def test_corners_stand_for_the_area_and_its_first_moment_in_any_order(seed):
    rng = np.random.default_rng(seed)
    polygons = [random_hull(rng), np.array([(0.0, 0.0), (2.0, 1.0)]), random_hull(rng, 1e-3) + 5, np.zeros((1, 2))]
    orders = [rng.permutation(len(p)) for p in polygons]
    mixed = [p[order] for p, order in zip(polygons, orders, strict=True)]
    start = np.cumsum([0, *map(len, mixed)])
    shares = np.split(corner_shares(np.concatenate(mixed), start), start[1:-1])
    for polygon, order, share in zip(polygons, orders, shares, strict=True):
        assert share.sum() == pytest.approx(1.0)
        if len(polygon) < 3:
            assert (share == 1 / len(polygon)).all()
            continue
        assert (share > 0).all()
        centroid = shapely.Polygon(polygon).centroid
        assert share @ polygon[order] == pytest.approx([centroid.x, centroid.y], abs=1e-12)
        alone = corner_shares(polygon, np.array([0, len(polygon)]))
        assert share == pytest.approx(alone[order])


@pytest.mark.parametrize("seed", range(6))
def test_corners_of_a_hull_stand_for_the_patches_in_it(seed):
    """Their area, its first moment, and no less than the mean of a convex function: the arm of cohesion in torsion."""
    rng = np.random.default_rng(seed)
    parts = [random_hull(rng, size) + rng.uniform(-9, 9, 2) for size in (1.0, 0.2, 2.0)]
    parts += [rng.uniform(-9, 9, (2, 2)), rng.uniform(-9, 9, (1, 2))]
    hull = outline_hull(np.concatenate(parts))
    share = shares_of_parts(hull, parts)
    solid = [shapely.Polygon(p) for p in parts[:3]]
    area = sum(p.area for p in solid)
    moment = sum(p.area * np.array([p.centroid.x, p.centroid.y]) for p in solid)
    assert share.sum() == pytest.approx(1.0)
    assert (share >= 0).all()
    assert share @ hull == pytest.approx(moment / area)
    order = rng.permutation(len(hull))
    assert shares_of_parts(hull[order], parts[::-1]) == pytest.approx(share[order])
    for pole in rng.uniform(-9, 9, (5, 2)):
        inner = sum(
            np.linalg.norm(np.mean(t, axis=0) - pole) * shapely.Polygon(t).area / area
            for p in solid
            for t in triangles_of(p, 12)
        )
        assert share @ np.linalg.norm(hull - pole, axis=1) >= inner


def triangles_of(polygon, cuts):
    """Triangles of a convex polygon, those about its centroid cut in strips; their means give less than the area."""
    corners = np.array(polygon.exterior.coords)[:-1]
    centre = np.array([polygon.centroid.x, polygon.centroid.y])
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        for k in range(cuts):
            a, b = one + (two - one) * k / cuts, one + (two - one) * (k + 1) / cuts
            yield [centre, a, b]


def test_a_patch_that_fills_its_hull_in_pieces_is_one_patch():
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    (found,) = joined_convex([square[[0, 1, 2]], square[[0, 3, 2]]])
    assert sorted(map(tuple, found.tolist())) == sorted(map(tuple, square.tolist()))
    assert len(joined_convex([square, square[:, ::-1] + [1.0, 0.5]])) == 2
    assert joined_convex([square[[0, 1, 1]]]) == []


@pytest.mark.parametrize(("seed", "sunk"), [*((seed, 0.0) for seed in (0, 1, 2, 324)), (1235, 1e-4)])
def test_a_concave_joint_has_its_area_however_it_lies(seed, sunk):
    """An L of three squares of .25 m2 on its like: the triangles that its face is cut into may be all but flat."""
    plan, turn = (
        [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)],
        Rotation.random(random_state=seed).as_matrix(),
    )
    lying = [(prism(plan, depth), top) for depth, top in ((0.5, 0.0), (0.3 + sunk, 0.3))]
    blocks = [
        replace(block, vertices=(block.vertices[:, [0, 2, 1]] * (1, 1, -1) + (0, 0, top)) @ turn.T)
        for block, top in lying
    ]
    assert find_interfaces(assembly(blocks)).area.sum() == pytest.approx(0.75, rel=1e-3)


def test_a_ring_has_the_area_of_the_ring():
    ring = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
    pieces = convex_polygons(shapely.Polygon(ring[:4], [ring[5:9]]))
    assert sum(shapely.Polygon(p).area for p in pieces) == pytest.approx(12.0)
    assert shapely.union_all([shapely.Polygon(p) for p in pieces]).area == pytest.approx(12.0)
    assert len(pieces) <= 6
