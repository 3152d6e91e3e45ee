"""How much a tie must and may pull, where one helps most, and anchor plates and tendons as what they do to blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, limit_load
from blockstat.analysis.problem import Problem, checked_loads
from blockstat.analysis.thrust import Extreme, extreme, range_warning, standing, with_overlaps
from blockstat.assembly import Block
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_density, check_positive, known_options
from blockstat.joint import Tie
from blockstat.loads import as_load, as_points, numbers, on_block, three
from blockstat.program.ties import check_anchors, tie_columns, tied_pairs
from blockstat.result import Result, Sentence, counted, finite
from blockstat.sensitivity.parameters import pinned
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

STEEL = 7850.0  #: [kg/m3]
ROUNDING = 1e-9  #: a least force below this part of what acts on the free blocks is what a solver leaves of none


class TieOutcome(Sentence):
    """The answers of `tie_range`; the value of each is the sentence that a user reads."""

    RANGE = "Range: the assembly stands with every force of the tie between the least and the greatest."
    NO_GREATEST = "No greatest: the assembly stands with every force of the tie from the least on."
    UNDECIDED = "Undecided: the assembly stands with every force between those told, but others are not excluded."


@dataclass(frozen=True, eq=False)
class TieRange(Result):
    """The least and the greatest force of a tie with which an assembly stands."""

    tie: Tie
    least: float  #: [N], proven by `least_forces`
    greatest: float  #: [N], proven by `greatest_forces`; inf for no greatest
    least_forces: Floats  #: shape (n_points, 3) [N]
    greatest_forces: Floats  #: shape (n_points, 3) [N]
    assembly: Assembly
    proven: bool = True  #: whether mechanisms prove that it does not stand with less or with more
    warnings: tuple[str, ...] = ()

    @property
    def outcome(self) -> TieOutcome:
        """Whether there is a greatest force."""
        if not self.proven:
            return TieOutcome.UNDECIDED
        return TieOutcome.RANGE if np.isfinite(self.greatest) else TieOutcome.NO_GREATEST

    def explain(self) -> str:
        """Return the range in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value, f"Least {self.least:.9g} N, greatest {self.greatest:.9g} N."]
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; no greatest force is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "tie": self.tie.as_dict(),
            "proven": self.proven,
            "least": self.least,
            "greatest": finite(self.greatest),
            "warnings": list(self.warnings),
        }


@known_options
def tie_range(
    assembly: Assembly,
    tie: int = 0,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> TieRange:
    """Find the least and the greatest force of a tie with which an assembly stands, between the tie's own bounds.

    Parameters
    ----------
    assembly : Assembly
        The blocks and their ties; it must stand with some force of the tie.
    tie : int, optional
        Number of the tie among those of the assembly.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    TieRange
        Both forces, each with a force field that proves it.

    Raises
    ------
    InputError
        When the assembly stands with no force of the tie, for a tie that does not exist, whose force is given or that
        holds two supports, and for an option that does not exist.

    Notes
    -----
    The least force with which an assembly carries a load is that of `loads` with the load in it. Of the limit load of a
    tie without a bound, it is the greatest force that is of any use.

    Examples
    --------
    A tie at its top holds a block that leans out over its foot.

    >>> from blockstat import Assembly, Tie, box, tie_range
    >>> blocks = [box((-2, -1, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (3, 1, 1), name="block")]
    >>> tie = Tie(("ground", "block"), ((-1, 0.5, 0), (0, 0.5, 1)))
    >>> held = Assembly.from_blocks(blocks, supports=[0], density=1000.0, ties=[tie])
    >>> found = tie_range(held)
    >>> round(found.least), found.outcome.word
    (10405, 'range')
    """
    if not isinstance(tie, (int, np.integer)) or not 0 <= tie < len(assembly.ties):
        raise InputError(f"tie is {tie!r}; the assembly has {counted(len(assembly.ties), 'tie')}, numbered from 0")
    if assembly.ties[tie].constant:
        raise InputError(f"{assembly.ties[tie].label}: its force is given; there is no range to find")
    if assembly.support[tied_pairs(assembly)[tie]].all():
        raise InputError(f"{assembly.ties[tie].label}: both its blocks are supports; it holds nothing, with any force")
    options = {"friction": friction, "gravity": gravity, "loads": loads, "gap": gap, "interfaces": interfaces}
    none = f"no force of {assembly.ties[tie].label} within its bounds makes it stand"
    problem, inside = standing(assembly, solver=solver, otherwise=none, **options)

    def ends(problem: Problem, inside: Floats) -> tuple[Extreme, Extreme]:
        column = problem.eq.n_columns - len(problem.ties) + int(np.flatnonzero(problem.ties == tie)[0])
        functional = np.zeros(3 * problem.eq.n_columns)
        functional[3 * column] = 1.0
        return extreme(problem, -functional, inside, solver), extreme(problem, functional, inside, solver)

    problem = with_overlaps(problem)
    low, high = ends(problem, inside)
    doubts = range_warning(problem, low, high, ends, "the force", loads=loads, solver=solver)
    acting = np.linalg.norm(problem.load[problem.assembly.free, :3], axis=1).sum()
    least = -low.value if -low.value > ROUNDING * acting else 0.0
    return TieRange(
        tie=assembly.ties[tie],
        least=least,
        greatest=high.value,
        least_forces=low.forces,
        greatest_forces=high.forces,
        assembly=problem.assembly,
        proven=low.proven and high.proven,
        warnings=tuple(dict.fromkeys([*problem.warnings, *low.doubts, *high.doubts, *doubts])),
    )


@known_options
def tie_gain(
    limit: LimitLoad, load: Any, ties: Sequence[Tie], *, force: float | None = None, loads: Floats | None = None
) -> Floats:
    """Return by how much each of some ties would raise a limit load multiplier, for each newton of its force.

    It is the slope at no force, and an upper bound for any force: the multiplier is concave in the force that a tie may
    have. A tie that may be slack lowers no limit: where the mechanism shortens it, the slope is zero. A tie that is
    anchored in single stones soon pulls these out, and then gains nothing more. `force` tells.

    Parameters
    ----------
    limit : LimitLoad
        Of the assembly without them.
    load : array_like
        Its load, as `blockstat.limit_load` took it.
    ties : sequence of Tie
        The ties that are considered.
    force : float, optional
        Greatest force of each tie by itself [N]: what it gains up to there is computed by a limit load each.
    loads : array of float, shape (n_blocks, 6), optional
        The permanent loads of the limit [N, N m].

    Returns
    -------
    array, shape (n_ties,)
        Derivatives of the multiplier by the forces [1/N], to first order: those of the mechanism of the limit. With
        `force`, the mean gain up to it. The best place of a tie is that of the largest.

    Raises
    ------
    InputError
        When there is no limit, when `load` and `loads` are not those of it, for a tie to a block that does not exist or
        beside it, or a force that is not positive.

    Notes
    -----
    A mechanism u with l'u = 1 bounds the multiplier by -w'u. The wrenches t of a unit tension add to w, so the bound
    rises by -t'u, the rate at which the mechanism lengthens the tie. The gain for a given force is no derivative of one
    mechanism: the weakest one changes.

    Examples
    --------
    A tie to the ground keeps a pillar from tipping the better the higher it is.

    >>> from blockstat import Assembly, Tie, box, limit_load, tie_gain
    >>> blocks = [box((-4, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0)
    >>> limit = limit_load(pillar, (1, 0, 0))
    >>> places = [Tie(("ground", "pillar"), ((-4, 0.5, z), (0, 0.5, z))) for z in (0.5, 1.0, 2.0)]
    >>> (9810.0 * tie_gain(limit, (1, 0, 0), places)).round(6).tolist()
    [0.5, 1.0, 2.0]

    Up to 20 kN those above and below the centroid gain less: the foot of the pillar slides away under them.

    >>> (9810.0 * tie_gain(limit, (1, 0, 0), places, force=20e3)).round(3).tolist()
    [0.466, 1.0, 0.687]
    """
    assembly = limit.assembly
    _, motion = pinned(limit, as_load(assembly, load), checked_loads(assembly, loads))
    check_anchors(assembly.with_(ties=ties))
    if force is not None:
        check_positive("force", force)
        options: dict[str, Any] = {"loads": loads, "interfaces": limit.interfaces, "optimum": True}
        held = [assembly, *(assembly.with_(ties=(*assembly.ties, replace(tie, greatest=force))) for tie in ties)]
        carried = np.array([limit_load(one, load, **options).lower for one in held])  # all to the same accuracy
        return (carried[1:] - carried[0]) / force
    columns = tie_columns(assembly, ties)
    gain = np.zeros(len(ties))
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = columns.pair[:, side]
        velocity = motion[block, :3] + np.cross(motion[block, 3:], columns.point - assembly.centroid[block])
        gain += sign * np.einsum("ij,ij->i", columns.force[:, 0], velocity)
    return np.where([tie.least == 0 for tie in ties], np.maximum(gain, 0.0), gain)


@known_options
def tendon_load(assembly: Assembly, blocks: Sequence[int | str], points: Any, force: float) -> Floats:
    """Make the load of an unbonded tendon with a constant force along a polyline, without friction at its bends.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    blocks : sequence of str or int
        The block that it is anchored in, those that it bends at, and the block of its other anchorage.
    points : array_like, shape (n, 3)
        The anchorages and the bends, each on its block [m].
    force : float
        Tension [N].

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block; they balance each other.

    Raises
    ------
    InputError
        For a point that is not on its block, or a force that is not positive.

    Notes
    -----
    The load does not follow the blocks when they move far.

    Examples
    --------
    >>> from blockstat import Assembly, box, tendon_load
    >>> blocks = [box((0, 0, 0), (1, 1, 1), name="a"), box((1, 0, 0), (2, 1, 1), name="b")]
    >>> row = Assembly.from_blocks(blocks)
    >>> tendon_load(row, ["a", "b"], [(0, 0.5, 0.5), (2, 0.5, 0.5)], 100.0)[:, :3].tolist()
    [[100.0, 0.0, 0.0], [-100.0, 0.0, 0.0]]
    """
    corners = as_points(points, "tendon", 2)
    if len(corners) != len(blocks):
        raise InputError(f"tendon: it has {len(corners)} points on {len(blocks)} blocks; one point a block is needed")
    check_positive("tendon: force", force)
    steps = np.diff(corners, axis=0)
    length = np.linalg.norm(steps, axis=1)
    if not length.all():
        raise InputError("tendon: two of its points that follow each other are the same")
    pull = force * steps / length[:, None]
    total = np.zeros((len(corners), 3))
    total[:-1] += pull
    total[1:] -= pull
    load = np.zeros((assembly.n_blocks, 6))
    passed = assembly.blocks_named(blocks, "tendon")
    if len(passed) != len(corners):
        raise InputError(f"tendon: one of {list(blocks)!r} is a layer of several blocks; one point a block is needed")
    for block, point, push in zip(passed, corners, total, strict=True):
        if not assembly.support[block] and not on_block(assembly, int(block), point):
            raise InputError(f'tendon: the point {point.tolist()} is not on block "{assembly.names[block]}"')
        load[block] += np.concatenate([push, np.cross(point - assembly.centroid[block], push)])
    return load


def anchor_plate(
    point: Sequence[float],
    outward: Sequence[float],
    sides: Sequence[float],
    *,
    thickness: float = 0.03,
    density: float = STEEL,
    name: str = "plate",
) -> Block:
    """Make an anchor plate as a block that lies on a face, for a tie that ends on it.

    Parameters
    ----------
    point : sequence of float, shape (3,)
        Middle of its inner face, on the masonry [m].
    outward : sequence of float, shape (3,)
        Out of the masonry.
    sides : sequence of float, shape (2,)
        Of the plate: the horizontal one and the other [m].
    thickness : float, optional
        [m].
    density : float, optional
        [kg/m3].
    name : str, optional
        Of the block.

    Returns
    -------
    Block
        A rigid plate that presses on all blocks that it covers.

    Raises
    ------
    InputError
        For sides, a thickness or a density that are not positive.

    Examples
    --------
    >>> from blockstat import anchor_plate
    >>> plate = anchor_plate((0, 0, 2), (-1, 0, 0), (0.4, 0.6), name="plate.left")
    >>> plate.vertices.min(axis=0).round(3).tolist(), plate.vertices.max(axis=0).round(3).tolist()
    ([-0.03, -0.2, 1.7], [0.0, 0.2, 2.3])
    """
    from blockstat.model.solids import box

    normal = three(outward, "outward")
    half = numbers(sides) / 2
    check_positive("plate: thickness", thickness)
    density = check_density(name, density)
    if half.shape != (2,) or not (np.isfinite(half) & (half > 0)).all() or not normal.any():
        raise InputError(f"plate: sides are {sides!r}; they must be two numbers above 0, and outward not zero")
    normal = normal / np.linalg.norm(normal)
    across = np.cross([0.0, 0.0, 1.0], normal)
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-9 else np.array([1.0, 0.0, 0.0])
    frame = np.stack([across, np.cross(normal, across), normal])
    flat = box((-half[0], -half[1], 0.0), (half[0], half[1], thickness))
    vertices = three(point, "point") + np.asarray(flat.vertices, dtype=float) @ frame
    return Block(vertices, flat.faces, name=name, group=name, density=density)
