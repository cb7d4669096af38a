"""Loads of a scene as forces on its blocks."""

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import (
    Joint,
    LineForce,
    Loads,
    Material,
    MeshSettings,
    Motion,
    PointForce,
    Scene,
    Support,
    Traction,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.stack import StackStructure


def stack(**keys: object) -> Scene:
    pile = StackStructure(name="st", material="stone", size=(1.0, 1.0), count=2)
    stone = {"stone": Material(density=2000.0)}
    return Scene(dimension=2, fidelity="rigid", materials=stone, structures=(pile,), **keys)


@pytest.mark.parametrize(
    ("key", "load"),
    [
        ("points", PointForce(block="st.*", vector=(0.0, -5.0))),
        ("lines", LineForce(block="st.b*", vector=(0.0, -5.0), start=(0.0, 1.0), end=(1.0, 1.0))),
    ],
)
def test_a_force_on_one_block_names_one(key, load):
    """What acts on a point of one block would else act as often as blocks match."""
    with pytest.raises(
        SceneError, match=rf"loads\.{key}\.0\.block = 'st\..*' selects 2 blocks \('st.b1', 'st.b2'\)"
    ):
        solve_scene(stack(loads=Loads(**{key: (load,)})))


def test_a_force_on_the_free_one_of_two():
    push = PointForce(block="st.[bg][2r]*", vector=(0.0, -5.0))  # st.b2 and the ground
    assert solve_scene(stack(loads=Loads(points=(push,)))).summary.applied == pytest.approx([0.0, -5.0])


def test_blocks_that_turn_together_share_a_pivot():
    turn = Support(on="st.b*", motion=Motion(rotation=0.01))
    gravity = Loads(gravity=(0.0, -9.81))
    with pytest.raises(SceneError, match=r"supports\.0\.motion turns 2 blocks .* pivot"):
        solve_scene(stack(supports=(turn,), loads=gravity))


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
    applied = solve_scene(scene).summary.applied
    assert applied == pytest.approx([0.0, -1e4 * np.pi * 2.25], rel=5e-3, abs=1.0)
