"""Random field: numbers that vary in space, the same for the same seed.

    field = gaussian_field(points, seed=1, length=0.5)          # mean 0, variance 1, shape (n,)
    strength = 0.35e6 * factors(field, 0.2, "lognormal")        # mean 1, coefficient of variation 0.2

Correlated fields are sums of waves with random normal amplitudes, whose wave vectors are drawn from the
spectrum of the correlation exp(−r²/ℓ²). Values at a point are normally distributed with variance 1,
whatever the
number of waves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import gamma, log_ndtr, ndtr, ndtri

FloatArray = NDArray[np.float64]

WAVES = 1024  # the error of the correlation is about 1/√WAVES
CHUNK = 2048  # points at once, to bound the memory


def gaussian_field(points: FloatArray, seed: int, length: float | None) -> FloatArray:
    """Standard normal values at points, shape (n,).

    Parameters
    ----------
    points : Where [m], shape (n, d). seed : Of the generator.
    length : ℓ of the correlation exp(−r²/ℓ²) [m]; None: independent values.
    """
    random = np.random.default_rng(seed)
    if length is None:
        return random.standard_normal(len(points))
    waves = random.standard_normal((points.shape[1], WAVES)) * np.sqrt(2.0) / length
    amplitudes = random.standard_normal((2, WAVES)) / np.sqrt(WAVES)
    parts = [np.zeros(0)]
    for start in range(0, len(points), CHUNK):
        phase = points[start : start + CHUNK] @ waves
        parts.append(np.cos(phase) @ amplitudes[0] + np.sin(phase) @ amplitudes[1])
    return np.concatenate(parts)


def factors(field: FloatArray, variation: float, distribution: str) -> FloatArray:
    """Positive factors with mean 1 that increase with a standard normal field, shape (n,).

    Parameters
    ----------
    field : Standard normal values, shape (n,).
    variation : Coefficient of variation.
    distribution : ``lognormal``, ``truncated_normal`` or ``weibull``.

    Raises
    ------
    ValueError : The distribution cannot have that variation.
    """
    return _DISTRIBUTIONS[distribution](field, variation)


def _lognormal(field: FloatArray, variation: float) -> FloatArray:
    width = np.sqrt(np.log1p(variation**2))
    grown: FloatArray = np.exp(width * field - 0.5 * width**2)
    return grown


def _truncated_normal(field: FloatArray, variation: float) -> FloatArray:
    """Normal about 1, cut off at 0 and 2."""
    greatest = 0.5  # the limit of a very wide normal distribution, a uniform one on (0, 2), has 1/√3
    if variation > greatest:
        raise ValueError(f"at most {greatest} with distribution 'truncated_normal'; take 'lognormal'")

    def spread(width: float) -> float:
        """Standard deviation of a normal distribution cut off at both ends."""
        edge = 1.0 / width
        density = np.exp(-0.5 * edge**2) / np.sqrt(2.0 * np.pi)
        return float(width * np.sqrt(1.0 - 2.0 * edge * density / (2.0 * ndtr(edge) - 1.0)))

    width: Any = brentq(lambda width: spread(width) - variation, 0.9 * variation, 100.0, xtol=1e-14)
    low = ndtr(-1.0 / width)
    return np.asarray(1.0 + width * ndtri(low + (1.0 - 2.0 * low) * ndtr(field)))


def _weibull(field: FloatArray, variation: float) -> FloatArray:
    def excess(shape: float) -> float:
        return float(gamma(1.0 + 2.0 / shape) / gamma(1.0 + 1.0 / shape) ** 2 - 1.0 - variation**2)

    # the shape is about 1.2/variation for small variations
    shape: Any = brentq(excess, 0.3, 3.0 + 2.0 / variation, xtol=1e-14)
    return np.asarray((-log_ndtr(-field)) ** (1.0 / shape) / gamma(1.0 + 1.0 / shape))


_DISTRIBUTIONS: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "lognormal": _lognormal,
    "truncated_normal": _truncated_normal,
    "weibull": _weibull,
}
