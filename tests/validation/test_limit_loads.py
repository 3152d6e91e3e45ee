"""Limit loads, tilts and thrusts against published values and values derived from first principles.

P: published. Ferris & Tin-Loi, Int. J. Mech. Sci. 43 (2001), the planar wall set; Ochsendorf, PhD thesis, Cambridge
(2002), tilted arch; De Lorenzis, DeJong & Ochsendorf, Earthquake Eng. Struct. Dyn. 36 (2007), the seven-voussoir arch.
D: derived by two independent methods (a planar linear program and hand-written mechanisms), to the digits given.
"""

import math

import numpy as np
import pytest

from blockstat import (
    LoadOutcome,
    friction_limit,
    limit_load,
    load_domain,
    point_load,
    settlement,
    thrust_range,
    tilt_limit,
)
from problems import FERRIS, arch, assembly, box, ferris_wall, hexahedron, running_bond, stack

BRACKET = 1e-6


def proven(result, exact, digits):
    assert result.outcome is LoadOutcome.LIMIT
    assert result.gap <= BRACKET
    assert result.lower <= exact + digits
    assert result.upper >= exact - digits
    return result.lower == pytest.approx(exact, abs=digits)


@pytest.mark.parametrize("name", FERRIS)
def test_ferris_and_tin_loi_walls(name):
    rows, blocks, joints, published, derived = FERRIS[name]
    result = limit_load(ferris_wall(rows), (1, 0, 0))
    assert (result.assembly.n_blocks - 1, result.interfaces.n_interfaces) == (blocks, joints)
    assert proven(result, derived, 1e-6)
    assert round(result.lower, 3) == published


INF = math.inf
ARCHES = [
    (180, 0.12, INF, 0.048631), (180, 0.12, 0.7, 0.048631), (180, 0.12, 0.6, 0.048631),
    (180, 0.15, INF, 0.149350), (180, 0.15, 0.7, 0.149350), (180, 0.15, 0.6, 0.149350),
    (180, 0.20, INF, 0.285646), (180, 0.20, 0.7, 0.285646), (180, 0.20, 0.6, 0.285646),
    (180, 0.30, INF, 0.518602), (180, 0.30, 0.7, 0.456126), (180, 0.30, 0.6, 0.365081),
    (157.5, 0.15, INF, 0.356052), (157.5, 0.20, INF, 0.518652),
    (157.5, 0.25, INF, 0.675637), (157.5, 0.25, 0.7, 0.675637), (157.5, 0.25, 0.6, 0.575291),
]  # fmt: skip


@pytest.mark.parametrize(("embrace", "t", "mu", "exact"), ARCHES)
def test_arch_of_twenty_voussoirs_under_horizontal_load(embrace, t, mu, exact):
    result = limit_load(arch(20, t, embrace=math.radians(embrace)), (1, 0, 0), friction=mu)
    assert proven(result, exact, 1e-6)


def test_de_lorenzis_arch():
    result = limit_load(arch(7, 0.15, embrace=math.radians(157.5)), (1, 0, 0), friction=INF)
    assert proven(result, 0.373612, 1e-6)


@pytest.mark.parametrize(("block", "exact"), [(4, 3.018464), (9, 0.422907)])
def test_point_load_on_a_voussoir(block, exact):
    asm = arch(20, 0.2)
    angle = math.pi - math.pi * (block + 0.5) / 20
    corners = asm.block_vertices(asm.names.index(f"voussoir{block}"))
    outer = corners[np.linalg.norm(corners[:, [0, 2]], axis=1) > 1.0].mean(axis=0)
    assert math.atan2(outer[2], outer[0]) == pytest.approx(angle)
    weight = asm.mass[asm.free].sum()
    load = point_load(asm, f"voussoir{block}", outer, (0, 0, -weight))
    assert proven(limit_load(asm, load, friction=INF), exact, 1e-6)


@pytest.mark.parametrize(("n", "t", "degrees"), [(100, 0.20, 15.8444), (20, 0.20, 15.9418), (36, 0.15, 8.2464)])
def test_tilted_semicircle(n, t, degrees):
    found = tilt_limit(arch(n, t), "y", friction=INF)
    assert found.stands == pytest.approx(degrees, abs=5e-5)
    assert found.falls == pytest.approx(found.stands, rel=1e-6)


@pytest.mark.parametrize(
    ("t", "least", "greatest"), [(0.15, 0.175635, 0.227718), (0.2, 0.154245, 0.255311), (0.3, 0.118217, 0.299956)]
)
def test_thrust_of_a_semicircle(t, least, greatest):
    asm = arch(20, t)
    weight = asm.mass[asm.free].sum()
    found = thrust_range(asm, ["right"], (1, 0, 0), friction=INF)
    assert found.least / weight == pytest.approx(least, abs=1e-6)
    assert found.greatest / weight == pytest.approx(greatest, abs=1e-6)
    # A spreading support meets the least thrust, a closing one the greatest.
    assert settlement(asm, ["right"], (1, 0, 0)).reaction / weight == pytest.approx(least, abs=1e-6)
    assert -settlement(asm, ["right"], (-1, 0, 0)).reaction / weight == pytest.approx(greatest, abs=1e-6)


@pytest.mark.parametrize(("courses", "exact"), [(4, 0.552372), (8, 0.389499), (12, 0.277391)])
def test_facade_of_a_u_shaped_wall(courses, exact):
    blocks = [box((-2, -2, -1), (8, 7, 0), name="ground")]
    for z in range(courses):
        plans = (
            [((x, 0), (x + 2, 1)) for x in (0, 2, 4)] + [((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (1, 3)]
            if z % 2 == 0
            else [((x, 0), (x + 2, 1)) for x in (1, 3)]
            + [((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (0, 2)]
            + [((x, 4), (x + 1, 5)) for x in (0, 5)]
        )
        blocks += [box((*low, z), (*high, z + 1)) for low, high in plans]
    assert proven(limit_load(assembly(blocks), (0, -1, 0), friction=0.7), exact, 1e-6)


@pytest.mark.parametrize("n", [3, 8])
def test_facade_alone(n):
    blocks = [box((-2, -2, -1), (8, 7, 0))]
    for z in range(n):
        starts = (0, 2, 4) if z % 2 == 0 else (1, 3)
        blocks += [box((x, 0, z), (x + 2, 1, z + 1)) for x in starts]
        blocks += [box((x, 0, z), (x + 1, 1, z + 1)) for x in ((0, 5) if z % 2 else ())]
    assert proven(limit_load(assembly(blocks), (0, -1, 0), friction=0.7), 1 / n, 1e-8)


@pytest.mark.parametrize(("height", "width"), [(2.5, 0.67333), (5.0, 0.83754), (10.0, 0.95326)])
def test_barrel_on_free_standing_piers(height, width):
    # R = 2.5, t = .5, 20 voussoirs, mu = .7: the least pier width that stands.
    def standing(w):
        inner, outer = 2.25, 2.75
        angles = math.pi - np.linspace(0, math.pi, 21)
        blocks = [box((-9, 0, -1), (9, 1, 0), name="ground")]
        for side in (-1, 1):
            low, high = sorted((side * inner, side * (inner + w)))
            blocks.append(box((low, 0, 0), (high, 1, height), name=f"pier{side}"))
        for a, b in zip(angles[:-1], angles[1:], strict=True):
            ring = [
                (r * math.cos(t), r * math.sin(t) + height) for t, r in ((a, outer), (a, inner), (b, inner), (b, outer))
            ]
            blocks.append(hexahedron([(x, 1, z) for x, z in ring], [(x, 0, z) for x, z in ring]))
        return limit_load(assembly(blocks, friction=0.7), (1, 0, 0)).outcome is LoadOutcome.LIMIT

    assert standing(width + 1e-4)
    assert not standing(width - 1e-4)


def test_least_friction():
    # REFERENCES: 27 voussoirs need t/R = .140891 at mu = .36 and .121124 at mu = .38.
    assert friction_limit(arch(27, 0.140891)).stands == pytest.approx(0.36, abs=2e-6)
    assert friction_limit(arch(27, 0.121124)).stands == pytest.approx(0.38, abs=2e-6)
    assert friction_limit(stack(1), gravity=(0.3, 0, -1)).stands == pytest.approx(0.3, abs=2e-6)
    assert math.isnan(friction_limit(stack(1)).falls)
    assert math.isnan(friction_limit(arch(10, 0.05)).stands)


def test_results_that_are_no_number():
    assert limit_load(stack(3), (0, 0, -1)).outcome is LoadOutcome.UNBOUNDED
    assert limit_load(arch(20, 0.1), (1, 0, 0)).outcome is LoadOutcome.DEAD_LOAD_UNSTABLE
    floating = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 3), (1, 1, 4))])
    assert limit_load(floating, (1, 0, 0)).outcome is LoadOutcome.DEAD_LOAD_UNSTABLE


def test_the_joints_of_a_mechanism_are_named():
    four = limit_load(arch(20, 0.15), (1, 0, 0)).joints()
    assert (len(four["hinges"]), len(four["sliding"]), len(four["opening"])) == (4, 0, 0)
    slide = limit_load(stack(1, 2.0, 0.5), (1, 0, 0)).joints()
    assert slide == {"hinges": [], "sliding": [("ground", "stone0")], "opening": []}
    tip = limit_load(stack(2, 0.5, 1.0), (1, 0, 0)).joints()
    assert tip["hinges"] == [("ground", "stone0")]


def test_domain_of_two_horizontal_loads_on_a_block():
    # A square block under loads x and y tips at |x| or |y| = b/h; friction .7 cuts the corners of the square.
    found = load_domain(stack(1, 1.0, 2.0), (1, 0, 0), (0, 1, 0), directions=16)
    size = np.linalg.norm(found.inner, axis=1)
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    exact = np.minimum(0.7, 0.5 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle))))
    np.testing.assert_allclose(size, exact, rtol=1e-7)
    for a, b, c in found.outer:
        assert (found.inner @ [a, b] <= c * (1 + 1e-7)).all()


def test_a_wall_in_two_directions_and_mirrored_is_the_same():
    wall = running_bond(6, 5)
    east, west = (limit_load(wall, (sign, 0, 0)) for sign in (1, -1))
    assert east.lower == pytest.approx(west.lower, rel=1e-8)
