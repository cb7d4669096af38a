"""ν from −0.99 to almost 1/2: what elements make of it, and what the user is told."""

from __future__ import annotations

import logging

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import check
from tests.extremes.scenes import certificate
from tests.extremes.solids import cantilever, cantilever_error, confined, confined_error


@pytest.mark.parametrize("poisson", [-0.99, -0.5, 0.0, 0.3, 0.49, 0.499, 0.499999])
@pytest.mark.parametrize("element", ["Q1", "P1", "Q2", "P2"])
def test_confined_cube_locks_in_no_element(element: str, poisson: float) -> None:
    """Uniform strain is exact; quadratic elements lose digits as 1 / (1 − 2ν)."""
    result = solve_scene(confined(poisson, element=element))
    assert confined_error(result) < 1e-9
    assert max(certificate(result).values()) < 1e-12


@pytest.mark.parametrize("poisson", [-0.99, 0.0, 0.499])
def test_confined_cube_in_space(poisson: float) -> None:
    assert confined_error(solve_scene(confined(poisson, dimension=3))) < 1e-9


# lowest share of Timoshenko's deflection that is missing, and highest, with 4 linear or 2 quadratic elements
# across: the clamp holds the bulging foot, which stiffens by up to 5 % as ν goes to 1/2
MISSING = {
    -0.9: {"Q1": (0.05, 0.1), "P1": (0.2, 0.3), "Q2": (0.0, 0.01), "P2": (0.0, 0.02)},
    0.0: {"Q1": (0.02, 0.04), "P1": (0.15, 0.2), "Q2": (0.0, 1e-3), "P2": (0.0, 1e-3)},
    0.2: {"Q1": (0.02, 0.04), "P1": (0.15, 0.2), "Q2": (0.0, 0.01), "P2": (0.0, 0.01)},
    0.45: {"Q1": (0.1, 0.2), "P1": (0.3, 0.4), "Q2": (0.0, 0.03), "P2": (0.0, 0.03)},
    0.499: {"Q1": (0.8, 0.95), "P1": (0.9, 0.99), "Q2": (0.0, 0.06), "P2": (0.0, 0.06)},
}


@pytest.mark.parametrize("element", ["Q1", "P1", "Q2", "P2"])
@pytest.mark.parametrize("poisson", MISSING)
def test_cantilever_locks_with_linear_elements(poisson: float, element: str) -> None:
    """At ν = 0.499 four Q1 across miss nine tenths of the deflection, two Q2 a twentieth."""
    divisions = (40, 4) if element.endswith("1") else (20, 2)
    result = solve_scene(cantilever(poisson, element=element, divisions=divisions))
    least, most = MISSING[poisson][element]
    assert least <= -cantilever_error(result) <= most
    assert max(certificate(result).values()) < 1e-10 + 1e-11 / (1 - 2 * poisson)


@pytest.mark.parametrize(("poisson", "element", "told"), [(0.45, "Q1", 1), (0.45, "Q2", 0), (0.3, "P1", 0)])
def test_locking_is_told(poisson: float, element: str, told: int, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        check(cantilever(poisson, element=element))
    found = [record.getMessage() for record in caplog.records if "poisson" in record.getMessage()]
    assert len(found) == told
    assert all("Q2" in message for message in found)
