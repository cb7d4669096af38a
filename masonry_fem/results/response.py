"""Response: what the probes did in dynamics, and the response spectra of what they and the ground did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from masonry_fem.records.told import Told

if TYPE_CHECKING:
    from masonry_fem.output.spectrum import Spectrum

FloatArray = NDArray[np.float64]


class SpectrumPeak(Told, frozen=True, kw_only=True):
    """Where a response spectrum is greatest.

    Attributes
    ----------
    pseudo_acceleration : ω² times the displacement [m/s²]. period : Of the oscillator there [s].
    """

    pseudo_acceleration: float
    period: float


class SpectraTold(Told, frozen=True, kw_only=True):
    """Response spectra, which stand in ``spectra.csv``.

    Attributes
    ----------
    damping : Ratio of the oscillators [-]. peaks : By the names of motions, as in the table.
    """

    damping: float
    peaks: dict[str, SpectrumPeak]

    @classmethod
    def of(cls, spectra: Mapping[str, Spectrum]) -> SpectraTold:
        """Their peaks."""
        peaks = {}
        for name, one in spectra.items():
            place = int(np.nanargmax(one.accelerations))
            top = float(one.accelerations[place])
            peaks[name] = SpectrumPeak(pseudo_acceleration=top, period=float(one.periods[place]))
        return cls(damping=next(iter(spectra.values())).damping, peaks=peaks)
