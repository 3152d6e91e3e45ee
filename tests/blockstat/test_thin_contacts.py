"""Edges and corners that touch, in all that reads contacts: forces, limits, laws, pictures, words, derivatives.

The contacts are written down by hand (tests/thin_contacts.py), the values by statics, as in
tests/validation/test_edges_and_corners.py.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    JointLaw,
    assess,
    friction_limit,
    limit_load,
    plot_forces,
    plot_utilisation,
    read,
    settlement,
    thrust_range,
    tilt_limit,
    write,
    write_verdict,
)
from blockstat.app.words import Known, block_card, numbers
from blockstat.contact.cells import centres, refine
from blockstat.contact.features import ContactKind
from blockstat.design_search.shared_joints import SharedJoints
from blockstat.sensitivity.vertices import limit_load_by_point, score_by_point
from blockstat.view.painter import view_of
from blockstat.view.three_d.geometry import contacts_without_area
from blockstat.view.utilisation import eccentricity, utilisation
from evidence.scenes.small import assembly, box, stack
from thin_contacts import contacts, extruded, in_groove, ladder, on_keels, on_one_ridge, on_ridges, on_three_corners

LENGTH, THICK, SIN, COS = 4.0, 0.2, np.sin(np.pi / 3), np.cos(np.pi / 3)  #: of the ladder
#: The thrust of a smooth wall on the ladder per weight, and the friction that it needs on the floor.
LADDER_WALL = (LENGTH * COS - THICK * SIN) / (2 * LENGTH * SIN)
TRIPOD = (np.sqrt(2 / 3) + 0.1) / 4  #: height of the centroid of the tetrahedron on three corners


def pushed_from_its_wall(mu):
    """Multiplier at which the ladder slides at both its ends or turns about its foot."""
    x, z = (LENGTH * COS - THICK * SIN) / 2, (LENGTH * SIN + THICK * COS) / 2
    arm = LENGTH * (SIN + mu * COS) / (1 + mu**2)
    return min((mu * arm - x) / (arm - z), x / z)


def found(scene, direction, **options):
    asm, rules = scene
    return limit_load(asm, direction, interfaces=contacts(asm, rules), **options)


@pytest.mark.parametrize(
    ("scene", "direction", "expected"),
    [
        # A box of height h tips over a ridge at c: (c - e) / (h / 2), or slides at mu.
        (on_ridges(), (1, 0, 0), 0.5),
        (on_ridges(eccentric=0.1), (1, 0, 0), 1 / 3),
        (on_ridges(eccentric=0.1), (-1, 0, 0), 2 / 3),
        (on_ridges(mu=0.4), (1, 0, 0), 0.4),
        (ladder(0.5), (1, 0, 0), pushed_from_its_wall(0.5)),
        (ladder(0.7), (1, 0, 0), pushed_from_its_wall(0.7)),
        # Over a side, 1 / (2 sqrt 3) off the middle, or over a corner, twice as far.
        (on_three_corners(10.0, 0.0), (0, -1, 0), np.sqrt(2)),
        (on_three_corners(10.0, 0.1), (0, -1, 0), 1 / (2 * np.sqrt(3) * TRIPOD)),
        (on_three_corners(10.0, 0.1), (0, 1, 0), 1 / (np.sqrt(3) * TRIPOD)),
        (on_three_corners(0.5, 0.1), (0, 1, 0), 0.5),
        # Across 1, along mu sqrt 2 / sqrt(1 - mu^2): the edges wedge it.
        (in_groove(0.2), (1, 0, -1), 1.0),
        (in_groove(0.2), (0, 1, 0), 0.2 * np.sqrt(2 / 0.96)),
        (in_groove(0.5), (0, 1, 0), 0.5 * np.sqrt(2 / 0.75)),
    ],
)
def test_limit_loads_on_edges_and_corners(scene, direction, expected):
    limit = found(scene, direction)
    assert (limit.lower, limit.upper) == pytest.approx((expected, expected), abs=1e-6)


@pytest.mark.parametrize("degrees", [0, 30, 60, 90])
def test_limit_load_of_crossed_keels(degrees):
    asm, _ = on_keels()
    x, y = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    height = asm.centroid[2, 2]
    expected = 1 / max(height * abs(x) / 0.2, height * abs(y) / 0.35, 1.0)
    assert found(on_keels(), (x, y, 0)).lower == pytest.approx(expected, abs=1e-6)


def test_a_turned_ladder_has_the_same_limit():
    # Upright along the axes it is solved in its plane; turned, with exact cones.
    asm, rules = ladder(0.5)
    x, y = np.cos(0.4), np.sin(0.4)
    turned = replace(asm, vertices=asm.vertices @ np.array([[x, y, 0], [-y, x, 0], [0, 0, 1]]))
    assert found((turned, rules), (x, y, 0)).lower == pytest.approx(pushed_from_its_wall(0.5), abs=1e-6)


def test_a_ladder_needs_its_friction_and_pushes_its_wall():
    asm, rules = ladder()
    faces = contacts(asm, rules)
    needed = (np.sqrt(LENGTH**2 - (THICK * SIN) ** 2) - LENGTH * SIN) / (LENGTH * COS + THICK * SIN)
    assert friction_limit(asm, interfaces=faces).value == pytest.approx(needed, abs=2e-6)
    weight = asm.free_weight
    smooth = asm.with_(groups=asm.names, joints=[JointLaw(("wall", "*"), friction=0.0)])
    assert friction_limit(smooth, interfaces=faces).value == pytest.approx(LADDER_WALL, abs=2e-6)
    only = thrust_range(smooth, ["wall"], (-1, 0, 0), interfaces=faces)
    assert (only.least, only.greatest) == pytest.approx((LADDER_WALL * weight,) * 2, rel=1e-6)
    thrust = thrust_range(asm, ["wall"], (-1, 0, 0), interfaces=faces)
    # Friction at the wall takes from the thrust or adds to it; the smooth wall lies between.
    assert thrust.least < LADDER_WALL * weight < thrust.greatest
    moved = settlement(asm, ["wall"], (-1, 0, 0), interfaces=faces)
    assert moved.outcome.word == "pushes"
    assert moved.reaction == pytest.approx(thrust.least, rel=1e-6)
    assert thrust.summary()["contacts"] == {"face": 0, "edge": 2, "corner": 0, "crossing": 0}
    assert moved.summary()["contacts"]["edge"] == 2


def test_tilt_of_a_box_on_ridges():
    asm, rules = on_ridges(mu=0.8)
    tilt = tilt_limit(asm, "y", interfaces=contacts(asm, rules))
    assert np.tan(np.deg2rad(tilt.value)) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_coulomb_limit_along_a_groove_is_below_the_associated_one(mu):
    # Without dilatancy the prism slides at mu / sin 45, before the edges wedge it.
    low, high = found(in_groove(mu), (0, 1, 0), flow="coulomb").coulomb
    assert low - 1e-6 <= mu * np.sqrt(2) <= high + 1e-6
    assert high - low < 1e-3


def test_a_block_that_turns_about_an_edge_hinges_there():
    joints = found(ladder(0.7), (1, 0, 0)).joints()
    assert joints == {"hinges": [("floor", "ladder")], "sliding": [], "opening": [("wall", "ladder")]}
    joints = found(ladder(0.5), (1, 0, 0)).joints()
    assert joints["sliding"] == [("floor", "ladder"), ("wall", "ladder")]
    joints = found(on_three_corners(10.0), (0, -1, 0)).joints()
    assert (len(joints["hinges"]), len(joints["opening"])) == (2, 1)


def test_words_count_contacts_by_kind():
    asm, rules = on_ridges()
    verdict = assess(asm, interfaces=contacts(asm, rules))
    assert verdict.summary()["contacts"] == {"face": 0, "edge": 2, "corner": 0, "crossing": 0}
    assert "Contacts: 2 edge." in verdict.explain()
    assert "2 edge" in numbers(Known(verdict))
    assert "left (edge)" in block_card(verdict, 2)
    limit = found(on_keels(), (1, 0, 0))
    assert limit.summary()["contacts"]["crossing"] == 4
    assert "Contacts: 4 crossing." in limit.explain()


def test_words_count_no_contacts_where_all_are_faces():
    asm, rules = on_one_ridge()
    assert "Contacts: 1 edge." in assess(asm, interfaces=contacts(asm, rules)).explain()
    assert "Contacts" not in assess(stack(1)).explain()


def test_a_subset_keeps_points_kinds_and_frames():
    asm, rules = on_ridges()
    faces = contacts(asm, rules)
    one = faces.subset(np.array([1]))
    assert (one.pair.tolist(), one.kinds.tolist(), one.start.tolist()) == ([[1, 2]], [ContactKind.EDGE], [0, 2])
    np.testing.assert_array_equal(one.point, faces.point[2:])
    assert faces.subset(np.array([False, False])).n_points == 0


# Joint laws


def test_compressive_strength_leaves_nothing_to_an_edge_and_says_so():
    asm, rules = on_ridges()
    crushed = asm.with_(joints=[JointLaw(("*", "*"), compression=1e9)])
    verdict = assess(crushed, interfaces=contacts(asm, rules))
    # It would fall, but only by crushing edges until they have an area, which proves nothing.
    assert verdict.outcome.word == "undecided"
    assert verdict.floating.tolist() == [2]
    # Lifted off by its weight, it falls for sure.
    up = assess(crushed, interfaces=contacts(asm, rules), gravity=(0, 0, 1))
    assert up.outcome.word == "unstable"
    [said] = [text for text in verdict.warnings if "area" in text]
    assert '"left" and "box"' in said
    assert '"right" and "box"' in said
    assert assess(asm, interfaces=contacts(asm, rules)).outcome.word == "stable"


def test_strengths_and_glue_give_nothing_to_an_edge():
    asm, rules = on_ridges()
    weight = asm.free_weight
    laws = [
        JointLaw(("*", "*"), tension=1e9, cohesion=1e9),
        JointLaw(("*", "*"), bond=weight),
        JointLaw(("*", "*"), bond=weight, bond_moment=weight),
    ]
    for law in laws:
        assert found((asm.with_(joints=[law]), rules), (1, 0, 0)).lower == pytest.approx(0.5, abs=1e-6)


def test_cells_leave_edges_and_corners_as_they_are():
    for scene, middle in ((on_ridges(), (-0.3, 0.4, 0.0)), (on_three_corners(), (0.0, 1 / np.sqrt(3), 0.0))):
        faces = contacts(*scene)
        cut = refine(faces, np.full(faces.n_interfaces, 8))
        np.testing.assert_array_equal(cut.point, faces.point)
        np.testing.assert_allclose(np.add.reduceat(cut.point_share, cut.start[:-1]), 1.0)
        for own in (faces, cut):
            np.testing.assert_allclose(centres(own, np.array([0]))[0], middle, atol=1e-12)


def test_contacts_are_handed_on_in_a_search():
    asm, rules = ladder()
    faces, joints = contacts(asm, rules), SharedJoints()
    joints.kept(lambda design: assess(design, interfaces=faces))(asm)

    def verify(design, interfaces=None):
        return interfaces

    handed = joints.handed(verify)(asm)
    assert handed.kinds.tolist() == [ContactKind.EDGE] * 2


# Pictures and files


def test_an_edge_is_eccentric_along_itself_and_a_corner_nowhere():
    edges, corners = contacts(*on_ridges()), contacts(*on_three_corners())
    # The first runs from y = 0 to .8, the second from .1 to .7; across the edge nothing counts.
    at = np.array([[-0.3, 0.6, 0.0], [0.3, 0.7, 0.0]])
    np.testing.assert_allclose(eccentricity(edges, at), [0.5, 1.0], atol=1e-12)
    np.testing.assert_array_equal(eccentricity(corners, corners.point), 0.0)


def test_corners_about_to_slide_use_all_their_friction():
    asm, rules = on_three_corners(0.3)
    verdict = assess(asm, gravity=(0.2999, 0, -1), interfaces=contacts(asm, rules))
    assert verdict.outcome.word == "stable"
    assert (utilisation(verdict) > 0.99).all()
    assert (verdict.demand()[1:] > 0.99).all()


@pytest.mark.parametrize("draw", [plot_forces, plot_utilisation])
@pytest.mark.parametrize(
    ("scene", "lines", "dots"), [(on_ridges(), 2, 0), (on_keels(), 0, 4), (on_three_corners(), 0, 3)]
)
def test_pictures_show_edges_as_lines_and_corners_as_dots(draw, scene, lines, dots, tmp_path):
    from matplotlib.collections import LineCollection, PathCollection
    from matplotlib.figure import Figure

    faces = contacts(*scene)
    verdict = assess(scene[0], interfaces=faces)
    axes = draw(verdict, Figure().add_subplot(), azimuth=20.0, elevation=30.0)
    flat = faces.point @ view_of(20.0, 30.0)[:2].T
    drawn = [c.get_segments() for c in axes.collections if isinstance(c, LineCollection)]
    assert {len(segments) for segments in drawn} == {lines}
    for segments in drawn[-1:] if lines else ():
        np.testing.assert_allclose(sorted(map(tuple, np.concatenate(segments))), sorted(map(tuple, flat)), atol=1e-9)
    places = [c.get_offsets() for c in axes.collections if isinstance(c, PathCollection)]
    assert sum(map(len, places)) == dots
    if dots:
        np.testing.assert_allclose(sorted(map(tuple, places[0])), sorted(map(tuple, flat)), atol=1e-9)
    assert draw(verdict, tmp_path / "joints.png").stat().st_size > 1000


def test_three_d_shows_edges_as_lines_and_corners_as_dots():
    lines, dots = contacts_without_area(contacts(*on_ridges()))
    assert (lines.shape, dots.shape) == ((2, 2, 3), (0, 3))
    lines, dots = contacts_without_area(contacts(*on_keels()))
    assert (lines.shape, dots.shape) == ((0, 2, 3), (4, 3))


def test_a_page_in_three_dimensions_draws_and_removes_them():
    pytest.importorskip("viser")
    from blockstat.view.three_d.canvas import Canvas
    from blockstat.view.three_d.page import interactive_html, start_viser, stop_viser

    server, _ = start_viser(port=0)
    try:
        canvas, drawn = Canvas(server), []
        for scene in (on_ridges(), on_keels(), on_ridges()):
            canvas.recentre(scene[0])
            canvas.contacts(*contacts_without_area(contacts(*scene)), 0.01)
            drawn.append(sorted(server.scene._handle_from_node_name))
    finally:
        stop_viser(server)
    assert [[name for name in names if name.startswith("/contacts/")] for names in drawn] == [
        ["/contacts/edges"], ["/contacts/corners"], ["/contacts/edges"],
    ]  # fmt: skip
    asm, rules = on_ridges()
    verdict = assess(asm, interfaces=contacts(asm, rules))
    assert "<html" in interactive_html(verdict, forces=True).lower()


@pytest.mark.parametrize(
    ("name", "format"), [("a.json", None), ("a.obj", None), ("a.json", "compas-assembly"), ("a.json", "compas-model")]
)
def test_blocks_on_edges_come_back_from_files(name, format, tmp_path):
    asm, rules = ladder()
    path = write(asm, tmp_path / name, **({} if format is None else {"format": format}))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        back = read(path, supports=["floor", "wall"])
    again = assess(back.with_(friction=0.5, gravity=asm.gravity), interfaces=contacts(back, rules))
    assert again.outcome.word == "stable"
    limit = limit_load(back.with_(friction=0.5, gravity=asm.gravity), (1, 0, 0), interfaces=contacts(back, rules))
    assert limit.lower == pytest.approx(pushed_from_its_wall(0.5), abs=1e-5)


def test_a_verdict_on_edges_is_written_with_its_demand(tmp_path):
    asm, rules = ladder(0.25)
    verdict = assess(asm, interfaces=contacts(asm, rules))
    assert verdict.demand()[2] > 0.95  # .2449 would be enough
    assert "demand" in write_verdict(verdict, tmp_path / "ladder.obj").read_text()


# Derivatives


def prismatic(points, rng):
    """A motion of all points that is the same along y."""
    _, line = np.unique(np.round(points[:, [0, 2]], 6), axis=0, return_inverse=True)
    motion = np.zeros_like(points)
    motion[:, [0, 2]] = rng.normal(size=(line.max() + 1, 2))[line.reshape(-1)]
    return motion


def any_motion(points, rng):
    """A random motion of all points."""
    return rng.normal(size=points.shape)


def leaning_keels():
    """The body on three of the four crossings, between which its centroid lies with this gravity."""
    asm, rules = on_keels(0.2)
    return asm.with_(gravity=np.array([-0.05, -0.04, -1.0])), rules[:3]


GRADIENTS = {
    "edge, tips": (on_ridges(), (1, 0, 0), any_motion),
    "edge, tips lengthwise": (on_ridges(), (0, 1, 0), any_motion),
    "edge, slides": (on_ridges(0.2), (1, 0.3, 0), any_motion),
    "ladder, turns": (ladder(0.7), (1, 0, 0), prismatic),
    "ladder, slides": (ladder(0.5), (1, 0, 0), prismatic),
    "crossing, tips": (on_keels(), (1, 0.2, 0), any_motion),
    "crossing, slides": (leaning_keels(), (-1, -0.3, 0), any_motion),
    "corner, tips": (on_three_corners(10.0), (0.1, -1, 0), any_motion),
    "corner, slides": (on_three_corners(0.3), (0.1, 1, 0), any_motion),
}


@pytest.mark.parametrize("name", GRADIENTS)
def test_limit_load_by_vertices_against_central_differences(name):
    (asm, rules), direction, motion_of = GRADIENTS[name]
    limit = found((asm, rules), direction)
    assert bool(limit.joints()["sliding"]) == ("slides" in name)
    gradient = limit_load_by_point(limit, direction)
    motion = motion_of(gradient.points, np.random.default_rng(3))

    def slope(step):
        ends = [replace(asm, vertices=asm.vertices + s * motion[gradient.vertex_point]) for s in (step, -step)]
        limits = [found((end, rules), direction) for end in ends]
        return np.diff([limit.lower + limit.upper for limit in limits[::-1]])[0] / (4 * step)

    # Richardson: the error of central differences goes with the square of the step.
    wide, narrow = slope(2e-3), slope(1e-3)
    assert gradient.along(motion) == pytest.approx((4 * narrow - wide) / 3, rel=2e-5, abs=2e-5)


@pytest.mark.parametrize("scene", [on_ridges(), on_keels(), on_three_corners()])
def test_score_by_vertices_against_central_differences(scene):
    asm, rules = scene
    asm = asm.with_(gravity=np.array([3.0, 0.2, -1.0]))

    def score(vertices):
        end = replace(asm, vertices=vertices)
        return assess(end, interfaces=contacts(end, rules))

    gradient = score_by_point(score(asm.vertices))
    motion = any_motion(gradient.points, np.random.default_rng(4))[gradient.vertex_point]
    ends = [score(asm.vertices + s * motion).score for s in (1e-3, -1e-3)]
    by_point = any_motion(gradient.points, np.random.default_rng(4))
    assert gradient.value > 0
    assert gradient.along(by_point) == pytest.approx((ends[0] - ends[1]) / 2e-3, rel=1e-4)


def test_place_and_scale_of_blocks_on_edges_change_nothing():
    for scene in (on_ridges(), on_keels(), on_three_corners(10.0)):
        gradient = limit_load_by_point(found(scene, (1, 0.2, 0)), (1, 0.2, 0))
        size = np.abs(gradient.gradient).sum()
        np.testing.assert_allclose(gradient.gradient.sum(axis=0), 0.0, atol=1e-6 * size)
        assert gradient.along(gradient.points) == pytest.approx(0.0, abs=1e-6 * size)


@pytest.mark.parametrize(
    ("scene", "direction"),
    [
        (on_ridges(), (1, 0, 0)),
        (ladder(), (1, 0, 0)),
        (on_keels(), (1, 0.2, 0)),
        (on_three_corners(10.0), (0.1, -1, 0)),
    ],
)
def test_contacts_that_are_searched_for_give_the_same_derivatives(scene, direction):
    by_hand = limit_load_by_point(found(scene, direction), direction)
    searched = limit_load_by_point(limit_load(scene[0], direction), direction)
    np.testing.assert_allclose(searched.gradient, by_hand.gradient, atol=1e-8)


def test_a_foot_and_a_keel_on_one_floor_have_derivatives():
    # One contact: the patch of the foot with the edge of the keel. Corners of the body on the floor stay on it.
    outline = [(-0.4, 0), (-0.2, 0), (-0.1, 0.1), (0.1, 0.1), (0.3, 0), (0.4, 0.2), (0.4, 1), (-0.4, 1)]
    asm = assembly([box((-1, -1, -1), (1, 2, 0)), extruded(outline, 0.0, 0.8)])
    gradient = limit_load_by_point(limit_load(asm, (1, 0, 0)), (1, 0, 0))
    centre = asm.centroid[1]
    assert gradient.value == pytest.approx((0.3 - centre[0]) / centre[2], abs=1e-6)
    motion = any_motion(gradient.points, np.random.default_rng(1))
    motion[gradient.points[:, 2] <= 0, 2] = 0.0

    def slope(step):
        ends = [replace(asm, vertices=asm.vertices + s * motion[gradient.vertex_point]) for s in (step, -step)]
        return np.diff([limit_load(end, (1, 0, 0)).lower for end in ends[::-1]])[0] / (2 * step)

    assert gradient.along(motion) == pytest.approx((4 * slope(1e-3) - slope(2e-3)) / 3, rel=2e-5)
