"""The map of stability: its page has every extreme, and nothing in it is silent."""

from __future__ import annotations

import sys

import pytest


@pytest.fixture(scope="module")
def making(repository):
    """The scripts that make the map."""
    sys.path.insert(0, str(repository / "docs"))
    import make_stability
    import stability_map

    yield make_stability, stability_map
    sys.path.remove(str(repository / "docs"))


def test_page_has_every_extreme_and_picture(making, repository):
    _, extremes = making
    page = (repository / "docs" / "stability.md").read_text(encoding="utf-8")
    for extreme in extremes.EXTREMES.values():
        assert f"| {extreme.name}: {extreme.quantity} |" in page
    for figure in extremes.FIGURES:
        assert f"images/{figure}.png" in page
        assert (repository / "docs" / "images" / f"{figure}.png").exists()


def test_whatever_is_missed_is_told(making, repository):
    page = (repository / "docs" / "stability.md").read_text(encoding="utf-8")
    assert "**silent**" not in page


@pytest.mark.slow
@pytest.mark.parametrize("name", ["θ, sliding cube", "narrow joints", "distance from the origin"])
def test_rows_are_what_the_program_gives(making, repository, name):
    """Range and outcome of a row measured again; those of quick scenes."""
    maker, extremes = making
    extreme = extremes.EXTREMES[name]
    rows = maker.measured(extreme)
    line = next(
        line
        for line in (repository / "docs" / "stability.md").read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| {name}:")
    )
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[3] == maker.reached(extreme, rows)
    assert cells[5] == maker.beyond(extreme, rows)
