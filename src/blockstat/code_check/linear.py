"""The linear verification of a collapse mechanism, Circolare 7/2019, C8.7.1.2.1.

    alpha0                               multiplier that activates the mechanism (C8.7.1.1)
    e* = (sum P d)^2 / (sum P sum P d^2)   share of the mass that takes part (C8.7.1.5)
    a0* = alpha0 g / (e* FC)             spectral acceleration that activates it (C8.7.1.3)

P are the weights that take part, d the horizontal components of the virtual displacements of their points. Blocks that
move as one body count as one: a wall divided into courses that turn together has `e* = 1`, while its courses one by one
give 3/4, and an a0* that is a third too high. The formula is for the few macro-blocks of a mechanism drawn by hand. A
mechanism that spreads over the stones of a wall lowers e* in the same way, so there its bodies are taken as one: e* is
at most 1 (Cauchy and Schwarz), and a0* at least alpha0 g / FC. So they are where joints open as they slide, as those of
associated friction do: an upper body that slides on the edge of a floor is pushed back by that, and e* sinks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome
from blockstat.analysis.verdict import mechanism_words, relative_motion
from blockstat.code_check.macro_blocks import is_mixture
from blockstat.code_check.pushed import G, check_pushed, gravity_of, mass_points
from blockstat.code_check.spectrum import Floor, Spectrum, check_floor, spectrum_of, table_ends
from blockstat.contact.point_law import joint_friction
from blockstat.errors import InputError, check_count, check_number, check_positive, check_vector, known_options
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import point_velocity
from blockstat.loads import Loads
from blockstat.result import Result, Sentence
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Corners of two blocks move as those of one body to this fraction of the mean speed of the mechanism, at least: what
#: the solvers leave in a mechanism of the optimum.
TOGETHER = 1e-5
#: Bodies of a mechanism drawn by hand, at most: a plane chain between two supports moves with four hinges.
MACRO_BLOCKS = 3
#: No masonry has a larger behaviour factor (NTC 2018, 7.3.II).
MOST_BEHAVIOUR = 5.0
STICKS = 1e3  #: a larger coefficient of friction is as good as any: no joint slides that has it
LEVEL = 1e-3  #: a direction counts as horizontal whose sine with the horizon is at most this
GREATEST = 10.0  #: no ground acceleration comes near it, in units of g
#: Ground accelerations at which a demand is looked at, in units of g: each 1.6 % above the one before. Where that of a
#: soft soil falls, it does so over a quarter.
STEPS = np.geomspace(1e-6, GREATEST, 1001)


class CheckOutcome(Sentence):
    """The answers of `linear_check`; the value of each is the sentence that a user reads."""

    SATISFIED = "Satisfied: the mechanism is not activated, or its demand is below q times what activates it."
    NOT_SATISFIED = "Not satisfied: the demand is above q times what activates the mechanism."
    CAPACITY = "Capacity: no demand was given."
    NOT_VERIFIED = "Not verified: the demand is borne without the inertia of permanent loads, whose mass is left out."


@dataclass(frozen=True, eq=False)
class LinearCheck(Result):
    """The linear verification of a mechanism and the figures that it rests on."""

    alpha0: float  #: load multiplier [-]
    participation: float  #: e* that the verification takes [-]; 1 where all bodies are taken as one
    apart: float  #: e* of the bodies apart [-]
    mass: float  #: M* [kg]
    acceleration: float  #: a0* [m/s2]
    confidence: float  #: FC [-]
    behaviour: float  #: q [-]
    ag_damage: float  #: least ag at which the mechanism is activated (SLD), in units of g
    ag_life: float  #: ag up to which life safety (SLV) is met by behaviour factor, in units of g
    demand: float | None  #: ag asked for at SLV, in units of g
    satisfied: bool | None  #: whether that ag is borne; None without one, and where `outcome` is not verified
    bodies: tuple[tuple[int, ...], ...]  #: blocks that move as one, for each body of the mechanism
    multiplier: str  #: which multiplier alpha0 is, in words
    ground: str  #: the site or the spectrum, in words
    limit: LimitLoad  #: whose mechanism is verified
    warnings: tuple[str, ...] = ()

    @property
    def outcome(self) -> CheckOutcome:
        """Whether the verification is satisfied."""
        return check_outcome([] if self.demand is None else [self.satisfied])

    def explain(self) -> str:
        """Return the verification in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        asked = asked_for(self.demand, self.satisfied, self.ag_life)
        return "\n".join(
            [
                self.outcome.value,
                f"alpha0 = {self.alpha0:.6g}, {bodies_in_words(self.bodies)}, e* = {self.participation:.6g}, "
                f"M* = {self.mass:.6g} kg (C8.7.1.5).",
                f"alpha0 is {self.multiplier}.",
                *mechanism_words(self.limit.assembly, self.limit.joints(), self.limit.moving),
                f"a0* = alpha0 g / (e* FC) = {self.acceleration:.6g} m/s2, FC = {self.confidence:g} (C8.7.1.3).",
                f"Activated at ag = {self.ag_damage:.6g} g (SLD), on {self.ground}.",
                f"With q = {self.behaviour:g}: ag = {self.ag_life:.6g} g (SLV){asked}.",
                *(f"Warning: {text}" for text in self.warnings),
            ]
        )

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
            "alpha0": self.alpha0,
            "multiplier": self.multiplier,
            "ground": self.ground,
            "e_star": self.participation,
            "e_star_apart": self.apart,
            "m_star": self.mass,
            "a0_star": self.acceleration,
            "fc": self.confidence,
            "q": self.behaviour,
            "ag_sld": self.ag_damage,
            "ag_slv": self.ag_life,
            "demand": self.demand,
            "bodies": len(self.bodies),
            **mechanism_summary(self.limit),
            "warnings": list(self.warnings),
        }


@known_options
def linear_check(
    limit: LimitLoad,
    direction: Sequence[float],
    *,
    site: Spectrum | None = None,
    confidence: float = 1.35,
    behaviour: float = 2.0,
    masses: Sequence[tuple[int | str, Sequence[float], float]] = (),
    loads: Loads | None = None,
    floor: Floor | None = None,
    demand: float | None = None,
    macro_blocks: int = MACRO_BLOCKS,
) -> LinearCheck:
    """Verify the mechanism of a limit load linearly, with a behaviour factor.

    Parameters
    ----------
    limit : LimitLoad
        Of a horizontal acceleration, of all that has mass. alpha0 is its lower bound; with flow="coulomb" that without
        dilatancy, of the joints that carry least. The displacements are those of its mechanism, which has associated
        friction in either case.
    direction : sequence of float, shape (3,)
        Direction of the acceleration.
    site : Site or SpectrumTable, optional
        Ground and spectrum; rock with F0 = 2.5 by default.
    confidence : float, optional
        FC; 1.35 where the crushing of stone is left out.
    behaviour : float, optional
        q, from 1 to 5; 2 where only alpha0 is known.
    masses : sequence of (block, point, weight), optional
        Weights [N] with mass besides the blocks' own, such as floors and roofs: the block that they move with and where
        they are [m].
    loads : array of float, shape (n_blocks, 6), or WeightedLoads, optional
        Permanent loads of the limit [N, N m]; of a case with a factor on the weight its `weighted_permanent`. Without
        them any are taken that do not hold a block back.
    floor : Floor, optional
        For a part high up in a building; by default the mechanism stands on the ground.
    demand : float, optional
        ag asked for at the limit state of life safety, in units of g.
    macro_blocks : int, optional
        A mechanism of more bodies than these is taken as one body, e* = 1. Raise it only where you judge its bodies to
        be macro-blocks.

    Returns
    -------
    LinearCheck
        a0*, the ground accelerations that it bears, and whether the demand is met.

    Raises
    ------
    InputError
        When there is no limit, or when its load is not the acceleration of all that has mass; for a mechanism that does
        not move along the direction, or a bad value.

    References
    ----------
    Circolare 21 gennaio 2019, n. 7 C.S.LL.PP., C7.2.3, C8.7.1.2.1. NTC 2018 (D.M. 17 gennaio 2018), 3.2.3.2.1.

    Notes
    -----
    On the ground, `ag S = q a0*` (q = 1 for SLD); high up, `S_eZ(T0) = q a0*` with the floor spectrum, which asks for
    no less than the ground does: its one mode leaves out what a building moves with its ground. The method is
    calibrated for mechanisms whose points move parallel to one plane. On soil D `ag S` falls between two accelerations:
    `ag_life` is the one up to which all are borne, and a demand is compared at its own ag. Where permanent loads press
    down without mass alpha0 is too high, and a demand that seems to be borne is not verified.

    By C8.7.1.5 a lower e* is a higher a0*. e* sinks where still weights count and where one macro-block counts as many
    bricks; by Cauchy and Schwarz it is at most 1. So blocks whose motion the bracket of the limit does not prove do not
    count, and more bodies than a hand mechanism has are taken as one. So are bodies of which some are a mechanism of
    the same multiplier without the others, or with a joint between them closed, for how far each moves is then
    arbitrary (see `blockstat.code_check.macro_blocks`), and bodies whose joints open as they slide, for stone does not:
    a capacity curve follows joints that slide without opening. The result has both e*.

    Examples
    --------
    A wall 4 m high and 0.5 m thick, in four courses that turn as one.

    >>> from blockstat import Assembly, Site, box, limit_load, linear_check
    >>> courses = [box((0, 0, k), (0.5, 3, k + 1)) for k in range(4)]
    >>> wall = Assembly.from_blocks([box((-1, -1, -1), (2, 4, 0)), *courses], supports=[0])
    >>> found = linear_check(limit_load(wall, (1, 0, 0)), (1, 0, 0), site=Site("B"))
    >>> round(found.participation, 6), round(found.acceleration, 6), round(found.ag_damage, 6)
    (1.0, 0.908333, 0.07716)
    """
    if limit.outcome is not LoadOutcome.LIMIT:
        raise InputError(f"no mechanism to verify: {limit.outcome.value}")
    check_level(limit.assembly, direction)
    check_factors(confidence, macro_blocks)
    check_number("behaviour", behaviour, least=1, most=MOST_BEHAVIOUR)
    if demand is not None:
        check_demand("demand", demand)
    ground = spectrum_of(site)
    check_floor(floor)
    bodies = moving_bodies(limit)
    if limit.coulomb_least is None:
        alpha0, multiplier = limit.lower, "with associated friction, which dilates: real joints may carry less"
    else:
        alpha0, multiplier = limit.coulomb_least[0], "without dilatancy, of the joints that carry least"
    sums = work_sums(limit.assembly, limit.mechanism, direction, bodies, masses)
    push, idle, weightless = check_pushed(limit, direction, masses, loads)
    gravity, unit = gravity_of(limit.assembly)
    share, _, warnings = oscillator(sums, bodies, macro_blocks, arbitrary(limit, bodies, push, macro_blocks)[0])
    acceleration = alpha0 * gravity / (share * confidence)
    high = high_up(limit, bodies) if floor is None else table_ends(ground, floor.period)

    def needed(ag: float) -> float:
        own = ground.spectrum(ag, 0.0)
        return own if floor is None else max(own, floor.spectrum(ground, ag))

    ag_life = bearable(needed, behaviour * acceleration / G)
    borne = is_borne(needed, behaviour * acceleration / G, ag_life, demand)
    return LinearCheck(
        alpha0=alpha0,
        participation=share,
        apart=sums[1] ** 2 / (sums[0] * sums[2]),
        mass=share * sums[0] / gravity,
        acceleration=acceleration,
        confidence=confidence,
        behaviour=behaviour,
        ag_damage=bearable(needed, acceleration / G),
        ag_life=ag_life,
        demand=demand,
        satisfied=None if borne and idle else borne,
        bodies=tuple(tuple(int(block) for block in body) for body in bodies),
        multiplier=multiplier,
        ground=ground.words,
        limit=limit,
        warnings=tuple(dict.fromkeys([*limit.warnings, *warnings, *high, *idle, *weightless, *unit])),
    )


def check_factors(confidence: float, macro_blocks: int) -> None:
    """Check what both verifications take.

    Parameters
    ----------
    confidence : float
        FC.
    macro_blocks : int
        Bodies up to which e* is that of the bodies apart.

    Raises
    ------
    InputError
        For a factor below 1, or a number of bodies that is not whole.
    """
    check_positive("confidence", confidence, least=1)
    check_count("macro_blocks", macro_blocks)


def check_outcome(borne: Sequence[bool | None]) -> CheckOutcome:
    """Return the outcome of a check.

    Parameters
    ----------
    borne : sequence of bool or None
        Whether each demand that is given is borne; None where that is not verified.

    Returns
    -------
    CheckOutcome
        Not satisfied where one demand is not borne, whatever is not verified.
    """
    if not borne:
        return CheckOutcome.CAPACITY
    if False in borne:
        return CheckOutcome.NOT_SATISFIED
    return CheckOutcome.NOT_VERIFIED if None in borne else CheckOutcome.SATISFIED


def mechanism_summary(limit: LimitLoad) -> dict[str, Any]:
    """Return which mechanism is verified, under the names that a limit load has for it.

    Parameters
    ----------
    limit : LimitLoad
        With the mechanism.

    Returns
    -------
    dict
        The joints that move, by kind, and the names of the blocks that do, fastest first.
    """
    return {"joints": limit.joints(), "moving": [limit.assembly.names[block] for block in limit.moving]}


def bodies_in_words(bodies: Sequence[Any]) -> str:
    """Return the number of bodies in words.

    Parameters
    ----------
    bodies : sequence
        The bodies.

    Returns
    -------
    str
        Such as "2 bodies".
    """
    return "1 body" if len(bodies) == 1 else f"{len(bodies):,} bodies"


def asked_for(demand: float | None, satisfied: bool | None, ag: float) -> str:
    """Return what is asked for in words, after what is borne.

    Parameters
    ----------
    demand, satisfied, ag : float, bool and float
        Ground acceleration asked for, whether it is borne, and the one up to which all are.

    Returns
    -------
    str
        Empty without a demand.
    """
    if demand is None:
        return ""
    falls = "; on this soil lesser accelerations are not all borne" if satisfied and demand > ag else ""
    return f", asked for {demand:.4g} g{falls}"


def high_up(limit: LimitLoad, bodies: Sequence[Ints]) -> tuple[str, ...]:
    """Return what to say of a mechanism that stands on nothing that moves with the ground.

    Parameters
    ----------
    limit : LimitLoad
        With its joints.
    bodies : sequence of array of int
        Blocks that move as one.

    Returns
    -------
    tuple of str
        A warning where no block that moves touches a support.
    """
    pair, support = limit.interfaces.pair, limit.assembly.support
    moves = np.zeros(limit.assembly.n_blocks, dtype=bool)
    moves[np.concatenate(bodies)] = True
    if (moves[pair] & support[pair[:, ::-1]]).any():
        return ()
    return (
        "no block of the mechanism touches a support: high up in a building the demand is that of a floor, which is "
        "given in Python, as floor=",
    )


def arbitrary(limit: LimitLoad, bodies: Sequence[Ints], push: Floats, macro_blocks: int) -> tuple[str, bool]:
    """Return why it is not known how far the bodies of a mechanism move beside each other.

    Parameters
    ----------
    limit : LimitLoad
        With the mechanism.
    bodies : sequence of array of int
        Blocks that move as one.
    push : array, shape (n_blocks, 6)
        The load of the limit [N, N m].
    macro_blocks : int
        Bodies from which on it does not matter.

    Returns
    -------
    reason : str
        Empty where it is known, for one body and for more than `macro_blocks`.
    mixture : bool
        Whether it is that the mechanism is a mixture of several.
    """
    if not 1 < len(bodies) <= macro_blocks:
        return "", False
    if _opens_as_it_slides(limit):
        return (
            "joints of the mechanism open as they slide, which those of stone do not, so that how far its bodies move "
            "beside each other is not known"
        ), False
    if is_mixture(limit, bodies, push, _speeds(limit)[1]):
        return (
            f"of the {bodies_in_words(bodies)} of the mechanism some are a mechanism without the others, or all with a "
            "joint between them closed, of the same multiplier to a thousandth, so that how far each moves beside them "
            "is arbitrary"
        ), True
    return "", False


def oscillator(
    sums: tuple[float, float, float], bodies: Sequence[Ints], macro_blocks: int, reason: str
) -> tuple[float, float, tuple[str, ...]]:
    """Return the equivalent oscillator of a mechanism, of one body where its bodies are no macro-blocks of it.

    Parameters
    ----------
    sums : tuple of float
        What `work_sums` returns.
    bodies : sequence of array of int
        Blocks that move as one.
    macro_blocks : int
        Bodies up to which e* is that of the bodies apart.
    reason : str
        That `arbitrary` returns.

    Returns
    -------
    share, displacement, warnings
        e*, the displacement of the oscillator [m] in the mechanism, and what a reader must know.

    Notes
    -----
    Of one body with the same weight and the same work, sum P d^2 is (sum P d)^2 / sum P, the least it can be. It has
    e* = 1 and the mean displacement of the weights: both a0 and d0 are on the safe side, and T is the same.
    """
    total, first, second = sums
    apart = first**2 / (total * second)
    if len(bodies) <= macro_blocks and not reason:
        return apart, second / first, ()
    taken = f"they are taken as one, e* = 1, the safe side. Apart they have e* = {apart:.4g}"
    words = (
        f"{reason}; {taken}"
        if reason
        else f"the mechanism has {bodies_in_words(bodies)}, more than the {macro_blocks} of a mechanism drawn by hand; "
        f"{taken} and would bear {1 / apart:.3g} times the acceleration: bricks count there as macro-blocks"
    )
    return 1.0, first / total, (words,)


def side_wall_friction(
    *,
    courses: int,
    height: float,
    overlap: float,
    thickness: float,
    unit_weight: float,
    friction: float,
    phi: float | None = None,
) -> float:
    """Return the friction force of one side wall that a facade tears itself from, by the Circolare 7/2019, C8.7.1.2.

    Parameters
    ----------
    courses : int
        n, the courses above the hinge in which facade and side wall interlock.
    height : float
        Height of a course [m].
    overlap : float
        l, length by which the blocks of two courses overlap [m].
    thickness : float
        t_s of the side wall [m].
    unit_weight : float
        W of its masonry [N/m3].
    friction : float
        mu.
    phi : float, optional
        The coefficient Phi of the formula; height / overlap by default (see the notes).

    Returns
    -------
    float
        F [N]. As a permanent load against the push, 2/3 of these courses below their top, it enters a limit load.

    Raises
    ------
    InputError
        For a number that is not above 0, and for courses that are not a whole number.

    Notes
    -----
    `F = 0.4 n (n + 1) Phi mu l^2 t_s W` (C8.7.1.2). The k-th joint from the top bears k courses of the stepped crack on
    its area l t_s, so that friction in all of them is

        mu W h l t_s (1 + ... + n) = 0.5 n (n + 1) (h / l) mu l^2 t_s W.

    The Circolare takes four fifths of it. The force of a joint grows with its depth, so the resultant lies at 2/3.

    References
    ----------
    Circolare 21 gennaio 2019, n. 7 C.S.LL.PP., C8.7.1.2.1.

    Examples
    --------
    >>> from blockstat import side_wall_friction
    >>> wall = {"courses": 12, "height": 0.30, "overlap": 0.25, "thickness": 0.5}
    >>> round(side_wall_friction(**wall, unit_weight=18e3, friction=0.577), 2)
    24303.24
    """
    check_count("courses", courses)
    numbers = {
        "height": height, "overlap": overlap, "thickness": thickness, "unit_weight": unit_weight, "friction": friction,
    }  # fmt: skip
    for name, value in numbers.items():
        check_positive(name, value)
    phi = height / overlap if phi is None else phi
    check_positive("phi", phi)
    return 0.4 * courses * (courses + 1) * phi * friction * overlap**2 * thickness * unit_weight


def moving_bodies(limit: LimitLoad) -> list[Ints]:
    """Return the bodies of a mechanism: moving blocks that touch and move as one.

    Parameters
    ----------
    limit : LimitLoad
        With its mechanism.

    Returns
    -------
    list of array of int
        Blocks of each body.

    Notes
    -----
    Two blocks move as one when the corners of both would move alike with either of them. Blocks that move alike with
    the ground are no part of the mechanism.

    A mechanism whose bound is within a share g of the optimum may be as far as sqrt(g) from the best one, because
    friction cones are curved. So motions below sqrt(g) of the mean speed sum P v^2 / sum P v are not proven to be part
    of it. Merging bodies raises e*, and so does leaving out weights that move by less than about e*/2 of the mean
    speed: both are on the safe side.
    """
    assembly, motion = limit.assembly, limit.mechanism
    fastest, unproven = _speeds(limit)
    moving = fastest > unproven
    pairs = limit.interfaces.pair
    pairs = pairs[moving[pairs].all(axis=1)]
    together = np.array([_as_one(assembly, motion, a, b, unproven) for a, b in pairs], dtype=bool)
    _, label = connected_components(assembly.n_blocks, pairs[together] if len(pairs) else pairs)
    return [np.flatnonzero((label == k) & moving) for k in np.unique(label[moving])]


def _speeds(limit: LimitLoad) -> tuple[Floats, float]:
    """The speed of the fastest corner of each block, and up to which speed a motion is not proven."""
    assembly = limit.assembly
    own = assembly.vertex_block
    speed = np.linalg.norm(point_velocity(assembly, limit.mechanism, own, assembly.vertices), axis=1)
    fastest = np.maximum.reduceat(speed, assembly.vertex_start[:-1])
    momentum = assembly.mass * fastest
    mean = float(momentum @ fastest) / max(float(momentum.sum()), 1e-300)
    return fastest, max(TOGETHER, float(np.sqrt(limit.gap))) * mean


def _opens_as_it_slides(limit: LimitLoad) -> bool:
    """Whether a contact point of the mechanism slides and opens at the rate of associated friction."""
    _, unproven = _speeds(limit)
    rate = relative_motion(limit.assembly, limit.interfaces, limit.mechanism)
    friction = np.minimum(joint_friction(limit.assembly, limit.interfaces), STICKS)[limit.interfaces.point_interface]
    opening = friction * np.hypot(rate[:, 1], rate[:, 2])
    return bool(((opening > unproven) & (np.abs(rate[:, 0] - opening) <= unproven)).any())


def _as_one(assembly: Assembly, motion: Floats, a: int, b: int, unproven: float) -> bool:
    """Whether two blocks have one motion, up to what is not proven."""
    corners = np.concatenate([assembly.block_vertices(a), assembly.block_vertices(b)])
    with_a, with_b = (point_velocity(assembly, motion, np.full(len(corners), k), corners) for k in (a, b))
    return bool(np.abs(with_a - with_b).max() <= unproven)


def work_sums(
    assembly: Assembly,
    mechanism: Floats,
    direction: Sequence[float],
    bodies: Sequence[Ints],
    masses: Sequence[tuple[int | str, Sequence[float], float]],
) -> tuple[float, float, float]:
    """Return the sums over bodies of P, P d and P d^2, d the displacement of the weights of a body.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    mechanism : array, shape (n_blocks, 6)
        Virtual displacements [m, rad].
    direction : sequence of float, shape (3,)
        Of d.
    bodies : sequence of array of int
        Blocks that move as one.
    masses : sequence of (block, point, weight)
        As in `linear_check`.

    Returns
    -------
    total, first, second : float
        [N], [N m], [N m2].

    Raises
    ------
    InputError
        For a bad direction, or one that the mechanism does not move along, and for bad masses.
    """
    unit = check_vector("direction", direction)
    unit = unit / np.linalg.norm(unit)
    load = assembly.mass * gravity_of(assembly)[0]
    work = load * (mechanism[:, :3] @ unit)
    for block, place, weight in mass_points(assembly, masses):
        load[block] += weight
        work[block] += weight * (point_velocity(assembly, mechanism, np.array([block]), place[None]) @ unit)[0]
    sums = np.array([(load[body].sum(), work[body].sum()) for body in bodies]).reshape(-1, 2)
    total, first = sums.sum(axis=0)
    second = float((sums[:, 1] ** 2 / sums[:, 0]).sum())
    if not first > 0:
        raise InputError(f"the mechanism does not move along {list(direction)}; give the direction of its load")
    return float(total), float(first), second


def check_level(assembly: Assembly, direction: Sequence[float]) -> None:
    """Check that a direction is horizontal.

    Parameters
    ----------
    assembly : Assembly
        Has the gravity.
    direction : sequence of float, shape (3,)
        Of an acceleration.

    Raises
    ------
    InputError
        For a bad direction, and one that is not horizontal.
    """
    gravity, along = assembly.gravity, check_vector("direction", direction)
    if abs(gravity @ along) > LEVEL * np.linalg.norm(gravity) * np.linalg.norm(along):
        raise InputError(f"direction is {[*map(float, along)]}; the acceleration of the code is horizontal")


def check_demand(name: str, demand: float) -> None:
    """Check that a ground acceleration asked for is a finite number above 0.

    Parameters
    ----------
    name : str
        What users read.
    demand : float
        In units of g.

    Raises
    ------
    InputError
        For anything else.
    """
    if isinstance(demand, bool) or not isinstance(demand, (int, float, np.number)) or not 0 < demand < np.inf:
        raise InputError(f"{name} is {demand!r}; it must be above 0")


def bearable(demand: Callable[[float], float], acceleration: float) -> float:
    """Return the peak ground acceleration up to which a demand is borne.

    Parameters
    ----------
    demand : callable
        Acceleration for a peak ground acceleration, both in units of g.
    acceleration : float
        What is borne, in units of g.

    Returns
    -------
    float
        The largest that is borne with all below it, in units of g, at most `GREATEST`.
    """
    from scipy.optimize import brentq, minimize_scalar

    def lacking(ag: float) -> float:
        return demand(ag) - acceleration

    def root(low: float, high: float) -> float:
        found: Any = brentq(lacking, low, high, xtol=1e-14)
        return float(found)

    before: list[tuple[float, float]] = [(0.0, lacking(0.0))]
    for ag in map(float, STEPS):
        value = lacking(ag)
        if len(before) > 1 and before[-2][1] <= before[-1][1] >= value:  # a peak between two steps
            ends = (before[-2][0], ag)
            found: Any = minimize_scalar(lambda x: -lacking(x), bounds=ends, method="bounded", options={"xatol": 1e-12})
            peak = float(found.x)
            if lacking(peak) > 0:
                return root(ends[0], peak)
        if value > 0:
            return root(before[-1][0], ag)
        before = [before[-1], (ag, value)]
    return GREATEST


def is_borne(needed: Callable[[float], float], acceleration: float, ag: float, demand: float | None) -> bool | None:
    """Return whether a demand is borne at its own ground acceleration.

    Parameters
    ----------
    needed : callable
        As `demand` of `bearable`.
    acceleration : float
        What is borne, in units of g.
    ag : float
        What `bearable` returns of the two.
    demand : float or None
        Ground acceleration asked for, in units of g.

    Returns
    -------
    bool or None
        None without a demand.
    """
    return None if demand is None else bool(demand <= ag or needed(demand) <= acceleration)
