"""Bodies are called what their fidelity is."""

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.errors import ExtensionError
from masonry_fem.scene.specs import Loads, Material, Scene
from masonry_fem.structures.stack import StackStructure


def test_a_group_of_another_kind_is_refused(monkeypatch):
    stack = StackStructure(name="s", material="m", size=(1.0, 1.0), count=1)
    scene = Scene(
        dimension=2, fidelity="rigid", materials={"m": Material(density=2000.0)}, structures=(stack,),
        loads=Loads(gravity=(0.0, -10.0)),
    )  # fmt: skip
    monkeypatch.setattr(RigidGroup, "kind", "stiff")
    with pytest.raises(
        ExtensionError, match=r"'rigid' makes a RigidGroup whose kind is 'stiff', expected 'rigid'"
    ):
        solve_scene(scene)
