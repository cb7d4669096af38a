"""Patch: two unit blocks under uniform pressure through a joint, and how far σ is from −p n nᵀ."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    Statics,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import solved

P = 1e6  # pressure [Pa]


def by_block(result: RunResult, axis: np.ndarray | None = None) -> dict[str, float]:
    """Largest |σ + p n nᵀ| / p over the Gauss points of each elastic block; n is upright unless given."""
    n = upright(result.built.model.assembly.dimension) if axis is None else axis
    exact = -P * np.outer(n, n)[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    worst: dict[str, float] = {}
    for group, state in zip(result.built.model.groups, result.march.state.bodies, strict=True):
        field = group.stress(state)
        if field is not None:
            error = np.abs(field.gauss - exact).max(axis=(1, 2, 3)) / P
            worst |= dict(zip(group.names, error.tolist(), strict=True))
    return worst


def worst_stress(result: RunResult, axis: np.ndarray | None = None) -> float:
    """The largest of all blocks."""
    return max(by_block(result, axis).values())


def upright(d: int) -> np.ndarray:
    return np.eye(3)[d - 1]


def pressed(
    d: int,
    lower: int,
    upper: int,
    placement: str = "gauss",
    elements: tuple[str, str] = ("Q1", "Q1"),
    young: float = 1e10,
    **keys: Any,
) -> tuple[RunResult, float]:
    """Unit blocks one on another under 1 MPa, rollers where symmetry allows; worst stress error / p."""
    one = BlockStructure(
        name="lower",
        material="lower",
        size=(1.0,) * d,
        mesh=MeshSettings(element=elements[0], divisions=(lower,) * d),
    )
    two = BlockStructure(
        name="upper",
        material="upper",
        size=(1.0,) * d,
        position=(0.0,) * (d - 1) + (1.0,),
        mesh=MeshSettings(element=elements[1], divisions=(upper,) * d),
    )
    return pair(d, (one, two), ("lower", "upper"), placement, young, **keys)


def pair(
    d: int,
    structures: tuple[Any, ...],
    names: tuple[str, str],
    placement: str = "gauss",
    young: float = 1e10,
    **keys: Any,
) -> tuple[RunResult, float]:
    """Two given unit blocks, of which ``names[0]`` stands below; ``young`` is of the upper one."""
    sides = [("left", "x"), ("front", "y")][: d - 1]
    supports = [Support(on=f"{names[0]}/bottom", components=("xyz"[d - 1],))]
    supports += [Support(on=f"{name}/{face}", components=(c,)) for name in names for face, c in sides]
    stone = {"density": 1000.0, "poisson": 0.2}
    result = solved(
        dimension=d,
        plane="stress",
        materials={"lower": Material(young=1e10, **stone), "upper": Material(young=young, **stone)},
        structures=structures,
        supports=tuple(supports),
        joints=(Joint(friction=0.0, placement=placement),),
        loads=Loads(tractions=(Traction(on=f"{names[1]}/top", vector=(0.0,) * (d - 1) + (-P,)),)),
        probes=(Probe(name="corner", block=names[1], point=(1.0,) * (d - 1) + (2.0,)),),
        analysis=Statics(),
        **keys,
    )
    return result, worst_stress(result)
