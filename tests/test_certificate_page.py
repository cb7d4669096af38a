"""The page "What the certificate promises": its forty lines find what the certificate says."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from masonry_fem.analyses.run import run
from masonry_fem.records.told import plain
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Output,
    Override,
    Scene,
    Statics,
    Support,
    Table,
    material_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

pytest.importorskip("pyvista")

SOFT = material_record("drucker_prager", cohesion=2e4, friction_angle=30.0)  # yields in arches that spread
STONE = {"stone": Material(density=2400.0, young=10e9, poisson=0.2, inelastic=SOFT)}
UPWARDS = {2: (0.0, -9.81), 3: (0.0, 0.0, -9.81)}
FIELDS = Output(pictures=False)

Check = Callable[[Path], dict[str, float]]


@pytest.fixture(scope="module")
def check(repository: Path) -> Check:
    """The function that the page gives to the sceptic."""
    text = (repository / "docs" / "certificate.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len([line for line in block.splitlines() if line.strip()]) <= 40
    names: dict[str, Any] = {}
    exec(compile(block, "docs/certificate.md", "exec"), names)
    found: Check = names["check"]
    return found


def both(check: Check, scene: Scene, out: Path) -> tuple[dict[str, float], dict[str, float], str]:
    """What the page's lines find, what the certificate says, and the outcome."""
    made = run(scene, out)
    told = made.summary.certificate.written
    return check(out), {name: part["value"] for name, part in plain(told).items()}, made.outcome


def arch(fidelity: str, dimension: int, steps: int, update: str = "moving") -> Scene:
    """An arch whose right springing moves away by 2 % of the radius."""
    away = Motion(displacement=(0.02, *(0.0,) * (dimension - 1)), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    deep = {"depth": 0.3} if dimension == 3 else {}
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials=STONE,
        structures=(
            ArchStructure(name="a", material="stone", radius=1.0, thickness=0.2, voussoirs=9, **deep),
        ),
        mesh=MeshSettings(divisions=(2,) * dimension),
        supports=(Support(on="a.springing_right", motion=away),),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=UPWARDS[dimension]),
        analysis=Statics(load_steps=steps),
        contact=Contact(update=update),
        output=FIELDS,
    )


@pytest.mark.parametrize(("fidelity", "dimension"), [("elastic", 2), ("elastic", 3), ("inelastic", 2)])
def test_stones_lose_by_not_turning_what_is_told(
    check: Check, dimension: int, fidelity: str, tmp_path: Path
) -> None:
    found, told, outcome = both(check, arch(fidelity, dimension, 2, "fixed"), tmp_path)
    assert outcome == "equilibrium"
    assert found["turning"] == pytest.approx(told["turning"], rel=1e-8)
    assert 0.01 < told["turning"] < 0.1
    assert max(found["balance"], told["balance"]) < 1e-8
    assert found["overlap"] < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["rigid", "elastic", "auto"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_stones_balance_where_they_are(check: Check, dimension: int, fidelity: str, tmp_path: Path) -> None:
    found, told, outcome = both(check, arch(fidelity, dimension, 1), tmp_path)
    assert outcome == "equilibrium"
    assert max(found["balance"], told["balance"]) < 1e-8
    assert told["turning"] == 0
    assert found["turning"] < 1e-8
    assert found["overlap"] < 1e-6


def test_steps_of_dynamics_leave_what_is_told(check: Check, tmp_path: Path) -> None:
    """A block that rocks: forces to rounding, moments to about the turn of a step."""
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials=STONE,
        structures=(StackStructure(name="s", material="stone", size=(0.3, 1.0), count=1),),
        joints=(Joint(friction=0.8),),
        loads=Loads(gravity=UPWARDS[2]),
        initial=(Initial(blocks="s.b1", spin=0.5),),
        analysis=Dynamics(step=5e-3, duration=0.1),
        output=FIELDS,
    )
    found, told, outcome = both(check, scene, tmp_path)
    assert outcome == "finished"
    assert found["balance"] == pytest.approx(told["balance"], rel=1e-6, abs=1e-12)


def test_a_block_that_nothing_touches(check: Check, tmp_path: Path) -> None:
    """It flies: there is no file of contact points, and nothing to fail for."""
    scene = Scene(
        dimension=3,
        fidelity="rigid",
        materials=STONE,
        structures=(BlockStructure(name="b", material="stone", size=(1.0, 1.0, 1.0)),),
        loads=Loads(gravity=UPWARDS[3]),
        analysis=Dynamics(step=1e-2, duration=0.05),
        output=FIELDS,
    )
    found, told, outcome = both(check, scene, tmp_path)
    assert outcome == "finished"
    assert not list(tmp_path.glob("fields/contacts_*"))
    assert found["balance"] == pytest.approx(told["balance"], abs=1e-12)
    assert found["balance"] < 1e-12


@pytest.mark.slow
def test_a_wall_of_rigid_and_elastic_stones_with_a_clamp(check: Check, tmp_path: Path) -> None:
    wall = WallStructure(name="w", material="stone", brick=(0.5, 0.25, 0.25), courses=3, columns=3)
    scene = Scene(
        dimension=3,
        materials=STONE,
        structures=(wall,),
        overrides=(Override(blocks="w.c2.*", fidelity="rigid"),),
        mesh=MeshSettings(divisions=(2, 1, 1)),
        supports=(Support(on="w.c1.b1/bottom"),),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.5, 0.3, -9.81)),
        analysis=Statics(),
        output=FIELDS,
    )
    found, told, outcome = both(check, scene, tmp_path)
    assert outcome == "equilibrium"
    assert max(found["balance"], told["balance"]) < 1e-8
    assert found["turning"] == pytest.approx(told["turning"], rel=1e-4, abs=1e-10)


@pytest.fixture
def overlapping() -> Scene:
    """A cantilever that sags onto a block below, where contacts are fixed as those of the start: none."""
    return Scene(
        dimension=2,
        materials={"soft": Material(density=2400.0, young=1e9, poisson=0.2)},
        structures=(
            BlockStructure(name="arm", material="soft", size=(2.0, 0.2)),
            BlockStructure(
                name="below", material="soft", size=(0.5, 0.5), position=(1.5, -0.503), support=True
            ),
            BlockStructure(name="top", material="soft", size=(0.2, 0.1), position=(0.1, 0.2)),
        ),
        overrides=(Override(blocks="[bt]*", fidelity="rigid"),),
        mesh=MeshSettings(element="Q2", divisions=(10, 2)),
        supports=(Support(on="arm/left"),),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=UPWARDS[2]),
        contact=Contact(update="fixed", reach=1e-3),
        analysis=Statics(),
        output=FIELDS,
    )


def test_overlaps_are_seen_by_both(check: Check, overlapping: Scene, tmp_path: Path) -> None:
    found, told, outcome = both(check, overlapping, tmp_path)
    assert outcome == "no_convergence"
    assert 0.008 < told["overlap"] < 0.012
    assert found["overlap"] == pytest.approx(told["overlap"], rel=0.02)


def test_a_reaction_that_is_not_what_it_was_is_found_out(check: Check, tmp_path: Path) -> None:
    """The lines of the page see a hundredth of a load that is written wrong."""
    scene = arch("rigid", 2, 1)
    run(scene, tmp_path / "true")
    shutil.copytree(tmp_path / "true", tmp_path / "false")
    (table,) = (tmp_path / "false" / "fields").glob("acting_*.csv")
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    column = head.split(",").index("load_fy")
    cells = rows[-1].split(",")
    cells[column] = repr(1.01 * float(cells[column]))
    table.write_text("\n".join([head, *rows[:-1], ",".join(cells)]), encoding="utf-8")
    assert check(tmp_path / "true")["balance"] < 1e-8
    assert 0.009 < check(tmp_path / "false")["balance"] < 0.1  # a force, and the moment of its wrong arm
