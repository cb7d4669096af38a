"""Bonded patch: infinitely strong joints between elastic blocks leave a uniform pull uniform."""

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import check, specs
from masonry_fem.scene import laws as records
from masonry_fem.structures.block import BlockStructure

PULL, YOUNG, HEIGHT = 2e5, 1e10, 0.4
STIFFNESS = {"normal_stiffness": 1e18, "tangential_stiffness": 1e18}
WHOLE = STIFFNESS | {"normal_strength": 1e12, "tangential_strength": 1e12,
                     "normal_energy": 1e12, "tangential_energy": 1e12}  # fmt: skip
BONDED = {
    "constant_threshold": specs.law_record("constant_threshold", strength=1e9),
    "mohr_coulomb": specs.law_record("mohr_coulomb", cohesion=1e9),
    "elastic": specs.law_record("elastic", **STIFFNESS),
    "elastic_brittle": specs.law_record(
        "elastic_brittle", **STIFFNESS, normal_strength=1e12, tangential_strength=1e12
    ),
    "fremond_cangemi": specs.law_record("fremond_cangemi", **STIFFNESS, energy=1e12),
    "monerie_acary": records.law_record("monerie_acary", **WHOLE),
    "bilinear": specs.law_record("bilinear", **WHOLE),
    "exponential": records.law_record("exponential", **WHOLE),
    "trapezoidal": records.law_record("trapezoidal", **WHOLE),
}


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", BONDED)
def test_a_uniform_pull_stays_uniform(kind, dimension):
    """Two blocks hang on their joint; Poisson's ratio narrows them as it does a bar of one piece."""
    plane = dimension - 1
    blocks = tuple(
        BlockStructure(
            name=name,
            material="stone",
            size=(0.3,) * plane + (HEIGHT,),
            position=(0.0,) * plane + (i * HEIGHT,),
            mesh=specs.MeshSettings(divisions=(2,) * plane + (1 + i,)),
        )
        for i, name in enumerate(("low", "high"))
    )
    faces = ("left", "front", "bottom") if dimension == 3 else ("left", "bottom")
    scene = specs.Scene(
        dimension=dimension,
        plane="stress",
        materials={"stone": specs.Material(density=2000.0, young=YOUNG, poisson=0.25)},
        structures=blocks,
        joints=(specs.Joint(law=BONDED[kind]),),
        supports=tuple(
            specs.Support(on=f"{'low' if face == 'bottom' else '*'}/{face}", components=(axis,))
            for face, axis in zip(faces, "xyz" if dimension == 3 else "xy", strict=True)
        ),
        loads=specs.Loads(tractions=(specs.Traction(on="high/top", vector=(0.0,) * plane + (PULL,)),)),
        probes=(specs.Probe(name="top", block="high", point=(0.3,) * plane + (2 * HEIGHT,)),),
        analysis=specs.Statics(),
    )
    result = solve_scene(check(scene))
    assert result.outcome == "equilibrium"
    moved = result.march.report.probes["top"]
    expected = np.array([-0.25 * 0.3] * plane + [2 * HEIGHT]) * PULL / YOUNG
    np.testing.assert_allclose(moved[:dimension], expected, rtol=1e-7)
    points = result.march.state.reaction
    shares = result.built.model.contacts.area / result.built.model.contacts.area.sum()
    np.testing.assert_allclose(points[:, 0], -PULL * 0.3**plane * shares, rtol=1e-6)
    assert np.abs(points[:, 1:]).max() < 1e-6 * PULL
