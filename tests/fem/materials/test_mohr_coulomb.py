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


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"cohesion": 0.0}, "cohesion is 0, expected a number > 0"),
        ({"dilatancy_angle": 40.0}, "dilatancy_angle is 40, expected at most the friction_angle 35"),
        ({"tension_strength": 0.0}, "tension_strength is 0, expected a number > 0"),
    ],
)
def test_what_is_impossible_is_refused(keys, message):
    with pytest.raises(LawError, match=message):
        MohrCoulomb(**({"cohesion": C, "friction_angle": PHI} | keys))
