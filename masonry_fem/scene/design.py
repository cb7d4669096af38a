"""Design: partial factors on strengths and loads, and how utilisations are told."""

from __future__ import annotations

from masonry_fem.records.record import Fraction, Positive, Spec


class LoadFactors(Spec, frozen=True, kw_only=True):
    """Factors by which the run multiplies the loads of a kind.

    They change what is computed, forces and displacements included, and the console, ``summary.json`` and the
    report say so.

    Attributes
    ----------
    gravity : of ``loads.gravity``
    accelerations : of all ``[[loads.accelerations]]``
    tractions : of all ``[[loads.tractions]]``
    points : of all ``[[loads.points]]``
    lines : of all ``[[loads.lines]]``
    """

    gravity: Positive = 1.0
    accelerations: Positive = 1.0
    tractions: Positive = 1.0
    points: Positive = 1.0
    lines: Positive = 1.0


class Design(Spec, frozen=True, kw_only=True):
    """Partial factors, of any code, for the [strength check](strength.md).

    Attributes
    ----------
    material_factor : by which strengths of stones are divided, γ_M
    loads : factors of loads, γ_F
    share : share of a stone's volume, the most utilised of it, over which its ``local`` utilisation is the
        mean
    """

    material_factor: Positive = 1.0
    loads: LoadFactors = LoadFactors()
    share: Fraction = 0.05
