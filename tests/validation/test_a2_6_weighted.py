"""A2.6 with weighted contacts: the patch test for any two meshes, with no more contacts than nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Override,
    Solver,
    Statics,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.patch import P, pair, pressed, worst_stress
from tests.validation.scenes import solved
from tests.validation.test_a2_6_patch import cube

EXACT = 1e-9  # of p
# Not the default: contacts that are nearly slivers make 1.1e-9 of p of an error of 3e-14, and of the balance
# of a stone that half bears on a floor 1e-11 of one of 1e-15.
TIGHT = Solver(tolerance=3e-14)


def assert_balanced(result: RunResult) -> None:
    """Contacts, loads and supports: force and moment of each block, and of all."""
    assert result.outcome == "equilibrium"
    measures = result.summary.certificate
    assert max(measures.block_balance, measures.global_balance) < 1e-12


@pytest.mark.parametrize("ratio", [(2, 3), (3, 4), (4, 6), pytest.param((8, 11), marks=pytest.mark.slow)])
@pytest.mark.parametrize("d", [2, 3])
def test_uniform_pressure(d: int, ratio: tuple[int, int]) -> None:
    """Two cubes, 14.6 % wrong with ``nodes`` in 3D; one contact for each node of the finer face."""
    result, error = pressed(d, *ratio, placement="weighted")
    assert error < EXACT
    assert_balanced(result)
    assert result.built.model.contacts.count == (max(ratio) + 1) ** (d - 1)
    assert result.summary.solver.linear_solves <= 6


@pytest.mark.parametrize("two", ["P1", "Q1", "P2", "Q2"])
@pytest.mark.parametrize("one", ["P1", "Q1", "P2", "Q2"])
@pytest.mark.parametrize("d", [2, 3])
def test_all_kinds_of_elements(d: int, one: str, two: str) -> None:
    result, error = pressed(d, 2, 3, "weighted", elements=(one, two))
    assert error < EXACT
    assert_balanced(result)


@pytest.mark.parametrize("cells", [(2, 4), (3, 1), (3, 3)])
@pytest.mark.parametrize(("one", "two"), [("P2", "P1"), ("Q1", "Q2"), ("P1", "Q2"), ("P1", "Q1")])
@pytest.mark.parametrize("d", [2, 3])
def test_vertices_that_are_among_the_others(d: int, one: str, two: str, cells: tuple[int, int]) -> None:
    """The default, with elements of two orders or kinds: ``nodes`` are up to 30 % wrong."""
    result, error = pressed(d, *cells, "auto", elements=(one, two))
    assert error < EXACT
    assert_balanced(result)


@pytest.mark.parametrize(
    ("one", "two"), [("skew", "skewer"), ("tetrahedra", "skew"), ("skewer", "tetrahedra")]
)
def test_edges_that_are_not_parallel(tmp_path: Path, one: str, two: str) -> None:
    files = []
    for z, (name, grid) in enumerate((("lower", one), ("upper", two))):
        element = "P1" if grid == "tetrahedra" else "Q1"
        mesh = MeshSettings(element=element, size=0.7 if element == "P1" else None)
        path = cube(tmp_path / f"{name}.geo", grid, float(z))
        files.append(FileStructure(name=name, material=name, path=str(path), trusted=True, mesh=mesh))
    result, error = pair(3, tuple(files), ("lower.stone", "upper.stone"), "weighted")
    assert error < EXACT
    assert_balanced(result)


AXIS = np.array([1.0, 2.0, -0.7])
TURN = Rotation.from_rotvec(np.radians(37.0) * AXIS / np.linalg.norm(AXIS)).as_matrix()


def turned(*vector: float) -> tuple[float, ...]:
    return tuple((TURN @ vector).tolist())


def box(name: str, size: tuple[float, ...], place: tuple[float, ...], **keys: Any) -> BlockStructure:
    """A box of the turned world."""
    return BlockStructure(
        name=name,
        material="stone",
        size=size,
        position=turned(*place),
        rotation=37.0,
        axis=tuple(AXIS),
        **keys,
    )


def error_of(result: RunResult, stress: np.ndarray) -> float:
    """Largest |σ − σ_exact| / p over all Gauss points; the exact one in the axes of the turned world."""
    exact = (TURN @ stress @ TURN.T)[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    fields = [
        group.stress(state)
        for group, state in zip(result.built.model.groups, result.march.state.bodies, strict=True)
    ]
    return max(float(np.abs(field.gauss - exact).max()) / P for field in fields if field is not None)


STONE = {"stone": Material(density=1000.0, young=1e10, poisson=0.2)}


@pytest.mark.parametrize(
    ("ratio", "elements", "cut"),
    [
        ((2, 3), ("Q1", "Q1"), True),
        ((2, 3), ("P1", "Q1"), True),
        ((2, 3), ("Q2", "P1"), True),
        ((2, 3), ("P2", "Q2"), True),
        ((3, 4), ("Q1", "Q1"), True),
        ((3, 4), ("Q1", "P2"), True),
        ((3, 4), ("P1", "Q1"), True),
        ((3, 4), ("Q1", "P1"), True),
        ((3, 4), ("P1", "Q2"), False),
        ((4, 6), ("Q1", "P1"), False),
        ((4, 6), ("Q2", "P2"), False),
        ((4, 6), ("Q1", "Q1"), True),
        ((4, 6), ("Q2", "P1"), True),
        ((4, 6), ("P1", "Q1"), True),
        ((4, 6), ("P1", "P1"), True),
        pytest.param((8, 11), ("P1", "Q1"), True, marks=pytest.mark.slow),
        ((8, 11), ("Q1", "Q1"), False),
        ((8, 11), ("P1", "P1"), False),
    ],
)
def test_under_an_oblique_load(ratio: tuple[int, int], elements: tuple[str, str], cut: bool) -> None:
    """Two blocks on three whose facets are covered in part, or one on one; turned by 37°, held by friction.

    The stress is uniform; bed joints bear τ = .1 p. The sides get the pressure ν p/(1 − ν) that keeps the
    stone from widening, so that it sticks to the floor; head joints bear it together with τ, which is less
    than μ times as much.
    """
    shear, side = 0.1 * P, 0.25 * P
    fewer, more = ratio
    courses: dict[str, tuple[float, list[tuple[float, float, int]]]] = {
        "low": (0.0, [(0.0, 0.31, fewer - 1), (0.31, 0.77, fewer), (0.77, 1.0, fewer)]),
        "top": (1.0, [(0.0, 0.58, more), (0.58, 1.0, more - 1)]),
    }
    if not cut:
        courses = {"low": (0.0, [(0.0, 1.0, fewer)]), "top": (1.0, [(0.0, 1.0, more)])}
    blocks, tractions = [box("floor", (1.4, 1.4, 0.5), (-0.2, -0.2, -0.5), support=True)], []
    for (row, (z, course)), element in zip(courses.items(), elements, strict=True):
        for i, (start, end, along) in enumerate(course):
            name = f"{row}{i}"
            mesh = MeshSettings(divisions=(along, along + i, 2), element=element)
            size = (end - start, 1.0, 1.0)
            blocks.append(box(name, size, (start, 0.0, z), mesh=mesh))
            tractions.append(Traction(on=f"{name}/front", vector=turned(0, side, 0)))
            tractions.append(Traction(on=f"{name}/back", vector=turned(0, -side, 0)))
        tractions.append(Traction(on=f"{row}0/left", vector=turned(side, 0, -shear)))
        tractions.append(Traction(on=f"{row}{len(course) - 1}/right", vector=turned(-side, 0, shear)))
        if row == "top":
            tractions += [Traction(on=f"top{i}/top", vector=turned(shear, 0, -P)) for i in range(len(course))]
    result = solved(
        materials=STONE,
        structures=tuple(blocks),
        loads=Loads(tractions=tuple(tractions)),
        joints=(Joint(friction=0.6, placement="weighted"),),
        contact=Contact(update="fixed"),  # the shear strain turns frames by 1e-5
        analysis=Statics(),
        solver=TIGHT if (ratio, elements) == ((2, 3), ("P1", "Q1")) else Solver(),
    )
    assert_balanced(result)
    assert error_of(result, np.array([[-side, 0, shear], [0, -side, 0], [shear, 0, -P]])) < EXACT


@pytest.mark.parametrize("cells", [(2, 3), (3, 4)])
def test_turned_on_a_rigid_floor(cells: tuple[int, int]) -> None:
    """Rigid on elastic on elastic: nothing but the floor holds the blocks, which may widen."""
    meshes = [MeshSettings(divisions=(n, n, n)) for n in cells]
    result = solved(
        materials=STONE,
        structures=(
            box("floor", (1.4, 1.4, 0.5), (-0.2, -0.2, -0.5), support=True),
            box("lower", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), mesh=meshes[0]),
            box("upper", (1.0, 1.0, 1.0), (0.0, 0.0, 1.0), mesh=meshes[1]),
        ),
        joints=(Joint(friction=0.0, placement="weighted"),),
        loads=Loads(tractions=(Traction(on="upper/top", vector=turned(0, 0, -P)),)),
        analysis=Statics(),
    )
    assert_balanced(result)
    assert worst_stress(result, TURN[:, 2]) < EXACT


def test_a_floor_that_bears_half_a_facet() -> None:
    """Two rigid floors meet under the middle of a facet: the elastic stone's weights are cut there."""
    floors = tuple(
        box(f"floor{i}", (width, 1.0, 0.5), (start, 0.0, -0.5), support=True)
        for i, (start, width) in enumerate(((0.0, 0.55), (0.55, 0.45)))
    )
    result = solved(
        materials=STONE,
        structures=(
            *floors,
            box("stone", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), mesh=MeshSettings(divisions=(3, 2, 2))),
        ),
        joints=(Joint(friction=0.0, placement="weighted"),),
        loads=Loads(tractions=(Traction(on="stone/top", vector=turned(0, 0, -P)),)),
        analysis=Statics(),
        solver=TIGHT,
    )
    assert_balanced(result)
    assert error_of(result, np.diag([0.0, 0.0, -P])) < EXACT


@pytest.mark.parametrize(
    ("courses", "divisions", "other"),
    [(6, (3, 2, 2), None), pytest.param(10, (4, 2, 2), (5, 3, 2), marks=pytest.mark.slow)],
)
def test_walls_take_few_linear_solves(
    courses: int, divisions: tuple[int, int, int], other: tuple[int, int, int] | None
) -> None:
    """Joints that end within facets, courses of other elements: over 200 with weights from outside."""
    wall = WallStructure(
        name="wall", material="stone", brick=(0.5, 0.25, 0.25), columns=courses, courses=courses
    )
    every_other = tuple(f"wall.c{course}.*" for course in range(2, courses + 1, 2))
    result = solved(
        fidelity="elastic",
        materials={"stone": Material(density=2400.0, young=1e10, poisson=0.2)},
        structures=(wall,),
        mesh=MeshSettings(divisions=divisions),
        overrides=tuple(
            Override(blocks=blocks, mesh=MeshSettings(divisions=other)) for blocks in every_other if other
        ),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.0, 0.0, -9.81)),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    assert result.built.model.contacts.means is not None
    assert result.summary.certificate.block_balance < 1e-9
    assert result.summary.solver.linear_solves <= 10
