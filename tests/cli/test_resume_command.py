"""Command ``resume``: what it does, says and returns."""

import pytest

from masonry_fem.cli import main

SCENE = """
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400 } }
structures = [{ kind = "stack", name = "pier", material = "stone", size = [1.0, 0.5], count = 2 }]
loads = { gravity = [0.0, -9.81] }
analysis = { kind = "dynamics", step = 0.01, duration = 0.05 }
output = { pictures = false, fields = false, checkpoint_steps = 2 }
"""


@pytest.fixture
def done(tmp_path):
    """The folder of a run that has come to its end."""
    (tmp_path / "pier.toml").write_text(SCENE, encoding="utf-8")
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "pier.toml"), "--out", str(out), "--quiet"]) == 0
    return out


def test_a_run_that_is_done_is_told_so_with_its_exit_code(done, capsys):
    assert main(["resume", str(done)]) == 0
    assert "has come to its end (finished), nothing is left to do" in capsys.readouterr().out


def test_more_steps_are_made(done, capsys):
    assert main(["resume", str(done), "--set", "analysis.duration=0.1"]) == 0
    assert "history.csv" in capsys.readouterr().out
    assert len((done / "history.csv").read_text(encoding="utf-8").splitlines()) == 11


def test_what_does_not_fit_is_one_line(done, capsys):
    assert main(["resume", str(done), "--set", "joints.0.friction=0.3"]) == 1
    said = capsys.readouterr().err
    assert "joints was" in said or "joints.0.friction was" in said
    assert "Traceback" not in said


@pytest.mark.parametrize("name", ["", "nowhere", "scene.toml"], ids=["folder", "nothing", "file"])
def test_what_has_no_checkpoint_is_told(tmp_path, name, capsys):
    (tmp_path / "scene.toml").touch()
    assert main(["resume", str(tmp_path / name)]) == 1
    assert "has no checkpoint.npz, expected the results folder of a run" in capsys.readouterr().err


def test_an_interrupted_run_says_how_it_goes_on(tmp_path, capsys, monkeypatch):
    from masonry_fem.output.history import History

    def ended(self, model, state, report):
        raise KeyboardInterrupt

    (tmp_path / "pier.toml").write_text(SCENE, encoding="utf-8")
    out = tmp_path / "out"
    with monkeypatch.context() as patched:
        patched.setattr(History, "record", ended)
        assert main(["run", str(tmp_path / "pier.toml"), "--out", str(out), "--quiet"]) == 130
    assert "masonry-fem resume" in (out / "summary.json").read_text(encoding="utf-8")
    assert main(["resume", str(out), "--quiet"]) == 0
