"""The lognormal fragility of collapse intensities that are known between two bounds each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.special import log_ndtr, ndtr, stdtrit

from blockstat.errors import InputError, check_number, known_options
from blockstat.loads import numbers
from blockstat.result import Result, Sentence, finite
from blockstat.typing import Floats

#: Records that a fragility needs: two have one difference, which says nothing on how sure a dispersion is.
FEWEST = 3
#: Rays on which the boundary of the confidence region is sought. The polygon lies inside the region, by 1e-6 of its
#: size where the boundary is round.
RAYS = 2880
#: Halvings of a ray: to 1e-9 of its length.
HALVINGS = 30
LOG_ROOT = 0.5 * np.log(2 * np.pi)


class FragilityOutcome(Sentence):
    """The answer of `fit_fragility`; the value is the sentence a user reads."""

    FITTED = "Fitted: a lognormal fragility by maximum likelihood."


@dataclass(frozen=True, eq=False)
class Fragility(Result):
    """Probability of collapse by intensity, `P = Phi(ln(intensity / median) / dispersion)`."""

    median: float  #: intensity at which half of the records fell a block, theta
    dispersion: float  #: standard deviation of the logarithm of the collapse intensity, beta
    median_interval: tuple[float, float]  #: contains the median with the confidence asked for
    dispersion_interval: tuple[float, float]
    confidence: float
    lower: Floats  #: largest intensity that each record is known to be carried at, shape (n_records,)
    upper: Floats  #: intensity at which it fell, shape (n_records,); inf for a record that never did
    region: Floats  #: boundary of the confidence region in (1 / beta, ln(theta) / beta), shape (n, 2)

    @property
    def outcome(self) -> FragilityOutcome:
        """What kind of answer this is."""
        return FragilityOutcome.FITTED

    def probability(self, intensity: ArrayLike) -> Floats:
        """Return the probability of collapse.

        Parameters
        ----------
        intensity : float or array of float
            Intensities above 0, in the unit of the bounds that were fitted.

        Returns
        -------
        array of float
            Of the same shape.

        Raises
        ------
        InputError
            For an intensity below 0.
        """
        given = np.asarray(intensity, dtype=float)
        if not (given >= 0).all():
            raise InputError(f"intensity is {intensity!r}; each must be at least 0")
        with np.errstate(divide="ignore"):
            return ndtr(np.log(given / self.median) / self.dispersion)

    def band(self, intensity: ArrayLike) -> tuple[Floats, Floats]:
        """Return the confidence interval of the probability of collapse at each intensity by itself.

        Parameters
        ----------
        intensity : float or array of float
            Intensities above 0, in the unit of the bounds that were fitted.

        Returns
        -------
        low, high : array of float
            Of the same shape.
        """
        slope, offset = self.region.T
        z = np.log(np.asarray(intensity, dtype=float))[..., None] * slope - offset
        return ndtr(z.min(axis=-1)), ndtr(z.max(axis=-1))

    def explain(self) -> str:
        """Return the median and the dispersion in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        (low, high), (narrow, wide) = self.median_interval, self.dispersion_interval
        fell = int(np.isfinite(self.upper).sum())
        return "\n".join(
            [
                self.outcome.value,
                f"Median theta = {self.median:.4g}; with {self.confidence:.0%} confidence {low:.4g} to {high:.4g}.",
                f"Dispersion beta = {self.dispersion:.3g}; with {self.confidence:.0%} confidence {narrow:.3g} to "
                f"{wide:.3g}.",
                f"{fell} of {len(self.upper)} records felled a block"
                + ("." if fell == len(self.upper) else "; the others are right-censored."),
            ]
        )

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; what is infinite is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "median": self.median,
            "dispersion": self.dispersion,
            "median_interval": [finite(end) for end in self.median_interval],
            "dispersion_interval": [finite(end) for end in self.dispersion_interval],
            "confidence": self.confidence,
            "lower": self.lower.tolist(),
            "upper": [finite(end) for end in self.upper],
        }


@known_options
def fit_fragility(lower: ArrayLike, upper: ArrayLike, *, confidence: float = 0.95) -> Fragility:
    """Fit a lognormal distribution to collapse intensities that are known between two bounds each.

    Parameters
    ----------
    lower : array of float, shape (n_records,)
        Largest intensity at which each record felled nothing; 0 where none is known. A record that never felled a block
        either says nothing and changes nothing.
    upper : array of float, shape (n_records,)
        Smallest intensity at which it felled a block; inf for a record that never did.
    confidence : float, optional
        Of the intervals and of the band, which holds at each intensity by itself.

    Returns
    -------
    Fragility
        Median, dispersion, their intervals and the band.

    Raises
    ------
    InputError
        For fewer than three records that say something, fewer than two that fell, bounds that are not ascending, or
        bounds that all records share, be it in one intensity: then the likelihood grows as the dispersion shrinks to 0.
        Also for an option that does not exist.

    Notes
    -----
    The likelihood of a record is `Phi(ln(upper / theta) / beta) - Phi(ln(lower / theta) / beta)`: a bracket is an
    interval-censored observation, a record that never fell a block a right-censored one. It is log-concave in
    (1 / beta, ln(theta) / beta), so the maximum is the only one.

    The confidence region is that of the likelihood ratio: it holds all parameters whose log-likelihood is within c / 2
    of the maximum. The intervals and the band are the ranges of theta, beta and P over it. A bootstrap over records was
    not chosen: resamples of three to ten records repeat one of them so often that the dispersion is 0, and those in
    which nothing falls have no fit. The covariance of the likelihood is symmetric where the truth is not. For few
    records the limit of c, a quantile of chi-square, is too small. With t the quantile of Student's distribution of
    m - 1 degrees of freedom, m records that fell, `c = m ln(1 + t^2 / (m - 1))` makes the interval of the median exact
    where all records fell at known intensities. `tests/dynsim/test_fragility.py` counts how often intervals and bands
    hold the truth over random sets of records.

    References
    ----------
    .. [1] Baker: Efficient analytical fragility function fitting using dynamic structural analysis, 2015.
    .. [2] Meeker & Escobar: Statistical methods for reliability data, 1998, chapter 8.
    .. [3] Burridge: A note on maximum likelihood estimation for regression models using grouped data, 1981.

    Examples
    --------
    >>> from dynsim import fit_fragility
    >>> found = fit_fragility([0.30, 0.38, 0.41, 0.55, 1.0], [0.31, 0.40, 0.43, 0.58, float("inf")])
    >>> round(found.median, 2), round(found.dispersion, 2), round(float(found.probability(0.3)), 2)
    (0.51, 0.5, 0.14)
    """
    low, high, fell = _checked(lower, upper, confidence)
    bounds = np.log(np.where(low > 0, low, 1.0)), np.log(np.where(fell, high, 1.0))
    bounds = np.where(low > 0, bounds[0], -np.inf), np.where(fell, bounds[1], np.inf)
    known = fell | (low > 0)  # of any other record the likelihood is 1, whatever the parameters
    bounds = bounds[0][known], bounds[1][known]
    centre, spread = _maximum(*bounds)
    # About the maximum, in its own units: there 1 / beta is 1 and ln(theta) / beta is 0.
    own = (bounds[0] - centre) / spread, (bounds[1] - centre) / spread
    slope, offset = _region(*own, _drop(int(fell.sum()), confidence))
    middles = centre + spread * offset / slope
    return Fragility(
        median=float(np.exp(centre)),
        dispersion=float(spread),
        median_interval=(float(np.exp(middles.min())), float(np.exp(middles.max()))),
        dispersion_interval=(float(spread / slope.max()), float(spread / slope.min())),
        confidence=confidence,
        lower=low,
        upper=high,
        region=np.stack([slope / spread, offset + slope * centre / spread], axis=1),
    )


def _checked(lower: ArrayLike, upper: ArrayLike, confidence: float) -> tuple[Floats, Floats, np.ndarray]:
    """The bounds as arrays, and which records fell a block."""
    low, high = np.atleast_1d(numbers(lower)), np.atleast_1d(numbers(upper))
    check_number("fragility: confidence", confidence)
    if not 0 < confidence < 1:
        raise InputError(f"fragility: confidence is {confidence!r}; it must be between 0 and 1")
    if low.ndim != 1 or low.shape != high.shape or not (np.isfinite(low).all() and (low >= 0).all()):
        raise InputError("fragility: lower and upper are one number a record each, and lower is 0 or more")
    known = int(((low > 0) | np.isfinite(high)).sum())
    if known < FEWEST:
        counted = f"{known} record{'s' * (known != 1)}"
        if known < len(low):
            counted += f" with a bound, of {len(low)}"
        raise InputError(f"fragility: {counted}; at least three are needed")
    if not (low < high).all():
        k = int(np.argmin(low < high))
        raise InputError(f"fragility: record {k} stands at {low[k]:g} and falls at {high[k]:g}; it must fall above")
    fell = np.isfinite(high)
    if fell.sum() < 2 or not (fell & (low > 0)).any():
        raise InputError(
            f"fragility: {int(fell.sum())} of {len(low)} records fell a block; two are needed, and one of them must be "
            "known to stand at a lower intensity; raise the intensity up to which records are scaled, or add records"
        )
    if low.max() <= high.min():
        shared = f"between {low.max():.4g} and {high.min():.4g}" if low.max() < high.min() else f"at {high.min():.4g}"
        raise InputError(
            f"fragility: all records may fall {shared}, so a dispersion cannot be found; ask for a finer resolution, "
            "or add records"
        )
    return low, high, fell


def _drop(fell: int, confidence: float) -> float:
    """How far the log-likelihood may lie below its maximum in the confidence region."""
    t = float(stdtrit(fell - 1, 0.5 + confidence / 2))
    return 0.5 * fell * np.log1p(t**2 / (fell - 1))


def _log_mass(low: Floats, high: Floats) -> Floats:
    """Logarithm of Phi(high) - Phi(low), without cancellation in the upper tail."""
    flip = low > 0
    low, high = np.where(flip, -high, low), np.where(flip, -low, high)
    inner, outer = log_ndtr(low), log_ndtr(high)
    return outer + np.log(-np.expm1(inner - outer))


def _maximum(low: Floats, high: Floats) -> tuple[float, float]:
    """Mean and standard deviation of the normal distribution of largest likelihood."""
    guess = np.where(np.isinf(low), high, np.where(np.isinf(high), low, (np.maximum(low, -1e300) + high) / 2))

    def cost(parameters: Floats) -> tuple[float, Floats]:
        mean, slope = parameters[0], np.exp(parameters[1])
        a, b = slope * (low - mean), slope * (high - mean)
        mass = _log_mass(a, b)
        weight_a, weight_b = (np.exp(-0.5 * z**2 - LOG_ROOT - mass) for z in (a, b))
        shift = slope * (weight_b - weight_a).sum()
        # An infinite bound has no weight, whatever it is multiplied by.
        steep = np.where(weight_b > 0, np.where(np.isinf(b), 0.0, b), 0.0) @ weight_b
        steep -= np.where(weight_a > 0, np.where(np.isinf(a), 0.0, a), 0.0) @ weight_a
        return -float(mass.sum()), np.array([shift, -steep])

    spread = float(guess.std()) or 1.0
    found = minimize(cost, [guess.mean(), -np.log(spread)], jac=True, method="BFGS", options={"gtol": 1e-9})
    return float(found.x[0]), float(np.exp(-found.x[1]))


def _region(low: Floats, high: Floats, drop: float) -> tuple[Floats, Floats]:
    """Boundary of the region of log-likelihoods within a drop of that at slope 1 and offset 0.

    The region is convex and holds that point, so each ray from it leaves the region once.
    """
    angle = np.linspace(0, 2 * np.pi, RAYS, endpoint=False)
    across, along = np.cos(angle), np.sin(angle)

    def inside(radius: Floats) -> np.ndarray:
        slope, offset = (1 + radius * across)[:, None], (radius * along)[:, None]
        positive = slope > 0
        safe = np.where(positive, slope, 1.0)
        value = _log_mass(safe * low - offset, safe * high - offset).sum(axis=1)
        return positive[:, 0] & (value >= best - drop)

    best = float(_log_mass(low, high).sum())
    with np.errstate(divide="ignore", invalid="ignore"):  # far outside, where nothing is likely
        near, far = np.zeros(RAYS), np.ones(RAYS)
        while (reaching := inside(far)).any():
            far = np.where(reaching, 2 * far, far)
        for _ in range(HALVINGS):
            middle = (near + far) / 2
            within = inside(middle)
            near, far = np.where(within, middle, near), np.where(within, far, middle)
    return 1 + near * across, near * along
