"""Edges and corners slide on a face as far as it reaches, and carry nothing beyond its rim."""

import numpy as np
import pytest

from blockstat import Assembly, Block, box, capacity, find_interfaces, settle_to_collapse
from blockstat.large_displacement.displaced.contact_pairs import edge_crossings, pair_points, pairs_at_rest
from blockstat.large_displacement.displaced.loads import read_loads
from blockstat.large_displacement.displaced.pose import rest_pose, rotation_matrices
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.overlap.edge_overlap import cut_to_faces
from blockstat.model.solids import polyhedron, prism

FAR = (5e5, 5.4e6, 0.0)
#: Turn about the vertical [rad], place [m], scale, and order of the blocks.
AS_DRAWN = (0.0, (0.0, 0.0, 0.0), 1.0, 1)
ELSEWHERE = [(0.7, FAR, 1.0, -1), (3.81, (0.0, 0.0, 0.0), 1e-2, -1), (5.5, FAR, 30.0, 1)]
PLACES = [AS_DRAWN, *ELSEWHERE]
GROUNDS = [box((-1, 0, -1), (0, 1, 0), name="L"), box((2, 0, -1), (3, 1, 0), name="R")]


def extruded(name, profile, low, high, across=(1, 0, 0), along=(0, 1, 0)):
    """A prism of a profile, whose places are along `across` and z, from low to high along another axis."""
    drawn = np.array([np.multiply(place, across) + (0, 0, z) for place, z in profile], dtype=float)
    return prism(*(drawn + end * np.array(along, dtype=float) for end in (low, high)), name=name)


def ridge(name, place, half=0.0):
    """A support that bears on an upright edge along y, or on a flat strip of twice the half width."""
    top = [(place + half, 0), (place - half, 0)] if half else [(place, 0)]
    return extruded(name, [(place - 0.5, -1), (place + 0.5, -1), *top], 0, 1)


def beam(foot):
    """A beam on a flat foot from x = -.4 to 0, which has nearly all its weight, and on another one from x = 2.2 on."""
    toe = [(2.2, 0), (2.2 + foot, 0)] if foot else [(2.2, 0)]
    return extruded("beam", [(-0.4, 0), (0, 0), (0, 0.3), (2, 0.3), *toe, (2.4, 0.3), (2.4, 0.5), (-0.4, 1.2)], 0, 1)


def beam_on_a_tip():
    """The beam with a pyramid for its second foot, whose tip is at (2.2, .5)."""
    sharp = beam(0.0)
    tips = np.flatnonzero((sharp.vertices[:, 2] == 0) & (sharp.vertices[:, 0] > 2))
    vertices = np.vstack([sharp.vertices, [[2.2, 0.5, 0.0]]])
    tip, faces = len(sharp.vertices), []
    for face in map(list, sharp.faces):
        if {*tips} <= {*face}:  # a flank of the edge becomes one of the pyramid
            faces.append([k if k not in tips else tip for k in face if k != tips[1]])
        elif {*tips} & {*face}:  # an end of the beam without the tip, and the triangle that leans in
            at = next(i for i, k in enumerate(face) if k in tips)
            faces.append([k for k in face if k not in tips])
            faces.append([face[at - 1], tip, face[(at + 1) % len(face)]])
        else:
            faces.append(face)
    used = sorted({k for face in faces for k in face})
    return polyhedron(vertices[used], [[used.index(k) for k in face] for face in faces], name="beam")


def sled(along_x, low=0.1, high=0.9):
    """A block of .4 m on two runners, upside down roofs of .2 m, whose edges are at .2 and .8, across x or along it."""
    profile = [(0.2, 1), (0.4, 1.2), (0.6, 1.2), (0.8, 1), (0.9, 1.2), (0.9, 1.6), (0.1, 1.6), (0.1, 1.2)]
    axes = ((0, 1, 0), (1, 0, 0)) if along_x else ((1, 0, 0), (0, 1, 0))
    return extruded("sled", profile, low, high, *axes)


def scene_of(blocks, supports, friction, place):
    """An assembly turned about the vertical, scaled and moved, its blocks in another order; the turn; the scale."""
    turn, offset, scale, order = place
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    moved = [Block(scale * each.vertices @ rotation.T + offset, each.faces, name=each.name) for each in blocks]
    return Assembly.from_blocks(moved[::order], supports=supports, friction=friction), rotation, scale


def collapse_of(blocks, move, friction, place, supports=("L", "R")):
    """The movement of R at which an assembly falls, as drawn [m]."""
    scene, rotation, scale = scene_of(blocks, supports, friction, place)
    path = settle_to_collapse(scene, {"R": rotation @ move}, displacement=0.8 * scale)
    assert path.outcome.word == "collapse"
    return path.collapse / scale


def curve_of(blocks, load, control, friction, place, supports, flow="coulomb"):
    """The curve of an assembly, and its displacements as drawn [m]."""
    scene, rotation, scale = scene_of(blocks, supports, friction, place)
    curve = capacity(scene, rotation @ load, control=control, flow=flow)
    return curve, curve.displacement / scale


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("foot", "expected"), [(0.0, 0.2), (0.02, 0.22), (0.1, 0.3)])
def test_a_beam_falls_when_its_sharp_foot_reaches_the_rim_as_a_blunt_one_does(place, foot, expected):
    """R, whose top is from x = 2 to 3, moves away below a foot that begins at x = 2.2.

    The foot on L has more weight and so more friction, which holds the beam. So the foot on R slides, and has left R
    after .2 m and its own width.
    """
    assert collapse_of([*GROUNDS, beam(foot)], (1, 0, 0), 0.5, place) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("place", PLACES)
def test_a_beam_falls_when_its_pointed_foot_reaches_the_rim(place):
    """As above, with a corner at x = 2.2."""
    assert collapse_of([*GROUNDS, beam_on_a_tip()], (1, 0, 0), 0.5, place) == pytest.approx(0.2, abs=1e-5)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("half", "expected"), [(0.0, 0.1), (0.001, 0.101)])
def test_a_lintel_falls_when_its_end_reaches_the_ridge_that_bears_it(place, half, expected):
    """A lintel from x = -.1 to 2.3 is on ridges at 0 and 2, and R moves away.

    Its middle is at 1.1, so R carries more and holds it. On L it slides until its end, .1 m from the ridge, is there.
    """
    blocks = [ridge("L", 0, half), ridge("R", 2, half), box((-0.1, 0, 0), (2.3, 1, 0.4), name="lintel")]
    assert collapse_of(blocks, (1, 0, 0), 0.7, place) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("place", PLACES)
def test_a_lintel_falls_when_the_ends_of_its_keels_reach_the_ridge(place):
    """As above, where two edges below the lintel cross the ridges: a crossing ends where one of its edges ends."""
    profile = [(0, 0.3), (0.25, 0), (0.5, 0.3), (0.75, 0), (1, 0.3), (1, 0.5), (0, 0.5)]
    lintel = extruded("lintel", profile, -0.1, 2.3, (0, 1, 0), (1, 0, 0))
    blocks = [ridge("L", 0), ridge("R", 2), lintel]
    assert collapse_of(blocks, (1, 0, 0), 0.7, place) == pytest.approx(0.1, abs=1e-5)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("made", [lambda: beam(0.0), beam_on_a_tip])
def test_the_curve_of_a_beam_ends_where_its_sharp_foot_leaves_the_ground(place, made):
    """Pushed towards -x, both feet slide at friction .5, and the second one is at the rim of R after .2 m."""
    curve, displacement = curve_of([*GROUNDS, made()], (-1, 0, 0), "beam", 0.5, place, ["L", "R"])
    assert curve.outcome.word == "collapse"
    assert curve.lower == pytest.approx(0.5, rel=1e-6)
    # The beam may turn as it slides, by the speed below which contacts stick: a ten-thousandth, 2 m away.
    assert displacement[-1] == pytest.approx(0.2, abs=2e-4)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("flow", ["coulomb", "associated"])
def test_a_sled_falls_when_the_force_of_its_front_runner_leaves_the_bed(place, flow):
    """Runners at x = .2 and .8, across x, slide on a bed that ends at 1, at friction .3.

    After a slip d the edge is at .8 + d. With dilatancy it is .3 d above the bed, and its force, which leans back by .3
    as it presses, meets the bed .3 x .3 d further on. So (1 + .09) d = .2 then.
    """
    blocks = [box((0, 0, 0), (1, 1, 1), name="bed"), sled(along_x=False)]
    curve, displacement = curve_of(blocks, (1, 0, 0), "sled", 0.3, place, ["bed"], flow)
    assert curve.outcome.word == "collapse"
    assert curve.lower == pytest.approx(0.3, rel=1e-6)
    assert displacement[-1] == pytest.approx(0.2 if flow == "coulomb" else 0.2 / 1.09, abs=1e-5)


@pytest.mark.parametrize("place", PLACES)
def test_runners_keep_the_part_that_is_on_the_bed(place):
    """Runners along x, from .1 to .9, slide along themselves over the rim of a bed that ends at 1, at friction .3.

    Their front ends pass the rim after .1 m. The resultant of the weight and of the push meets the bed .3 h further on
    than the centre, which is at .5 + d and h above the bed. That is at the rim where d = .5 - .3 h. From there on the
    sled tips about the rim, and the multiplier falls.
    """
    runners = sled(along_x=True)
    blocks = [box((0, 0, 0), (1, 1, 1), name="bed"), runners]
    height = Assembly.from_blocks([runners], supports=["sled"]).centroid[0, 2] - 1
    curve, displacement = curve_of(blocks, (1, 0, 0), "sled", 0.3, place, ["bed"])
    tips = 0.5 - 0.3 * height
    assert curve.lower[displacement < tips - 1e-4] == pytest.approx(0.3, rel=1e-6)
    assert (curve.lower[displacement > tips + 1e-3] < 0.3).all()
    assert displacement[-1] == pytest.approx(0.5, abs=1e-4)


@pytest.mark.parametrize(
    ("shift", "angle", "expected"),
    [
        ((0.0, 0.0), 0.0, [(2.2, 0.0), (2.2, 1.0)]),
        ((0.0, 0.3), 0.0, [(2.2, 0.3), (2.2, 1.0)]),
        ((-0.15, -0.3), 0.0, [(2.05, 0.0), (2.05, 0.7)]),
        ((-0.1, 0.0), np.pi / 4, [(2.1 + 0.5**1.5, 0.5 - 0.5**1.5), (2.0, 0.6)]),
        ((-0.25, 0.0), 0.0, []),
        ((0.0, 1.1), 0.0, []),
    ],
)
def test_an_edge_bears_on_the_part_that_is_above_the_face(shift, angle, expected):
    """An edge from (2.2, 0) to (2.2, 1), shifted and turned about its middle, on a face from (2, 0) to (3, 1).

    Turned by 45 degrees about (2.1, .5) it begins at .5 cos 45 in front of it and ends as far behind it. It is at the
    rim, x = 2, where y = .5 + .1.
    """
    blocks = [*GROUNDS, beam(0.0)]
    scene = Assembly.from_blocks(blocks, supports=["L", "R"], friction=0.5)
    joints = find_interfaces(scene)
    structure = Structure(scene, joints, read_loads(scene, None), None, "auto", np.zeros((3, 6)))
    own, middle = int(np.flatnonzero(joints.area == 0)[0]), np.array([2.2, 0.5, 0.0])
    pose = rest_pose(scene)
    pose.rotation[2] = rotation_matrices(np.array([[0.0, 0.0, angle]]))[0]
    arm = scene.centroid[2] - middle
    pose.displacement[2] = pose.rotation[2] @ arm - arm + (*shift, 0.0)
    cut = cut_to_faces(structure, pairs_at_rest(scene, joints), np.array([own]), pose, 0.0)
    contacts = cut.contacts.select(np.flatnonzero(cut.contacts.joint == own))
    place = edge_crossings(contacts, pose, pair_points(scene, contacts, pose, 0.0))[0]
    side = np.flatnonzero(joints.pair[own] == 2)[0]
    found = place[:, side, :2]
    assert sorted(found.tolist()) == [pytest.approx(each, abs=1e-9) for each in sorted(expected)]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("keels", [False, True])
def test_edges_may_share_a_slip(place, keels):
    """A lintel from x = -.1 to 2.3 that is pushed slides on both ridges, at 0 and 2, until its end is at L."""
    profile = [(0, 0.3), (0.25, 0), (0.5, 0.3), (0.75, 0), (1, 0.3), (1, 0.5), (0, 0.5)]
    lintel = extruded("lintel", profile, -0.1, 2.3, (0, 1, 0), (1, 0, 0))
    blocks = [ridge("L", 0), ridge("R", 2), lintel if keels else box((-0.1, 0, 0), (2.3, 1, 0.4), name="lintel")]
    curve, displacement = curve_of(blocks, (1, 0, 0), "lintel", 0.7, place, ["L", "R"])
    assert curve.lower == pytest.approx(0.7, rel=1e-6)
    # Where the turn is not known to the last digit it is no linkage, and the last finite step is a part of the way.
    assert displacement[-1] == pytest.approx(0.1, abs=1e-5 if place == AS_DRAWN else 2e-3)


@pytest.mark.parametrize("place", PLACES)
def test_edges_may_share_the_slip_of_supports_that_part(place):
    """A beam on two edges at x = -.1 and 2.2, whose middle is between, on grounds up to 0 and from 2 on.

    Its weight is the same on both. The bearing on L is shorter, so it takes all slip, and is used up after .1 m.
    """
    profile = [(-0.1, 0), (0.2, 0.2), (1.9, 0.2), (2.2, 0), (2.3, 0.2), (2.3, 0.5), (-0.2, 0.5), (-0.2, 0.2)]
    assert collapse_of([*GROUNDS, extruded("beam", profile, 0, 1)], (1, 0, 0), 0.7, place) == pytest.approx(
        0.1, abs=1e-5
    )


def noisy_block_on_a_pedestal(seed, off):
    """A block of .8 x .8 x .6 m in the middle of a pedestal of 1 m, triangulated, with corners off by a deviation."""
    rng, blocks = np.random.default_rng(seed), []
    for name, each in (("p", box((0, 0, 0), (1, 1, 1))), ("w", box((0.1, 0.1, 1), (0.9, 0.9, 1.6)))):
        vertices = each.vertices + rng.normal(0, off, each.vertices.shape)
        faces = []
        for face in map(list, each.faces):
            k = int(rng.integers(len(face)))
            face = face[k:] + face[:k]
            faces += [[face[0], face[i], face[i + 1]] for i in range(1, len(face) - 1)]
        blocks.append(Block(vertices, faces, name=name))
    return Assembly.from_blocks(blocks, supports=["p"], friction=0.3)


@pytest.mark.parametrize("seed", [8, 30])
def test_slivers_of_a_triangulated_joint_do_not_carry_a_block_beyond_its_bed(seed):
    """The block slides at friction .3, and nothing is carried when its centre is at the rim, after .5 m.

    Beside its patches the joint has edges of a few tenths of a millimetre at the corners of the block.
    """
    curve = capacity(noisy_block_on_a_pedestal(seed, 1e-4), (1, 0, 0), control="w")
    assert curve.outcome.word == "zero"
    assert curve.lower.max() < 0.3 * (1 + 1e-2)
    assert curve.displacement[-1] == pytest.approx(0.5, abs=1e-3)


def over_ridges(gap, low=0.0, high=1.0):
    """A slab from x = -1 to 2, 1 m wide and .4 m thick, above the edges of ridges at x = 0 and 1 from low to high."""
    ridges = []
    for name, place in (("L", 0), ("R", 1)):
        profile = [(place - 0.4, -1), (place + 0.4, -1), (place, -gap)]
        ridges.append(extruded(name, profile, low, high))
    return [*ridges, box((-1, 0, 0), (2, 1, 0.4), name="slab")]


def pyramid(name, x, y):
    """A support with a tip at (x, y, 0)."""
    base = [(x - 0.2, y - 0.2, -1), (x + 0.2, y - 0.2, -1), (x + 0.2, y + 0.2, -1), (x - 0.2, y + 0.2, -1)]
    return polyhedron(np.array([*base, (x, y, 0)]), [[3, 2, 1, 0], *([k, (k + 1) % 4, 4] for k in range(4))], name=name)


def over_tips(end):
    """A slab from x = -1 on, .4 m thick, on three tips: two at x = 0 and one at 1."""
    tips = [pyramid("A", 0, 0.2), pyramid("B", 0, 0.8), pyramid("C", 1, 0.5)]
    return [*tips, box((-1, 0, 0), (end, 1, 0.4), name="slab")]


@pytest.mark.parametrize(
    ("place", "gap"), [*((AS_DRAWN, gap) for gap in (0.0, 1e-4, 1e-3)), *((place, 1e-5) for place in ELSEWHERE)]
)
@pytest.mark.parametrize("wide", [False, True])
def test_a_slab_that_slides_over_ridges_is_carried_where_they_are(place, gap, wide):
    """At friction .3 the resultant of the weight and the push meets the ridges' plane .3 x .2 beyond the centre.

    That is at R, x = 1, where the centre has come from .5 to .94, after .44 m. From there on the slab tips about R, on
    a radius r of its centre with r2 = .062 + .22. With the centre still u = .5 - d before R the multiplier is u over
    the root of r2 - u2, and zero at d = .5. A gap of the joints at rest changes none of it, as they count as
    closed. Where ridges are wider than the slab its rims cross them, and the curve may end where the slab tips.
    """
    blocks = over_ridges(gap, *((-0.1, 1.1) if wide else (0.0, 1.0)))
    curve, displacement = curve_of(blocks, (1, 0, 0), "slab", 0.3, place, ["L", "R"])
    off = 1e-4 + gap  # with the last pose of the path located to the rounding of coordinates
    slides, tips = displacement < 0.44 - off, displacement > 0.44 + off
    before = np.maximum(0.5 - displacement[tips], 0.0)
    assert curve.lower[slides] == pytest.approx(0.3, rel=1e-6)
    assert curve.lower[tips] == pytest.approx(before / np.sqrt(0.06**2 + 0.2**2 - before**2), abs=2e-3)
    assert displacement[-1] == pytest.approx(0.5, abs=1e-3) or (
        wide and displacement[-1] == pytest.approx(0.44, abs=off)
    )


@pytest.mark.parametrize(("place", "gap"), [(AS_DRAWN, 0.0), (ELSEWHERE[0], 1e-5)])
def test_a_slab_that_rises_as_it_slides_over_ridges_is_carried_where_they_are(place, gap):
    """As above with dilatancy: after a slip d the centre is .2 + .3 d above the ridges.

    The force of R goes through its edge. So the slab tips where .5 + d + .3 (.2 + .3 d) = 1, which is at .44 / 1.09.
    Until then it slides, and the multiplier is zero where the centre is at R. Without dilatancy it tips at .44 m, and
    dilatancy makes that no later.
    """
    curve, displacement = curve_of(over_ridges(gap), (1, 0, 0), "slab", 0.3, place, ["L", "R"], "associated")
    tips = 0.44 / 1.09
    assert curve.lower[displacement < tips - 1e-3] == pytest.approx(0.3, rel=1e-6)
    assert (curve.lower[displacement > 0.44 + 1e-3] < 0.2995).all()
    assert displacement[-1] == pytest.approx(0.5, abs=2e-3)
    assert curve.lower[-1] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.xfail(strict=True, reason="finite steps close the dilated joints again where no linkage leads on")
def test_a_slab_that_rises_as_it_slides_over_ridges_tips_where_its_force_is_at_the_ridge():
    """The multiplier falls from .44 / 1.09 m on, as derived above."""
    curve, displacement = curve_of(over_ridges(0.0), (1, 0, 0), "slab", 0.3, AS_DRAWN, ["L", "R"], "associated")
    assert (curve.lower[displacement > 0.44 / 1.09 + 1e-3] < 0.2999).all()


@pytest.mark.parametrize("place", PLACES[:2])
@pytest.mark.parametrize(
    ("end", "push", "tips", "zero"),
    [
        (2.0, (1, 0, 0), 0.46, None),
        (2.0, (-1, 0, 0), 0.46, 0.5),
        (1.2, (-1, 0, 0), 0.06, 0.1),
        (2.0, (0, 1, 0), 0.11, 0.15),
    ],
)
def test_a_slab_that_slides_over_tips_is_carried_where_they_are(place, end, push, tips, zero):
    """At friction .2 the resultant is .2 x .2 beyond the centre, which is at (.5, .5), of the shorter slab at (.1, .5).

    The sides of the triangle of the tips are .5 m away along x, or .1 m from the shorter slab; along y it is .15 m to
    the side from (0, .8) to (1, .5). The slab tips where the resultant is there, and carries nothing when its centre
    is. Where it would tip on the one tip at (1, .5) it may roll to either side as well.
    """
    curve, displacement = curve_of(over_tips(end), push, "slab", 0.2, place, ["A", "B", "C"])
    assert curve.lower[displacement < tips - 1e-3] == pytest.approx(0.2, rel=1e-5)
    assert (curve.lower[displacement > tips + 2e-3] < 0.2).all()
    assert displacement[-1] <= (zero or 0.5) + 1e-3
    assert displacement[-1] >= tips - 1e-3


@pytest.mark.parametrize("place", PLACES[:2])
@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_sled_on_a_long_bed_is_carried_by_its_runners(place, friction):
    """The runners are at x = .2 and .8 and the bed ends at 2, so the front one is at the rim after 1.2 m."""
    blocks = [box((0, 0, 0), (2, 1, 1), name="bed"), sled(along_x=False)]
    curve, displacement = curve_of(blocks, (1, 0, 0), "sled", friction, place, ["bed"])
    slides = displacement < 1.2 - 1e-3
    assert curve.lower[slides] == pytest.approx(friction, rel=1e-6)
    assert displacement[-1] == pytest.approx(1.2, abs=1e-3)


@pytest.mark.parametrize("place", PLACES[:2])
@pytest.mark.parametrize("low", [0.0, -0.1])
def test_a_ridge_that_moves_away_is_drawn_by_the_weight_on_it(place, low):
    """A lintel, with most of its weight above L at x = 0, sticks there and slides on the edge of R, at 2 + d.

    R carries the weight times c / (2 + d), where c is the place of the centre, and .3 of that holds it back.
    """
    lintel = extruded("lintel", [(-0.3, 0), (3, 0), (3, 0.3), (0.5, 0.3), (-0.3, 2)], 0, 1)
    ridges = [extruded(n, [(x - 0.5, -1), (x + 0.5, -1), (x, 0)], low, 1 - low) for n, x in (("L", 0), ("R", 2))]
    centre = float(Assembly.from_blocks([lintel], supports=["lintel"]).centroid[0, 0])
    scene, rotation, scale = scene_of([*ridges, lintel], ["L", "R"], 0.3, place)
    path = settle_to_collapse(scene, {"R": (rotation @ (1, 0, 0)).tolist()}, displacement=0.6 * scale)
    own = scene.names.index("lintel")
    weight = float(scene.volume[own] * scene.density[own] * np.linalg.norm(scene.gravity))
    moved = np.array(path.displacement) / scale
    assert path.outcome.word == "reached"
    assert -np.array(path.reaction) / weight == pytest.approx(0.3 * centre / (2 + moved), rel=1e-3)
