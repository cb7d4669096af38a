"""Start-up: heavy libraries are loaded by the scenes that need them, and by nothing else."""

import subprocess
import sys

import pytest

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


def test_contact_solver_loads_arrays_only(repository):
    assert not loaded("import masonry_fem.nscd", repository) & HEAVY
