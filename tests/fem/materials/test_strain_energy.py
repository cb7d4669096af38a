"""Laws that are an energy in UFL: docs/add_a_material.md, closed forms, and what is no energy."""

import re
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import ufl

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import LawError
from masonry_fem.fem.material_conformance import violations
from masonry_fem.fem.material_law import Isotropic
from masonry_fem.fem.strain_energy import StrainEnergy
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import Material, MeshSettings, Motion, PythonMaterial, Scene, Statics, Support
from masonry_fem.structures.block import BlockStructure
from tests.fem.materials.strain_paths import SIZE, STONE


def linear(strain, elastic):
    deviator = ufl.dev(strain)
    return elastic.bulk / 2 * ufl.tr(strain) ** 2 + elastic.shear * ufl.inner(deviator, deviator)


@dataclass(frozen=True)
class Hooke(StrainEnergy):
    name: ClassVar[str] = "hooke"

    def energy(self, strain, elastic):
        return linear(strain, elastic)


@dataclass(frozen=True)
class Mixed(StrainEnergy):
    """All that an energy may be made of."""

    share: float
    name: ClassVar[str] = "mixed"

    def energy(self, strain, elastic):
        trace = ufl.tr(strain)
        opened = ufl.conditional(ufl.gt(trace, 0), ufl.exp(100 * trace) - 1 - 100 * trace, 0)
        bent = ufl.sqrt(1 + 1e4 * ufl.inner(strain, strain)) - 1 - 5e3 * ufl.inner(strain, strain)
        shear = ufl.cos(100 * strain[0, 1]) - 1 + 5e3 * strain[0, 1] ** 2
        other = 1e3 * abs(ufl.det(strain)) + ufl.max_value(-trace, 0) ** 3
        return linear(strain, elastic) + self.share * (opened + bent + shear + other)


@pytest.fixture(name="stiffening")
def _stiffening(repository):
    """The class of the page."""
    page = (repository / "docs/add_a_material.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"`[\w/]*stiffening\.py`:\n\n```python\n(.*?)```", page, re.S)
    names = {"__name__": "stiffening"}
    exec(compile(block, "stiffening.py", "exec", dont_inherit=True), names)
    return names["Stiffening"](closing=1e-3, growth=5e12)


def test_the_energy_of_linear_elasticity_is_that():
    strain = 1e-3 * np.random.default_rng(0).normal(size=(50, 6))
    made = Hooke().update(STONE, np.zeros_like(strain), strain, np.zeros((50, 0)), SIZE)
    np.testing.assert_allclose(made.stress, strain @ STONE.matrix, rtol=1e-12, atol=1e-4)
    np.testing.assert_allclose(made.stored, 0.5 * (made.stress * strain).sum(axis=1), rtol=1e-12)
    assert not made.changed.any()


def test_the_law_of_the_page_conforms_and_stiffens_under_pressure(stiffening):
    assert violations(stiffening, strain=1e-3) == []
    pressed = np.array([[-1e-3, -1e-3, -1e-3, 0, 0, 0], [1e-3, 1e-3, 1e-3, 0, 0, 0]])
    made = stiffening.update(STONE, np.zeros((2, 6)), pressed, np.zeros((2, 0)), SIZE)
    linear_part = 3 * STONE.bulk * 1e-3
    np.testing.assert_allclose(made.stress[:, 0], [-linear_part - 5e12 * 4e-6, linear_part], rtol=1e-12)
    assert made.changed.tolist() == [True, False]


def test_derivatives_of_everything_are_those_of_differences():
    law, start = Mixed(1e6), np.zeros((80, 6))
    strain, h = 3e-3 * np.random.default_rng(1).normal(size=(80, 6)), 1e-7
    inner = np.zeros((80, 0))
    made = law.update(STONE, start, strain, inner, SIZE)
    ends = [
        [law.update(STONE, start, strain + side * h * unit, inner, SIZE) for side in (1, -1)]
        for unit in np.eye(6)
    ]
    stress = np.stack([(up.stored - down.stored) / (2 * h) for up, down in ends], axis=1)
    tangent = np.stack([(up.stress - down.stress) / (2 * h) for up, down in ends], axis=2)
    np.testing.assert_allclose(made.stress, stress, atol=1e-6 * np.abs(stress).max())
    np.testing.assert_allclose(made.tangent, tangent, atol=1e-6 * STONE.matrix.max())
    np.testing.assert_array_equal(made.tangent, made.tangent.transpose(0, 2, 1))


@dataclass(frozen=True)
class Wrong(StrainEnergy):
    kind: str
    name: ClassVar[str] = "wrong"

    def energy(self, strain, elastic):
        return strain if self.kind == "tensor" else ufl.erf(strain[0, 0])


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("tensor", r"the shape \(3, 3\), expected a scalar"),
        ("erf", r"its energy has a Erf of UFL, expected sums"),
    ],
)
def test_what_is_no_energy_is_refused(kind, message):
    with pytest.raises(LawError, match=message):
        Wrong(kind).update(STONE, np.zeros((1, 6)), np.ones((1, 6)), np.zeros((1, 0)), SIZE)


def test_a_scene_has_the_energy_beside_it(repository, tmp_path):
    """A block between platens whose volume goes down by 4 ‰: σ_zz = −(λ + 2 μ) e − growth (e − closing)²."""
    page = (repository / "docs/add_a_material.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"`[\w/]*stiffening\.py`:\n\n```python\n(.*?)```", page, re.S)
    (tmp_path / "stiffening.py").write_text(block, encoding="utf-8")
    law = {"file": "stiffening.py", "name": "Stiffening", "trusted": True}
    stone = Material(
        density=2000.0,
        young=1e9,
        poisson=0.2,
        inelastic=PythonMaterial(**law, parameters={"closing": 1e-3, "growth": 1e12}),
    )
    mesh = MeshSettings(divisions=(1, 1))
    sides = [Support(on=f"b/{face}", components=("x",)) for face in ("left", "right")]
    down = Motion(displacement=(0.0, -4e-3))
    scene = Scene(
        dimension=2,
        fidelity="inelastic",
        materials={"m": stone},
        structures=(BlockStructure(name="b", material="m", size=(1.0, 1.0), mesh=mesh),),
        supports=(
            *sides,
            Support(on="b/bottom", components=("y",)),
            Support(on="b/top", components=("y",), motion=down),
        ),
        analysis=Statics(load_steps=2),
    )
    result = solve_scene(check(scene, base=tmp_path), tmp_path)
    elastic = Isotropic.of(1e9, 0.2)
    expected = (elastic.bulk + 4 / 3 * elastic.shear) * 4e-3 + 1e12 * 3e-3**2
    assert result.outcome == "equilibrium"
    assert result.march.report.support_resultants["b/top"][1] == pytest.approx(-expected, rel=1e-9)
    assert result.march.ledger.material_dissipation == 0.0
    assert result.march.ledger.imbalance <= 1e-9
    assert result.summary.stress.yielded is None
