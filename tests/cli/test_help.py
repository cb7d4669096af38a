"""Help: each command has examples that are understood, and shells complete what can be typed."""

import shlex
import shutil
import subprocess

import pytest

from masonry_fem import cli
from masonry_fem.cli import completion, new
from masonry_fem.cli.grammar import overrides_of
from masonry_fem.scene import load
from masonry_fem.structures import kinds

EXAMPLES = [line for command in cli.COMMANDS for _, line in command.EXAMPLES]


def test_every_command_has_examples_in_its_help():
    top = cli.parser()
    pages = top._subparsers._group_actions[0].choices
    assert len(pages) == len(cli.COMMANDS)
    for (name, page), command in zip(pages.items(), cli.COMMANDS, strict=True):
        assert command.EXAMPLES
        for what, line in command.EXAMPLES:
            assert line.startswith(f"masonry-fem {name}")
            assert f"  # {what}\n  {line}\n" in page.format_help()


@pytest.mark.parametrize("line", EXAMPLES)
def test_examples_are_understood(line, repository, monkeypatch):
    """By the parser, and the scene that they name with what they change in it."""
    monkeypatch.chdir(repository)
    words = shlex.split(line.replace("\\\n", " ").partition(" > ")[0])[1:]
    options = cli.parser().parse_args(words)
    assert callable(options.command)
    if "scene" in options:
        load(options.scene, overrides_of(options))


@pytest.mark.parametrize("line", [line for _, line in new.EXAMPLES])
def test_examples_without_a_scene_run(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(shlex.split(line)[1:]) == 0
    load(tmp_path / capsys.readouterr().out.split()[1])


@pytest.mark.parametrize("shell", completion.SHELLS)
def test_a_script_is_printed_for_each_shell(shell, capsys):
    assert cli.main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "masonry-fem" in script
    for name in ("threshold", "refine-to", "elliptical_arch"):
        assert name in script


def test_a_shell_without_a_script_is_bad_input(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main(["completion", "cmd"])
    assert ended.value.code == 1
    assert "bash" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["thr"], {"threshold"}),
        (["run", "--ref"], {"--refine-to"}),
        (["run", "wa"], {"wall.toml"}),
        (["new", "dom"], {kind for kind in kinds() if kind.startswith("dom")}),
        (["explain", "output.rep"], {"output.report"}),
        (["contact", "--solver", "ns"], {"nsgs"}),
        (["report", "res"], {"results"}),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bash_completes(typed, offered, tmp_path, capsys):
    assert cli.main(["completion", "bash"]) == 0
    (tmp_path / "script").write_text(capsys.readouterr().out, encoding="utf-8")
    (tmp_path / "wall.toml").touch()
    (tmp_path / "wall.py").touch()
    (tmp_path / "results").mkdir()
    words = " ".join(shlex.quote(word) for word in ["masonry-fem", *typed])
    code = (
        f"source ./script; COMP_WORDS=({words}); COMP_CWORD={len(typed)}; COMP_LINE='{words}'; "
        f"_shtab_masonry_fem masonry-fem {shlex.quote(typed[-1])}; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    )
    done = subprocess.run(
        ["bash", "--norc", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60
    )
    assert {line for line in done.stdout.split("\n") if line} == offered, done.stderr
