"""Orthotropic elasticity against its isotropic case, turned tensors, and its own bounds."""

import numpy as np
import pytest

from masonry_fem.bodies.rotation import exponential
from masonry_fem.errors import SceneError
from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.orthotropic import Orthotropic
from masonry_fem.fem.strains import Strains
from masonry_fem.fem.stress import StressRecovery
from tests.fem.materials.strain_paths import turned
from tests.fem.meshes import CELLS, box_mesh, dimension_of

OAK = Orthotropic((12e9, 1.5e9, 0.8e9), (0.4, 0.5, 0.35), (0.9e9, 0.1e9, 0.7e9))


def stone(own, young=10e9, poisson=0.2):
    return ElasticMaterial(young, poisson, 2000.0, orthotropic=own)


def isotropic(young=10e9, poisson=0.2):
    shear = young / (2 * (1 + poisson))
    return Orthotropic((young,) * 3, (poisson,) * 3, (shear,) * 3)


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("cell", CELLS)
def test_equal_moduli_are_those_of_isotropic_stone(cell, plane):
    d = dimension_of(cell)
    mesh = box_mesh(cell, (2, 1, 1)[:d], (0.0,) * d, (0.5, 0.2, 0.3)[:d], 0.2)
    plane = plane if d == 2 else None
    turn = exponential(np.array([0.0, 0.0, 0.7] if d == 2 else [0.3, -0.5, 0.7]))
    materials = [stone(None), stone(isotropic().turned(turn))]
    plain, own = assemble_shapes([mesh, mesh], materials, plane)
    scale = abs(plain.stiffness).max()
    assert abs(own.stiffness - plain.stiffness).max() <= 1e-11 * scale  # turns have 12 digits
    assert abs(own.stiffness - own.stiffness.T).max() == 0.0
    assert abs(own.mass - plain.mass).max() == 0.0
    moved = 1e-4 * np.random.default_rng(0).normal(size=(1, mesh.points.size))
    one, two = (StressRecovery.of(mesh, material, plane).gauss_stress(moved) for material in materials)
    np.testing.assert_allclose(two, one, atol=1e-11 * np.abs(one).max())
    np.testing.assert_allclose(
        energy_density(two, materials[1]), energy_density(one, materials[0]), rtol=1e-9
    )


def test_turned_strains_have_turned_stresses():
    turn = exponential(np.array([0.7, -1.1, 0.4]))
    strain = np.random.default_rng(1).normal(size=(5, 6))
    expected = turned(strain @ OAK.matrix, turn, shears=1)
    found = turned(strain, turn, shears=2) @ OAK.turned(turn).matrix
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


def test_a_bar_off_its_axis_has_the_modulus_of_the_turned_tensor():
    """1/E(α) = cos⁴/E_1 + sin⁴/E_2 + (1/G_12 − 2 ν_12/E_1) sin² cos²."""
    for angle in np.radians([0.0, 17.0, 45.0, 90.0]):
        c, s = np.cos(angle), np.sin(angle)
        matrix = OAK.turned(exponential(np.array([0.0, 0.0, angle]))).matrix
        soft = c**4 / 12e9 + s**4 / 1.5e9 + (1 / 0.9e9 - 0.8 / 12e9) * s**2 * c**2
        assert np.linalg.inv(matrix)[0, 0] == pytest.approx(soft, rel=1e-9)


@pytest.mark.parametrize("cell", CELLS)
def test_a_mesh_pulled_off_its_axes_has_the_strains_of_its_compliance(cell):
    """Any uniform stress: the displacements of its strain balance it on every mesh."""
    d = dimension_of(cell)
    turn = exponential(np.array([0.0, 0.0, 0.7] if d == 2 else [0.3, -0.5, 0.7]))
    material, plane = stone(OAK.turned(turn)), "stress" if d == 2 else None
    mesh = box_mesh(cell, (2, 1, 1)[:d], (0.0,) * d, (0.5, 0.2, 0.3)[:d], 0.2)
    (own,) = assemble_shapes([mesh], [material], plane)
    stress = np.array([1e6, -3e5, 0, 2e5, 0, 0] if d == 2 else [1e6, -3e5, 2e5, 2e5, 1e5, -4e5])
    strain = np.linalg.inv(material.orthotropic.matrix) @ stress  # σ_zz is 0 in the plane
    gradient = np.array([
        [strain[0], strain[3] / 2, strain[5] / 2],
        [strain[3] / 2, strain[1], strain[4] / 2],
        [strain[5] / 2, strain[4] / 2, strain[2]],
    ])[:d, :d]  # fmt: skip
    moved = (mesh.points @ gradient).ravel()
    uniform = np.broadcast_to(stress, (1, *Strains.of(mesh).weight.shape, 6))
    forces = Strains.of(mesh).forces(uniform)[0]
    np.testing.assert_allclose(own.stiffness @ moved, forces, atol=1e-10 * np.abs(forces).max())
    found = StressRecovery.of(mesh, material, plane).gauss_stress(moved[None])
    np.testing.assert_allclose(found, uniform, atol=1e-9 * 1e6)


@pytest.mark.parametrize(
    ("poisson", "message"),
    [
        ((3.0, 0.3, 0.3), r"ν_12 is 3, expected less than 2\.828 in size, the root of E_1/E_2"),
        ((2.5, 1.3, 0.3), r"is -[0-9.]+, expected more than 0, as some strain would give energy"),
    ],
)
def test_ratios_of_no_material_are_refused(poisson, message):
    with pytest.raises(SceneError, match=message):
        Orthotropic((12e9, 1.5e9, 0.8e9), poisson, (1e9, 1e9, 1e9))
