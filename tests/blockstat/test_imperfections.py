"""Imperfect joints, friction, weights and loads: the worst case in closed form, by reference and by enumeration."""

import itertools
import json
import math
import subprocess
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import shapely
from scipy.optimize import brentq

from blockstat import (
    Assembly,
    Block,
    Imperfections,
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    assess,
    box,
    find_interfaces,
    limit_load,
    load_case,
    point_load,
    prove_limit,
    prove_verdict,
    tilt_limit,
    write,
)
from blockstat.analysis.limit_load import _carried
from blockstat.analysis.tilt_friction import bracket, tilt
from blockstat.contact.features import ContactKind
from blockstat.imperfection.lost_edges import least_width, lose_edges
from blockstat.imperfection.lost_patches import corner_speeds, lose_rims
from evidence.bisection import bisect
from evidence.scenes.small import arch, assembly, running_bond, stack, trilith
from overhang import BACKWARDS, FORWARDS, PLACES, apex, beside, one_support, overhanging, ridge, rising
from point_bodies import ladder
from tests.crosscheck import test_arch_program as planar

SIDE = (1, 0, 0)
EXACT = 1e-6


def agrees(found, exact):
    assert found.lower == pytest.approx(exact, rel=EXACT)
    assert found.upper == pytest.approx(exact, rel=EXACT)


@pytest.mark.parametrize("delta", [0.0, 0.01, 0.05, 0.2])
def test_a_block_rocks_about_an_edge_that_is_further_in(delta):
    """(b - 2 delta) / h."""
    agrees(limit_load(stack(1, 1.0, 2.0), SIDE, imperfections=Imperfections(edge=delta)), (1 - 2 * delta) / 2)
    found = tilt_limit(stack(1, 1.0, 2.0), "y", imperfections=Imperfections(edge=delta), friction=2.0)
    assert found.stands == pytest.approx(math.degrees(math.atan((1 - 2 * delta) / 2)), rel=EXACT)


def test_a_stack_and_a_trilith_lose_the_same():
    loss = Imperfections(edge=0.02)
    agrees(limit_load(stack(5, 1.0, 0.5), SIDE, imperfections=loss), (1 - 0.04) / 2.5)
    whole = limit_load(trilith(), SIDE).lower  # b / h = .25
    side = min(np.ptp(trilith().block_vertices(1)[:, :1], axis=0)[0], 1.0)
    agrees(limit_load(trilith(), SIDE, imperfections=loss), whole * (side - 0.04) / side)


def chain(thickness, delta):
    """A semicircle of 20 voussoirs of which each joint has lost delta at both ends."""
    whole = planar.arch(20, thickness)
    inner, outer = whole.joints.swapaxes(0, 1)
    along = (outer - inner) / thickness
    return replace(whole, joints=np.stack([inner + delta * along, outer - delta * along], axis=1))


@pytest.mark.parametrize("thickness", [0.2, 0.15])
def test_the_multiplier_of_an_arch_with_shrunk_joints(thickness):
    """Semicircle of 20 voussoirs, infinite friction, against a planar linear program."""
    for delta in (0, 0.0025, 0.005, 0.01, 0.015, 0.02):
        shrunk = chain(thickness, delta)
        value = planar.solve(shrunk, np.inf, load=planar.sideways(shrunk))
        found = limit_load(arch(20, thickness, friction=np.inf), SIDE, imperfections=Imperfections(edge=delta))
        assert found.lower == pytest.approx(value, abs=1e-8)
        assert found.upper == pytest.approx(value, abs=1e-8)


@pytest.mark.parametrize("delta", [0, 0.0025, 0.005, 0.01, 0.02])
def test_the_least_thickness_of_an_arch_grows_by_twice_the_loss(delta):
    """t/R of a semicircle of 20 voussoirs, infinite friction, against a planar linear program."""
    least = brentq(lambda thickness: planar.solve(chain(thickness, delta), np.inf), 0.1, 0.2, xtol=1e-9)

    def stands(thickness):
        scene = arch(20, thickness, friction=np.inf)
        return assess(scene, imperfections=Imperfections(edge=delta), score=False).outcome is Outcome.STABLE

    found, _ = bisect(stands, least + 1e-3, least - 1e-3, 1e-8)
    assert found == pytest.approx(least, abs=1e-7)


@pytest.mark.parametrize(
    ("share", "degrees", "within"),
    [
        *(("0 %", 8.246367, 1.1e-6), ("2 %", 7.211128, 1.1e-6), ("4 %", 6.1265, 1.1e-6), ("6 %", 5.022037, 1.1e-6)),
        *(("8 %", 3.90394, 1.1e-6), ("10 %", 2.740505, 1.1e-6)),
        *(("6.575 %", 4.7, 2e-3), ("6.93 %", 4.5, 4e-3), ("6.22 %", 4.9, 4e-3)),
    ],
)
def test_the_tilt_of_an_arch_with_rounded_edges(share, degrees, within):
    """Shin et al. 2016, 36 voussoirs, t/R .15, mu tan 43: 8.246367 deg as drawn; 4.7 +- .2 measured, for which the loss
    is given in three or four digits."""
    scene = arch(36, 0.15, friction=math.tan(math.radians(43)))
    found = tilt_limit(scene, "y", imperfections=Imperfections(edge=share))
    assert found.stands == pytest.approx(degrees, abs=within)
    assert found.worst == ("" if share == "0 %" else f"joints lose {share} of their width at each edge")


def test_friction_is_divided():
    """A slab slides at mu, and a wedge of weights bears W tan: half the friction is half the push."""
    slab = stack(1, 2.0, 0.5)
    agrees(limit_load(slab, SIDE, friction=0.6, imperfections=Imperfections(friction=1.5)), 0.4)
    agrees(limit_load(slab, SIDE, friction=0.6, imperfections=Imperfections(friction=1.5, edge="1 mm")), 0.4)


@pytest.mark.parametrize(
    ("law", "bound"),
    [
        ({"cohesion": 0.7}, True),
        ({"tension": 0.3}, True),
        ({"cohesion": 0.7, "tension": 0.3}, False),
        ({"cohesion": 0.7, "bond": 0.3}, False),
        ({"cohesion": 0.7, "bond": 0.3, "bond_moment": 0.1}, True),
    ],
)
def test_where_less_friction_need_not_be_worse_the_words_say_so(law, bound):
    """In tension a joint holds mu f_n + c, f_n < 0: more with less friction."""
    slab = stack(1, 2.0, 0.5, density=1.0).with_(joints=[JointLaw(("*", "*"), **law)], gravity=(0, 0, -0.5))
    found = limit_load(slab, SIDE, friction=0.6, imperfections=Imperfections(friction=1.5))
    assert ("no bound" in found.worst) is not bound
    assert found.worst.startswith("friction / 1.5")
    assert "no bound" not in limit_load(slab, SIDE, friction=0.6, imperfections=Imperfections(edge="1 mm")).worst


def test_the_lightest_block_slides_first_and_the_heaviest_falls_first():
    """A dead push of 3 kN on a block: it slides at 3 kN = mu W."""
    block = stack(1).with_(gravity=np.array([0.0, 0.0, -10.0]), density=np.array([1.0, 500.0]))
    push = np.zeros((2, 6))
    push[1] = [1.0, 0, 0, 0, -0.5, 0]  # at the foot
    name = {"*": (400.0, 600.0)}
    agrees(limit_load(block, push, friction=0.5, imperfections=Imperfections(density=name)), 0.5 * 4000.0)
    overhang = assembly([box((-1, 0, -1), (0, 1, 0)), box((-1, 0, 0), (0.9, 1, 1), name="arm", group="arm"),
                         box((-1, 0, 1), (-0.5, 1, 2), name="ballast", group="ballast")], density=1.0)  # fmt: skip
    # Moments about the edge x = 0: the arm -.05 x 1.9 (inwards), the ballast .75 x .5 (inwards).
    light = Imperfections(density={"arm": (1.0, 1.0), "ballast": (0.1, 1.0)})
    assert assess(overhang, imperfections=light).outcome is Outcome.STABLE
    down = np.zeros((3, 6))
    down[1] = [0, 0, -1.0, *np.cross([0.9 + 0.05, 0, 0], [0, 0, -1.0])]  # at the tip, 0.9 outside
    agrees(limit_load(overhang, down, imperfections=light), (0.05 * 1.9 + 0.75 * 0.5 * 0.1) / 0.9)


def test_the_factor_on_the_weight_of_a_case_is_that_of_the_densities_allowed_for():
    """A push at the foot of a block slides it at 0.9 mu W, W the least, whatever factor its other loads have."""
    block = stack(1).with_(gravity=np.array([0.0, 0.0, -10.0]), density=np.array([1.0, 500.0]))
    push = np.zeros((2, 6))
    push[1] = [1.0, 0, 0, 0, -0.5, 0]
    case = load_case(block, "light", {"push": push}, {"light": {"weight": 0.9, "live": {"push": 2.0}}})
    allowed = Imperfections(density={"*": (400.0, 600.0)}, loads={"*": (0.0, 1.5)})
    options = {"friction": 0.5, "imperfections": allowed}
    found = limit_load(block, case.live, loads=case.weighted_permanent, **options)
    agrees(found, 0.5 * 0.9 * 4000.0 / 2)
    proof = prove_limit(found, case.live, loads=case.weighted_permanent)
    assert float(proof.content["proof"]["multiplier"]) == pytest.approx(900.0, rel=EXACT)
    for share, outcome in ((0.999, Outcome.STABLE), (1.001, Outcome.UNSTABLE)):
        acting = replace(case, live=share * 0.5 * 0.9 * 4000.0 / 1.5 * push).weighted_loads
        assert assess(block, loads=acting, **options).outcome is outcome


def test_the_proof_of_a_worst_case_is_under_its_own_loads():
    """A block twice as high as wide tips at half its weight: under 1.5 times a push of 0.3 it carries 0.05 more."""
    block = stack(1, 1.0, 2.0, density=2000.0)
    push = np.zeros((2, 6))
    push[1, 0] = 0.3 * block.free_weight
    for factor, outcome in ((1.5, Outcome.STABLE), (2.0, Outcome.UNSTABLE)):
        allowed = Imperfections(loads={"*": (0.5, factor)})
        found = assess(block, loads=push, imperfections=allowed)
        proof = prove_verdict(found, loads=push)
        assert found.outcome is outcome
        assert proof.outcome.word == outcome.word
        assert float(proof.content["data"]["blocks"][1]["dead"][0]) == pytest.approx(factor * push[1, 0], rel=EXACT)
        limit = limit_load(block, SIDE, loads=push, imperfections=allowed)
        proof = prove_limit(limit, SIDE, loads=push)
        if outcome is Outcome.STABLE:
            assert float(proof.content["proof"]["multiplier"]) == pytest.approx(0.05, rel=1e-4)
        else:
            assert proof.outcome.word == "unstable"


def test_a_proof_is_under_the_loads_of_its_answer():
    """Loads need not be given again, and others are refused."""
    block = stack(1, 1.0, 2.0, density=2000.0)
    push = np.zeros((2, 6))
    push[1, 0] = 0.3 * block.free_weight
    limit = limit_load(block, SIDE, loads=push)
    assert float(prove_limit(limit, SIDE).content["proof"]["multiplier"]) == pytest.approx(0.2, rel=1e-4)
    for proof in (partial(prove_limit, limit, SIDE), partial(prove_verdict, assess(block))):
        with pytest.raises(InputError, match="loads: they are not those that the answer was found under"):
            proof(loads=0.5 * push)


def test_a_load_that_helps_is_least_and_one_that_harms_is_greatest():
    block = stack(1, 1.0, 2.0, density=1.0)
    dead = np.zeros((2, 6))
    dead[1] = [0, 0, -1.0, 0, 0, 0]  # half the weight of 2
    options = {"loads": dead, "friction": 5.0}
    agrees(limit_load(block, SIDE, imperfections=Imperfections(loads={"*": (0.0, 1.0)}), **options), 0.5)
    agrees(limit_load(block, SIDE, imperfections=Imperfections(loads={"*": (0.5, 1.0)}), **options), 0.5 * 2.5 / 2)


SCENES = [
    *(stack(n, w, h) for n, w, h in itertools.product((1, 2, 3), (0.8, 1.0), (0.5, 1.2))),
    *(arch(n, t) for n, t in itertools.product((3, 4, 5, 6, 7), (0.15, 0.2, 0.3))),
    *(running_bond(c, b) for c, b in itertools.product((2, 3), (1, 2))),
    *(trilith(d) for d in (0.5, 1.0, 2.0, 5.0)),
]


@pytest.mark.parametrize("number", [*range(8), *(pytest.param(k, marks=pytest.mark.slow) for k in range(8, 50))])
def test_the_worst_case_is_the_worst_of_all_combinations(number):
    """Edges of each joint lost or not, friction less or not, densities at either end: none is worse, one is equal."""
    scene = SCENES[number % len(SCENES)]
    rng = np.random.default_rng(number)
    loss, gamma = rng.uniform(0.005, 0.02), rng.uniform(1.1, 1.6)
    names = tuple(f"part{k % 3}" for k in range(scene.n_blocks))
    scene = scene.with_(groups=names, friction=rng.uniform(0.4, 0.9))
    density = {name: tuple(np.sort(rng.uniform(1500, 3000, 2))) for name in sorted(set(names))}
    load = np.array([1.0, rng.uniform(-0.3, 0.3), rng.uniform(-0.2, 0.2)])
    found = limit_load(scene, load, imperfections=Imperfections(edge=loss, friction=gamma, density=density))
    whole = find_interfaces(scene)
    n = whole.n_interfaces
    # All combinations of joints where they are few; else all joints lost, none, and some at random.
    every = np.array(list(itertools.product((False, True), repeat=n))) if n <= 4 else None
    masks = [np.ones(n, bool), np.zeros(n, bool), *(rng.random((2, n)) < 0.5)] if every is None else every
    values = []
    for mask, mu, ends in itertools.product(masks, (1.0, gamma), itertools.product(*density.values())):
        weights = np.array([dict(zip(density, ends, strict=True))[name] for name in names])
        case = scene.with_(density=weights, friction=scene.friction / mu)
        values.append(limit_load(case, load, interfaces=lose_edges(whole, loss * mask)).lower)
    assert found.lower == pytest.approx(min(values), rel=1e-6, abs=1e-9)


def test_an_edge_on_a_face_loses_its_ends_and_a_corner_nothing():
    scene = Assembly.from_blocks([*ladder(60.0)], supports=[0, 1], friction=0.6)
    joints = find_interfaces(scene)
    assert (joints.kinds == ContactKind.EDGE).all()
    found = lose_edges(joints, np.full(joints.n_interfaces, 0.1))
    ends = found.point.reshape(-1, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 0.6 - 0.2)
    np.testing.assert_allclose(least_width(joints), 0.6)
    assert lose_edges(joints, np.full(joints.n_interfaces, 0.31)).n_interfaces == 0


def test_the_width_of_a_joint_with_a_notch_is_that_of_its_limbs_however_its_face_is_drawn():
    """An L of limbs 1 m and 0.5 m wide."""
    corners = [(0, 0), (2, 0), (2, 0.5), (1, 0.5), (1, 2), (0, 2)]
    foot = [(x, y, 0.0) for x, y in corners]
    n = len(corners)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    top = [*range(n, 2 * n)]
    for bottom in ([[*range(n)][::-1]], [[3, 2, 1], [3, 1, 0], [3, 0, 5], [3, 5, 4]]):
        block = Block(np.vstack([foot, np.array(foot) + (0, 0, 1)]), [*bottom, top, *sides])
        joints = find_interfaces(assembly([box((-1, -1, -1), (3, 3, 0)), block]))
        assert joints.n_interfaces == 1
        np.testing.assert_allclose(least_width(joints), 0.5)


def test_a_joint_narrower_than_what_it_loses_is_gone():
    found = assess(stack(2), imperfections=Imperfections(edge=0.51))
    assert found.outcome is Outcome.UNSTABLE
    assert len(found.floating) == 2
    np.testing.assert_allclose(find_interfaces(stack(1)).area, 1.0)
    lost = lose_edges(find_interfaces(stack(1)), np.array([0.1]))
    np.testing.assert_allclose(lost.area, 0.64)
    np.testing.assert_allclose(np.ptp(lost.point, axis=0), [0.8, 0.8, 0.0], atol=1e-12)


def test_nothing_is_lost_without_imperfections():
    one, two = limit_load(arch(10, 0.2), SIDE), limit_load(arch(10, 0.2), SIDE, imperfections=Imperfections())
    assert (one.lower, one.upper) == (two.lower, two.upper)
    assert one.worst == two.worst == ""


def test_the_worst_case_can_be_proved():
    """Its assembly and joints are in the result."""
    found = limit_load(arch(7, 0.25), SIDE, imperfections=Imperfections(edge="5 mm", friction=1.2))
    assert "joints lose 5 mm at each edge, friction / 1.2" in found.explain()
    assert float(prove_limit(found, SIDE).content["proof"]["multiplier"]) == pytest.approx(found.lower)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"edge": "3 inches"}, 'edge is \'3 inches\'; it must be metres, or text such as "3 mm" or "5 %"'),
        ({"edge": "60 %"}, "edge is"),
        ({"edge": -1.0}, "edge is"),
        ({"friction": 0.9}, "friction is 0.9; it divides friction and is at least 1"),
        ({"density": {"wall": (2000, 1000)}}, 'density of "wall" is'),
        ({"density": {"wall": (0, 1000)}}, 'density of "wall" is'),
        ({"density": {"wall": 1800}}, 'density of "wall" is 1800; it must be two densities .*, least first'),
        ({"density": {"wall": ("1800", "2000")}}, 'density of "wall" is'),
        ({"density": {"wall": (1800, (2000, 2100))}}, 'density of "wall" is'),
        ({"loads": {"wall": 1.2}}, 'loads of "wall" is 1.2; it must be two factors, least first'),
        ({"density": 1800}, "density is 1800; it must be ranges by group"),
        ({"loads": {"wall": (1, 2, 3)}}, 'loads of "wall" is'),
        ({"density": {str(k): (1, 2) for k in range(11)}}, "11 ranges; 10 are the most"),
    ],
)
def test_errors_say_what_is_wrong(given, message):
    with pytest.raises(InputError, match=message.replace("(", r"\(").replace(")", r"\)")):
        Imperfections(**given)


def test_groups_must_exist():
    with pytest.raises(InputError, match='no group "nave"'):
        assess(stack(1), imperfections=Imperfections(density={"nave": (1, 2)}))
    with pytest.raises(InputError, match="there are no permanent loads"):
        assess(stack(1), imperfections=Imperfections(loads={"*": (1, 2)}))


@pytest.mark.parametrize(
    ("question", "key", "exact"),
    [
        (("limit", "--load", "1,0,0"), "lower", 0.9 / 2 / 1),
        (("tilt", "--axis", "y"), "stands_deg", math.degrees(math.atan(0.9 / 2))),
        (("check", "--tilt", "y,24"), "verdict", "stable"),
        (("check", "--tilt", "y,25"), "verdict", "unstable"),
    ],
)
def test_the_commands_ask_for_the_worst_case(tmp_path, question, key, exact):
    file = write(stack(1, 1.0, 2.0), tmp_path / "block.json")
    command, *rest = question
    answer = run(command, file, *rest, "--imperfection", "edge=5 %", "--imperfection", "friction=1.05", "--json")
    assert answer.returncode == 0, answer.stderr
    found = json.loads(answer.stdout)
    assert found[key] == (exact if isinstance(exact, str) else pytest.approx(exact, rel=EXACT))
    assert found["imperfections"] == "joints lose 5 % of their width at each edge, friction / 1.05"


def test_the_option_names_what_it_does_not_understand(tmp_path):
    file = write(stack(1, 1.0, 2.0), tmp_path / "block.json")
    for text in ("edges=3", "density=1,2", "density.wall=1", "friction"):
        answer = run("check", file, "--imperfection", text)
        assert answer.returncode == 2
        assert f'--imperfection is "{text}"; it must read edge=LENGTH' in answer.stderr


def run(*arguments):
    code = "from blockstat.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_joints_that_are_divided_have_no_edges_to_lose():
    held = stack(1, 1.0, 2.0, friction=2.0, joints=[JointLaw(("*", "*"), cells=2)])
    divided = limit_load(held, SIDE).interfaces
    with pytest.raises(InputError, match="imperfections: joints that are divided into cells have no edges to lose"):
        tilt_limit(held, "y", interfaces=divided, imperfections=Imperfections(edge=0.01))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("order", [FORWARDS, BACKWARDS])
@pytest.mark.parametrize("inside", [1e-3, 2.6e-3, 3.1e-3, 0.02])
def test_what_bears_on_a_lost_strip_of_a_face_is_lost_with_it(inside, order, place):
    """A slab, of which 3 mm at the rim are lost, on a prop so far from its rim; without the prop it falls."""
    loss = Imperfections(edge=3e-3 * place[1])
    for prop in (apex(1.5 - inside), apex(1.4, y=inside), ridge(1.5 - inside), rising(inside), rising(0.3, y=inside)):
        asm, _ = overhanging(prop, place=place, order=order)
        assert assess(asm, score=False).outcome is Outcome.STABLE
        found = assess(asm, imperfections=loss, score=False)
        assert found.outcome is (Outcome.STABLE if inside > 3e-3 else Outcome.UNSTABLE)


def test_edges_that_cross_are_lost_where_a_slip_as_long_as_the_loss_parts_them():
    """Half a metre from their ends edges at an angle of .01 are 5 mm apart."""
    asm, _ = overhanging(beside(0.01))
    for loss, stands in (("4.9 mm", True), ("5.1 mm", False)):
        found = assess(asm, imperfections=Imperfections(edge=loss), score=False)
        assert (found.outcome is Outcome.STABLE) is stands


@pytest.mark.parametrize("place", PLACES)
def test_an_edge_keeps_the_part_that_is_on_what_a_face_has_left(place):
    """A ridge whose one end is 1 mm and whose other end is 5 mm from the rim: half of it is further than 3 mm."""
    prop = ridge(0.0)
    corners = np.array(prop.vertices)
    corners[:3, 0] += 1.5 - 1e-3
    corners[3:, 0] += 1.5 - 5e-3
    # Its ends are beyond the slab, so that they are not lost themselves.
    along = corners[3:] - corners[:3]
    corners[:3] -= 0.5 * along
    corners[3:] += 0.5 * along
    asm, _ = overhanging(replace(prop, vertices=corners), place=place)
    joints = find_interfaces(asm)
    assert sorted(joints.kinds.tolist()) == [ContactKind.FACE, ContactKind.EDGE]
    turn, scale, away = place
    left = lose_edges(joints, np.full(2, 3e-3 * scale), asm)
    k = int(np.flatnonzero(left.kinds == ContactKind.EDGE)[0])
    c, s = np.cos(turn), np.sin(turn)
    found = (left.point[left.start[k] : left.start[k + 1]] - away) / scale @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    found = found[found[:, 1].argsort()]
    assert found[0] == pytest.approx((1.5 - 3e-3, 0.5, 0), abs=1e-4)
    assert found[1, 1] == pytest.approx(1 - 3e-3, abs=1e-5)
    # It is lost where nothing of it is further than that.
    assert not lose_edges(joints, np.full(2, 5.1e-3 * scale), asm).kinds.any()
    # Joints alone lose the ends.
    ends = lose_edges(joints, np.full(2, 3e-3 * scale))
    k = int(np.flatnonzero(ends.kinds == ContactKind.EDGE)[0])
    assert np.ptp(ends.point[ends.start[k] : ends.start[k + 1]], axis=0).max() > 0.99 * scale * max(abs(c), abs(s))


@pytest.mark.parametrize("edge", [False, True])
def test_an_edge_or_a_corner_beside_a_patch_of_its_pair_goes_with_the_strip_it_is_on(edge):
    """The bed has a foot below the slab and a ridge, or a tip, 2 mm from the far rim of the slab: one joint."""
    asm = one_support(2e-3, edge=edge)
    for loss, stands in (("1 mm", True), ("3 mm", False)):
        found = assess(asm, imperfections=Imperfections(edge=loss), score=False)
        assert (found.outcome is Outcome.STABLE) is stands


def test_friction_that_is_given_joint_by_joint_is_divided_too():
    slab = stack(1, 2.0, 0.5, friction=0.9)
    joints = find_interfaces(slab)
    rough = replace(joints, friction=np.full(joints.n_interfaces, 0.6))
    agrees(limit_load(slab, SIDE, interfaces=rough), 0.6)
    agrees(limit_load(slab, SIDE, interfaces=rough, imperfections=Imperfections(friction=1.5)), 0.4)


def test_a_block_on_its_corner_has_joints_without_width():
    """A pyramid on its tip: the corner has no width, and keeps its place."""
    tip = Block([(0, 0, 0), (1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)],
                [[1, 2, 3, 4], [0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4]])  # fmt: skip
    joints = find_interfaces(assembly([box((-2, -2, -1), (2, 2, 0)), tip]))
    assert joints.kinds.tolist() == [ContactKind.CORNER]
    assert least_width(joints).tolist() == [0.0]
    lost = lose_edges(joints, np.array([0.1]))
    np.testing.assert_allclose(lost.point, [[0, 0, 0]], atol=1e-12)


def test_the_worst_case_of_joints_with_cells_is_of_the_joints_that_were_handed_in():
    slab = stack(1, 2.0, 0.5, joints=[JointLaw(("*", "*"), cells=2)])
    faces = find_interfaces(slab)
    faces = replace(faces, friction=np.full(faces.n_interfaces, 0.2))
    for worst in (None, Imperfections(), Imperfections(edge=1e-3)):
        found = limit_load(slab, (1, 0, 0), friction=0.9, interfaces=faces, imperfections=worst)
        assert (found.lower, found.upper) == pytest.approx((0.2, 0.2), rel=1e-3)
        leaning = assess(slab, gravity=(0.5, 0, -1), interfaces=faces, imperfections=worst)
        assert leaning.outcome is Outcome.UNSTABLE


def table(*feet, place=(0.0, 0.0, 0.0)):
    """A table of depth 1 whose feet are x from, x to."""
    ends = sorted(feet)
    outline = [(ends[0][0], 0.0)]
    for (_, end), (begin, _) in itertools.pairwise(ends):
        outline += [(end, 0.0), (end, 0.2), (begin, 0.2), (begin, 0.0)]
    outline += [(ends[-1][1], 0.0), (ends[-1][1], 0.4), (ends[0][0], 0.4)]
    n = len(outline)
    faces = [list(range(n)), list(range(2 * n - 1, n - 1, -1))]
    faces += [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    corners = np.array([(x, y, z) for y in (0.0, 1.0) for x, z in outline])
    return Block(corners + place, faces, name="table")


def on_grounds(block, *cuts, **options):
    grounds = [box((a, -1, -1), (b, 2, 0), name=f"ground{a}") for a, b in itertools.pairwise([-1, *cuts, 3])]
    return Assembly.from_blocks([*grounds, block], supports=range(len(grounds)), density=1000.0, **options)


@pytest.mark.parametrize("width", [0.1, 0.4])
def test_a_share_of_the_width_is_that_of_each_foot_whatever_the_ground_is_made_of(width):
    """The table tips about the edge of a foot, which has lost 5 % of the foot's width."""
    for cuts in ((), (1,)):
        scene = on_grounds(table((0, width), (2 - width, 2)), *cuts, friction=9.0)
        tips = (1 - 0.05 * width) / scene.centroid[-1][2]
        agrees(limit_load(scene, SIDE, imperfections=Imperfections(edge="5 %")), tips)


@pytest.mark.parametrize("loss", ["1 mm", "3 mm", "0.05 m"])
@pytest.mark.parametrize("feet", [((0, 0.4), (0.996, 1)), ((0, 0.004), (0.5, 1)), ((0, 0.3), (0.7, 1))])
def test_a_foot_is_lost_whatever_the_ground_is_made_of(feet, loss):
    """A foot 4 mm wide has nothing left after 3 mm at each of its edges."""
    found = [
        limit_load(asm, (1, 0, 0), imperfections=Imperfections(edge=loss))
        for asm in (on_grounds(table(*feet), 0.45), on_grounds(table(*feet)))
    ]
    assert found[0].outcome is found[1].outcome
    if np.isfinite(found[0].lower):
        assert found[1].lower == pytest.approx(found[0].lower, rel=1e-6)
    stable = [assess(asm, imperfections=Imperfections(edge=loss)).outcome for asm in (
        on_grounds(table(*feet), 0.45), on_grounds(table(*feet))
    )]  # fmt: skip
    assert stable[0] is stable[1]
    lost = loss == "3 mm" and feet[0] == (0, 0.4)
    assert (stable[0] is Outcome.UNSTABLE) == (lost or (loss == "0.05 m" and feet[0] == (0, 0.4)))


@pytest.mark.parametrize("place", [(0, 0, 0), (5e5, 5.2e6, 300)])
def test_two_feet_lose_their_own_edges(place):
    block = table((0, 0.3), (0.7, 1), place=place)
    low, high = np.array([(-1, -1, -1), (2, 2, 0)]) + place
    joints = find_interfaces(Assembly.from_blocks([box(low, high), block], supports=[0]))
    lost = lose_edges(joints, np.array([0.1]))
    assert lost.area == pytest.approx([2 * 0.1 * 0.8])
    expected = [(0.1, 0.1), (0.1, 0.9), (0.9, 0.1), (0.9, 0.9)]
    assert sorted(map(tuple, (lost.point - place)[:, :2].round(6).tolist())) == expected
    assert len(lost.parts[0]) == 2
    again = lose_edges(lost, np.array([0.02]))
    assert again.area == pytest.approx([2 * 0.06 * 0.76])
    assert again.drawn is joints
    assert lose_edges(joints, np.array([0.16])).n_interfaces == 0
    assert lose_edges(joints, np.array([0.0])).area == pytest.approx(joints.area)


def test_glue_is_lost_with_the_edges_of_feet():
    """T times the first moment of what is left of the feet about the rim that is left."""
    law = JointLaw(("*", "*"), tension=1e5)
    asm = on_grounds(table((0, 0.5), (0.9, 1)), joints=[law])
    moment = np.zeros((2, 6))
    moment[1, 4] = -1.0
    found = limit_load(asm, moment, imperfections=Imperfections(edge=0.02))
    glue = 1e5 * 0.96 * (0.46 * 0.23 + 0.06 * (0.95 - 0.02))
    weight = asm.mass[1] * 9.81 * (asm.centroid[1, 0] - 0.02)
    agrees(found, glue + weight)


def test_edges_that_were_in_a_joint_are_no_bare_contacts_once_it_has_lost_them():
    """The table and its plinth have aligned edges: (1 - 2 delta) / 2 h with the height h of the centroid."""
    asm = Assembly.from_blocks(
        [box((0, 0, -1), (1, 1, 0), name="plinth"), table((0, 0.3), (0.7, 1))],
        supports=[0],
        density=1000.0,
        friction=3.0,
    )
    agrees(limit_load(asm, SIDE), 0.5 / asm.centroid[1, 2])
    agrees(limit_load(asm, SIDE, imperfections=Imperfections(edge="50 mm")), 0.45 / asm.centroid[1, 2])


#: An L in pieces.
PIECES = {
    "two": [[(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1), (1, 1), (1, 2), (0, 2)]],
    "overhanging": [[(0, 0), (1, 0), (1, 2), (0, 2)], [(1, 0), (2, 0), (2, 1), (1, 1)]],
    "triangles": [
        [(0, 0), (2, 0), (2, 1)],
        [(0, 0), (2, 1), (1, 1)],
        [(0, 0), (1, 1), (0, 2)],
        [(1, 1), (1, 2), (0, 2)],
    ],
}


@pytest.mark.parametrize("depth", [0.0, 0.1, 0.3, 0.49, 0.5])
@pytest.mark.parametrize("name", PIECES)
def test_an_l_loses_its_rims_and_not_its_seams(name, depth):
    """The L less a strip along each rim, its notch losing a square: (2 - 2 d)^2 less a square of side 1."""
    left, hull = lose_rims([np.array(p, float)[:: (-1) ** k] for k, p in enumerate(PIECES[name])], depth)
    expected = (2 - 2 * depth) ** 2 - 1
    area = sum(shapely.Polygon(part).area for part in left)
    assert area == pytest.approx(max(expected, 0), abs=1e-9)
    assert shapely.union_all([shapely.Polygon(part) for part in left]).area == pytest.approx(area, abs=1e-9)
    if expected > 0:
        d = depth
        ends = [(d, d), (2 - d, d), (2 - d, 1 - d), (1 - d, 2 - d), (d, 2 - d)]
        assert sorted(map(tuple, hull.round(9).tolist())) == sorted((round(x, 9), round(y, 9)) for x, y in ends)
    else:
        assert len(hull) == 0


def test_a_bare_edge_beside_a_foot_loses_its_ends_and_a_corner_stays():
    foot, edge, corner = (
        np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float),
        np.array([(3.0, 0), (3, 1)]),
        np.array([(2.0, 5)]),
    )
    left, hull = lose_rims([foot, edge, corner], 0.1)
    assert sorted(map(tuple, hull.round(9).tolist())) == [(0.1, 0.1), (0.1, 0.9), (2, 5), (3, 0.1), (3, 0.9)]
    assert sorted(map(len, left)) == [1, 2, 4]
    assert lose_rims([foot, edge], 0.5)[1].tolist() == []
    _, ends = lose_rims([foot * 0.1, edge], 0.1)
    assert sorted(map(tuple, ends.round(9).tolist())) == [(3, 0.1), (3, 0.9)]
    assert lose_rims([foot * 0.1, corner], 0.1)[1].tolist() == [[2, 5]]


@pytest.mark.parametrize("name", PIECES)
def test_corners_of_a_joint_of_patches_move_as_its_rims_do(name):
    parts = [np.array(p, float) for p in PIECES[name]] + [np.array([(2.5, 0.0), (2.5, 1.0)])]
    hull = lose_rims(parts, 0.0)[1]
    speed = corner_speeds(hull, parts)
    moved = lose_rims(parts, 1e-3)[1]
    for corner in hull + 1e-3 * speed:
        assert np.linalg.norm(moved - corner, axis=1).min() < 1e-9


def light_in_a_slot_and_heavy_on_an_edge():
    """Two cubes of 1 N: one in a slot, one with its weight .1 m beyond the edge of its table, held down by 2 N."""
    blocks = [
        box((-1, 0, 0), (0, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="right"),
        box((0, 0, -1), (1, 1, 0), name="floor"), box((0, 0, 0), (1, 1, 1), name="cube"),
        box((9, -1, -1), (10.4, 2, 0), name="table"), box((10, 0, 0), (11, 1, 1), name="leans"),
    ]  # fmt: skip
    fixed = ["left", "right", "floor", "table"]
    return Assembly.from_blocks(blocks, supports=fixed, friction=0.9, density=1.0, gravity=(0, 0, -1))


def test_without_dilatancy_the_worst_case_is_that_of_the_joints_that_carry_least():
    # Up by 4 N the cube rises at W / 4; with dilatancy it jams. Down by 1 N at 10.9 the other tips at
    # (2 x .2 - .1 W) / .5: that is least for the greatest weight, and what the cube carries for the least.
    asm = light_in_a_slot_and_heavy_on_an_edge()
    held = point_load(asm, "leans", (10.2, 0.5, 1.0), (0, 0, -2.0))
    load = point_load(asm, "leans", (10.9, 0.5, 1.0), (0, 0, -1.0)) + point_load(asm, "cube", (0.5,) * 3, (0, 0, 4.0))
    allowed = {"loads": held, "imperfections": Imperfections(density={"*": (0.8, 1.2)})}
    assert limit_load(asm, load, **allowed).lower == pytest.approx((0.4 - 0.12) / 0.5, rel=2e-4)
    found = limit_load(asm, load, flow="coulomb", **allowed)
    assert found.coulomb_least == pytest.approx((0.8 / 4, 0.8 / 4), rel=5e-3)
    assert found.lower == pytest.approx((0.4 - 0.08) / 0.5, rel=2e-4)


def test_a_case_of_which_nothing_is_known_without_dilatancy_is_worse_than_one_that_is_known():
    found = limit_load(stack(1), SIDE)
    known = replace(found, lower=0.5, coulomb_kinds=((0.4, 0.41), (0.3, 0.31)))
    unknown = replace(found, lower=0.6, outcome=LoadOutcome.UNDECIDED)
    assert [_carried(own, "coulomb") for own in (known, unknown, replace(unknown, lower=-np.inf))] == [
        0.3, 0.0, -np.inf,
    ]  # fmt: skip
    assert _carried(unknown, "associated") == 0.6


def test_the_tilt_of_the_worst_case_without_dilatancy_is_that_of_the_joints_that_bear_least(monkeypatch):
    told = iter([((30.0, 31.0), (10.0, 11.0)), ((20.0, 21.0), (15.0, 16.0))])
    monkeypatch.setattr(tilt, "_tilt", lambda *_: bracket.of_kinds(next(told), "tilt", "deg"))
    found = tilt_limit(stack(1), "y", flow="coulomb", imperfections=Imperfections(density={"*": (1.0, 2.0)}))
    assert (found.stands, found.least) == (30.0, (10.0, 11.0))


def test_what_the_worst_case_of_a_tilt_warns_of_is_told():
    """A pillar 3 cm thick loses its foot, and then nothing holds it."""
    asm = assembly([box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.03, 1, 1), name="thin")])
    assert not tilt_limit(asm, "y").warnings
    found = tilt_limit(asm, "y", imperfections=Imperfections(edge=0.02))
    assert math.isnan(found.stands)
    assert any('"thin"' in text for text in found.warnings)
