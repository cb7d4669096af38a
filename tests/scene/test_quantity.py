"""Quantities: numbers with units in strings."""

import subprocess
import sys

import pytest

from masonry_fem.scene.quantity import COMMON_UNITS, FACTORS, NOUNS, QuantityError, _registry, si_value


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("10 GPa", "Pa", 1e10),
        ("25 cm", "m", 0.25),
        ("30 deg", "deg", 30.0),
        ("1 rad", "deg", 57.29577951308232),
        ("2400 kg/m^3", "kg/m^3", 2400.0),
        ("2.4 t/m**3", "kg/m^3", 2400.0),
        ("1e-3kN/m", "N/m", 1.0),
        ("-9.81 m/s²", "m/s^2", -9.81),
        ("5 N/mm^2", "Pa", 5e6),
        ("120 rpm", "rad/s", 12.566370614359172),
        ("2400 kg/m3", "kg/m^3", 2400.0),
        ("3 kN/m2", "Pa", 3000.0),
        ("20 %", None, 0.2),
        ("20 degC", "K", 20.0),  # changes of temperature, which have no zero of their own
        ("18 degF", "K", 10.0),
        ("8e-6 1/K", "1/K", 8e-6),
        ("0.5", None, 0.5),
        (" +.5 ms ", "s", 5e-4),
    ],
)
def test_quantities_become_si_numbers(text, unit, expected):
    assert si_value(text, unit) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit"),
    [("10 kg", "Pa"), ("3 m", "s"), ("30 deg", None), ("3", "m"), ("1 Hz", "rad/s"), ("abc", "m"), ("", "m"),
     ("3 flurb", "m"), ("3 m/", "m"), ("1 2 m", "m"), ("__import__('os')", "m"), ("1 m; 2", "m"),
     ("20 degC", "deg")],
)  # fmt: skip
def test_what_is_no_such_quantity_is_refused(text, unit):
    with pytest.raises(QuantityError):
        si_value(text, unit)


@pytest.mark.parametrize("text", ["1" + " " * 20000 + "a\nb", "1" * 20000 + "\nb"], ids=["blanks", "digits"])
def test_a_long_text_is_refused_at_once(text):
    """A pattern that tried all ways to part it took hours."""
    with pytest.raises(QuantityError):
        si_value(text, "m")


def test_every_unit_of_the_records_is_known_and_named():
    for unit in (*NOUNS, *COMMON_UNITS):
        si_value(f"1 {unit}", next(other for other in NOUNS if _same(unit, other)))


def _same(unit: str, other: str) -> bool:
    try:
        si_value(f"1 {unit}", other)
    except QuantityError:
        return False
    return True


def test_factors_of_common_units_are_those_of_the_units_library():
    """To the last digit, so that a scene is the same whichever of the two reads it."""
    registry = _registry()
    for unit, factors in FACTORS.items():
        for written, factor in factors.items():
            for number in (1.0, 0.1, 8.37, 1234.5, 3e-7):
                one = registry.Quantity(number, _of_changes(written)).to(_of_changes(unit))
                assert number * factor == one.magnitude, f"{number} {written} in {unit}"


def _of_changes(unit: str) -> str:
    return unit.replace("degC", "delta_degC")


def test_the_units_library_waits_for_a_unit_that_is_not_common():
    code = (
        "import sys; from masonry_fem.scene.quantity import si_value\n"
        "import masonry_fem.scene; si_value('1 cm', 'm'); assert 'pint' not in sys.modules\n"
        "si_value('1 ft', 'm'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
