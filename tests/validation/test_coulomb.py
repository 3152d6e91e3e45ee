"""Verdicts without dilatancy and self-stress on the wedges of Kao et al., CAD 146:103216 (2022).

Closed forms: a block in a V-groove slides along it at tan(theta) = mu / sin(beta), beta the flank's angle from the
vertical; 3DEC and coupled rigid-block analysis give the same to a tenth of a degree.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Outcome, assess, build, limit_load, load_scene, read, tilt_limit, with_values
from blockstat.coulomb import MOST_SOLVES, coulomb_state
from blockstat.problem import pose
from problems import FERRIS, arch, assembly, box, ferris_wall, running_bond, stack

#: case, axis, mu, closed form [deg], force-only statics with the exact cone [deg, derived]
WEDGES = [
    ("type_a", "x", 0.2, 21.80, 23.09),
    ("type_a", "y", 0.2, 71.31, 71.30),
    ("type_c", "x", 0.2, 13.00, 13.08),
    ("type_a", "x", 0.84, 59.24, 180.0),
    ("type_c", "x", 0.84, 44.13, 46.96),
]
SELF_STRESS = Outcome.STABLE_ONLY_BY_SELF_STRESS


def tilted(asm, axis, degrees):
    turn = Rotation.from_euler(axis, degrees, degrees=True)
    return asm.with_(gravity=turn.apply(asm.gravity))


@pytest.mark.parametrize(("case", "axis", "mu", "closed_form", "force_only"), WEDGES)
def test_critical_angles(cases, case, axis, mu, closed_form, force_only):
    asm = read(cases / f"cra_{case}__y0.json").with_(friction=mu)
    associated = tilt_limit(asm, axis)
    assert associated.stands == pytest.approx(force_only, abs=0.011)
    for degrees in (closed_form - 0.5, closed_form + 0.5):
        verdict = assess(tilted(asm, axis, degrees), flow="coulomb")
        assert (verdict.outcome is Outcome.STABLE) == (degrees < closed_form)
        assert verdict.coulomb is None or verdict.coulomb.solves < 50


@pytest.mark.parametrize(
    ("case", "mu", "outcome"),
    [("H", 0.3, SELF_STRESS), ("H", 0.84, SELF_STRESS), ("H", 1.5, SELF_STRESS), ("A", 0.84, SELF_STRESS),
     ("shelf", 0.9, SELF_STRESS), ("shelf_stable", 0.9, Outcome.STABLE)],
)  # fmt: skip
def test_false_positives_of_force_only_statics(cases, case, mu, outcome):
    asm = read(cases / f"cra_{case}.json").with_(friction=mu)
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, flow="coulomb").outcome is outcome


@pytest.mark.parametrize(
    ("case", "degrees"), [("type_a__y0", 59.0), ("type_a__y0", 59.5), ("H", 0.0), ("shelf_stable", 0.0)]
)
def test_units_order_and_compliance_do_not_matter(cases, case, degrees):
    asm = tilted(read(cases / f"cra_{case}.json").with_(friction=0.84), "x", degrees)
    expected = assess(asm, flow="coulomb").outcome
    for scale in (1e-3, 1e3):
        assert assess(asm.with_(vertices=scale * asm.vertices), flow="coulomb").outcome is expected
        assert assess(asm.with_(density=scale * asm.density), flow="coulomb").outcome is expected
    problem = pose(asm, friction=None, gravity=None, loads=None, gap=1e-2, interfaces=None)
    for compliance in (1e-5, 1e-4, 1e-3, 1e-2, 1e-1):
        state = coulomb_state(problem.program, compliance=compliance)
        assert state.settles is (expected is Outcome.STABLE)
        assert state.solves <= MOST_SOLVES


def test_a_flat_arch_slips_out_between_rigid_abutments():
    # Force-only statics hold it by any thrust; real abutments push only as hard as the arch makes them.

    blocks = [box((-1, 0, 0), (0, 1, 1), name="left"), box((2, 0, 0), (3, 1, 1), name="right")]
    blocks += [box((0.25 * k, 0, 0), (0.25 * (k + 1), 1, 1)) for k in range(8)]
    asm = assembly(blocks, supports=["left", "right"], friction=0.1)
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, flow="coulomb").outcome is SELF_STRESS


@pytest.mark.parametrize("make", [lambda: stack(4), lambda: arch(20, 0.12), lambda: running_bond(6, 5)])
def test_ordinary_masonry_settles_at_once(make):
    verdict = assess(make(), flow="coulomb")
    assert verdict.outcome is Outcome.STABLE
    assert verdict.coulomb.solves <= 5


def test_the_chapel_that_statics_allow_and_bullet_fells(root):
    # Walls of .5 m: statically admissible, and Bullet sees the vault spread (see the demo's report).
    scene = load_scene(root / "examples" / "chapel.toml")
    outcomes = [
        assess(build(with_values(scene, {"wall.thickness": t})), flow="coulomb").outcome for t in (0.6, 0.5, 0.4)
    ]
    assert outcomes == [Outcome.STABLE, SELF_STRESS, Outcome.UNSTABLE]


def test_friction_without_slip_law_needs_no_fixed_point():
    for mu in (0.0, np.inf):
        verdict = assess(stack(2), friction=mu, flow="coulomb")
        assert verdict.outcome is Outcome.STABLE
        assert verdict.coulomb is None


@pytest.mark.slow
@pytest.mark.parametrize(("name", "published"), [("W1", 0.640), ("W3", 0.356), ("W4", 0.264)])
def test_zero_dilatancy_of_ferris_and_tin_loi(name, published):
    # Ferris & Tin-Loi (2001), complementarity program; the factor is not unique and the published ones are minima.
    found = limit_load(ferris_wall(FERRIS[name][0]), (1, 0, 0), flow="coulomb")
    assert found.lower == pytest.approx(FERRIS[name][4], abs=1e-6)
    low, high = found.coulomb
    assert low == pytest.approx(published, rel=5e-3)
    assert high == pytest.approx(published, rel=5e-3)


def test_least_coulomb_pull_on_a_slab():
    # Associated P = mu (W_A + 2 W_B / (1 - mu^2)); least Coulomb P = mu (W_A + 2 W_B / (1 + mu^2)) = 1.3 at mu = .5.
    blocks = [
        box((-3, 0, -1), (8, 1, 0), name="ground"),
        box((2, 0, 1), (3, 1, 2), name="wall"),
        box((-2, 0, 0), (2, 1, 1), name="A", density=0.25),
        box((-2, 0, 1), (2, 1, 2), name="B", density=0.25),
    ]
    asm = assembly(blocks, supports=["ground", "wall"], friction=0.5)
    pull = np.zeros((4, 6))
    pull[2, [0, 4]] = 1.0, -0.5  # at the height of the lower joint
    found = limit_load(asm, pull, flow="coulomb")
    assert found.lower == pytest.approx(11 / 6, rel=1e-8)
    assert found.coulomb[0] <= 1.3 <= found.coulomb[1] * (1 + 1e-6)


def test_hinging_has_no_dilatancy_to_lose():
    found = limit_load(arch(20, 0.2), (1, 0, 0), flow="coulomb")
    assert found.coulomb[0] == pytest.approx(found.lower, rel=6e-4)
