"""Results folders: one writer at a time, old files gone before new ones, nothing of a user's touched."""

import json
import multiprocessing
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from masonry_fem.analyses.run import run
from masonry_fem.errors import OutputError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.output.folder import Folder, listed, refuse_busy, unfinished, writer_of
from masonry_fem.scene import load

SCENE = """
title = "pier"
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400 } }
structures = [{ kind = "stack", name = "pier", material = "stone", size = [1.0, 0.5], count = 2 }]
loads = { gravity = [0, -9.81] }
output = { pictures = false }
"""


def outcome(out: Path) -> str:
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))["outcome"]


def names(out: Path) -> set[str]:
    return {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()} - {
        ".masonry-fem/lock", ".masonry-fem/run", ".masonry-fem/view"
    }  # fmt: skip


def test_it_says_running_until_it_is_done(tmp_path):
    with Folder(tmp_path, "run", title="arch"):
        told = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
        assert told["outcome"] == "running"
        assert told["pid"] == os.getpid()
        assert writer_of(tmp_path) == str(os.getpid())
        assert "is still writing" in unfinished(tmp_path)
        write_atomic(tmp_path / "summary.json", b'{"outcome": "equilibrium"}')
    assert outcome(tmp_path) == "equilibrium"
    assert writer_of(tmp_path) == ""
    assert unfinished(tmp_path) == ""


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (KeyboardInterrupt(), "interrupted"),
        (OutputError("no room"), "failed"),
        (ZeroDivisionError(), "failed"),
    ],
)
def test_an_end_before_the_end_is_told(tmp_path, error, said):
    with pytest.raises(type(error)), Folder(tmp_path, "run"):
        raise error
    assert outcome(tmp_path) == said


def test_a_study_says_running_until_its_cells_are_computed(tmp_path):
    with Folder(tmp_path, "study", title="arch"):
        told = json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))
        assert (told["title"], told["outcome"]) == ("arch", "running")
        assert "is still writing" in unfinished(tmp_path, "study.json")
    assert not (tmp_path / "study.json").exists()  # Study.write tells it later
    with pytest.raises(OutputError), Folder(tmp_path, "study"):
        raise OutputError("no room")
    assert json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))["outcome"] == "failed"


def test_an_end_while_old_files_go_leaves_the_word_running(tmp_path, monkeypatch):
    with Folder(tmp_path, "run"):
        write_atomic(tmp_path / "history.csv", b"old")
    with monkeypatch.context() as patch:
        patch.setattr(Folder, "_remove", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            Folder(tmp_path, "run").__enter__()
    assert outcome(tmp_path) == "running"  # files of the older run may be left
    with Folder(tmp_path, "run"):
        assert names(tmp_path) == {"summary.json"}


def test_own_old_files_go_and_a_users_stay(tmp_path):
    with Folder(tmp_path, "run"):
        write_atomic(tmp_path / "fields" / "blocks_000001.vtu", b"old")
        write_atomic(tmp_path / "history.csv", b"old")
    with Folder(tmp_path, "view"):
        write_atomic(tmp_path / "deformed.png", b"old")
    with Folder(tmp_path, "collapse"):
        write_atomic(tmp_path / "trials.csv", b"of another command")
        write_atomic(tmp_path / "collapse.json", b"{}")
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "fields" / "mine.vtu").write_text("mine")
    (tmp_path / "history.csv.part").write_bytes(b"half")
    kept = {"notes.txt", "fields/mine.vtu", "trials.csv", "collapse.json", ".masonry-fem/collapse"}
    with Folder(tmp_path, "run", clears=("view",)):
        assert names(tmp_path) == kept | {"summary.json"}
        assert outcome(tmp_path) == "running"
    (tmp_path / "fields" / "mine.vtu").unlink()
    with Folder(tmp_path, "run"):
        write_atomic(tmp_path / "fields" / "blocks_000001.vtu", b"new")
    with Folder(tmp_path, "run"):
        pass
    assert not (tmp_path / "fields").exists()


def test_a_file_belongs_to_who_wrote_it_last(tmp_path):
    for command in ("run", "collapse"):
        with Folder(tmp_path, command):
            write_atomic(tmp_path / "mechanism.png", command.encode())
    with Folder(tmp_path, "run"):
        assert (tmp_path / "mechanism.png").read_bytes() == b"collapse"
    with Folder(tmp_path, "collapse"):
        assert not (tmp_path / "mechanism.png").exists()


def test_a_list_leads_nowhere_else(tmp_path):
    out, other = tmp_path / "out", tmp_path / "other"
    other.write_text("not here")
    with Folder(out, "run"):
        pass
    (out / ".masonry-fem" / "run").write_text(f"../other\n{other}\nfields/../../other\nhistory.csv\n")
    assert listed(out / ".masonry-fem" / "run") == ["history.csv"]
    with Folder(out, "run"):
        pass
    assert other.read_text() == "not here"


def _hold(out, pipe):
    with Folder(out, "run"):
        pipe.send("holds")
        pipe.poll(60)


@pytest.fixture
def holder(tmp_path):
    """Another process that writes to a folder, until the pipe to it is closed.

    A test may kill it: whoever sets an event waits for ever for the dead who waited for it.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_hold, args=(tmp_path / "out", theirs))
    process.start()
    theirs.close()
    assert ours.poll(60)
    assert ours.recv() == "holds"
    yield tmp_path / "out", process
    ours.close()
    process.join()


def test_a_second_writer_is_refused_and_a_killed_one_blocks_nobody(holder):
    out, process = holder
    for attempt in (lambda: refuse_busy(out), lambda: Folder(out, "run").__enter__()):
        with pytest.raises(OutputError, match=rf"out' is being written by process {process.pid};.*--out"):
            attempt()
    assert outcome(out) == "running"
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    assert "was killed before its end" in unfinished(out)
    refuse_busy(out)
    with Folder(out, "run"):
        write_atomic(out / "summary.json", b'{"outcome": "finished"}')
    assert outcome(out) == "finished"


def command(*arguments, **keys):
    line = [sys.executable, "-m", "masonry_fem", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, check=False, timeout=120, **keys)


def test_the_command_line_says_who_writes(holder, tmp_path):
    out, process = holder
    (tmp_path / "pier.toml").write_text(SCENE)
    done = command("run", tmp_path / "pier.toml", "--out", out)
    assert done.returncode == 1
    assert done.stderr == (
        f"masonry-fem: results folder '{out}' is being written by process {process.pid}; "
        "wait for its end, or choose another folder with --out\n"
    )


def test_a_file_without_room_is_one_sentence(tmp_path):
    """A limit on the size of files, which the system enforces as it does a full disk."""
    (tmp_path / "pier.toml").write_text(SCENE)
    run(load(tmp_path / "pier.toml"), tmp_path / "out")
    before = names(tmp_path / "out")
    assert "history.csv" in before

    def small():
        resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))

    # Python would cut off what it keeps of modules, too, and others could not load it
    kept = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    done = command("run", tmp_path / "pier.toml", "--out", tmp_path / "out", preexec_fn=small, env=kept)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "cannot be written: File too large; free some space, or choose another place" in done.stderr
    assert names(tmp_path / "out") <= {"summary.json", "history.csv", "as_run.toml"}
    assert (tmp_path / "out" / "history.csv").read_bytes() == b""  # no half line
    assert outcome(tmp_path / "out") == "failed"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_one_sentence(tmp_path):
    (tmp_path / "out").mkdir(mode=0o555)
    with pytest.raises(OutputError, match=r"out/.masonry-fem' cannot be made: Permission denied"):
        Folder(tmp_path / "out", "run").__enter__()


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "summary.json"
    write_atomic(path, b"old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        write_atomic(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_view_and_study_say_that_a_run_was_killed(tmp_path, caplog):
    pytest.importorskip("pyvista")
    from masonry_fem.analyses.study.reference import Reference
    from masonry_fem.errors import MasonryError
    from masonry_fem.output.view import view

    dies = "import os, sys\nfrom pathlib import Path\nfrom masonry_fem.output.folder import Folder\n"
    dies += "with Folder(Path(sys.argv[1]), 'run', title='pier'):\n    os.kill(os.getpid(), 9)\n"
    assert subprocess.run([sys.executable, "-c", dies, str(tmp_path)], check=False).returncode == -9
    with pytest.raises(MasonryError, match=r"blocks.pvd: no such file"):
        view(tmp_path, tmp_path)
    assert "was killed before its end" in caplog.text
    with pytest.raises(MasonryError, match=r"--reference .* was killed before its end; .* run it again"):
        Reference.parse([str(tmp_path)], ())
