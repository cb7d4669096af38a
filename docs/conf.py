"""Sphinx: ``sphinx-build docs docs/_build`` after ``pip install -e '.[docs]'``."""

import sys
from pathlib import Path

from masonry_fem import __version__

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

project = "masonry_fem"
author = "The masonry_fem developers"
release = __version__
extensions = ["myst_parser", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["_build", "demos/*.py", "demos/*.ipynb", "demos/*.md5"]
html_theme = "furo"
html_title = f"masonry_fem {release}"
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
