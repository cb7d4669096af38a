"""Random fields: distribution, correlation, cost and seed."""

import numpy as np
import pytest

from masonry_fem.build.random_field import CHUNK, factors, gaussian_field

NORMAL = np.random.default_rng(0).standard_normal(200_000)


@pytest.mark.parametrize("distribution", ["lognormal", "truncated_normal", "weibull"])
@pytest.mark.parametrize("variation", [0.02, 0.2, 0.5])
def test_mean_and_variation_are_as_asked(distribution, variation):
    values = factors(NORMAL, variation, distribution)
    assert values.mean() == pytest.approx(1.0, abs=4 * variation / np.sqrt(len(NORMAL)))
    assert values.std() == pytest.approx(variation, rel=0.01)
    assert values.min() > 0
    order = np.argsort(NORMAL)
    assert (np.diff(values[order]) >= 0).all()  # weak in one is weak in all


def test_wide_distributions():
    for distribution in ("lognormal", "weibull"):
        values = factors(NORMAL, 1.0, distribution)
        assert values.mean() == pytest.approx(1.0, rel=0.01)
        assert values.std() == pytest.approx(1.0, rel=0.03)
    assert factors(NORMAL, 0.5, "truncated_normal").max() <= 2.0
    with pytest.raises(ValueError, match=r"at most 0\.5"):
        factors(NORMAL, 0.6, "truncated_normal")


def test_the_lognormal_has_its_median():
    assert factors(np.zeros(1), 0.3, "lognormal")[0] == pytest.approx(1 / np.sqrt(1.09))


def test_a_seed_is_a_field():
    points = np.random.default_rng(3).uniform(0, 5, (CHUNK + 10, 3))
    for length in (None, 0.5):
        one, again = (gaussian_field(points, 7, length) for _ in range(2))
        np.testing.assert_array_equal(one, again)
        assert np.abs(gaussian_field(points, 8, length) - one).max() > 1
    # a correlated value hangs on the place alone
    order = np.random.default_rng(4).permutation(len(points))
    np.testing.assert_allclose(gaussian_field(points[order], 7, 0.5), one[order], atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_correlation_falls_as_said(dimension):
    """Over 4000 seeds: variance 1 everywhere, exp(−r²/ℓ²) between points."""
    distance = np.array([0.0, 0.2, 0.5, 1.0, 3.0])
    points = np.zeros((5, dimension))
    points[:, -1] = distance
    drawn = np.array([gaussian_field(points + 10, seed, 0.5) for seed in range(1500)])
    assert drawn.mean(axis=0) == pytest.approx(np.zeros(5), abs=0.1)
    covariance = np.cov(drawn.T)
    assert np.diag(covariance) == pytest.approx(np.ones(5), abs=0.12)
    assert covariance[0] == pytest.approx(np.exp(-((distance / 0.5) ** 2)), abs=0.1)


def test_independent_values_are_independent():
    values = gaussian_field(np.zeros((50_000, 2)), 1, None)
    assert values.mean() == pytest.approx(0, abs=0.02)
    assert values.std() == pytest.approx(1, abs=0.02)
    assert np.mean(values[1:] * values[:-1]) == pytest.approx(0, abs=0.02)
