"""Quantity: a number with a unit, written as a string (``"10 GPa"``, ``"25 cm"``, ``"30 deg"``).

    si_value("25 cm", "m")       # 0.25

The units library is loaded at the first such string, never for a scene of plain numbers.
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
COMMON_UNITS = (
    "Pa", "kPa", "MPa", "GPa", "N/mm^2", "m", "cm", "mm", "km", "s", "ms", "min", "Hz", "N", "kN", "MN",
    "kN/m", "N/m", "kg/m^3", "g/cm^3", "t/m^3", "m/s", "mm/s", "m/s^2", "mm/s^2", "deg", "rad", "rad/s",
    "MB", "GB", "K", "degC", "1/K", "mm^2", "cm^2", "m^2",
)  # fmt: skip
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
    from pint import UnitRegistry  # noqa: PLC0415  (a quarter of a second that most scenes do not need)

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
