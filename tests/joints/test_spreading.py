"""Non-local adhesion along a row of points."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import FremondCangemi, probe
from tests.joints.samples import path_laplacian

C, ENERGY = 1e10, 50.0
U0 = np.sqrt(ENERGY / C)


def row(count, gradient, spacing=1e-3, **others):
    return FremondCangemi(normal_stiffness=C, tangential_stiffness=C, energy=ENERGY, gradient=gradient,
                          laplacian=path_laplacian(spacing, count), **others)  # fmt: skip


def opened(count, *stretches):
    path = np.zeros((len(stretches), count, 2))
    path[..., 0] = np.array(stretches)[:, None] * U0
    return path


@pytest.mark.parametrize("viscosity", [0.0, 20.0])
def test_uniform_opening_does_not_feel_the_neighbours(viscosity):
    path = opened(7, 0.5, 1.5, 2.5, 1.0)
    local = FremondCangemi(normal_stiffness=C, tangential_stiffness=C, energy=ENERGY, viscosity=viscosity)
    one, other = probe(row(7, 1e-4, viscosity=viscosity), path), probe(local, path)
    assert one.adhesion == pytest.approx(other.adhesion, rel=1e-10)


def test_a_broken_point_weakens_its_neighbours():
    """Yβ − kβ'' = w, β(0) = 0: β = (w/Y)(1 − exp(−x √(Y/k)))."""
    stretch, gradient, count = 1.5, 5e-3, 201
    errors = []
    for refine in (1, 2):
        n = refine * (count - 1) + 1
        law = row(n, gradient, spacing=1e-3 / refine)
        state = law.initial(n, 2)
        state.adhesion[0] = 0.0
        Y = ENERGY * stretch**2
        history = probe(law, opened(n, stretch), state=state)
        x = np.arange(n) * 1e-3 / refine
        exact = (1 - np.exp(-x * np.sqrt(Y / gradient))) / stretch**2
        errors.append(np.abs(history.adhesion[0] - exact).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_adhesion_never_heals_by_its_neighbours():
    rng = np.random.default_rng(4)
    path = opened(40, *np.ones(8)) * rng.uniform(0, 3, (8, 40, 1))
    history = probe(row(40, 1e-4, viscosity=1.0), path)
    assert (np.diff(history.adhesion, axis=0) <= 0).all()
    assert (history.adhesion >= 0).all()
    assert (np.diff(history.dissipated, axis=0) >= 0).all()
    smooth, rough = history.adhesion[-1], probe(row(40, 1e-12, viscosity=1.0), path).adhesion[-1]
    assert np.abs(np.diff(smooth)).sum() < 0.9 * np.abs(np.diff(rough)).sum()


def test_needs_a_laplacian():
    with pytest.raises(LawError, match=r"gradient is 0\.1, expected with a laplacian"):
        FremondCangemi(normal_stiffness=C, tangential_stiffness=C, energy=ENERGY, gradient=0.1)
