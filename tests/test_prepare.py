"""tools/prepare on machines that lack something: one sentence with the cure, nothing made."""

import os
import shutil
import subprocess

import pytest


@pytest.fixture
def bare_machine(tmp_path, repository):
    """A copy of the installer beside a PATH that holds the plainest commands only."""
    (tmp_path / "tools").mkdir()
    shutil.copy(repository / "tools" / "prepare", tmp_path / "tools" / "prepare")
    commands = tmp_path / "bin"
    commands.mkdir()
    for name in ("sh", "dirname", "rm", "sed"):
        (commands / name).symlink_to(shutil.which(name))

    def add(name: str, script: str) -> None:
        (commands / name).write_text(f"#!{shutil.which('sh')}\n{script}\n")
        (commands / name).chmod(0o755)

    def prepare(*, linked: bool = False) -> str:
        done = subprocess.run(
            [commands / "sh", tmp_path / "tools" / "prepare", "fenicsx"],
            env={"PATH": str(commands), "LC_ALL": os.environ.get("LC_ALL", "C.UTF-8")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 1
        assert (tmp_path / ".venv").exists() == linked
        assert "Traceback" not in done.stdout + done.stderr
        return done.stderr.strip()

    return add, prepare


def test_an_environment_of_another_checkout(bare_machine, tmp_path):
    _, prepare = bare_machine
    other = tmp_path / "other"
    (other / ".venv" / "bin").mkdir(parents=True)
    (other / "tools").mkdir()
    (other / "tools" / "prepare").touch()
    (tmp_path / ".venv").symlink_to(other / ".venv")
    message = prepare(linked=True)
    assert message.startswith(f"masonry_fem: .venv is a symbolic link to that of {other}, ")
    assert "rm .venv" in message
    assert "\n" not in message
    assert not list((other / ".venv" / "bin").iterdir())


def test_a_link_to_an_environment_of_its_own(bare_machine, tmp_path):
    """It is somewhere else, as on a larger disk: what is missing next is told."""
    _, prepare = bare_machine
    (tmp_path / "disk" / "venv").mkdir(parents=True)
    (tmp_path / ".venv").symlink_to(tmp_path / "disk" / "venv")
    assert prepare(linked=True).startswith("masonry_fem: no C compiler (cc)")


def test_no_compiler(bare_machine):
    _, prepare = bare_machine
    message = prepare()
    assert message.startswith("masonry_fem: no C compiler (cc)")
    assert "apt install gcc" in message
    assert "\n" not in message


def test_no_python(bare_machine):
    add, prepare = bare_machine
    add("cc", "exit 0")
    message = prepare()
    assert "found no python3, expected Python 3.12 or newer" in message
    assert "make PYTHON=" in message
    assert "\n" not in message


def test_old_python(bare_machine):
    add, prepare = bare_machine
    add("cc", "exit 0")
    add("python3", 'if [ "$1" = --version ]; then echo Python 3.11.2; else exit 1; fi')
    message = prepare()
    assert "found Python 3.11.2, expected Python 3.12 or newer" in message
    assert "\n" not in message


def test_python_without_venv(bare_machine):
    add, prepare = bare_machine
    add("cc", "exit 0")
    add("python3.13", 'case "$1" in -m) echo no ensurepip; exit 1;; --version) echo Python 3.13.5;; esac')
    message = prepare()
    assert message.splitlines()[0] == "no ensurepip"
    assert "apt install python3-venv" in message.splitlines()[-1]
