"""Economy: a scene is charged for what it asks for, and for nothing else."""

from __future__ import annotations

import io
import json
import subprocess
import sys

import numpy as np
import pytest
from msgspec import structs
from rich.console import Console

import masonry_fem.build.model as composition
import masonry_fem.fem.groups as grouping
import masonry_fem.joints.fold as folding
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.bodies.base import Scheme
from masonry_fem.fem.condense import coefficients
from masonry_fem.meshing import mesher as meshing
from masonry_fem.output.terminal import print_summary
from masonry_fem.scene.specs import (
    Dynamics,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Output,
    Scene,
    Statics,
    law_record,
)
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

BARE = Output(fields=False, pictures=False)
FEM_PHASES = {"import", "mesh", "assemble", "factorise"}


def wall(fidelity="elastic", dimension=3, analysis=None, columns=3, courses=4, **keys):
    """Running bond on the ground: whole bricks and half bricks, however many."""
    brick = (0.5, 0.25, 0.25) if dimension == 3 else (0.5, 0.25)
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        mesh=MeshSettings(divisions=(2,) * dimension),
        materials={"stone": Material(density=2400.0, young=1e10)},
        structures=(
            WallStructure(name="wall", material="stone", brick=brick, columns=columns, courses=courses),
        ),
        loads=Loads(gravity=(*(0.0,) * (dimension - 1), -9.81)),
        analysis=analysis or Statics(),
        output=BARE,
        **keys,
    )


def stack():
    """Two blocks on each other and on the ground."""
    pile = StackStructure(name="pile", material="stone", size=(1.0, 1.0, 1.0), count=2)
    return structs.replace(wall(), structures=(pile,))


@pytest.fixture
def calls(monkeypatch):
    """How often meshes are made, shapes assembled and contacts detected."""
    seen = {"mesh": 0, "assemble": 0, "detect": 0}

    def count(name, function):
        def counted(*arguments, **keys):
            seen[name] += len(arguments[0]) if name == "assemble" else 1
            return function(*arguments, **keys)

        return counted

    monkeypatch.setattr(meshing, "mesh_shape", count("mesh", meshing.mesh_shape))
    monkeypatch.setattr(grouping, "assemble_shapes", count("assemble", grouping.assemble_shapes))
    monkeypatch.setattr(composition, "detect", count("detect", composition.detect))
    return seen


# --- finite elements ------------------------------------------------------------------------------


def test_repeated_blocks_are_meshed_assembled_and_factorised_once(calls):
    small = solve_scene(wall(columns=2, courses=2)).summary
    assert calls == {"mesh": 2, "assemble": 2, "detect": 1}
    large = solve_scene(wall(columns=5, courses=6)).summary
    assert calls == {"mesh": 4, "assemble": 4, "detect": 2}
    for summary in (small, large):
        assert (summary.shapes, summary.meshes, summary.factorisations) == (2, 2, 2)
    assert large.blocks > 6 * small.blocks / 2


def test_a_march_factorises_and_detects_once(calls):
    result = solve_scene(wall(analysis=Dynamics(step=1e-3, duration=8e-3, theta=1.0), courses=2))
    assert result.summary.steps == 8
    assert result.summary.factorisations == 2
    assert calls == {"mesh": 2, "assemble": 2, "detect": 1}


def test_a_long_step_after_short_ones_is_factorised_once_more():
    (bricks,) = (group for group in solve_scene(stack()).built.model.groups if group.deforms)
    assert bricks.factorisations == 1
    bricks.factor(Scheme(step=1e-3))
    bricks.factor(Scheme(step=1e-3))
    assert bricks.factorisations == 2


def test_statics_puts_no_mass_into_its_matrices():
    result = solve_scene(wall())
    scheme = result.march.last.scheme
    for group in result.built.model.groups:
        if group.deforms:
            inertial, elastic = coefficients(group.operators, scheme)
            assert inertial == 0.0
            assert elastic > 0.0


def test_a_rigid_scene_has_no_finite_element_phases(calls):
    summary = solve_scene(wall("rigid")).summary
    assert not FEM_PHASES & set(summary.seconds)
    assert (summary.meshes, summary.factorisations) == (0, 0)
    assert calls == {"mesh": 0, "assemble": 0, "detect": 1}
    assert set(solve_scene(wall()).summary.seconds) >= FEM_PHASES


# --- joints ---------------------------------------------------------------------------------------


def test_dry_joints_are_one_law_and_solved_in_one_turn(monkeypatch):
    """However many records they have: no arrays of parts are made, and nothing is solved again."""
    solved, solve_contacts = [], folding.solve

    def counting(*given):
        solved.append(solve_contacts(*given))
        return solved[-1]

    monkeypatch.setattr(folding, "solve", counting)
    joints = (Joint(friction=0.6), Joint(interface="head", friction=0.4, dynamic_friction=0.3))
    dry = solve_scene(wall("rigid", joints=joints))
    laws = dry.built.model.laws
    assert laws.all_plain
    assert len(laws.parts) == 1
    assert len(solved) == dry.march.report.step
    law = law_record(
        "fremond_cangemi", normal_stiffness=1e10, tangential_stiffness=1e10, energy=50.0, viscosity=0.0
    )
    assert not solve_scene(wall("rigid", joints=(Joint(law=law),))).built.model.laws.all_plain


# --- dimension ------------------------------------------------------------------------------------


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_plane_scene_stays_plane(fidelity):
    result = solve_scene(wall(fidelity, dimension=2))
    state, model = result.march.state, result.built.model
    assert state.reaction.shape == (model.contacts.count, 2)
    assert state.frame.shape == (model.contacts.count, 2, 2)
    for group in model.groups:
        assert group.nodes(0).shape[1] == 2
        if not group.prescribed:
            assert result.march.last.free[model.groups.index(group)].rigid_impulse.shape[1] == 3


# --- files and libraries --------------------------------------------------------------------------


def test_nothing_is_written_that_was_not_asked_for(tmp_path):
    result = run(wall("rigid"), tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").glob("[!.]*")} == {
        "summary.json",
        "history.csv",
        "as_run.toml",
    }
    assert {path.name for path in result.files} == {"summary.json", "history.csv", "as_run.toml"}


SCENE = """
fidelity = "{fidelity}"
mesh = {{ divisions = [2, 1, 1] }}
[materials.stone]
density = 2400.0
young = 1e10
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = 2
courses = 2
[loads]
gravity = [0.0, 0.0, -9.81]
[output]
fields = false
pictures = false
"""


def modules(fidelity, folder):
    """Modules that ``masonry-fem run`` holds after a scene."""
    (folder / "wall.toml").write_text(SCENE.format(fidelity=fidelity))
    code = (
        "import json, sys, masonry_fem.cli\n"
        "code = masonry_fem.cli.main(['run', 'wall.toml', '--quiet'])\n"
        "print(json.dumps([code, *sys.modules]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=folder
    )
    ended, *names = json.loads(done.stdout.splitlines()[-1])
    assert ended == 0
    return set(names)


def test_a_rigid_run_loads_only_what_it_uses(tmp_path):
    loaded = modules("rigid", tmp_path)
    libraries = {name.partition(".")[0] for name in loaded}
    assert not libraries & {"dolfinx", "ufl", "basix", "petsc4py", "mpi4py", "gmsh", "meshio", "pyvista",
                            "matplotlib", "clarabel", "rich", "pint", "pyamg"}  # fmt: skip
    # of fem only the laws of materials, whose keys scenes may have
    own = {"analyses.cells", "analyses.study", "fem._compat", "fem.assemble", "fem.condense", "fem.elastic",
           "fem.groups", "fem.inelastic", "fem.lagrange", "limit", "meshing.mesher",
           "importing.mesh_files", "importing.apart", "output.interfaces", "output.asked.fields",
           "output.asked.pictures"}  # fmt: skip
    assert not loaded & {"scipy.optimize", "scipy.spatial", *(f"masonry_fem.{name}" for name in own)}


@pytest.mark.slow
def test_an_elastic_run_of_boxes_loads_neither_gmsh_nor_pictures(tmp_path):
    libraries = {name.partition(".")[0] for name in modules("elastic", tmp_path)}
    assert "dolfinx" in libraries
    assert not libraries & {"gmsh", "meshio", "pyvista", "matplotlib", "clarabel", "rich", "pint"}


# --- what the console says ------------------------------------------------------------------------


def told(summary):
    """The console's lines for a summary."""
    console = Console(width=200, file=io.StringIO())
    print_summary(summary, console)
    return console.file.getvalue()


def test_the_console_counts_shapes_and_factorisations():
    assert "15 blocks, 2 shapes, 2 meshes, 2 factorisations," in told(solve_scene(wall()).summary)
    rigid = told(solve_scene(wall("rigid")).summary)
    assert "15 blocks, 2 shapes," in rigid
    assert "factorisation" not in rigid


def test_reactions_are_the_same_whatever_is_asked_for(tmp_path):
    bare, asked = wall("rigid"), Output(fields=False, pictures=False, interfaces=True)
    first = run(bare, tmp_path / "bare").march.state
    second = run(structs.replace(bare, output=asked), tmp_path / "asked").march.state
    np.testing.assert_array_equal(first.reaction, second.reaction)
