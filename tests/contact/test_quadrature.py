"""Quadrature on triangles: exact up to its degree, against the closed form of monomials."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest

from masonry_fem.contact.placement.parts.quadrature import quadrature

TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


@pytest.mark.parametrize("density", [1, 3])
@pytest.mark.parametrize("degree", [2, 4])
def test_rules_on_a_triangle_integrate_their_degree(degree: int, density: int) -> None:
    """∫ x^a y^b over the unit triangle = a! b! / (a + b + 2)!."""
    points, weights, rows = quadrature(TRIANGLE, TRIANGLE[None], TRIANGLE[None], degree, False, density)
    assert len(points) == {2: 3, 4: 6}[degree] * density**2
    assert not rows.any()
    for a in range(degree + 1):
        for b in range(degree + 1 - a):
            found = weights @ (points[:, 0] ** a * points[:, 1] ** b)
            exact = factorial(a) * factorial(b) / factorial(a + b + 2)
            assert found == pytest.approx(exact, rel=1e-12), (a, b)
