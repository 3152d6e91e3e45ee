"""Contacts that are in no program: whether a mechanism holds at those without a unique normal and at overlaps; gaps."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from blockstat.analysis.problem import Problem, crushes
from blockstat.analysis.reserve import loose_joints
from blockstat.certificate.falling import falling_blocks
from blockstat.contact.edges import CONVEX
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import NEAR_MISS, Interfaces, find_interfaces, near_blocks
from blockstat.contact.overlap.penetration import overlaps
from blockstat.contact.point_law import point_law
from blockstat.contact.tolerance import allowed_gap, beyond, gap_words, stated_length
from blockstat.contact.unresolved import Unresolved, unresolved_contacts
from blockstat.geometry.convexity import protrusions
from blockstat.geometry.polyhedron import point_velocity
from blockstat.loads import Loads, up_of, weighted
from blockstat.program.ties import tied_pairs
from blockstat.result import plain
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Speeds below this fraction of the fastest corner are rounding.
SLOW = 1e-6
NOWHERE = np.empty(0, dtype=np.int64)
#: Programs that hold only what mechanisms have asked for; the next one holds all.
ROUNDS = 4
#: The widest share of the size of a block up to which edges and corners are looked for.
WIDEST = 0.19


class _Judged(Protocol):
    @property
    def mechanism(self) -> Floats: ...


Judged = TypeVar("Judged", bound=_Judged)


def overlap_warnings(problem: Problem, mechanism: Floats) -> list[str]:
    """Warn of blocks in a mechanism that overlap too far to have a joint, and so have none in the program.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        Velocity [m] and rotation [rad] of each block, shape (n_blocks, 6); the fastest corner moves by 1 m.

    Returns
    -------
    list of str
        One warning that names a pair, or none.
    """
    hidden = _overlapping(problem, mechanism)
    if not len(hidden):
        return []
    one, two = (problem.assembly.names[i] for i in hidden[0])
    return [
        f'"{one}" and "{two}" overlap too far to have a joint ({len(hidden)} such pairs move), so instability is '
        "not proven"
    ]


def _overlapping(problem: Problem, mechanism: Floats) -> Ints:
    """The pairs of blocks that overlap too far to have a joint of which a mechanism moves one, shape (n, 2)."""
    moves = np.abs(mechanism).max(axis=1) > 0
    # A joint elsewhere does not help: where two blocks overlap, they have no joint that they ought to have.
    pairs = overlaps(problem.assembly, gap=problem.gap)[0] if problem.overlapping is None else problem.overlapping
    return pairs[moves[pairs].any(axis=1)]


def rim_warnings(problem: Problem, mechanism: Floats) -> list[str]:
    """Warn of blocks that a mechanism drives into each other where they touch without a unique normal.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        As in `overlap_warnings`.

    Returns
    -------
    list of str
        One warning that names a pair, or none.

    Notes
    -----
    Two edges, or an edge and a corner, keep apart where `n'g >= 0` about one of the normals that separate them. So the
    motions that they allow are all but those of an open convex cone, and the polar of these is nothing: no force can
    resist a motion in which the blocks pass each other. They pass where they open about one of the normals by more than
    rounding, edges along each other at every point that they share. Blocks that share a sliver too narrow for a patch
    do not pass: there, each normal may resist.
    """
    found = _resisting(problem, mechanism)
    if not len(found.pair):
        return []
    pairs = np.unique(found.pair, axis=0)
    first, second = (problem.assembly.names[i] for i in pairs[0])
    return [
        f'"{first}" and "{second}" touch only {found.reason[0]}, where forces have no definite direction ({len(pairs)} '
        "such pairs would be driven into each other), so instability is not proven"
    ]


def _resisting(problem: Problem, mechanism: Floats) -> Unresolved:
    """The contacts without a unique normal at which a mechanism drives blocks into each other."""
    assembly, rims = problem.assembly, problem.interfaces.rims
    if rims is None or not len(rims):
        return unresolved_contacts(assembly, problem.interfaces, pairs=np.empty((0, 2), dtype=np.int64))
    moving = _moving(assembly, mechanism, rims)
    if problem.unresolved is None:
        found = unresolved_contacts(assembly, problem.interfaces, gap=problem.gap, pairs=moving)
    else:
        found = problem.unresolved().among(moving, assembly.n_blocks)
    if not len(found.pair):
        return found
    one, two = (point_velocity(assembly, mechanism, found.pair[:, side], found.point) for side in (0, 1))
    velocity = two - one
    opening = np.einsum("nj,nj->n", found.normal, velocity[found.contact])
    passing, closing = np.full(len(found.pair), -np.inf), np.full(len(found.pair), np.inf)
    np.maximum.at(passing, found.contact, opening)
    np.minimum.at(closing, found.contact, opening)
    grazes = np.where(_slivers(problem, found.pair), True, passing <= SLOW)
    resists = grazes & (closing < -SLOW)
    resists[found.line[_driven_between_ends(found, velocity), 0]] = True
    return found.only(resists)


def _driven_between_ends(found: Unresolved, velocity: Floats) -> np.ndarray:
    """Which edges a mechanism drives into the edges along them, somewhere between the ends of what they share.

    The opening about each normal is linear along the edges. So the largest is convex, and least at an end or where two
    of them are equal.
    """
    begin, end = found.line.T
    count = np.bincount(found.contact, minlength=len(found.pair))[begin]
    column = np.minimum(np.arange(count.max(initial=0)), count[:, None] - 1)
    normal = found.normal[np.searchsorted(found.contact, begin)[:, None] + column]
    first, last = (np.einsum("nkj,nj->nk", normal, velocity[k]) for k in (begin, end))
    i, j = np.triu_indices(column.shape[1], 1)
    ahead, behind = first[:, i] - first[:, j], last[:, i] - last[:, j]
    line, pair = np.nonzero(ahead * behind < 0)
    share = ahead[line, pair] / (ahead[line, pair] - behind[line, pair])
    opening = first[line] + share[:, None] * (last[line] - first[line])
    driven = (opening.max(axis=1, initial=-np.inf) <= SLOW) & (opening.min(axis=1, initial=np.inf) < -SLOW)
    return np.bincount(line[driven], minlength=len(begin)) > 0


def _moving(assembly: Assembly, mechanism: Floats, pairs: Ints) -> Ints:
    """Those of some pairs of blocks that a mechanism moves against each other."""
    a, b = pairs.T
    apart = (
        mechanism[b, :3] - mechanism[a, :3] + np.cross(mechanism[a, 3:], assembly.centroid[a] - assembly.centroid[b])
    )
    turn = (mechanism[b, 3:] - mechanism[a, 3:]) * assembly.size[b, None]
    return pairs[np.hypot(np.linalg.norm(apart, axis=1), np.linalg.norm(turn, axis=1)) > SLOW]


def _opening(assembly: Assembly, mechanism: Floats, joints: Interfaces) -> Floats:
    """How fast a mechanism opens each point of some joints [m], below zero where it closes it."""
    joint = joints.point_interface
    one, two = (point_velocity(assembly, mechanism, joints.pair[joint, side], joints.point) for side in (0, 1))
    return np.einsum("nj,nj->n", joints.frame[joint, 0], two - one)


def falling_freely(problem: Problem, loads: Loads | None = None, held: Ints = NOWHERE) -> Ints:
    """Return the largest set of blocks that may fall freely from joints that nothing has pressed, by weight alone.

    Parameters
    ----------
    problem
        The posed problem.
    loads
        Those that it was posed with.
    held
        Numbers of blocks that are left out.

    Returns
    -------
    Ints
        Their numbers, ascending. Left out are blocks with a tie or with a load beside the weight, and those that have
        in their way what has no joint: an overlap, edges and corners without a unique normal, and joints with a gap
        beyond the tolerance. Empty where crushed contacts are in the way.
    """
    assembly, interfaces = problem.assembly, problem.interfaces
    if not assembly.gravity.any():
        return NOWHERE
    law = point_law(assembly, interfaces)
    tied = np.union1d(interfaces.point_interface[(law.floor > 0) | (law.shift > 0)], problem.bonds)
    down = -up_of(assembly)
    beside = np.zeros((assembly.n_blocks, 6)) if loads is None else np.asarray(weighted(loads).beside)
    near = np.array([(other.a, other.b) for other in interfaces.dropped], dtype=np.int64)
    carried = assembly.support | beside.any(axis=1)
    carried[np.concatenate([held, tied_pairs(assembly).ravel(), near.ravel()])] = True
    while len(blocks := falling_blocks(carried, interfaces, down, tied)):
        motion = np.zeros((assembly.n_blocks, 6))
        motion[blocks, :3] = down
        in_the_way = np.concatenate([_overlapping(problem, motion).ravel(), _resisting(problem, motion).pair.ravel()])
        stopped = np.intersect1d(in_the_way, blocks)
        if not len(stopped):
            return blocks[:0] if crushes(problem, motion) else blocks
        carried[stopped] = True
    return NOWHERE


def _slivers(problem: Problem, pairs: Ints) -> np.ndarray:
    """Which pairs of blocks share a patch that was too narrow to be taken."""
    n = problem.assembly.n_blocks
    slivers = [d.a * n + d.b for d in problem.interfaces.dropped if d.reason == "sliver"]
    return np.isin(pairs @ [n, 1], slivers)


def judged_with_rims(problem: Problem, mechanism: Floats, judge: Callable[[Interfaces], Judged]) -> Judged:
    """Judge again with what contacts without a unique normal could carry, as far as mechanisms ask for it.

    What falls with these contacts, falls, if its mechanism drives no blocks into each other at the others.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        As in `rim_warnings`; it drives blocks into each other.
    judge
        Returns an answer with a `mechanism` for the interfaces with more contacts. It is asked first with those at
        which the given mechanism drives blocks into each other, then also with those at which the mechanism of its
        answer does so, and with all of them after `ROUNDS` rounds.

    Returns
    -------
    object
        The last answer. Its mechanism holds at all contacts.
    """
    assembly, joints, n = problem.assembly, problem.interfaces, problem.assembly.n_blocks
    held = pairs_driven(problem, mechanism)
    for _ in range(ROUNDS):
        found = judge(unresolved_contacts(assembly, joints, gap=problem.gap, pairs=held).beside(joints))
        more = pairs_driven(problem, found.mechanism)
        more = more[~np.isin(more @ [n, 1], held @ [n, 1])]
        if not len(more):
            return found
        held = np.concatenate([held, more])
    return judge(unresolved_contacts(assembly, joints, gap=problem.gap).beside(joints))


def pairs_driven(problem: Problem, mechanism: Floats) -> Ints:
    """Return the pairs of blocks that a mechanism drives into each other where they touch without a unique normal.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        As in `overlap_warnings`.

    Returns
    -------
    array of int, shape (n, 2)
        Each once, sorted.
    """
    return np.unique(_resisting(problem, mechanism).pair, axis=0)


def gap_warnings(problem: Problem, *, more_may_help: bool, mechanism: Floats | None = None) -> list[str]:
    """Say when the answer may hang on the joint tolerance.

    Parameters
    ----------
    problem
        The posed problem.
    more_may_help
        Whether further joints may change the answer; they do not where all is carried.
    mechanism
        As in `overlap_warnings`: edges and corners in its way are told too. None to leave that to the caller.

    Returns
    -------
    list of str
        A sentence for each kind of joint, or none.
    """
    assembly, interfaces, gap = problem.assembly, problem.interfaces, problem.gap
    found = []
    near = [d for d in interfaces.dropped if d.reason == "gap"]
    if more_may_help and near:
        least = min(near, key=lambda d: d.value / d.limit)
        a, b = assembly.names[least.a], assembly.names[least.b]
        found.append(
            f"near joints that were not taken: {len(near)} (gap tolerance {gap_words(gap)}), the closest "
            f'"{a}" to "{b}" with {beyond(least.value, least.limit)} m: a larger tolerance may change the answer'
        )
    narrow = [d for d in interfaces.dropped if d.reason == "narrow"]
    if more_may_help and narrow:
        least = min(narrow, key=lambda d: d.value / d.limit)
        found.append(
            f"joints that were not taken as they are narrower than their gap: {len(narrow)}, the widest for its gap "
            f'"{assembly.names[least.a]}" to "{assembly.names[least.b]}", {plain(1e3 * least.limit, 2)} mm wide and '
            f"{beyond(1e3 * least.value, 1e3 * least.limit)} mm open: no tolerance takes them, and faces that meet may "
            "change the answer"
        )
    found += _within_warp(problem) if more_may_help else []
    found += near_edge_warnings(problem, mechanism) if more_may_help and mechanism is not None else []
    loose = loose_joints(assembly, interfaces)
    if loose.any():
        worst = f"{plain(1e3 * interfaces.gap[loose].max(), 2)} mm"
        found.append(f"{loose.sum()} of {len(loose)} joints do not quite close (up to {worst}) and count as touching")
    return found


def near_edge_warnings(problem: Problem, mechanism: Floats) -> list[str]:
    """Say when edges and corners beyond the joint tolerance are in the way of a mechanism.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        As in `overlap_warnings`.

    Returns
    -------
    list of str
        One warning that names the closest, or none. Joints that displaced corners took along are not doubted.

    Notes
    -----
    With the tolerance times `NEAR_MISS`, contacts are looked for between the blocks that move against each other.
    What the mechanism does not close cannot stop it. Pairs of which a near patch was dropped have a warning already,
    and two convex blocks with a patch meet in its plane alone.
    """
    assembly, interfaces, gap = problem.assembly, problem.interfaces, problem.gap
    if interfaces.moved or not mechanism.any():
        return []
    length, n = stated_length(gap), assembly.n_blocks
    dropped = [other.a * n + other.b for other in interfaces.dropped if other.reason != "sliver"]
    first_face = np.searchsorted(assembly.face_block, np.arange(n))
    convex = np.maximum.reduceat(protrusions(assembly), first_face) <= CONVEX * assembly.size
    flat = interfaces.pair[interfaces.kinds == ContactKind.FACE]
    beside_a_plane = flat[convex[flat].all(axis=1)]
    told = np.concatenate([np.array(dropped, dtype=np.int64), beside_a_plane @ [n, 1]])
    pairs = _moving(assembly, mechanism, near_blocks(assembly, gap=gap))
    pairs = pairs[~np.isin(pairs @ [n, 1], told)]
    if not len(pairs):
        return []
    wider = min(NEAR_MISS * float(gap), WIDEST) if length is None else f"{NEAR_MISS * length:.17g} m"
    found = find_interfaces(assembly, gap=wider, near=pairs)
    limit = allowed_gap(assembly, gap)[found.pair].min(axis=1)
    closing = np.minimum.reduceat(_opening(assembly, mechanism, found), found.start[:-1]) < -SLOW
    # An edge in the plane of a patch is part of it. By a length, patches that are taken may be open by their warp too.
    new = ((found.kinds != ContactKind.FACE) | (length is None)) & (found.gap > limit) & closing
    if not new.any():
        return []
    least = int(np.where(new, found.gap / limit, np.inf).argmin())
    a, b = (assembly.names[i] for i in found.pair[least])
    return [
        f"near edges and corners that were not taken and are in the way of the fall: {new.sum()} (gap tolerance "
        f'{gap_words(gap)}), the closest "{a}" to "{b}" with {beyond(found.gap[least], limit[least])} m: a larger '
        "tolerance may change the answer"
    ]


def _within_warp(problem: Problem) -> list[str]:
    """Name faces beyond the near misses of a gap given as a length that are apart by less than they are warped."""
    assembly, gap, planes = problem.assembly, problem.gap, problem.assembly.planes
    length = stated_length(gap)
    warp = np.zeros(assembly.n_blocks)
    np.maximum.at(warp, assembly.face_block, planes.warp)
    if length is None or not warp.max() > NEAR_MISS * length:
        return []
    wide = find_interfaces(assembly, gap=f"{warp.max():.17g} m")
    told = {*map(tuple, problem.interfaces.pair.tolist()), *((own.a, own.b) for own in problem.interfaces.dropped)}
    new = np.array([pair not in told for pair in map(tuple, wide.pair.tolist())], bool) & (wide.area > 0)
    new &= (wide.gap > length) & (wide.gap <= warp[wide.pair].max(axis=1))
    if not new.any():
        return []
    least = int(np.where(new, wide.gap, np.inf).argmin())
    a, b = (assembly.names[i] for i in wide.pair[least])
    return [
        f"faces apart by less than they are warped, and not taken: {new.sum()} (gap tolerance {gap_words(gap)}), the "
        f'closest "{a}" to "{b}"; gap="{_rounded_up(1e3 * wide.gap[least])} mm" closes it'
    ]


def _rounded_up(value: float) -> str:
    """A number of two digits that is no smaller but by rounding."""
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return f"{step * np.ceil(value / step - 1e-9):.3g}"
