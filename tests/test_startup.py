"""Start-up: heavy libraries are loaded by the scenes that need them, and by nothing else."""

import subprocess
import sys

import pytest

from masonry_fem.errors import SceneError
from masonry_fem.scene import load

HEAVY = {"dolfinx", "petsc4py", "mpi4py", "pyvista", "vtk", "vtkmodules", "gmsh", "matplotlib"}
HANDY = {"numpy", "scipy", "numba", "rich", "pint"}


def loaded(code, folder):
    """Top-level modules that a fresh interpreter holds after ``code``."""
    report = "\nimport sys\nprint(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code + report], capture_output=True, text=True, check=True, cwd=folder
    )
    return set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(
    "code",
    [
        "import masonry_fem",
        "import masonry_fem.cli\ntry:\n    masonry_fem.cli.main(['--help'])\nexcept SystemExit:\n    pass",
    ],
    ids=["import", "help"],
)
def test_start_loads_no_library(code, repository):
    assert not loaded(code, repository) & (HEAVY | HANDY)


FAULTS = {
    "unknown key 'colour'": "colour = 'red'",
    "lacks the key 'structures'": "materials.stone.density = 2400.0",
    "fidelity": "fidelity = 'soft'\nmaterials = {}\nstructures = []",
    "density": "materials.stone.density = -1.0\nstructures = []",
}


@pytest.mark.parametrize("told", FAULTS)
def test_a_refused_file_loads_no_library(told, repository, tmp_path):
    """Structures, which need NumPy, are read after these keys."""
    scene = tmp_path / "scene.toml"
    scene.write_text(FAULTS[told], encoding="utf-8")
    with pytest.raises(SceneError, match=told):
        load(scene)
    code = f"import masonry_fem.cli\nassert masonry_fem.cli.main(['check', {str(scene)!r}]) == 1"
    assert not loaded(code, repository) & (HEAVY | HANDY)


def test_contact_solver_loads_arrays_only(repository):
    assert not loaded("import masonry_fem.nscd", repository) & HEAVY
