"""Mohr and Coulomb's pyramid with its cut-off of tension against closed forms: planes, edges, points."""

import numpy as np
import pytest
from scipy.optimize import nnls

from masonry_fem.errors import LawError
from masonry_fem.fem.materials.mohr_coulomb import ENDS, MohrCoulomb
from masonry_fem.fem.materials.parts.principal import principal
from tests.fem.materials.strain_paths import SIZE, STONE, Point

C, PHI = 2e6, 35.0
SINE, COSINE = np.sin(np.radians(PHI)), np.cos(np.radians(PHI))
APEX = C * COSINE / SINE
RATIO = (1 + SINE) / (1 - SINE)
DILATANCIES = [None, 10.0, 0.0]
CUTS = [None, 0.3e6, 1.5e6]


@pytest.mark.parametrize("psi", DILATANCIES)
@pytest.mark.parametrize("confinement", [0.0, 1e6])
def test_triaxial_compression(psi, confinement):
    point = Point(MohrCoulomb(C, PHI, psi))
    point.to(np.array([1, 1, 1, 0, 0, 0]) * -confinement / (3 * STONE.bulk))
    for axial in np.linspace(0, -5e-3, 11)[1:]:
        stress = point.squeezed(axial, -confinement)
    assert stress == pytest.approx(-(RATIO * confinement + 2 * C * np.sqrt(RATIO)), rel=1e-8)
    plastic = point.strain[0] - np.linalg.solve(STONE.matrix, point.stress)
    sine = np.sin(np.radians(PHI if psi is None else psi))
    assert plastic[:3].sum() / plastic[2] == pytest.approx(-2 * sine / (1 - sine), rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("confinement", [0.0, 1e6, 4e6])
def test_triaxial_extension(cut, confinement):
    """(1 + sin φ) σ_axial + (1 − sin φ) · confinement = 2 c cos φ, and no more than the cut-off."""
    point = Point(MohrCoulomb(C, PHI, 10.0, cut))
    point.to(np.array([1, 1, 1, 0, 0, 0]) * -confinement / (3 * STONE.bulk))
    for axial in np.linspace(0, 4e-3, 21)[1:]:
        stress = point.squeezed(axial, -confinement)
    bound = (2 * C * COSINE - (1 - SINE) * confinement) / (1 + SINE)
    assert stress == pytest.approx(min(bound, np.inf if cut is None else cut), rel=1e-8)


@pytest.mark.parametrize("psi", DILATANCIES)
def test_the_intermediate_stress_makes_no_difference(psi):
    """Plane strain between free sides: σ_zz = −2 c cos φ/(1 − sin φ), whatever σ_yy is."""
    law = MohrCoulomb(C, PHI, psi)
    start, internal, side = np.zeros((1, 6)), law.initial(1), 0.0
    for axial in np.linspace(0, -6e-3, 13)[1:]:
        for _ in range(50):
            strain = np.array([[side, 0.0, axial, 0, 0, 0]])
            made = law.update(STONE, start, strain, internal, SIZE)
            if abs(made.stress[0, 0]) <= 1e-10 * C:
                break
            side -= made.stress[0, 0] / made.tangent[0, 0, 0]
        start, internal = strain, made.internal
    assert -1e-3 * C > made.stress[0, 1] > made.stress[0, 2]
    np.testing.assert_allclose(made.stress[0, 2], -2 * C * COSINE / (1 - SINE), rtol=1e-8)


@pytest.mark.parametrize("psi", DILATANCIES)
@pytest.mark.parametrize("steps", [1, 7])
def test_simple_shear_without_change_of_volume(psi, steps):
    """One plane slips by Λ, dilatancy that cannot have its way makes pressure: with a = 2 (K − 2G/3) sin ψ

    Λ = (G γ − c cos φ)/(a sin φ + 2 G (1 + sin φ sin ψ)), and no stress of the third axis but −a Λ.
    """
    point, angle, sine = (
        Point(MohrCoulomb(C, PHI, psi)),
        4e-3,
        np.sin(np.radians(PHI if psi is None else psi)),
    )
    for share in np.arange(1, steps + 1) / steps:
        point.to([0, 0, 0, share * angle, 0, 0])
    G, pressing = STONE.shear, 2 * (STONE.bulk - 2 * STONE.shear / 3) * sine
    flow = (G * angle - C * COSINE) / (pressing * SINE + 2 * G * (1 + SINE * sine))
    first = G * angle - flow * (pressing + 2 * G * (1 + sine))
    last = -G * angle - flow * (pressing - 2 * G * (1 - sine))
    assert first > -pressing * flow > last
    mean, shear = (first + last) / 2, (first - last) / 2
    np.testing.assert_allclose(
        point.stress, [mean, mean, -pressing * flow, shear, 0, 0], rtol=1e-8, atol=1e-8 * C
    )
    assert shear + mean * SINE == pytest.approx(C * COSINE, rel=1e-8)


@pytest.mark.parametrize("psi", DILATANCIES)
@pytest.mark.parametrize("cut", CUTS)
def test_no_stress_is_beyond_the_apex(psi, cut):
    point = Point(MohrCoulomb(C, PHI, psi, cut))
    most = APEX if cut is None else min(APEX, cut)
    for stretch in (3.0, 8.0):
        point.to(np.array([1.0, 1.1, 0.9, 0.1, -0.05, 0.08]) * stretch * APEX / (3 * STONE.bulk))
    np.testing.assert_allclose(point.stress, most * np.array([1, 1, 1, 0, 0, 0]), rtol=1e-8, atol=1e-8 * C)


def test_cycles_of_shear_without_friction_dissipate_the_area_of_their_loops():
    point, angle = Point(MohrCoulomb(C, 0.0)), 5e-3
    for _ in range(3):
        before = point.dissipated
        for turn in (*np.linspace(0, 1, 41)[1:], *np.linspace(1, -1, 81)[1:], *np.linspace(-1, 0, 41)[1:]):
            point.to([0, 0, 0, turn * angle, 0, 0])
    np.testing.assert_allclose(point.dissipated - before, 4 * C * (angle - C / STONE.shear), rtol=1e-8)


@pytest.mark.parametrize("psi", DILATANCIES)
@pytest.mark.parametrize("cut", CUTS)
def test_stresses_are_inside_and_flow_is_that_of_the_planes_they_are_on(psi, cut):
    """Every end, from random strains: planes, edges and points; each flow a sum of the planes' own."""
    law, random = MohrCoulomb(C, PHI, psi, cut), np.random.default_rng(4)
    strain = random.normal(size=(3000, 6)) * 10.0 ** random.uniform(-4, -2, (3000, 1))
    strain[:, :3] += 10.0 ** random.uniform(-5, -2, (3000, 1)) * random.choice([-1, 1], (3000, 1))
    made = law.update(STONE, np.zeros_like(strain), strain, law.initial(3000), SIZE)
    normals, flows, bounds = law.planes
    values = principal(made.stress)[0]
    left = values @ normals.T - bounds
    scale = 2 * C + np.abs(strain @ STONE.matrix).max(axis=1)
    assert (left.max(axis=1) <= 1e-11 * scale).all()
    trial = principal(strain @ STONE.matrix)[0]
    flowed = np.linalg.solve(STONE.matrix[:3, :3], (trial - values).T).T
    on = left >= -1e-9 * scale[:, None]
    seen = set()
    for row in np.flatnonzero(made.changed):
        planes = np.flatnonzero(on[row])
        rates, missing = nnls(flows[planes].T, flowed[row])
        assert missing <= 1e-9 * np.abs(strain[row]).max()
        seen.add(tuple(planes[rates > 0]))
    assert {len(planes) for planes in seen} >= {1, 2, 3}


def test_every_end_is_needed():
    """Trial stresses beyond each plane, edge and point come to it: 12 regions, the cut-off below the apex."""
    law = MohrCoulomb(C, PHI, PHI, 0.4e6)
    normals, flows, bounds = law.planes
    D, random = STONE.matrix[:3, :3], np.random.default_rng(8)
    assert len(ENDS) == 12
    for planes in ENDS:
        chosen = list(planes)
        free = np.linalg.lstsq(normals[chosen], bounds[chosen], rcond=None)[0]
        inside = None
        for _ in range(4000):  # a point of the end that is inside all others
            shift = random.normal(size=3) * 4e6
            shift -= np.linalg.pinv(normals[chosen]) @ (normals[chosen] @ shift)
            end = free + shift
            if (normals @ end - bounds).max() <= 1e-6 and end[0] >= end[1] - 1e-6 and end[1] >= end[2] - 1e-6:
                inside = end
                break
        assert inside is not None, planes
        trial = inside + D @ (flows[chosen].T @ random.uniform(1e-4, 2e-4, len(chosen)))
        strain = np.zeros((1, 6))
        strain[0, :3] = np.linalg.solve(D, trial)
        made = law.update(STONE, np.zeros((1, 6)), strain, law.initial(1), SIZE)
        np.testing.assert_allclose(made.stress[0, :3], inside, atol=1e-8 * C)


YOUNG, WIDTH, CUT, CRACK, SLIP = 10e9, float(SIZE[0]), 0.8e6, 40.0, 4000.0


def soft(residual=0.0, psi=10.0):
    return MohrCoulomb(C, PHI, psi, CUT, fracture_energy=CRACK, shear_fracture_energy=SLIP, residual=residual)


@pytest.mark.parametrize("residual", [0.0, 0.3])
def test_a_bar_in_tension_softens_along_a_straight_line(residual):
    """σ = f_t − β λ with β = (1 − r)² h f_t²/(2 G_f), e = σ/E + λ, down to r f_t."""
    point, slope = Point(soft(residual)), (1 - residual) ** 2 * WIDTH * CUT**2 / (2 * CRACK)
    stresses = []
    for strain in np.linspace(0, 4e-3, 41)[1:]:
        stresses.append(point.squeezed(strain))
        flow = (YOUNG * strain - CUT) / (YOUNG - slope)
        expected = YOUNG * strain if flow < 0 else max(CUT - slope * flow, residual * CUT)
        assert stresses[-1] == pytest.approx(expected, rel=1e-8, abs=1e-8 * CUT)
    assert stresses[-1] == pytest.approx(residual * CUT, abs=1e-8 * CUT)
    assert sum(1.001 * residual * CUT < stress < 0.999 * CUT for stress in stresses) >= 5


@pytest.mark.slow
@pytest.mark.parametrize("psi", [None, 10.0, 0.0])
@pytest.mark.parametrize("confinement", [0.0, 1e6])
def test_a_column_under_pressure_softens_along_a_straight_line(psi, confinement):
    """Both planes at σ1 = σ2 slip: the axial flow is (1 − sin ψ) Λ, z = h c cos φ Λ/G_s, c falls by z c."""
    point, sine = Point(soft(psi=psi)), np.sin(np.radians(PHI if psi is None else psi))
    point.to(np.array([1, 1, 1, 0, 0, 0]) * -confinement / (3 * STONE.bulk))
    first, left = point.strain[0, 2], -confinement * RATIO
    whole = 2 * C * np.sqrt(RATIO)
    slope = whole * WIDTH * C * COSINE / SLIP
    seen = 0
    for axial in first + np.linspace(0, -80e-3, 161)[1:]:
        stress = point.squeezed(axial, -confinement)
        elastic = -confinement + YOUNG * (axial - first)
        flow = (left - whole - elastic) / (YOUNG * (1 - sine) - slope)
        strength = whole - slope * flow
        expected = elastic if flow < 0 else left - max(strength, 0.0)
        seen += flow > 0 and strength > 0
        assert stress == pytest.approx(expected, rel=1e-8, abs=1e-8 * C)
    assert seen >= 5
    assert stress == pytest.approx(left, rel=1e-8, abs=1e-8 * C)  # friction alone


def test_all_directions_crack_together_at_the_apex():
    """3 K (e − λ) = f_t (1 − z), z = 3 λ h f_t/(2 G_f)."""
    point = Point(soft())
    pull = CUT / (3 * STONE.bulk)
    for share in (0.9, 1.5, 3.0, 6.0):
        point.to(np.array([1, 1, 1, 0, 0, 0]) * share * pull)
        slope = 3 * WIDTH * CUT**2 / (2 * CRACK)
        flow = max((share - 1) * CUT / (3 * STONE.bulk - slope), 0.0)
        np.testing.assert_allclose(point.stress[:3], 3 * STONE.bulk * (share * pull - flow), rtol=1e-8)


def test_a_crack_takes_the_fracture_energy_and_a_slip_that_of_shear():
    """In any number of steps."""
    crack, slip = Point(soft()), Point(MohrCoulomb(C, 0.0, shear_fracture_energy=SLIP))
    N = 7
    for point, taken, stiff, top, component in (
        (crack, CRACK, STONE.bulk + 4 * STONE.shear / 3, CUT, 2),
        (slip, SLIP, STONE.shear, C, 3),
    ):
        opening = 2 * taken / (top * WIDTH)
        for share in np.arange(N + 1) / N:
            strain = np.zeros(6)
            strain[component] = top * (1 - share) / stiff + share * opening
            point.to(strain)
        assert point.stress[component] == pytest.approx(0.0, abs=1e-8 * top)
        assert point.dissipated * WIDTH == pytest.approx(taken, rel=1e-8)
        point.to(2 * strain)
        assert point.stress[component] == pytest.approx(0.0, abs=1e-8 * top)


def test_cracked_stone_bears_pressure_and_rubs():
    """Nothing is left of cohesion and tension: −σ = confinement (1 + sin φ)/(1 − sin φ)."""
    point = Point(soft())
    for axial in np.linspace(0, 4e-3, 21)[1:]:
        point.squeezed(axial)
    assert point.internal[0, 7] == 1.0
    for axial in np.linspace(3e-3, -8e-3, 34):
        stress = point.squeezed(axial, -1e6)
    assert stress == pytest.approx(-RATIO * 1e6, rel=1e-8)


def test_slip_hardens_by_its_slope_and_cycles_add_up():
    """φ = 0: τ = (c + H γ)/(1 + H/G) in the first shear; back, by 2 τ elastically, and on from there."""
    H, angle = 2e9, 4e-3
    point = Point(MohrCoulomb(C, 0.0, hardening=H))
    point.to([0, 0, 0, angle, 0, 0])
    first = (C + H * angle) / (1 + H / STONE.shear)
    assert point.stress[3] == pytest.approx(first, rel=1e-8)
    slip = angle - first / STONE.shear
    assert point.internal[0, 7] == pytest.approx(slip, rel=1e-8)
    point.to([0, 0, 0, -angle, 0, 0])
    # c + H (slip + more) = G (angle + slip − more)
    more = (STONE.shear * (angle + slip) - C - H * slip) / (STONE.shear + H)
    assert point.stress[3] == pytest.approx(-(C + H * (slip + more)), rel=1e-8)


def test_a_column_hardens_under_pressure():
    """σ = −2 √((1 + sin φ)/(1 − sin φ)) (c + H 2 cos φ Λ), with the axial flow (1 − sin ψ) Λ."""
    H, psi = 1e9, 10.0
    point, side = Point(MohrCoulomb(C, PHI, psi, hardening=H)), 1 - np.sin(np.radians(psi))
    for axial in np.linspace(0, -6e-3, 13)[1:]:
        stress = point.squeezed(axial)
    slope = 4 * np.sqrt(RATIO) * H * COSINE
    flow = (6e-3 * YOUNG - 2 * C * np.sqrt(RATIO)) / (YOUNG * side + slope)
    assert stress == pytest.approx(-(2 * C * np.sqrt(RATIO) + slope * flow), rel=1e-8)


def test_elements_that_are_too_wide_to_soften_are_refused():
    """Tension in all directions loses uniqueness first: h f_t²/(2 G_f) = K."""
    law, widest = soft(), 2 * CRACK * STONE.bulk / CUT**2
    law.refuse(STONE, np.array([0.99 * widest]))
    with pytest.raises(LawError, match=r"m wide, expected less than .* larger fracture_energy"):
        law.refuse(STONE, np.array([0.1, 1.01 * widest]))
    MohrCoulomb(C, PHI).refuse(STONE, np.array([1e9]))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"cohesion": 0.0}, "cohesion is 0, expected a number > 0"),
        ({"dilatancy_angle": 40.0}, "dilatancy_angle is 40, expected at most the friction_angle 35"),
        ({"tensile_strength": 0.0}, "tensile_strength is 0, expected a number > 0"),
        ({"hardening": 1e9, "fracture_energy": 10.0}, "hardening is 1e.09 beside a fracture energy"),
        ({"residual": 0.2}, "residual is 0.2, but nothing is lost, expected a fracture_energy"),
        ({"friction_angle": 0.0, "fracture_energy": 9.0}, "fracture_energy is 9, but without friction"),
    ],
)
def test_what_is_impossible_is_refused(keys, message):
    with pytest.raises(LawError, match=message):
        MohrCoulomb(**({"cohesion": C, "friction_angle": PHI} | keys))
