"""Pose the equilibrium problem of an assembly: check the input, find the joints, set up the program."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.assembly import check_supports
from blockstat.certificate.interior_motions import expansions
from blockstat.contact.cells import refine
from blockstat.contact.interfaces import Interfaces
from blockstat.contact.overlap.searched import searched_joints
from blockstat.contact.point_law import joint_friction, keeps_friction, kept_friction, last_law, point_law
from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import point_velocity
from blockstat.imperfection.imperfections import Imperfections, Realisation, realisations
from blockstat.loads import Loads, WeightedLoads, check_size
from blockstat.program.bonds import KINDS, Bonds, bond_columns, bond_forces, bonded
from blockstat.program.equilibrium import Equilibrium, equilibrium, split_floating, weight
from blockstat.program.given_joints import check_given
from blockstat.program.penalty import PenaltyProgram, penalty_program
from blockstat.program.planar import find_plane
from blockstat.program.ties import check_anchors, given_wrenches, tie_columns, tied_pairs
from blockstat.surface.distance import smallest_gap
from blockstat.surface.facets import facets
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact.unresolved import Unresolved

#: A contact that closes at less than this, where the fastest corner moves at 1, does not close: rounding.
CLOSING = 1e-9


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything the solvers and the certificates need, and what was noticed on the way."""

    assembly: Assembly
    interfaces: Interfaces
    load: Floats  #: dead load on each block, shape (n_blocks, 6) [N, N m]
    eq: Equilibrium  #: of the blocks that a chain of joints ties to a support
    program: PenaltyProgram | None  #: None when there is no such block
    floating: Ints  #: blocks that nothing holds
    gap: float | str
    warnings: tuple[str, ...]
    timings: dict[str, float]
    bonds: Ints  #: interfaces with a bond at their centre, whose columns follow the contact points
    #: pairs of blocks that overlap too far to have a joint, shape (n, 2); None: to be looked for when it matters
    overlapping: Ints | None = None
    #: gives the contacts without a unique normal, if they are known already; None: to be looked for when it matters
    unresolved: Callable[[], Unresolved] | None = None
    #: ties of the assembly whose forces are unknowns; their columns follow those of the bonds
    ties: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    undivided: Interfaces | None = None  #: the joints before joint laws divided them into cells; None: they did not
    given: Interfaces | None = None  #: the joints as found or given, for another problem on the same blocks

    def warnings_with(self, others: Iterable[str]) -> tuple[str, ...]:
        """Return the warnings of this problem and others, each once.

        Parameters
        ----------
        others
            Of the same problem in another case.

        Returns
        -------
        tuple of str
            In their order.
        """
        return tuple(dict.fromkeys((*self.warnings, *others)))

    def to_blocks(self, twist: Floats) -> Floats:
        """Return a scaled twist as velocities and rotations of all blocks.

        Parameters
        ----------
        twist
            Of the program, shape (6 n,).

        Returns
        -------
        Floats
            Shape (n_blocks, 6) [m, rad].
        """
        mechanism = np.zeros((self.assembly.n_blocks, 6))
        if self.program is not None:
            mechanism[self.eq.blocks] = twist.reshape(-1, 6) / np.repeat([1.0, self.program.length_unit], 3)
        return mechanism

    def to_points(self, force: Floats) -> Floats:
        """Return scaled forces as contact forces at all points.

        Parameters
        ----------
        force
            Of the program, shape (m, 3).

        Returns
        -------
        Floats
            Shape (n_points, 3) [N], tension below zero.
        """
        forces = np.zeros((self.interfaces.n_points, 3))
        if self.program is not None:
            n = self.program.n_points
            forces[self.eq.points] = force[:n] * self.program.force_unit
            forces[self.eq.points, 0] -= self.program.shift[:n] * self.program.force_unit
        return forces

    def to_bonds(self, force: Floats) -> Bonds | None:
        """Return what the bonds carry under scaled forces.

        Parameters
        ----------
        force
            Of the program, shape (m, 3).

        Returns
        -------
        Bonds or None
            None without bonds.
        """
        if self.program is None or not len(self.bonds):
            return None
        first, count = self.program.n_points, KINDS * len(self.bonds)
        return bond_forces(self.interfaces, self.bonds, force[first : first + count] * self.program.force_unit)

    def to_ties(self, force: Floats) -> Floats | None:
        """Return the forces of the ties under scaled forces.

        Parameters
        ----------
        force
            Of the program, shape (m, 3).

        Returns
        -------
        Floats or None
            Tension, or compression of struts, shape (n_ties,) [N]; None without ties.
        """
        if not self.assembly.ties:
            return None
        found = np.array([tie.least for tie in self.assembly.ties], dtype=float)
        if self.program is not None and len(self.ties) and len(force):
            found[self.ties] = force[-len(self.ties) :, 0] * self.program.force_unit
        return found

    def rates_by_supports(self, apart: Floats, motion: Floats) -> Floats:
        """Return the rates of contact points, bonds and ties by a movement of the supports alone.

        Parameters
        ----------
        apart
            Velocity of block b against block a by that movement at each joint, shape (n_interfaces, 3).
        motion
            Of the supports that move whole, which carry the ends of ties, shape (n_blocks, 6); zero elsewhere.

        Returns
        -------
        Floats
            Of the columns of the program, shape (m, 3).
        """
        of_joints = [self.interfaces.point_interface[self.eq.points]]
        of_joints += [np.repeat(self.bonds, KINDS)] if len(self.bonds) else []
        velocity = [apart[joint] for joint in of_joints]
        ends = [motion[columns.pair, :3] for columns in self.eq.columns[len(velocity) :]]
        velocity += [end[:, 1] - end[:, 0] for end in ends]
        pairs = zip(self.eq.columns, velocity, strict=True)
        return np.concatenate([np.einsum("nij,nj->ni", columns.force, moved) for columns, moved in pairs])

    def adhesion_at_points(self, adhesion: Floats) -> Floats:
        """Return scaled missing adhesion at all contact points.

        Parameters
        ----------
        adhesion
            Of the program, shape (n,).

        Returns
        -------
        Floats
            Shape (n_points,) [N].
        """
        values = np.zeros(self.interfaces.n_points)
        if self.program is not None:
            values[self.eq.points] = adhesion * self.program.force_unit
        return values

    def motions(self) -> tuple[Floats, ...]:
        """Return twists of the program that may open every joint.

        They are made when first asked for.

        Returns
        -------
        tuple of Floats
            Shape (6 n,) each.
        """
        return self._expansions

    @cached_property
    def _expansions(self) -> tuple[Floats, ...]:
        return expansions(self.assembly, self.interfaces, self.eq.blocks)

    @property
    def strengths(self) -> list[str]:
        """What is said of a load that is carried without bound, where strengths of joints or ties bound it."""
        of_joints = any(law.strong or law.compression for law in self.assembly.joints)
        of_ties = any(np.isfinite(self.assembly.ties[k].greatest) for k in self.ties)
        what = " and ".join(name for name, has in (("joints", of_joints), ("ties", of_ties)) if has)
        told = f"{what} have strengths, which bound the load far beyond the weight: it was not followed so far"
        return [told] if what else []

    @property
    def slips(self) -> bool:
        """Whether a joint has friction. Without any, flow is normal to the joints whatever is asked for."""
        return self.program is not None and bool((self.program.friction > 0).any())

    def scaled(self, load: Floats) -> Floats:
        """Return a wrench on each block as a load of the program.

        Parameters
        ----------
        load
            Shape (n_blocks, 6) [N, N m].

        Returns
        -------
        Floats
            Shape (6 n,).
        """
        assert self.program is not None
        unit = np.repeat([1.0, self.program.length_unit], 3) * self.program.force_unit
        return (load[self.eq.blocks] / unit).reshape(-1)


def pose(
    assembly: Assembly,
    *,
    friction: float | None,
    gravity: Any,
    loads: Loads | None,
    gap: float | str,
    interfaces: Interfaces | None,
    displaced: bool = False,
) -> Problem:
    """Check the input, find the joints and set up the program.

    Parameters
    ----------
    assembly, friction, gravity, loads, gap, interfaces
        As in `blockstat.assess`.
    displaced
        Whether the given joints are those of blocks that have moved, whose points need not be near both blocks.

    Returns
    -------
    Problem
        The joints, the equilibrium and the penalty program, with warnings and times.

    Raises
    ------
    InputError
        When nothing supports the assembly, when blocks overlap, for loads of the wrong shape, or for joints that cannot
        be those of the assembly.
    """
    changes = {k: v for k, v in (("friction", friction), ("gravity", gravity)) if v is not None}
    assembly = assembly.with_(**changes) if changes else assembly
    check_supports(assembly)
    if not isinstance(interfaces, Interfaces | None):
        raise InputError(f"interfaces is {interfaces!r}; it must be what find_interfaces returns")
    if interfaces is not None:
        check_given(assembly, interfaces, displaced=displaced)
    if interfaces is None or not interfaces.moved:
        check_anchors(assembly)
    load = weight(assembly) + checked_loads(assembly, loads) + given_wrenches(assembly)
    pairs = tied_pairs(assembly)
    timings: dict[str, float] = {}
    warnings: list[str] = []
    undivided = overlapping = None
    with timed(timings, "interfaces"):
        if interfaces is None:
            interfaces, overlapping, told = searched_joints(assembly, gap)
            warnings += told
        given = interfaces
        warnings += unheeded(assembly, given) if friction is not None else []
        if assembly.joints:
            if interfaces.share is None:
                undivided, interfaces = interfaces, _divided(assembly, interfaces)
            lost = _crushed(assembly, interfaces)
            if lost.any():
                crushed = (*interfaces.crushed, interfaces.subset(lost))
                interfaces = replace(interfaces.subset(~lost), crushed=crushed)
        if interfaces.crushed:
            warnings += _crushed_warnings(assembly, interfaces.crushed)
    with timed(timings, "equilibrium"):
        held, floating = split_floating(assembly, np.concatenate([interfaces.pair, pairs]))
        touched = np.any(np.isin(interfaces.pair, held), axis=1)
        points = np.flatnonzero(touched[interfaces.point_interface])
        unknown = np.array([not tie.constant for tie in assembly.ties], dtype=bool)
        ties = np.flatnonzero(np.isin(pairs, held).any(axis=1) & unknown) if assembly.ties else np.empty(0, np.int64)
        eq, program, bonds = _program(assembly, interfaces, load, held, points, touched, ties)
    warnings += _floating_warnings(assembly, floating, interfaces)
    if assembly.support.all():
        warnings.append("all blocks are supports; there was nothing to check")
    return Problem(
        assembly, interfaces, load, eq, program, floating, gap, tuple(warnings), timings, bonds, overlapping,
        ties=ties, undivided=undivided, given=given,
    )  # fmt: skip


def with_joints(problem: Problem, interfaces: Interfaces, loads: Loads | None) -> Problem:
    """Pose a problem again on other joints of its blocks.

    Parameters
    ----------
    problem
        The problem.
    interfaces
        The joints.
    loads
        Those that it was posed with.

    Returns
    -------
    Problem
        With the overlaps of the blocks, if they are known.
    """
    options = {"friction": None, "gravity": None, "gap": problem.gap}
    other = pose(problem.assembly, loads=loads, interfaces=interfaces, **options)
    return replace(other, overlapping=problem.overlapping)


def unheeded(assembly: Assembly, interfaces: Interfaces) -> list[str]:
    """Return what is said where joints have another friction than the one that is asked for.

    Parameters
    ----------
    assembly : Assembly
        With the friction that is asked for.
    interfaces : Interfaces
        Its joints.

    Returns
    -------
    list of str
        How many joints keep a friction of their own and whose it is; nothing where none does.
    """
    kept = keeps_friction(assembly, interfaces) & (joint_friction(assembly, interfaces) != assembly.friction)
    count = f"a friction of {assembly.friction:g} is asked for, and {kept.sum()} of {len(kept)} joints"
    return [f"{count} {kept_friction(assembly, interfaces, kept)}"] if kept.any() else []


def cases_of(problem: Problem, loads: Loads | None, imperfections: Imperfections) -> Iterator[Realisation]:
    """Give the cases among which the worst one of some imperfections is.

    Parameters
    ----------
    problem
        The problem as drawn.
    loads
        The permanent loads that it was posed with.
    imperfections
        What is allowed for.

    Yields
    ------
    Realisation
        One for each combination of the ends of the ranges.
    """
    faces = problem.interfaces
    if faces.share is not None and problem.undivided is not None:  # cells take the place of the edges that are lost
        faces = problem.undivided
    yield from realisations(problem.assembly, faces, loads, imperfections)


def _divided(assembly: Assembly, interfaces: Interfaces) -> Interfaces:
    """The interfaces with cells where a joint law asks for them."""
    divisions = np.array([law.divisions if law else 0 for law in last_law(assembly, interfaces)], dtype=np.int64)
    return refine(interfaces, divisions) if divisions.any() else interfaces


def _crushed(assembly: Assembly, interfaces: Interfaces) -> np.ndarray:
    """Interfaces without area under a joint law with compressive strength, shape (n_interfaces,)."""
    crushed = interfaces.area == 0
    for k, law in enumerate(last_law(assembly, interfaces) if crushed.any() else ()):
        crushed[k] &= law is not None and law.compression is not None
    return crushed


def _crushed_warnings(assembly: Assembly, crushed: tuple[Interfaces, ...]) -> list[str]:
    pairs = [" and ".join(f'"{assembly.names[i]}"' for i in pair) for faces in crushed for pair in faces.pair]
    more = f"; and {len(pairs) - 3} more" if len(pairs) > 3 else ""
    what = "contacts without area carry nothing under a joint law with compressive strength"
    return [f"{what}: {'; '.join(pairs[:3])}{more}"]


def _program(
    assembly: Assembly, interfaces: Interfaces, load: Floats, held: Ints, points: Ints, touched: np.ndarray, ties: Ints
) -> tuple[Equilibrium, PenaltyProgram | None, Ints]:
    """Equilibrium and program of the held blocks, and the interfaces with bonds."""
    friction = joint_friction(assembly, interfaces)[interfaces.point_interface[points]]
    if not assembly.joints and not len(ties):
        eq = equilibrium(assembly, interfaces, load, held, points)
        plane = find_plane(assembly, interfaces, eq)
        return eq, penalty_program(eq, friction, plane=plane) if len(held) else None, points[:0]
    law = point_law(assembly, interfaces)
    bonds, capacity = bonded(assembly, interfaces)
    live = touched[bonds]
    bonds, capacity = bonds[live], capacity[np.repeat(live, KINDS)]
    chosen = [assembly.ties[k] for k in ties]
    more = [bond_columns(interfaces, bonds)] if len(bonds) else []
    more += [tie_columns(assembly, chosen)] if chosen else []
    eq = equilibrium(assembly, interfaces, load, held, points, more)
    none = np.zeros(len(capacity) + len(ties))
    bounds: dict[str, Any] = {
        "shift": np.concatenate([law.shift[points], none]),
        "lower": np.concatenate([law.floor[points], 0 * capacity, [tie.least for tie in chosen]]),
        "upper": np.concatenate([law.cap[points], capacity, [tie.greatest for tie in chosen]]),
    }
    plain = not len(ties) and not bounds["lower"].any() and np.isinf(bounds["upper"]).all()
    plane = find_plane(assembly, interfaces, eq) if plain else None
    mu = np.concatenate([friction, np.ones(len(none))])
    return eq, penalty_program(eq, mu, plane=plane, **bounds) if len(held) else None, bonds


def crushes(problem: Problem, mechanism: Floats) -> bool:
    """Return whether a mechanism drives in contacts that have no area to crush on.

    They carry nothing under their joint law, but would crush until they have an area, which no rigid block has. So such
    a mechanism does not prove that the assembly falls.

    Parameters
    ----------
    problem
        The posed problem.
    mechanism
        Of all blocks, scaled to move the fastest corner by 1 m, shape (n_blocks, 6).

    Returns
    -------
    bool
        True where such a contact closes.
    """
    for faces in problem.interfaces.crushed:
        k = faces.point_interface
        a, b = (point_velocity(problem.assembly, mechanism, side, faces.point) for side in faces.pair[k].T)
        if (np.einsum("ij,ij->i", faces.frame[k, 0], b - a) < -CLOSING).any():
            return True
    return False


def free_fall(problem: Problem) -> Floats:
    """Return the motion of the groups that nothing holds, each as one body along its load.

    Parameters
    ----------
    problem
        The posed problem.

    Returns
    -------
    Floats
        Shape (n_blocks, 6); zero for blocks that are held and for groups without a load.
    """
    assembly = problem.assembly
    pair = np.concatenate([problem.interfaces.pair, tied_pairs(assembly)])
    _, label = connected_components(assembly.n_blocks, pair)
    motion = np.zeros((assembly.n_blocks, 6))
    for group in np.unique(label[problem.floating]):
        blocks = np.flatnonzero(label == group)
        pull = problem.load[blocks, :3].sum(axis=0)
        rounding = 1e-12 * np.abs(problem.load[blocks]).sum()
        if np.linalg.norm(pull) > rounding:
            motion[blocks, :3] = pull / np.linalg.norm(pull)
            continue
        arm = assembly.centroid[blocks] - assembly.centroid[blocks].mean(axis=0)
        moment = (problem.load[blocks, 3:] + np.cross(arm, problem.load[blocks, :3])).sum(axis=0)
        if np.linalg.norm(moment) > rounding * float(assembly.size[blocks].mean()):
            turn = moment / np.linalg.norm(moment)
            motion[blocks, :3], motion[blocks, 3:] = np.cross(turn, arm), turn
    return motion


def checked_loads(assembly: Assembly, loads: Loads | None) -> Floats:
    """Return a wrench on each block; zeros for None.

    Parameters
    ----------
    assembly
        The blocks.
    loads
        Shape (n_blocks, 6) [N, N m], or these with a factor on the weight of the blocks.

    Returns
    -------
    Floats
        Shape (n_blocks, 6) [N, N m].

    Raises
    ------
    InputError
        For another shape, or for values that are not finite or that no building bears.
    """
    if loads is None:
        return np.zeros((assembly.n_blocks, 6))
    if isinstance(loads, WeightedLoads):
        return checked_loads(assembly, loads.beside) + loads.more_weight(assembly)
    try:
        loads = np.asarray(loads, dtype=float)
    except (TypeError, ValueError):
        text = f"loads must be numbers of shape ({assembly.n_blocks}, 6), as `loads` of a load case"
        raise InputError(text) from None
    if loads.shape != (assembly.n_blocks, 6) or not np.isfinite(loads).all():
        raise InputError(f"loads have shape {loads.shape}; finite values of shape ({assembly.n_blocks}, 6) are needed")
    check_size(loads)
    return loads


def _floating_warnings(assembly: Assembly, floating: Ints, interfaces: Interfaces) -> list[str]:
    """Name the blocks that touch nothing, or say how far apart all are when none touches another."""
    touched = np.unique(interfaces.pair)
    alone = np.setdiff1d(floating, touched)
    if len(alone) > 1 and not len(touched):
        return [_distances(assembly)]
    return [f'block "{assembly.names[i]}" touches nothing' for i in alone[:5]] + (
        [f"{len(alone) - 5} more blocks touch nothing"] if len(alone) > 5 else []
    )


def _distances(assembly: Assembly) -> str:
    """How far apart free blocks are at least, and how far from the supports."""
    solid, free, support = facets(assembly), assembly.free, np.flatnonzero(assembly.support)
    between, *pair = smallest_gap(solid, free, free)
    one, two = (assembly.names[i] for i in pair)
    below, *pair = smallest_gap(solid, free, support)
    near, held = (assembly.names[i] for i in sorted(pair, key=lambda i: assembly.support[i]))
    if min(between, below) <= 0:
        return "no two blocks have a joint, but some overlap; within a gap as large as that they count as touching"
    return (
        f'no two blocks touch: the smallest gap between two of them is {between:.3g} m ("{one}" and "{two}"), '
        f'and {below:.3g} m to a support ("{near}" and "{held}")'
    )


@contextmanager
def timed(timings: dict[str, float], step: str) -> Iterator[None]:
    """Add the process time of a step to the timings.

    Parameters
    ----------
    timings
        Seconds by step; changed in place.
    step
        The name of the step.

    Yields
    ------
    None
        The step runs in the body of the with statement.
    """
    start = process_time()
    yield
    timings[step] = process_time() - start
