"""Fragility: a lognormal distribution fitted to intervals, its ranges, and where there is none."""

import numpy as np
import pytest
from scipy.special import ndtr

from masonry_fem.analyses.incremental.fragility import fragility

MEDIAN, SPREAD = 2.0, 0.4
GRID = np.arange(0.25, 6.01, 0.25)


def sample(number: int, seed: int) -> np.ndarray:
    """Intensities at which records pass a limit."""
    return MEDIAN * np.exp(SPREAD * np.random.default_rng(seed).standard_normal(number))


def between(passes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The grid's intensities below and above."""
    padded = np.concatenate([[0.0], GRID, [np.inf]])
    place = np.searchsorted(padded, passes)
    return padded[place - 1], padded[place]


def test_of_narrow_intervals_it_is_mean_and_deviation_of_the_logarithms():
    logs = np.log(sample(30, 1))
    found = fragility(np.exp(logs) * (1 - 1e-5), np.exp(logs) * (1 + 1e-5))
    assert (found.outcome, found.records, found.passed) == ("fitted", 30, 30)
    assert found.median == pytest.approx(np.exp(logs.mean()), rel=1e-4)
    assert found.dispersion == pytest.approx(logs.std(), rel=1e-4)
    # the likelihood ratio of a normal sample: ln(1 + t²/n) = 3.841/n
    reach = logs.std() * np.sqrt(np.exp(3.841459 / 30) - 1)
    assert found.median_range == pytest.approx(np.exp(logs.mean() + reach * np.array([-1, 1])), rel=1e-3)
    assert found.probability(np.array([found.median]))[0] == pytest.approx(0.5)


def test_a_large_synthetic_sample_gives_its_parameters_back():
    passes = sample(2000, 2)
    found = fragility(*between(passes))
    assert found.median == pytest.approx(MEDIAN, rel=0.03)
    assert found.median == pytest.approx(np.exp(np.log(passes).mean()), rel=3e-3)
    assert found.dispersion == pytest.approx(SPREAD, rel=0.05)
    low, high = found.median_range
    assert high / low == pytest.approx(np.exp(2 * 1.96 * SPREAD / np.sqrt(2000)), rel=5e-3)


def test_records_that_never_pass_count_too():
    passes = sample(400, 3)
    known = passes < 2.2
    low, high = between(passes)
    found = fragility(np.where(known, low, 2.2), np.where(known, high, np.inf))
    assert found.passed < 300
    assert found.median == pytest.approx(MEDIAN, rel=0.06)
    assert found.dispersion == pytest.approx(SPREAD, rel=0.12)


@pytest.mark.slow
def test_ranges_hold_the_truth_as_often_as_they_say():
    """95 % of 400 samples of 20 records, less what small samples cost."""
    at = np.array([1.5])
    truth = ndtr(np.log(at[0] / MEDIAN) / SPREAD)
    held = np.zeros(3)
    for seed in range(400):
        found = fragility(*between(sample(20, 100 + seed)))
        low, high = found.band(at)[:, 0]
        held += [
            found.median_range[0] <= MEDIAN <= found.median_range[1],
            found.dispersion_range[0] <= SPREAD <= found.dispersion_range[1],
            low <= truth <= high,
        ]
    assert np.all(held / 400 > 0.91)
    assert np.all(held / 400 < 0.98)


def test_the_unit_of_intensity_makes_no_difference():
    low, high = between(sample(12, 4))
    one, other = fragility(low, high), fragility(9.81 * low, 9.81 * high)
    assert other.median == pytest.approx(9.81 * one.median, rel=1e-6)
    assert other.dispersion == pytest.approx(one.dispersion, rel=1e-6)
    assert other.median_range == pytest.approx(9.81 * np.array(one.median_range), rel=1e-4)
    at = np.array([1.0, 2.0, 3.0])
    assert other.band(9.81 * at) == pytest.approx(one.band(at), abs=1e-5)


def test_the_band_holds_the_curve():
    found = fragility(*between(sample(15, 5)))
    at = np.geomspace(0.2, 10, 40)
    low, high = found.band(at)
    assert np.all(low < found.probability(at))
    assert np.all(found.probability(at) < high)


def test_where_one_intensity_parts_them_there_is_a_step():
    found = fragility(np.array([1.0, 1.2, 0.0]), np.array([1.5, np.inf, 1.6]))
    assert (found.outcome, found.dispersion) == ("step", 0.0)
    assert found.median_range == (1.2, 1.5)
    assert found.probability(np.array([1.1, 1.6])).tolist() == [0.0, 1.0]
    assert np.isnan(found.band(np.array([1.0]))).all()


def test_of_what_falls_at_the_least_intensity_no_median_is_known():
    found = fragility(np.zeros(3), np.ones(3))
    assert (found.outcome, found.median, found.median_range) == ("step", None, (0.0, 1.0))


def test_what_never_passes_is_told():
    found = fragility(np.ones(3), np.full(3, np.inf))
    assert (found.outcome, found.passed, found.median) == ("never passed", 0, None)
    assert np.isnan(found.probability(np.array([1.0]))).all()


def test_where_more_pass_at_less_intensity_nothing_is_fitted():
    found = fragility(np.array([0.0, 2.0, 0.0, 3.0]), np.array([1.0, np.inf, 1.2, np.inf]))
    assert found.outcome == "not determined"
