"""Combinations: partial factors on loads and strengths, and the scene of each load combination.

for combination, own in combination_scenes(scene):       # own: a scene without combinations
    ...
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from msgspec import structs
from msgspec.structs import asdict

from masonry_fem.records.record import Fraction, Positive, Spec

if TYPE_CHECKING:
    from masonry_fem.scene.actions import Combination, Loads
    from masonry_fem.scene.specs import Scene


GRAVITY = "gravity"  # the case of ``loads.gravity``
SCALED = {
    "accelerations": ("vector",),
    "accelerograms": ("scale",),
    "tractions": ("vector",),
    "pressures": ("pressure", "unit_weight"),
    "points": ("vector",),
    "lines": ("vector",),
    "moving": ("vector",),
    "temperatures": ("change",),
}  # what a factor multiplies, by kind of load


def cases_of(scene: Scene) -> tuple[str, ...]:
    """Names of the scene's load cases, each once."""
    own = (load.case for kind in SCALED for load in getattr(scene.loads, kind) if load.case is not None)
    return tuple(dict.fromkeys([*([] if scene.loads.gravity is None else [GRAVITY]), *own]))


def combination_scenes(scene: Scene) -> Iterator[tuple[Combination, Scene]]:
    """Each combination with its scene: loads multiplied by the factors, those of other cases left out."""
    for combination in scene.combinations:
        title = f"{scene.title}, {combination.name}" if scene.title else combination.name
        loads = _combined(scene.loads, combination.factors)
        yield combination, structs.replace(scene, title=title, loads=loads, combinations=())


def _combined(loads: Loads, factors: dict[str, float]) -> Loads:
    changes: dict[str, Any] = {}
    for kind, keys in SCALED.items():
        acting = ((load, factors.get(load.case, 0.0) if load.case else 1.0) for load in getattr(loads, kind))
        changes[kind] = tuple(
            structs.replace(load, **{key: _times(factor, getattr(load, key)) for key in keys})
            for load, factor in acting
            if factor != 0.0
        )
    if loads.gravity is not None:
        factor = factors.get(GRAVITY, 0.0)
        changes |= (
            {"gravity": _times(factor, loads.gravity)} if factor else {"gravity": None, "gravity_time": None}
        )
    return structs.replace(loads, **changes)


def _times(factor: float, value: Any) -> Any:
    return tuple(factor * part for part in value) if isinstance(value, tuple) else factor * value


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
    material_factor : factor γ_M by which strengths of stones are divided
    loads : factors γ_F of loads
    share : share of a stone's volume, the most utilised of it, over which its ``local`` utilisation is the
        mean
    """

    material_factor: Positive = 1.0
    loads: LoadFactors = LoadFactors()
    share: Fraction = 0.05
