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


CAPPED = {"tension_cutoff": 0.3e6, "crushing_pressure": 6e6}
HYDROSTATIC = np.array([1.0, 1.0, 1.0, 0, 0, 0])


@pytest.mark.parametrize("slope", [0.0, 4e9])
def test_pores_are_crushed_along_a_straight_line_and_stay_so(slope):
    """−p = K (e − ζ) = p_c + H_c ζ; what is dissipated is the work of −p on ζ."""
    K, volume, crushing = STONE.bulk, 4e-3, CAPPED["crushing_pressure"]
    point = Point(DruckerPrager(C, 35.0, 10.0, crushing_hardening=slope, **CAPPED))
    crushed = 0.0
    for share in (0.25, 0.5, 1.0, 0.85, 1.0, 1.2):
        squeezed, before = share * volume, point.dissipated
        more = max((K * squeezed - crushing) / (K + slope) - crushed, 0.0)
        crushed += more
        point.to(-squeezed / 3 * HYDROSTATIC)
        np.testing.assert_allclose(point.stress[:3], -K * (squeezed - crushed), rtol=1e-8)
        assert point.internal[0, 8] == pytest.approx(crushed, rel=1e-8)
        assert (point.dissipated - before > 1e-9 * crushing) == (more > 1e-9)
    if not slope:
        assert point.dissipated == pytest.approx(crushing * crushed, rel=1e-8)


def test_stone_between_rigid_sides_comes_to_the_corner_of_cone_and_cap():
    """−p = p_c and √J2 = ξ c + η p_c, whatever the strain beyond."""
    law = DruckerPrager(C, 35.0, 10.0, **CAPPED)
    eta, xi, _ = law.cone
    for steps in (1, 9):
        point = Point(law)
        for axial in np.linspace(0, -2e-2, steps + 1)[1:]:
            point.to([0, 0, axial, 0, 0, 0])
        p = point.stress[:3].mean()
        assert -p == pytest.approx(CAPPED["crushing_pressure"], rel=1e-8)
        deviator = (point.stress[0] - point.stress[2]) / np.sqrt(3)
        assert deviator == pytest.approx(xi * C + eta * CAPPED["crushing_pressure"], rel=1e-8)


def test_tension_is_cut_off():
    """Mean stress p_t: a bar bears 3 p_t, and so do all directions together."""
    law = DruckerPrager(C, 35.0, 10.0, **CAPPED)
    eta, xi, _ = law.cone
    cut = CAPPED["tension_cutoff"]
    assert np.sqrt(3) * cut + eta * cut < xi * C  # the cone does not come first
    bar, all_ways, corner = Point(law), Point(law), Point(law)
    for strain in np.linspace(0, 2e-3, 11)[1:]:
        stress = bar.squeezed(strain)
        all_ways.to(strain * HYDROSTATIC)
        corner.to([strain, strain, strain, strain, 0, 0])
    assert stress == pytest.approx(3 * cut, rel=1e-8)
    np.testing.assert_allclose(all_ways.stress[:3], cut, rtol=1e-8)
    deviator = corner.stress - corner.stress[:3].mean() * HYDROSTATIC
    assert corner.stress[:3].mean() == pytest.approx(cut, rel=1e-8)
    root = np.sqrt(0.5 * deviator[:3] @ deviator[:3] + deviator[3:] @ deviator[3:])
    assert root == pytest.approx(xi * C - eta * cut, rel=1e-8)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("keys", [{}, CAPPED, {"hardening": 2e9}])
def test_the_tangent_of_stone_under_pressure_or_tension_from_all_sides(sign, keys):
    """Without deviator of the trial stress: shear stiffness is elastic at cap and cut-off, 0 at the apex."""
    law, h = DruckerPrager(C, 35.0, 10.0, **keys), 1e-8
    strain = sign * 4e-3 / 3 * HYDROSTATIC[None]
    zero, fresh = np.zeros((1, 6)), law.initial(1)
    made = law.update(STONE, zero, strain, fresh, SIZE)
    columns = [
        law.update(STONE, zero, strain + h * unit, fresh, SIZE).stress
        - law.update(STONE, zero, strain - h * unit, fresh, SIZE).stress
        for unit in np.eye(6)
    ]
    wrong = np.abs(np.stack(columns, axis=2) / (2 * h) - made.tangent)
    assert wrong.max() <= 1e-6 * STONE.matrix.max()
    assert made.changed[0] == (sign > 0 or bool(keys and "crushing_pressure" in keys))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"cohesion": 0.0}, "cohesion is 0, expected a number > 0"),
        ({"friction_angle": 90.0}, "friction_angle is 90"),
        ({"dilatancy_angle": 40.0}, "dilatancy_angle is 40, expected at most the friction_angle 35"),
        ({"hardening": -1.0}, "hardening is -1"),
        ({"crushing_hardening": 1e9}, "crushing_hardening is 1e.09, but nothing is crushed"),
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
