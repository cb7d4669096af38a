"""Every law between free faces: σ_zz = 0, and strengths in the plane against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.fem.material_law import Isotropic
from masonry_fem.fem.materials.brittle_damage import BrittleDamage
from masonry_fem.fem.materials.drucker_prager import DruckerPrager
from masonry_fem.fem.materials.mohr_coulomb import MohrCoulomb
from masonry_fem.fem.plane_stress import PlaneStress
from tests.fem.materials.every_law import LAWS
from tests.fem.materials.strain_paths import SIZE, STONE, Point, turned

YOUNG, POISSON = 10e9, 0.2
C, PHI = 2e6, 35.0
SINE, COSINE = np.sin(np.radians(PHI)), np.cos(np.radians(PHI))
IN_PLANE = np.array([0, 1, 3])
POINTS = 300


class Plate(Point):
    """A point of a plate, driven in its plane; of strains and stresses xx, yy and xy are given."""

    def __init__(self, law, elastic=STONE):
        super().__init__(PlaneStress(law), elastic)

    def pulled(self, axial, side_stress=0.0):
        """A step to the strain xx, with the stress yy prescribed [Pa]; the stress xx."""
        side = self.strain[0, 1] - POISSON * (axial - self.strain[0, 0])
        for _ in range(100):
            trial = np.array([axial, side, 0.0, 0.0, 0.0, 0.0])
            made = self.law.update(self.elastic, self.strain, trial[None], self.internal, SIZE)
            left, slope = made.stress[0, 1] - side_stress, made.tangent[0, 1, 1]
            if abs(left) <= 1e-9 * C:
                break
            side -= left / max(slope, 1e-3 * YOUNG)
        self.to(trial)
        return self.stress[0]


@pytest.fixture(params=LAWS, name="law")
def _law(request):
    return PlaneStress(LAWS[request.param])


def walked(law, seed=0, scale=1e-3):
    """A committed state after a random step in the plane, and another strain: start, strain, committed."""
    random = np.random.default_rng(seed)
    start, strain = np.zeros((2, POINTS, 6))
    start[:, IN_PLANE] = scale * random.normal(size=(POINTS, 3))
    committed = law.update(STONE, np.zeros_like(start), start, law.initial(POINTS), SIZE).internal
    strain[:, IN_PLANE] = start[:, IN_PLANE] + scale * random.normal(size=(POINTS, 3))
    return start, strain, committed


# --- of every law ---------------------------------------------------------------------------------


def test_a_plate_is_the_solid_with_the_strain_that_is_remembered(law):
    """With the ε_zz found, the law in three dimensions has no σ_zz, and the same stress in the plane."""
    start, strain, committed = walked(law)
    made = law.update(STONE, start, strain, committed, SIZE)
    start[:, 2], strain[:, 2] = committed[:, -1], made.internal[:, -1]
    solid = law.law.update(STONE, start, strain, committed[:, :-1], SIZE)
    scale = np.abs(strain @ STONE.matrix).max()
    assert np.abs(solid.stress[:, 2]).max() <= 1e-12 * scale
    np.testing.assert_allclose(made.stress, solid.stress, atol=1e-12 * scale)
    np.testing.assert_array_equal(made.internal[:, :-1], solid.internal)
    assert (made.stress[:, 2] == 0).all()


@pytest.mark.slow
def test_tangent_is_the_derivative_of_the_stress(law):
    start, strain, committed = walked(law)
    made, h = law.update(STONE, start, strain, committed, SIZE), 1e-8
    assert made.changed.sum() > POINTS / 10
    columns = [
        (
            law.update(STONE, start, strain + h * unit, committed, SIZE).stress
            - law.update(STONE, start, strain - h * unit, committed, SIZE).stress
        )
        / (2 * h)
        for unit in np.eye(6)[IN_PLANE]
    ]
    wrong = np.abs(np.stack(columns, axis=2) - made.tangent[:, :, IN_PLANE])[:, IN_PLANE].max(axis=(1, 2))
    assert wrong.max() <= 1e-6 * STONE.matrix.max()
    assert not made.tangent[:, 2].any()
    assert not made.tangent[:, :, 2].any()


def test_small_strains_are_those_of_an_elastic_plate(law):
    strain = np.zeros((POINTS, 6))
    strain[:, IN_PLANE] = 1e-7 * np.random.default_rng(2).normal(size=(POINTS, 3))
    made = law.update(STONE, np.zeros_like(strain), strain, law.initial(POINTS), SIZE)
    factor = YOUNG / (1 - POISSON**2)
    plate = factor * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])
    np.testing.assert_allclose(made.stress[:, IN_PLANE], strain[:, IN_PLANE] @ plate, rtol=1e-11)
    own = made.tangent[:, IN_PLANE][:, :, IN_PLANE]
    np.testing.assert_allclose(own, np.broadcast_to(plate, own.shape), atol=1e-12 * factor)
    np.testing.assert_allclose(
        made.internal[:, -1], -POISSON / (1 - POISSON) * strain[:, :2].sum(axis=1), rtol=1e-11
    )
    assert not made.changed.any()


def test_a_step_that_goes_nowhere_changes_nothing(law):
    start, strain, committed = walked(law)
    kept = committed.copy()
    made = law.update(STONE, start, strain, committed, SIZE)
    again = law.update(STONE, strain, strain, made.internal, SIZE)
    np.testing.assert_allclose(again.stress, made.stress, atol=1e-11 * np.abs(made.stress).max())
    np.testing.assert_allclose(again.internal, made.internal, atol=1e-11)
    np.testing.assert_array_equal(committed, kept)


def test_what_is_turned_in_the_plane_has_turned_stresses(law):
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    random, zero = np.random.default_rng(5), np.zeros((POINTS, 6))
    first, second = np.zeros((2, POINTS, 6))
    first[:, IN_PLANE], second[:, IN_PLANE] = 2e-3 * random.normal(size=(2, POINTS, 3))

    def end(one, two):
        return law.update(
            STONE, one, two, law.update(STONE, zero, one, law.initial(POINTS), SIZE).internal, SIZE
        )

    plain = end(first, second)
    other = end(turned(first, turn, shears=2), turned(second, turn, shears=2))
    expected = turned(plain.stress, turn, shears=1)
    np.testing.assert_allclose(other.stress, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(other.dissipation, plain.dissipation, atol=1e-10 * plain.dissipation.max())


strains = st.lists(
    st.lists(st.floats(-1.0, 1.0, allow_subnormal=False), min_size=3, max_size=3), min_size=1, max_size=6
)


@settings(max_examples=60, deadline=None)
@given(path=strains, scale=st.sampled_from([1e-5, 1e-3, 1e-1]), name=st.sampled_from(sorted(LAWS)))
def test_no_step_gives_energy_and_none_is_lost_without_a_name(path, scale, name):
    """The work is that in the plane."""
    law = PlaneStress(LAWS[name])
    start, committed, stored = np.zeros((1, 6)), law.initial(1), 0.0
    for step in path:
        strain = np.zeros((1, 6))
        strain[0, IN_PLANE] = scale * np.array(step)
        made = law.update(STONE, start, strain, committed, SIZE)
        across = np.abs([made.internal[0, -1], committed[0, -1]]).max()
        trial = STONE.matrix.max() * max(np.abs(strain).max(), np.abs(start).max(), across) ** 2
        assert made.dissipation[0] >= -1e-14 * trial
        work = float(made.stress[0] @ (strain - start)[0])
        named = made.stored[0] - stored + made.dissipation[0] + made.excess[0]
        assert abs(work - named) <= 1e-12 * trial
        start, committed, stored = strain, made.internal, made.stored[0]


# --- closed forms ---------------------------------------------------------------------------------


@pytest.mark.parametrize("psi", [None, 10.0, 0.0])
@pytest.mark.parametrize("cut", [None, 0.4e6])
def test_the_hexagon_of_mohr_and_coulomb(psi, cut):
    """Uniaxial and biaxial strengths, tension and pressure together, and shear."""
    law = MohrCoulomb(C, PHI, psi, cut)
    pressed, drawn = 2 * C * COSINE / (1 - SINE), min(2 * C * COSINE / (1 + SINE), cut or np.inf)
    for sign, limit in ((-1, pressed), (1, drawn)):
        uniaxial, biaxial = Plate(law), Plate(law)
        for strain in sign * np.linspace(0, 6e-3, 13)[1:]:
            stress = uniaxial.pulled(strain)
            biaxial.to([strain, strain, 0, 0, 0, 0])
        assert stress == pytest.approx(sign * limit, rel=1e-8)
        np.testing.assert_allclose(biaxial.stress[:2], sign * limit, rtol=1e-8)
    mixed, side = Plate(law), -0.6 * pressed
    mixed.to(np.array([-POISSON, 1, 0, 0, 0, 0]) * side / YOUNG)
    for strain in mixed.strain[0, 0] + np.linspace(0, 2e-3, 21)[1:]:
        stress = mixed.pulled(strain, side)
    along = (2 * C * COSINE + (1 - SINE) * side) / (1 + SINE)
    assert stress == pytest.approx(min(along, cut or np.inf), rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("psi", [None, 10.0, 0.0])
def test_the_ellipse_of_drucker_and_prager(psi):
    """√J2 + η p = ξ c, with J2 = (σ_x² − σ_x σ_y + σ_y²)/3 + τ² and p = (σ_x + σ_y)/3."""
    law = DruckerPrager(C, PHI, psi, fit="plane_strain")
    eta, xi, _ = law.cone
    for sign in (-1, 1):
        uniaxial, biaxial = Plate(law), Plate(law)
        for strain in sign * np.linspace(0, 8e-3, 33)[1:]:
            stress = uniaxial.pulled(strain)
            biaxial.to([strain, strain, 0, 0, 0, 0])
        assert stress == pytest.approx(sign * xi * C / (1 / np.sqrt(3) + sign * eta / 3), rel=1e-8)
        both = sign * xi * C / (1 / np.sqrt(3) + sign * 2 * eta / 3)
        np.testing.assert_allclose(biaxial.stress[:2], both, rtol=1e-8)


def test_shear_without_dilatancy():
    """The plate stays as thick as it is, and τ = ξ c; cycles dissipate the area of their loops."""
    law, angle = DruckerPrager(C, PHI, 0.0), 5e-3
    plate, limit = Plate(law), law.cone[1] * C
    for _ in range(2):
        before = plate.dissipated
        for turn in (*np.linspace(0, 1, 41)[1:], *np.linspace(1, -1, 81)[1:], *np.linspace(-1, 0, 41)[1:]):
            plate.to([0, 0, 0, turn * angle, 0, 0])
            assert abs(plate.stress[3]) <= limit * (1 + 1e-12)
    assert plate.internal[0, -1] == pytest.approx(0.0, abs=1e-14)
    assert plate.dissipated - before == pytest.approx(4 * limit * (angle - limit / STONE.shear), rel=1e-8)


def test_hardening_raises_the_uniaxial_strength_by_its_slope():
    law = DruckerPrager(C, PHI, 10.0, hardening=3e9)
    eta, xi, eta_bar = law.cone
    plate = Plate(law)
    for strain in np.linspace(0, -6e-3, 25)[1:]:
        stress = -plate.pulled(strain)
    lean, lean_bar = 1 / np.sqrt(3) - eta / 3, 1 / np.sqrt(3) - eta_bar / 3
    flow = (6e-3 - xi * C / (lean * YOUNG)) / (xi**2 * 3e9 / (lean * YOUNG) + lean_bar)
    np.testing.assert_allclose(stress, (xi * C + xi**2 * 3e9 * flow) / lean, rtol=1e-8)


@pytest.mark.parametrize("poisson", [0.0, 0.2, 0.4])
def test_a_bar_in_tension_softens_exponentially_and_bears_pressure_again(poisson):
    """s(e) = f_t exp(−2 H (E e/f_t − 1)), as in three dimensions: its sides are free."""
    strength, energy, stone = 2e6, 100.0, Isotropic.of(YOUNG, poisson)
    H = SIZE[0] / (2 * YOUNG * energy / strength**2 - SIZE[0])
    plate = Plate(BrittleDamage(strength, energy), stone)
    for strain in np.linspace(0, 8 * strength / YOUNG, 33)[1:]:
        stress, intact = plate.pulled(strain), YOUNG * strain
        expected = intact if intact <= strength else strength * np.exp(-2 * H * (intact / strength - 1))
        assert stress == pytest.approx(expected, rel=1e-8)
    damage = plate.internal[0, 1]
    assert 0.5 < damage < 1.0
    assert plate.pulled(-1e-4) == pytest.approx(-1e-4 * YOUNG, rel=1e-8)


@pytest.mark.parametrize("poisson", [0.0, 0.2, 0.4])
def test_both_directions_of_a_plate_crack_at_the_strength(poisson):
    """Equal strains e: σ = E e/(1 − ν), up to f_t; then e = (1/g − ν) σ/E, as the thickness bears nothing."""
    strength, stone = 2e6, Isotropic.of(YOUNG, poisson)
    plate = Plate(BrittleDamage(strength, 100.0), stone)
    limit = strength * (1 - poisson) / YOUNG
    plate.to(np.array([1, 1, 0, 0, 0, 0]) * 0.999 * limit)
    np.testing.assert_allclose(plate.stress[:2], 0.999 * strength, rtol=1e-10)
    assert plate.internal[0, 1] == 0.0
    for share in np.linspace(1.0, 4.0, 13)[1:]:
        strain = share * limit
        plate.to(np.array([1, 1, 0, 0, 0, 0]) * strain)
        kept = 1 - plate.internal[0, 1]
        expected = YOUNG * strain / (1 / kept - poisson)
        np.testing.assert_allclose(plate.stress[:2], expected, rtol=1e-8)
        assert plate.internal[0, -1] == pytest.approx(-2 * poisson * expected / YOUNG, rel=1e-8, abs=1e-15)
    assert kept < 0.6
