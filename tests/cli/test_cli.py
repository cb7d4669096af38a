"""The command line: exit codes, one-line errors, what each command prints and writes."""

import json
import logging
import os
import re
import subprocess
import sys
import types
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from masonry_fem import cli
from masonry_fem.errors import GeometryError

SCENE = """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 0.5]
count = 2
[loads]
gravity = [0, -9.81]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "pier.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def runner(monkeypatch):
    """A stand-in for ``masonry_fem.analyses.run``: what the CLI asks of it, and answers to order."""
    stub = types.ModuleType("masonry_fem.analyses.run")
    stub.calls = []
    stub.answer = SimpleNamespace(
        outcome="equilibrium", message="all at rest", summary={"outcome": "equilibrium"}, files=[]
    )

    def run(scene, out, *, base, save_contact=None, quiet=False):
        stub.calls.append((scene, out, base, save_contact, quiet))
        if isinstance(stub.answer, BaseException):
            raise stub.answer
        return stub.answer

    stub.run = run
    monkeypatch.setitem(sys.modules, "masonry_fem.analyses.run", stub)
    inspection = types.ModuleType("masonry_fem.analyses.inspect")
    facts = {"blocks": 3, "seconds": 0.25, "roles": {"rigid": 2}, "estimated_memory_mb": 385.756}
    inspection.check_scene = lambda scene, base: dict(facts)
    inspection.write_mesh = lambda scene, out, base: [out / "mesh.vtu"]
    monkeypatch.setitem(sys.modules, "masonry_fem.analyses.inspect", inspection)
    return stub


def test_run_hands_the_scene_over_and_names_the_files(scene, runner, capsys, tmp_path):
    runner.answer.files = [tmp_path / "summary.json"]
    change = "structures.pier.count=5"
    code = cli.main(
        ["run", str(scene), "--out", str(tmp_path / "out"), "--set", change, "--save-contact", "3"]
    )
    assert code == 0
    (given, out, base, step, quiet) = runner.calls[0]
    assert given.structures[0].count == 5
    assert (out, base, step, quiet) == (tmp_path / "out", tmp_path, 3, False)
    printed = capsys.readouterr()
    assert f"wrote {tmp_path / 'summary.json'}" in printed.out
    assert "equilibrium" in printed.out
    assert printed.err == ""


def test_quiet_prints_nothing(scene, runner, capsys):
    assert cli.main(["run", str(scene), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("options", "level"), [([], logging.WARNING), (["--verbose"], logging.INFO), (["--debug"], logging.DEBUG)]
)
def test_who_asks_is_told_more(scene, runner, options, level):
    assert cli.main(["run", str(scene), "--quiet", *options]) == 0
    assert logging.getLogger("masonry_fem").level == level


def test_memory_that_is_not_enough_is_said_in_a_sentence(scene, runner, capsys, monkeypatch):
    def hungry(*given, **keys):
        raise MemoryError

    monkeypatch.setattr(sys.modules["masonry_fem.analyses.run"], "run", hungry)
    assert cli.main(["run", str(scene), "--quiet"]) == 1
    told = capsys.readouterr().err
    assert "memory" in told
    assert "mesh.size" in told
    assert "unexpected" not in told


def test_results_go_to_a_folder_named_after_the_scene(scene, runner):
    cli.main(["run", str(scene), "--quiet"])
    assert runner.calls[0][1] == Path("results/pier")


@pytest.mark.parametrize(
    ("outcome", "code"), [("equilibrium", 0), ("finished", 0), ("no_convergence", 2), ("no_equilibrium", 3)]
)
def test_the_exit_code_tells_the_outcome(scene, runner, capsys, outcome, code):
    runner.answer.outcome, runner.answer.message = outcome, "wall.c3.b1 slides"
    assert cli.main(["run", str(scene), "--quiet"]) == code
    assert capsys.readouterr().err == ("masonry-fem: wall.c3.b1 slides\n" if code else "")


@pytest.mark.parametrize("outcome", ["equilibrium", "no_convergence", "no_equilibrium"])
def test_the_message_is_said_once(scene, runner, capsys, outcome):
    said = "wall.c3.b1 slides"
    runner.answer.outcome, runner.answer.message = outcome, said
    runner.answer.summary = {"outcome": outcome, "message": said}
    cli.main(["run", str(scene)])
    printed = capsys.readouterr()
    assert (printed.out + printed.err).count(said) == 1
    assert (said in printed.err) == (outcome != "equilibrium")
    assert outcome.replace("_", " ") in printed.out


def test_errors_are_one_line(scene, runner, capsys):
    runner.answer = GeometryError("block 'a' overlaps block 'b' by 0.1 m")
    assert cli.main(["run", str(scene)]) == 1
    assert capsys.readouterr().err == "masonry-fem: block 'a' overlaps block 'b' by 0.1 m\n"


def test_unexpected_errors_are_one_line_with_a_hint(scene, runner, capsys):
    runner.answer = ZeroDivisionError("division by zero")
    assert cli.main(["run", str(scene)]) == 1
    assert re.fullmatch(
        r"masonry-fem: unexpected ZeroDivisionError: division by zero \(.*test_cli\.py, line \d+\); "
        r"run again with --debug for the details\n",
        capsys.readouterr().err,
    )


def test_debug_lets_errors_through(scene, runner):
    runner.answer = ZeroDivisionError("division by zero")
    with pytest.raises(ZeroDivisionError):
        cli.main(["run", str(scene), "--debug"])


def test_an_interrupt_is_told(scene, runner, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner.answer = KeyboardInterrupt()
    assert cli.main(["run", str(scene), "--out", "here"]) == 130
    assert capsys.readouterr().err == "masonry-fem: interrupted\n"
    Path("here").mkdir()
    assert cli.main(["run", str(scene), "--out", "here"]) == 130
    assert capsys.readouterr().err == "masonry-fem: interrupted; what was written so far is in here\n"


def test_a_bad_scene_is_told(scene, capsys):
    assert cli.main(["run", str(scene), "--set", "fidelity=rigit"]) == 1
    assert capsys.readouterr().err == (
        f"masonry-fem: {scene} with --set fidelity=rigit: fidelity is 'rigit', "
        "expected one of 'auto', 'elastic', 'inelastic', 'reduced', 'rigid'; did you mean 'rigid'?\n"
    )


def test_a_missing_file_is_told(capsys, tmp_path):
    assert cli.main(["check", str(tmp_path / "no.toml")]) == 1
    assert "no.toml: no such scene file" in capsys.readouterr().err


def test_bad_usage_is_bad_input(capsys):
    for arguments in ([], ["walk"], ["run"], ["contact", "a.npz", "--tol", "small"]):
        with pytest.raises(SystemExit) as caught:
            cli.main(arguments)
        assert caught.value.code == 1
    assert "invalid float value: 'small'" in capsys.readouterr().err


def test_check_prints_a_table(scene, runner, capsys):
    assert cli.main(["check", str(scene)]) == 0
    words = capsys.readouterr().out.split()
    assert words == [
        "blocks",
        "3",
        "seconds",
        "0.25",
        "roles",
        "rigid",
        "2",
        "estimated",
        "memory",
        "386",
        "MB",
    ]


def test_mesh_names_its_files(scene, runner, capsys):
    assert cli.main(["mesh", str(scene), "--out", "there"]) == 0
    assert capsys.readouterr().out == "wrote there/mesh.vtu\n"


def test_info_lists_what_there_is(capsys):
    assert cli.main(["info"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines][:3] == ["masonry_fem", "python", "numpy"]


# --- contact problems: one sphere pressed and pushed on a plane, by hand ----------------------


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    """W = I, q = (-1, -0.2), friction 0.5: sticks with r = (1, 0.2)."""
    path = tmp_path / "sphere.npz"
    np.savez(
        path, W_data=np.ones(2), W_indices=np.arange(2, dtype=np.int32),
        W_indptr=np.arange(3, dtype=np.int32), shape=np.array([2, 2]), q=np.array([-1.0, -0.2]),
        mu=np.array([0.5]), dim=2, name="sphere",
    )  # fmt: skip
    return path


def test_contact_prints_its_answer_and_writes_the_reaction(problem, tmp_path, capsys):
    out = tmp_path / "r.npy"
    assert cli.main(["contact", str(problem), "--tol", "1e-9", "--reaction", str(out)]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["outcome"] == "converged"
    assert facts["contacts"] == 1
    assert facts["error"] <= 1e-9
    assert facts["measures"]["natural_map"] <= 1e-9
    assert {"iterations", "seconds", "method", "message", "tolerance"} <= facts.keys()
    np.testing.assert_allclose(np.load(out), [1.0, 0.2], rtol=1e-9)


def test_contact_tells_which_impulses_are_a_choice(tmp_path, capsys):
    """Two points under one sphere, twice the same contact: any shares will do, equal ones are least."""
    path, out = tmp_path / "twice.npz", tmp_path / "r.npy"
    np.savez(
        path, W_data=np.tile([1.0, 1.0], 4), W_indices=np.array([0, 2, 1, 3, 0, 2, 1, 3], dtype=np.int32),
        W_indptr=np.arange(0, 9, 2, dtype=np.int32), shape=np.array([4, 4]),
        q=np.array([-1.0, -0.2, -1.0, -0.2]), mu=np.full(2, 0.5), dim=2, name="twice",
    )  # fmt: skip
    assert cli.main(["contact", str(path), "--least-norm", "--reaction", str(out)]) == 0
    facts = json.loads(capsys.readouterr().out)["determinacy"]
    assert not facts["unique"]
    assert facts["unique_contacts"] == 0
    assert facts["contacts_not_unique"] == [0, 1]
    assert facts["least_norm"] <= facts["norm_found"] * (1 + 1e-12)
    assert facts["least_norm_error"] <= 1e-9
    np.testing.assert_allclose(np.load(out), [0.5, 0.1, 0.5, 0.1], rtol=1e-8)


def test_contact_that_does_not_converge_has_its_code(shared_data, capsys):
    hard = shared_data / "fc" / "Capsules-i100-1090.npz"
    assert cli.main(["contact", str(hard), "--tol", "1e-40"]) == 2
    facts = json.loads(capsys.readouterr().out)
    assert facts["outcome"] in {"stalled", "max_iterations"}
    assert facts["error"] > 1e-40


def test_contact_tells_bad_settings_and_files(problem, tmp_path, capsys):
    assert cli.main(["contact", str(problem), "--solver", "magic"]) == 1
    methods = "'auto', 'interior_point', 'newton', 'nsgs'"
    assert f"expected one of {methods}" in capsys.readouterr().err
    assert cli.main(["contact", str(problem), "--solver", "admm"]) == 1
    assert "'admm' is gone" in capsys.readouterr().err
    assert cli.main(["contact", str(problem), "--threads", "2"]) == 1
    assert "choose method 'nsgs'" in capsys.readouterr().err
    assert cli.main(["contact", str(problem), "--solver", "nsgs", "--relaxation", "2.5"]) == 1
    assert "relaxation is 2.5, expected a number between 0 and 2" in capsys.readouterr().err
    assert cli.main(["contact", str(tmp_path / "no.npz")]) == 1
    error = capsys.readouterr().err
    assert "no.npz" in error
    assert "unexpected" not in error


# --- as a program -----------------------------------------------------------------------------


def test_help_loads_nothing_heavy():
    code = (
        "import sys, masonry_fem, masonry_fem.cli as cli\n"
        "try: cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'dolfinx', 'gmsh', 'pyvista', 'pint', 'rich', 'matplotlib'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "run" in done.stdout


def test_the_program_ends_with_its_code_and_no_traceback(tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text("dimension = 5\n")
    command = [sys.executable, "-m", "masonry_fem", "check", str(bad)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == f"masonry-fem: {bad}: the scene lacks the key 'materials' (a table)\n"


@pytest.mark.parametrize("command", ["check", "info"])
def test_a_reader_that_leaves_is_no_error(scene, command):
    """As in ``masonry-fem check ... | head -1``: no traceback, no crash report of PETSc."""
    words = [sys.executable, "-m", "masonry_fem", command, *([str(scene)] if command == "check" else [])]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.close()
        said = process.stderr.read()
    assert said == ""
    assert process.returncode == 141


def test_petsc_leaves_signals_alone(scene, runner, monkeypatch):
    monkeypatch.setenv("PETSC_OPTIONS", "-log_view")
    cli.main(["run", str(scene), "--quiet"])
    assert os.environ["PETSC_OPTIONS"] == "-log_view -no_signal_handler"


def test_yes_confirms_what_is_large(scene, monkeypatch, capsys):
    monkeypatch.setattr("masonry_fem.build.foresight.BLOCKS", 2)
    assert cli.main(["check", str(scene)]) == 1
    assert "structures.pier with count = 2 brings the scene to some 3 blocks" in capsys.readouterr().err
    assert cli.main(["check", str(scene), "--yes"]) == 0
