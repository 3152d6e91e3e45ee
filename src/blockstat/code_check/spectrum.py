"""Elastic spectra of NTC 2018, 3.2.3.2.1, and floor spectra of Circolare 7/2019, C7.2.3 and C8.7.1.2.1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.errors import InputError, check_choice, check_number, check_positive
from blockstat.loads import numbers

#: Table 3.2.IV: least S_S, a and b of `S_S = a - b F0 ag/g`, greatest S_S; and p, q of `C_C = p TC*^q`.
SOILS = {
    "A": (1.0, 1.0, 0.0, 1.0, 1.0, 0.0),
    "B": (1.0, 1.4, 0.4, 1.2, 1.1, -0.2),
    "C": (1.0, 1.7, 0.6, 1.5, 1.05, -0.33),
    "D": (0.9, 2.4, 1.5, 1.8, 1.25, -0.5),
    "E": (1.0, 2.0, 1.1, 1.6, 1.15, -0.4),
}


@dataclass(frozen=True)
class Site:
    """What the spectrum of a site needs besides its peak ground acceleration.

    Examples
    --------
    >>> from blockstat import Site
    >>> Site(soil="B", f0=2.5, tc_star=0.3).amplification(0.1)
    1.2
    """

    soil: str = "A"  #: category of the ground, A to E
    f0: float = 2.5  #: F0, greatest spectral amplification [-]
    tc_star: float = 0.3  #: TC* [s]
    topography: float = 1.0  #: S_T [-]

    def __post_init__(self) -> None:
        check_choice("soil", self.soil, SOILS)
        # F0 below 1 and S_T below 1 would ask for less than the ground does; TC* is in seconds.
        for name, least, most in (("f0", 1.0, 10.0), ("tc_star", 0.01, 5.0), ("topography", 1.0, 3.0)):
            check_number(f"site: {name}", getattr(self, name), least=least, most=most)

    @property
    def words(self) -> str:
        """The site in words."""
        return f"soil {self.soil}, S_T {self.topography:g}, F0 {self.f0:g}, TC* {self.tc_star:g} s"

    def amplification(self, ag: float) -> float:
        """Return S = S_S S_T.

        Parameters
        ----------
        ag : float
            Peak ground acceleration on rock, in units of g.

        Returns
        -------
        float
            S [-].
        """
        least, a, b, greatest, _, _ = SOILS[self.soil]
        return float(np.clip(a - b * self.f0 * ag, least, greatest)) * self.topography

    def spectrum(self, ag: float, period: float, *, damping: float = 5.0) -> float:
        """Return the elastic spectral acceleration S_e(T) in units of g (NTC 2018, 3.2.2).

        Parameters
        ----------
        ag : float
            Peak ground acceleration on rock, in units of g.
        period : float
            T [s]; 0 gives `ag S`.
        damping : float, optional
            xi [per cent].

        Returns
        -------
        float
            S_e / g.
        """
        *_, p, q = SOILS[self.soil]
        tc = p * self.tc_star**q * self.tc_star
        tb, td = tc / 3.0, 4.0 * ag + 1.6
        eta = damping_factor(damping)
        plateau = ag * self.amplification(ag) * eta * self.f0
        if period < tb:
            return plateau * (period / tb + (1.0 - period / tb) / (eta * self.f0))
        if period < tc:
            return plateau
        return plateau * tc / period * (1.0 if period < td else td / period)


@dataclass(frozen=True)
class SpectrumTable:
    """An elastic spectrum given by values, in place of that of a site.

    Its peak ground acceleration is its value at the period 0.

    Examples
    --------
    >>> from blockstat import SpectrumTable
    >>> table = SpectrumTable(periods=(0.0, 0.1, 0.5, 2.0), values=(0.15, 0.4, 0.4, 0.1))
    >>> round(table.spectrum(0.30, 0.2), 6)
    0.8
    """

    periods: tuple[float, ...]  #: ascending from 0 [s]
    values: tuple[float, ...]  #: S_e at 5 % damping, in units of g

    def __post_init__(self) -> None:
        periods, values = numbers(self.periods), numbers(self.values)
        if periods.ndim != 1 or periods.shape != values.shape or len(periods) < 2:
            raise InputError("spectrum: periods and values must be as many numbers, two at least")
        if not (np.isfinite(periods).all() and (np.diff(periods) > 0).all() and periods[0] == 0):
            raise InputError("spectrum: periods must ascend from 0")
        if not (np.isfinite(values).all() and (values >= 0).all() and values[0] > 0):
            raise InputError("spectrum: values must be at least 0, and above 0 at the period 0")

    @property
    def words(self) -> str:
        """The table in words."""
        return f"ground with a spectrum of {len(self.periods)} values"

    def spectrum(self, ag: float, period: float, *, damping: float = 5.0) -> float:
        """Return the spectral acceleration S_e(T) in units of g, with all values scaled to a peak ground acceleration.

        Up to the period T_B of the greatest value, damping takes from it in proportion to T, as in NTC 2018, 3.2.2, and
        nowhere leaves less than the factor eta does.

        Parameters
        ----------
        ag : float
            Value at T = 0, in units of g.
        period : float
            T [s]; beyond the last period the velocity is that of the last, as between T_C and T_D of the code. Beyond
            T_D that asks for too much; of a table that ends before T_C for too little.
        damping : float, optional
            xi [per cent].

        Returns
        -------
        float
            S_e / g.
        """
        last, eta, first = self.periods[-1], damping_factor(damping), int(np.argmax(self.values))
        value = float(np.interp(period, self.periods, self.values)) * last / max(period, last)
        if period < self.periods[first]:
            less = value - (1.0 - eta) * self.values[first] * period / self.periods[first]
            value = max(less, eta * value)
        elif period:
            value *= eta
        return ag / self.values[0] * value


#: What gives `spectrum(ag, period, damping=)`.
Spectrum = Site | SpectrumTable


def table_ends(ground: Spectrum, period: float) -> tuple[str, ...]:
    """Return what to say of a period beyond a table that ends on its plateau.

    Parameters
    ----------
    ground : Site or SpectrumTable
        The spectrum.
    period : float
        T at which it is taken [s].

    Returns
    -------
    tuple of str
        A warning that too little may be asked for, or none.
    """
    if isinstance(ground, Site) or period <= ground.periods[-1] or ground.values[-1] < max(ground.values):
        return ()
    return (
        f"the spectrum ends at {ground.periods[-1]:g} s with its greatest value and is taken beyond, where it may ask "
        f"for less than is due; give it beyond its plateau",
    )


def spectrum_of(site: Any, what: str = "site") -> Spectrum:
    """Return the ground of a verification.

    Parameters
    ----------
    site : object
        What was given; None for rock.
    what : str, optional
        What it is; the message of an error begins with it.

    Returns
    -------
    Site or SpectrumTable
        The ground.

    Raises
    ------
    InputError
        For anything else.
    """
    if site is None:
        return Site()
    if not isinstance(site, Spectrum):
        raise InputError(f"{what} is {site!r}; it must be a Site or a SpectrumTable")
    return site


@dataclass(frozen=True)
class Floor:
    """Where in a building a mechanism stands, for the floor spectrum of Circolare 7/2019.

    Examples
    --------
    >>> from blockstat import Floor
    >>> round(Floor(period=0.281170663, own_period=0.174556213, gamma=1.2).factor(), 6)
    4.369598
    """

    period: float  #: T1, fundamental period of the building [s]
    own_period: float  #: T0, of the part that may overturn, before it does [s]
    gamma: float  #: modal participation, 3n/(2n + 1) for n storeys [-]
    psi: float = 1.0  #: modal displacement at the height of the part: z/H [-]
    damping: float = 5.0  #: xi1 of the building [per cent]
    own_damping: float = 5.0  #: xi of the part [per cent]

    def __post_init__(self) -> None:
        for name in ("period", "own_period", "gamma", "psi", "damping", "own_damping"):
            check_positive(f"floor: {name}", getattr(self, name))

    def factor(self) -> float:
        """Return S_eZ(T0) / S_e(T1), one mode of the building.

        Returns
        -------
        float
            Amplification from the ground spectrum at T1 to the floor spectrum at T0 [-].

        Notes
        -----
        The peak is `m = 1.1 xi1^-0.5 eta(xi)` with xi1 as a fraction (as per cent, which the source says, resonance
        would reduce the acceleration), and the acceleration of the floor is
        `a_Z = S_e(T1, xi1) gamma psi sqrt(1 + 0.0004 xi1^2)` with xi1 in per cent (C7.2.6, C7.2.7).
        """
        rigid = self.gamma * self.psi * float(np.sqrt(1.0 + 0.0004 * self.damping**2))
        peak = 1.1 / float(np.sqrt(self.damping / 100.0)) * damping_factor(self.own_damping)
        low, high = 0.8 * self.period, 1.1 * self.period
        off = 0.0
        if self.own_period < low:
            off = (1.0 - self.own_period / low) ** 1.6
        elif self.own_period > high:
            off = (self.own_period / high - 1.0) ** 1.2
        return rigid * peak / (1.0 + (peak - 1.0) * off)

    def spectrum(self, ground: Spectrum, ag: float) -> float:
        """Return the acceleration S_eZ(T0) of the part in units of g (C7.2.5).

        Parameters
        ----------
        ground : Site or SpectrumTable
            The spectrum at the foot of the building, taken at T1 with the damping of the building.
        ag : float
            Peak ground acceleration, in units of g.

        Returns
        -------
        float
            S_eZ / g; beyond T1 at least the S_e of the ground at T0, with the damping of the part.
        """
        above = self.factor() * ground.spectrum(ag, self.period, damping=self.damping)
        if self.own_period <= self.period:
            return above
        return max(above, ground.spectrum(ag, self.own_period, damping=self.own_damping))


def damping_factor(damping: float) -> float:
    """Return eta = sqrt(10 / (5 + xi)), at least 0.55.

    Parameters
    ----------
    damping : float
        xi [per cent].

    Returns
    -------
    float
        eta [-].
    """
    return max(float(np.sqrt(10.0 / (5.0 + damping))), 0.55)


def check_floor(floor: Any) -> None:
    """Check that what was given as a floor is one, or None.

    Parameters
    ----------
    floor : object
        What was given.

    Raises
    ------
    InputError
        For anything else.
    """
    if floor is not None and not isinstance(floor, Floor):
        raise InputError(f"floor is {floor!r}; it must be a Floor")
