"""Apart: what damaged files do to their readers ends in one sentence, and nothing of it is left behind."""

from __future__ import annotations

import logging
import math
import os
import re
import signal
import tempfile
import time
from pathlib import Path

import gmsh
import psutil
import pytest

from masonry_fem import cli
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.importing.apart import Errand, done_apart
from masonry_fem.records.remark import gathered
from masonry_fem.scene import check, load
from masonry_fem.scene.quantity import si_value
from masonry_fem.scene.specs import MeshSettings, Reading, Scene
from masonry_fem.structures import build_structure, build_structures
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.survey import SurveyStructure
from tests.importing.test_trust import SCENE

PATIENT = Reading(time=120.0)
ENDLESS = "For i In {1:1e12}\n  a = i;\nEndFor\n"
GREEDY = "a() = {};\nFor i In {1:1e9}\n  a() += {i, i, i, i, i, i, i, i};\nEndFor\n"


def children() -> list[psutil.Process]:
    return psutil.Process().children(recursive=True)


@pytest.fixture(autouse=True)
def _nothing_left_behind(tmp_path_factory, monkeypatch):
    folder = tmp_path_factory.mktemp("own")  # other tests read files at the same time
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    before = set(children())  # of tests before
    yield
    assert not [one for one in set(children()) - before if one.status() != psutil.STATUS_ZOMBIE]
    assert not list(folder.iterdir())


def test_results_come_in_order() -> None:
    errands = [Errand("a", math.hypot, (3.0, 4.0)), Errand("b", str.upper, ("word",))]
    assert done_apart(errands, PATIENT) == [5.0, "WORD"]


@pytest.mark.parametrize("kind", [signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS])
def test_a_crash_names_its_file_and_signal(kind: signal.Signals) -> None:
    errands = [Errand("good.step", abs, (-1,)), Errand("bad.step", signal.raise_signal, (kind,))]
    with pytest.raises(GeometryError, match=rf"^bad\.step crashed its reader \({kind.name}\)"):
        done_apart(errands, PATIENT)


def test_an_end_without_answer_is_told() -> None:
    with pytest.raises(GeometryError, match=r"^bad\.step crashed its reader \(exit code 7\)"):
        done_apart([Errand("bad.step", os._exit, (7,))], PATIENT)


def test_more_time_than_allowed() -> None:
    start = time.monotonic()
    with pytest.raises(GeometryError, match=r"^slow\.geo was not done within reading\.time = 1 s; raise"):
        done_apart([Errand("slow.geo", time.sleep, (600.0,))], Reading(time=1.0))
    assert time.monotonic() - start < 60.0


def test_what_a_system_can_wait_is_the_most() -> None:
    assert done_apart([Errand("a", abs, (-1,))], Reading(time=1e6)) == [1]
    block = StackStructure(name="s", material="m", size=(1.0, 1.0, 1.0), count=1)
    scene = Scene(materials={}, structures=(block,), reading=Reading(time=1e7))
    with pytest.raises(SceneError, match=r"reading\.time is 10000000\.0, expected a time .*1e\+06"):
        check(scene)


def test_more_memory_than_allowed() -> None:
    with pytest.raises(GeometryError, match=r"^large\.json needs more memory than reading\.memory = 1e\+08 "):
        done_apart([Errand("large.json", bytearray, (10**9,))], Reading(memory=1e8))


def test_errors_keep_their_class_and_defects_are_told_as_such() -> None:
    with pytest.raises(SceneError, match="no such scene file"):
        done_apart([Errand("a", load, ("missing.toml",))], PATIENT)
    with pytest.raises(GeometryError, match=r"^wall\.vtu could not be read, ValueError: .*export it again"):
        done_apart([Errand("wall.vtu", float, ("x",))], PATIENT)


def test_what_is_logged_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "partly.geo").write_text(
        'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nBox(2) = {0, 0, 1, 1, 1, 1};\n'
        'Physical Volume("100 % a") = {1};\n'
    )
    spec = FileStructure(name="f", material="s", path="partly.geo", trusted=True)
    stack = StackStructure(name="pier", material="s", size=(1.0, 1.0, 1.0), count=2)
    settings = MeshSettings(element="P1")
    with gathered() as remarks:
        made = build_structures((stack, spec), 3, tmp_path, (settings, settings), PATIENT)
    assert [len(one.blocks) for one in made] == [3, 1]
    (warned,) = (one for one in caplog.records if one.levelno >= logging.WARNING)
    assert "no physical group" in warned.getMessage()
    assert [(one.code, one.sentence) for one in remarks] == [("ungrouped", warned.getMessage())]


def test_what_is_no_remark_is_logged_too(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    corners = "".join(
        f"a,{number},{x},0,{z}\n" for number, (x, z) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)])
    )
    (tmp_path / "a.csv").write_text(f"stone,vertex,x,y,z\n{corners}")
    spec = SurveyStructure(name="s", material="s", path="a.csv", depth=0.5)
    with caplog.at_level(logging.INFO, logger="masonry_fem"), gathered() as remarks:
        build_structures((spec,), 3, tmp_path, (MeshSettings(),), PATIENT)
    told = {one.levelno: one.name for one in caplog.records if "off the wall's plane" in one.getMessage()}
    assert told == {logging.INFO: "masonry_fem.importing.survey"}
    assert not remarks


def test_the_same_bits_as_in_this_process(repository: Path) -> None:
    spec = FileStructure(name="f", material="s", path="keystone_arch.msh")
    settings, base = MeshSettings(), repository / "meshes"
    (there,) = build_structures((spec,), 3, base, (settings,), PATIENT)
    here = build_structure(spec, 3, base, settings)
    assert [one.name for one in there.blocks] == [one.name for one in here.blocks]
    for one, two in zip(there.shapes, here.shapes, strict=True):
        assert one.mesh is not None
        assert two.mesh is not None
        assert one.mesh.points.tobytes() == two.mesh.points.tobytes()
        assert one.mesh.cells.tobytes() == two.mesh.cells.tobytes()
        assert one.solid.vertices.tobytes() == two.solid.vertices.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(("text", "limits", "said"), [
    (ENDLESS, 'time = "2 s"', "was not done within reading.time = 2 s"),
    ('SystemCall "sleep 600";\n', 'time = "2 s"', "was not done within reading.time = 2 s"),
    (GREEDY, 'memory = "50 MB"', "memory"),
])  # fmt: skip
def test_a_program_that_takes_too_much(
    text: str, limits: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "box.geo").write_text(text)
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format(name="box.geo") + f"[reading]\n{limits}\n")
    assert cli.main(["check", str(scene), "--trust"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "structures.box.path 'box.geo'" in line
    assert said in line


def test_a_step_file_that_crashes_its_reader(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of the ways to damage a drawing, one that OpenCASCADE 7.8 does not survive: what refers to itself."""
    path = tmp_path / "box.step"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    whole = path.read_text()
    path.write_text(re.sub(r"#(\d+) = VECTOR\('',#\d+", r"#\1 = VECTOR('',#\1", whole))
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format(name="box.step") + '[mesh]\nelement = "P1"\n')
    assert cli.main(["check", str(scene)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "structures.box.path 'box.step'" in line


def test_limits_have_units() -> None:
    assert si_value("4 GB", "B") == 4e9
    assert si_value("2 min", "s") == 120.0
