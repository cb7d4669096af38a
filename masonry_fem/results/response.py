"""Response: what the probes did in dynamics, and the response spectra of what they and the ground did."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.response import ProbeResponse
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]


class ResponseTold(Told, frozen=True, kw_only=True):
    """Greatest and last displacements of a probe, relative to the ground.

    Attributes
    ----------
    peak : Of greatest size along each axis, with sign, shape (d,) [m]. peak_time : When, shape (d,) [s].
    greatest : Length of the longest displacement [m]. greatest_time : When [s].
    residual : At the end of the last step, shape (d,) [m].
    swing : Largest distance from the residual in the last tenth of the steps, shape (d,) [m].
    """

    peak: FloatArray
    peak_time: FloatArray
    greatest: float
    greatest_time: float
    residual: FloatArray
    swing: FloatArray

    @classmethod
    def of(cls, one: ProbeResponse) -> ResponseTold:
        """The same as a record."""
        return cls(**{key: getattr(one, key) for key in cls.__struct_fields__})
