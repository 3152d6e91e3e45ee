"""Verdicts without dilatancy and self-stress on the assemblies of Kao et al., CAD 146:103216 (2022).

H, A and the shelf fall in 3DEC and in coupled rigid-block analysis. A block in a V-groove slides along it at
tan(theta) = mu / sin(beta), beta the flank's angle from the vertical; the critical angles of the wedges, and the limit
loads without dilatancy, are in `evidence.references`.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Outcome, assess, build, glued, limit_load, load_scene, read, with_values
from blockstat.analysis.coulomb import MOST_SOLVES, coulomb_state, settling_share
from blockstat.analysis.problem import pose
from evidence.scenes.bonded import bonded_scene, program_of
from evidence.scenes.small import arch, flat_arch, running_bond, stack

SELF_STRESS = Outcome.STABLE_ONLY_BY_SELF_STRESS


def tilted(asm, axis, degrees):
    turn = Rotation.from_euler(axis, degrees, degrees=True)
    return asm.with_(gravity=turn.apply(asm.gravity))


@pytest.mark.parametrize(
    ("case", "mu", "outcome"),
    [("H", 0.3, SELF_STRESS), ("H", 0.84, SELF_STRESS), ("H", 1.5, SELF_STRESS), ("A", 0.84, SELF_STRESS),
     ("shelf", 0.9, SELF_STRESS), ("shelf_stable", 0.9, Outcome.STABLE)],
)  # fmt: skip
def test_false_positives_of_force_only_statics(cases, case, mu, outcome):
    asm = read(cases / f"cra_{case}.json").with_(friction=mu)
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, flow="coulomb").outcome is outcome


@pytest.mark.parametrize("degrees", [59.14, 59.18, 59.21, 59.2372, 59.26, 59.3])
def test_next_to_its_limit_a_wedge_is_judged_right_or_not_at_all(cases, degrees):
    # tan(theta) = .84 / sin(30 deg): 59.2372 deg. The slips shrink by .998 a program, however long it takes.
    asm = tilted(read(cases / "cra_type_a__y0.json").with_(friction=0.84), "x", degrees)
    outcome = assess(asm, flow="coulomb").outcome
    assert outcome in (Outcome.UNDECIDED, Outcome.STABLE if degrees < 59.2372 else SELF_STRESS)
    assert outcome is not Outcome.UNDECIDED or abs(degrees - 59.2372) < 0.05


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
    asm = flat_arch(8, friction=0.1)
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, flow="coulomb").outcome is SELF_STRESS


@pytest.mark.parametrize("make", [lambda: stack(4), lambda: arch(20, 0.12), lambda: running_bond(6, 5)])
def test_ordinary_masonry_settles_at_once(make):
    verdict = assess(make(), flow="coulomb")
    assert verdict.outcome is Outcome.STABLE
    assert verdict.coulomb.solves <= 5


def test_how_tight_joints_are_decides_only_between_the_limits(cases):
    # A stack rests and A falls whatever the joints. A glued ring of blocks in torsion hangs on them, and less so when
    # the glue is stronger.
    for asm, share in ((stack(4), 1.0), (read(cases / "cra_A.json").with_(friction=0.84), 0.0)):
        assert settling_share(program_of(asm), tries=4) == share
    _, ring, _ = bonded_scene(56)
    assert assess(ring, flow="coulomb").outcome is Outcome.STABLE
    assert 0.0 < settling_share(program_of(ring)) < 0.5
    assert settling_share(program_of(glued(ring.with_(joints=()), 2.0 * ring.joints[0].bond))) > 0.5


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


def test_hinging_has_no_dilatancy_to_lose():
    found = limit_load(arch(20, 0.2), (1, 0, 0), flow="coulomb")
    assert found.coulomb[0] == pytest.approx(found.lower, rel=6e-4)
