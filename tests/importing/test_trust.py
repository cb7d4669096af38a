"""Trust: what a file asks a machine to do is not done unless the user says so."""

from __future__ import annotations

from pathlib import Path

import gmsh
import pytest

from masonry_fem import cli
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.importing.mesh_files import read
from masonry_fem.scene import load
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.structures.file import FileStructure

SCENE = """
dimension = 3
fidelity = "rigid"
[materials.stone]
density = 2400
[[structures]]
kind = "file"
name = "box"
path = "{name}"
material = "stone"
supports = ["*"]
[loads]
gravity = [0, 0, -9.81]
[output]
pictures = false
fields = false
"""
BOX = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\n'
COMMANDS = (["check"], ["run"], ["mesh"], ["limit"], ["collapse"], ["study", "--vary", "dimension=3"])


def touching(mark: Path) -> str:
    return f'SystemCall "touch {mark}";\n'


@pytest.fixture
def mark(tmp_path: Path) -> Path:
    """A file that only a program that was run would have made."""
    return tmp_path / "ran"


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    scene = folder / "scene.toml"
    scene.write_text(SCENE.format(name=name))
    return scene


@pytest.mark.parametrize("ending", ["geo", "geo_unrolled", "GEO"])
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_no_command_runs_a_program_unasked(
    command: list[str], ending: str, tmp_path: Path, mark: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = written(tmp_path, f"box.{ending}", touching(mark) + BOX)
    out = [] if command[0] in ("check", "limit") else ["--out", str(tmp_path / "out")]
    assert cli.main([command[0], str(scene), *command[1:], *out]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"structures.box.trusted is false, expected true: 'box.{ending}' is a program" in line
    assert "--trust" in line
    assert not mark.exists()


@pytest.mark.parametrize("ending", [pytest.param("geo", marks=pytest.mark.slow), "geo_unrolled"])
def test_trust_is_given_in_the_scene_or_on_the_command_line(
    ending: str, tmp_path: Path, mark: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = written(tmp_path, f"box.{ending}", touching(mark) + BOX)
    assert cli.main(["check", str(scene), "--trust"]) == 0
    assert mark.exists()
    mark.unlink()
    assert cli.main(["check", str(scene), "--set", "structures.box.trusted=true"]) == 0
    assert mark.exists()
    assert capsys.readouterr().err == ""


def test_a_scene_read_in_python_is_held_to_it_too(tmp_path: Path, mark: Path) -> None:
    scene = written(tmp_path, "box.geo", touching(mark) + BOX)
    with pytest.raises(SceneError, match="trusted is false"):
        load(scene)
    spec = FileStructure(name="box", material="stone", path="box.geo")
    with pytest.raises(GeometryError, match="trusted is False"):
        read(spec, 3, tmp_path, MeshSettings())
    assert not mark.exists()


def test_trusting_leaves_unreadable_scenes_to_the_reader(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.toml").write_text("[[")
    for name in ("bad.toml", "missing.toml"):
        assert cli.main(["check", str(tmp_path / name), "--trust"]) == 1
        assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(("name", "beginning"), [
    ("box.msh", r"\$MeshFormat"), ("box.step", "ISO-10303-21"), ("box.stp", "ISO-10303-21"),
])  # fmt: skip
@pytest.mark.parametrize("before", ["", "\n", "$MeshFor\n"])
def test_a_program_by_another_ending_is_refused(
    name: str, beginning: str, before: str, tmp_path: Path, mark: Path
) -> None:
    """gmsh would run it: it takes what it does not know for a program."""
    (tmp_path / name).write_text(before + touching(mark) + BOX)
    with pytest.raises(GeometryError, match=f"begins with .*, expected '{beginning}'"):
        read(FileStructure(name="box", material="stone", path=name), 3, tmp_path, MeshSettings())
    assert not mark.exists()


@pytest.mark.parametrize("name", ["box.msh", "box.step", "box.geo"])
def test_options_beside_a_file_are_not_read(name: str, tmp_path: Path, mark: Path) -> None:
    """gmsh runs FILE.opt; of a trusted program, too, only the program itself is trusted."""
    path = tmp_path / name
    if path.suffix == ".geo":
        path.write_text(BOX)
    else:
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
        gmsh.finalize()
    for options in (f"{name}.opt", "box.opt"):
        (tmp_path / options).write_text(touching(mark))
    spec = FileStructure(name="box", material="stone", path=name, trusted=path.suffix == ".geo")
    assert len(read(spec, 3, tmp_path, MeshSettings(element="P1")).blocks) == 1
    assert not mark.exists()


def test_a_trusted_program_finds_what_stands_beside_it(tmp_path: Path) -> None:
    (tmp_path / "height.geo").write_text("H = 3;\n")
    (tmp_path / "box.geo").write_text('Include "height.geo";\n' + BOX.replace("1};", "H};"))
    spec = FileStructure(name="box", material="stone", path="box.geo", trusted=True)
    made = read(spec, 3, tmp_path, MeshSettings(element="P1"))
    assert made.shapes[0].solid.mass_properties().volume == pytest.approx(3.0)


@pytest.mark.parametrize("folder", ['a"b', "a\\b", "a\nb"])
def test_a_program_where_gmsh_cannot_name_it(folder: str, tmp_path: Path) -> None:
    base = tmp_path / folder
    base.mkdir()
    (base / "box.geo").write_text(BOX)
    spec = FileStructure(name="box", material="stone", path="box.geo", trusted=True)
    with pytest.raises(GeometryError, match="expected a path without quotation marks"):
        read(spec, 3, base, MeshSettings())
