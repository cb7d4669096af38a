"""Sphinx: ``sphinx-build docs docs/_build`` after ``pip install -e '.[docs]'``."""

import re
import sys
from pathlib import Path
from typing import Any

from masonry_fem import __version__

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

project = "masonry_fem"
author = "The masonry_fem developers"
release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["_build", "demos/*.py", "demos/*.ipynb", "demos/*.md5"]
html_theme = "furo"
html_title = f"masonry_fem {release}"
html_static_path = ["_static"]
html_css_files = ["narrow.css"]
myst_heading_anchors = 2
suppress_warnings = ["config.cache"]
sphinx_gallery_conf = {
    "examples_dirs": str(ROOT / "demos"),
    "gallery_dirs": "demos",
    "filename_pattern": r"\.py$",
    "plot_gallery": "False",  # the pictures are in docs/images (make_images.py); building needs no DOLFINx
    "download_all_examples": False,
    "copyfile_regex": r".*\.toml",
}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True


ENTRY = re.compile(r"(?:^|(?<=[.;\]]) )(\w+(?:, \w+)*) : ")  # name : meaning, one or several a line


def sections_as_lists(*event: Any) -> None:
    """Parameters, Returns, Raises ... of docstrings as lists; an entry goes on in indented lines."""
    lines: list[str] = event[-1]
    made: list[str] = []
    inside = False
    for line, after in zip(lines, [*lines[1:], ""], strict=True):
        if line and after and set(after) == {"-"}:
            made += [f"**{line}**", ""]
            inside = True
        elif set(line) == {"-"}:
            continue
        elif inside and line.startswith(" "):
            made[-1] += f" {line.strip()}"
        elif inside and line:
            made.append(f"- {line}")
        else:
            made.append(line)
    lines[:] = "\n".join(as_entries(line) for line in made).split("\n")


def as_entries(line: str) -> str:
    """A list's line with an item for each of its entries; other lines as they are."""
    if not line.startswith("- "):
        return line
    return "- " + ENTRY.sub(r"\n- ``\1``: ", line[2:]).removeprefix("\n- ")


def setup(app: Any) -> None:
    """Have Sphinx show docstrings so."""
    app.connect("autodoc-process-docstring", sections_as_lists)
