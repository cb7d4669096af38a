"""Combinations: the scene of each load combination.

for combination, own in combination_scenes(scene):       # own: a scene without combinations
    ...
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from msgspec import structs

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
