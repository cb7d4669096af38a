"""Rings: a quarter of two concentric rings under pressure from outside, in any numbers of facets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    Loads,
    MeshSettings,
    Scene,
    Statics,
    Support,
    Traction,
)
from masonry_fem.structures.file import FileStructure
from tests.validation.scenes import STONE

INNER, BETWEEN, OUTER = 0.8, 1.0, 1.2  # radii [m]
P = 1e6  # pressure [Pa]
# Lamé, where the rings touch
EXACT = P * OUTER**2 / (OUTER**2 - INNER**2) * (1 - (INNER / BETWEEN) ** 2)


def _ring(name: str, radii: tuple[float, float], facets: int, layers: int, base: int) -> str:
    """Gmsh geometry of a quarter ring: corners on the circles, a quadrilateral a facet, ``name_out3`` ..."""
    angles = np.linspace(0.0, np.pi / 2, facets + 1)
    step = facets + 2
    lines = []
    for row, radius in enumerate(radii):
        for j, angle in enumerate(angles.tolist()):
            x, y = radius * np.cos(angle), radius * np.sin(angle)
            lines.append(f"Point({base + row * step + j}) = {{{x:.16g}, {y:.16g}, 0, 1}};")
    for j in range(facets):
        for row in (0, 1):
            first = base + row * step + j
            lines.append(f"Line({first}) = {{{first}, {first + 1}}}; Transfinite Curve{{{first}}} = 2;")
    across = base + 2 * step
    for j in range(facets + 1):
        lines.append(f"Line({across + j}) = {{{base + j}, {base + step + j}}};")
        lines.append(f"Transfinite Curve{{{across + j}}} = {layers + 1};")
    for j in range(facets):
        loop = f"{across + j}, {base + step + j}, -{across + j + 1}, -{base + j}"
        lines.append(f"Curve Loop({base + j}) = {{{loop}}}; Plane Surface({base + j}) = {{{base + j}}};")
        lines.append(f"Transfinite Surface{{{base + j}}}; Recombine Surface{{{base + j}}};")
        lines.append(f'Physical Curve("{name}_out{j}") = {{{base + step + j}}};')
    inside = ", ".join(str(base + j) for j in range(facets))
    lines.append(f'Physical Surface("{name}") = {{{inside}}};')
    lines.append(f'Physical Curve("{name}_in") = {{{inside}}};')
    lines.append(f'Physical Curve("{name}_x") = {{{across}}};')
    lines.append(f'Physical Curve("{name}_y") = {{{across + facets}}};')
    return "\n".join(lines) + "\n"


def squeezed(folder: Path, inner: int, outer: int, friction: float = 0.0, **keys: Any) -> RunResult:
    """Rings of ``inner`` and ``outer`` facets over 90°, both cuts on rollers."""
    layers = max(2, round(0.2 * max(inner, outer) / (np.pi / 2)))
    text = _ring("inner", (INNER, BETWEEN), inner, layers, 1000)
    text += _ring("outer", (BETWEEN, OUTER), outer, layers, 100000)
    (folder / "rings.geo").write_text(text)
    middles = (np.arange(outer) + 0.5) * np.pi / 2 / outer
    supports = tuple(
        Support(on=f"c.{ring}/{ring}_{cut}", components=(component,))
        for ring in ("inner", "outer")
        for cut, component in (("x", "y"), ("y", "x"))
    )
    scene = Scene(
        dimension=2,
        materials={"stone": STONE},
        structures=(FileStructure(name="c", material="stone", path="rings.geo", trusted=True),),
        mesh=MeshSettings(element="Q1"),
        supports=supports,
        joints=(Joint(friction=friction, **keys),),
        contact=Contact(angle=30.0, reach=0.05),
        loads=_pressure(middles),
        analysis=Statics(),
    )
    return solve_scene(scene, folder)


def _pressure(middles: np.ndarray) -> Loads:
    return Loads(
        tractions=tuple(
            Traction(on=f"c.outer/outer_out{j}", vector=(-P * np.cos(angle), -P * np.sin(angle)))
            for j, angle in enumerate(middles.tolist())
        )
    )


def pressures(result: RunResult) -> np.ndarray:
    """Pressure of each place along the joint, over the exact one; places in order."""
    contacts, force = result.built.model.contacts, result.march.state.reaction[:, 0]
    angle = np.arctan2(contacts.points[:, 0, 1], contacts.points[:, 0, 0])
    _, of = np.unique(np.round(angle, 7), return_inverse=True)
    found: np.ndarray = np.bincount(of, force) / np.bincount(of, contacts.area) / EXACT
    return found
