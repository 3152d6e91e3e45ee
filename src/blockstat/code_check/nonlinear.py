"""The nonlinear verification of a collapse mechanism from its capacity curve, Circolare 7/2019, C8.7.1.2.1.

    e* = (sum P d)^2 / (sum P sum P d^2)         C8.7.1.5
    a  = alpha g / (e* FC)                       C8.7.1.3
    d  = d_C sum P d^2 / (d_C' sum P d)          C8.7.1.4, d_C' the virtual displacement of the control
    SLD: a_Z = a0                                C8.7.1.8, or S_eZ(T0) = a0, C8.7.1.9
    d_SLV = 0.4 d0,  T_SLV = 1.68 pi sqrt(d_SLV / a(d_SLV)),  damping 8 %
    d_SLC = 0.6 d0,  T_SLC = 1.56 pi sqrt(d_SLC / a(d_SLC)),  damping 10 %

The demand is the displacement `S_e(T) (T / 2 pi)^2`, of the ground, or of the floor that a part stands on. Blocks that
move as one body count as one (see `blockstat.code_check.linear`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.verdict import mechanism_words
from blockstat.code_check.linear import (
    MACRO_BLOCKS,
    CheckOutcome,
    arbitrary,
    asked_for,
    bearable,
    bodies_in_words,
    check_demand,
    check_factors,
    check_level,
    check_outcome,
    high_up,
    is_borne,
    mechanism_summary,
    moving_bodies,
    oscillator,
    work_sums,
)
from blockstat.code_check.pushed import G, check_metres, check_pushed, gravity_of, mean_displacement
from blockstat.code_check.rocking import RockingBlock, rocking_block
from blockstat.code_check.spectrum import Floor, Spectrum, check_floor, spectrum_of, table_ends
from blockstat.errors import InputError, check_choice, known_options
from blockstat.large_displacement.capacity_curve import CapacityCurve, CapacityOutcome
from blockstat.large_displacement.displaced.loads import moved_with_centroids
from blockstat.loads import Loads
from blockstat.result import Result

#: Share of d0, factor of pi sqrt(d / a) and damping [per cent] of the limit states with a displacement.
STATES = {"SLV": (0.4, 1.68, 8.0), "SLC": (0.6, 1.56, 10.0)}
#: The control goes back where it does so by more than this part of its largest displacement: more than the error of
#: a pose.
BACK = 1e-3
#: A block that turns has lost .4 of its multiplier at d_SLV = .4 d0, one that slides none. Chosen between: a mechanism
#: that keeps more than this slides.
FALLEN = 0.9
#: A drop that leaves less than this part of the multiplier ends life safety. It is between two points of a curve that
#: are no further apart than `AT_ONCE`, relative to its largest displacement: a step of a curve as it is by default.
REMAINS, AT_ONCE = 0.5, 1.0 / 30.0
#: Of two walls of one multiplier that move at v, d0 of the mixture by straight lines is (sum P v)^2 / (sum P times
#: sum P v^2 / d0): at most the mean of both d0, but it may be above the lesser one.
MIXED = (
    "the curve follows a mixture of mechanisms, and one of them may end at a lesser d0: no demand on its displacement "
    "is verified; draw the blocks that are to rest as supports, or those that are to move as one as one block"
)


@dataclass(frozen=True)
class LimitState:
    """One limit state of the oscillator."""

    name: str  #: SLD, SLV or SLC
    displacement: float  #: d [m]; 0 for SLD
    acceleration: float  #: a [m/s2]
    period: float  #: T [s]; 0 for SLD on the ground
    damping: float  #: [per cent]
    ag: float  #: peak ground acceleration up to which all are borne, in units of g
    demand: float | None  #: what is asked for, in units of g
    satisfied: bool | None  #: whether that is borne; None without one, and where the check is not verified


@dataclass(frozen=True, eq=False)
class NonlinearCheck(Result):
    """The nonlinear verification of a mechanism and the figures that it rests on."""

    alpha0: float  #: multiplier at rest [-]; where the curve begins by self-stress alone, that without
    participation: float  #: e* that the verification takes [-]; 1 where all bodies are taken as one
    apart: float  #: e* of the bodies apart [-]
    mass: float  #: M* [kg]
    acceleration: float  #: a0 [m/s2]
    ultimate: float  #: d0, displacement of the oscillator where its acceleration is zero [m]
    confidence: float  #: FC [-]
    shape: str  #: "curve" or "line"
    states: tuple[LimitState, ...]  #: SLD, SLV, SLC
    bodies: tuple[tuple[int, ...], ...]  #: blocks that move as one, for each body of the mechanism
    rocking: RockingBlock | None  #: where there is one body
    limit: LimitLoad  #: of the curve at rest, with the mechanism that is verified
    warnings: tuple[str, ...] = ()

    @property
    def outcome(self) -> CheckOutcome:
        """Whether all demands that are given are borne."""
        return check_outcome([state.satisfied for state in self.states if state.demand is not None])

    def state(self, name: str) -> LimitState:
        """Return a limit state.

        Parameters
        ----------
        name : str
            SLD, SLV or SLC.

        Returns
        -------
        LimitState
            Its displacement, acceleration, period and ground acceleration.

        Raises
        ------
        InputError
            For another name.
        """
        check_choice("state", name, [state.name for state in self.states])
        return next(state for state in self.states if state.name == name)

    def explain(self) -> str:
        """Return the verification in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        told = {
            CheckOutcome.CAPACITY: CheckOutcome.CAPACITY.value,
            CheckOutcome.SATISFIED: "Satisfied: all demands are borne.",
            CheckOutcome.NOT_SATISFIED: "Not satisfied: a demand is not borne.",
            CheckOutcome.NOT_VERIFIED: "Not verified: all demands are borne without the inertia of permanent loads, "
            "whose mass is left out.",
        }
        lines = [
            told[self.outcome],
            f"alpha0 = {self.alpha0:.6g}, {bodies_in_words(self.bodies)}, e* = {self.participation:.6g}, "
            f"M* = {self.mass:.6g} kg (C8.7.1.5).",
            f"a0 = alpha0 g / (e* FC) = {self.acceleration:.6g} m/s2, FC = {self.confidence:g} (C8.7.1.3).",
            f"d0 = {self.ultimate:.6g} m (C8.7.1.4); multipliers of the {self.shape}.",
            *mechanism_words(self.limit.assembly, self.limit.joints(), self.limit.moving),
        ]
        for state in self.states:
            where = (
                f"a = {state.acceleration:.6g} m/s2 (C8.7.1.8, C8.7.1.9)"
                if not state.displacement
                else f"d = {state.displacement:.6g} m, a = {state.acceleration:.6g} m/s2, T = {state.period:.6g} s, "
                f"damping {state.damping:g} % (C8.7.1.10 to C8.7.1.12)"
            )
            asked = asked_for(state.demand, state.satisfied, state.ag)
            lines.append(f"{state.name}: {where}: ag = {state.ag:.6g} g{asked}.")
        if self.rocking is not None:
            lines.append(
                f"One rocking block: R = {self.rocking.radius:.6g} m, slenderness {self.rocking.slenderness:.6g} rad, "
                f"p = {self.rocking.frequency:.6g} 1/s."
            )
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
            "alpha0": self.alpha0,
            "e_star": self.participation,
            "e_star_apart": self.apart,
            "m_star": self.mass,
            "a0_star": self.acceleration,
            "d0_star": self.ultimate,
            "fc": self.confidence,
            "shape": self.shape,
            "states": {
                state.name: {
                    "d": state.displacement,
                    "a": state.acceleration,
                    "T": state.period,
                    "damping": state.damping,
                    "ag": state.ag,
                    "demand": state.demand,
                    "satisfied": state.satisfied,
                }
                for state in self.states
            },
            "bodies": len(self.bodies),
            **mechanism_summary(self.limit),
            "housner": None
            if self.rocking is None
            else {"R": self.rocking.radius, "alpha": self.rocking.slenderness, "p": self.rocking.frequency},
            "warnings": list(self.warnings),
        }


@known_options
def nonlinear_check(
    curve: CapacityCurve,
    direction: Sequence[float],
    *,
    site: Spectrum | Mapping[str, Spectrum] | None = None,
    confidence: float = 1.35,
    masses: Sequence[tuple[int | str, Sequence[float], float]] = (),
    loads: Loads | None = None,
    floor: Floor | None = None,
    shape: str = "curve",
    demand: Mapping[str, float] | None = None,
    macro_blocks: int = MACRO_BLOCKS,
) -> NonlinearCheck:
    """Verify a mechanism from its capacity curve: acceleration (SLD) and displacements (SLV, SLC).

    Parameters
    ----------
    curve : CapacityCurve
        Of a horizontal acceleration of all that has mass.
    direction : sequence of float, shape (3,)
        Direction of the acceleration.
    site : Site, SpectrumTable or mapping, optional
        Ground and spectrum; rock with F0 = 2.5 by default. F0 and TC* belong to a return period: a mapping has one
        spectrum for each of "SLD", "SLV" and "SLC".
    confidence : float, optional
        FC; 1.35 where the crushing of stone is left out.
    masses, loads : optional
        As in `blockstat.linear_check`.
    floor : Floor, optional
        For a part high up in a building. Its `own_period` T0 counts for SLD; for the others it is their T, with their
        damping.
    shape : str, optional
        The code leaves the choice: "curve" takes multipliers off the curve; "line" takes alpha0 (1 - d / d0).
    demand : mapping, optional
        ag asked for by limit state, in units of g, as {"SLV": 0.15}.
    macro_blocks : int, optional
        As in `blockstat.linear_check`. Taken as one body, a mechanism has a lower a0 and a lower d0.

    Returns
    -------
    NonlinearCheck
        The oscillator, the ground accelerations that it bears, and whether the demands are met.

    Raises
    ------
    InputError
        For a curve that was interrupted, is of another load or drops as soon as the mechanism moves, for a gravity
        above one and a half of 9.81 m/s2, as in a scene that is in millimetres, for a direction that is not horizontal,
        or a bad value.

    References
    ----------
    Circolare 21 gennaio 2019, n. 7 C.S.LL.PP., C8.7.1.2.1. NTC 2018 (D.M. 17 gennaio 2018), 3.2.3.2.1. Housner: The
    behavior of inverted pendulum structures during earthquakes, 1963.

    Notes
    -----
    d0 is where the curve is zero, or where it ends before that because no admissible state follows or, on the safe
    side, where the control or the mean of the masses begins to go back. A drop of the curve that leaves less than half
    of the multiplier bounds d_SLV, and so does a block that falls out, such as a beam that loses its bearing: the
    multiplier is then the one after it. Where the curve rises again its least multiplier before counts, on the safe
    side, and so does what is carried without self-stress where the curve begins above it. Demands on the displacement
    are not verified where the multiplier hardly falls, as when a block slides, where the curve took loads to act at the
    centroids of their blocks, or where it follows a mixture of several mechanisms of one multiplier. The method is
    calibrated for mechanisms whose points move parallel to one plane.

    Examples
    --------
    A wall 4 m high and 0.5 m thick.

    >>> from blockstat import Assembly, Site, box, capacity, nonlinear_check
    >>> blocks = [box((-1, -1, -1), (2, 4, 0), name="ground"), box((0, 0, 0), (0.5, 3, 4), name="wall")]
    >>> curve = capacity(Assembly.from_blocks(blocks, supports=["ground"]), (1, 0, 0), control="wall")
    >>> found = nonlinear_check(curve, (1, 0, 0), site=Site("B"), shape="line")
    >>> [f"{state.ag:.6f}" for state in found.states]
    ['0.077160', '0.162041', '0.237594']
    """
    check_choice("shape", shape, ("curve", "line"))
    check_factors(confidence, macro_blocks)
    if curve.outcome not in (CapacityOutcome.ZERO, CapacityOutcome.COLLAPSE):
        raise InputError(f"the capacity curve does not tell where the multiplier is zero. {curve.outcome.value}")
    asked = _demands(demand)
    check_metres(curve.assembly)
    check_level(curve.assembly, direction)
    ground = _spectra(site)
    check_floor(floor)
    curve, back = _forward(curve, direction, masses)
    dropped, after = _lost(curve)
    if not (curve.lower[0] > 0 and curve.displacement[-1] > 0 and dropped > 0):
        raise InputError("as soon as the mechanism moves the multiplier drops to less than half: there is no capacity")
    limit = replace(curve.limit, mechanism=curve.points[0].mechanism)  # joints of a curve slide as its flow has it
    bodies = moving_bodies(limit)
    sums = work_sums(curve.assembly, limit.mechanism, direction, bodies, masses)
    push, idle, weightless = check_pushed(curve.limit, direction, masses, loads)
    reason, mixture = arbitrary(limit, bodies, push, macro_blocks)
    share, per_control, told = oscillator(sums, bodies, macro_blocks, reason)
    displacement = per_control * curve.displacement
    gravity, unit = gravity_of(curve.assembly)
    per_multiplier = gravity / (share * confidence)
    most = np.inf if curve.without_self_stress is None else curve.without_self_stress[0]
    acceleration = np.minimum(curve.lower, most) * per_multiplier
    high = high_up(limit, bodies) if floor is None else ()
    ultimate, warnings = float(displacement[-1]), [*curve.warnings, *told, *high, *idle, *weightless, *unit, *back]
    if curve.outcome is CapacityOutcome.COLLAPSE and not back:
        warnings.append("the curve ends before the multiplier is zero; d0 is its end")
    if len(asked) > 1 and not isinstance(site, Mapping):
        warnings.append(
            f"F0 and TC* are those of one return period for {', '.join(sorted(asked))}; site= takes one for each"
        )

    def borne(there: float, bounded: bool) -> float:
        if shape == "line":
            return float(acceleration[0]) * (1.0 - there / ultimate)
        return per_multiplier * min(most, after if bounded else _least_up_to(curve, there / per_control))

    states = [_damage(float(acceleration[0]), ground["SLD"], floor, asked.get("SLD"))]
    for name, (part, factor, damping) in STATES.items():
        bounded = name == "SLV" and per_control * dropped <= part * ultimate
        there = per_control * dropped if bounded else part * ultimate
        held = borne(there, bounded)
        period = factor * np.pi * float(np.sqrt(there / held))
        states.append(_displaced(name, there, held, period, damping, ground[name], floor, asked.get(name)))
    for state in states:
        warnings += table_ends(ground[state.name], state.period if floor is None else max(state.period, floor.period))
    warnings += (slides := _slides(curve))
    warnings += [MIXED] if mixture else []
    doubted = ["SLD", *STATES] if idle else [*STATES] if mixture or slides or _at_centroids(curve) else []
    states = [replace(one, satisfied=None) if one.satisfied and one.name in doubted else one for one in states]
    return NonlinearCheck(
        alpha0=float(min(curve.lower[0], most)),
        participation=share,
        apart=sums[1] ** 2 / (sums[0] * sums[2]),
        mass=share * sums[0] / gravity,
        acceleration=float(acceleration[0]),
        ultimate=ultimate,
        confidence=confidence,
        shape=shape,
        states=tuple(states),
        bodies=tuple(tuple(int(block) for block in body) for body in bodies),
        limit=limit,
        rocking=rocking_block(curve.assembly, limit.mechanism, bodies, masses),
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _demands(demand: Mapping[str, float] | None) -> dict[str, float]:
    """The ground acceleration asked for by limit state."""
    if demand is not None and not isinstance(demand, Mapping):
        raise InputError(f'demand is {demand!r}; give it by limit state, such as {{"SLV": 0.15}}')
    for name, value in (asked := dict(demand or {})).items():
        check_choice("demand", name, ("SLD", *STATES))
        check_demand(f"demand of {name}", value)
    return asked


def _spectra(site: Spectrum | Mapping[str, Spectrum] | None) -> Mapping[str, Spectrum]:
    """The spectrum of each limit state."""
    names = ("SLD", *STATES)
    if not isinstance(site, Mapping):
        return dict.fromkeys(names, spectrum_of(site))
    for name in site:
        check_choice("site", name, names)
    if missing := [name for name in names if name not in site]:
        raise InputError(f"site has no spectrum of {', '.join(missing)}; a mapping has one of {', '.join(names)}")
    return {name: spectrum_of(own, f"site of {name}") for name, own in site.items()}


def _forward(
    curve: CapacityCurve, direction: Sequence[float], masses: Sequence[tuple[int | str, Sequence[float], float]]
) -> tuple[CapacityCurve, list[str]]:
    """The curve up to where its control or the mean of its masses begins to go back, and what is to be said of that.

    The work of the load belongs to the mean of the masses. A control may go on falling while all else comes back.
    """
    along = mean_displacement(curve.assembly, [point.pose for point in curve.points], direction, masses)
    kept = {}
    for name, there in ((curve.control, curve.displacement), ("mean of the masses", along)):
        furthest = np.maximum.accumulate(there)
        back = np.flatnonzero(there < furthest - BACK * furthest[-1])
        if len(back):
            kept[name] = int(np.argmax(there[: back[0]])) + 1
    if not kept:
        return curve, []
    name = min(kept, key=lambda each: kept[each])
    far = curve.displacement[kept[name] - 1]
    metres = "m" if name == curve.control else "m of the control"
    told = f"the {name} goes back from {far:.4g} {metres} on, which d0 is taken for (on the safe side)"
    return replace(curve, points=curve.points[: kept[name]]), [f'{told}; a curve with control="mean" may go further']


def _least_up_to(curve: CapacityCurve, there: float) -> float:
    """The least multiplier up to a displacement: a curve may rise again, where it falls and joints close."""
    before = curve.lower[curve.displacement <= there]
    return min(float(before.min()), float(curve.at(there)[0]))


def _slides(curve: CapacityCurve) -> tuple[str, ...]:
    """What to say where the multiplier has not fallen on the way to d_SLV."""
    share = STATES["SLV"][0]
    if _least_up_to(curve, share * curve.displacement[-1]) <= FALLEN * curve.lower[0]:
        return ()
    return (
        "the multiplier has hardly fallen at d_SLV: the mechanism slides, and where it ends depends on what it slides "
        "on; no demand on its displacement is verified",
    )


def _at_centroids(curve: CapacityCurve) -> bool:
    """Whether loads of the curve were taken to act at centroids, of which it warns."""
    wrenches = np.ones((curve.assembly.n_blocks, 6))
    told = moved_with_centroids(curve.assembly, {"load": wrenches, "loads": wrenches})
    return not set(told).isdisjoint(curve.warnings)


def _lost(curve: CapacityCurve) -> tuple[float, float]:
    """The displacement of the control at which much is lost for the first time, and the multiplier after it.

    That is where the multiplier drops, or a block falls out. Infinite and nan where neither happens.
    """
    there, lower = curve.displacement, curve.lower
    drops = (lower[1:] < REMAINS * lower[:-1]) & (np.diff(there) <= AT_ONCE * there.max())
    found = [(float(there[first]), float(lower[first + 1])) for first in np.flatnonzero(drops)[:1]]
    for fallen in curve.fallen:
        before, beyond = there < fallen.parameter, there >= fallen.parameter
        if before.any() and beyond.any():
            up_to = int(np.flatnonzero(before)[-1])
            found.append((float(there[up_to]), float(lower[: up_to + 2].min())))
    return min(found, default=(np.inf, np.nan))


def _damage(acceleration: float, site: Spectrum, floor: Floor | None, demand: float | None) -> LimitState:
    """The mechanism begins."""

    def at(ag: float) -> float:
        own = site.spectrum(ag, 0.0)
        return own if floor is None else max(own, floor.spectrum(site, ag))

    period, damping = (0.0, 5.0) if floor is None else (floor.own_period, floor.own_damping)
    borne = bearable(at, acceleration / G)
    satisfied = is_borne(at, acceleration / G, borne, demand)
    return LimitState("SLD", 0.0, acceleration, period, damping, borne, demand, satisfied)


def _displaced(
    name: str,
    displacement: float,
    acceleration: float,
    period: float,
    damping: float,
    site: Spectrum,
    floor: Floor | None,
    demand: float | None,
) -> LimitState:
    """The ag whose spectral displacement at the period is the displacement."""
    above = None if floor is None else replace(floor, own_period=period, own_damping=damping)

    def at(ag: float) -> float:
        own = site.spectrum(ag, period, damping=damping)
        return own if above is None else max(own, above.spectrum(site, ag))

    spectral = displacement * (2.0 * np.pi / period) ** 2 / G
    borne = bearable(at, spectral)
    satisfied = is_borne(at, spectral, borne, demand)
    return LimitState(name, displacement, acceleration, period, damping, borne, demand, satisfied)
