"""tools/mutations.py: what it changes in the lines of mechanics, and which tests it runs on that."""

import ast
import importlib.util
import os
import shutil
import subprocess
import sys

import pytest


@pytest.fixture(scope="module")
def tool():
    from tests.conftest import REPOSITORY

    spec = importlib.util.spec_from_file_location("mutations", REPOSITORY / "tools" / "mutations.py")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(REPOSITORY / "tools"))  # where `touched` is
    sys.modules["mutations"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["mutations"]
    sys.path.remove(str(REPOSITORY / "tools"))


def test_every_room_has_its_files_and_tests(tool, repository):
    for files, tests in tool.ROOMS.items():
        assert [name for name in files if not (repository / f"masonry_fem/{name}.py").exists()] == []
        assert [name for name in tests if not (repository / name).exists()] == []


def test_each_mutation_changes_one_place_and_still_parses(tool, repository):
    chosen = tool.sample(200, seed=3)
    assert len({(one.file, one.line, one.start, one.new) for one in chosen}) == 200
    assert len({one.file for one in chosen}) == sum(map(len, tool.ROOMS))
    for one in chosen:
        lines = (repository / one.file).read_text(encoding="utf-8").splitlines()
        line = lines[one.line - 1].encode()
        assert line[one.start : one.end].decode() == one.old != one.new
        lines[one.line - 1] = (line[: one.start] + one.new.encode() + line[one.end :]).decode()
        assert ast.dump(ast.parse("\n".join(lines))) != ast.dump(
            ast.parse((repository / one.file).read_text(encoding="utf-8"))
        )


def test_the_same_seed_gives_the_same_mutations(tool):
    assert tool.sample(20, seed=1) == tool.sample(20, seed=1) != tool.sample(20, seed=2)


SOURCE = """
from numba import njit as compiled
HALF = 0.5

def plain(a):
    if a > HALF:
        return (a
                - HALF)
    return -a

@compiled
def turned(a):
    return -a
"""
TESTS = """
from masonry_fem.thing import plain, turned

def test_one():
    assert plain(1.0) == 0.5

def test_other():
    assert plain(-1.0) == 1.0

def test_turned():
    assert turned(1.0) == -1.0
"""
ASKED = """
from pathlib import Path
import mutations

tests = mutations.Tests(Path("memory").resolve())
for change in [(8, 16, 17, "-", "+"), (9, 11, 12, "-", "+"), (13, 11, 12, "-", ""), (6, 9, 10, ">", ">=")]:
    print(tests.noticed(mutations.Mutation("masonry_fem/thing.py", *change, ""), ("tests",)))
"""


@pytest.mark.parametrize(("line", "expected"), [(3, None), (6, {6}), (8, {7, 8}), (9, {9}), (13, {13})])
def test_a_statement_is_all_its_lines_or_only_its_head(tool, line, expected):
    assert tool._statement(SOURCE, line) == expected


@pytest.mark.slow
def test_the_tests_that_come_to_a_line_are_asked(repository, tmp_path):
    """A project of one file: each change is seen by its own test, and the last makes no difference."""
    for name, text in {
        "pyproject.toml": "[tool.pytest.ini_options]\nmarkers = ['slow: takes long']\n",
        "masonry_fem/__init__.py": "",
        "masonry_fem/thing.py": SOURCE,
        "tests/test_thing.py": TESTS,
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "tools").mkdir()
    for name in ("mutations", "touched"):
        shutil.copy(repository / f"tools/{name}.py", tmp_path / "tools")
    for command in (["git", "init", "-q"], ["git", "add", "."]):
        subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run(
        [sys.executable, "-c", ASKED], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path / "tools")},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    named = [f"tests/test_thing.py::test_{name}" for name in ("one", "other", "turned")]
    assert done.stdout.splitlines() == [*named, ""], done.stderr


def test_the_table_names_each_with_what_noticed_it(tool):
    told = [
        {"file": "masonry_fem/march/step.py", "code": "max(a, b)", "old": "max", "new": "min", "noticed": ""},
        {"file": "masonry_fem/march/loads.py", "code": "a + b", "old": "+", "new": "-",
         "noticed": "tests/march/test_march.py::test_loads"},
    ]  # fmt: skip
    assert tool.table(told).splitlines() == [
        "1 of 2 were noticed.",
        "",
        "| file | line | change | noticed by |",
        "|---|---|---|---|",
        "| `march/loads.py` | `a + b` | `+` → `-` | `test_loads` |",
        "| `march/step.py` | `max(a, b)` | `max` → `min` | **nothing**: a hole |",
    ]
