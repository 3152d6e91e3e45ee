"""Arches in their plane by another formulation and another solver: the derived values of `evidence.references.arches`.

A chain of blocks is written from its joints alone, as Livesley (1978) has it: two corners a joint, Coulomb friction as
two inequalities, three equations a block; HiGHS solves it. Where a thickness is looked for, s is the pressure that
every corner can have at least, and the answer is where it comes down to 0. Nothing here is shared with the product.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq, linprog

from evidence.references.arches import PIERS, POINTED, POLY, PUSHED, SECTORS, SLIDING, THRUST

WIDE = math.radians(157.5)


@dataclass
class Chain:
    """Blocks in a row between two fixed ends."""

    joints: np.ndarray  #: two corners of each, the lower one first, from left to right, shape (n + 1, 2, 2)
    weight: np.ndarray  #: shape (n,)
    centroid: np.ndarray  #: shape (n, 2)


def polygon(corners):
    """Area and centroid."""
    x, z = np.transpose(corners)
    cross = x * np.roll(z, -1) - np.roll(x, -1) * z
    centre = [((p + np.roll(p, -1)) * cross).sum() / (3 * cross.sum()) for p in (x, z)]
    return abs(cross.sum()) / 2, centre


def voussoirs(joints):
    """Straight-sided blocks between joints."""
    joints = np.asarray(joints, dtype=float)
    parts = [polygon([*a, *b[::-1]]) for a, b in zip(joints[:-1], joints[1:], strict=True)]
    return Chain(joints, np.array([area for area, _ in parts]), np.array([centre for _, centre in parts]))


def arch(n, thickness, *, embrace=math.pi, radius=1.0):
    angles = math.pi / 2 + embrace / 2 - np.linspace(0, embrace, n + 1)
    radii = np.array([radius - thickness / 2, radius + thickness / 2])
    return voussoirs(np.stack([np.outer(np.cos(angles), radii), np.outer(np.sin(angles), radii)], axis=2))


def sectors(n, thickness, *, embrace=math.pi, lune=False):
    """An arch with the weights of annular sectors, or of the slices of a lune of a dome, by numerical integration."""
    chain = arch(n, thickness, embrace=embrace)
    angles = math.pi / 2 + embrace / 2 - np.linspace(0, embrace, n + 1)
    point, share = np.polynomial.legendre.leggauss(20)
    for k, (a, b) in enumerate(zip(angles[:-1], angles[1:], strict=True)):
        angle = ((a + b) / 2 + (a - b) / 2 * point)[:, None]
        r = 1 + thickness / 2 * point[None, :]
        density = np.outer(share, share) * r * (r * abs(np.cos(angle)) if lune else 1.0) * (a - b) * thickness / 4
        chain.weight[k] = density.sum()
        chain.centroid[k] = [(density * r * f(angle)).sum() / density.sum() for f in (np.cos, np.sin)]
    return chain


def pointed(n, eccentricity, thickness):
    """Two arcs of radius 1 with their centres at +-eccentricity, n voussoirs each, cut upright at the crown."""
    radii = np.array([1 - thickness / 2, 1 + thickness / 2])
    angles = np.linspace(0, math.acos(eccentricity), n + 1)[:-1]
    left = np.stack([eccentricity - np.outer(np.cos(angles), radii), np.outer(np.sin(angles), radii)], axis=2)
    crown = np.stack([0 * radii, np.sqrt(radii**2 - eccentricity**2)], axis=1)
    return voussoirs([*left, crown, *(left * (-1, 1))[::-1]])


def on_piers(width, height, *, radius=2.5, thickness=0.5, n=20):
    """A barrel on two piers, whose inner faces go on from the intrados."""
    barrel = arch(n, thickness, radius=radius)
    barrel.joints[..., 1] += height
    barrel.centroid[:, 1] += height
    inner, middle = radius - thickness / 2, radius - thickness / 2 + width / 2
    feet = [[[side * inner, 0.0], [side * (inner + width), 0.0]] for side in (-1, 1)]
    return Chain(
        np.array([feet[0], *barrel.joints, feet[1]]),
        np.array([width * height, *barrel.weight, width * height]),
        np.array([[-middle, height / 2], *barrel.centroid, [middle, height / 2]]),
    )


def solve(chain, mu, *, load=None, goal=None):
    """Greatest multiplier of a load, wrenches of shape (n, 3); or greatest sum of `goal`, shape (4,), times the normal
    and shear at the two corners of the last joint; with neither, greatest pressure s that all corners can have."""
    n = len(chain.weight)
    along = chain.joints[:, 1] - chain.joints[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    size = 4 * (n + 1) + 1
    balance = np.zeros((n, 3, size))
    cone = []
    for j, corners in enumerate(chain.joints):
        for c, corner in enumerate(corners):
            column = 4 * j + 2 * c
            pressed = np.zeros(size)
            pressed[column] = -1.0
            if load is None and goal is None:
                pressed[-1] = 1.0
            cone.append(pressed)
            for sign in (-1, 1) if math.isfinite(mu) else ():
                slides = mu * pressed
                slides[column + 1] = sign
                cone.append(slides)
            for block, side in ((j, 1), (j - 1, -1)):
                if 0 <= block < n:
                    x, z = corner - chain.centroid[block]
                    for k, (fx, fz) in enumerate((normal[j], (-normal[j][1], normal[j][0]))):
                        balance[block, :, column + k] = side * fx, side * fz, side * (x * fz - z * fx)
    cost = np.zeros(size)
    cost[-1] = -1.0
    if load is not None:
        balance[:, :, -1] = load
    if goal is not None:
        cost[-1] = 0.0
        cost[-5:-1] = -np.asarray(goal)
    down = np.zeros((n, 3))
    down[:, 1] = chain.weight
    found = linprog(
        cost, np.array(cone), np.zeros(len(cone)), balance.reshape(-1, size), down.reshape(-1), (None, None),
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )  # fmt: skip
    assert found.status == 0, found.message
    return -found.fun


def sideways(chain):
    return np.outer(chain.weight, (1.0, 0.0, 0.0))


def unit(text):
    """Of the last digit of a printed number."""
    return 10.0 ** -len(text.partition(".")[2]) * (1 + 1e-6)


def agrees(make, text, mu=math.inf):
    """The least size at which every corner can be pressed is the printed one."""
    value = float(text)
    found = brentq(lambda size: solve(make(size), mu), 0.97 * value, 1.03 * value, xtol=1e-9)
    assert found == pytest.approx(value, abs=unit(text))


@pytest.mark.parametrize("n", POLY)
def test_least_thickness(n):
    agrees(lambda t: arch(n, t), POLY[n])


@pytest.mark.parametrize("mu", SLIDING)
def test_least_thickness_of_27_voussoirs_that_slide(mu):
    agrees(lambda t: arch(27, t), SLIDING[mu], mu)


def test_least_thickness_of_sectors():
    agrees(lambda t: sectors(SECTORS, t), ".1074780")


def test_least_thickness_of_a_lune():
    agrees(lambda t: sectors(120, t, lune=True), ".042813")


@pytest.mark.parametrize(("e", "n", "text"), [(e, n, text) for e, rows in POINTED.items() for n, text in rows.items()])
def test_least_thickness_of_pointed_arches(e, n, text):
    agrees(lambda t: pointed(n, e, t), text)


@pytest.mark.parametrize("height", PIERS)
def test_least_width_of_piers(height):
    agrees(lambda width: on_piers(width, height), PIERS[height], 0.7)


def test_least_friction():
    for text, chain in ((".395265", sectors(SECTORS, 0.1074780313)), (".309215", arch(88, 0.5))):
        mu = brentq(lambda mu, chain=chain: solve(chain, mu) + 1e-9, 0.3, 0.45, xtol=1e-9)
        assert mu == pytest.approx(float(text), abs=2 * unit(text))


@pytest.mark.parametrize(
    ("degrees", "t", "mu", "text"),
    [
        (degrees, t, mu, text)
        for degrees, rows in PUSHED.items()
        for t, texts in rows.items()
        for mu, text in zip((math.inf, 0.7, 0.6), texts, strict=True)
    ],
)
def test_push(degrees, t, mu, text):
    chain = arch(20, t, embrace=math.radians(degrees))
    assert solve(chain, mu, load=sideways(chain)) == pytest.approx(float(text), abs=unit(text))


@pytest.mark.parametrize(
    ("chain", "text"), [(arch(7, 0.15, embrace=WIDE), ".373612"), (sectors(7, 0.15, embrace=WIDE), ".370010")]
)
def test_push_of_seven_voussoirs(chain, text):
    assert solve(chain, math.inf, load=sideways(chain)) == pytest.approx(float(text), abs=unit(text))


@pytest.mark.parametrize(("n", "t", "text"), [(100, 0.2, "15.8444"), (20, 0.2, "15.9418"), (36, 0.15, "8.2464")])
def test_tilt(n, t, text):
    chain = arch(n, t)
    degrees = math.degrees(math.atan(solve(chain, math.inf, load=sideways(chain))))
    assert degrees == pytest.approx(float(text), abs=unit(text))


@pytest.mark.parametrize("t", THRUST)
def test_thrust(t):
    chain = arch(20, t)
    shear = np.array([0.0, 1.0, 0.0, 1.0])  # of the last joint, which lies flat
    found = -solve(chain, math.inf, goal=-shear), solve(chain, math.inf, goal=shear)
    for value, text in zip(found, THRUST[t], strict=True):
        assert value / chain.weight.sum() == pytest.approx(float(text), abs=unit(text))


@pytest.mark.parametrize(("block", "text"), [(4, "3.018464"), (9, ".422907")])
def test_load_on_a_voussoir(block, text):
    chain = arch(20, 0.2)
    arm = chain.joints[block : block + 2, 1, 0].mean() - chain.centroid[block, 0]
    load = np.zeros((20, 3))
    load[block] = chain.weight.sum() * np.array([0.0, -1.0, -arm])
    assert solve(chain, math.inf, load=load) == pytest.approx(float(text), abs=unit(text))
