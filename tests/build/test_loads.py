"""Loads of a scene as forces on its blocks."""

import numpy as np
import pytest

from masonry_fem.run import solve_scene
from masonry_fem.scene.specs import (
    ArchStructure,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Scene,
    Traction,
)


@pytest.mark.parametrize("divisions", [(1, 2), (2, 2), (6, 2), (40, 2)])
def test_traction_on_a_curved_side_whatever_the_elements(divisions):
    """The extrados of a voussoir is many small faces, of which coarse elements skip some."""
    arch = ArchStructure(name="arch", material="stone", radius=2.0, thickness=0.5, voussoirs=11)
    scene = Scene(
        dimension=2,
        materials={"stone": Material(density=2400.0, young=10e9)},
        structures=(arch,),
        mesh=MeshSettings(divisions=divisions),
        joints=(Joint(friction=0.7),),
        loads=Loads(tractions=(Traction(on="arch.v*/extrados", vector=(0.0, -1e4)),)),
    )
    applied = solve_scene(scene).summary["applied"]
    assert applied == pytest.approx([0.0, -1e4 * np.pi * 2.25], rel=5e-3, abs=1.0)
