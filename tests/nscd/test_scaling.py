"""Scale of contacts: against NumPy's own 2-norm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem
from masonry_fem.nscd.scaling import contact_scale, whole_scale
from tests.nscd.families import FAMILIES, blocks


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("size", [1e-200, 1e-9, 1.0, 1e200])
def test_scale_is_the_norm_of_the_diagonal_block(d: int, size: float) -> None:
    rng = np.random.default_rng(d)
    blocks = size * rng.normal(size=(20, d, d))
    blocks[0] = size * np.eye(d)
    blocks[1] = size * np.diag([1.0] + [1e-12] * (d - 1))
    blocks[2] = size * np.ones((d, d))
    W = np.zeros((20 * d, 20 * d))
    for i, block in enumerate(blocks):
        W[i * d : (i + 1) * d, i * d : (i + 1) * d] = block
    expected = np.linalg.norm(blocks, ord=2, axis=(1, 2))
    problem = ContactProblem.plain(W, np.zeros((20, d)), 0.5)
    np.testing.assert_allclose(contact_scale(problem), expected, rtol=1e-12)


def test_what_nothing_moves_gets_the_mean_of_the_others() -> None:
    problem = ContactProblem.plain(np.diag([2.0, 2, 2, 0, 0, 0, 4, 4, 4]), np.zeros((3, 3)), 0.5)
    np.testing.assert_allclose(contact_scale(problem), [2, 3, 4])


@pytest.mark.parametrize("d", [2, 3])
def test_elastic_contacts_are_scaled_by_their_compliance_and_rigid_ones_by_their_bodies(d: int) -> None:
    """‖W_el‖₂ where there is one, else ‖B M_r⁻¹ Bᵀ‖₂, with unit mass in statics."""
    rng = np.random.default_rng(d)
    for family in ("elastic dynamics", "elastic statics"):
        problem = FAMILIES[family](rng, d)
        c, stiff = problem.count, np.arange(problem.count) % 3 == 0
        W = problem.compliance.toarray().reshape(c, d, c, d).copy()
        W[stiff], W[:, :, stiff] = 0.0, 0.0
        mixed = replace(problem, compliance=blocks(W.reshape(c * d, c * d), d))
        mass = np.where(problem.rigid_mass > 0, 2.0 * problem.rigid_mass, 1.0)
        mixed = replace(mixed, rigid_mass=np.where(problem.rigid_mass > 0, mass, 0.0))
        expected = [np.linalg.norm(W[i, :, i], ord=2) for i in range(c)]
        for i in np.flatnonzero(stiff):
            sides = [(body, side) for body, side in zip(problem.bodies[i], problem.rigid_map[i], strict=True)]
            block = sum((side / mass[body]) @ side.T for body, side in sides if body >= 0)
            expected[i] = np.linalg.norm(block, ord=2)
        np.testing.assert_allclose(contact_scale(mixed), expected, rtol=1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_the_whole_scale_is_that_of_elastic_and_rigid_part_together(d: int) -> None:
    problem = FAMILIES["elastic dynamics"](np.random.default_rng(d), d)
    compliance = problem.compliance.toarray().reshape(problem.count, d, problem.count, d)
    expected = []
    for i in range(problem.count):
        block = compliance[i, :, i].copy()
        for body, side in zip(problem.bodies[i], problem.rigid_map[i], strict=True):
            if body >= 0:
                mass = np.where(problem.rigid_mass[body] > 0, problem.rigid_mass[body], 1.0)
                block += (side / mass) @ side.T
        expected.append(np.linalg.norm(block, ord=2))
    np.testing.assert_allclose(whole_scale(problem), expected, rtol=1e-12)
