"""Start-up: heavy libraries are loaded by the scenes that need them, and by nothing else."""

import subprocess
import sys

import pytest

HEAVY = {"dolfinx", "petsc4py", "mpi4py", "pyvista", "vtk", "vtkmodules", "gmsh", "matplotlib"}
HANDY = {"numpy", "scipy", "numba", "rich", "pint"}

RIGID = """
from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Dynamics, Loads, Material, Output, Scene
from masonry_fem.structures.stack import StackStructure
result = solve_scene(Scene(
    dimension=2,
    fidelity="rigid",
    materials={"stone": Material(density=2000.0)},
    structures=(StackStructure(name="pile", material="stone", size=(1.0, 1.0), count=2),),
    loads=Loads(gravity=(0.0, -10.0)),
    analysis=Dynamics(step=0.1, duration=0.2, theta=1.0),
    output=Output(pictures=False),
))
assert result.outcome == "finished"
"""


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


def test_a_rigid_scene_loads_neither_fenicsx_nor_pictures(repository):
    assert not loaded(RIGID, repository) & HEAVY
