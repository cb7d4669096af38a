"""Drucker and Prager's cone against closed forms."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.fem.materials.drucker_prager import DruckerPrager
from tests.fem.materials.strain_paths import SIZE, STONE, Point

C = 2e6
ANGLES = [(35.0, None), (35.0, 10.0), (20.0, 0.0)]
SINE = {angle: np.sin(np.radians(angle)) for angle in (20.0, 35.0)}
COSINE = {angle: np.cos(np.radians(angle)) for angle in (20.0, 35.0)}


@pytest.mark.parametrize("angles", ANGLES)
@pytest.mark.parametrize("confinement", [0.0, 1e6])
def test_triaxial_compression_has_the_strength_of_mohr_and_coulomb(angles, confinement):
    phi, psi = angles
    point = Point(DruckerPrager(C, phi, psi))
    point.to(np.array([1, 1, 1, 0, 0, 0]) * -confinement / (3 * STONE.bulk))
    steps = [point.squeezed(axial, -confinement) for axial in np.linspace(0, -5e-3, 11)[1:]]
    ratio = (1 + SINE[phi]) / (1 - SINE[phi])
    strength = ratio * confinement + 2 * C * np.sqrt(ratio)
    np.testing.assert_allclose(steps[4:], -strength, rtol=1e-8)
    assert -steps[0] < 0.9 * strength  # it was elastic there


@pytest.mark.parametrize("angles", ANGLES)
def test_uniaxial_tension_has_the_strength_that_it_is_fitted_to(angles):
    phi, psi = angles
    point = Point(DruckerPrager(C, phi, psi, fit="tension"))
    pulled = [point.squeezed(axial) for axial in np.linspace(0, 2e-3, 6)[1:]]
    np.testing.assert_allclose(pulled[1:], 2 * C * COSINE[phi] / (1 + SINE[phi]), rtol=1e-8)


@pytest.mark.parametrize("angles", ANGLES)
def test_dilatancy_is_the_ratio_of_plastic_volume_and_shear(angles):
    """ε_p,v / √(2 e_p : e_p) = η̄, which is read from the strains that are not elastic."""
    phi, psi = angles
    law = DruckerPrager(C, phi, psi)
    point = Point(law)
    for axial in np.linspace(0, -5e-3, 11)[1:]:
        point.squeezed(axial)
    plastic = point.strain[0] - np.linalg.solve(STONE.matrix, point.stress)
    volume = plastic[:3].sum()
    shear = plastic[:3] - volume / 3
    ratio = 6 * np.sin(np.radians(phi if psi is None else psi))
    ratio /= np.sqrt(3) * (3 - np.sin(np.radians(phi if psi is None else psi)))
    assert volume / np.sqrt(2 * shear @ shear) == pytest.approx(ratio, rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("angles", ANGLES)
@pytest.mark.parametrize("steps", [1, 7])
def test_simple_shear_without_change_of_volume(angles, steps):
    """Dilatancy that cannot have its way makes pressure: λ = (G γ − ξ c)/(G + K η η̄), τ = ξ c + η K η̄ λ."""
    phi, psi = angles
    law = DruckerPrager(C, phi, psi)
    eta, xi, eta_bar = law.cone
    point, angle, (K, G) = Point(law), 4e-3, (STONE.bulk, STONE.shear)
    for share in np.arange(1, steps + 1) / steps:
        point.to([0, 0, 0, share * angle, 0, 0])
    flow = (G * angle - xi * C) / (G + K * eta * eta_bar)
    np.testing.assert_allclose(point.stress[3], xi * C + eta * K * eta_bar * flow, rtol=1e-8)
    np.testing.assert_allclose(point.stress[:3], -K * eta_bar * flow, rtol=1e-8, atol=1e-8 * C)


@pytest.mark.parametrize("angles", ANGLES)
def test_no_stress_is_beyond_the_apex(angles):
    phi, psi = angles
    point, apex = Point(DruckerPrager(C, phi, psi)), C * COSINE[phi] / SINE[phi]
    elastic = apex / (3 * STONE.bulk)
    point.to(np.array([0.9, 0.9, 0.9, 0, 0, 0]) * elastic)
    np.testing.assert_allclose(point.stress[:3], 0.9 * apex, rtol=1e-12)
    for stretch in (2.0, 5.0):
        point.to(np.array([1.1, 0.9, 1.0, 0.2, -0.1, 0.3]) * stretch * elastic)
        np.testing.assert_allclose(
            point.stress, apex * np.array([1, 1, 1, 0, 0, 0]), rtol=1e-8, atol=1e-8 * C
        )


@pytest.mark.parametrize("angles", ANGLES)
def test_the_apex_hardens_as_its_equation_says(angles):
    """p = β (c + H β ε_vp) with p = K (ε_v − ε_vp) and β = cot φ."""
    phi, psi = angles
    H, volume = 5e9, 9e-3
    point, beta = Point(DruckerPrager(C, phi, psi, hardening=H)), COSINE[phi] / SINE[phi]
    point.to(np.array([1, 1, 1, 0, 0, 0]) * volume / 3)
    plastic = (STONE.bulk * volume - beta * C) / (STONE.bulk + beta**2 * H)
    assert plastic > 0
    np.testing.assert_allclose(point.stress[:3], STONE.bulk * (volume - plastic), rtol=1e-8)


@pytest.mark.parametrize("angles", ANGLES)
def test_cone_and_apex_meet(angles):
    """Along a line of strains across their border stresses have no jump, with and without hardening."""
    phi, psi = angles
    for hardening in (0.0, 2e9):
        law = DruckerPrager(C, phi, psi, hardening=hardening)
        shares = np.linspace(0.0, 1.0, 4001)[:, None]
        strains = (1 - shares) * np.array([1, 1, 1, 0, 0, 0]) * 3e-3 + shares * np.array(
            [0, 0, 0, 2e-2, 0, 0]
        )
        made = law.update(STONE, np.zeros_like(strains), strains, law.initial(len(strains)), SIZE)
        deviator = made.stress - made.stress[:, :3].mean(axis=1)[:, None] * [1, 1, 1, 0, 0, 0]
        sheared = np.abs(deviator).max(axis=1) > 1e-9 * C
        assert sheared.any()
        assert not sheared.all()
        jumps = np.abs(np.diff(made.stress, axis=0)).max(axis=1)
        assert jumps.max() <= 3 * STONE.matrix.max() * np.abs(np.diff(strains, axis=0)).max()


def test_cycles_of_shear_dissipate_the_area_of_their_loops():
    """Without dilatancy the loop of amplitude γ has the area 4 τ (γ − τ/G), τ = ξ c."""
    law = DruckerPrager(C, 35.0, 0.0)
    point, angle = Point(law), 5e-3
    limit = law.cone[1] * C
    for _ in range(3):
        before = point.dissipated
        for turn in (*np.linspace(0, 1, 41)[1:], *np.linspace(1, -1, 81)[1:], *np.linspace(-1, 0, 41)[1:]):
            point.to([0, 0, 0, turn * angle, 0, 0])
            assert abs(point.stress[3]) <= limit * (1 + 1e-12)
    area = 4 * limit * (angle - limit / STONE.shear)
    # a step that crosses the limit is dissipated with its end's stress: exact, as that does not change
    np.testing.assert_allclose(point.dissipated - before, area, rtol=1e-8)


def test_hardening_raises_the_uniaxial_strength_by_its_slope():
    """√J2 = ξ (c + H κ) − η p of a uniaxial stress, κ = ξ λ, axial plastic strain = −λ (1/√3 − η̄/3)."""
    law = DruckerPrager(C, 35.0, 10.0, hardening=3e9)
    eta, xi, eta_bar = law.cone
    point = Point(law)
    for axial in np.linspace(0, -6e-3, 25)[1:]:
        stress = -point.squeezed(axial)
    young = 10e9
    # σ (1/√3 − η/3) = ξ (c + H ξ λ) and ε = σ/E + λ (1/√3 − η̄/3)
    lean, lean_bar = 1 / np.sqrt(3) - eta / 3, 1 / np.sqrt(3) - eta_bar / 3
    flow = (6e-3 - xi * C / (lean * young)) / (xi**2 * 3e9 / (lean * young) + lean_bar)
    np.testing.assert_allclose(stress, (xi * C + xi**2 * 3e9 * flow) / lean, rtol=1e-8)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"cohesion": 0.0}, "cohesion is 0, expected a number > 0"),
        ({"friction_angle": 90.0}, "friction_angle is 90"),
        ({"dilatancy_angle": 40.0}, "dilatancy_angle is 40, expected at most the friction_angle 35"),
        ({"hardening": -1.0}, "hardening is -1"),
        ({"fit": "best"}, "fit is 'best', expected 'compression' or 'tension' or 'plane_strain'"),
    ],
)
def test_what_is_impossible_is_refused(keys, message):
    with pytest.raises(LawError, match=message):
        DruckerPrager(**({"cohesion": C, "friction_angle": 35.0} | keys))


def test_without_friction_it_is_von_mises():
    """No apex, and the strength 2 c in uniaxial tension and compression alike, fitted so."""
    law = DruckerPrager(C, 0.0)
    for sign in (1, -1):
        point = Point(law)
        for axial in np.linspace(0, sign * 4e-3, 9)[1:]:
            stress = point.squeezed(axial)
        assert stress == pytest.approx(sign * 2 * C, rel=1e-8)
