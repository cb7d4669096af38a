"""Determinacy of a run: what stands in the summary and the table, and which reactions are written."""

import csv
import json

import numpy as np
import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Output, Scene, Statics
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.stack import StackStructure

STONE = {"stone": Material(density=2000.0, young=1e9)}


def scene(structure, **keys):
    given = {
        "dimension": 2,
        "fidelity": "rigid",
        "materials": STONE,
        "structures": (structure,),
        "joints": (Joint(friction=0.8),),
        "loads": Loads(gravity=(0.0,) * (keys.get("dimension", 2) - 1) + (-10.0,)),
        "analysis": Statics(),
        "output": Output(pictures=False, determinacy=True),
    } | keys
    return Scene(**given)


def pile(dimension):
    size = (1.0,) * dimension
    return scene(StackStructure(name="pile", material="stone", size=size, count=3), dimension=dimension)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_stack_is_determined_joint_by_joint(tmp_path, dimension):
    result = run(pile(dimension), tmp_path)
    told = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["determinacy"]
    assert told["reactions"] == "least norm"
    assert (told["interfaces_determined"], told["interfaces_not_determined"]) == (3, 0)
    assert told["not_determined"] == []
    assert told["supports_not_determined"] == {}
    assert told["contacts_not_unique"] == 3 * 2 ** (dimension - 1)
    assert told["error"] < 1e-9
    assert tmp_path / "determinacy.csv" in result.files
    with (tmp_path / "determinacy.csv").open() as file:
        rows = list(csv.DictReader(file))
    weights = sorted(float(row["normal"]) for row in rows)
    np.testing.assert_allclose(weights, [20e3, 40e3, 60e3], rtol=1e-7)
    assert {row["normal_determined"] for row in rows} == {"1"}
    assert result.summary.supports["pile.ground"].force[-1] == pytest.approx(60e3)


def test_an_arch_tells_that_its_thrust_is_a_choice(tmp_path):
    """A thick arch of rigid voussoirs: a whole interval of thrusts carries it (A3.3)."""
    arch = ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.2, voussoirs=11)
    result = run(scene(arch), tmp_path)
    told = result.summary.determinacy
    assert told.interfaces_not_determined == 12
    left = told.supports_not_determined["arch.springing_left"]
    assert "fx" in left
    assert "fy" in left  # one springing may carry more than the other
    thrust = abs(result.summary.supports["arch.springing_left"].force[0]) / (2000 * 10)
    assert 0.094247 <= thrust <= 0.160027


def test_fields_hold_the_reactions_of_least_norm(tmp_path):
    plain = solve_scene(pile(2))
    result = run(pile(2), tmp_path)
    assert len(list((tmp_path / "fields").glob("contacts_*.vtu"))) >= 1
    assert len((tmp_path / "history.csv").read_text().splitlines()) == 2
    assert plain.summary.determinacy == result.summary.determinacy


def test_elastic_blocks_and_clamps_are_determined(tmp_path):
    pair = StackStructure(name="pair", material="stone", size=(1.0, 1.0), count=2)
    built = scene(pair, fidelity="elastic", mesh=MeshSettings(element="Q1", divisions=(2, 2)))
    told = run(built, tmp_path).summary.determinacy
    assert told.interfaces_not_determined == 0
    assert told.contacts_not_unique == 0


def test_without_asking_nothing_is_told(tmp_path):
    result = run(
        scene(
            StackStructure(name="a", material="stone", size=(1.0, 1.0), count=1),
            output=Output(pictures=False),
        ),
        tmp_path,
    )
    assert result.summary.determinacy is None
    assert not (tmp_path / "determinacy.csv").exists()
