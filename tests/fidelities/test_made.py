"""What a fidelity makes is looked at before it is computed with."""

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.errors import ExtensionError
from masonry_fem.fidelities import fidelity
from masonry_fem.scene.specs import Loads, Material, Scene
from masonry_fem.structures.stack import StackStructure


@pytest.fixture
def scene():
    fidelity("rigid")  # it is found, with its name, before a test takes something away
    stack = StackStructure(name="s", material="m", size=(1.0, 1.0), count=1)
    return Scene(
        dimension=2, fidelity="rigid", materials={"m": Material(density=2000.0)}, structures=(stack,),
        loads=Loads(gravity=(0.0, -10.0)),
    )  # fmt: skip


def test_a_group_of_another_kind_is_refused(scene, monkeypatch):
    monkeypatch.setattr(RigidGroup, "kind", "stiff")
    with pytest.raises(
        ExtensionError, match=r"'rigid' makes a RigidGroup whose kind is 'stiff', expected 'rigid'"
    ):
        solve_scene(scene)


def test_a_group_that_lacks_something_is_refused(scene, monkeypatch):
    monkeypatch.delattr(RigidGroup, "advance")
    monkeypatch.delattr(RigidGroup, "kind")
    with pytest.raises(
        ExtensionError, match=r"'rigid' makes a RigidGroup that lacks advance, kind, expected all"
    ):
        solve_scene(scene)
