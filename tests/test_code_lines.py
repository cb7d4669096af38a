"""tools/code_lines.py: what counts as a line of code and as a decision."""

import subprocess
import sys

SOURCE = '''"""Docstring,
over two lines.
"""

import os  # a comment behind code


def plain(a):
    """A function's docstring."""
    text = """kept: no docstring,
    but a value
    """

    # a comment by itself
    return (
        a,
        text,
    )


def branchy(values, table):
    """Thirteen: one, and twelve decisions."""
    for value in values:
        if value and table or os:
            while value:
                value -= 1
        elif not value:
            assert table
    try:
        found = [v if v else 0 for v in values if v]
    except ValueError:
        found = []
    match found:
        case []:
            return 0
        case _:
            return 1
'''


def count(repository, *arguments):
    script = repository / "tools" / "code_lines.py"
    return subprocess.run(
        [sys.executable, script, *arguments], capture_output=True, text=True, check=False, cwd=repository
    )


def test_lines_and_branches_are_counted_by_room(repository, tmp_path):
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "file.py").write_text(SOURCE)
    (tmp_path / "__init__.py").write_text('"""Nothing but a docstring."""\n')
    done = count(repository, tmp_path, "--name")
    rows = done.stdout.splitlines()
    assert "| room | 1 | 25 | 1 |" in rows
    assert "| (top) | 1 | 0 | 0 |" in rows
    assert "| **all** | 2 | 25 | 1 |" in rows
    assert rows[-1] == f"{tmp_path / 'room' / 'file.py'}:21: branchy, 13"


def test_a_folder_without_python_is_refused(repository, tmp_path):
    done = count(repository, tmp_path)
    assert done.returncode == 1
    assert "expected a package's folder" in done.stderr
    assert "Traceback" not in done.stderr
