"""Masks: files hold no NaN; an array ``has_NAME`` tells where NAME has a value, and where 0 stands for none.

Rigid blocks have no stress, open joints no centre of pressure. Pictures know NaN, many readers do not.
"""

from __future__ import annotations

from collections.abc import MutableMapping
from typing import Any

import numpy as np

from masonry_fem.output import fields, interface_fields
from masonry_fem.output.fields import Arrays

# whose mask tells of an array that may lack values; all that is made of the stress shares its mask
MASK_OF = {
    **dict.fromkeys((fields.STRESS, fields.VON_MISES, fields.PRINCIPAL, *fields.DIRECTIONS), fields.STRESS),
    **{name: name for name in (fields.STRESS_ERROR, fields.ADHESION, fields.UTILISATION)},
    **{name: name for name in (interface_fields.CENTRE, interface_fields.ECCENTRICITY)},
    **{name: name for name in (interface_fields.KERN, interface_fields.PRESSURE)},
}


def without_nan(arrays: Arrays) -> Arrays:
    """The arrays with 0 for NaN, and the masks of those that may lack values."""
    made: Arrays = {}
    for name, values in arrays.items():
        unknown = np.isnan(values) if np.issubdtype(values.dtype, np.floating) else np.zeros(1, bool)
        if name in MASK_OF or unknown.any():
            known = ~unknown.reshape(len(values), -1).any(axis=1)
            made.setdefault(f"has_{MASK_OF.get(name, name)}", known.astype(np.uint8))
            made[name] = np.where(unknown, 0.0, values)
        else:
            made[name] = values
    return made


def with_nan(arrays: MutableMapping[str, Any]) -> None:
    """Put NaN back where a mask says that there is no value."""
    for name in list(arrays):
        mask = f"has_{MASK_OF.get(name, name)}"
        if mask in arrays:
            values = np.array(arrays[name])
            values[np.asarray(arrays[mask]) == 0] = np.nan
            arrays[name] = values
