"""Quantity: a number with a unit, written as a string (``"10 GPa"``, ``"25 cm"``, ``"30 deg"``).

    si_value("25 cm", "m")       # 0.25

The units library takes longer to load than most scenes to be read; it is asked only of units that are not
common ones.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from masonry_fem.scene.misfit import nearest

# what a quantity is called in messages, by the unit it is held in
NOUNS = {
    "m": "a length",
    "m^2": "an area",
    "s": "a time",
    "Hz": "a frequency",
    "Pa": "a pressure",
    "kg/m^3": "a density",
    "deg": "an angle",
    "rad": "an angle",
    "rad/s": "an angular velocity",
    "m/s": "a velocity",
    "m/s^2": "an acceleration",
    "N": "a force",
    "N/m": "a force per length",
    "1/s": "a rate",
    "B": "an amount of memory",
    "K": "a change of temperature",
    "1/K": "an expansion by temperature",
}
# by the unit that a quantity is held in, what one of each unit is: the numbers of the units library
FACTORS = {
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm^2": 1e6},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3},
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "Hz": {"Hz": 1.0},
    "N": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "N/m": {"kN/m": 1e3, "N/m": 1.0},
    "kg/m^3": {"kg/m^3": 1.0, "g/cm^3": 999.9999999999999, "t/m^3": 1e3},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e-3},
    "deg": {"deg": 1.0, "rad": 57.29577951308232},
    "rad": {"rad": 1.0, "deg": 0.017453292519943295},
    "rad/s": {"rad/s": 1.0},
    "B": {"MB": 1e6, "GB": 1e9},
    "K": {"K": 1.0, "degC": 1.0},
    "1/K": {"1/K": 1.0},
    "m^2": {"mm^2": 1e-6, "cm^2": 1e-4, "m^2": 1.0},
}
COMMON_UNITS = tuple(dict.fromkeys(unit for units in FACTORS.values() for unit in units))
# "++" and "*+" do not backtrack; otherwise a long text that is no quantity would take minutes
_NUMBER_AND_UNIT = re.compile(r"([+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?)\s*+(.*)")
_UNIT = r"[^\W\d]+(?:(?:\^|\*\*) ?-?\d|[²³])?"  # letters, and one digit of an exponent
_UNITS = re.compile(rf" *(?:1 ?/ ?)?(?:{_UNIT}(?: ?[*/·] ?| |(?= *$)))* *|%")
_SCALE = re.compile("deg[CF]|celsius|fahrenheit")
_EXPONENT = re.compile(r"(?<=[A-Za-z])([23])(?![\w.])")  # kg/m3 is how many write kg/m^3


class QuantityError(ValueError):
    """A string that is no quantity of the wanted kind; the text says why, to follow the value."""


def noun_of(unit: str | None) -> str:
    """What a quantity held in ``unit`` is called: ``a pressure``, ``a number``."""
    return "a number" if unit is None else NOUNS.get(unit, "a quantity")


def si_value(text: str, unit: str | None) -> float:
    """The number that a text stands for.

    Parameters
    ----------
    text : A number with a unit.
    unit : Unit of the result; None for a pure number.

    Raises
    ------
    QuantityError : The text is no number with a unit, or its unit has another dimension.
    """
    match = _NUMBER_AND_UNIT.fullmatch(text.strip())
    if match is None:
        raise QuantityError("")
    number, written = float(match[1]), _EXPONENT.sub(r"^\1", match[2])
    if not written and unit is not None:
        raise QuantityError(f"; give it a unit ('{text.strip()} {unit}') or write it without quotes")
    if (factor := FACTORS.get(unit or "", {}).get(written)) is not None:
        return number * factor
    if not _UNITS.fullmatch(re.sub(r"[()\s]+", " ", written)):  # the library evaluates any expression
        raise QuantityError(f"; '{written}' is no known unit{nearest(written, COMMON_UNITS)}")
    if _SCALE.fullmatch(written):  # of changes, which have no zero of their own
        written = f"delta_{written}"
    registry = _registry()
    try:
        quantity = registry.Quantity(number, registry.parse_units(written))
        target = registry.Quantity(1.0, registry.parse_units(unit or ""))
        root = quantity.to_root_units().units
    except Exception as error:  # the library raises many kinds for a unit that it cannot read
        raise QuantityError(f"; '{written}' is no known unit{nearest(written, COMMON_UNITS)}") from error
    if root != target.to_root_units().units:  # not only the dimension: an angle is no pure number
        raise QuantityError("")
    return float(quantity.to(target.units).magnitude)


def si_factor(unit: str) -> float:
    """By how much a number with a unit becomes one in SI units.

    Parameters
    ----------
    unit : As ``"kN"``; of temperatures, of their changes.

    Raises
    ------
    QuantityError : It is no known unit.
    """
    written = _EXPONENT.sub(r"^\1", unit.strip())
    if not written or not _UNITS.fullmatch(re.sub(r"[()\s]+", " ", written)):
        raise QuantityError(f"; '{unit}' is no known unit{nearest(unit, COMMON_UNITS)}")
    if _SCALE.fullmatch(written):
        written = f"delta_{written}"
    registry = _registry()
    try:
        return float(registry.Quantity(1.0, registry.parse_units(written)).to_base_units().magnitude)
    except Exception as error:
        raise QuantityError(f"; '{unit}' is no known unit{nearest(unit, COMMON_UNITS)}") from error


@cache
def _registry() -> Any:
    """The units library's registry, made once; its definitions are kept parsed where there is a place."""
    from pint import UnitRegistry  # noqa: PLC0415  (a sixth of a second that most scenes do not need)

    try:
        return UnitRegistry(cache_folder=":auto:")
    except Exception:  # no folder to write to, or a file that another process is just writing
        return UnitRegistry()


def is_number(word: str) -> bool:
    """Whether a word of a table is meant as a number, 'nan' among them: a line with it has no titles."""
    try:
        float(word)
    except ValueError:
        return False
    return True
