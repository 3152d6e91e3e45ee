"""What a stable verdict has in reserve: whether it is balanced, and on which doubtful joints it or a limit load rests.

A joint is doubtful if it is a sliver, or if it does not quite close.

An assembly withstands any small load more if and only if `-w` lies inside `A K`, the loads that the contacts can
balance. It does not where a block can move without moving a contact point (`blockstat.certificate.neutral`), or where
no forces in equilibrium have slack at every contact point. Then there is a neutral motion: no joint closes under it,
and the loads do no work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from operator import ne
from typing import NamedTuple, TypeVar

import numpy as np
from scipy import sparse

from blockstat.analysis.decision import solve_margin_locally
from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import corner_speed
from blockstat.assembly import Assembly
from blockstat.certificate.check import FORCE_TOLERANCE, balance, force_errors
from blockstat.certificate.neutral import ON_A_LINE, loose_blocks
from blockstat.contact.coplanar import Parts, Patch, Patches, joints_of_patches
from blockstat.contact.faces import convex_polygons, opened, outline_hull
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import WIDTH, Interfaces
from blockstat.contact.tolerance import LOOSE
from blockstat.geometry import clipping
from blockstat.geometry.components import connected_components
from blockstat.imperfection.bare_contacts import BareContacts
from blockstat.program.penalty import PenaltyProgram
from blockstat.program.ties import tie_columns
from blockstat.result import listed
from blockstat.solve.answer import Answer
from blockstat.typing import Floats, Ints

#: A joint narrower than this share of the smaller block (cube root of volume) is a sliver: 0.2 mm on a brick, less than
#: stone is cut or measured to.
SLIVER = 1e-3
#: Frictionless joints are lent this friction: that blocks slide on them freely is not worth a word.
LENT = 1e-3
#: Corners slower than this fraction of the fastest are at rest.
SLOW = 0.01
NAMED = 3  #: blocks, or joints of a kind, that a warning names
Found = TypeVar("Found")  #: what an analysis finds


def neutral_blocks(problem: Problem, checked: Answer, *, solver: str = "auto") -> Ints:
    """Find the blocks of a stable assembly that a neutral motion moves.

    Parameters
    ----------
    problem
        The posed problem.
    checked
        The forces that prove it stable, with their certificate.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Ints
        Their numbers, ascending.

    Notes
    -----
    Forces with slack at every point show that there is nothing to look for beyond loose blocks. Only where those at
    hand have none is the largest slack asked for, by one more program. Slack of less than `FORCE_TOLERANCE` of a
    block's load is none: equilibrium is proven no better than that. Columns whose force is given, as that of a bond
    without capacity, have no slack to have and hold nothing.
    """
    program = problem.program
    assert program is not None
    loose, live = _loose(problem), program.upper > program.lower
    program, slack = _of_columns(program, live), checked.certificate.slack
    if not live.all():
        slack = force_errors(program, checked.force[live]).slack
    if slack > FORCE_TOLERANCE:
        return loose
    lent = replace(program, friction=np.maximum(program.friction, LENT))
    widest = solve_margin_locally(lent, solver=solver)
    if force_errors(lent, balance(lent, widest.force)).slack > FORCE_TOLERANCE:
        return loose
    speed = corner_speed(problem.assembly, problem.to_blocks(widest.twist))
    return np.union1d(loose, np.flatnonzero(speed > SLOW * speed.max(initial=0.0)))


def _of_columns(program: PenaltyProgram, live: np.ndarray) -> PenaltyProgram:
    """The program with some of its columns of three alone, all contact points among them."""
    if live.all():
        return program
    names = ("friction", "shift", "lower", "upper", "point_blocks")
    changes = {name: getattr(program, name)[live] for name in names}
    return replace(program, **changes, local=program.local[np.repeat(live, 3)], plane=None)


def _loose(problem: Problem) -> Ints:
    """Find the blocks that can move without moving a contact point, and without a tie that lengthens or shortens."""
    assembly, interfaces, held = problem.assembly, problem.interfaces, problem.eq.blocks
    if not len(problem.ties):
        return loose_blocks(assembly.support, interfaces, held, problem.bonds)
    # Patches make blocks one body, as the ground is one.
    ground = np.flatnonzero(assembly.support)
    joined = [np.column_stack([ground[:-1], ground[1:]]), interfaces.pair[interfaces.area > 0]]
    _, body = connected_components(assembly.n_blocks, np.concatenate(joined))
    free = np.setdiff1d(body[held], body[ground])
    if not len(free):
        return held[:0]
    rates = _rates(problem, body, free)
    value, vector = np.linalg.eigh((rates.T @ rates).toarray())
    still = vector[:, value <= ON_A_LINE**2 * value[-1]].reshape(len(free), -1)
    return held[np.isin(body[held], free[np.linalg.norm(still, axis=1) > ON_A_LINE])]


def _rates(problem: Problem, body: Ints, free: Ints) -> sparse.csr_array:
    """Relative velocities at contact points between bodies, and of the ends of ties, for motions of the free bodies.

    A body moves about the middle of its points; its rotation is in units of one over their reach. Returns shape
    (n, 6 n_free).
    """
    faces, ties = problem.interfaces, [problem.assembly.ties[k] for k in problem.ties]
    columns, ends = tie_columns(problem.assembly, ties), np.array([tie.points for tie in ties], dtype=float)
    pair = np.concatenate([np.repeat(faces.pair[faces.point_interface], 3, axis=0), columns.pair])
    way = np.concatenate([np.tile(np.eye(3), (faces.n_points, 1)), columns.force[:, 0]])
    point = np.concatenate([np.repeat(faces.point, 3, axis=0)[:, None, :].repeat(2, axis=1), ends])
    across = body[pair[:, 0]] != body[pair[:, 1]]
    side, way, point = body[pair[across]], way[across], point[across]
    rows, numbers, values = [], [], []
    for k, each in enumerate(free):
        row, which = np.nonzero(side == each)
        arm = point[row, which] - point[row, which].mean(axis=0)
        arm /= np.linalg.norm(arm, axis=1).max(initial=0.0) or 1.0
        sign = np.where(which == 1, 1.0, -1.0)[:, None]
        values.append((sign * np.hstack([way[row], np.cross(arm, way[row])])).ravel())
        rows.append(np.repeat(row, 6))
        numbers.append(np.tile(6 * k + np.arange(6), len(row)))
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(numbers))
    return sparse.csr_array(entries, shape=(len(way), 6 * len(free)))


def neutral_warning(problem: Problem, neutral: Ints) -> list[str]:
    """Say that a stable assembly has no reserve.

    Parameters
    ----------
    problem
        The posed problem.
    neutral
        The blocks that a neutral motion moves.

    Returns
    -------
    list of str
        A sentence, or none.
    """
    if not len(neutral):
        return []
    names = listed([f'"{problem.assembly.names[i]}"' for i in neutral], NAMED)
    return [f"balanced: in equilibrium without reserve; nothing resists a small push that moves {names}"]


def loose_joints(assembly: Assembly, interfaces: Interfaces) -> np.ndarray:
    """Tell which joints do not quite close.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.

    Returns
    -------
    array of bool, shape (n_interfaces,)
        True for a joint that is open by more than `LOOSE` of its smaller block, or of its own width if it is narrower.

    Notes
    -----
    Before a patch of width b that is open by g bears, one of the blocks turns by up to g / b. So the share of the width
    is an angle, and what turns by less than it loses no more than that share of an arm.
    """
    if not interfaces.n_interfaces:
        return np.zeros(0, dtype=bool)
    return _is_loose(assembly, interfaces, _diagonals(interfaces.point, interfaces.start[:-1]))


def _is_loose(assembly: Assembly, of: Interfaces | Patches, diagonal: Floats) -> np.ndarray:
    """Which joints or patches do not quite close; a diagonal is that of the box of their points [m]."""
    least = assembly.size[of.pair].min(axis=1)
    width = of.area / np.maximum(diagonal, np.finfo(float).tiny)
    return of.gap > LOOSE * np.where(of.area > 0, np.minimum(least, width), least)


class Doubtful(NamedTuple):
    """Joints that an answer may not rest on, by number, ascending."""

    slivers: Ints
    loose: Ints  #: those that do not quite close

    @property
    def steps(self) -> list[Doubtful]:
        """What is left out one after the other: slivers, and then all; none where nothing is doubtful."""
        if not len(self.loose):
            return [self] if len(self.slivers) else []
        return [self._replace(loose=self.loose[:0]), self] if len(self.slivers) else [self]


def doubtful_joints(problem: Problem, forces: Floats | None) -> Doubtful:
    """Find the doubtful joints that carry load.

    Parameters
    ----------
    problem
        The posed problem.
    forces
        Shape (n_points, 3) [N]; None where those that count are not at hand, for all doubtful joints.

    Returns
    -------
    Doubtful
        Joints with load on slivers, and joints with load that do not quite close.
    """
    interfaces = problem.interfaces
    narrow, loose = _narrow_joints(problem, interfaces), np.flatnonzero(loose_joints(problem.assembly, interfaces))
    if forces is None:
        return Doubtful(np.array(sorted(narrow), dtype=np.int64), loose)
    own = np.where(problem.assembly.support, np.inf, np.linalg.norm(problem.load[:, :3], axis=1))
    least = FORCE_TOLERANCE * own[interfaces.pair].min(axis=1)
    carried = np.linalg.norm(forces, axis=1)

    def loaded(k: int, points: np.ndarray | slice = slice(None)) -> bool:
        return bool(carried[interfaces.start[k] : interfaces.start[k + 1]][points].sum() > least[k])

    slivers = [k for k, own_narrow in sorted(narrow.items()) if loaded(k, own_narrow.beyond)]
    return Doubtful(np.array(slivers, dtype=np.int64), loose[[loaded(k) for k in loose.tolist()]])


class _Narrow(NamedTuple):
    """A joint that is a sliver or has some."""

    beyond: np.ndarray  #: which of its points slivers alone give
    hull: Floats  #: corners of what is wide, shape (n, 3), none where nothing is [m]
    wide: list[Floats]  #: convex polygons that this is made of, along t1 and t2 from the first point of the joint [m]


def _narrow_joints(problem: Problem, interfaces: Interfaces) -> dict[int, _Narrow]:
    """The joints among some interfaces of a problem that have slivers, by number.

    Slivers are patches narrower than `SLIVER` of the smaller block, arms of patches that are as narrow, edges that are
    shorter, edges and corners that lie on a face no further from its rim, and edges that cross where a slip no longer
    than this parts them. A strip along the rim of what is wide is none: it moves an arm by its width at most, which is
    nothing.
    """
    if not interfaces.n_interfaces:
        return {}
    least = SLIVER * problem.assembly.size[interfaces.pair].min(axis=1)
    length = _diagonals(interfaces.point, interfaces.start[:-1])
    narrow = (interfaces.area > 0) & (interfaces.area < least * length)
    edges = interfaces.kinds == ContactKind.EDGE
    narrow |= edges & (length < least)
    bare = cache(lambda: BareContacts(problem.assembly, interfaces, least))  # most scenes have patches alone
    for k in np.flatnonzero(interfaces.kinds != ContactKind.FACE).tolist():
        narrow[k] |= not len(bare().left(k, interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]))
    parts = _parts_of_narrow(interfaces, narrow, least)
    found = {}
    for k in sorted({*np.flatnonzero(narrow).tolist(), *parts}):
        points = interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]
        own_parts = [part for part in parts.get(k, []) if len(part) > 2 or len(bare().left(k, part))]
        own = _what_is_wide(points, own_parts, interfaces.frame[k, 1:], float(least[k]))
        if own.beyond.any():
            found[k] = own
    return found


def _diagonals(point: Floats, start: Ints) -> Floats:
    """Of the boxes of points, one list after the other [m]."""
    return np.linalg.norm(np.maximum.reduceat(point, start) - np.minimum.reduceat(point, start), axis=1)


def _parts_of_narrow(interfaces: Interfaces, narrow: np.ndarray, least: Floats) -> Parts:
    """What those joints are made of whose hull is more than their patches, of pairs of which one or a patch is narrow.

    Patches are convex: a narrow arm of one that is not comes in pieces, of which the last at least is narrow. Edges and
    corners beside patches may be on rims.
    """
    patches = interfaces.patches
    if patches is None or not len(patches.pair):
        return {}
    n = int(max(interfaces.pair.max(), patches.pair.max())) + 1
    key, asked = interfaces.pair @ [n, 1], patches.pair @ [n, 1]
    widths = dict(zip(key.tolist(), least.tolist(), strict=True))
    width = np.array([widths.get(k, 0.0) for k in asked.tolist()])
    length = _diagonals(patches.corner, np.cumsum(patches.count) - patches.count)
    thin = (patches.count < 3) | (patches.area < width * length)
    return _parts_of_pairs(interfaces, np.isin(key, np.union1d(asked[thin], key[narrow])))


def _parts_of_pairs(interfaces: Interfaces, joints: np.ndarray) -> Parts:
    """`Interfaces.parts` of some joints, which are all those of their pairs, without a look at the others."""
    rows = np.flatnonzero(joints)
    if not len(rows):
        return {}
    few = replace(interfaces.subset(rows), patches=_of_pairs(interfaces.patches, interfaces.pair[rows])[0])
    return {int(rows[k]): own for k, own in few.parts.items()}


def _of_pairs(patches: Patches | None, pairs: Ints) -> tuple[Patches | None, Patches | None]:
    """The patches of some pairs of blocks, and the others."""
    if patches is None or not len(patches.pair):
        return patches, patches
    n = int(max(pairs.max(initial=0), patches.pair.max())) + 1
    own = np.isin(patches.pair @ [n, 1], pairs @ [n, 1])
    return patches.take(np.flatnonzero(own)), patches.take(np.flatnonzero(~own))


def _what_is_wide(points: Floats, parts: list[Floats], across: Floats, least: float) -> _Narrow:
    """What of a joint is wide: of its patches, edges that are long enough, and corners."""
    import shapely

    flat = [(part - points[0]) @ across.T for part in parts]
    # Patches that touch are one, also where rounding has left a seam between them.
    room = WIDTH * least
    solid = [shapely.buffer(shapely.Polygon(own), room, join_style="mitre") for own in flat if len(own) > 2]
    wide = shapely.get_parts(opened(shapely.union_all(solid), least))
    pieces = [piece for own in wide if own.geom_type == "Polygon" and own.area > 0 for piece in convex_polygons(own)]
    if not pieces:
        return _Narrow(np.ones(len(points), dtype=bool), np.empty((0, 3)), [])
    bare = [own for own in flat if len(own) == 1 or (len(own) == 2 and np.linalg.norm(own[1] - own[0]) >= least)]
    hull = outline_hull(np.concatenate([*pieces, *bare]))
    away = shapely.distance(shapely.points((points - points[0]) @ across.T), shapely.Polygon(hull))
    return _Narrow(away > least, points[0] + hull @ across, pieces)


def without_slivers(problem: Problem) -> Interfaces:
    """Return the interfaces of a problem without its slivers.

    Parameters
    ----------
    problem
        The posed problem.

    Returns
    -------
    Interfaces
        On the hulls of what of the joints is wide. Those that joint laws divide into cells are not divided yet; where
        joints were given in cells, the cells on slivers are missing.
    """
    interfaces = problem.interfaces if problem.undivided is None else problem.undivided
    narrow = _narrow_joints(problem, interfaces)
    points, area = np.split(interfaces.point, interfaces.start[1:-1]), interfaces.area.copy()
    share = None if interfaces.share is None else interfaces.share[_kept(interfaces, narrow)]
    for k, own in narrow.items():
        points[k] = own.hull if share is None else points[k][~own.beyond]
        area[k] = area[k] if share is not None else sum(_area(piece) for piece in own.wide)
    left = _on_points(interfaces, np.flatnonzero([len(own) > 0 for own in points]), points, area)
    return replace(left, share=share, patches=_wide_patches(interfaces, narrow))


def _on_points(interfaces: Interfaces, rows: Ints, points: list[Floats], area: Floats) -> Interfaces:
    """Some of the joints, on other points [m] and with other areas [m2], both given for all joints."""
    start = np.concatenate([[0], np.cumsum([len(points[k]) for k in rows])]).astype(np.int64)
    point = np.concatenate([np.empty((0, 3)), *(points[k] for k in rows)])
    return replace(interfaces.subset(rows), point=point, start=start, area=area[rows])


def _kept(interfaces: Interfaces, narrow: dict[int, _Narrow]) -> np.ndarray:
    """Which points are not on slivers alone."""
    kept = np.ones(interfaces.n_points, dtype=bool)
    for k, own in narrow.items():
        kept[interfaces.start[k] : interfaces.start[k + 1]] = ~own.beyond
    return kept


def _wide_patches(interfaces: Interfaces, narrow: dict[int, _Narrow]) -> Patches | None:
    """The patches without slivers."""
    joints = list(narrow)
    n = int(interfaces.pair.max(initial=0)) + 1
    key = interfaces.pair @ [n, 1]
    beside = np.isin(key, key[joints])
    patches = _of_pairs(interfaces.patches, interfaces.pair[joints])[1]
    if patches is None:
        return None
    parts, more = _parts_of_pairs(interfaces, beside), []
    for k in np.flatnonzero(beside).tolist():
        origin, frame = interfaces.point[interfaces.start[k]], interfaces.frame[k]
        flat = narrow[k].wide if k in narrow else [(own - origin) @ frame[1:].T for own in parts.get(k, [])]
        gap = float(interfaces.gap[k])
        more += [Patch(interfaces.pair[k], frame, origin, _area(own), gap, own) for own in flat]
    return patches.with_more(more) if more else patches


def _area(polygon: Floats) -> float:
    """Of a convex polygon; none of an edge or a corner."""
    return float(clipping.area(polygon[None], np.array([len(polygon)]))[0])


def without_doubtful(problem: Problem, doubtful: Doubtful) -> Interfaces:
    """Return the interfaces of a problem without its slivers, without its joints that do not quite close, or both.

    Parameters
    ----------
    problem
        The posed problem.
    doubtful
        Of each kind that it has all are left out.

    Returns
    -------
    Interfaces
        As of `without_slivers`.
    """
    whole = problem.interfaces if problem.undivided is None else problem.undivided
    interfaces = without_slivers(problem) if len(doubtful.slivers) else whole
    return _without_loose(problem.assembly, interfaces) if len(doubtful.loose) else interfaces


def _without_loose(assembly: Assembly, interfaces: Interfaces) -> Interfaces:
    """The joints that close; of one of several patches the hull of those that do, unless it is divided into cells."""
    loose = loose_joints(assembly, interfaces)
    closing = {} if interfaces.share is not None else _closing_patches(assembly, interfaces, np.flatnonzero(loose))
    points, area = np.split(interfaces.point, interfaces.start[1:-1]), interfaces.area.copy()
    for k, (hull, own_area) in closing.items():
        points[k], area[k] = hull, own_area
    rows = np.array([k for k in range(len(points)) if not loose[k] or k in closing], dtype=np.int64)
    return _on_points(interfaces, rows, points, area)


def _closing_patches(assembly: Assembly, interfaces: Interfaces, joints: Ints) -> dict[int, tuple[Floats, float]]:
    """Of some joints the hull of the patches that close, shape (n, 3) [m], and their area [m2], where there are any."""
    patches = _of_pairs(interfaces.patches, interfaces.pair[joints])[0]
    if patches is None or not len(patches.pair):
        return {}
    own = interfaces.subset(joints)
    joint = joints_of_patches([own.outline(k) for k in range(len(joints))], own.pair, own.frame, patches)
    loose = _is_loose(assembly, patches, _diagonals(patches.corner, np.cumsum(patches.count) - patches.count))
    found = {}
    for number, k in enumerate(joints.tolist()):
        rows = np.flatnonzero((joint == number) & ~loose & (patches.area > 0))
        if len(rows):
            across = interfaces.frame[k, 1:]
            corners = np.concatenate([p.origin + p.polygon @ p.frame[1:] for p in patches.take(rows)])
            origin = corners[0]  # the joint lies between its patches
            hull = outline_hull((corners - origin) @ across.T)
            found[k] = origin + hull @ across, float(patches.area[rows].sum())
    return found


def joints_in_words(problem: Problem, doubtful: Doubtful) -> str:
    """Name doubtful joints by kind.

    Parameters
    ----------
    problem
        The posed problem.
    doubtful
        The joints.

    Returns
    -------
    str
        The kinds with the names of the blocks, a few of each.
    """
    names = problem.assembly.names
    kinds = (
        (f"joints narrower than {SLIVER:g} of their smaller block", doubtful.slivers),
        ("joints that do not quite close", doubtful.loose),
    )
    listed_kinds = []
    for words, joints in kinds:
        pairs = [f'"{names[a]}" to "{names[b]}"' for a, b in problem.interfaces.pair[joints].tolist()]
        listed_kinds += [f"{words}: {listed(pairs, NAMED)}"] if pairs else []
    return ", and ".join(listed_kinds)


def resting_warning(
    problem: Problem,
    forces: Floats | None,
    found: Found,
    again: Callable[[Interfaces], Found | None],
    told: str,
    *,
    worse: Callable[[Found, Found], bool] = ne,
    words: Callable[[Found], str] = str,
    falls: str = "it is not proven stable",
) -> list[str]:
    """Say which doubtful joints an answer rests on, and what it is without them.

    Parameters
    ----------
    problem
        The posed problem.
    forces
        Those that prove the answer, shape (n_points, 3) [N]; None where they are not at hand, so that any joint may be
        among those that bear it.
    found
        The answer.
    again
        Gives it with other interfaces, and None where the assembly is not proven to stand on them. It is asked only
        where a doubtful joint is loaded, and must not ask for doubtful joints itself.
    told
        The answer in words, such as "stable".
    worse
        Whether an answer, the first argument, tells less than another.
    words
        Says an answer on fewer joints, such as "it is 0.5".
    falls
        Says that there is none.

    Returns
    -------
    list of str
        A sentence, or none.

    Notes
    -----
    Where both kinds of doubtful joints are loaded, slivers alone are left out first. In a drawing with noise they may
    be invented, while joints that do not quite close are what the blocks stand on.
    """
    doubtful, text, last = doubtful_joints(problem, forces), "", found
    for own in doubtful.steps:
        bare = again(without_doubtful(problem, own))
        if bare is None or worse(bare, last):
            so = falls if bare is None else words(bare)
            more = joints_in_words(problem, own._replace(slivers=own.slivers[:0]))
            head = f"{told} only with {joints_in_words(problem, own)}; without them"
            text = f"{text}, and without {more} either {so}" if text else f"{head} {so}"
            if bare is None:
                break
            last = bare
    return [text] if text else []


def moved(bare: float, found: float, room: float = 0.0) -> bool:
    """Tell whether a value without doubtful joints is another than with them.

    Parameters
    ----------
    bare, found
        The values; both may be infinite.
    room
        By how much they may differ beyond what slivers make of them.

    Returns
    -------
    bool
        Whether they differ.

    Notes
    -----
    A strip of `SLIVER` of a block moves an arm by that share, and a value with it: a smaller difference says nothing.
    """
    return bare != found and not abs(bare - found) <= SLIVER * min(abs(bare), abs(found)) + room


def limit_warning(
    problem: Problem, forces: Floats | None, carried: float, tolerance: float, carried_by: Callable[[Interfaces], float]
) -> list[str]:
    """Say which doubtful joints a limit load rests on, and what is carried without them.

    Parameters
    ----------
    problem
        The posed problem.
    forces
        Those that carry the multiplier, shape (n_points, 3) [N], or None as in `resting_warning`.
    carried
        The multiplier, the lower end of a bracket.
    tolerance
        Largest width of the bracket, relative to its upper end.
    carried_by
        Gives the multiplier with other interfaces, below zero where the dead load is not carried; asked only where a
        doubtful joint is loaded.

    Returns
    -------
    list of str
        A sentence, or none.

    Notes
    -----
    The forces that carry a load without limit are not at hand, so that any joint may be among those that bear it.
    """
    if carried <= 0:
        return []

    def again(joints: Interfaces) -> float | None:
        bare = carried_by(joints)
        return None if bare == -np.inf else bare

    return resting_warning(
        problem, None if np.isinf(carried) else forces, carried, again,
        f"the load is carried up to {carried:.6g}" if np.isfinite(carried) else "any multiple is carried",
        worse=lambda bare, last: bare < (1 - SLIVER - tolerance) * last,
        words=lambda bare: f"it is {bare:.6g}",
        falls="the dead load is not proven to be carried",
    )  # fmt: skip
