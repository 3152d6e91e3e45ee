"""A second opinion on sequences: states, orders, courses, the least forces of props, and how a centring comes free.

The least forces of props lie between two linear programs, with polygons inside and outside the cones of friction.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_array, hstack, vstack

import blockstat
from evidence.checks import independent
from evidence.checks.strength import strengths, taken_up
from evidence.opinion import polygons

EXACT = 1e-5  #: relative, between the least forces and their bound
SPARE = 1e-5  #: relative, of programs solved to a tolerance
JUDGED = 10  #: steps of a plan, about
LACK = 1e-5  #: of the mean weight, what given forces of props may leave unbalanced


class Site:
    """A state of an assembly: what is there, what is free, the contacts between them, and its props."""

    def __init__(self, asm, state, props, *, friction=None, faces=None, gap=independent.GAP):
        self.asm = asm if friction is None else asm.with_(friction=friction)
        present, held = ([asm.names.index(name) for name in names] for names in state)
        there = asm.support.copy()
        there[present] = True
        self.free = np.flatnonzero(there & ~asm.support & ~np.isin(np.arange(asm.n_blocks), held))
        faces = blockstat.find_interfaces(self.asm, gap=gap) if faces is None else faces
        rows = there[faces.pair].all(axis=1) & np.isin(faces.pair, self.free).any(axis=1)
        self.faces = faces.subset(rows)
        mass, self.centroid = independent.bodies(self.asm)
        self.size = np.cbrt(mass / self.asm.density)
        self.weight = mass[:, None] * self.asm.gravity
        self.unit = float(np.linalg.norm(self.weight[self.free], axis=1).mean()) if len(self.free) else 1.0
        k = self.faces.point_interface
        place, block = self.faces.point, self.faces.pair[k]
        self.matrix = polygons.columns(place, self.faces.frame[k], block, self.free, self.centroid, self.size)
        self.block = np.array([asm.names.index(prop.block) for prop in props], dtype=int)
        self.foot = np.array([prop.point for prop in props], dtype=float).reshape(-1, 3)
        way = np.array([prop.direction for prop in props], dtype=float).reshape(-1, 3)
        self.way = way / np.linalg.norm(way, axis=1)[:, None]
        arm = (self.foot - self.centroid[self.block]) / self.size[self.block][:, None]
        pushes = np.zeros((len(props), self.asm.n_blocks, 6))
        pushes[np.arange(len(props)), self.block] = np.hstack([self.way, np.cross(arm, self.way)])
        self.pushes = csc_array(pushes[:, self.free].reshape(len(props), 6 * len(self.free)).T)
        load = np.zeros((len(self.free), 6))
        load[:, :3] = self.weight[self.free] / self.unit
        self.load = load.reshape(-1)

    def least(self, what, *, inside):
        """The least total or peak of the props [N], with polygons inside or outside the cones; inf where none hold."""
        m, n = self.faces.n_points, len(self.way)
        peak = int(what == "peak")
        cone = polygons.cones(strengths(self.asm, self.faces).mu, inside=inside)
        equal = hstack([self.matrix, self.pushes, csc_array((len(self.load), peak))]).tocsc()
        upper = [hstack([cone, csc_array((cone.shape[0], n + peak))])]
        if peak:
            eye = csc_array(np.eye(n))
            upper.append(hstack([csc_array((n, 3 * m)), eye, csc_array(-np.ones((n, 1)))]))
        upper = vstack(upper).tocsc()
        cost = np.concatenate([np.zeros(3 * m), np.full(n, 1.0 - peak), np.ones(peak)])
        limits = [*polygons.bounds(m), *[(0, None)] * (n + peak)]
        answer = linprog(cost, upper, np.zeros(upper.shape[0]), equal, -self.load, limits, method="highs")
        return float(answer.fun) * self.unit if answer.status == 0 else np.inf

    def lack(self, force):
        """The least that contact forces with these forces of the props leave unbalanced, in mean weights."""
        cone = polygons.cones(strengths(self.asm, self.faces).mu, inside=False)
        given = self.load + self.pushes @ (force / self.unit)
        one = csc_array(np.ones((len(given), 1)))
        upper = vstack([hstack([self.matrix, -one]), hstack([-self.matrix, -one]),
                        hstack([cone, csc_array((cone.shape[0], 1))])]).tocsc()  # fmt: skip
        bound = np.concatenate([-given, given, np.zeros(cone.shape[0])])
        cost = np.append(np.zeros(self.matrix.shape[1]), 1.0)
        limits = [*polygons.bounds(self.faces.n_points), (0, None)]
        return float(linprog(cost, upper, bound, bounds=limits, method="highs").fun)


def check_falsework(found, asm, state, props, *, friction=None, faces=None, gap=independent.GAP):
    """Raise AssertionError unless the props hold the state, and no smaller forces of theirs do."""
    assert found.props == tuple(props), "other props"
    site = Site(asm, state, props, friction=friction, faces=faces, gap=gap)
    if not len(site.free):
        return
    if found.outcome.word == "undecided":
        return
    if found.outcome.word == "not_held":
        assert not np.isfinite(site.least(found.least, inside=True)), "forces in the props hold the state"
        return
    assert (found.force >= 0).all(), "a prop pulls"
    value = found.total if found.least == "total" else found.peak
    scale = EXACT * max(value, site.unit)
    assert abs(value - found.bound) <= scale, "the bound is another"
    assert value <= site.least(found.least, inside=True) * (1 + SPARE) + scale, "smaller forces hold the state"
    assert value >= site.least(found.least, inside=False) * (1 - SPARE) - scale, "such small forces do not hold it"
    assert site.lack(found.force) <= LACK, "the props do not hold the state with these forces"


def check_decentring(found, asm, state, props, *, friction=None, faces=None, gap=independent.GAP):
    """Raise AssertionError unless blocks follow a centring as joints and props allow, and do the work of its forces.

    Of all motions that joints and props allow it is the one of the greatest work, which is that of the least forces.
    """
    check_falsework(found.falsework, asm, state, props, friction=friction, faces=faces, gap=gap)
    site = Site(asm, state, props, friction=friction, faces=faces, gap=gap)
    motion, low = found.displacement, found.lowering
    fixed = np.setdiff1d(np.arange(asm.n_blocks), site.free)
    assert not motion[fixed].any(), "a block moves that is held or absent"

    def moved(block, point):
        return motion[block, :3] + np.cross(motion[block, 3:], point - site.centroid[block])

    k = found.interfaces.point_interface
    one, two = (moved(found.interfaces.pair[k, side], found.interfaces.point) for side in (0, 1))
    rate = np.einsum("nij,nj->ni", found.interfaces.frame[k], two - one)
    _, closing = taken_up(strengths(site.asm, found.interfaces), rate)
    assert closing.max(initial=0.0) <= 1e-4 * low, "a joint closes"
    sunk = -(moved(site.block, site.foot) * site.way).sum(axis=1)
    assert sunk.max(initial=0.0) <= low * (1 + 1e-4), "a block sinks further than its prop"
    work = float((site.weight * motion[:, :3])[site.free].sum())
    assert abs(work - low * found.falsework.total) <= 1e-5 * low * site.unit * len(site.free), (
        "other work than the props'"
    )
    opening = np.zeros(found.interfaces.n_interfaces)
    np.maximum.at(opening, k, rate[:, 0])
    assert np.abs(opening - found.opening).max(initial=0.0) <= 1e-6 * low, "a joint opens by another amount"
    least = np.full(found.interfaces.n_interfaces, np.inf)
    np.minimum.at(least, k, rate[:, 0])
    hinges = np.flatnonzero((opening > 1e-4 * low) & (least <= 1e-4 * low))
    assert np.array_equal(hinges, found.hinges), "other joints hinge"


def check_states(verdicts, *, gap=independent.GAP):
    """Raise AssertionError unless the evidence of each verdict supports it."""
    for verdict in verdicts:
        independent.check_verdict(verdict, gap=gap)


def check_order(found, asm, *, held_at_most, groups=(), friction=None, flow="associated", gap=independent.GAP):
    """Raise AssertionError unless steps of the plan are proven to stand with no more hands; a group takes one.

    Of long plans every so many steps are judged, and the last.
    """
    if found.plan is None:
        return
    group = {name: k for k, names in enumerate(groups) for name in names}
    there, states = [], []
    for step in found.plan.steps:
        there += step.install
        assert len({group.get(name, name) for name in step.hold}) <= held_at_most, "more blocks are held"
        states.append((tuple(there), step.hold))
    assert sorted(there) == sorted(asm.names[k] for k in asm.free), "other blocks are installed"
    _check_stands(asm, states, friction=friction, flow=flow, gap=gap)


def _check_stands(asm, states, **options):
    chosen = [*states[: -1 : -(-len(states) // JUDGED)], states[-1]]
    for verdict in blockstat.assess_states(asm, chosen, score=False, **options):
        assert verdict.outcome.word == "stable", "a state falls"


def check_safest(found, asm, *, held_at_most, groups=(), friction=None, gap=independent.GAP):
    """Raise AssertionError unless the plan stands at the friction that is said, and the finished assembly needs it."""
    if found.least_friction is None or found.found.plan is None:
        return
    falls, stands = found.least_friction
    own = asm.friction if friction is None else friction
    assert found.friction == own
    assert falls <= stands <= own * (1 + 1e-12)
    check_order(found.found, asm, held_at_most=held_at_most, groups=groups, friction=stands, gap=gap)


def check_courses(found, asm, *, friction=None, gap=independent.GAP):
    """Raise AssertionError unless the blocks that are held after each course hold it, and are as many as is said."""
    there, states = [], []
    for course in found.courses:
        there += course.blocks
        assert len(course.held) >= course.at_least, "fewer blocks are held than at least needed"
        states.append((tuple(there), course.held))
    if found.outcome.word == "built":
        assert sorted(there) == sorted(asm.names[k] for k in asm.free), "other blocks are installed"
        _check_stands(asm, states, friction=friction, gap=gap)


def install():
    """Put the checks of this module behind the functions, as `evidence.checks.independent.install` does."""
    independent.install_all(
        {
            "falsework": lambda found, given: check_falsework(found, *_site(given), **_options(given, faces=True)),
            "decentring": lambda found, given: check_decentring(found, *_site(given), **_options(given, faces=True)),
            "assess_states": lambda found, given: check_states(found, gap=_gap(given)),
            "remove_each": lambda found, given: check_states(found.values(), gap=_gap(given)),
            "find_order": lambda found, given: check_order(
                found, given["assembly"], held_at_most=given["held_at_most"], **_options(given, "groups", "flow")
            ),
            "safest_order": lambda found, given: check_safest(
                found, given["assembly"], held_at_most=given["held_at_most"], **_options(given, "groups")
            ),
            "build_by_courses": lambda found, given: check_courses(found, given["assembly"], **_options(given)),
        }
    )


def _site(given):
    return given["assembly"], given["state"], given["props"]


def _gap(given):
    return given.get("gap", independent.GAP) if given.get("interfaces") is None else None


def _options(given, *names, faces=False):
    options = {name: given[name] for name in ("friction", "gap", *names) if given.get(name) is not None}
    return options | ({"faces": given.get("interfaces")} if faces else {})
