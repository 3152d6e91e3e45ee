"""Blocks on edges and corners: exact limits from first principles.

Each limit follows from the equilibrium of one rigid body on a few contact points with Coulomb friction. The formulas
stand at the tests; the body has unit weight, and a push is a multiple of it.
"""

import numpy as np
import pytest

from blockstat import Block, JointLaw, assess, find_interfaces, limit_load
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.analysis.verdict import Outcome
from blockstat.contact.features import ContactKind
from evidence.scenes.small import assembly, box
from tests.point_bodies import (
    EVERYWHERE,
    EXACT,
    FLOOR,
    PLACES,
    agrees,
    crossed_keels,
    hull,
    ladder,
    limit,
    moved,
    octahedron_in_a_corner,
    placed,
    prism_in_a_groove,
    ridge,
    tetrahedron,
    torque_limit,
)


@EVERYWHERE
def test_three_vertices_on_a_floor(place, flip):
    # rho / (2 h_c cos delta) with rho = 1 / sqrt 3, h_c = (sqrt(2/3) + c) / 4, delta from the nearest side's normal.
    height = (np.sqrt(2 / 3) + 0.1) / 4
    for angle, delta in ((180, 0.0), (0, 60.0), (165, 15.0)):
        exact = 1 / np.sqrt(3) / (2 * height * np.cos(np.deg2rad(delta)))
        push = (np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle)), 0)
        agrees(limit([FLOOR, tetrahedron(0.1)], [0], push, place=place, flip=flip, friction=10.0), exact)
        agrees(limit([FLOOR, tetrahedron(0.1)], [0], push, place=place, flip=flip, friction=0.5), 0.5)


@EVERYWHERE
def test_a_box_on_two_ridges(place, flip):
    # +x: min(mu, 2 (c - e) / h), -x: min(mu, 2 (c + e) / h), y: min(mu, d / h) for 1.0 x .8 x 1.2, c = .3.
    c, depth, height = 0.3, 0.8, 1.2
    for e in (0.0, 0.1):
        body = box((e - 0.5, -0.4, 0.2), (e + 0.5, 0.4, 1.4), name="body")
        blocks = [FLOOR, ridge(-c), ridge(c), body]
        cases = {(1, 0, 0): 2 * (c - e) / height, (-1, 0, 0): 2 * (c + e) / height, (0, 1, 0): depth / height}
        for push, turns in cases.items():
            for mu in (0.8, 0.4):
                agrees(limit(blocks, [0, 1, 2], push, place=place, flip=flip, friction=mu), min(mu, turns))


@EVERYWHERE
def test_a_torque_on_three_vertices(place, flip):
    # mu rho per weight: each vertex carries a third of it.
    found = torque_limit([FLOOR, tetrahedron(0.1)], [0], (0, 0, 1), place=place, flip=flip, friction=0.5)
    agrees(found, 0.5 / np.sqrt(3))


@EVERYWHERE
def test_crossed_keels(place, flip):
    # min(mu, a / (z |cos psi|), c / (z |sin psi|)).
    a = 0.2
    blocks, c, z = crossed_keels((-a, a))
    for psi in (0, 30, 60, 90):
        along, across = np.cos(np.deg2rad(psi)), np.sin(np.deg2rad(psi))
        exact = min(1.0, a / (z * max(along, 1e-9)), c / (z * max(across, 1e-9)))
        agrees(limit(blocks, [0, 1], (along, across, 0), place=place, flip=flip, friction=1.0), exact)


@EVERYWHERE
@pytest.mark.parametrize("mu", [0.3, 1.0])
def test_one_keel_on_two_ridges(place, flip, mu):
    # It balances on the line between two points: no push across, and min(mu, c / z) along.
    blocks, c, z = crossed_keels((0.0,))
    for push in ((1, 0, 0), (-1, 0, 0)):
        found = limit(blocks, [0, 1], push, place=place, flip=flip, friction=mu)
        assert found.outcome is LoadOutcome.LIMIT
        assert abs(found.lower) <= EXACT
        assert abs(found.upper) <= EXACT
    agrees(limit(blocks, [0, 1], (0, 1, 0), place=place, flip=flip, friction=mu), min(mu, c / z))


@EVERYWHERE
def test_a_ladder_between_floor_and_wall(place, flip):
    # Push away from the wall: min((mu L - x_g) / (L - z_g), x_g / z_g), L = l (sin + mu cos) / (1 + mu^2).
    length, thick, angle = 4.0, 0.2, np.deg2rad(60)
    x = (length * np.cos(angle) - thick * np.sin(angle)) / 2
    z = (length * np.sin(angle) + thick * np.cos(angle)) / 2
    for mu in (0.5, 0.7):
        arm = length * (np.sin(angle) + mu * np.cos(angle)) / (1 + mu**2)
        agrees(
            limit(ladder(60), [0, 1], (-1, 0, 0), place=place, flip=flip, friction=mu),
            min((mu * arm - x) / (arm - z), x / z),
        )


@EVERYWHERE
def test_a_ladder_needs_friction(place, flip):
    # mu >= (-l sin + sqrt(l^2 - t^2 sin^2)) / (l cos + t sin).
    length, thick, angle = 4.0, 0.2, np.deg2rad(60)
    root = np.sqrt(length**2 - thick**2 * np.sin(angle) ** 2)
    least = (root - length * np.sin(angle)) / (length * np.cos(angle) + thick * np.sin(angle))
    scene, _ = placed(ladder(60), [0, 1], place=place, flip=flip)
    assert assess(scene, friction=least + EXACT).outcome is Outcome.STABLE
    assert assess(scene, friction=least - EXACT).outcome is Outcome.UNSTABLE


@EVERYWHERE
@pytest.mark.parametrize("wall", [0.0, 0.1, 0.6])
def test_a_ladder_against_a_wall_of_another_friction(place, flip, wall):
    # tan th >= l (1 - m1 m2) / (2 m1 l + t (1 + m1 m2)), m1 at the floor and m2 at the wall: linear in m1.
    length, thick, rise = 4.0, 0.2, np.tan(np.deg2rad(60))
    least = (length - thick * rise) / (2 * length * rise + wall * (thick * rise + length))
    for floor, outcome in ((least + EXACT, Outcome.STABLE), (least - EXACT, Outcome.UNSTABLE)):
        laws = [JointLaw(("floor", "*"), friction=floor), JointLaw(("wall", "*"), friction=wall)]
        scene, _ = placed(ladder(60), [0, 1], place=place, flip=flip, joints=laws)
        assert assess(scene).outcome is outcome


@EVERYWHERE
@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_prism_in_a_groove(place, flip, mu):
    # Across cot beta; along, with any forces, mu / (sin beta sqrt(1 - mu^2 cot^2 beta)), beta = 45 degrees.
    agrees(limit(prism_in_a_groove(), [0], (1, 0, 0), place=place, flip=flip, friction=mu), 1.0)
    along = mu * np.sqrt(2) / np.sqrt(1 - mu**2)
    agrees(limit(prism_in_a_groove(), [0], (0, 1, 0), place=place, flip=flip, friction=mu), along)


@EVERYWHERE
@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_prism_spins_in_a_groove(place, flip, mu):
    # mu r / ((1 + mu^2) sin beta) per weight, about the axis of the prism.
    found = torque_limit(prism_in_a_groove(), [0], (0, 1, 0), place=place, flip=flip, friction=mu)
    agrees(found, mu * np.sqrt(2) / (1 + mu**2))


def brackets(found, exact, width=0.01):
    """Whether a bracket without dilatancy holds a limit and is narrow."""
    lower, upper = found.coulomb
    assert lower <= exact * (1 + EXACT)
    assert upper >= exact * (1 - EXACT)
    assert upper - lower < width * exact


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_prism_slides_along_a_groove_at_the_coulomb_limit(mu):
    # mu / sin beta: no wedging without dilatancy.
    brackets(limit(prism_in_a_groove(), [0], (0, 1, 0), friction=mu, flow="coulomb"), mu * np.sqrt(2))


@EVERYWHERE
def test_a_torque_on_an_octahedron_in_a_corner(place, flip):
    # sqrt 2 mu r / sqrt(1 - 2 mu^2) per weight, with r = 1/2.
    mu, blocks = 0.3, octahedron_in_a_corner()[0]
    found = torque_limit(blocks, [0, 1, 2], (0, 0, 1), place=place, flip=flip, friction=mu)
    agrees(found, np.sqrt(2) * mu * 0.5 / np.sqrt(1 - 2 * mu**2))


def test_a_torque_on_an_octahedron_in_a_corner_without_dilatancy():
    # sqrt 2 mu r per weight.
    mu, blocks = 0.3, octahedron_in_a_corner()[0]
    brackets(torque_limit(blocks, [0, 1, 2], (0, 0, 1), friction=mu, flow="coulomb"), np.sqrt(2) * mu * 0.5)


@EVERYWHERE
def test_an_octahedron_in_a_corner(place, flip):
    # 1 / sqrt 2 towards a face's normal and sqrt 2 the other way, for every mu < 1 / sqrt 2.
    blocks, axis = octahedron_in_a_corner()
    push = axis @ [1, 0, 0] * [1, 1, 0]
    push /= np.linalg.norm(push)
    # Without friction rounded coordinates leave a moment that nothing carries.
    for mu in (0.0, 0.3, 0.6) if place == "here" else (0.3, 0.6):
        agrees(limit(blocks, [0, 1, 2], push, place=place, flip=flip, friction=mu), np.sqrt(0.5))
        agrees(limit(blocks, [0, 1, 2], -push, place=place, flip=flip, friction=mu), np.sqrt(2))


@pytest.mark.parametrize(
    ("blocks", "kind", "points"),
    [
        ([FLOOR, ridge(0.0), box((-0.5, -0.4, 0.2), (0.5, 0.4, 1))], ContactKind.EDGE, 2),
        (octahedron_in_a_corner()[0], ContactKind.CORNER, 3),
        (crossed_keels()[0], ContactKind.CROSSING, 4),
    ],
    ids=["edge on face", "corner on face", "edge across edge"],
)
@pytest.mark.parametrize("place", PLACES)
def test_each_kind_of_contact_is_found_once(blocks, kind, points, place):
    blocks = [Block(PLACES[place](np.asarray(b.vertices, float)), b.faces) for b in blocks]
    faces = find_interfaces(assembly(blocks))
    rows = np.flatnonzero(faces.pair[:, 1] == len(blocks) - 1)
    assert set(faces.kinds[rows].tolist()) == {kind}
    assert np.isin(faces.point_interface, rows).sum() == points
    assert (faces.area[rows] == 0).all()


def plank_on_a_rim(reach):
    """A plank from a pillar to a wall whose top edge its end just meets, or passes by `reach`."""
    pillar = box((-1, 0, 0), (0, 1, 1), name="pillar")
    wall = box((4, 0, 0), (5, 1, 1), name="wall")
    return assembly([pillar, wall, box((-0.5, 0, 1), (4 + reach, 1, 1.2), name="plank")], supports=[0, 1])


def test_a_verdict_that_hangs_on_an_edge_along_an_edge_is_undecided():
    verdict = assess(plank_on_a_rim(0.0))
    assert verdict.outcome is Outcome.UNDECIDED
    assert any('"wall" and "plank"' in warning and "edge along edge" in warning for warning in verdict.warnings)
    assert assess(plank_on_a_rim(1e-3)).outcome is Outcome.STABLE
    assert assess(plank_on_a_rim(-1e-3)).outcome is Outcome.UNSTABLE


def test_a_column_on_the_tip_of_another_is_undecided_and_one_beside_it_falls():
    tip = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
    up = hull(tip, name="lower")
    down = moved(up, np.diag([1, -1, -1]), (0, 1, 2))
    verdict = assess(assembly([up, Block(down.vertices, down.faces, "upper")]))
    assert verdict.outcome is Outcome.UNDECIDED
    assert any('"lower" and "upper"' in warning and "corner on corner" in warning for warning in verdict.warnings)
    beside = moved(down, shift=(0.01, 0, 0))
    assert assess(assembly([up, Block(beside.vertices, beside.faces, "upper")])).outcome is Outcome.UNSTABLE


def test_what_falls_whatever_a_rim_carries_is_unstable():
    # The upper block hangs beyond the edge that it shares with the lower one: no force at an edge can hold it.
    verdict = assess(assembly([box((0, 0, 0), (1, 1, 1)), box((1, 0, 1), (2, 1, 2))]))
    assert verdict.outcome is Outcome.UNSTABLE


def test_triangles_of_one_face_have_no_edge_between_them():
    ridged = [FLOOR, ridge(0.0), box((-0.5, -0.4, 0.2), (0.5, 0.4, 1), name="body")]
    body = ridged[2]
    ridged[2] = Block(body.vertices, [t for f in body.faces for t in ([f[0], f[1], f[2]], [f[0], f[2], f[3]])])
    faces = find_interfaces(assembly(ridged))
    row = np.flatnonzero((faces.pair == [1, 2]).all(axis=1))
    assert faces.kinds[row].tolist() == [ContactKind.EDGE]
    assert np.ptp(faces.point[faces.point_interface == row[0]][:, 1]) == pytest.approx(0.8)


def test_a_limit_that_hangs_on_a_corner_on_a_corner_is_not_proven():
    # Two blocks on a floor meet at the tips of two spikes: pushed at it one slides or is held, pushed away it slides.
    def spiked(sign, name):
        back = [(sign * x, y, z) for x in (1, 2) for y in (-0.5, 0.5) for z in (0.0, 1.0)]
        return hull([(0.0, 0.0, 0.5), *back], name=name)

    blocks = [FLOOR, spiked(1, "anvil"), spiked(-1, "body")]
    found = limit(blocks, [0, 1], (1, 0, 0), friction=0.5)
    assert found.outcome is LoadOutcome.UNDECIDED
    assert found.lower == pytest.approx(0.5, rel=EXACT)
    assert found.upper > 0.6
    assert any('"anvil" and "body"' in warning and "corner on corner" in warning for warning in found.warnings)
    agrees(limit(blocks, [0, 1], (-1, 0, 0), friction=0.5), 0.5)


def test_dead_load_that_only_crushing_edges_carry_is_undecided():
    scene = assembly([FLOOR, ridge(0.0), box((-0.5, -0.4, 0.2), (0.5, 0.4, 1), name="body")], supports=[0, 1])
    assert limit_load(scene, (0, 1, 0)).outcome is LoadOutcome.LIMIT
    found = limit_load(scene.with_(joints=[JointLaw(("*", "*"), compression=1e9)]), (0, 1, 0))
    assert found.outcome is LoadOutcome.UNDECIDED
    assert any("carry nothing" in warning for warning in found.warnings)
