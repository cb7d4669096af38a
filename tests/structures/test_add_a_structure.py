"""docs/add_a_structure.md followed literally: its file in the folder is a structure wherever it matters."""

import json
import os
import re
import subprocess
import sys

import pytest

# the folder is looked into at the first scene: a further place stands for a file that was put there
WITH_FOLDER = """
import sys
import masonry_fem.structures
masonry_fem.structures.__path__.append({folder!r})
"""
COMMAND = "from masonry_fem.cli import main\nsys.exit(main({arguments!r}))"


@pytest.fixture(scope="module")
def folder(repository, tmp_path_factory):
    """Where a reader of the page has copied its blocks."""
    page = (repository / "docs/add_a_structure.md").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"`([\w./]+)`:\n\n```(?:python|toml)\n(.*?)```", page, re.S))
    assert list(blocks) == ["masonry_fem/structures/cairn.py", "cairn.toml"]
    folder = tmp_path_factory.mktemp("structures")
    for name, block in blocks.items():
        (folder / name.rpartition("/")[2]).write_text(block, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def said(folder, repository):
    """What a program says, with the page's file among the structures."""

    def run(code, **names):
        whole = WITH_FOLDER.format(folder=str(folder)) + code.format(**names)
        done = subprocess.run(
            [sys.executable, "-c", whole], cwd=folder, capture_output=True, text=True, check=False,
            env={**os.environ, "PYTHONPATH": str(repository)},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


def test_a_scene_has_it(said):
    text = said(COMMAND, arguments=["check", "cairn.toml"])
    assert re.search(r"^blocks +4 *$", text, re.M)
    assert re.search(r"^interfaces +3 *$", text, re.M)


@pytest.mark.slow
def test_it_stands(said, folder):
    said(COMMAND, arguments=["run", "cairn.toml", "--out", "out"])
    summary = json.loads((folder / "out/summary.json").read_text(encoding="utf-8"))
    volume = 1.0 * 0.8 * 0.3 * sum(0.9 ** (3 * k) for k in (1, 2, 3))
    assert summary["supports"]["cairn.b1"]["force"][2] == pytest.approx(2400 * 9.81 * volume, rel=1e-9)
