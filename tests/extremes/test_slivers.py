"""Wedges of a thousandth of a degree, plates and needles, and joints of almost no area."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from tests.extremes.scenes import arrived, certificate
from tests.extremes.solids import (
    DYNAMICS,
    ONE_STEP,
    carried_error,
    keystone,
    keystone_error,
    ledges,
    ledges_error,
    slender,
)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("half_angle", [1e-3, 1e-2, 0.1, 1.0, 10.0, 60.0, 89.0])
def test_keystone_of_any_angle(half_angle: float, fidelity: str) -> None:
    """Without friction N = W / (2 sin a): 28 648 W at a thousandth of a degree."""
    result = solve_scene(keystone(half_angle, fidelity=fidelity))
    assert result.outcome == "equilibrium"
    assert keystone_error(result, half_angle) < 1e-9
    assert max(certificate(result).values()) < 1e-8


@pytest.mark.parametrize("half_angle", [1e-2, 0.1, 1.0, 10.0, 60.0])
def test_keystone_in_a_march(half_angle: float) -> None:
    """At 1e-3 degrees errors of reactions 28 648 times the weight keep it from rest to 1e-6."""
    result = solve_scene(keystone(half_angle, analysis=ONE_STEP))
    assert result.outcome == "equilibrium"
    assert keystone_error(result, half_angle) < 1e-6


@pytest.mark.parametrize("lying", [True, False], ids=["plates", "needles"])
@pytest.mark.parametrize("aspect", [1e2, 1e4, 1e5])
def test_rigid_plates_and_needles(aspect: float, lying: bool) -> None:
    for analysis in (None, DYNAMICS):
        keys = {} if analysis is None else {"analysis": analysis}
        scene = slender(aspect, lying=lying, fidelity="rigid", **keys)
        result = solve_scene(scene)
        assert result.outcome == arrived(scene)
        assert carried_error(result) < 1e-8
        assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize(("aspect", "worst"), [(1e2, 1e-10), (1e3, 1e-8), (1e4, 1e-6)])
def test_elastic_needles(aspect: float, worst: float) -> None:
    """What limits them is rounding of K u: it grows with the square of the aspect."""
    result = solve_scene(slender(aspect, lying=False))
    assert result.outcome == "equilibrium"
    assert carried_error(result) < 1e-9
    assert max(certificate(result).values()) < worst


@pytest.mark.parametrize(("aspect", "worst"), [(1e1, 1e-10), (1e2, 1e-10), (1e3, 1e-8), (1e4, 1e-6)])
def test_elastic_plates(aspect: float, worst: float, caplog: pytest.LogCaptureFixture) -> None:
    """Plates bend a million times as easily as they are squeezed: from 1e3 on rounding of W p may exceed what
    is aimed at, and then the run says so. What joints carry is exact all the same.
    """
    result = solve_scene(slender(aspect))
    told = certificate(result)
    assert result.outcome == "equilibrium"
    inexact = "ended at an error of up to" in caplog.text
    assert inexact == (result.summary.certificate.natural_map > 1e-10)
    if aspect < 1e3:
        assert not inexact
    assert max(told.values()) < worst
    assert carried_error(result) < 1e-9


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("width", [0.1, 1e-3, 1e-4, 2.1e-5])
def test_lintel_on_narrow_ledges(width: float, fidelity: str, dimension: int) -> None:
    result = solve_scene(ledges(width, fidelity=fidelity, dimension=dimension))
    assert result.outcome == "equilibrium"
    assert ledges_error(result) < 1e-9
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("width", "told"), [(1.9e-5, True), (1e-5, True), (1e-9, False), (0.0, False)])
def test_slivers_and_shared_edges_carry_nothing(
    width: float, told: bool, dimension: int, caplog: pytest.LogCaptureFixture
) -> None:
    """Below 1e-4 of a face of 0.2 m; that it is a sliver is told where it is more than a shared edge."""
    result = solve_scene(ledges(width, dimension=dimension))
    assert result.outcome == "no_equilibrium"
    assert "lintel falls" in result.message
    messages = [record.getMessage() for record in caplog.records]
    assert any("only a sliver" in message for message in messages) == told
    assert any("no support holds 'lintel'" in message for message in messages)
