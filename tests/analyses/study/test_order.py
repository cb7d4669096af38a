"""Orders and what is left: sequences whose limit is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from masonry_fem.analyses.study.order import observe

WIDTHS = [0.4, 0.2, 0.1]


@given(st.floats(0.51, 2.4), st.floats(-10, 10), st.floats(-3, 3), st.floats(1.3, 3), st.floats(1.3, 3))
def test_a_power_of_the_width_is_seen_and_bounded(p, limit, factor, coarse, fine) -> None:
    assume(abs(factor) > 1e-3)
    widths = np.array([coarse * fine, fine, 1.0])
    values = limit + factor * widths**p
    seen = observe(widths, values)
    assert seen.order == pytest.approx(p, abs=1e-3)
    assert seen.regular
    assert seen.error >= abs(values[-1] - limit)


@given(st.floats(0.65, 1.0), st.floats(0.0, 0.5), st.floats(0.05, 1.0))
def test_a_singular_rest_hidden_by_a_smooth_one_is_bounded(p, second, width) -> None:
    """Coarse meshes see the smooth part h² first; the singular one stays in the end."""
    widths = width * np.array([4.0, 2.0, 1.0])
    values = 1.0 + widths**p + second * widths**2
    seen = observe(widths, values)
    assert seen.error >= abs(values[-1] - 1.0)


def test_vectors_converge_by_their_norm() -> None:
    limit = np.array([1.0, -2.0])
    levels = [limit + h**2 * np.array([1.0, 3.0]) for h in WIDTHS]
    assert observe(WIDTHS, levels).order == pytest.approx(2.0, abs=1e-4)


def test_values_that_turn_back_are_told() -> None:
    seen = observe(WIDTHS, [1.0, 1.3, 1.1])
    assert (seen.order, seen.regular, seen.words) == (None, False, "oscillates")
    assert seen.error >= 0.2


def test_what_grows_has_no_order() -> None:
    """A corner's stress grows as the logarithm of the width or worse."""
    seen = observe(WIDTHS, [29.86, 34.69, 40.2])
    assert not seen.regular
    assert seen.words == "not asymptotic"


def test_a_last_step_that_is_small_by_accident_leaves_what_the_one_before_says() -> None:
    seen = observe(WIDTHS, [1.0, 1.2, 1.2001])
    assert not seen.regular
    assert seen.error >= 0.1


def test_no_change_is_no_order() -> None:
    seen = observe(WIDTHS, [3.0, 3.0 + 1e-13, 3.0])
    assert (seen.order, seen.words) == (None, "no change")
    assert seen.error < 1e-12


def test_two_levels_leave_three_times_their_difference() -> None:
    seen = observe([0.2, 0.1], [1.0, 1.1])
    assert (seen.order, seen.words) == (None, "2 levels")
    assert seen.error == pytest.approx(0.3)
    assert observe([0.1], [1.0]).words == "1 level"
