"""Strength–energy laws at one point: stiffness, strength and energy are what was asked for."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Bilinear, Exponential, MonerieAcary, Trapezoidal, probe

# joints of the shear wall J4D
DATA = {"normal_stiffness": 82e9, "tangential_stiffness": 36e9, "normal_strength": 0.25e6,
        "tangential_strength": 0.35e6, "normal_energy": 18.0, "tangential_energy": 125.0}  # fmt: skip
SHAPES = (Bilinear, Exponential, MonerieAcary, Trapezoidal)
CRITICAL = 0.25e6 / 82e9, 0.35e6 / 36e9


def direction(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def along(law, unit, end, steps=600):
    """A proportional opening that begins at the threshold."""
    first = np.linspace(0, 1, 3)[1:] * threshold(unit)
    return probe(law, np.outer([*first, *np.linspace(first[-1], end, steps + 1)[1:]], unit))


def threshold(unit):
    """Elliptic: the opening of a direction at which damage begins."""
    return 1 / np.hypot(unit[0] / CRITICAL[0], unit[1] / CRITICAL[1])


def test_monerie_acary_in_tension():
    """A7.10, mode I."""
    critical, tail = CRITICAL[0], 1.5 * (18.0 / 0.25e6 - 0.5 * CRITICAL[0])
    assert (critical, tail) == pytest.approx((3.048780e-6, 1.057134e-4), rel=1e-6)
    opening = [0.5 * critical, critical, *(critical + np.array([0.25, 0.5, 0.75, 1.0]) * tail)]
    history = probe(MonerieAcary(**DATA), [[x, 0] for x in opening])
    assert history.stress[:, 0] == pytest.approx(
        [125e3, 250e3, 234.375e3, 187.5e3, 109.375e3, 0], rel=1e-10, abs=1e-6
    )
    assert history.dissipated[-1] == pytest.approx(18.0, rel=1e-10)


def test_monerie_acary_in_shear():
    """A7.10, mode II."""
    critical, tail = CRITICAL[1], 1.5 * (125.0 / 0.35e6 - 0.5 * CRITICAL[1])
    assert (critical, tail) == pytest.approx((9.722222e-6, 5.284226e-4), rel=1e-6)
    slide = critical + np.array([0.0, 0.25, 0.5, 0.75, 1.00001]) * tail
    history = probe(MonerieAcary(**DATA, friction=0.0), [[0, x] for x in slide], pressure=1e6)
    assert history.stress[:, 1] == pytest.approx(
        [350e3, 328.125e3, 262.5e3, 153.125e3, 0], rel=1e-10, abs=1e-6
    )
    assert history.dissipated[-1] == pytest.approx(125.0, rel=1e-10)
    assert history.state.broken[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_demand_is_the_opening_over_that_of_further_damage(shape):
    openings = CRITICAL[0] * np.array([0.5, 1.0, 3.0, 1.5, 3.0, 1e6, 1e6])
    history = probe(shape(**DATA), [[x, 0] for x in openings])
    assert history.demand == pytest.approx([0.5, 1.0, 3.0, 0.5, 1.0, 1e6 / 3.0, 0.0], rel=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.5, np.pi / 2])
@pytest.mark.parametrize("mixing", [1.0, 2.0])
def test_energy_of_a_mode(shape, angle, mixing):
    """The area below a proportional opening is G of its mode, whatever the shape and the steps."""
    law, unit = shape(**DATA, mixing=mixing, friction=0.0), direction(angle)
    load = np.array([82e9, 36e9]) * unit**2
    share = load[1] / load.sum()
    energy = (((1 - share) / 18.0) ** mixing + (share / 125.0) ** mixing) ** (-1 / mixing)
    history = along(law, unit, 60 * energy / (load.sum() * threshold(unit)), steps=6)
    assert history.dissipated[-1] + history.stored[-1] == pytest.approx(energy, rel=1e-10)
    assert history.stored[1] == pytest.approx(0.5 * load.sum() * threshold(unit) ** 2, rel=1e-10)
    assert history.adhesion[1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("residual", "angle"), [(0.0, 0.0), (0.0, 0.5), (0.4, 0.5), (0.4, 0.0)])
def test_book_keeping_is_the_area(shape, residual, angle):
    """Stored and dissipated energy against the work by quadrature along a proportional opening."""
    law, unit = shape(**DATA, residual=residual, friction=0.0), direction(angle)
    history = along(law, unit, 30 * threshold(unit))
    work = history.work()
    assert history.dissipated + history.stored == pytest.approx(work, rel=3e-4, abs=1e-9)  # trapezoids


@pytest.mark.parametrize("shape", SHAPES)
def test_unloading_goes_to_the_residual_opening(shape):
    opening = 30e-6
    for residual in (0.0, 0.3, 0.9):
        law = shape(**DATA, residual=residual)
        there = probe(law, [[opening, 0]])
        beta = there.adhesion[-1]
        assert 0 < beta < 1
        left = residual * (1 - beta) * opening
        assert there.state.opening[0] == pytest.approx(left, rel=1e-12)
        back = probe(law, [[0.5 * (opening + left), 0], [left, 0]], state=there.state, start=there.jump[-1])
        assert back.stress[0, 0] == pytest.approx(0.5 * there.stress[-1, 0], rel=1e-12)
        assert back.stress[1, 0] == pytest.approx(0.0, abs=1e-6)
        pressed = probe(law, [[0, 0]], pressure=1e5, state=back.state, start=back.jump[-1])
        assert pressed.jump[0, 0] == pytest.approx(left, rel=1e-12)
        assert pressed.stress[0, 0] == pytest.approx(-1e5)


@pytest.mark.parametrize("shape", SHAPES)
def test_inverse_of_the_shape(shape):
    law = shape(**DATA)
    for ductility in (1.001, 2.0, 50.0):
        gamma = np.full(40, ductility)
        end = 1 + np.linspace(0, 0.99, 40) * 0.5 * (ductility - 1)
        beta = law.shape(end, gamma)
        assert law.reached(beta, gamma) == pytest.approx(end, rel=1e-9)
        assert (np.diff(beta) < 0).all()


def test_friction_may_grow_with_damage():
    law = Bilinear(**DATA, friction=0.75, friction_mode="damage")
    history = probe(law, [[0, 5e-6], [0, 1e-4], [0, 1e-2]], pressure=1e6)
    springs = history.adhesion * 36e9 * np.array([5e-6, 1e-4, 1e-2])
    assert history.stress[:, 1] - springs == pytest.approx(0.75e6 * (1 - history.adhesion))


def test_trapezoid_without_plateau_is_bilinear():
    path = np.outer(np.linspace(0, 4e-4, 50)[1:], direction(0.7))
    one, other = probe(Trapezoidal(**DATA, plateau=0.0), path), probe(Bilinear(**DATA), path)
    assert one.reaction == pytest.approx(other.reaction, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"normal_energy": 0.3}, r"normal_energy is 0\.3 J/m², expected more than the elastic"),
        ({"residual": 1.0}, "residual is 1"),
        ({"mixing": 0.5}, r"mixing is 0\.5"),
        ({"tangential_strength": 0.0}, "tangential_strength is 0"),
        ({"friction_mode": "x"}, "friction_mode"),
    ],
)
def test_impossible_parameters(change, match):
    with pytest.raises(LawError, match=match):
        MonerieAcary(**(DATA | change))


def test_impossible_plateau():
    with pytest.raises(LawError, match="plateau is 1"):
        Trapezoidal(**DATA, plateau=1.0)
