"""Supports that move: what follows, which joints crack, and what holds the supports back.

A foundation is the part of the supports that moves as one: whole support blocks, or only where some blocks stand on
them, or only inside a region. So one slab of ground may settle in part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.reserve import moved, resting_warning
from blockstat.analysis.thrust import admissible, optima, power_on_supports, standing, standing_on, support_indices
from blockstat.analysis.verdict import corner_speed, relative_motion
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_vector, known_options
from blockstat.loads import Loads
from blockstat.program.bonds import Bonds
from blockstat.result import Result, Sentence, counted, finite, listed, plain
from blockstat.studies.moving_supports import Foundation, in_words, on_supports, parts_that_move
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Blocks whose fastest corner moves by less than this, relative to the movement of the supports, are at rest.
MOVING = 0.01
#: Joints that open or slide by less than this, relative to the movement of the supports, stay shut.
SHUT = 1e-4
#: A reaction smaller than this, relative to all loads, is none: what forces leave of equilibrium.
NO_REACTION = 1e-9
FALLS_ANYWAY = "it falls without any movement of its supports"  #: says what does not stand


class SettlementOutcome(Sentence):
    """The answers of `settlement` and `settle`; each value is the sentence a user reads."""

    PUSHES = "Pushes: the assembly pushes the moving supports along."
    RESISTS = "Resists: the assembly pushes against the movement of the supports."
    FREE = "Free: the assembly neither pushes the moving supports along nor resists their movement."


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
        for name, displacement, joints, reaction in self.foundations:
            lines.append(
                f"{name} moves by ({in_words(1e3 * displacement)}) mm with {counted(len(joints), 'joint')} on it, and "
                f"carries ({in_words(reaction)}) N."
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
                    "displacement": [float(part) for part in displacement],
                    "reaction": [float(part) for part in reaction],
                    "joints": len(joints),
                }
                for name, displacement, joints, reaction in self.foundations
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
    return _settled(problem, inside, lambda own: parts_that_move(own, moves), loads, solver)


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

    def parts(problem: Problem) -> list[tuple[Foundation, Ints]]:
        joints = np.flatnonzero(on_supports(problem) & np.isin(problem.interfaces.pair, moving).any(axis=1))
        return [(Foundation("supports", unit, joints, np.zeros(3)), moving)]

    return replace(_settled(problem, inside, parts, loads, solver), foundations=())


def _settled(
    problem: Problem,
    inside: Floats,
    parts: Callable[[Problem], list[tuple[Foundation, Ints]]],
    loads: Loads | None,
    solver: str,
) -> Settlement:
    """What follows when parts of the supports move, with the doubtful joints that the reaction rests on."""
    found = _follows(problem, inside, parts(problem), solver)

    def again(joints: Interfaces) -> float | None:
        stood = standing_on(problem, joints, loads, solver)
        try:
            return None if stood is None else _follows(*stood, parts(stood[0]), solver).reaction
        except InputError:  # nothing that is left stands on a part, or no forces are proven
            return None

    thin = resting_warning(
        problem, found.forces, found.reaction, again,
        f"the force on the moving supports is {found.reaction:.6g} N",
        worse=lambda bare, last: moved(bare, last, _no_reaction(problem)),
        words=lambda bare: f"it is {bare:.6g} N",
        falls="it is not known",
    )  # fmt: skip
    return replace(found, warnings=(*found.warnings, *thin))


def _follows(problem: Problem, inside: Floats, parts: Sequence[tuple[Foundation, Ints]], solver: str) -> Settlement:
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
    found: Floats = np.where(np.abs(reaction) <= _no_reaction(problem), 0.0, reaction)
    return found


def _no_reaction(problem: Problem) -> float:
    """What forces leave of equilibrium [N]."""
    loads = np.linalg.norm(problem.load[~problem.assembly.support, :3], axis=1).sum()
    return NO_REACTION * max(float(loads), problem.assembly.free_weight)
