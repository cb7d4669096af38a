"""Components: vectors in words; what is rounding beside the greatest one is 0. Files keep all digits.

in_words([-1.4e-13, -1.02e-5], "m", ("x", "z"), 5)          # 'x 0 m  z −10.2 µm'
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from masonry_fem.output.sheet import quantity

# Share of the greatest component below which another is rounding. Sideways motions of symmetric arches of
# elastic stones, which a contact tolerance of 1e-10 leaves, are up to 2.4e-8 of their crown's.
ROUNDING = {"m": 1e-7}
OTHERS = 1e-9


def greatest(vectors: Iterable[Any]) -> float:
    """The largest size of a component of several vectors; 0 where there are none."""
    return max((float(np.abs(np.asarray(one, float)).max(initial=0.0)) for one in vectors), default=0.0)


def rounded(value: float, unit: str, beside: float) -> float:
    """The value, or 0 where it is rounding.

    Parameters
    ----------
    value : The component. unit : Its unit: displacements [m] have more rounding than forces.
    beside : The greatest component of its kind.
    """
    return 0.0 if abs(value) <= ROUNDING.get(unit, OTHERS) * beside else value


def in_words(
    values: Any, unit: str, names: Sequence[str], digits: int, beside: float = 0.0, mark: str = "  "
) -> str:
    """Components by their axes, what is rounding as 0.

    Parameters
    ----------
    values : The vector. unit : Its unit. names : Its axes. digits : Of each number.
    beside : The greatest component of other vectors of its kind. mark : Between components.
    """
    flat = np.ravel(np.asarray(values, float)).tolist()
    largest = max(beside, greatest([flat]))
    told = (quantity(rounded(value, unit, largest), unit, digits) for value in flat)
    return mark.join(f"{name} {value}" for name, value in zip(names, told, strict=False))
