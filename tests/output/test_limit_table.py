"""What limit analysis says, on the console."""

from io import StringIO

import pytest
from rich.console import Console

from masonry_fem.output.limit_table import print_limits

TOLD = {
    "title": "flyer",
    "message": "The loads can be carried.",
    "blocks": 10,
    "contacts": 22,
    "dead": ["gravity"],
    "growing": [],
    "admissible": True,
    "unlimited": False,
    "multiplier": None,
    "least_multiplier": None,
    "supports": {"wall": {"x": [19864.1176, None], "y": [-1e-8, 5000.0]}, "foot": {"x": [None, -19864.1176]}},
    "certificate": {"unbalanced": 1e-12, "closing": 0.0, "gap": 0.0},
    "notes": ["elastic blocks count as rigid"],
}


def printed(dimension: int, **changes) -> str:
    stream = StringIO()
    print_limits(TOLD | changes, dimension, Console(file=stream, width=120))
    return stream.getvalue()


@pytest.mark.parametrize(("dimension", "unit"), [(2, "kN/m"), (3, "kN")])
def test_intervals_have_units_and_may_be_unbounded(dimension: int, unit: str) -> None:
    text = printed(dimension)
    assert f"19.8641 {unit} to ∞" in text
    assert f"−∞ to −19.8641 {unit}" in text
    assert f"0 {unit.removeprefix('k')} to 5 {unit}" in text  # rounding is nothing


def test_verdict_and_notes() -> None:
    text = printed(2)
    assert "│ admissible" in text
    assert "collapse multiplier" not in text
    assert "elastic blocks count as rigid" in text
    assert "not admissible" in printed(2, admissible=False)


@pytest.mark.parametrize(
    ("changes", "shown"),
    [
        ({"multiplier": 0.40189, "least_multiplier": 0.0}, "0.40189"),
        ({"unlimited": True, "least_multiplier": 0.0}, "no limit"),
        ({"multiplier": 2.0, "least_multiplier": 0.5}, "least multiplier"),
    ],
)
def test_multipliers(changes: dict, shown: str) -> None:
    text = printed(2, growing=["points.0"], **changes)
    assert shown in text
    assert ("least multiplier" in text) is bool(changes["least_multiplier"])
