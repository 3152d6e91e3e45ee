"""Derivatives of the limit load and of the score by the parameters of a design, without solving again.

Envelope theorem: at the optimum the unknowns do not matter to first order, so the derivative is that of the
equilibrium residual, with the forces in their joints' frames and the mechanism held fixed:

    d lambda / d theta = -u' d(A f + w + lambda l) / d theta    with l' u = 1,
    d (1/2 |s|^2) / d theta = u' d(A (f - E s) + w) / d theta.

The derivative of the residual is taken by central differences on the rebuilt geometry, which costs two interface
searches a parameter and no solve. The forces of ties are fixed as well, at their bound where they have reached one, and
count with the load w. Friction is no part of the residual: it widens the cones, which adds the sum of f'_n |slip| d mu
to d lambda and takes it off the other, f'_n the normal force above the apex of the cone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.verdict import Outcome, Verdict, relative_motion
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.contact.point_law import joint_friction, point_law
from blockstat.errors import InputError
from blockstat.loads import acceleration, as_load
from blockstat.program.bonds import bond_wrenches
from blockstat.program.equilibrium import weight, wrenches_between
from blockstat.program.ties import given_wrenches, tie_wrenches
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

Make = Callable[[Mapping[str, float]], "Assembly"]
LoadOf = Callable[["Assembly"], Any]
JointsOf = Callable[["Assembly"], Interfaces]

#: Half width of the differences, relative to the parameter: the residual is smooth, so rounding sets it.
STEP = 1e-5
#: Forces that balance a load do so to this fraction of the largest one on a block; moments count over its size.
BALANCE = 1e-5


def limit_load_gradient(
    make: Make, values: Mapping[str, float], load: LoadOf, *, joints: JointsOf = find_interfaces
) -> tuple[LimitLoad, dict[str, float]]:
    """Find the limit load of a design and its derivative by each of its parameters.

    Parameters
    ----------
    make
        Builds the assembly of some parameter values.
    values
        The values of the design by name.
    load
        Gives the load on an assembly, as in `blockstat.limit_load`.
    joints
        Gives the joints of an assembly, if they are not what a search finds.

    Returns
    -------
    limit : LimitLoad
        The limit load of the design.
    gradient : dict of str to float
        Change of the multiplier per unit of each parameter.

    Raises
    ------
    InputError
        When there is no limit, or when a small step changes which blocks touch or how many ties there are.

    Examples
    --------
    A pillar 2 m high tips at width / height times its weight.

    >>> from blockstat import Assembly, acceleration, box, limit_load_gradient
    >>> def pillar(values):
    ...     corner = (values["width"], 0.5, 2)
    ...     blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), corner, name="pillar")]
    ...     return Assembly.from_blocks(blocks, supports=["ground"])
    >>> limit, gradient = limit_load_gradient(pillar, {"width": 0.5}, lambda made: acceleration(made, (1, 0, 0)))
    >>> round(limit.lower, 4), round(gradient["width"], 4)
    (0.25, 0.5)
    """
    assembly = _plain(make(values))
    found = joints(assembly)
    limit = limit_load(assembly, load(assembly), interfaces=found, gap=found.searched, optimum=True)
    return limit, slopes_of_limit(limit, make, values, load, joints=joints)


def slopes_of_limit(
    limit: LimitLoad, make: Make, values: Mapping[str, float], load: LoadOf, *, joints: JointsOf = find_interfaces
) -> dict[str, float]:
    """Return the derivative of a limit load by each parameter of its design.

    Parameters
    ----------
    limit
        The limit load of `make(values)`, to its optimum.
    make, values, load, joints
        As in `limit_load_gradient`.

    Returns
    -------
    dict of str to float
        Change of the multiplier per unit of each parameter.

    Raises
    ------
    InputError
        As `limit_load_gradient`.
    """
    multiplier, twist = pinned(limit, as_load(_plain(limit.assembly), load(limit.assembly)))
    rubbing = friction_power(limit, twist)

    def residual(changed: Assembly, interfaces: Interfaces) -> Floats:
        total = _dead_load(changed, limit) + multiplier * as_load(changed, load(changed))
        return _residual(changed, interfaces, _shifted(changed, interfaces, limit, limit.forces), total)

    def change(changed: Assembly, interfaces: Interfaces) -> float:
        held = _more_friction(changed, interfaces, limit) @ rubbing
        return float(held - (twist * residual(changed, interfaces)).sum())

    return _differences(make, values, limit.interfaces, change, joints)


def pinned(limit: LimitLoad, load: Floats, loads: Floats | None = None) -> tuple[float, Floats]:
    """Return the multiplier of a limit and the mechanism on which the load does work 1.

    Parameters
    ----------
    limit
        A limit load.
    load
        Its load, shape (n_blocks, 6) [N, N m].
    loads
        Its permanent loads, of the same shape; None for none.

    Returns
    -------
    multiplier : float
        The middle of the bracket.
    twist : Floats
        Shape (n_blocks, 6).

    Raises
    ------
    InputError
        When there is no limit, or when the forces of the limit do not carry these loads.
    """
    if limit.outcome is not LoadOutcome.LIMIT:
        raise InputError(f"no limit load to differentiate: {limit.outcome.value}")
    assembly = limit.assembly
    total = _dead_load(assembly, limit) + limit.lower * load + (0.0 if loads is None else loads)
    bonds = bond_wrenches(assembly, limit.interfaces, limit.bonds)
    rest = _residual(assembly, limit.interfaces, limit.forces, total + bonds)
    rest, total = (wrenches[assembly.free] / _lengths(assembly)[assembly.free] for wrenches in (rest, total))
    if np.abs(rest).max() > BALANCE * np.abs(total).max():
        raise InputError("the limit is not that of this load: its forces do not balance the weight and the load")
    return (limit.lower + limit.upper) / 2, limit.mechanism / float((limit.mechanism * load).sum())


def friction_power(result: LimitLoad | Verdict, twist: Floats) -> Floats:
    """Return the power of friction at each contact point, for each unit of its coefficient.

    Parameters
    ----------
    result
        With the forces.
    twist
        The mechanism, shape (n_blocks, 6).

    Returns
    -------
    Floats
        Shape (n_points,): the normal force above the apex of the cone times the rate of slip.
    """
    assembly, faces = result.assembly, result.interfaces
    slip = relative_motion(assembly, faces, twist)[:, 1:]
    return (result.forces[:, 0] + point_law(assembly, faces).shift) * np.linalg.norm(slip, axis=1)


def penalty_optimum(verdict: Verdict) -> tuple[Floats, Floats]:
    """Return the mechanism and the net contact forces f - E s of the penalty program's optimum.

    Parameters
    ----------
    verdict
        A verdict with a score.

    Returns
    -------
    twist : Floats
        Shape (n_blocks, 6).
    net : Floats
        Shape (n_points, 3) [N].

    Raises
    ------
    InputError
        For an infinite score.

    Notes
    -----
    At the optimum |s|^2 = w'u, which gives the mechanism its size; what joints hold in tension counts with the load w,
    and so does what ties pull.
    """
    if not np.isfinite(verdict.score):
        raise InputError("the score is infinite: no residual tension at the joints could hold this design")
    assembly, faces, normal = verdict.assembly, verdict.interfaces, np.array([1.0, 0.0, 0.0])
    held = -point_law(assembly, faces).shift[:, None] * normal
    load = _residual(assembly, faces, held, _dead_load(assembly, verdict))
    twist = verdict.mechanism * float(verdict.adhesion @ verdict.adhesion) / float((verdict.mechanism * load).sum())
    return twist, verdict.forces - verdict.adhesion[:, None] * normal


def score_load(assembly: Assembly) -> Floats:
    """Return the forces of whose sum of magnitudes a score is a share.

    Parameters
    ----------
    assembly
        The blocks.

    Returns
    -------
    Floats
        Weight and given forces of ties, shape (n_blocks, 3) [N]; zero on supports.
    """
    load = (weight(assembly) + given_wrenches(assembly))[:, :3]
    return np.where(assembly.support[:, None], 0.0, load)


def stone_sensitivity(limit: LimitLoad, direction: Sequence[float], *, pushed: bool = True) -> Floats:
    """Return the change of the limit load multiplier by mass added at each block's centroid.

    Parameters
    ----------
    limit
        A limit load.
    direction
        Three numbers, the acceleration of which `limit` is the limit.
    pushed
        Whether the load pushes the added mass as well. Without, the load stays what it was.

    Returns
    -------
    Floats
        Shape (n_blocks,) [1/kg], zero on supports.

    Notes
    -----
    The added mass m weighs on the block, and where `pushed` the load, being an acceleration, pushes it as well::

        d lambda / d m = -v' (g + lambda |g| e)    with l' u = 1,

    v the velocity of the centroid, e the unit vector of the load; without `pushed` the second term is left out.

    Examples
    --------
    A pillar tips at the same share of its weight whatever its mass. Mass that the load does not push holds it down.

    >>> from blockstat import Assembly, box, limit_load, stone_sensitivity
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> limit = limit_load(pillar, (1, 0, 0))
    >>> pushed, resting = (stone_sensitivity(limit, (1, 0, 0), pushed=pushed) for pushed in (True, False))
    >>> bool(abs(pushed[1]) < 1e-9), bool(resting[1] > 1e-4)
    (True, True)
    """
    assembly = limit.assembly
    load = acceleration(assembly, direction)
    multiplier, twist = pinned(limit, load)
    field = assembly.gravity + (multiplier * load[:, :3] / assembly.mass[:, None] if pushed else 0.0)
    return np.where(
        assembly.support, 0.0, -np.einsum("ij,ij->i", twist[:, :3], np.broadcast_to(field, load[:, :3].shape))
    )


def score_gradient(
    make: Make, values: Mapping[str, float], *, joints: JointsOf = find_interfaces
) -> tuple[Verdict, dict[str, float]]:
    """Return the score of an unstable design and its derivative by each of its parameters.

    Parameters
    ----------
    make
        Builds the assembly of some parameter values.
    values
        The values of the design by name.
    joints
        Gives the joints of an assembly, if they are not what a search finds.

    Returns
    -------
    verdict : Verdict
        The verdict on the design.
    gradient : dict of str to float
        Change of the score per unit of each parameter; zero where the design is stable.

    Raises
    ------
    InputError
        For an infinite score, or when a small step changes which blocks touch or how many ties there are.

    Examples
    --------
    A pillar that tips needs less adhesion once it is wider.

    >>> from blockstat import Assembly, box, score_gradient
    >>> def pillar(values):
    ...     corner = (values["width"], 0.5, 2)
    ...     blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), corner, name="pillar")]
    ...     return Assembly.from_blocks(blocks, supports=["ground"], gravity=(3.0, 0.0, -9.81))
    >>> verdict, gradient = score_gradient(pillar, {"width": 0.5})
    >>> verdict.outcome.word, gradient["width"] < 0
    ('unstable', True)
    """
    assembly = _plain(make(values))
    found = joints(assembly)
    verdict = assess(assembly, interfaces=found, gap=found.searched)
    return verdict, slopes_of_score(verdict, make, values, joints=joints)


def slopes_of_score(
    verdict: Verdict, make: Make, values: Mapping[str, float], *, joints: JointsOf = find_interfaces
) -> dict[str, float]:
    """Return the derivative of a score by each parameter of its design.

    Parameters
    ----------
    verdict
        The verdict on `make(values)`, with its score.
    make, values, joints
        As in `score_gradient`.

    Returns
    -------
    dict of str to float
        Change of the score per unit of each parameter; zero where the design is stable.

    Raises
    ------
    InputError
        As `score_gradient`.
    """
    assembly = _plain(verdict.assembly)
    if verdict.outcome is Outcome.STABLE:
        return dict.fromkeys(values, 0.0)
    twist, net = penalty_optimum(verdict)
    tension, total = float(np.linalg.norm(verdict.adhesion)), _total(score_load(assembly))
    rubbing = friction_power(verdict, twist)

    def score_change(changed: Assembly, interfaces: Interfaces) -> float:
        forces = _shifted(changed, interfaces, verdict, net)
        energy = float((twist * _residual(changed, interfaces, forces, _dead_load(changed, verdict))).sum())
        energy -= float(_more_friction(changed, interfaces, verdict) @ rubbing)
        return (energy / tension - verdict.score * _total(score_load(changed))) / total

    return _differences(make, values, verdict.interfaces, score_change, joints)


def _plain(assembly: Assembly) -> Assembly:
    """The assembly, if its joints have laws of which the derivative is known."""
    for law in assembly.joints:
        unknown = set(law.as_dict()) - {"between", "friction", "tension", "bond"}
        if unknown:
            label, names = " and ".join(law.between), ", ".join(sorted(unknown))
            raise InputError(f"joint law between {label}: derivatives know friction, tension and bond, not {names}")
    return assembly


def _differences(
    make: Make,
    values: Mapping[str, float],
    interfaces: Interfaces,
    measure: Callable[[Assembly, Interfaces], float],
    joints: JointsOf,
) -> dict[str, float]:
    """Central differences of a measure that holds forces and twists fixed."""
    gradient = {}
    for name, value in values.items():
        step = STEP * max(abs(value), 1e-3)
        ends = []
        for sign in (1.0, -1.0):
            changed = make({**values, name: value + sign * step})
            ends.append(measure(changed, _matched(interfaces, joints(changed), name)))
        gradient[name] = (ends[0] - ends[1]) / (2 * step)
    return gradient


def _matched(old: Interfaces, new: Interfaces, name: str) -> Interfaces:
    """The new interfaces, if they are the old ones moved a little."""
    same = old.pair.shape == new.pair.shape and (old.pair == new.pair).all() and (old.start == new.start).all()
    if not same or np.abs(old.frame - new.frame).max(initial=0.0) > 0.1:
        raise InputError(f'"{name}": a small step changes which blocks touch, or how; there is no derivative here')
    return new


def _more_friction(changed: Assembly, interfaces: Interfaces, result: LimitLoad | Verdict) -> Floats:
    """By how much the coefficient of friction of each contact point grows; not at all where it stays infinite."""
    old, new = joint_friction(result.assembly, result.interfaces), joint_friction(changed, interfaces)
    return np.subtract(new, old, out=np.zeros_like(new), where=new != old)[interfaces.point_interface]


def _shifted(changed: Assembly, interfaces: Interfaces, result: LimitLoad | Verdict, forces: Floats) -> Floats:
    """Forces where tension capacities go with the joints' areas: what is held fixed is their place in the cones."""
    more = point_law(changed, interfaces).shift - point_law(result.assembly, result.interfaces).shift
    return forces - more[:, None] * np.array([1.0, 0.0, 0.0])


def _dead_load(changed: Assembly, result: LimitLoad | Verdict) -> Floats:
    """Weight and what ties pull, each as far from its bound as in the result, shape (n_blocks, 6) [N, N m]."""
    ties, pulls = result.assembly.ties, [] if result.ties is None else result.ties
    if len(changed.ties) != len(ties):
        raise InputError("a small step changes how many ties there are; there is no derivative here")
    force = []
    for old, new, pull in zip(ties, changed.ties, pulls, strict=True):
        bound = "least" if pull - old.least < old.greatest - pull else "greatest"
        force.append(pull + getattr(new, bound) - getattr(old, bound))
    return weight(changed) + tie_wrenches(changed, changed.ties, np.array(force))


def _lengths(assembly: Assembly) -> Floats:
    """What turns wrenches into forces: 1, and for moments the size of the block, shape (n_blocks, 6)."""
    return np.repeat([np.ones(assembly.n_blocks), assembly.size], 3, axis=0).T


def _total(forces: Floats) -> float:
    return float(np.linalg.norm(forces, axis=1).sum())


def _residual(assembly: Assembly, interfaces: Interfaces, forces: Floats, load: Floats) -> Floats:
    """Unbalanced wrench on each free block, forces fixed in their joints' frames, shape (n_blocks, 6) [N, N m]."""
    k = interfaces.point_interface
    force = np.einsum("nij,ni->nj", interfaces.frame[k], forces)
    total = load + wrenches_between(assembly, interfaces.pair[k], interfaces.point, force)
    total[assembly.support] = 0.0
    return total
