"""tools/mutations.py: what it changes in the lines of mechanics, without running tests on it."""

import ast
import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def tool():
    from tests.conftest import REPOSITORY

    spec = importlib.util.spec_from_file_location("mutations", REPOSITORY / "tools" / "mutations.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["mutations"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["mutations"]


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
HALF = 0.5

def plain(a):
    if a > HALF:
        return (a
                - HALF)
    return -a

@njit(cache=True)
def compiled(a):
    return -a
"""


@pytest.mark.parametrize(
    ("line", "expected"),
    [(2, ({2}, True)), (5, ({5}, False)), (7, ({6, 7}, False)), (8, ({8}, False)), (12, ({12}, True))],
)
def test_a_statement_is_all_its_lines_or_only_its_head(tool, line, expected):
    """Who runs what is compiled, or run on import, cannot be seen."""
    assert tool._statement(SOURCE, line) == expected


TESTS = """
from masonry_fem.thing import plain

def test_one():
    assert plain(1.0) == 0.5

def test_other():
    assert plain(0.0) == 0.0
"""


def test_the_tests_that_come_to_a_line_are_found_and_one_fails(tool, tmp_path):
    copy = tmp_path / "project"
    (copy / "masonry_fem").mkdir(parents=True)
    (copy / "tests").mkdir()
    (copy / "tools").mkdir()
    source = SOURCE.split("\n@njit", maxsplit=1)[0]
    (copy / "masonry_fem/__init__.py").touch()
    (copy / "masonry_fem/thing.py").write_text(source)
    (copy / "tests/test_thing.py").write_text(TESTS)
    plugin = Path(tool.__file__).with_name("touched.py")
    (copy / "tools/touched.py").write_text(plugin.read_text(encoding="utf-8"))
    (copy / "pytest.ini").write_text("[pytest]\nmarkers = slow: takes long\n")
    tests = tool.Tests(tmp_path)
    one = tool.Mutation("masonry_fem/thing.py", 7, 16, 17, "-", "+", "- HALF)")
    chosen = tests.touching(one, ("tests",))
    assert chosen == ["tests/test_thing.py::test_one"]
    assert tests.failing(chosen, one) == ""
    (copy / one.file).write_text(source.replace("- HALF", "+ HALF"))
    assert tests.failing(chosen, one) == chosen[0]


def test_the_table_names_what_nobody_noticed(tool):
    told = [
        {"file": "masonry_fem/march/loads.py", "code": "a + b", "old": "+", "new": "-", "noticed": "t"},
        {"file": "masonry_fem/march/step.py", "code": "max(a, b)", "old": "max", "new": "min", "noticed": ""},
    ]
    text = tool.table(told)
    assert "| `march` | 2 | 1 |" in text
    assert "- `masonry_fem/march/step.py`, `max(a, b)`: `max` → `min`" in text
