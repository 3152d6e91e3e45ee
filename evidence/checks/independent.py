"""An independent check of every answer: forces and mechanisms checked from first principles.

Shares no code with what it checks: of `blockstat` it takes the data (blocks, joints, joint laws) and nothing of the
matrices, programs, solvers or certificates. Masses and centroids are summed over tetrahedra, equilibrium block by
block, cones and velocities point by point. `install` puts it behind `assess`, `limit_load` and `thrust_range`, so that
a test that gets an answer at all gets one that has passed. Two claims come without evidence and are asked again
another way: an unbounded load, at a thousand times its size; and nothing is claimed by an undecided answer.
"""

from __future__ import annotations

import functools
import inspect
import sys

import numpy as np

import blockstat
from blockstat.contact.interfaces import GAP
from evidence.checks.coulomb import check_displacements
from evidence.checks.strength import (
    bonds_taken_up,
    check_bonds,
    check_points,
    constant_ties,
    strengths,
    taken_up,
    tie_ends,
    tie_wrenches,
    ties_taken_up,
)

FORCE = 1e-8  #: of a block's own load, what a balanced block may lack and a cone may miss
ROUNDING = 1e-12  #: of the forces that meet in a block
MANY_WEIGHTS = 1e6  #: no assembly stands by contact forces of so many weights
ADHESION = 1e-5  #: of the total load and adhesion; forces of an unstable assembly are the solver's own
TIGHT = 1e-7  #: by how much a bound may lie above what its mechanism proves, relative to the work of the loads
CROSSING = 3  #: the kind of a contact of two edges that cross
PARALLEL = np.cos(np.deg2rad(8.0))  # a joint lies halfway between its faces, which turn by 15 degrees at most


def following(start):
    """Of each corner in a list of faces, the next one round its face."""
    index = np.arange(1, start[-1] + 1)
    index[start[1:] - 1] = start[:-1]
    return index


def bodies(asm):
    """Mass and centroid of each block: tetrahedra on its first corner, faces split about the mean of their corners."""
    corners, count = asm.vertices[asm.face_vertices], np.diff(asm.face_start)
    block = np.repeat(asm.face_block, count)
    origin = asm.vertices[asm.vertex_start[:-1]]
    a = corners - origin[block]
    b = a[following(asm.face_start)]
    c = np.repeat(np.add.reduceat(a, asm.face_start[:-1]) / count[:, None], count, axis=0)
    volume = np.einsum("ij,ij->i", c, np.cross(a, b)) / 6
    total = np.bincount(block, volume, asm.n_blocks)
    first = np.stack([np.bincount(block, volume * (a + b + c)[:, i] / 4, asm.n_blocks) for i in range(3)], axis=1)
    return asm.density * total, origin + first / total[:, None]


def dead_load(asm, loads=None):
    """Weight, with the factor that loads may have, and further wrenches, shape (n_blocks, 6), and the centroids."""
    mass, centroid = bodies(asm)
    loads = at_rest(asm, loads)
    beside, factor = getattr(loads, "beside", loads), getattr(loads, "weight", 1.0)
    wrench = np.zeros((asm.n_blocks, 6)) if beside is None else np.array(beside, dtype=float)
    wrench[:, :3] += factor * mass[:, None] * asm.gravity
    return wrench, centroid


def at_rest(asm, load):
    """Wrenches of forces at their points, shape (n_blocks, 6); another load as it is."""
    if not hasattr(load, "couple"):
        return load
    wrench = np.zeros((asm.n_blocks, 6))
    wrench[:, 3:] = load.couple
    arm = load.point - bodies(asm)[1][load.block]
    np.add.at(wrench, load.block, np.hstack([load.force, np.cross(arm, load.force)]))
    return wrench


def live_load(asm, load):
    load = np.asarray(at_rest(asm, load), dtype=float)
    if load.shape != (3,):
        return load
    load = load / np.abs(load).max()
    wrench = np.zeros((asm.n_blocks, 6))
    wrench[:, :3] = np.outer(bodies(asm)[0], load) * np.linalg.norm(asm.gravity) / np.linalg.norm(load)
    return wrench


def check_joints(asm, faces, gap: float | str | None = GAP):
    """Every contact point lies where its kind says, and the normal leads from the first block to the second.

    A point of a patch lies on a face of either block. In assemblies with edges and corners it may be one of those too,
    and lies on a face of one. A crossing lies on an edge of either block, at right angles to the normal.
    """
    square = faces.frame @ faces.frame.swapaxes(1, 2)
    assert np.abs(square - np.eye(3)).max(initial=0.0) < 1e-9
    if gap is None:  # the joints were given, and are what they are said to be
        return
    size = np.cbrt(bodies(asm)[0] / asm.density)
    corners = asm.vertices[asm.face_vertices]
    start = corners[np.repeat(asm.face_start[:-1], np.diff(asm.face_start))]
    normal = np.add.reduceat(np.cross(corners - start, corners[following(asm.face_start)] - start), asm.face_start[:-1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]  # some faces have no area
    centre = np.add.reduceat(corners, asm.face_start[:-1]) / np.diff(asm.face_start)[:, None]
    first = np.searchsorted(asm.face_block, np.arange(asm.n_blocks + 1))
    k = faces.point_interface
    if isinstance(gap, str):  # a length; faces that are flat to a quarter of it are one face, on both sides
        allowed = np.full(len(k), 1.5 * float(gap.split()[0]) * {"m": 1.0, "mm": 1e-3}[gap.split()[1]])
    else:
        allowed = gap * size[faces.pair].min(axis=1)[k]
    kind = np.zeros(len(faces.pair), int) if faces.kind is None else faces.kind
    on_face = np.zeros((2, len(k)), bool)
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = faces.pair[k, side]
        count = np.diff(first)[block]
        point = np.repeat(np.arange(len(k)), count)
        face = first[block][point] + np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
        facing = sign * np.einsum("ij,ij->i", normal[face], faces.frame[k[point], 0]) > PARALLEL
        height = np.abs(np.einsum("ij,ij->i", faces.point[point] - centre[face], normal[face]))
        touches = facing & (height <= allowed[point] + 1e-14 * np.abs(faces.point[point]).max(axis=1))
        on_face[side] = np.logical_or.reduceat(touches, np.cumsum(count) - count)
    needed = on_face.all(axis=0) if not kind.any() else on_face.any(axis=0)
    assert needed[kind[k] != CROSSING].all(), "a contact point lies on no face"
    for i in np.flatnonzero(kind[k] == CROSSING):
        for block in faces.pair[k[i]]:
            assert crosses(asm, block, faces.point[i], faces.frame[k[i], 0], allowed[i]), "no edge at a crossing"


def crosses(asm, block, point, normal, allowed):
    """Whether an edge of a block passes through a point at right angles to a normal."""
    first, last = np.searchsorted(asm.face_block, [block, block + 1])
    own = slice(asm.face_start[first], asm.face_start[last])
    tail = asm.vertices[asm.face_vertices[own]]
    along = asm.vertices[asm.face_vertices[following(asm.face_start)][own]] - tail
    length = np.linalg.norm(along, axis=1)
    share = np.clip(((point - tail) * along).sum(axis=1) / length**2, 0.0, 1.0)
    near = np.linalg.norm(tail + share[:, None] * along - point, axis=1) <= allowed
    return bool((near & (np.abs(along @ normal) <= 1e-6 * length)).any())


def imbalance(asm, faces, wrench, centroid, forces, bonds=()):
    """Force and moment / size left over on each block, its own load in the same terms, and the forces it meets."""
    k = faces.point_interface
    push = np.einsum("nij,ni->nj", faces.frame[k], forces)
    left, met = wrench.copy(), np.zeros(asm.n_blocks)
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = faces.pair[k, side]
        np.add.at(left[:, :3], block, sign * push)
        np.add.at(left[:, 3:], block, sign * np.cross(faces.point - centroid[block], push))
        np.add.at(met, block, np.linalg.norm(push, axis=1))
    for i, centre, pull, turn in bonds:
        for block, sign in zip(faces.pair[i], (-1.0, 1.0), strict=True):
            left[block, :3] += sign * pull
            left[block, 3:] += sign * (np.cross(centre - centroid[block], pull) + turn)
            met[block] += np.linalg.norm(pull)
    unit = np.repeat([np.ones(asm.n_blocks), np.cbrt(bodies(asm)[0] / asm.density)], 3, axis=0).T
    left, own = (np.linalg.norm(values / unit, axis=1) for values in (left, wrench))
    return np.where(asm.support, 0.0, left), own, met


def check_forces(asm, faces, wrench, centroid, forces, bonds=None, live=0.0, ties=None):
    """Contact forces, bonds and ties balance dead and live load on every free block within their strengths."""
    dead, wrench = wrench, wrench + live
    weight = np.linalg.norm(wrench[~asm.support, :3], axis=1)
    spare = FORCE * weight.max(initial=0.0)
    glue = check_bonds(asm, faces, bonds, spare)
    tied = tie_wrenches(asm, centroid, ties, spare)
    left, _, met = imbalance(asm, faces, wrench + tied, centroid, forces, glue)
    _, own, _ = imbalance(asm, faces, wrench, centroid, forces)
    met = met + np.linalg.norm(tied[:, :3], axis=1)
    # Where the two loads cancel, each by itself says what is small.
    own = np.maximum(own, np.linalg.norm(dead[:, :3], axis=1))
    allowed = FORCE * own + ROUNDING * met
    assert (left <= allowed).all(), "a block is not balanced"
    spare = np.where(asm.support, np.inf, allowed)[faces.pair].min(axis=1)[faces.point_interface]
    check_points(strengths(asm, faces), forces, spare)


def check_motion(asm, faces, wrench, centroid, motion):
    """Work of loads (less what bonds take) and the largest rate at which a joint closes, rounding taken off."""
    assert not motion[asm.support].any(), "a support moves"
    k = faces.point_interface
    rate, size = np.zeros((len(k), 3)), np.zeros(len(k))
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = faces.pair[k, side]
        arm = faces.point - centroid[block]
        rate += sign * (motion[block, :3] + np.cross(motion[block, 3:], arm))
        reach = np.linalg.norm(arm, axis=1) + np.linalg.norm(faces.point, axis=1)
        size += np.linalg.norm(motion[block, :3], axis=1) + np.linalg.norm(motion[block, 3:], axis=1) * reach
    rate = np.einsum("nij,nj->ni", faces.frame[k], rate)
    strength = strengths(asm, faces)
    power, closing = taken_up(strength, rate)
    rounding = 1e-15 * (1 + np.where(np.isinf(strength.mu), 1.0, strength.mu)) * size
    closing = np.maximum(closing - rounding, 0.0).max(initial=0.0)
    tied, given = ties_taken_up(asm, centroid, motion)
    work = (wrench * motion).sum() - power.sum() - bonds_taken_up(asm, faces, centroid, motion) - tied
    return work, max(closing, given)


def assert_falls(asm, faces, wrench, centroid, motion):
    """The loads drive the motion, and no contact forces of a sensible size could resist it."""
    work, closing = check_motion(asm, faces, wrench, centroid, motion)
    total = np.linalg.norm(wrench[~asm.support, :3], axis=1).sum()
    assert work > 0, "the loads do not drive the mechanism"
    assert work >= 0.99 * MANY_WEIGHTS * closing * total, "the mechanism drives a block into another"


def held_blocks(asm, faces):
    """Blocks that a chain of joints and ties connects to a support."""
    held = asm.support.copy()
    pairs = np.concatenate([faces.pair, np.array([b for _, b, *_ in tie_ends(asm, asm.centroid)], int).reshape(-1, 2)])
    while True:
        a, b = held[pairs].T
        reached = held.copy()
        reached[pairs[a, 1]] = True
        reached[pairs[b, 0]] = True
        if (reached == held).all():
            return held
        held = reached


def check_verdict(verdict, *, loads=None, gap=GAP):
    """Raise AssertionError unless the evidence of a verdict supports it."""
    asm, faces, outcome = verdict.assembly, verdict.interfaces, verdict.outcome.word
    wrench, centroid = dead_load(asm, loads)
    check_joints(asm, faces, gap)
    assert sorted(verdict.floating) == list(np.flatnonzero(~held_blocks(asm, faces)))
    if outcome.startswith("stable"):
        assert verdict.score == 0
        assert not verdict.adhesion.any()
        check_forces(asm, faces, wrench, centroid, verdict.forces, verdict.bonds, ties=verdict.ties)
        if verdict.displacement is not None:
            check_displacements(verdict)
        assert outcome != "stable" or verdict.coulomb is None or verdict.displacement is not None
    elif outcome == "unstable":
        assert_falls(asm, faces, wrench, centroid, verdict.mechanism)
        if np.isfinite(verdict.score):
            given = wrench + tie_wrenches(asm, centroid, constant_ties(asm), None)
            total = np.linalg.norm(given[~asm.support, :3], axis=1).sum()
            np.testing.assert_allclose(np.linalg.norm(verdict.adhesion), verdict.score * total, rtol=1e-9)
            pulled = verdict.forces - np.multiply.outer(verdict.adhesion, [1.0, 0, 0])
            glue = check_bonds(asm, faces, verdict.bonds, ADHESION * total)
            tied = tie_wrenches(asm, centroid, verdict.ties, ADHESION * total)
            left, _, _ = imbalance(asm, faces, wrench + tied, centroid, pulled, glue)
            assert left.max() <= ADHESION * (total + verdict.adhesion.sum()), (
                "the missing adhesion does not balance the blocks"
            )


def check_limit(found, load, *, loads=None, gap=GAP):
    """Raise AssertionError unless forces carry the lower bound and the mechanism proves the upper one."""
    asm, faces = found.assembly, found.interfaces
    wrench, centroid = dead_load(asm, loads)
    live = live_load(asm, load)
    check_joints(asm, faces, gap)
    if found.outcome.word == "dead_load_unstable":
        if held_blocks(asm, faces).all():
            assert_falls(asm, faces, wrench, centroid, found.mechanism)
        return
    assert not found.lower > found.upper * (1 + np.sign(found.upper) * 1e-9)
    if found.outcome.word == "unbounded":
        many = 1e3 * np.abs(wrench).sum() / np.abs(live[~asm.support]).sum()
        check_forces(asm, faces, wrench, centroid, found.forces, found.bonds, ties=found.ties)
        total = many * live + wrench - dead_load(asm)[0]
        more = blockstat.assess(asm, loads=total, interfaces=faces)
        assert more.outcome.word == "stable", "not even a thousand times the load is carried"
    elif np.isfinite(found.lower):
        check_forces(asm, faces, wrench, centroid, found.forces, found.bonds, found.lower * live, found.ties)
    if np.isfinite(found.upper):
        work, closing = check_motion(asm, faces, wrench, centroid, found.mechanism)
        rate = (live * found.mechanism).sum()
        resisted = closing * np.linalg.norm(found.forces, axis=1).sum()
        assert rate > 0, "the load does not drive the mechanism"
        rounding = 1e-9 * (np.abs(wrench * found.mechanism).sum() + abs(found.upper) * rate)
        if found.upper == 0:  # what adds less than 2e-9 to the loads on each block is told as none; corners move by 1 m
            rounding += 2e-9 * np.linalg.norm(wrench[~asm.support, :3], axis=1).sum()
        assert found.upper * rate + work >= resisted - rounding, "the mechanism moves only at a larger load"
        more = TIGHT * (np.abs(wrench * found.mechanism).sum() + abs(found.upper) * rate)
        assert found.upper * rate + work <= 2 * resisted + more, "the mechanism moves at a smaller load"
    if found.coulomb is not None:
        assert 0 <= found.coulomb[0] <= found.coulomb[1] <= max(found.lower * (1 + 1e-12), found.upper)


def check_thrust(found, supports, direction, *, loads=None):
    """Raise AssertionError unless both force fields are admissible and push the supports as hard as is said."""
    asm, faces = found.assembly, found.interfaces
    wrench, centroid = dead_load(asm, loads)
    named = [supports] if isinstance(supports, (str, int)) else supports
    index = [asm.names.index(s) if isinstance(s, str) else s for s in named]
    along = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    k = faces.point_interface
    sign = np.isin(faces.pair[k, 1], index).astype(float) - np.isin(faces.pair[k, 0], index)
    for value, forces in ((found.least, found.least_forces), (found.greatest, found.greatest_forces)):
        if np.isfinite(value):
            check_forces(asm, faces, wrench, centroid, forces)
            thrust = np.einsum("n,nij,ni,j->", sign, faces.frame[k], forces, along)
            np.testing.assert_allclose(thrust, value, rtol=1e-9, atol=1e-9 * np.abs(wrench).sum())


def install():
    """Put the checks of this module behind the functions."""
    install_all({"assess": _assessed, "limit_load": _limited, "thrust_range": _thrust})


def install_all(checks):
    """Put checks behind the functions of these names, wherever they have been imported to."""
    for name, check in checks.items():
        original = getattr(blockstat, name)
        if getattr(original, "checked", False):
            continue
        replacement = checked(original, check)
        for module in list(sys.modules.values()):
            own = getattr(module, "__name__", "").split(".")[0] in ("blockstat", "evidence", "__main__")
            if own and vars(module).get(name) is original:
                setattr(module, name, replacement)


def checked(function, check):
    """The function, its result handed to `check` with the arguments before it is returned."""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def and_checked(*args, **options):
        result = function(*args, **options)
        given = signature.bind(*args, **options).arguments
        if given.get("imperfections") is None:  # the worst case has its own loads, and was checked on the way
            check(result, given)
        return result

    and_checked.checked = True  # other decorators wrap, too
    return and_checked


def _gap(given):
    """The tolerance that joints were found with; None where they were given."""
    return given.get("gap", GAP) if given.get("interfaces") is None else None


def _assessed(verdict, given):
    check_verdict(verdict, loads=given.get("loads"), gap=_gap(given))


def _limited(found, given):
    check_limit(found, given["load"], loads=given.get("loads"), gap=_gap(given))


def _thrust(found, given):
    check_joints(found.assembly, found.interfaces, _gap(given))
    check_thrust(found, given["supports"], given["direction"], loads=given.get("loads"))
