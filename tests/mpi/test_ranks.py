"""Ranks: the same results from one process and from several, one output, and no rank that is left behind."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

from masonry_fem.host.ranks import COUNTS, Alone, join, team
from tests.mpi.scenes import SCENES, SPLIT, scene

HERE = Path(__file__).parent
CLI = ("-m", "masonry_fem")
TOGETHER = (str(HERE / "together.py"),)
LARGE_PARTS = (str(HERE / "large_parts.py"),)
PRECONDITIONER = (str(HERE / "preconditioner.py"),)
PROBLEMS = (str(HERE / "problems.py"),)
BESIDE = Path(sys.executable).parent / "mpiexec"  # that of the MPI that this Python's libraries have
MPIEXEC = str(BESIDE) if BESIDE.exists() else shutil.which("mpiexec")


def started(folder, count, *arguments, program=CLI):
    """What ``count`` ranks make of a command line."""
    command = [sys.executable, *program, *map(str, arguments)]
    if count:
        if MPIEXEC is None:
            pytest.skip("there is no mpiexec")
        pytest.importorskip("petsc4py")
        command = [MPIEXEC, "-n", str(count), *command]
    ours = {name: value for name, value in os.environ.items() if not name.startswith(("PMI_", "OMPI_"))}
    root = str(HERE.parents[1])
    return subprocess.run(
        command, cwd=folder, env=ours | {"PYTHONPATH": root}, capture_output=True, text=True, check=False,
        timeout=600,
    )  # fmt: skip


def ran(folder, count, name, program=CLI):
    """Summary of a run, and the fields of its blocks at the end."""
    (folder / "scene.toml").write_text(scene(name))
    out = folder / f"ranks_{count}"
    done = started(folder, count, "run", "scene.toml", "--out", out, "--quiet", program=program)
    assert done.returncode == 0, done.stderr
    assert not done.stdout
    fields = meshio.read(sorted((out / "fields").glob("blocks_*.vtu"))[-1])
    return json.loads((out / "summary.json").read_text()), fields


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """What one process without mpiexec makes of a scene."""
    known = {}

    def run(name):
        if name not in known:
            known[name] = ran(tmp_path_factory.mktemp("alone"), 0, name)
        return known[name]

    return run


def assert_same(found, expected, tolerance=1e-7):
    """The same summary and fields to a tolerance, relative to the largest value of each."""
    (ours, fields), (theirs, others) = found, expected
    for key in ("outcome", "steps", "blocks", "contacts", "unknowns"):
        assert ours[key] == theirs[key]
    assert ours["certificate"]["natural_map"] <= 1e-9
    for name, wrench in theirs["supports"].items():
        for part in ("force", "moment"):
            size = np.abs(theirs["supports"][name][part]).max()
            np.testing.assert_allclose(
                ours["supports"][name][part], wrench[part], rtol=0, atol=tolerance * size
            )
    for name, values in others.point_data.items():
        if name.startswith("principal_direction"):  # an axis has no sign, and two equal stresses no axes
            continue
        size = np.abs(values).max(initial=0.0)
        np.testing.assert_allclose(
            fields.point_data[name], values, rtol=0, atol=tolerance * size, err_msg=name
        )


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize("name", SCENES)
def test_ranks_find_what_one_process_does(name, count, alone, tmp_path):
    found = ran(tmp_path, count, name)
    assert_same(found, alone(name))
    told = found[0]["ranks"]
    assert told["count"] == count
    assert ("products" in told.get("work", {})) == (name in SPLIT)
    codes = {remark["code"] for remark in found[0].get("remarks", ())}
    assert ("idle_ranks" in codes) == (name not in SPLIT)


@pytest.mark.slow
def test_one_rank_is_one_process(alone, tmp_path):
    found = ran(tmp_path, 1, "elastic statics")
    assert_same(found, alone("elastic statics"), 0.0)
    assert "ranks" not in found[0]


@pytest.mark.slow
def test_ranks_without_stones(alone, tmp_path):
    found = ran(tmp_path, 7, "few stones")
    assert_same(found, alone("few stones"))
    assert min(found[0]["ranks"]["work"]["products"]["seconds"]) >= 0


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 4])
def test_bodies_matrix_factorised_together(count, alone, tmp_path):
    assert_same(ran(tmp_path, count, "elastic statics", TOGETHER), alone("elastic statics"))


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_unlike_stones_are_factorised_by_all_ranks(count, alone, tmp_path):
    found = ran(tmp_path, count, "unlike stones")
    assert_same(found, alone("unlike stones"))
    assert found[0]["factorisations"] == alone("unlike stones")[0]["factorisations"]
    assert min(found[0]["ranks"]["work"]["stones"]["seconds"]) > 0
    assert "remarks" not in found[0] or "idle_ranks" not in {one["code"] for one in found[0]["remarks"]}


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_no_seam_is_divided(count, tmp_path):
    """Steps are preconditioned as on one rank, so that they are the same ones on any number of them."""
    (tmp_path / "scene.toml").write_text(scene("elastic statics"))
    done = started(tmp_path, count, "run", "scene.toml", "--quiet", program=PRECONDITIONER)
    assert done.returncode == 0, done.stderr
    assert "impulses and motions agree to" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_ranks_take_the_turns_of_one_process(count, tmp_path):
    """Open joints, cohesion, rigid stones, what has no equilibrium, and iterations that fail."""
    done = started(tmp_path, count, program=PROBLEMS)
    assert done.returncode == 0, done.stderr
    assert "of which the leader ended 1" in done.stderr


@pytest.mark.slow
def test_ranks_solve_for_parts_of_parts(tmp_path):
    """Some of them together, the others dealt out, and none waits for ever."""
    (tmp_path / "scene.toml").write_text(scene("parts"))
    done = started(tmp_path, 2, "run", "scene.toml", "--out", "out", "--quiet", program=LARGE_PARTS)
    assert done.returncode == 0, done.stderr
    assert int(done.stderr.split("parts within parts: ")[1][0]) > 1
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "equilibrium"
    assert summary["certificate"]["natural_map"] <= 1e-9
    assert min(summary["ranks"]["work"]["parts"]["seconds"]) > 0


@pytest.mark.slow
def test_each_rank_has_its_share(tmp_path):
    work = ran(tmp_path, 2, "elastic, many contacts, by the program's own choice")[0]["ranks"]["work"]
    assert min(work["products"]["seconds"]) > 0
    # what is exchanged is what lies between the parts, not the wall
    exchanged, handed = max(work["exchange"]["received"]), max(work["handed out"]["received"])
    assert 0 < exchanged / max(work["exchange"]["times"]) < 0.02 * handed


@pytest.mark.slow
def test_errors_are_told_once(tmp_path):
    (tmp_path / "scene.toml").write_text("dimension = 4")
    for arguments in (("run", "scene.toml"), ("run", "none.toml"), ("run",), ("check", "scene.toml")):
        done = started(tmp_path, 2, *arguments)
        assert done.returncode == 1
        assert done.stderr.count("masonry-fem") == 1 + done.stderr.count("usage:")
    assert "'run' is the only command" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "code", "said"),
    [
        ("agreed", 1, "masonry-fem: block 'wall.c1.b1' is not there"),
        ("alone", 1, "masonry-fem: rank 1: unexpected ZeroDivisionError: of one rank"),
        ("interrupted", 130, "masonry-fem: interrupted"),
        ("singular", 0, ""),
    ],
)
def test_failures_leave_no_rank_behind(how, code, said, tmp_path):
    (tmp_path / "scene.toml").write_text(scene("elastic statics"))
    failing = (str(HERE / "failing.py"), how)
    done = started(tmp_path, 2, "run", "scene.toml", "--quiet", program=failing)
    assert done.returncode == code, done.stderr
    told = [line for line in done.stderr.splitlines() if line.startswith("masonry-fem")]
    assert told == [] if not said else [line.startswith(said) for line in told] == [True]


@pytest.mark.slow
def test_each_rank_has_one_thread_unless_somebody_says_how_many(monkeypatch, tmp_path):
    code = "import os, sys, masonry_fem.host.ranks as r\nif r.join(): sys.exit(0)\n" + (
        "print(os.environ['OPENBLAS_NUM_THREADS'], os.environ['OMP_NUM_THREADS'])\nr.team().end(0)"
    )
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    done = started(tmp_path, 2, program=("-c", code))
    assert done.stdout.split() == ["1", "3"], done.stderr


def test_one_process_has_no_mpi(tmp_path):
    code = "import sys, masonry_fem.cli as c; c.main(['info']); print('mpi4py' in sys.modules)"
    done = started(tmp_path, 0, program=("-c", code))
    assert done.stdout.splitlines()[-1] == "False", done.stderr


def test_a_process_that_was_started_alone_leads_nobody(monkeypatch):
    for name in COUNTS:
        monkeypatch.delenv(name, raising=False)
    assert not join()
    assert isinstance(team(), Alone)
    assert team().size == 1
    assert not team().spent()
