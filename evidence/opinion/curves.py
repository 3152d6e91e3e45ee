"""A second opinion on capacity curves and on settlements to collapse: power, work and balance at each pose.

Poses are taken from the answer. Where points have gone, what the weights do on the way, which joints are open and
whether forces balance there are computed from the corners of the blocks and of their first joints. Shares no code with
`blockstat.large_displacement`.

Forces that do not rub do no work. So at each point of a curve the multiplier is the ratio of two powers, and on a path
the weights lose as much energy as the supports take up. Joints that slide take more, which bounds both from one side.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_array, hstack, vstack

from evidence.checks import independent
from evidence.opinion import polygons

SHUT = 1e-6  #: of the largest block, how far points that touch may be apart
POWER = 1e-6  #: relative, of a multiplier by power
STEP = 1e-2  #: of what moves in a step, how far the mean of the rates at its ends may lead elsewhere
PLACE = 1e-5  #: of the greatest displacement, how exactly the changes of a mechanism are placed
OPEN = 1e-2  #: relative, of an opening: of the normals that turn with either block
WORK = 1e-3  #: of the work in a step, by the rule of trapezia
BALANCE = 1e-6  #: of the mean weight, what contact forces at a pose may lack
NEAR = 0.02  #: of a block, corners nearer than this to the plane of a joint are drawn to lie in it
OFF = 4.0  #: times the distance of such corners from it, how far points that touch may be apart


class Pair:
    """The material points of the first joints, which lie together at rest, as seen from both blocks."""

    def __init__(self, asm, faces):
        self.asm, self.faces = asm, faces
        self.mass, self.centroid = independent.bodies(asm)
        self.joint = faces.point_interface
        self.block = faces.pair[self.joint]
        self.size = np.cbrt(self.mass / asm.density)
        self.shut = SHUT * self.size.max() + OFF * self._off()

    def _off(self):
        """The largest distance of corners from the plane of their joint, where they are drawn to lie in it."""
        off = 0.0
        for k, pair in enumerate(self.faces.pair):
            place, normal = self.faces.point[self.joint == k].mean(axis=0), self.faces.frame[k, 0]
            near = NEAR * self.size[pair].min()
            for block in pair:
                away = np.abs((self.asm.block_vertices(int(block)) - place) @ normal)
                off = max(off, away[away < near].max(initial=0.0))
        return off

    def places(self, pose):
        """Where the points of both blocks are, shape (2, n, 3)."""
        return np.stack([self.moved(pose, self.block[:, side], self.faces.point) for side in (0, 1)])

    def moved(self, pose, block, point):
        """Where points of blocks have gone."""
        arm = point - self.centroid[block]
        return self.centroid[block] + pose.displacement[block] + np.einsum("nij,nj->ni", pose.rotation[block], arm)

    def velocity(self, pose, rate, block, place):
        """How fast places on displaced blocks move."""
        arm = place - self.centroid[block] - pose.displacement[block]
        return rate[block, :3] + np.cross(rate[block, 3:], arm)

    def normals(self, pose):
        """The normals of the joints as they turn with either block, shape (2, n, 3)."""
        normal = self.faces.frame[self.joint, 0]
        return np.stack([np.einsum("nij,nj->ni", pose.rotation[self.block[:, side]], normal) for side in (0, 1)])


def check_pose(pair, pose):
    """Raise AssertionError unless the blocks are turned without distortion and supports stay."""
    square = pose.rotation @ pose.rotation.swapaxes(1, 2)
    assert np.abs(square - np.eye(3)).max() < 1e-9, "a block is distorted"
    fixed = pair.asm.support
    assert not pose.displacement[fixed].any(), "a support has moved"
    assert np.abs(pose.rotation[fixed] - np.eye(3)).max(initial=0.0) < 1e-12, "a support has turned"


class Forces:
    """Forces that act at points of blocks and keep their direction, and constant moments."""

    def __init__(self, pair, given, *, live=False):
        asm = pair.asm
        self.pair, self.moment = pair, np.zeros((asm.n_blocks, 3))
        if isinstance(given, (tuple, list)) and isinstance(given[0], (tuple, list)) and len(given[0]) == 3:
            self.block = np.array([asm.names.index(b) if isinstance(b, str) else b for b, _, _ in given], dtype=int)
            self.point = np.array([point for _, point, _ in given], dtype=float)
            self.force = np.array([force for _, _, force in given], dtype=float)
            return
        if hasattr(given, "couple"):
            self.block, self.point, self.force, self.moment = given.block, given.point, given.force, given.couple
            return
        given = np.zeros((asm.n_blocks, 6)) if given is None else given
        wrench = independent.live_load(asm, given) if live else np.asarray(given, dtype=float)
        self.block = np.arange(asm.n_blocks)
        self.point, self.force, self.moment = pair.centroid, wrench[:, :3], wrench[:, 3:]

    def power(self, pose, rate):
        """Of the forces on a motion [W]."""
        place = self.pair.moved(pose, self.block, self.point)
        speed = self.pair.velocity(pose, rate, self.block, place)
        free = ~self.pair.asm.support
        return float((self.force * speed)[free[self.block]].sum() + (self.moment * rate[:, 3:])[free].sum())

    def potential(self, pose):
        """Work of the forces from rest to a pose [J]; moments are left out."""
        way = self.pair.moved(pose, self.block, self.point) - self.point
        return float((self.force * way)[~self.pair.asm.support[self.block]].sum())

    def wrench(self, pose):
        """On each block about its displaced centroid, shape (n_blocks, 6)."""
        asm, pair = self.pair.asm, self.pair
        found = np.zeros((asm.n_blocks, 6))
        found[:, 3:] = self.moment
        arm = pair.moved(pose, self.block, self.point) - (pair.centroid + pose.displacement)[self.block]
        np.add.at(found, self.block, np.hstack([self.force, np.cross(arm, self.force)]))
        return found


def weights(pair):
    """The weights as forces at centroids."""
    wrench = np.zeros((pair.asm.n_blocks, 6))
    wrench[:, :3] = pair.mass[:, None] * pair.asm.gravity
    return Forces(pair, wrench)


def touching(pair, pose, moved=0.0):
    """Which points lie together, and how far points of each joint are apart along its two normals, shape (2, n)."""
    ends = pair.places(pose)
    if np.ndim(moved):
        ends = ends + moved
    apart = ends[1] - ends[0]
    gap = np.einsum("snj,nj->sn", pair.normals(pose), apart)
    return np.linalg.norm(apart, axis=1) <= pair.shut, gap


def hinges_only(pair, pose, rate, together):
    """Whether every joint that is not open turns about points that stay together, and which; none of them closes."""
    place = pair.places(pose).mean(axis=0)
    one, two = (pair.velocity(pose, rate, pair.block[:, side], place) for side in (0, 1))
    speed = np.linalg.norm(two - one, axis=1)
    fastest = max(np.abs(rate[:, :3]).max(), np.abs(rate[:, 3:]).max() * pair.size.max())
    still = fastest * pair.shut / pair.size.max()
    pinned = together & (speed <= still)
    joints = np.unique(pair.joint[pinned])
    _, gap = touching(pair, pose)
    opening = np.einsum("nj,nj->n", pair.normals(pose).mean(axis=0), two - one)
    assert (opening >= -still)[together].all(), "a joint closes"
    open_ = (gap.min(axis=0) > pair.shut) | (together & (opening > still))
    shut = np.setdiff1d(np.unique(pair.joint[~open_]), joints)
    return not len(shut), pinned


def least_lack(pair, pose, wrench, points):
    """The least unbalanced force of forces at points that touch, within friction, in mean weights."""
    asm, faces = pair.asm, pair.faces
    free = np.flatnonzero(~asm.support)
    place, normal = pair.places(pose).mean(axis=0)[points], pair.normals(pose).mean(axis=0)[points]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    one = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.6, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    one /= np.linalg.norm(one, axis=1)[:, None]
    frame = np.stack([normal, one, np.cross(normal, one)], axis=1)
    matrix = polygons.columns(place, frame, pair.block[points], free, pair.centroid + pose.displacement, pair.size)
    unit = asm.free_weight / len(free)
    load = wrench[free] / unit
    load[:, 3:] /= pair.size[free][:, None]
    inside = polygons.cones(independent.strengths(asm, faces).mu[points])
    lack = csc_array(np.ones((len(load.reshape(-1)), 1)))
    upper = vstack([hstack([matrix, -lack]), hstack([-matrix, -lack]),
                    hstack([inside, csc_array((inside.shape[0], 1))])])  # fmt: skip
    bound = np.concatenate([-load.reshape(-1), load.reshape(-1), np.zeros(inside.shape[0])])
    cost = np.append(np.zeros(matrix.shape[1]), 1.0)
    answer = linprog(cost, upper.tocsc(), bound, bounds=[*polygons.bounds(len(points)), (0, None)], method="highs")
    return float(answer.fun) if answer.status == 0 else np.inf


def check_capacity(found, load, *, loads=None, control=None, flow="coulomb", every=1):
    """Raise AssertionError unless each point of a curve follows from its pose and its mechanism.

    Forces are looked for at every `every`-th point where joints hinge. Where joints slide without opening they take
    power, and the multipliers are bounded from below only; they are not checked with joint laws, ties and finite steps.
    """
    pair = Pair(found.assembly, found.interfaces)
    dead, live = Forces(pair, loads), Forces(pair, load, live=True)
    weight = weights(pair)
    plain = not (pair.asm.joints or pair.asm.ties or any("finite steps" in text for text in found.warnings))
    plain = plain and not any("left out" in text for text in found.warnings)
    kinds = pair.faces.kinds.any()
    assert found.points[0].displacement == 0
    for k, point in enumerate(found.points):
        pose, rate = point.pose, point.mechanism
        check_pose(pair, pose)
        assert not rate[pair.asm.support].any(), "a support moves"
        assert point.lower <= point.upper + POWER * abs(point.upper), "the bounds cross"
        driven = live.power(pose, rate)
        assert driven > 0 or not plain, "the load does not drive the mechanism"
        least = -(weight.power(pose, rate) + dead.power(pose, rate)) / driven
        if not plain:
            continue
        scale = POWER * (abs(least) + found.points[0].upper)
        together, gap = touching(pair, pose)
        wrench = weight.wrench(pose) + dead.wrench(pose) + point.lower * live.wrench(pose)
        check_distances(pair, gap, () if flow == "associated" else unbalanced(pair.asm, wrench))
        hinged, pinned = hinges_only(pair, pose, rate, together)
        if not kinds and (hinged or flow == "associated"):
            if not k:  # the bounds at rest are those of the corners as drawn
                scale = max(scale, (1e-4 + 2 * pair.shut / pair.size.max()) * point.upper)
            assert abs(point.upper - least) <= scale
            assert abs(point.lower - least) <= scale
            if not k or flow == "associated":
                continue
            check_open(pair, pose, point.opened)
            if k % every == 0:
                lack = least_lack(pair, pose, wrench, np.flatnonzero(pinned))
                assert lack <= BALANCE, "no forces balance the blocks where they are"
        else:
            assert point.upper >= least - scale, "the weights resist by more than the load does"
    block, start, shares = control_points(pair, found, control, live)
    place = [(shares * (pair.moved(point.pose, block, start) - start)).sum() for point in found.points]
    scale = max(np.abs(found.displacement).max(), 1e-300)
    exact = 1e-6 * scale + (pair.shut - SHUT * pair.size.max())
    assert np.abs(place - found.displacement).max() <= exact, "the control is elsewhere"
    if plain:
        check_events(found.events, found.displacement, found.lower)
        for point in found.points:
            speed = pair.velocity(point.pose, point.mechanism, block, pair.moved(point.pose, block, start))
            assert abs((shares * speed).sum() - 1.0) <= 1e-6, "the control moves at another rate"
        for before, after in zip(found.points[:-1], found.points[1:], strict=True):
            if after.displacement - before.displacement > PLACE * scale:  # no jump, and no change of the mechanism
                check_step(pair, before, after)


def unbalanced(asm, wrench):
    """Free blocks whose loads do not balance by themselves: they cannot hang in the air."""
    free = np.flatnonzero(~asm.support)
    unit = asm.free_weight / len(free)
    force, moment = (np.abs(wrench[free, part]).max(axis=1) for part in (slice(3), slice(3, 6)))
    return free[(force > BALANCE * unit) | (moment > BALANCE * unit * asm.size[free])]


def check_distances(pair, gap, held=()):
    """Raise AssertionError if a block penetrates another one, or one of those that must be held touches none."""
    room = 10 * pair.shut
    assert (gap.max(axis=0) >= -room).all(), "a block penetrates another one"
    assert np.isin(held, pair.block[gap.min(axis=0) <= room]).all(), "a block touches nothing"


def check_events(events, there, value):
    """Raise AssertionError unless the values before and after each change are values of the curve there."""
    for event in events:
        here = value[np.abs(there - event.parameter) <= PLACE * np.abs(there).max()]
        for told in (event.before, event.after if event.after != np.inf else None):
            assert told is None or np.isclose(here, told, rtol=PLACE, atol=PLACE * np.abs(value).max()).any()


def check_open(pair, pose, opened):
    """Raise AssertionError unless the joints that are open somewhere are those that are said to be."""
    _, gap = touching(pair, pose)
    limits = 10 * pair.shut, SHUT / 1e3 * pair.size.max()
    wide, any_ = (np.unique(pair.joint[gap.max(axis=0) > least]) for least in limits)
    assert np.isin(wide, opened).all(), "a joint is open"
    assert np.isin(opened, any_).all(), "a joint is shut"


def check_step(pair, before, after):
    """Raise AssertionError unless the mean of two rates leads from one pose to the next."""
    step = after.displacement - before.displacement
    way = after.pose.displacement - before.pose.displacement
    mean = (before.mechanism[:, :3] + after.mechanism[:, :3]) / 2 * step
    turn = after.pose.rotation @ before.pose.rotation.swapaxes(1, 2)
    spin = (
        np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], 1) / 2
    )
    turned = (before.mechanism[:, 3:] + after.mechanism[:, 3:]) / 2 * step
    size = max(np.abs(mean).max(), np.abs(turned).max() * pair.size.max())
    assert np.abs(way - mean).max() <= STEP * size, "the rates do not lead from pose to pose"
    assert np.abs(spin - turned).max() * pair.size.max() <= STEP * size, "the rates do not turn the blocks so"


def control_points(pair, found, control, live):
    """Blocks and points whose displacements times the shares, shape (n, 3), are that of the control."""
    asm = pair.asm
    free = ~asm.support[live.block]
    total = live.force[free].sum(axis=0)
    along = total / np.linalg.norm(total) * (-1.0 if "against the load" in found.control else 1.0)
    if control == "mean":
        force = live.force[free]
        return live.block[free], live.point[free], force / np.linalg.norm(force, axis=1).sum()
    if control is None:
        block = asm.names.index(found.control.split('"')[1])
        written = [float(x) for x in found.control.split("(")[1].split(")")[0].split(",")]
        corners = asm.vertices[asm.vertex_block == block]
        return np.array([block]), corners[[np.linalg.norm(corners - written, axis=1).argmin()]], along[None]
    if isinstance(control, (tuple, list)):
        block = asm.names.index(control[0]) if isinstance(control[0], str) else control[0]
        return np.array([block]), np.array([control[1]], dtype=float), along[None]
    if isinstance(control, str) and control not in asm.names:
        own = [k for k, group in enumerate(asm.groups) if group == control or group.startswith(f"{control}.")]
    else:
        own = [asm.names.index(control) if isinstance(control, str) else control]
    return np.array(own), pair.centroid[own], np.outer(pair.mass[own] / pair.mass[own].sum(), along)


def check_path(found, *, loads=None):
    """Raise AssertionError unless joints are as open as the poses have them and the energy is accounted for.

    Contacts of finite steps are open by as much as the answer says; there, openings are not checked. The work of the
    weights from point to point is that of the assembly on the supports that move, and what joints that
    slide or have laws take up.
    """
    first = found.first
    pair = Pair(first.assembly, first.interfaces)
    weight, dead = weights(pair), Forces(pair, loads)
    drive = np.zeros((2, len(pair.joint), 3))
    for part in first.foundations:
        for side in (0, 1):
            own = np.isin(pair.joint, part.joints) & pair.asm.support[pair.block[:, side]]
            drive[side, own] = part.displacement / first.displacement
    stepped = any("finite steps" in text for text in found.warnings)
    assert (np.diff(found.displacement) >= 0).all()
    tied = [pair.asm.blocks_named(tie.between, tie.label) for tie in pair.asm.ties]  # these may hang in the air
    energy = []
    for there, opening, pose in zip(found.displacement, found.openings, found.poses, strict=True):
        check_pose(pair, pose)
        together, gap = touching(pair, pose, there * drive)
        if not stepped:
            check_distances(pair, gap, np.setdiff1d(np.flatnonzero(~pair.asm.support), tied))
        widest, least = np.full(len(opening), -np.inf), np.full(len(opening), np.inf)
        np.maximum.at(widest, pair.joint, gap.max(axis=0))
        np.minimum.at(least, pair.joint, gap.min(axis=0))
        # Points of faces that have slid on each other do not face each other any more.
        faced = (least > 10 * pair.shut) | np.isin(np.arange(len(opening)), pair.joint[together])
        off = np.abs(np.maximum(widest, 0.0) - opening)
        assert stepped or (off <= OPEN * opening + pair.shut)[faced].all(), "a joint is not so open"
        energy.append(weight.potential(pose) + dead.potential(pose))
    if not stepped:
        check_events(found.events, found.displacement, found.reaction)
    step = np.diff(found.displacement)
    done = step * (found.reaction[1:] + found.reaction[:-1]) / 2
    lost = np.diff(energy)
    plain = not (pair.asm.joints or pair.asm.ties or found.warnings) and not dead.moment.any()
    if plain:
        jumps = step <= PLACE * found.displacement[-1]
        spare = WORK * np.abs(found.reaction).max() * step
        assert (lost - done >= -spare)[~jumps].all(), "the supports take up more than the weights do"
        slides = _slides(pair, found, drive)
        assert (lost - done <= spare)[~jumps & ~slides].all(), "the weights do more than the supports take up"


def _slides(pair, found, drive):
    """In which steps a joint neither is open nor turns about points that stay together, shape (k - 1,)."""
    slides = []
    for there, pose in zip(found.displacement, found.poses, strict=True):
        together, gap = touching(pair, pose, there * drive)
        shut = np.unique(pair.joint[gap.min(axis=0) <= pair.shut])
        slides.append(len(np.setdiff1d(shut, pair.joint[together])) > 0)
    slides = np.array(slides, dtype=bool)
    return slides[1:] | slides[:-1]


def install():
    """Put the checks of this module behind the functions; forces are looked for at every tenth point."""
    independent.install_all(
        {
            "capacity": lambda found, given: check_capacity(
                found,
                given["load"],
                loads=given.get("loads"),
                control=given.get("control"),
                flow=given.get("flow", "coulomb"),
                every=10,
            ),
            "settle_to_collapse": lambda found, given: check_path(found, loads=given.get("loads")),
        }
    )
