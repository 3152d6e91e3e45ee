"""Supports that move: what follows, which joints crack, and what holds the supports back.

A foundation is the part of the supports that moves as one: whole support blocks, or only where some blocks stand on
them, or only inside a region. So one slab of ground may settle in part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.thrust import admissible, optima, power_on_supports, standing, support_indices
from blockstat.analysis.verdict import corner_speed, relative_motion
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_vector, known_options
from blockstat.joint import fits
from blockstat.loads import numbers
from blockstat.program.bonds import Bonds
from blockstat.program.ties import tied_pairs
from blockstat.result import Result, Sentence, counted, finite, listed, plain
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Blocks whose fastest corner moves by less than this, relative to the movement of the supports, are at rest.
MOVING = 0.01
#: Joints that open or slide by less than this, relative to the movement of the supports, stay shut.
SHUT = 1e-4
#: What sticks out of a region by less than this, relative to the block on the support, is rounding.
ROUNDING = 1e-6
#: A reaction smaller than this, relative to all loads, is none: what forces leave of equilibrium.
NO_REACTION = 1e-9
FALLS_ANYWAY = "it falls without any movement of its supports"  #: says what does not stand


class SettlementOutcome(Sentence):
    """The answers of `settlement` and `settle`; each value is the sentence a user reads."""

    PUSHES = "Pushes: the assembly pushes the moving supports along."
    RESISTS = "Resists: the assembly pushes against the movement of the supports."
    FREE = "Free: the assembly neither pushes the moving supports along nor resists their movement."


class Foundation(NamedTuple):
    """A part of the supports that moves as one."""

    name: str
    displacement: Floats  #: shape (3,) [m]
    joints: Ints  #: numbers of the interfaces on it
    reaction: Floats  #: force of the assembly on it, with bonds and ties, shape (3,) [N]


class Crack(NamedTuple):
    """What a joint does, to first order in the movement of the supports."""

    blocks: tuple[str, str]
    opening: float  #: largest distance of the two faces [m]
    slip: float  #: largest slip along the joint [m]


@dataclass(frozen=True, eq=False)
class Settlement(Result):
    """What happens when supports begin to move."""

    mechanism: Floats  #: shape (n_blocks, 6) [m, rad], at `displacement`; 0 for a support that moves in part
    forces: Floats  #: shape (n_points, 3) [N], the one state of the settling assembly
    #: [N], force of the assembly on the moving supports along the movement: its work per unit of `displacement`; zero
    #: where it is no more than rounding
    reaction: float
    interfaces: Interfaces
    assembly: Assembly
    warnings: tuple[str, ...] = ()
    displacement: float = 1.0  #: [m], of the foundation that moves furthest; all else is in proportion
    foundations: tuple[Foundation, ...] = ()
    ties: Floats | None = None  #: tension of each tie, or compression of each strut, with `forces`, (n_ties,) [N]
    bonds: Bonds | None = None  #: what the bonds at the centres of joints carry with `forces`

    @property
    def outcome(self) -> SettlementOutcome:
        """Whether the assembly pushes with the movement or against it; one that only rides along does neither."""
        if not self.reaction:
            return SettlementOutcome.FREE
        return SettlementOutcome.PUSHES if self.reaction > 0 else SettlementOutcome.RESISTS

    @property
    def joint_motion(self) -> Floats:
        """Displacement of block b against block a at each contact point in the joint's frame, shape (n_points, 3) [m].

        Positive normal values open the joint. A ground that moves in part counts where it moves.
        """
        faces, support = self.interfaces, self.assembly.support
        motion = relative_motion(self.assembly, faces, self.mechanism)
        index = faces.point_interface
        moved = np.flatnonzero(support & np.any(self.mechanism, axis=1))
        first, second = faces.pair.T
        whole = np.isin(first, moved) | np.isin(second, moved)  # in `mechanism` already
        for foundation in self.foundations:
            part = np.isin(index, foundation.joints) & ~whole[index]
            sign = np.where(support[faces.pair[index[part], 1]], 1.0, -1.0)
            along = np.einsum("nij,j->ni", faces.frame[index[part]], foundation.displacement)
            motion[part] += sign[:, None] * along
        return motion

    def cracks(self, *, tolerance: float = SHUT) -> list[Crack]:
        """Return the joints that open or slide, the widest first.

        Parameters
        ----------
        tolerance : float, optional
            Relative to the movement of the supports; what moves less is left out.

        Returns
        -------
        list of Crack
            Openings and slips [m], to first order. Friction is associated: a joint that slides by s also opens by
            friction x s.
        """
        motion, faces = self.joint_motion, self.interfaces
        if not faces.n_interfaces:
            return []
        opening = np.maximum.reduceat(motion[:, 0], faces.start[:-1])
        slip = np.maximum.reduceat(np.hypot(motion[:, 1], motion[:, 2]), faces.start[:-1])
        moved = np.flatnonzero(np.maximum(opening, slip) > tolerance * self.displacement)
        order = moved[np.argsort(-opening[moved], kind="stable")]
        names = self.assembly.names
        return [
            Crack((names[faces.pair[k, 0]], names[faces.pair[k, 1]]), max(float(opening[k]), 0.0), float(slip[k]))
            for k in order
        ]

    def explain(self, limit: int = 5) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Parameters
        ----------
        limit : int, optional
            Most blocks and joints that are named.

        Returns
        -------
        str
            The lines.
        """
        lines = [
            self.outcome.value,
            f"Force on the moving supports along the movement, with dilatant friction: {self.reaction:.6g} N.",
        ]
        for name, moved, joints, reaction in self.foundations:
            lines.append(
                f"{name} moves by ({_numbers(1e3 * moved)}) mm with {counted(len(joints), 'joint')} on it, and carries "
                f"({_numbers(reaction)}) N."
            )
        speed = corner_speed(self.assembly, self.mechanism)
        order = np.argsort(-speed, kind="stable")
        moving = (speed[order] > MOVING * self.displacement) & ~self.assembly.support[order]
        names = [self.assembly.names[i] for i in order[moving]]
        if names:
            lines.append(f"Blocks that move with them: {listed(names, limit)}.")
        cracks = [crack for crack in self.cracks() if crack.opening > SHUT * self.displacement]
        if cracks and self.foundations:
            lines.append(
                f"Open, to first order in the movement: {counted(len(cracks), 'joint')}. Those that slide open by "
                "friction times slip, as dilatant friction has it. The widest are:"
            )
            lines += [f"  {a} and {b}: {plain(1e3 * width)} mm" for (a, b), width, _ in cracks[:limit]]
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "displacement": finite(self.displacement),
            "reaction": finite(self.reaction),
            "foundations": [
                {
                    "name": name,
                    "displacement": [float(part) for part in moved],
                    "reaction": [float(part) for part in reaction],
                    "joints": len(joints),
                }
                for name, moved, joints, reaction in self.foundations
            ],
            "cracks": [
                {"blocks": list(crack.blocks), "opening": crack.opening, "slip": crack.slip} for crack in self.cracks()
            ],
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "contacts": self.interfaces.contacts,
            "warnings": list(self.warnings),
        }


@known_options
def settle(
    assembly: Assembly,
    moves: Mapping[Any, Sequence[float]],
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> Settlement:
    """Find what follows when parts of the supports move, and the joints that crack, to first order.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    moves : mapping
        Displacement [m], three numbers, of each part of the supports that moves. A part is named by a support block, by
        a group of supports, or by a block or a group that stands on supports, which then move below it alone. Six
        numbers (x0, y0, z0, x1, y1, z1) are a region: the supports move where their joints lie inside that box, which
        must hold each of these joints whole.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    Settlement
        The mechanism, the contact forces, the reaction of every part that moves, and the cracks.

    Raises
    ------
    InputError
        When the assembly does not stand or jams, for a part that is nowhere or that two moves share, for a region that
        cuts a joint of a support, or for an option that does not exist.

    Notes
    -----
    Minimises -w' u over motions that no joint resists, with the supports' displacement given: the state of least
    potential energy. It is of first order: all values are in proportion to the displacement, at the geometry of rest.
    Where several motions have that energy, as in a symmetrical arch whose thrust line touches more edges than a
    mechanism has hinges, the answer is one of their mixtures: `settle_to_collapse` finds the one that goes on.
    Ties move with the supports that move whole, and count with contacts and bonds in the reactions.

    References
    ----------
    Iannuzzo, A., Van Mele, T. and Block, P. (2020). Piecewise rigid displacement (PRD) method. Mechanics Research
    Communications 107.

    Examples
    --------
    A lintel of 2 m on two piers of .5 m. The right one settles by 15 mm. The lintel turns by 1/100: it rests on the
    inner edge of the left pier and on the outer edge of the right one, 1.5 m apart.

    >>> from blockstat import Assembly, box, settle
    >>> piers = [box((x, 0, 0), (x + 0.5, 1, 2), name=name) for x, name in ((0, "left"), (1.5, "right"))]
    >>> lintel = box((0, 0, 2), (2, 1, 2.5), name="lintel")
    >>> found = settle(Assembly.from_blocks([*piers, lintel], supports=["left", "right"]), {"right": (0, 0, -0.015)})
    >>> found.outcome.word, sorted((crack.blocks, round(crack.opening, 5)) for crack in found.cracks())
    ('pushes', [(('left', 'lintel'), 0.005), (('right', 'lintel'), 0.005)])
    """
    options = {"friction": friction, "gravity": gravity, "loads": loads, "gap": gap, "interfaces": interfaces}
    problem, inside = standing(assembly, solver=solver, otherwise=FALLS_ANYWAY, **options)
    if not isinstance(moves, Mapping) or not moves:
        raise InputError(f'"{assembly.name}": no supports move; name them, as in {{"ground": (0, 0, -0.01)}}')
    parts = []
    for where, given in moves.items():
        displacement = check_vector(f"{_called(where)}: displacement", given)
        supports, joints = _part(problem, where)
        parts.append((Foundation(_called(where), displacement, joints, np.zeros(3)), supports))
    counts = np.bincount(np.concatenate([part.joints for part, _ in parts]), minlength=problem.interfaces.n_interfaces)
    if (counts > 1).any():
        names = " and ".join(f'"{problem.assembly.names[i]}"' for i in problem.interfaces.pair[np.argmax(counts)])
        raise InputError(f"two moves share the joint of {names}; let each joint belong to one of them")
    whole, times = np.unique(np.concatenate([supports for _, supports in parts]), return_counts=True)
    if (times > 1).any():
        name = problem.assembly.names[whole[np.argmax(times)]]
        raise InputError(f'two moves share the support "{name}"; let each support belong to one of them')
    return _settled(problem, inside, parts, solver)


@known_options
def settlement(
    assembly: Assembly,
    supports: Sequence[int | str],
    direction: Sequence[float],
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> Settlement:
    """Find mechanism, forces and reaction when supports begin to move along a direction, by a unit of length.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    supports : sequence of str or int
        Names or numbers of support blocks that move together.
    direction : sequence of float, shape (3,)
        Direction of the movement, of any length.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    Settlement
        The mechanism that begins, the contact forces and the reaction of the supports.

    Raises
    ------
    InputError
        When the assembly does not stand, jams, for a block that is no support, or for an option that does not exist.

    Notes
    -----
    `settle` moves several parts by different displacements, and parts of a support.

    Examples
    --------
    One springer of an arch yields outwards: the arch follows, and pushes it along.

    >>> from blockstat import settlement
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> found = settlement(ring, ["springer.right"], (1, 0, 0))
    >>> found.outcome.word, round(found.reaction)
    ('pushes', 2006)
    """
    options = {"friction": friction, "gravity": gravity, "loads": loads, "gap": gap, "interfaces": interfaces}
    problem, inside = standing(assembly, solver=solver, otherwise=FALLS_ANYWAY, **options)
    moving = support_indices(problem.assembly, supports)
    unit = check_vector("direction", direction)
    unit = unit / np.linalg.norm(unit)
    joints = np.flatnonzero(_on_supports(problem) & np.isin(problem.interfaces.pair, moving).any(axis=1))
    part = Foundation("supports", unit, joints, np.zeros(3))
    return replace(_settled(problem, inside, [(part, moving)], solver), foundations=())


def _settled(problem: Problem, inside: Floats, parts: Sequence[tuple[Foundation, Ints]], solver: str) -> Settlement:
    """What follows when parts of the supports move; beside each stand the supports that move whole with it."""
    program = problem.program
    assert program is not None
    size = max(float(np.linalg.norm(part.displacement)) for part, _ in parts)
    moves = [_movement(problem, part.joints, own, part.displacement / size) for part, own in parts]
    rate, whole = (np.sum([move[k] for move in moves], axis=0) for k in (0, 1))
    for answer in optima(program, rate.reshape(-1), solver):
        if answer.status.is_infeasible:
            raise InputError(
                f'"{problem.assembly.name}": the supports cannot move so; the blocks are jammed between them'
            )
        force = admissible(program, certificate.balance(program, answer.force), inside)
        if force is not None:
            break
    else:
        raise InputError(f'"{problem.assembly.name}": no force field of the settling blocks could be proven')
    reactions = [_reaction(problem, part.joints, own, force) for part, own in parts]
    return Settlement(
        mechanism=size * (problem.to_blocks(answer.twist) + whole),
        forces=problem.to_points(force),
        reaction=float(_beyond_rounding(problem, np.array(power_on_supports(problem, rate, whole, force)))),
        interfaces=problem.interfaces,
        assembly=problem.assembly,
        warnings=problem.warnings,
        ties=problem.to_ties(force),
        bonds=problem.to_bonds(force),
        displacement=size,
        foundations=tuple(part._replace(reaction=own) for (part, _), own in zip(parts, reactions, strict=True)),
    )


def _movement(problem: Problem, joints: Ints, supports: Ints, velocity: Floats) -> tuple[Floats, Floats]:
    """Rates of the program by supports that move below some joints, (m, 3), and their motion, (n_blocks, 6)."""
    pair, support = problem.interfaces.pair, problem.assembly.support
    apart, motion = np.zeros((len(pair), 3)), np.zeros((len(support), 6))
    # The velocity of block b against block a: that of the support, or its opposite.
    apart[joints] = np.where(support[pair[joints, 1]], 1.0, -1.0)[:, None] * velocity
    motion[supports, :3] = velocity
    return problem.rates_by_supports(apart, motion), motion


def _reaction(problem: Problem, joints: Ints, supports: Ints, force: Floats) -> Floats:
    """Force of the assembly on a part of the supports, shape (3,) [N]: its power as they move along each axis."""
    moves = [_movement(problem, joints, supports, axis) for axis in np.eye(3)]
    return _beyond_rounding(
        problem, np.array([power_on_supports(problem, rate, motion, force) for rate, motion in moves])
    )


def _beyond_rounding(problem: Problem, reaction: Floats) -> Floats:
    """Reactions, with zero in place of what forces leave of equilibrium."""
    loads = np.linalg.norm(problem.load[~problem.assembly.support, :3], axis=1).sum()
    bound = NO_REACTION * max(float(loads), problem.assembly.free_weight)
    found: Floats = np.where(np.abs(reaction) <= bound, 0.0, reaction)
    return found


def _on_supports(problem: Problem) -> np.ndarray:
    """Interfaces between a support and a free block, shape (n_interfaces,)."""
    return problem.assembly.support[problem.interfaces.pair].sum(axis=1) == 1


def _part(problem: Problem, where: Any) -> tuple[Ints, Ints]:
    """Supports that move whole, and the joints that move with them."""
    assembly, faces = problem.assembly, problem.interfaces
    between = _on_supports(problem)
    if isinstance(where, tuple):
        lower, upper = np.sort(np.asarray(where, dtype=float).reshape(2, 3), axis=0)
        inside = [_lies_in(problem, k, lower, upper, _called(where)) for k in np.flatnonzero(between).tolist()]
        found = np.flatnonzero(between)[np.array(inside, dtype=bool)]
        if not len(found):
            raise InputError(f"{_called(where)}: no joint of a support lies in this box")
        return np.empty(0, dtype=np.int64), found
    named = np.zeros(assembly.n_blocks, dtype=bool)
    if isinstance(where, str) and where not in assembly.names:
        named |= np.array([fits(where, group) for group in assembly.groups])
    if not named.any():
        named[assembly.blocks_named(where, "foundations")] = True
    # A group that holds supports and what stands on them means the supports.
    supports = np.flatnonzero(named & assembly.support)
    sides = named & assembly.support if len(supports) else named
    found = np.flatnonzero(between & sides[faces.pair].any(axis=1))
    ends = tied_pairs(assembly)
    anchors = ends[~assembly.support[ends].all(axis=1)]
    if not len(found) and not np.isin(anchors, supports).any():
        what = "nothing rests on it or is tied to it" if len(supports) else "it does not stand on a support"
        raise InputError(f"{_called(where)}: {what}, so no support can move there")
    return supports, found


def _lies_in(problem: Problem, joint: int, lower: Floats, upper: Floats, called: str) -> bool:
    """Whether a joint lies in a box, or beside it; one that lies partly in it is refused."""
    assembly, pair = problem.assembly, problem.interfaces.pair[joint]
    corners = problem.interfaces.outline(joint)
    low, high = corners.min(axis=0), corners.max(axis=0)
    slack = ROUNDING * float(assembly.size[pair[~assembly.support[pair]]].min())
    beyond = np.maximum(lower - low, high - upper)
    if (beyond <= slack).all():
        return True
    # Where the joint is flat it may lie in a face of the box; where it is wide, touching a face is to lie beside it.
    margin = np.where(high - low > 2 * slack, slack, -slack)
    if not len(_cut_to(corners, lower + margin, upper - margin)):
        return False
    k = int(np.argmax(beyond))
    a, b = (assembly.names[block] for block in pair)
    ends = np.round([[low[k], high[k]], [lower[k], upper[k]]], 9) + 0.0  # no -0
    joint_ends, box_ends = (f"from {one:.7g} to {two:.7g} m" for one, two in ends)
    raise InputError(
        f'{called}: the joint of "{a}" and "{b}" lies partly in this box: it is {joint_ends} in {"xyz"[k]}, the box '
        f"{box_ends}; the box must hold whole joints, so divide the support or the block there, or take a box that "
        "holds the joint"
    )


def _cut_to(corners: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return the corners of the part of a convex polygon, or of a line, that lies in a box."""
    for axis in range(3):
        for side, bound in ((1.0, lower[axis]), (-1.0, upper[axis])):
            inside = side * (corners[:, axis] - bound)
            follow, then = np.roll(corners, -1, axis=0), np.roll(inside, -1)
            crossed = inside * then < 0
            share = inside / np.where(crossed, inside - then, 1.0)
            both = np.stack([corners, corners + share[:, None] * (follow - corners)], axis=1)
            corners = both[np.stack([inside >= 0, crossed], axis=1)]
    return corners


def _called(where: Any) -> str:
    if isinstance(where, tuple):
        if numbers(where).shape != (6,) or not np.isfinite(numbers(where)).all():
            raise InputError(f"a region is {where!r}; it must be six numbers, x0, y0, z0, x1, y1, z1")
        return f"region ({_numbers(where)})"
    if not isinstance(where, (str, int, np.integer)):
        raise InputError(f"a part that moves is {where!r}; it must be a block, a group or the six numbers of a region")
    return f'"{where}"'


def _numbers(values: Any) -> str:
    return ", ".join(f"{float(part):.4g}" for part in values)
