"""Terminals of any encoding and width, and signals: what a command says and how it ends."""

import contextlib
import gc
import importlib
import io
import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from masonry_fem import cli
from masonry_fem.cli import console
from masonry_fem.cli.signals import answered
from masonry_fem.nscd.mumps import petsc
from masonry_fem.output.terminal import print_summary

SCENE = """
title = "Gewölbe μ = ½ – σ₁"
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400 } }
structures = [{ kind = "stack", name = "säule", material = "stone", size = [1.0, 0.5], count = 2 }]
loads = { gravity = [0, -9.81] }
output = { pictures = false, fields = false }
"""


@pytest.mark.parametrize(
    ("settings", "title"),
    [
        ({"PYTHONIOENCODING": "ascii", "COLUMNS": "1"}, "Gewolbe mu = 12 - sigma1"),
        pytest.param(
            {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "COLUMNS": "0"},
            "Gewolbe mu",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            {"PYTHONIOENCODING": "latin-1", "COLUMNS": "none"},
            "Gewölbe mu = ½ - sigma1",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["ascii", "POSIX", "latin-1"],
)
def test_any_encoding_and_width(settings, title, tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    line = [sys.executable, "-m", "masonry_fem", "run", "scene.toml", "--out", "out"]
    encoding = settings.get("PYTHONIOENCODING", "ascii")
    done = subprocess.run(
        line, capture_output=True, encoding=encoding, check=False, timeout=120, cwd=tmp_path,
        env=os.environ | settings,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert title in done.stdout
    assert "equilibrium" in done.stdout
    assert "min normal reaction" in done.stdout  # not cut, however narrow
    line[-3:] = ["scene.toml", "--set", "structures.säule.count=0"]
    done = subprocess.run(
        line, capture_output=True, encoding=encoding, check=False, timeout=120, cwd=tmp_path,
        env=os.environ | settings,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "Error" not in done.stderr


@pytest.mark.parametrize(
    ("sign", "plain"),
    [
        ("ü", "u"),
        ("²", "2"),
        ("→", "->"),
        ("µ", "u"),
        ("Σ", "sigma"),
        ("‰", "?"),
        ("\udcff", "?"),
        ("\x85", "?"),
    ],
)
def test_signs_become_plain(sign, plain):
    console.speak_readably()
    assert sign.encode("ascii", errors="readable") == plain.encode()


def test_help_tells_all_exit_codes():
    told = {0, 1, 2, 3, console.INTERRUPTED, console.PIPE_CLOSED, 128 + 15, 128 + 1}
    top = cli.parser()
    pages = [top, *top._subparsers._group_actions[0].choices.values()]
    assert len(pages) == 1 + len(cli.COMMANDS)
    for page in pages:
        words = page.format_help().partition("Exit codes:")[2].replace(",", " ").split()
        assert told <= {int(word) for word in words if word.isdigit()}


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_signals_end_as_an_interrupt_does(number, monkeypatch, capsys):
    def command(options):
        os.kill(os.getpid(), number)
        return 0

    options = SimpleNamespace(command=command, debug=False, verbose=False)
    monkeypatch.setattr(cli, "parser", lambda: SimpleNamespace(parse_args=lambda _: options))
    before = signal.signal(number, signal.SIG_DFL)  # ignored where the tests run under nohup
    try:
        assert cli.main([]) == 128 + number
        assert signal.getsignal(number) == signal.SIG_DFL
    finally:
        signal.signal(number, before)
    assert capsys.readouterr().err == f"masonry-fem: interrupted by {signal.Signals(number).name}\n"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP], ids=lambda number: number.name)
def test_signals_end_a_run_whose_libraries_would_answer_them(number):
    """PETSc answers SIGTERM with a report of its crash; MPI's transport takes SIGHUP, and the run goes on."""
    if petsc() is None:
        pytest.skip("without PETSc nothing answers them")
    script = f"""
        import os, signal, time
        from types import SimpleNamespace
        from masonry_fem import cli
        def command(options):
            from masonry_fem.nscd.mumps import petsc
            petsc()
            os.kill(os.getpid(), {int(number)})
            time.sleep(1)
        signal.signal({int(number)}, signal.SIG_DFL)
        options = SimpleNamespace(command=command, debug=False, verbose=False)
        cli.parser = lambda: SimpleNamespace(parse_args=lambda _: options)
        raise SystemExit(cli.main([]))
    """
    words = [sys.executable, "-c", textwrap.dedent(script)]
    process = subprocess.run(words, capture_output=True, text=True, check=False)
    assert process.returncode == 128 + number
    assert process.stderr == f"masonry-fem: interrupted by {number.name}\n"


def test_a_command_that_keeps_what_it_knows_has_the_signals_code(monkeypatch):
    """A search for a collapse ends by itself, with the code of an interrupt."""

    def command(options):
        try:
            os.kill(os.getpid(), signal.SIGTERM)
        except KeyboardInterrupt:
            return console.INTERRUPTED

    options = SimpleNamespace(command=command, debug=False, verbose=False)
    monkeypatch.setattr(cli, "parser", lambda: SimpleNamespace(parse_args=lambda _: options))
    assert cli.main([]) == 143


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
def test_a_signal_that_comes_while_something_is_thrown_away_is_not_lost(number):
    """Python tells of exceptions in ``__del__`` and forgets them."""

    class Thrown:
        def __del__(self):
            signal.raise_signal(number)

    def wait(thing):
        del thing
        time.sleep(10)

    with answered(), pytest.raises(KeyboardInterrupt):
        wait(Thrown())


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
def test_an_error_that_a_signal_became_is_an_end(number, monkeypatch, capsys):
    """A signal that comes while a compiled function makes its result is the cause of a SystemError."""

    def command(options):
        try:
            signal.raise_signal(number)
        except KeyboardInterrupt as ended:
            raise SystemError("returned a result with an exception set") from ended

    options = SimpleNamespace(command=command, debug=False, verbose=False)
    monkeypatch.setattr(cli, "parser", lambda: SimpleNamespace(parse_args=lambda _: options))
    assert cli.main([]) == 128 + number
    by = "" if number == signal.SIGINT else f" by {number.name}"
    assert capsys.readouterr().err == f"masonry-fem: interrupted{by}\n"


def test_what_a_signal_left_half_made_goes_in_silence():
    """LLVM's objects look for what their constructors would have made, as they are thrown away."""

    class Made:
        def __init__(self, number):
            self.itself = self
            if number is not None:
                signal.raise_signal(number)
            self.handle = 1

        def __del__(self):
            del self.handle

    class Wrong(Made):
        def __init__(self):
            """Make nothing."""

    def thrown_away(number):
        with contextlib.suppress(KeyboardInterrupt):
            Made(number)

    told = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "unraisablehook", lambda what: told.append(type(what.exc_value)))
        with answered() as received:
            Wrong()
            assert told == [AttributeError]  # nothing was interrupted yet
            thrown_away(signal.SIGINT)
        assert received.came
        gc.collect()
    assert told == [AttributeError]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
def test_a_signal_waits_until_a_module_is_loaded(number, tmp_path, monkeypatch):
    """A library in C that loads others may crash where one of them ends with an exception (VTK does)."""
    name = f"loaded_at_{number.name}"
    (tmp_path / f"{name}.py").write_text(
        f"import signal\nsignal.raise_signal({int(number)})\nloaded = True\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(tmp_path)

    def load_and_wait():
        importlib.import_module(name)
        time.sleep(10)

    begun = time.monotonic()
    with answered() as received, pytest.raises(KeyboardInterrupt):
        load_and_wait()
    assert time.monotonic() - begun < 10  # what waits by then is interrupted
    assert received.number == number
    assert sys.modules.pop(name).loaded


@pytest.mark.parametrize(("asked", "settings"), [(["--no-color"], {}), ([], {"NO_COLOR": "1"}), ([], {})])
def test_colours_go_when_they_are_not_wanted(asked, settings, monkeypatch):
    """On a terminal that shows colours; bold letters stay."""
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("TERM", "xterm-256color")
    shown = io.StringIO()

    def command(options):
        made = Console(file=shown, force_terminal=True)
        print_summary({"outcome": "equilibrium", "message": "It stands."}, made)
        return 0

    options = cli.parser().parse_args(["info", *asked])
    options.command = command
    monkeypatch.setattr(cli, "parser", lambda: SimpleNamespace(parse_args=lambda _: options))
    assert cli.main([]) == 0
    coloured = re.search(r"\x1b\[[0-9;]*3[0-7]m", shown.getvalue()) is not None
    assert coloured == (not asked and not settings)
    os.environ.pop("NO_COLOR", None)


def test_long_messages_are_broken_between_words_on_terminals_only(monkeypatch):
    sentence = "masonry-fem: structures.s.path " + "is a word of several words " * 6 + "x" * 90
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("sys.stderr", io.StringIO())
    assert console.fitted(sentence) == sentence
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    told = console.fitted(sentence)
    assert " ".join(told.split()) == sentence
    assert all(len(line) <= 80 for line in told.splitlines()[:-1])
    assert told.splitlines()[-1].strip() == "x" * 90, "a path stays whole"
