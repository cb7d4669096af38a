"""(M̂⁻¹)_el against the eigenmodes of the pencil (K, M), for any step, dense and sparse."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

from masonry_fem.bodies.base import Scheme
from masonry_fem.fem import condense
from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.clamp import holds
from masonry_fem.fem.condense import Compliance, coefficients
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.nscd.mumps import MumpsFactor, petsc
from tests.fem.meshes import box_mesh

STONE = ElasticMaterial(30e9, 0.2, 2400.0)
SCHEMES = [
    Scheme(1e-12, 1.0), Scheme(1e-6, 0.5), Scheme(1e-4, 0.5), Scheme(1e-2, 0.7), Scheme(1.0, 1.0),
    Scheme(1e3, 1.0), Scheme(0.25, 1.0, 0.0),
]  # fmt: skip
MESH = box_mesh("hexahedron", (4, 2, 2), (0, 0, 0), (0.5, 0.25, 0.25))
# a ball joint's worth of freedom: one edge pinned, one face on rollers, a face built in
CLAMPS = {
    "free": (),
    "roller": ((4, (2,)),),
    "two rollers": ((4, (2,)), (0, (0,))),
    "built in": ((4, (0, 1, 2)),),
}
LEFT = {"free": 6, "roller": 3, "two rollers": 1, "built in": 0}


@pytest.fixture(scope="module")
def operators():
    return assemble_shapes([MESH], [STONE], None)[0]


def setting(operators, clamp):
    free = holds(MESH, CLAMPS[clamp], "brick").free
    return free, rigid_modes(MESH.points, operators.mass, free)


@pytest.mark.parametrize("clamp", CLAMPS)
def test_modes_are_those_that_the_clamps_allow(operators, clamp):
    free, modes = setting(operators, clamp)
    assert modes.count == LEFT[clamp]
    held = np.setdiff1d(np.arange(MESH.points.size), free)
    assert not modes.modes[held].any()
    assert not modes.modes[:, modes.count :].any()
    gram = modes.modes.T @ operators.mass @ modes.modes
    np.testing.assert_allclose(gram, np.diag(np.arange(6) < modes.count).astype(float), atol=1e-13)
    size = np.abs(operators.stiffness.data).max() * max(np.abs(modes.modes).max(), 1e-9)
    assert np.abs(operators.stiffness @ modes.modes).max() <= 1e-12 * size


@pytest.mark.parametrize("backend", ["dense", "mumps", "superlu"])
@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
@pytest.mark.parametrize("clamp", CLAMPS)
def test_against_eigenmodes(operators, clamp, scheme, backend, monkeypatch):
    if backend == "superlu":
        monkeypatch.setattr(condense, "petsc", lambda: None)
    damped = replace(operators, material=replace(STONE, mass_damping=0.5, stiffness_damping=1e-5))
    free, modes = setting(operators, clamp)
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (operators.stiffness, operators.mass))
    values, vectors = linalg.eigh(K, M)
    values, vectors = values[modes.count :], vectors[:, modes.count :]
    for material_of in (operators, damped):
        c_m, c_k = coefficients(material_of, scheme)
        exact = (vectors / (c_m + c_k * values)) @ vectors.T
        every = np.arange(MESH.points.size)
        compliance = Compliance(material_of, modes, free, scheme, dense=backend == "dense")
        block = compliance.block(every)
        assert np.abs(compliance.block(every[::6]) - block[::6, ::6]).max() <= 1e-13 * np.abs(block).max()
        assert np.abs(block[np.ix_(free, free)] - exact).max() <= 1e-11 * np.abs(exact).max()
        columns = np.random.default_rng(1).normal(size=(4, MESH.points.size))
        answer = compliance.apply(columns)
        held = np.setdiff1d(np.arange(MESH.points.size), free)
        assert not answer[:, held].any()
        np.testing.assert_allclose(answer, columns @ block, atol=1e-11 * np.abs(columns @ block).max())


def test_coefficients_are_those_of_the_theta_step():
    """M̂ = M + hθ C + h²θ² K with C = α M + β K; statics keeps h²θ² K only."""
    material = replace(STONE, mass_damping=0.5, stiffness_damping=1e-3)
    made = assemble_shapes([box_mesh("quad", (1, 1), (0, 0), (1, 1))], [material], "strain")[0]
    assert coefficients(made, Scheme(0.1, 0.75)) == pytest.approx((1 + 0.0375, 0.075e-3 + 0.005625))
    assert coefficients(made, Scheme(0.1, 1.0, 0.0)) == pytest.approx((0.0, 0.01))


def test_mumps_is_used_where_it_is(operators):
    """Keeps the test above honest: with the wheel, ``sparse`` means MUMPS."""
    if petsc() is None:
        pytest.skip("PETSc without MUMPS")
    free, modes = setting(operators, "free")
    made = Compliance(operators, modes, free, SCHEMES[2], dense=False)
    assert isinstance(made._factor._factor, MumpsFactor)


@pytest.fixture(scope="module")
def large():
    """A free stone that is factorised sparsely, and the dofs of one of its faces."""
    mesh = box_mesh("hexahedron", (12, 12, 12), (0, 0, 0), (1.0, 1.0, 1.0))
    made = assemble_shapes([mesh], [STONE], None)[0]
    modes = rigid_modes(mesh.points, made.mass, np.arange(mesh.points.size))
    face = np.unique(mesh.facets[mesh.facet_face == 4])
    return made, modes, (face[:, None] * 3 + np.arange(3)).ravel()


@pytest.mark.parametrize("inertia", [0.0, 1.0])
def test_block_of_a_large_shape_is_what_single_solutions_give(large, inertia):
    made, modes, dofs = large
    scheme, free = Scheme(1e-3, 1.0, inertia), np.arange(len(modes.modes))
    compliance = Compliance(made, modes, free, scheme)
    block, some = compliance.block(dofs), [0, 7, 200, len(dofs) - 1]
    columns = compliance.apply(condense.units(dofs[some], len(modes.modes)).T)
    np.testing.assert_allclose(columns[:, dofs], block[some], atol=1e-11 * np.abs(block).max())
    # the equations themselves: M̂ x + M Φ λ = r, Φᵀ M x = 0
    c_m, c_k = coefficients(made, Scheme(1e-3, 1.0, inertia))
    left = c_m * (made.mass @ columns.T) + c_k * (made.stiffness @ columns.T)
    left -= condense.units(dofs[some], len(left))
    left -= modes.momentum @ (modes.modes.T @ left)
    assert np.abs(left).max() <= 1e-11
    size = np.abs(modes.momentum).sum(axis=0).max() * np.abs(columns).max()
    assert np.abs(modes.momentum.T @ columns.T).max() <= 1e-13 * size


def test_memory_of_a_large_shape(large, monkeypatch):
    """No array of unknowns × contacts, and none of unknowns², is held or even made on the way."""
    made, modes, dofs = large
    width, unknowns = 8, len(modes.modes)
    monkeypatch.setattr(condense, "AT_ONCE", 1)
    monkeypatch.setattr(condense, "FEWEST", width)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        compliance = Compliance(made, modes, np.arange(unknowns), Scheme(1.0, 1.0, 0.0))
        held = tracemalloc.get_traced_memory()[0] - before
        tracemalloc.reset_peak()
        block = compliance.block(dofs)
        peak = tracemalloc.get_traced_memory()[1] - before - held
    finally:
        tracemalloc.stop()
    assert held <= 8 * 60 * unknowns  # the modes, and what springs move
    most = 8 * 6 * width * unknowns + 3 * block.nbytes
    assert peak <= most < 8 * unknowns * len(dofs)


@pytest.mark.parametrize("clamp", ["free", "built in"])
def test_a_large_shape_leaves_its_matrices_on_disk(clamp, monkeypatch):
    """The factor needs the room; what comes of them is the same, bit by bit."""
    if petsc() is None:
        pytest.skip("PETSc without MUMPS")
    mine = assemble_shapes([MESH], [STONE], None)[0]
    free, modes = setting(mine, clamp)
    usual = Compliance(mine, modes, free, SCHEMES[2], dense=False).block(free[:30])
    before = mine.stiffness.toarray(), mine.mass.toarray()
    monkeypatch.setattr(condense, "LARGE", len(free))
    parked = Compliance(mine, modes, free, SCHEMES[2], dense=False).block(free[:30])
    assert np.array_equal(parked, usual)
    for matrix, dense in zip((mine.stiffness, mine.mass), before, strict=True):
        assert isinstance(matrix.data.base, np.memmap)
        assert np.array_equal(matrix.toarray(), dense)
