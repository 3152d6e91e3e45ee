"""Joint laws against closed forms: Coulomb with cohesion and cut-offs, stress block, bonds, torsion.

Stress block: a joint b wide under N at eccentricity e carries it on the width b - 2e, so e <= (b/2)(1 - N / (sigma A)).
Torsion of a square joint of side a under uniform pressure: mu N a (sqrt 2 + ln(1 + sqrt 2)) / 6 = .382598 mu N a.
"""

import itertools

import numpy as np
import pytest

from blockstat import Block, JointLaw, LoadOutcome, Outcome, assess, limit_load
from blockstat.model import solids
from evidence.scenes.small import assembly, box, prism

CLOSE = 1e-6


def slab(law, *, size=(2.0, 1.0, 0.5), friction=0.5):
    """A block on the ground, its weight equal to its volume."""
    a, b, h = size
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    stone = box((-a / 2, -b / 2, 0), (a / 2, b / 2, h), name="stone", group="stone")
    return assembly([ground, stone], joints=[law], friction=friction)


def law(**values):
    return JointLaw(("stone", "ground"), **values)


def pull(force, moment=(0, 0, 0)):
    return np.array([np.zeros(6), [*force, *moment]])


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0.6, 0.8, 0)])
@pytest.mark.parametrize("tension", [0.0, 0.3, 5.0])
def test_sliding_with_cohesion_whatever_the_tension(direction, tension):
    # |f_t| = mu W + c A, low pull: the slab cannot tip. Weight 1, area 2.
    asm = slab(law(cohesion=0.7, tension=tension))
    found = limit_load(asm, pull(direction, np.cross((0, 0, -0.25), direction)))
    assert found.lower == pytest.approx(0.5 * 1.0 + 0.7 * 2.0, rel=CLOSE)
    assert found.gap < CLOSE


@pytest.mark.parametrize("tension", [0.0, 0.3, 1.2])
def test_lifting_stops_at_the_tension_cut_off(tension):
    # T A + W; the apex of the cone at c/mu = 1.4 lies beyond each of these.
    found = limit_load(slab(law(cohesion=0.7, tension=tension)), pull((0, 0, 1)))
    assert found.lower == pytest.approx(1.0 + 2.0 * tension, rel=CLOSE)
    assert found.gap < CLOSE


def test_the_cone_ends_at_its_apex():
    found = limit_load(slab(law(cohesion=0.7, tension=5.0)), pull((0, 0, 1)))
    assert found.lower == pytest.approx(1.0 + 2.0 * 1.4, rel=CLOSE)


def test_cohesion_does_not_keep_a_block_from_tipping():
    tall = slab(law(cohesion=3.0), size=(0.5, 1.0, 2.0))
    assert limit_load(tall, (1, 0, 0)).lower == pytest.approx(0.5 / 2.0, rel=CLOSE)


def test_cohesion_in_a_coulomb_state():
    asm = slab(law(cohesion=0.2))
    sideways = np.cross((0, 0, -0.25), (1, 0, 0))
    found = limit_load(asm, pull((1, 0, 0), sideways), flow="coulomb")
    assert found.coulomb is not None
    assert found.coulomb[0] == pytest.approx(0.5 + 0.2 * 2.0, rel=1e-3)


@pytest.mark.parametrize("used", [0.25, 0.5, 0.8])
def test_a_stress_block_narrows_the_joint_of_a_tipping_block(used):
    width, height = 0.5, 2.0
    exact = width / height * (1 - used)
    below = []
    for cells in (4, 8, 16):
        asm = slab(law(compression=height / used, cells=cells), size=(width, 1.0, height), friction=2.0)
        found = limit_load(asm, (1, 0, 0))
        assert found.gap < CLOSE
        below.append(exact - found.lower)
    assert min(below) > -CLOSE  # cells are a lower bound
    assert below[2] < max(0.25 * below[0], CLOSE)
    assert below[1] < 0.04 * exact


@pytest.mark.parametrize("used", [0.25, 0.5, 0.75])
def test_a_block_on_two_feet_crushes_on_its_feet(used):
    # A portal 1 wide on two feet of f = 0.1, tipping about the right one. The pressure sigma = W / (used 2 f) needs a
    # length s = 2 f used. It fills the right foot from its rim, and then the left one from its inner edge at x = f.
    # The resultant lies at x_R, and lambda z_G = x_R - 1/2. The hull would carry pressure under the opening.
    foot = 0.1
    outline = [(0, 0), (foot, 0), (foot, 1.5), (1 - foot, 1.5), (1 - foot, 0), (1, 0), (1, 2), (0, 2)]
    portal = prism(outline, 1.0, name="stone", group="stone")
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    plain = assembly([ground, portal], friction=2.0)
    right = min(2 * foot * used, foot)
    left = 2 * foot * used - right
    resultant = (right * (1 - right / 2) + left * (foot - left / 2)) / (right + left)
    exact = (resultant - 0.5) / plain.centroid[1, 2]
    strength = plain.mass[1] / (used * 2 * foot)
    below = []
    for cells in (4, 8, 16):
        found = limit_load(plain.with_(joints=[law(compression=strength, cells=cells)]), (1, 0, 0))
        assert found.gap < CLOSE
        below.append(exact - found.lower)
    assert min(below) > -CLOSE  # cells are a lower bound
    assert below[2] < max(0.35 * below[0], CLOSE)
    assert below[1] < 0.01 * exact


def test_feet_crush_under_the_weight_that_they_carry():
    # Two feet of .1 x 1 carry at most sigma .2, whatever their hull of 1 x 1 is.
    outline = [(0, 0), (0.1, 0), (0.1, 1.5), (0.9, 1.5), (0.9, 0), (1, 0), (1, 2), (0, 2)]
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    plain = assembly([ground, prism(outline, 1.0, name="stone", group="stone")])
    for share, outcome in ((1 + 1e-5, Outcome.STABLE), (1 - 1e-5, Outcome.UNSTABLE)):
        strong = plain.with_(joints=[law(compression=share * plain.mass[1] / 0.2)])
        assert assess(strong).outcome is outcome


def test_a_bond_of_unequal_feet_sits_at_their_common_centroid():
    # Feet of .3 and .1: centroid of the area at (.3 x .15 + .1 x .95) / .4 = .35. A moment-free bond there holds a pull
    # that goes through it up to its strength, and one beside it not.
    outline = [(0, 0), (0.3, 0), (0.3, 1.5), (0.9, 1.5), (0.9, 0), (1, 0), (1, 2), (0, 2)]
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    bond = law(bond=10.0, bond_moment=0.0)
    plain = assembly([ground, prism(outline, 1.0, name="stone", group="stone")], gravity=(0, 0, -1e-4), joints=[bond])
    offset = np.array([0.35, 0.5, 0.0]) - plain.centroid[1]
    found = limit_load(plain, pull((0, 0, 1), np.cross(offset, (0, 0, 1))))
    assert found.lower == pytest.approx(10.0, rel=1e-4)


@pytest.mark.parametrize("other", [{}, {"tension": 1.0}, {"cohesion": 0.3}, {"tension": 1.0, "cohesion": 0.3}])
def test_crushing_under_its_own_weight(other):
    # Pressure 2 under a block 2 high, whatever the joint bears in tension and shear.
    for strength, outcome in ((2 * (1 + 1e-5), Outcome.STABLE), (2 * (1 - 1e-5), Outcome.UNSTABLE)):
        assert assess(slab(law(compression=strength, **other), size=(0.5, 1.0, 2.0))).outcome is outcome


def test_torsion_of_a_square_joint():
    # Corners carry sqrt(1/2) mu N a; if no cell can take more than its share, the pressure is uniform.
    a, mu = 1.0, 0.5
    uniform = (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 6 * mu * a
    assert uniform == pytest.approx(0.382598 * mu, rel=1e-6)
    couple = pull((0, 0, 0), (0, 0, 1))
    size = (a, a, 1.0)
    corners = limit_load(slab(law(), size=size), couple)
    assert corners.lower == pytest.approx(np.sqrt(0.5) * mu * a, rel=CLOSE)
    error = []
    for cells in (4, 8, 16):
        loose = limit_load(slab(law(cells=cells), size=size), couple)
        assert uniform < loose.lower < corners.lower
        tight = limit_load(slab(law(cells=cells, compression=1 + 1e-5), size=size), couple)
        assert tight.upper >= tight.lower
        error.append(tight.lower / uniform - 1)
    assert max(error) < 0  # from below, as any division of a stress field must
    np.testing.assert_allclose(np.diff(np.log(np.abs(error))) / np.log(2), -1.8, atol=0.2)  # nearly second order


@pytest.mark.parametrize("moment", [0.0, 0.4])
def test_a_bonded_cantilever(moment):
    # Bending M, and the tension F at the centre against the pressure at the lower edge: W L / 2 = M + F a / 2.
    a, length, force = 0.5, 2.0, 3.0
    wall = box((-1, 0, -1), (0, a, 1), name="wall", group="wall")
    beam = box((0, 0, -a / 2), (length, a, a / 2), name="beam", group="beam")
    glue = JointLaw(("wall", "beam"), bond=force, bond_moment=moment)
    asm = assembly([wall, beam], joints=[glue], friction=5.0, gravity=(0, 0, -1e-3))
    weight = length * a * a * 1e-3
    found = limit_load(asm, (0, 0, -1))
    assert (1 + found.lower) * weight * length / 2 == pytest.approx(moment + force * a / 2, rel=CLOSE)
    assert found.gap < CLOSE
    assert found.bonds is not None
    assert np.linalg.norm(found.bonds.moment) == pytest.approx(moment, abs=1e-5)


def test_a_bonded_bell_hangs_shears_and_turns():
    ceiling = box((-2, -2, 1), (2, 2, 2), name="ceiling", group="rock")
    bell = box((0, 0, 0), (1, 1, 1), name="bell", group="bell")
    glue = JointLaw(("rock", "bell"), bond=3.0, bond_moment=0.4)
    asm = assembly([ceiling, bell], joints=[glue], friction=0.0)
    assert limit_load(asm, (0, 0, -1)).lower == pytest.approx(2.0, rel=CLOSE)  # F = 3 W
    at_the_joint = pull((1, 0, 0), np.cross((0, 0, 0.5), (1, 0, 0)))
    assert limit_load(asm, at_the_joint).lower == pytest.approx(3.0, rel=CLOSE)
    assert limit_load(asm, pull((0, 0, 0), (0, 0, 1))).lower == pytest.approx(0.4, rel=CLOSE)


def test_bonds_and_contacts_balance_by_hand():
    wall = box((-1, 0, -1), (0, 0.5, 1), name="wall", group="wall")
    beam = box((0, 0, -0.25), (1, 0.5, 0.25), name="beam", group="beam")
    glue = JointLaw(("wall", "beam"), bond=1.0, bond_moment=0.2)
    verdict = assess(assembly([wall, beam], joints=[glue]))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.bonds is not None
    faces = verdict.interfaces
    push = np.einsum("nij,ni->nj", faces.frame[faces.point_interface], verdict.forces)
    centre = np.array([0.0, 0.25, 0.0])
    force = push.sum(axis=0) + verdict.bonds.force[0]
    about = np.cross(faces.point - centre, push).sum(axis=0) + verdict.bonds.moment[0]
    np.testing.assert_allclose(force, [0, 0, 0.25], atol=1e-9)
    np.testing.assert_allclose(about, np.cross([0.5, 0, 0], [0, 0, 0.25]), atol=1e-9)
    assert np.linalg.norm(verdict.bonds.moment[0]) <= np.hypot(0.2, 0.2) * (1 + 1e-9)


def test_a_capacity_is_no_endless_one():
    dry = slab(law(), friction=0.5)
    strong = slab(law(compression=100.0), friction=0.5)
    assert limit_load(dry, pull((0, 0, -1))).outcome is LoadOutcome.UNBOUNDED
    crushed = limit_load(strong, pull((0, 0, -1)))
    assert crushed.outcome is LoadOutcome.LIMIT
    assert crushed.lower == pytest.approx(100.0 * 2.0 - 1.0, rel=CLOSE)


def profile(corners, *, place=(0.0, 0.0, 0.0), turned=0, name="stone"):
    """A block of depth 1 over an outline in x and z."""
    corners = np.roll(np.array(corners, float), turned, axis=0)
    n = len(corners)
    flat = [np.column_stack([corners[:, 0], np.full(n, y), corners[:, 1]]) for y in (0.0, 1.0)]
    faces = [list(range(n)), list(range(2 * n - 1, n - 1, -1))]
    faces += [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    return Block(np.concatenate(flat) + place, faces, name=name, group=name)


def plate(plan, height, *, place=(0.0, 0.0, 0.0), turned=0):
    """A plate over an outline in x and y."""
    plan = np.roll(np.array(plan, float), turned, axis=0)
    low, high = (np.column_stack([plan, np.full(len(plan), z)]) + place for z in (0.0, height))
    return solids.prism(low, high, name="stone", group="stone")


def glued_down(stone, law, *, place=(0.0, 0.0, 0.0), first=True):
    """A stone glued on the ground, one ground or the stone first."""
    low, high = np.array([(-5, -5, -1), (5, 5, 0)]) + place
    ground = box(low, high, name="ground", group="ground")
    return assembly([ground, stone] if first else [stone, ground], supports=["ground"], joints=[law])


def opened(asm, x=0.0):
    """The moment that opens the joint about the line x = 0 of the stone, and the part of the weight [N m]."""
    k = asm.names.index("stone")
    moment = np.zeros((2, 6))
    moment[k, 4] = -1.0
    found = limit_load(asm, moment)
    assert found.gap < 1e-6
    weight = asm.mass[k] * np.linalg.norm(asm.gravity) * (asm.centroid[k, 0] - x)
    return found.lower - weight


FEET = [(0, 0), (0.5, 0), (0.5, 0.3), (0.98, 0.3), (0.98, 0), (1, 0), (1, 0.4), (0, 0.4)]
#: A foot .2 wide, and a bare edge at x = 1 in its plane.
FOOT_AND_EDGE = [(0, 0), (0.2, 0), (0.2, 0.3), (0.6, 0.3), (1, 0), (1, 0.4), (0, 0.4)]
UTM = (5e5, 5.2e6, 300.0)


@pytest.mark.parametrize("strengths", [{}, {"cohesion": 20.0}, {"cohesion": 3.0}])
@pytest.mark.parametrize(("place", "turned", "first"), [((0, 0, 0), 0, True), ((0, 0, 0), 3, False), (UTM, 0, True)])
@pytest.mark.parametrize(("corners", "moment"), [(FEET, 0.5 * 0.25 + 0.02 * 0.99), (FOOT_AND_EDGE, 0.2 * 0.1)])
def test_glue_acts_where_there_is_area(corners, moment, place, turned, first, strengths):
    """T times the first moment of the feet about x = 0: equal shares of the corners of the hull gave T A / 2.

    A cohesion beyond mu T, with mu = .5, changes nothing, and one below it lets go at c / mu.
    """
    tension = min(10.0, strengths.get("cohesion", np.inf) / 0.5)
    asm = glued_down(
        profile(corners, place=place, turned=turned),
        law(friction=0.5, tension=10.0, **strengths),
        place=place,
        first=first,
    )
    assert opened(asm, x=place[0]) == pytest.approx(tension * moment, rel=1e-5)


def test_a_bond_is_spread_over_the_feet():
    """F acts at the centroid of the two feet, whatever their area."""
    found = opened(glued_down(profile(FEET), law(friction=0.5, bond=4.0)))
    assert found == pytest.approx(4.0 * (0.5 * 0.25 + 0.02 * 0.99) / 0.52, rel=1e-5)


def test_feet_on_one_ground_and_on_two_hold_the_same():
    values = []
    for ends in ([-5, 5], [-5, 0.7, 5]):
        grounds = [box((a, -5, -1), (b, 5, 0), name=f"g{a}", group="ground") for a, b in itertools.pairwise(ends)]
        asm = assembly([*grounds, profile(FEET)], supports=[g.name for g in grounds], joints=[law(tension=10.0)])
        moment = np.zeros((len(grounds) + 1, 6))
        moment[-1, 4] = -1.0
        values.append(limit_load(asm, moment).lower)
    assert values[0] == pytest.approx(values[1], rel=1e-6)


@pytest.mark.parametrize("cut", [0.0, 1e-6, 1e-3, 0.3])
def test_a_corner_that_is_cut_off_a_glued_triangle_takes_its_own_area_with_it(cut):
    """T times the first moment of the triangle less that of its corner: 1 mm of a corner is next to nothing."""
    plan = [(0, 0), (1, 0), (0, 1)] if not cut else [(0, 0), (1 - cut, 0), (1 - cut, cut), (0, 1)]
    stone = plate(plan, 0.01)
    lost = cut**2 / 2 * (1 - 2 * cut / 3)
    found = opened(glued_down(stone, law(tension=10.0)))
    assert found == pytest.approx(10.0 * (1 / 6 - lost), rel=1e-5)


ELL = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


@pytest.mark.parametrize("turned", [0, 2, 3])
@pytest.mark.parametrize("place", [(0, 0, 0), UTM])
def test_a_joint_in_the_form_of_an_l_has_the_area_of_the_l(place, turned):
    """Area 3 and first moment 2.5 about x = 0; the hull has 3.5 and 3.083."""
    asm = glued_down(plate(ELL, 0.5, place=place, turned=turned), law(tension=10.0), place=place)
    assert opened(asm, x=place[0]) == pytest.approx(25.0, rel=1e-5)
    lifted = limit_load(asm, pull((0, 0, 1), np.cross(np.array([5, 5, 1]) / 6 - (asm.centroid[1] - place), (0, 0, 1))))
    assert lifted.lower == pytest.approx(30.0 + asm.mass[1] * np.linalg.norm(asm.gravity), rel=1e-5)


def test_an_l_crushes_on_its_own_area():
    """C times the area of the L, pressed at its centroid; its hull has a sixth more."""
    asm = glued_down(plate(ELL, 0.5), law(compression=10.0))
    load = pull((0, 0, -1), np.cross(np.array([5 / 6, 5 / 6, 0]) - asm.centroid[1], (0, 0, -1)))
    found = limit_load(asm, load)
    assert found.lower == pytest.approx(30.0 - asm.mass[1] * np.linalg.norm(asm.gravity), rel=1e-4)


@pytest.mark.parametrize("cells", [4, 8, 16])
def test_cohesion_at_the_corners_is_more_than_uniform_cohesion_in_torsion_and_cells_are_less(cells):
    """Without pressure .382598 c a^3 is exact; at the corners c acts on the arm a / sqrt 2."""
    asm = slab(law(cohesion=10.0), size=(1.0, 1.0, 1e-3))
    torque = pull((0, 0, 0), (0, 0, 1))
    assert limit_load(asm, torque).lower == pytest.approx(10.0 / np.sqrt(2), rel=1e-4)
    found = limit_load(asm.with_(joints=[law(cohesion=10.0, cells=cells)]), torque).lower / 3.82598
    assert 1 - 0.5 / cells**1.5 < found < 1.0
