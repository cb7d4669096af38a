"""Input at the ends of what numbers can say: refused by name, with what to do, never a raw error."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import MasonryError
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene.specs import Contact, Material, MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.extremes.solids import lifted

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize("value", [NAN, INF, 0.0, -1.0])
@pytest.mark.parametrize(("place", "change"), [
    ("materials.stone.density", lambda v: {"materials": {"stone": Material(density=v, young=1e10)}}),
    ("materials.stone.young", lambda v: {"materials": {"stone": Material(density=1.0, young=v)}}),
    ("structures.cube.size.0", lambda v: {
        "structures": (BlockStructure(name="cube", material="stone", size=(v, 1.0)),)}),
    ("contact.reach", lambda v: {"contact": Contact(reach=v)}),
    ("mesh.size", lambda v: {"mesh": MeshSettings(size=v)}),
])  # fmt: skip
def test_numbers_that_are_none(place: str, change, value: float) -> None:
    with pytest.raises(MasonryError, match=f"{place} is {value}, expected a .* > 0 in "):
        solve_scene(lifted(0.0, fidelity="elastic", **change(value)))


@pytest.mark.parametrize("poisson", [NAN, -1.0, 0.5, 2.0])
def test_poisson_that_is_none(poisson: float) -> None:
    materials = {"stone": Material(density=1.0, young=1e10, poisson=poisson)}
    with pytest.raises(MasonryError, match=r"poisson is .*, expected a number > -1 and < 0.5"):
        solve_scene(lifted(0.0, fidelity="elastic", materials=materials))


@pytest.mark.slow
def test_poisson_a_rounding_below_a_half() -> None:
    materials = {"stone": Material(density=1.0, young=1e10, poisson=float(np.nextafter(0.5, 0.0)))}
    with pytest.raises(
        MasonryError, match=r"block 'cube': its stiffness is singular to rounding.*make the block rigid"
    ):
        solve_scene(lifted(0.0, fidelity="elastic", materials=materials))


@pytest.mark.parametrize(("mesh", "count"), [
    (MeshSettings(size=1e-9), "1.0e\\+18"), (MeshSettings(divisions=(10**9, 1)), "1.0e\\+09"),
])  # fmt: skip
def test_more_elements_than_memory(mesh: MeshSettings, count: str) -> None:
    with pytest.raises(MasonryError, match=f"shape 'cube' would have {count} elements, .* raise mesh.size"):
        solve_scene(lifted(0.0, fidelity="elastic", mesh=mesh))


@pytest.mark.parametrize("element", ["P1", "Q1"])
def test_more_elements_than_memory_where_gmsh_makes_them(element: str) -> None:
    pentagon = np.array([[0.0, 0.0], [1.0, 0.0], [1.2, 0.7], [0.5, 1.0], [-0.2, 0.6]])
    solid = Polytope(pentagon, tuple((k, (k + 1) % 5) for k in range(5)))
    with pytest.raises(MasonryError, match=r"shape 'stone' would have .* elements"):
        mesh_shape(Shape("stone", solid), MeshSettings(element=element, size=1e-8), 2)


@pytest.mark.parametrize("place", [1e13, 1e15, 1e17, 1e100])
def test_places_that_coordinates_cannot_draw(place: float) -> None:
    stack = StackStructure(name="cube", material="stone", size=(0.3, 0.3), count=2, position=(place, 0.0))
    with pytest.raises(
        MasonryError, match=r"from the origin, where coordinates are .* m apart; .* same offset"
    ):
        solve_scene(lifted(0.0, structures=(stack,), probes=()))


@pytest.mark.parametrize(("place", "told"), [(1e6, False), (1e9, True)])
def test_places_where_digits_are_lost(place: float, told: bool, caplog: pytest.LogCaptureFixture) -> None:
    """Coordinates of surveys (some 1e6 m) are good; farther off a warning says what to do."""
    stack = StackStructure(name="cube", material="stone", size=(0.3, 0.3), count=2, position=(place, 0.0))
    assert solve_scene(lifted(0.0, structures=(stack,), probes=())).outcome == "equilibrium"
    assert any("lose digits" in record.getMessage() for record in caplog.records) == told


@pytest.mark.parametrize("aspect", [1e12, 1e15])
def test_blocks_thinner_than_coordinates(aspect: float) -> None:
    stack = StackStructure(name="cube", material="stone", size=(1.0, 1.0 / aspect), count=1)
    with pytest.raises(MasonryError, match=r"m thin and stands .*or make the block thicker"):
        solve_scene(lifted(0.0, structures=(stack,), probes=()))


@pytest.mark.parametrize(("edge", "told"), [(1e-5, True), (1e-3, False), (1.0, False), (300.0, True)])
def test_sizes_that_no_stones_have_are_told(
    edge: float, told: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """They are computed all the same: mostly mm were taken for m."""
    assert solve_scene(lifted(0.0, edge=edge)).outcome == "equilibrium"
    assert any("taken for m" in record.getMessage() for record in caplog.records) == told
