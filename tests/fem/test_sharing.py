"""Sharing: blocks of one shape and material share mesh, matrices and factors."""

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.fem import deformable
from masonry_fem.scene.specs import Loads, Material, MeshSettings, Scene
from masonry_fem.structures.wall import WallStructure


@pytest.fixture
def factored(monkeypatch):
    """Operators of every factor made, in order."""
    made, compliance = [], deformable.Compliance

    def counted(operators, *rest, **known):
        made.append(operators)
        return compliance(operators, *rest, **known)

    monkeypatch.setattr(deformable, "Compliance", counted)
    return made


@pytest.mark.parametrize("count", [2, 4])
def test_a_wall_has_two_shapes_and_two_factors(count, factored):
    wall = WallStructure(name="wall", material="stone", brick=(0.4, 0.2, 0.2), columns=count, courses=count)
    result = solve_scene(
        Scene(
            materials={"stone": Material(density=2400.0, young=10e9)},
            structures=(wall,),
            mesh=MeshSettings(divisions=(2, 1, 1)),
            loads=Loads(gravity=(0.0, 0.0, -9.81)),
        )
    )
    assert result.outcome == "equilibrium"
    elastic_shapes = {
        stone.shape
        for stone, role in zip(result.built.model.assembly.blocks, result.built.stones.fidelity, strict=True)
        if role == "elastic"
    }
    assert len(elastic_shapes) == 2
    assert len({id(operators) for operators in factored}) == len(factored) == 2
