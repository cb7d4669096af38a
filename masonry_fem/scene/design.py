"""Design: partial factors on strengths and loads, and how utilisations are told."""

from __future__ import annotations

from msgspec.structs import asdict

from masonry_fem.records.record import Fraction, Positive, Spec


class LoadFactors(Spec, frozen=True, kw_only=True):
    """Factors by which the run multiplies the loads of a kind.

    They change what is computed, forces and displacements included, and the console, ``summary.json`` and the
    report say so.

    Attributes
    ----------
    gravity : of ``loads.gravity``
    accelerations : of all ``[[loads.accelerations]]``
    accelerograms : of all ``[[loads.accelerograms]]`` that act as inertia
    tractions : of all ``[[loads.tractions]]``
    pressures : of all ``[[loads.pressures]]``
    points : of all ``[[loads.points]]``
    lines : of all ``[[loads.lines]]``
    moving : of all ``[[loads.moving]]``
    """

    gravity: Positive = 1.0
    accelerations: Positive = 1.0
    accelerograms: Positive = 1.0
    tractions: Positive = 1.0
    pressures: Positive = 1.0
    points: Positive = 1.0
    lines: Positive = 1.0
    moving: Positive = 1.0

    @property
    def used(self) -> dict[str, float]:
        """Those that are not 1, by kind of load."""
        return {kind: factor for kind, factor in asdict(self).items() if factor != 1.0}

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence on those that are not 1, for results that do not list them; none where all are 1."""
        told = ", ".join(f"{kind} × {factor:g}" for kind, factor in self.used.items())
        return (f"loads are multiplied by the partial factors of design.loads: {told}",) if told else ()


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
