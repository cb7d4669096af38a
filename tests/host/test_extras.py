"""Extras: where gmsh or pictures are not installed all else works, and a sentence says what to install."""

import os
import subprocess
import sys
import tomllib

import pytest

from masonry_fem.cli import main
from masonry_fem.errors import InstallationError
from masonry_fem.host import installation
from masonry_fem.meshing.session import session

WITHOUT = "import sys\nsys.modules.update(dict.fromkeys({names!r}))\n"
WALL = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ element = "P1", size = 0.3 }}
materials.stone = {{ young = "10 GPa", density = 2400 }}
structures = [{structure}]
loads.gravity = [0.0, -9.81]
analysis.kind = "statics"
output.pictures = {pictures}
"""
STACK = '{ kind = "stack", name = "pile", material = "stone", size = [1.0, 0.5], count = 2 }'
FILE = '{ kind = "file", name = "keystone", material = "stone", path = "keystone.msh" }'


@pytest.fixture
def command(tmp_path, repository):
    """The command line where some modules are as if they were not installed, in processes it starts, too."""

    def run(*arguments, without, cwd=tmp_path):
        (tmp_path / "sitecustomize.py").write_text(WITHOUT.format(names=without))
        paths = os.pathsep.join([str(tmp_path), str(repository)])
        environment = os.environ | {"PYTHONPATH": paths}
        return subprocess.run(
            [sys.executable, "-m", "masonry_fem", *map(str, arguments)],
            capture_output=True,
            text=True,
            check=False,
            cwd=cwd,
            env=environment,
        )

    return run


@pytest.fixture
def lacking(monkeypatch):
    """Makes a library as if it were not installed, as far as those see who look before they import it."""

    def without(name):
        find = installation.find_spec
        monkeypatch.setattr(installation, "find_spec", lambda one: None if one == name else find(one))

    return without


def scene_of(folder, structure=STACK, fidelity="rigid", pictures="true"):
    path = folder / "scene.toml"
    path.write_text(WALL.format(structure=structure, fidelity=fidelity, pictures=pictures))
    return path


def test_without_pictures_a_run_writes_all_else(command, tmp_path):
    done = command(
        "run", scene_of(tmp_path), "--out", tmp_path / "out", without=["pyvista", "vtkmodules", "matplotlib"]
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("pip install") == 1
    sentence = (
        "no pictures: pyvista and matplotlib are not installed; pip install 'masonry-fem[pictures]', or set"
    )
    assert sentence in " ".join(done.stderr.split())
    written = {path.suffix for path in (tmp_path / "out").iterdir()}
    assert {".json", ".csv", ".pvd"} <= written
    assert ".png" not in written


def test_a_folder_to_be_shown_says_what_to_install(lacking, tmp_path, capsys):
    lacking("pyvista")
    assert main(["view", str(tmp_path), "--png"]) == 1
    told = "cannot be shown: pyvista is not installed; pip install 'masonry-fem[pictures]'"
    assert told in capsys.readouterr().err


@pytest.mark.slow
def test_without_gmsh_a_rigid_run_ends_well(command, tmp_path):
    done = command("run", scene_of(tmp_path, pictures="false"), "--out", tmp_path / "out", without=["gmsh"])
    assert done.returncode == 0, done.stderr
    assert "gmsh" not in done.stderr


def test_gmsh_that_is_not_installed_is_told(lacking):
    lacking("gmsh")
    told = r"read or meshed: gmsh is not installed; pip install 'masonry-fem\[gmsh\]'"
    with pytest.raises(InstallationError, match=told), session("file 'vault.msh'"):
        pass


@pytest.mark.slow
def test_a_file_for_gmsh_says_what_to_install(command, tmp_path):
    """It is read in a process of its own."""
    (tmp_path / "keystone.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")
    done = command("check", scene_of(tmp_path, FILE, pictures="false"), without=["gmsh"])
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "cannot be read or meshed: gmsh is not installed; pip install 'masonry-fem[gmsh]'" in done.stderr


USUAL = {"fenicsx", "gmsh", "pictures"}  # the others serve single commands and file formats


def test_the_extras_are_those_of_the_package(repository):
    package = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    for extra, modules in installation.EXTRAS.items():
        wanted = package["optional-dependencies"][extra]
        named = {requirement.partition(">")[0].replace("-", "_") for requirement in wanted}
        assert named == set(modules)
        assert not any(one.partition(">")[0] in modules for one in package["dependencies"])
        lines = asked_for(repository)
        assert all(f",{extra}" in line for line in lines if extra in USUAL or ",test" in line)


def asked_for(repository):
    """The lines of the Makefile that install: whatever is made, nothing is missing."""
    lines = (repository / "Makefile").read_text().splitlines()
    found = [line for line in lines if line.lstrip().startswith("@sh tools/prepare")]
    assert len(found) == 3
    return found


def test_gmsh_without_the_libraries_it_draws_with_is_told(monkeypatch):
    class Broken:
        def find_spec(self, name, path=None, target=None):
            if name == "gmsh":
                raise OSError("libGLU.so.1: cannot open shared object file")

    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    monkeypatch.setattr(installation, "lacking", lambda extra: None)
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    with (
        pytest.raises(InstallationError, match=r"gmsh cannot be loaded \(libGLU.*; install what it draws"),
        session("file 'vault.msh'"),
    ):
        pass
