"""Searches of many runs say what they do not write although the scene asks for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.study import study
from masonry_fem.analyses.threshold import threshold
from masonry_fem.scene import load
from tests.analyses.test_collapse import PIER


def search(path: Path, kind: str) -> list[str]:
    """What a search says besides its numbers."""
    out = path.parent / "out"
    if kind == "a study":
        return list(study(path, {"joints.0.friction": [0.4]}, out=out, workers=1).notes)
    if kind == "a search for a threshold":
        return list(threshold(path, "joints.0.friction", (0.4, 0.5), out=out).summary.notes)
    return list(collapse(load(path), acceleration="x", tolerance=0.5).summary.notes)


@pytest.mark.parametrize("kind", ["a study", "a search for a threshold", "a search for collapse"])
def test_a_report_that_no_search_writes(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "pier.toml"
    path.write_text(PIER + "\n[output]\nreport = true\n")
    (said,) = (one for one in search(path, kind) if "output.report" in one)
    assert f"not {kind}" in said
    assert not list(tmp_path.rglob("report.html"))
    path.write_text(PIER)
    assert not any("output.report" in one for one in search(path, kind))
