"""Lognormal fragilities of brackets: Baker, Efficient analytical fragility function fitting, 2015."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import CensoredData, chi2, lognorm, norm
from scipy.stats import t as student

from blockstat import InputError
from dynsim import fit_fragility

THETA, BETA = 0.4, 0.5


def brackets(count, *, seed, width=0.05, most=np.inf):
    """Random collapse intensities, each between two bounds that do not depend on it."""
    rng = np.random.default_rng(seed)
    true, step = THETA * np.exp(BETA * rng.standard_normal(count)), np.log1p(width)
    phase = step * rng.random(count)
    low = np.exp(step * np.floor((np.log(true) - phase) / step) + phase)
    high = low * np.exp(step)
    return np.where(high > most, most, low), np.where(high > most, np.inf, high)


def by_scipy(low, high):
    """Median and dispersion by the maximisation of scipy.stats."""
    fell = np.isfinite(high)
    data = CensoredData(interval=np.column_stack([low[fell], high[fell]]), right=low[~fell])
    shape, _, scale = lognorm.fit(data, floc=0)
    return scale, shape


@pytest.mark.parametrize(
    ("count", "width", "most"), [(3, 0.05, np.inf), (12, 0.05, 0.6), (40, 0.5, np.inf), (40, 0.05, 0.3)]
)
def test_the_fit_is_that_of_scipy(count, width, most):
    low, high = brackets(count, seed=count, width=width, most=most)
    found = fit_fragility(low, high)
    # The simplex of scipy stops at 1e-4.
    np.testing.assert_allclose([found.median, found.dispersion], by_scipy(low, high), rtol=5e-4)


def test_a_known_distribution_is_recovered():
    # The errors of ln(theta) and ln(beta) have standard deviations beta / sqrt(n) and 1 / sqrt(2 n): four of them.
    count = 300
    found = fit_fragility(*brackets(count, seed=7))
    assert abs(np.log(found.median / THETA)) < 4 * BETA / np.sqrt(count)
    assert abs(np.log(found.dispersion / BETA)) < 4 / np.sqrt(2 * count)


def test_the_interval_of_the_median_is_students_where_intensities_are_known():
    low, high = brackets(6, seed=3, width=1e-3)
    log = np.log(np.sqrt(low * high))
    expected = np.exp(student.interval(0.9, len(log) - 1, log.mean(), log.std(ddof=1) / np.sqrt(len(log))))
    found = fit_fragility(low, high, confidence=0.9)
    np.testing.assert_allclose(found.median_interval, expected, rtol=1e-4)
    # The band crosses one half at the ends of the interval.
    for end, side in zip(found.median_interval, (1, 0), strict=True):
        assert found.band(end)[side] == pytest.approx(0.5, abs=1e-4)


def test_the_intervals_are_those_of_the_profile_likelihood():
    low, high = brackets(8, seed=11, most=0.5)
    fell = int(np.isfinite(high).sum())
    assert 2 < fell < 8
    found = fit_fragility(low, high, confidence=0.9)

    def mass(mean, spread):
        inside = norm.cdf((np.log(high) - mean) / spread) - norm.cdf((np.log(low) - mean) / spread)
        return np.log(np.maximum(inside, 1e-300)).sum()

    best = mass(np.log(found.median), found.dispersion)
    drop = 0.5 * fell * np.log1p(student.ppf(0.95, fell - 1) ** 2 / (fell - 1))
    middles = np.log(found.median) + np.array([-2.0, 2.0])

    def lack(log_spread):
        profile = minimize_scalar(lambda mean: -mass(mean, np.exp(log_spread)), bounds=middles, method="bounded")
        return best + profile.fun - drop

    middle = np.log(found.dispersion)
    ends = np.exp([brentq(lack, middle - 1.5, middle), brentq(lack, middle, middle + 1.7)])
    np.testing.assert_allclose(found.dispersion_interval, ends, rtol=1e-3)


def test_the_region_of_many_records_is_that_of_chi_square():
    # One degree of freedom a parameter, as Wilks (1938) says.
    found = fit_fragility(*brackets(300, seed=1))
    reach = np.sqrt(chi2.ppf(0.95, 1) / 300)
    low, high = np.log(np.array(found.median_interval) / found.median) / found.dispersion
    np.testing.assert_allclose([-low, high], reach, rtol=0.02)


def test_the_band_holds_the_curve_and_widens_with_confidence():
    low, high = brackets(10, seed=5)
    at = np.linspace(0.05, 2.0, 40)
    wide, narrow = (fit_fragility(low, high, confidence=c) for c in (0.99, 0.5))
    for found in (wide, narrow):
        below, above = found.band(at)
        assert (below < found.probability(at)).all()
        assert (found.probability(at) < above).all()
    assert (wide.band(at)[0] < narrow.band(at)[0]).all()
    assert (wide.band(at)[1] > narrow.band(at)[1]).all()


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 10])
def test_intervals_and_bands_hold_the_truth_as_often_as_they_say(count):
    # Four standard deviations of the share of 200 sets, 1.5 % each; for few records the intervals may be too wide.
    sets, hits, tenth = 200, np.zeros(3), THETA * np.exp(norm.ppf(0.1) * BETA)
    for seed in range(sets):
        found = fit_fragility(*brackets(count, seed=1000 + seed))
        (low, high), (narrow, wide), (below, above) = (
            found.median_interval,
            found.dispersion_interval,
            found.band(tenth),
        )
        hits += [low <= THETA <= high, narrow <= BETA <= wide, below <= 0.1 <= above]
    assert (hits / sets >= 0.95 - 4 * 0.0154).all()
    assert (hits / sets < 1.0).all()


def test_a_record_that_falls_at_once_is_left_censored():
    # Nothing is known of the first but that it is below .2: as scipy takes it.
    low, high = np.array([0.0, 0.3, 0.5, 0.45]), np.array([0.2, 0.32, 0.55, 0.47])
    data = CensoredData(left=[0.2], interval=np.column_stack([low[1:], high[1:]]))
    shape, _, scale = lognorm.fit(data, floc=0)
    found = fit_fragility(low, high)
    np.testing.assert_allclose([found.median, found.dispersion], [scale, shape], rtol=5e-4)
    assert np.isfinite(found.dispersion_interval).all()


def test_a_record_of_which_nothing_is_known_changes_nothing():
    low, high = brackets(5, seed=2)
    alone, beside = fit_fragility(low, high), fit_fragility([0.0, *low, 0.0], [np.inf, *high, np.inf])
    assert (beside.median, beside.dispersion) == (alone.median, alone.dispersion)
    assert beside.median_interval == alone.median_interval
    assert beside.dispersion_interval == alone.dispersion_interval
    assert len(beside.lower) == 7


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e6])
def test_units_change_nothing(unit):
    low, high = brackets(5, seed=2)
    one, other = fit_fragility(low, high), fit_fragility(unit * low, unit * high)
    assert other.dispersion == pytest.approx(one.dispersion, rel=1e-6)
    np.testing.assert_allclose(np.array(other.median_interval) / unit, one.median_interval, rtol=1e-5)


@pytest.mark.parametrize(("top", "has_fit"), [(0.4, False), (0.39, True)])
def test_brackets_have_a_dispersion_where_they_share_no_intensity(top, has_fit):
    # Two records fall below .4 or .39 and one above .4; the best likelihood at each dispersion, over a grid of medians.
    low, high = np.log([0.3, 0.4, 0.3]), np.log([top, 0.5, top])

    def best(spread):
        mean = np.linspace(np.log(0.35), np.log(0.45), 2001)[:, None]
        return (norm.cdf((high - mean) / spread) - norm.cdf((low - mean) / spread)).prod(axis=1).max()

    spreads = (0.03, 0.05, 0.1, 0.2)
    likelihood = [best(spread) for spread in spreads]
    assert spreads[np.argmax(likelihood)] == (0.1 if has_fit else 0.03)
    assert max(likelihood) < 4 / 27  # as if two in three fell at one intensity: no dispersion reaches it
    if has_fit:
        assert 0.05 < fit_fragility(np.exp(low), np.exp(high)).dispersion < 0.2


@pytest.mark.parametrize(
    ("low", "high", "options", "words"),
    [
        ([0.1, 0.2], [0.2, 0.3], {}, "2 records; at least three are needed"),
        ([0.1, 0.2, 0.0], [0.2, 0.3, np.inf], {}, "2 records with a bound, of 3; at least three are needed"),
        ([0.0, 0.0, 0.0], [np.inf] * 3, {}, "0 records with a bound, of 3; at least three are needed"),
        ([0.1, 0.2, 0.3], [0.2, 0.3], {}, "one number a record each"),
        ([0.1, np.nan, 0.3], [0.2, 0.3, 0.4], {}, "one number a record each"),
        ([0.1, -0.2, 0.3], [0.2, 0.3, 0.4], {}, "lower is 0 or more"),
        ([0.1, 0.4, 0.3], [0.2, 0.3, 0.4], {}, r"record 1 stands at 0\.4 and falls at 0\.3"),
        ([0.1, 1.0, 1.0], [0.2, np.inf, np.inf], {}, "1 of 3 records fell a block; two are needed"),
        ([0.0, 0.0, 1.0], [0.2, 0.3, np.inf], {}, "one of them must be known to stand"),
        ([0.30, 0.31, 0.32], [0.34, 0.33, 0.35], {}, r"may fall between 0\.32 and 0\.33, so a dispersion cannot"),
        ([0.3, 0.4, 0.3], [0.4, 0.5, 0.4], {}, r"all records may fall at 0\.4, so a dispersion cannot be found"),
        ([0.1, 0.2, 0.3], [0.2, 0.3, 0.4], {"confidence": 1.0}, "confidence is 1.0; it must be between 0 and 1"),
        ([0.1, 0.2, 0.3], [0.2, 0.3, 0.4], {"sure": 0.9}, 'unknown option "sure"; options are: confidence'),
    ],
)
def test_bounds_without_a_fragility_are_refused(low, high, options, words):
    with pytest.raises(InputError, match=words):
        fit_fragility(low, high, **options)


def test_the_probability_at_no_intensity_is_zero_and_below_it_an_error():
    found = fit_fragility(*brackets(12, seed=1))
    assert found.probability(0.0) == 0.0
    with pytest.raises(InputError, match=r"intensity is -1; each must be at least 0"):
        found.probability(-1)
