"""Swept key: a key of a scene, and the values between which a search gives it one after another.

    key = SweptKey.of("structures.arch.thickness", "5 cm", "20 cm")
    key.low, key.high, key.override(12.0)          # 5.0, 20.0, "structures.arch.thickness=12.0 cm"

A key is what ``--set`` takes. With a direction the key is a vector, and a value is its size along that.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from masonry_fem.errors import MasonryError

QUANTITY = re.compile(r"\s*([+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?)\s*+(.*?)\s*")


@dataclass(frozen=True, slots=True)
class SweptKey:
    """A key and the ends of its values.

    Attributes
    ----------
    key : Dotted key.
    low, high : Ends, in the order given. unit : Of the values, "" for none.
    along : Unit vector that values are sizes along; empty where the key is a number.
    whole : Whether values are whole numbers.
    """

    key: str
    low: float
    high: float
    unit: str
    along: tuple[float, ...]
    whole: bool = False

    @classmethod
    def of(cls, key: str, low: str | float, high: str | float, along: Sequence[float] = ()) -> SweptKey:
        """From what a user writes.

        Parameters
        ----------
        key : Dotted key.
        low, high : Numbers, or texts with a unit, the same for both.
        along : Direction of a vector, of any size.

        Raises
        ------
        MasonryError : No key, no numbers, other units, or no direction.
        """
        if "=" in key or not all(key.split(".")):
            raise MasonryError(f"key '{key}', expected a dotted key without value: structures.arch.thickness")
        (first, unit), (last, other) = _quantity(low), _quantity(high)
        if unit != other:
            raise MasonryError(
                f"--between {low} {high}: units '{unit}' and '{other}' differ, expected the same for both"
            )
        if first == last:
            raise MasonryError(f"--between {low} {high}: the ends are equal, expected two values")
        size = math.hypot(*along) if along else 1.0
        if not (size > 0 and math.isfinite(size)):
            raise MasonryError(f"--along {' '.join(map(str, along))}, expected a direction, as 1 1 0")
        return cls(key, first, last, unit, tuple(part / size for part in along))

    def override(self, value: float) -> str:
        """The text that ``--set`` takes."""
        if self.along:
            return (
                f"{self.key}=[{', '.join(self._written(part * value, quoted=True) for part in self.along)}]"
            )
        return f"{self.key}={self._written(value)}"

    def told(self, value: float) -> str:
        """A value in words."""
        return f"{value:.6g}{f' {self.unit}' if self.unit else ''}"

    def fitted(self, readable: Callable[[str], object]) -> SweptKey:
        """The same key, of whole numbers where the scene takes no others.

        Parameters
        ----------
        readable : Raises MasonryError where the scene with an override cannot be read.

        Raises
        ------
        MasonryError : The scene takes neither.
        """
        try:
            readable(self.override(0.5 * (self.low + self.high) + 1e-3 * (self.high - self.low)))
        except MasonryError:
            whole = SweptKey(self.key, self.low, self.high, self.unit, self.along, whole=True)
            if self.along or not (self.low.is_integer() and self.high.is_integer()):
                raise
            readable(whole.override(self.low))
            return whole
        return self

    def _written(self, value: float, *, quoted: bool = False) -> str:
        number = str(round(value)) if self.whole else repr(value)
        if not self.unit:
            return number
        return f'"{number} {self.unit}"' if quoted else f"{number} {self.unit}"


def _quantity(text: str | float) -> tuple[float, str]:
    """Number and unit of a value."""
    found = QUANTITY.fullmatch(str(text))
    if found is None or not math.isfinite(float(found[1])):
        raise MasonryError(f"--between has {text!r}, expected a number, or one with a unit as '12 cm'")
    return float(found[1]), found[2]
