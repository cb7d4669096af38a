"""Records and scales as a user gives them, and the intensity of what shakes the ground."""

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.incremental.records import Intensity, parsed_scales, read_records
from masonry_fem.errors import MasonryError
from masonry_fem.march.shaking import Component, GroundMotion, Shaking


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("a.AT2", "b.csv", "c.AT2"):
        (tmp_path / name).write_text("0 0\n1 1\n")
    return tmp_path


def test_a_file_serves_all_axes(folder: Path) -> None:
    (found,) = read_records([folder / "b.csv"], ("x", "z"))
    assert found.name == "b"
    assert found.files == {"x": folder / "b.csv", "z": folder / "b.csv"}


def test_a_list_has_a_file_for_each_axis_from_where_it_is(folder: Path) -> None:
    (folder / "pairs.txt").write_text("# horizontal, vertical\na.AT2, c.AT2\n\nb.csv   # both\n")
    first, second = read_records([folder / "pairs.txt"], ("x", "y"))
    assert first.files == {"x": folder / "a.AT2", "y": folder / "c.AT2"}
    assert second.files == {"x": folder / "b.csv", "y": folder / "b.csv"}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["d.AT2"], "no such record: .*d.AT2"),
        (["a.AT2", "a.AT2"], "two records are named 'a'"),
        (["three.txt"], "three.txt, line 1: 3 files, expected one, or 2 .*x and y"),
        (["none.txt"], "none.txt: cannot be read"),
        (["empty.txt"], "no records"),
    ],
)
def test_what_is_no_record_is_told(folder: Path, given: list[str], words: str) -> None:
    (folder / "three.txt").write_text("a.AT2, b.csv, c.AT2\n")
    (folder / "empty.txt").write_text("# nothing\n")
    with pytest.raises(MasonryError, match=words):
        read_records([folder / name for name in given], ("x", "y"))


def test_scales_are_numbers_and_ranges() -> None:
    assert parsed_scales("0.2:1:0.2,1.5,2", "scales") == (0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0)
    assert parsed_scales([2, 1], "scales") == (1.0, 2.0)
    assert parsed_scales("0.1:0.75:0.1", "scales")[-1] == 0.7


@pytest.mark.parametrize("text", ["0", "-1", "a", "2:1:0.5", "1:2", "1:2:0", "nan", "1,,2"])
def test_what_is_no_scale_is_told(text: str) -> None:
    with pytest.raises(MasonryError, match="expected positive numbers"):
        parsed_scales(text, "scales")


def test_intensity_is_that_across_gravity() -> None:
    times = np.linspace(0.0, 1.0, 5)
    ground = Shaking(
        tuple(
            Component(axis, GroundMotion(times, size * np.array([0, 1, -2, 1, 0.0])), False)
            for axis, size in enumerate((1.0, 4.0, 9.0))
        ),
        3,
    )
    assert Intensity(None, 0.05).of(ground, (0,)) == 2.0
    assert Intensity(None, 0.05).of(ground, (0, 1)) == pytest.approx(4.0)  # geometric mean of 2 and 8
    assert Intensity(None, 0.05).of(ground, ()) == 18.0


def test_a_spectral_intensity_is_that_of_an_oscillator() -> None:
    """At resonance with ten cycles of a sine of 1 m/s² it grows to (1 − e^(−2πζn))/(2ζ)."""
    times = np.linspace(0.0, 5.0, 2001)
    ground = Shaking((Component(0, GroundMotion(times, np.sin(4 * np.pi * times)), False),), 2)
    told = Intensity(0.5, 0.05)
    assert told.words == "Sa(0.5 s, 5 %)"
    assert told.of(ground, (0,)) == pytest.approx((1 - np.exp(-2 * np.pi * 0.05 * 10)) / 0.1, rel=0.01)


def test_a_period_is_positive() -> None:
    with pytest.raises(MasonryError, match="period is 0 s"):
        Intensity(0.0, 0.05)
