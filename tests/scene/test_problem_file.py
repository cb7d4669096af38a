"""Problem files of COMPAS: their supports, friction and loads become those of the scene."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.limit.strength import strength_of
from masonry_fem.records.structure import ProblemFile, Structure
from masonry_fem.scene import check, specs
from masonry_fem.scene.problem_file import with_conditions
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures.file import FileStructure

STONE = {"stone": specs.Material(density=2000.0)}


def wrapped(kind: str, data: Any) -> dict[str, Any]:
    return {"dtype": f"compas_dem.{kind}", "data": data, "guid": "1"}


def problem(**conditions: Any) -> dict[str, Any]:
    """Three cubes one on another; the lowest is held, friction is .3."""
    cubes = [Polytope.box((0.0, 0.0, float(k)), (1.0, 1.0, k + 1.0)) for k in range(3)]
    elements = {
        f"guid{k}": wrapped("elements/Block", {"geometry": wrapped("Mesh", {
            "vertex": {str(i): dict(zip("xyz", p, strict=True))
                       for i, p in enumerate(cube.vertices.tolist())},
            "face": {str(i): list(loop) for i, loop in enumerate(cube.faces)},
        })})
        for k, cube in enumerate(cubes)
    }  # fmt: skip
    graph = {"node": {str(k): {"element": f"guid{k}"} for k in range(3)}, "edge": {}}
    fixed = {"block_index": 0, "translation": [0.0] * 3, "rotation": [0.0] * 3}
    told = {"gravity": False, "g": 9.81, "body_forces": [], "point_loads": [], "surface_loads": [],
            "displacements": [fixed]} | conditions  # fmt: skip
    return wrapped(
        "problem/Problem",
        {
            "model": wrapped("models/BlockModel", {"elements": elements, "graph": graph}),
            "boundary_conditions": wrapped("problem/BoundaryConditions", told),
            "contact_properties": wrapped(
                "interactions/ContactProperties",
                {"contact_model": wrapped("interactions/MohrCoulomb", {"phi": 16.7, "mu": 0.3, "k_n": 1e9})},
            ),
        },
    )


def scene(folder: Path, record: Any, keys: dict[str, Any] | None = None, **others: Any) -> specs.Scene:
    (folder / "p.json").write_text(json.dumps(record))
    file = FileStructure(name="p", material="stone", path="p.json", **keys or {})
    return specs.Scene(fidelity="rigid", materials=STONE, structures=(file,), **others)


def test_what_the_file_says_is_taken_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    found = check(scene(tmp_path, problem(gravity=True)), base=tmp_path)
    assert found.supports == (specs.Support(on="p.b0"),)
    assert found.joints == (specs.Joint(), specs.Joint(friction=0.3, between=("p", "p")))
    assert found.loads.gravity == (0.0, 0.0, -9.81)
    assert "1 supports, 0 forces, gravity 9.81 m/s², friction 0.3 are taken" in caplog.text
    assert "k_n = 1e+09 is passed over" in caplog.text
    assert check(found, base=tmp_path) == found


def test_weight_forces_and_pressures_are_carried(tmp_path: Path) -> None:
    """Two free cubes of 2 t; a force on the upper one, 1 kPa inwards on its top of 1 m², .1 m/s² along y."""
    top = {"dtype": "compas.geometry/Polygon", "data": {"points": [
        [0, 0, 3], {"dtype": "compas.geometry/Point", "data": [1, 0, 3]}, [1, 1, 3], [0, 1, 3]]}}  # fmt: skip
    record = problem(
        gravity=True,
        body_forces=[[0.0, 0.1, 0.0]],
        point_loads=[{"block_index": 2, "force": [50, 0, -5], "moment": None, "point": [0.5, 0.5, 2.5]}],
        surface_loads=[{"block_index": 2, "polygon": top, "magnitude": -1000.0, "direction": None}],
    )
    result = solve_scene(scene(tmp_path, record), base=tmp_path)
    assert result.outcome == "equilibrium"
    assert result.summary.applied == pytest.approx([50.0, 400.0, -2 * 2000 * 9.81 - 5.0 - 1000.0])
    support = result.summary.supports["p.b0"]
    assert support.force == pytest.approx([-50.0, -400.0, 40245.0], rel=1e-6)


def test_friction_of_the_file_holds(tmp_path: Path) -> None:
    """A push of .29 of the upper cube's weight is carried, one of .31 is not."""
    outcomes = []
    for share in (0.29, 0.31):
        push = {"block_index": 2, "force": [share * 2000 * 9.81, 0, 0], "point": [0.5, 0.5, 2.01]}
        record = problem(gravity=True, point_loads=[push])
        outcomes.append(solve_scene(scene(tmp_path, record), base=tmp_path).outcome)
    assert outcomes == ["equilibrium", "no_equilibrium"]


def test_what_the_scene_says_stands(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    own = {
        "joints": (specs.Joint(friction=0.7),),
        "loads": specs.Loads(gravity=(0.0, 0.0, -1.62)),
        "supports": (specs.Support(on="p.b0", motion=specs.Motion(displacement=(0.0, 0.0, -1e-3))),),
    }
    found = check(scene(tmp_path, problem(gravity=True), **own), base=tmp_path)
    assert (found.joints, found.loads) == (own["joints"], own["loads"])
    assert found.supports[-1] == own["supports"][0]  # the last motion of a block is the one that holds
    assert "gravity is that of the scene, friction is that of the scene's joints, not 0.3" in caplog.text


def test_blocks_alone(tmp_path: Path) -> None:
    given = scene(tmp_path, problem(), {"conditions": False})
    assert check(given, base=tmp_path) == given


class Heap(Structure, frozen=True, kw_only=True, tag="heap"):
    """A kind of one's own, with its blocks in one file and what holds them in another."""

    holds: str | None = "p.json"

    @property
    def problem(self) -> ProblemFile | None:
        return None if self.holds is None else ProblemFile(self.holds, 2.0)

    def blocks_alone(self) -> Heap:
        return replace(self, holds=None)


def test_any_structure_may_have_a_problem_file(tmp_path: Path) -> None:
    moved = {"block_index": 1, "translation": [0.0, 0.0, 0.1], "rotation": None}
    given = scene(tmp_path, problem(displacements=[moved]))
    heap = Heap(name="heap", material="stone")
    found = with_conditions(replace(given, structures=(heap,)), tmp_path)
    assert found.structures == (replace(heap, holds=None),)
    (support,) = found.supports
    assert support.on == "heap.b1"
    assert support.motion is not None
    assert support.motion.displacement == (0.0, 0.0, 0.2)
    assert with_conditions(found, tmp_path) == found


def test_moved_blocks_and_scaled_lengths(tmp_path: Path) -> None:
    moves = [
        {"block_index": 0, "translation": [0, 0, 5.0], "rotation": None},
        {"block_index": 0, "translation": None, "rotation": [0, 0.01, 0]},
    ]
    found = check(scene(tmp_path, problem(displacements=moves), {"scale": 1e-3}), base=tmp_path)
    motion = specs.Motion(displacement=(0.0, 0.0, 5e-3), rotation=(0.0, 0.01, 0.0))
    assert found.supports == (specs.Support(on="p.b0", motion=motion),)


@pytest.mark.parametrize(
    ("conditions", "said"),
    [
        ({"point_loads": [{"block_index": 2, "force": [1, 0, 0], "moment": [0, 1, 0]}]}, "has a moment"),
        ({"point_loads": [{"block_index": 2}]}, "cannot be read .KeyError: 'force'"),
        ({"point_loads": [{"block_index": 2, "force": [float("nan"), 0, 0]}]}, "points.0.vector.0 is nan"),
        ({"point_loads": [{"block_index": 9, "force": [1, 0, 0]}]}, "'p.b9' selects no block"),
        ({"displacements": 3}, "cannot be read .TypeError"),
        ({"surface_loads": [{"block_index": 1, "polygon": {"points": []}}]}, "cannot be read .IndexError"),
        (
            {"surface_loads": [{"block_index": 1, "polygon": {"points": [[0, 0, 3], [1, 0, 3], [2, 0, 3]]}}]},
            "3 corners without area",
        ),
        ({"point_loads": [{"block_index": 2, "force": [10**400, 0, 0]}]}, "cannot be read .OverflowError"),
        ({"displacements": [{"block_index": "*"}]}, "cannot be read .ValueError"),
        ({"body_forces": [[0, 1]]}, "scene with what its problem files say: loads.accelerations.0"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path: Path, conditions: dict[str, Any], said: str) -> None:
    with pytest.raises(MasonryError, match=said):
        solve_scene(scene(tmp_path, problem(**conditions)), base=tmp_path)


def test_barrel_of_compas_dem(shared_data: Path) -> None:
    """121 blocks, 26 of them held, μ .5, 80 156.4 N (its README)."""
    path = shared_data / "compas" / "dem_barrel_problem.json"
    file = FileStructure(name="v", material="stone", path=str(path))
    given = specs.Scene(
        fidelity="rigid", materials=STONE, structures=(file,), loads=specs.Loads(gravity=(0.0, 0.0, -9.81))
    )
    result = solve_scene(given)
    assert result.outcome == "equilibrium"
    assert result.summary.blocks == 121
    assert len(result.summary.supports) == 26
    assert result.summary.applied == pytest.approx([0.0, 0.0, -80156.4], abs=0.05)
    assert set(strength_of(result.built.model).friction.tolist()) == {0.5}


def test_a_file_that_is_no_json_is_told_by_its_reader(tmp_path: Path) -> None:
    given = scene(tmp_path, problem())
    (tmp_path / "p.json").write_text("{")
    with pytest.raises(MasonryError, match="is no JSON"):
        solve_scene(given, base=tmp_path)
    (tmp_path / "p.json").unlink()
    with pytest.raises(SceneError, match="expected an existing file"):
        check(given, base=tmp_path)


def two_problems(folder: Path, first: Any, second: Any, **others: Any) -> specs.Scene:
    one = scene(folder, first, **others)
    (folder / "q.json").write_text(json.dumps(second))
    file = FileStructure(name="q", material="stone", path="q.json")
    return replace(one, structures=(*one.structures, file))


def test_two_files_have_each_their_friction_and_load_everything_once(tmp_path: Path) -> None:
    first = problem(gravity=True, body_forces=[[0.0, 0.1, 0.0]])
    second = problem(gravity=True, body_forces=[[0.0, 0.1, 0.0]])
    second["data"]["contact_properties"]["data"]["contact_model"]["data"]["mu"] = 0.4
    pushed = specs.Loads(accelerations=(specs.Acceleration(vector=(1.0, 0.0, 0.0)),))
    found = check(two_problems(tmp_path, first, second, loads=pushed), base=tmp_path)
    assert [(one.friction, one.between) for one in found.joints[1:]] == [(0.3, ("p", "p")), (0.4, ("q", "q"))]
    assert [one.vector for one in found.loads.accelerations] == [(1.0, 0.0, 0.0), (0.0, 0.1, 0.0)]
    assert found.loads.gravity == (0.0, 0.0, -9.81)


@pytest.mark.parametrize(
    ("other", "word"),
    [({"gravity": True, "g": 1.6}, "gravity"), ({"body_forces": [[0, 1, 0]]}, "accelerations")],
)
def test_two_files_that_deny_each_other_are_refused(tmp_path: Path, other: Any, word: str) -> None:
    first = problem(gravity=True, body_forces=[[0.0, 0.1, 0.0]])
    with pytest.raises(SceneError, match=rf"q.json': its {word}"):
        check(two_problems(tmp_path, first, problem(**other)), base=tmp_path)


def test_a_plane_scene_is_told_that_its_file_needs_space(tmp_path: Path) -> None:
    plane = scene(tmp_path, problem(gravity=True), dimension=2)
    with pytest.raises(MasonryError, match="expected a scene with dimension = 3"):
        solve_scene(plane, base=tmp_path)
