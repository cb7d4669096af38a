"""Arch bridges: fill that stands on the barrel node on node, its weight, its thrust on the ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Override,
    Scene,
    Solver,
    Statics,
    Support,
    Traction,
    material_record,
)
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch_bridge import ArchBridgeStructure
from tests.meshing.test_meshing import check as check_mesh

G = 9.81
BRICK = Material(density=1900.0, young=5e9)
STRIP = (-1.7, -1.3)


def spec(**keys) -> ArchBridgeStructure:
    given = {"span": 6.0, "rise": 1.5, "thickness": 0.3, "voussoirs": 20, "cover": 0.2, "depth": 3.0}
    return ArchBridgeStructure(**({"name": "bridge", "material": "brick"} | given | keys))


def bridge(dimension: int = 2, **keys) -> Assembly:
    return build_structure(spec(**keys), dimension, Path(), MeshSettings())


def solve(structure: ArchBridgeStructure, soil: Material, mesh: MeshSettings, loads=(), dimension=2):
    """Rigid stones under fill between smooth walls."""
    walls = {"left": "x", "right": "x"} | ({"front": "y", "back": "y"} if dimension == 3 else {})
    scene = Scene(
        dimension=dimension,
        fidelity="rigid",
        materials={"brick": BRICK, "soil": soil},
        structures=(structure,),
        overrides=(Override(blocks="bridge.fill", material="soil", fidelity="inelastic", mesh=mesh),),
        supports=tuple(Support(on=f"bridge.fill/{face}", components=(axis,)) for face, axis in walls.items()),
        joints=(Joint(friction=0.7),),
        loads=Loads(gravity=(*(0.0,) * (dimension - 1), -G), tractions=loads),
        analysis=Statics(),
        solver=Solver(tolerance=1e-8),
    )
    result = solve_scene(check(scene))
    assert result.outcome == "equilibrium", result.march.message
    return result


def soil(poisson: float, cohesion: float = 2e3) -> Material:
    law = material_record("mohr_coulomb", cohesion=cohesion, friction_angle=35.0, dilatancy_angle=5.0)
    return Material(density=2000.0, young=50e6, poisson=poisson, inelastic=law)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_fill_reaches_from_the_barrel_to_the_road(dimension: int) -> None:
    made, keys = bridge(dimension), spec()
    assert overlapping(made) == []
    *_, fill = (made.solid(number) for number in range(len(made.blocks)))
    radius = keys.radius + keys.thickness / 2
    outer = radius * np.sin(keys.half)
    road, level = keys.rise + keys.thickness + keys.cover, radius * np.cos(keys.half)
    barrel = 20 * radius**2 * np.sin(2 * keys.half / 20) / 2 - outer * level  # chords over the springings
    base = keys.rise + keys.thickness - radius + level
    area = 2 * keys.ends * (road - base) - barrel
    assert fill.mass_properties().volume == pytest.approx(area * (3.0 if dimension == 3 else 1.0), rel=1e-12)
    low, high = fill.vertices.min(axis=0), fill.vertices.max(axis=0)
    assert (low[0], high[0], low[-1], high[-1]) == pytest.approx((-outer - 3, outer + 3, base, road))


@pytest.mark.parametrize("dimension", [2, 3])
def test_each_voussoir_carries_one_facet_of_the_fill(dimension: int) -> None:
    made = bridge(dimension)
    interfaces = [one for one in detect(made) if one.label == "fill"]
    names = [{made.blocks[block].name for block in one.blocks} - {"bridge.fill"} for one in interfaces]
    stones = [name for (name,) in names if ".v" in name]
    assert sorted(stones) == sorted(block.name for block in made.blocks if ".v" in block.name)
    assert max(np.abs(one.gap).max() for one in interfaces) < 1e-12
    fill = made.shapes[-1].solid
    faces = [face for face, name in enumerate(fill.names) if name == "base"]
    area = sum(float(np.linalg.norm(fill.area_vector(face))) for face in faces)
    assert sum(one.area for one in interfaces) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_nodes_of_the_fill_stand_at_the_joints_of_the_barrel(dimension: int) -> None:
    made = bridge(dimension)
    mesh = mesh_shape(made.shapes[-1], MeshSettings(divisions=(1, 2, 3)[3 - dimension :]), dimension)
    check_mesh(mesh, made.shapes[-1].solid)
    tops = [made.solid(number) for number, block in enumerate(made.blocks) if ".v" in block.name]
    joints = np.concatenate([one.face_points(one.names.index("extrados")) for one in tops])
    away = np.abs(joints[:, None] - mesh.points[None]).max(axis=2).min(axis=1)
    assert away.max() < 1e-12


def test_a_strip_is_as_long_as_it_is_said_to_be() -> None:
    fill = bridge(strip=STRIP).shapes[-1].solid
    loaded = np.concatenate(
        [fill.face_points(face) for face, name in enumerate(fill.names) if name == "strip"]
    )
    assert (loaded[:, 0].min(), loaded[:, 0].max()) == pytest.approx(STRIP)
    assert "strip" not in bridge().shapes[-1].solid.names


def test_impossible_bridges_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"strip is \[-0.05, 0.05\] m, narrower than the fill"):
        bridge(strip=(-0.05, 0.05))
    scene = {"dimension": 2, "fidelity": "rigid", "materials": {"brick": BRICK}, "analysis": Statics()}
    for keys, expected in (
        ({"rise": 3.1}, "half the span"),
        ({"strip": (-9.0, 1.0)}, "on the road from -6.24"),
    ):
        with pytest.raises(SceneError, match=expected):
            check(Scene(**scene, structures=(spec(**keys),)))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bridge_carries_its_weight_and_a_load_on_the_strip_evenly(dimension: int) -> None:
    """Symmetric: load in the middle of the road."""
    structure = spec(strip=(-0.4, 0.4), approach=1.5, voussoirs=16)
    pressure = Traction(on="bridge.fill/strip", vector=(*(0.0,) * (dimension - 1), -20e3))
    mesh = MeshSettings(element="Q1", divisions=(1, 2, 3)[3 - dimension :])
    result = solve(structure, soil(0.3), mesh, (pressure,), dimension)
    made = build_structure(structure, dimension, Path(), MeshSettings())
    *stones, fill = (
        made.solid(number).mass_properties().volume
        for number, block in enumerate(made.blocks)
        if not block.support
    )
    strip = 0.8 * (structure.depth if dimension == 3 else 1.0)
    weight = G * (BRICK.density * sum(stones) + 2000.0 * fill) + 20e3 * strip
    given = result.summary.supports
    left, right = (np.array(given[f"bridge.abutment_{end}"].force) for end in ("left", "right"))
    ends = [given[f"bridge.fill/{end}"].force[0] for end in ("left", "right")]
    assert left[-1] + right[-1] == pytest.approx(weight, rel=1e-8)
    assert left[[0, -1]] == pytest.approx(right[[0, -1]] * [-1, 1], rel=1e-5)
    assert ends[0] == pytest.approx(-ends[1], rel=1e-5)
    assert left[0] + right[0] + sum(ends) == pytest.approx(0.0, abs=1e-6 * weight)


@pytest.mark.parametrize(("poisson", "at_rest"), [(0.35, True), (0.05, False)])
def test_the_ends_get_the_pressure_of_earth_at_rest_or_active(poisson: float, at_rest: bool) -> None:
    """Far from the barrel ε_x = 0: K₀ = ν/(1 − ν). Where Rankine's K_a is more, soil yields to that."""
    structure = spec(span=2.0, rise=0.2, cover=0.5, voussoirs=8, approach=2.5)
    result = solve(structure, soil(poisson, cohesion=200.0), MeshSettings(element="Q2", divisions=(1, 4)))
    height = 0.5 + (structure.radius + 0.15) * (1 - np.cos(structure.half))
    vertical = 2000.0 * G * height
    active = np.tan(np.pi / 4 - np.radians(35.0) / 2) ** 2
    if at_rest:
        expected = poisson / (1 - poisson) * vertical * height / 2
    else:
        expected = active * vertical * height / 2 - 2 * 200.0 * np.sqrt(active) * height
    force = result.summary.supports["bridge.fill/left"].force[0]
    assert force == pytest.approx(expected, rel=0.01)
