"""What the statics return."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.coulomb import CoulombState
from blockstat.certificate.check import FORCE_LIMIT, FORCE_TOLERANCE, Certificate
from blockstat.contact.interfaces import Interfaces
from blockstat.contact.point_law import joint_friction, point_law
from blockstat.geometry.polyhedron import point_velocity
from blockstat.loads import Loads
from blockstat.program.bonds import Bonds
from blockstat.result import Result, Sentence, counted, finite, listed
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


#: What is said in place of "stable" where a Coulomb state exists in some joints and not in others.
HANGS = (
    "Stable in some joints only: without dilatancy and self-stress the blocks stand or fall with how tight the joints "
    "are. A fall is not excluded."
)
#: What is said in place of "no displacement was found" where blocks fall freely: in some joints there may be one.
FALLS = "Stable only by self-stress: a force field exists, but blocks fall freely from joints that nothing has pressed."
UNTRIED = "Other tightnesses of the joints were not tried (tightnesses=12)."
#: What a plain "stable" leaves open, and what answers it.
CAVEAT = "Friction is associated and self-stress counts: real joints may carry less"
ASSOCIATED = f'{CAVEAT} (see flow="coulomb").'


class Outcome(Sentence):
    """The static answers; each value is the sentence a user reads."""

    STABLE = "Stable: a force field within every friction cone balances every block."
    STABLE_ONLY_BY_SELF_STRESS = (
        "Stable only by self-stress: a force field exists, but no displacement of the blocks was found that causes one."
    )
    UNSTABLE = "Unstable: no admissible force field exists; the blocks move as the mechanism shows."
    UNDECIDED = "Undecided: too close to the limit to prove either way at the accuracy of the numbers."


@dataclass(frozen=True, eq=False)
class Verdict(Result):
    """A static verdict with the evidence for it.

    Stable is a statement about forces: an admissible field exists. Friction is not associated and jammed
    blocks can hold themselves on paper, so it does not promise rest; unstable does promise motion.
    """

    outcome: Outcome
    #: sqrt(sum s_i^2) / sum of the forces on the free blocks (their weight, without loads and ties of given force):
    #: adhesion missing, 0 for stable, inf if none helps, nan where an earlier mechanism decided (see
    #: `blockstat.analysis.certificate_cache`)
    score: float
    forces: Floats  #: shape (n_points, 3) [N], (f_n, f_1, f_2) on block b in the frame of the interface
    adhesion: Floats  #: shape (n_points,) [N], tension that point would have to carry; 0 for stable
    mechanism: Floats  #: shape (n_blocks, 6), velocity [m] and rotation [rad], scaled to move the fastest corner by 1 m
    certificate: Certificate
    interfaces: Interfaces
    assembly: Assembly
    solver: str
    timings: dict[str, float] = field(default_factory=dict)  #: process seconds of each step
    floating: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))  #: blocks that nothing holds
    #: blocks of a stable assembly that a motion moves at no cost, as on one edge: nothing resists a small push
    neutral: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    warnings: tuple[str, ...] = ()
    flow: str = "associated"  #: the flow rule asked for, "associated" or "coulomb"
    coulomb: CoulombState | None = None  #: what a "coulomb" verdict rests on, if more than a force field was needed
    #: displacements that cause `forces` in a Coulomb state, scaled like `mechanism`, shape (n_blocks, 6); None without
    displacement: Floats | None = None
    held: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))  #: interfaces held only by self-stress
    #: blocks that fall freely from joints that nothing has pressed: a proof that only self-stress holds them
    falling: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    bonds: Bonds | None = None  #: what the bonds at the centres of joints carry with `forces`
    ties: Floats | None = None  #: tension of each tie, or compression of each strut, with `forces`, (n_ties,) [N]
    loads: Loads | None = None  #: permanent loads beside the weight that it was found under, of the worst case
    worst: str = ""  #: the case of the imperfections that this verdict is of, the worst one, in words
    because: str = ""  #: what leaves an answer undecided, in words; empty where it is the accuracy of the numbers

    @property
    def motion(self) -> Floats:
        """Fastest corner of each block under the mechanism, shape (n_blocks,), 1 for the fastest block."""
        return corner_speed(self.assembly, self.mechanism)

    @property
    def moving(self) -> Ints:
        """Blocks that move in the mechanism, fastest first."""
        return fastest_first(self.assembly, self.mechanism)

    @property
    def headline(self) -> str:
        """The sentence of the outcome, and what a Coulomb state leaves open: other joints may have none."""
        if len(self.falling) and self.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS:
            return FALLS
        if self.outcome is Outcome.UNDECIDED and self.because:
            return f"Undecided: {self.because}."
        if self.outcome is not Outcome.STABLE or self.coulomb is None:
            return self.outcome.value
        if self.coulomb.hangs:
            return HANGS
        return f"{self.outcome.value} {UNTRIED}" if np.isnan(self.coulomb.tightness) else self.outcome.value

    def demand(self) -> Floats:
        """Return how hard friction and strength are used at each block in the force field found.

        Returns
        -------
        Floats
            Shape (n_blocks,), 0 to 1 (1: at the limit).

        Notes
        -----
        It is the largest `|f_t| / (mu f_n + c)`, or pressure over strength, over points that carry at least 1 % of the
        block's largest force. A joint without friction uses none. Other admissible force fields have other values.
        """
        points = self.interfaces.point_interface
        law = point_law(self.assembly, self.interfaces)
        force = self.forces + law.shift[:, None] * np.array([1.0, 0.0, 0.0])
        tangent = np.hypot(force[:, 1], force[:, 2])
        with np.errstate(divide="ignore", invalid="ignore"):
            used = np.where(force[:, 0] > 0, np.minimum(tangent / (law.friction * force[:, 0]), 1.0), 1.0)
            used[(force[:, 0] > 0) & (law.friction == 0)] = 0.0
            crushed = np.where(np.isinf(law.cap), 0.0, self.forces[:, 0] / (law.cap - law.shift))
        used = np.clip(np.maximum(used, crushed), 0.0, 1.0)
        size = np.linalg.norm(force, axis=1)
        result = np.zeros(self.assembly.n_blocks)
        for side in self.interfaces.pair[points].T:
            largest = np.zeros(self.assembly.n_blocks)
            np.maximum.at(largest, side, size)
            real = size > 0.01 * largest[side]
            np.maximum.at(result, side[real], used[real])
        return result

    def explain(self, limit: int = 5) -> str:
        """Return the verdict in words: the outcome, the evidence, and the blocks that move first.

        Parameters
        ----------
        limit : int, optional
            Most blocks that are named.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.headline, *([f"Worst case of the imperfections: {self.worst}."] if self.worst else [])]
        proof = self.certificate
        if self.outcome in (Outcome.STABLE, Outcome.STABLE_ONLY_BY_SELF_STRESS):
            lines.append(
                f"Largest residual {proof.residual:.1e} of a block's load, "
                f"cones violated by {proof.cone_violation:.1e}."
            )
            lines.append(f"Normal forces of {proof.total_force:.3g} times the weight in total.")
            if proof.residual > FORCE_TOLERANCE:
                lines.append(f"Without rounding of the forces on a block, residuals are {proof.imbalance:.1e}.")
            if self.flow == "associated":
                lines.append(ASSOCIATED)
        else:
            lines += self._missing_words(limit)
        lines += self._settling_words(limit)
        if len(self.floating):
            names = listed([self.assembly.names[i] for i in self.floating], limit)
            lines.append(f"{'No joint' if self._by_contacts else 'Nothing'} holds: {names}.")
        if words := self.interfaces.contact_words:
            lines.append(f"Contacts: {words}.")
        lines += [f"Warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    @property
    def _by_contacts(self) -> bool:
        """Whether contacts that are no joints leave the answer undecided."""
        return self.outcome is Outcome.UNDECIDED and bool(self.because) and self.coulomb is None

    def _missing_words(self, limit: int) -> list[str]:
        """What is known of blocks that no force field was found to balance, one fact a line."""
        lines, proof, joints = [], self.certificate, self._by_contacts
        if self.score > 0 and not (joints and np.isinf(self.score)):
            # Not where an earlier mechanism decided, and not where none is missing.
            lines.append(f"Residual tension (score): {self.score:.3g} of the weight.")
        if proof.required_force < FORCE_LIMIT:
            lines.append(f"Any equilibrium would need {proof.required_force:.3g} times the weight in normal forces.")
        elif np.isfinite(proof.required_force):  # such forces balance anything, by their rounding
            of = " of the joints" if joints else ""
            lines.append(f"No normal forces{of} balance the blocks, even of {FORCE_LIMIT:,.0f} times the weight.")
        elif joints:
            lines.append("No normal forces of the joints, however large, balance the blocks.")
        else:
            lines.append("No normal forces at all, however large, balance the blocks.")
        if self.outcome is Outcome.UNDECIDED and not joints:
            lines.append(
                f"Best force field: residual {proof.residual:.1e}, cones violated by {proof.cone_violation:.1e}."
            )
        if len(self.moving):
            lines.append(first_words(self.assembly, self.moving, limit=limit))
            lines += motion_words(self.assembly, self.interfaces, self.mechanism, limit=limit)
        return lines

    def _settling_words(self, limit: int) -> list[str]:
        """What was found out about friction without dilatancy and self-stress, one fact a line."""
        lines, names = [], self.assembly.names
        if self.coulomb is not None:
            lines.append(self.coulomb.explain())
        if len(self.held):
            pairs = self.interfaces.pair[self.held]
            blocks = len(np.unique(pairs[~self.assembly.support[pairs]]))
            joints = listed([f"{names[a]}-{names[b]}" for a, b in pairs], limit)
            lines.append(f"Held so: {blocks} of {len(self.assembly.free)} blocks, at the joints {joints}.")
        if self.coulomb is not None and len(self.coulomb.clamped):
            clamped = listed([names[i] for i in self.coulomb.clamped], limit)
            lines.append(f"Held by others that press on them as joints give way, and free to fall else: {clamped}.")
        if len(self.falling):
            falling = listed([names[i] for i in self.falling], limit)
            lines.append(f"Proof: none of their joints closes when they fall freely, so none resists: {falling}.")
        return lines

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; an infinite score or force is None.

        Returns
        -------
        dict
            Values by name.
        """
        proof = self.certificate
        return {
            "outcome": self.outcome.word,
            "sentence": self.headline,
            "score": finite(self.score),
            "moving": [self.assembly.names[i] for i in self.moving],
            "floating": [self.assembly.names[i] for i in self.floating],
            "neutral": [self.assembly.names[i] for i in self.neutral],
            "certificate": {
                "residual": finite(proof.residual),
                "cone_violation": finite(proof.cone_violation),
                "work": finite(proof.work),
                "mechanism_violation": finite(proof.mechanism_violation),
                "required_force": finite(proof.required_force),
                "imbalance": finite(proof.imbalance),
                "total_force": finite(proof.total_force),
            },
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "contacts": self.interfaces.contacts,
            "contact_points": self.interfaces.n_points,
            "dropped": len(self.interfaces.dropped),
            "solver": self.solver,
            "flow": self.flow,
            "held": [[self.assembly.names[i] for i in pair] for pair in self.interfaces.pair[self.held]],
            "falling": [self.assembly.names[i] for i in self.falling],
            "held_share": None if self.coulomb is None else self.coulomb.share,
            "tightness": None if self.coulomb is None else finite(self.coulomb.tightness),
            "imperfections": self.worst or None,
            "warnings": list(self.warnings),
            "timings": self.timings,
        }


#: Motions at a joint below this share of its largest are none: those of a mechanism are exact to 1e-6 or so.
STILL = 0.02


def motion_words(assembly: Assembly, interfaces: Interfaces, mechanism: Floats, *, limit: int = 5) -> list[str]:
    """Say how a mechanism moves the joints: which open as hinges, where blocks slide, and which part.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Their joints.
    mechanism : array of float, shape (n_blocks, 6)
        Twists of the blocks, of any size.
    limit : int, optional
        Most joints that are named of each kind, those that move most.

    Returns
    -------
    list of str
        A sentence for each kind of motion that occurs.

    Notes
    -----
    Let a point open by `g_n` and slip by `g_t`. An admissible mechanism has `g_n >= mu g_t`, with equality where the
    point does work against friction. A joint slides when the point that opens least for its slip does so by friction
    alone and slips, opens as a hinge when that point rests, and parts when it opens by more.
    """
    points, pair = interfaces.point_interface, interfaces.pair[interfaces.point_interface]
    velocity = [point_velocity(assembly, mechanism, side, interfaces.point) for side in pair.T]
    local = np.einsum("pij,pj->pi", interfaces.frame[points], velocity[1] - velocity[0])
    slip = np.hypot(local[:, 1], local[:, 2])
    friction = point_law(assembly, interfaces).friction
    excess = local[:, 0] - np.where(slip > 0, np.minimum(friction, 1e9) * slip, 0.0)
    size = np.linalg.norm(local, axis=1)
    largest = np.maximum.reduceat(size, interfaces.start[:-1]) if len(size) else size
    found: dict[str, list[int]] = {"slide": [], "hinge": [], "part": []}
    for joint in np.argsort(-largest, kind="stable"):
        if largest[joint] <= STILL * largest.max():
            break
        own = slice(interfaces.start[joint], interfaces.start[joint + 1])
        resting = excess[own] <= STILL * largest[joint]
        slides = slip[own][resting].max(initial=0.0) > STILL * largest[joint]
        found["slide" if slides else "hinge" if resting.any() else "part"].append(int(joint))
    words = {"slide": "Slides at", "hinge": "Opens as a hinge at", "part": "Parts at"}
    return [f"{words[kind]} {_joints(assembly, interfaces, own, limit)}." for kind, own in found.items() if own]


def _joints(assembly: Assembly, interfaces: Interfaces, joints: list[int], limit: int) -> str:
    """Names of the two blocks of some joints."""
    named = ", ".join(f"{assembly.names[a]} | {assembly.names[b]}" for a, b in interfaces.pair[joints[:limit]])
    return named + (f" and {counted(len(joints) - limit, 'joint')} more" if len(joints) > limit else "")


def fastest_first(assembly: Assembly, mechanism: Floats) -> Ints:
    """Return the blocks that move in a mechanism, fastest first.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    mechanism : array of float, shape (n_blocks, 6)
        Twists of the blocks; the fastest corner moves by 1 m.

    Returns
    -------
    array of int
        Those of which a corner moves by more than 0.01 m.
    """
    speed = corner_speed(assembly, mechanism)
    order = np.argsort(-speed, kind="stable")
    return order[speed[order] > 0.01]


def first_words(assembly: Assembly, moving: Ints, *, limit: int = 5) -> str:
    """Name the blocks that move first.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    moving : array of int
        What `fastest_first` returns.
    limit : int, optional
        Most blocks that are named.

    Returns
    -------
    str
        One sentence.
    """
    return f"First to move: {listed([assembly.names[i] for i in moving], limit)}."


def mechanism_words(assembly: Assembly, joints: dict[str, list[tuple[str, str]]], moving: Ints) -> list[str]:
    """Tell the joints and the blocks that move in a mechanism.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    joints : dict of str to list of tuple of str
        What `moving_joints` returns.
    moving : array of int
        What `fastest_first` returns.

    Returns
    -------
    list of str
        One sentence a line.
    """
    lines = [f"Joints of the mechanism: {', '.join(joint_counts(joints))}."]
    return [*lines, first_words(assembly, moving)] if len(moving) else lines


def moving_joints(
    assembly: Assembly, interfaces: Interfaces, mechanism: Floats, tolerance: float
) -> dict[str, list[tuple[str, str]]]:
    """Return the joints that move in a mechanism, as `LimitLoad.joints` names them.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Their joints.
    mechanism : array of float, shape (n_blocks, 6)
        Twists of the blocks; the fastest corner moves by 1 m.
    tolerance : float
        Of motion [m].

    Returns
    -------
    dict of str to list of tuple of str
        "hinges", "sliding" and "opening" pairs of block names.
    """
    found: dict[str, list[tuple[str, str]]] = {"hinges": [], "sliding": [], "opening": []}
    rate = relative_motion(assembly, interfaces, mechanism)
    friction = np.minimum(joint_friction(assembly, interfaces), 1e3)
    a, b = interfaces.pair.T
    turning = np.linalg.norm(mechanism[b, 3:] - mechanism[a, 3:], axis=1)
    size = assembly.size[interfaces.pair].min(axis=1)
    turns = (interfaces.area == 0) & (turning * size > tolerance)
    for k, pair in enumerate(interfaces.pair):
        own = rate[interfaces.start[k] : interfaces.start[k + 1]]
        slide = np.hypot(own[:, 1], own[:, 2])
        contact = own[:, 0] - friction[k] * slide <= tolerance
        still = bool(np.abs(own).max(initial=0.0) <= tolerance)
        if still and not turns[k]:
            continue
        kind = "sliding" if contact.all() and not still else "hinges" if contact.any() else "opening"
        found[kind].append((assembly.names[pair[0]], assembly.names[pair[1]]))
    return found


def joint_counts(joints: Mapping[str, Sequence[tuple[str, str]]]) -> list[str]:
    """Return how many joints of each kind move, in words.

    Parameters
    ----------
    joints : mapping of str to sequence
        As of `moving_joints`.

    Returns
    -------
    list of str
        One entry a kind.

    Examples
    --------
    >>> from blockstat.analysis.verdict import joint_counts
    >>> joint_counts({"hinges": [("pier", "slab")], "sliding": []})
    ['1 hinge', '0 sliding']
    """
    return [
        f"{len(pairs)} {'hinge' if (kind, len(pairs)) == ('hinges', 1) else kind}" for kind, pairs in joints.items()
    ]


def corner_speed(assembly: Assembly, twist: Floats) -> Floats:
    """Return the largest corner velocity of each block under twists.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    twist : array of float, shape (n_blocks, 6)
        Velocity of the centroid [m/s] and angular velocity [rad/s] of each block.

    Returns
    -------
    array of float, shape (n_blocks,)
        Speeds [m/s].
    """
    velocity = point_velocity(assembly, twist, assembly.vertex_block, assembly.vertices)
    return np.maximum.reduceat(np.linalg.norm(velocity, axis=1), assembly.vertex_start[:-1])


def unit_motion(assembly: Assembly, mechanism: Floats) -> Floats:
    """Scale a mechanism so that the fastest corner moves by 1 m.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    mechanism : array of float, shape (n_blocks, 6)
        Twists of the blocks, of any size.

    Returns
    -------
    array of float, shape (n_blocks, 6)
        The scaled twists; zero stays zero.
    """
    if not mechanism.any():
        return mechanism
    return mechanism / corner_speed(assembly, mechanism).max()


def relative_motion(assembly: Assembly, interfaces: Interfaces, mechanism: Floats) -> Floats:
    """Return the velocity of block b against block a at each contact point.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        The joints.
    mechanism
        Velocity and rotation of each block, shape (n_blocks, 6) [m/s, rad/s].

    Returns
    -------
    Floats
        In the frame (n, t1, t2) of each joint, shape (n_points, 3) [m/s]; positive normal velocities open.
    """
    k = interfaces.point_interface
    a, b = (point_velocity(assembly, mechanism, side, interfaces.point) for side in interfaces.pair[k].T)
    return np.einsum("nij,nj->ni", interfaces.frame[k], b - a)
