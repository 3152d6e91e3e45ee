"""Joint laws against closed forms: Coulomb with cohesion and cut-offs, stress block, bonds, torsion (REFERENCES 1).

Stress block: a joint b wide under N at eccentricity e carries it on the width b - 2e, so e <= (b/2)(1 - N / (sigma A)).
Torsion of a square joint of side a under uniform pressure: mu N a (sqrt 2 + ln(1 + sqrt 2)) / 6 = .382598 mu N a.
"""

import numpy as np
import pytest

from blockstat import JointLaw, LoadOutcome, Outcome, assess, limit_load
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
