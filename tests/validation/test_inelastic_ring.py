"""A thick ring under inner pressure, in plane strain: Hill's elastic-plastic solution, and its limit load.

A quarter of a ring of radii a = 1 m and b = 2 m, drawn with gmsh, its sides on planes of symmetry. With the
shear strength k the pressure p takes plasticity to the radius c,

    p = k (2 ln(c/a) + 1 − c²/b²),     u(b) = 2 (1 − ν²) k c²/(E b),     at last p = 2 k ln(b/a)

(Hill, The Mathematical Theory of Plasticity, 1950, V.2). The pressure follows from the displacement of the
inner side, as no equilibrium is beyond the limit.
"""

from __future__ import annotations

from pathlib import Path as File
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.march.equilibrium.path import Path
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import Loads, Material, Probe, Scene, Support, Traction, material_record
from masonry_fem.structures.file import FileStructure

C, YOUNG, POISSON = 1e6, 1e9, 0.3
INNER, OUTER = 1.0, 2.0


def drawing(sectors: int) -> str:
    """Quarter of a ring in gmsh's language: as many elements through it as sectors, inner sides by sector."""
    said = ["Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 0; Point(1) = {0, 0, 0};"]
    for i, angle in enumerate(np.linspace(0, np.pi / 2, sectors + 1)):
        x, y = round(np.cos(angle), 15), round(np.sin(angle), 15)
        said.append(f"Point({100 + i}) = {{{INNER * x}, {INNER * y}, 0}};")
        said.append(f"Point({200 + i}) = {{{OUTER * x}, {OUTER * y}, 0}};")
        said.append(f"Line({300 + i}) = {{{100 + i}, {200 + i}}};")
        said.append(f"Transfinite Curve{{{300 + i}}} = {sectors + 1};")
    for i in range(sectors):
        for arc in (100 + i, 200 + i):
            said.append(f"Circle({arc}) = {{{arc}, 1, {arc + 1}}}; Transfinite Curve{{{arc}}} = 2;")
        said.append(f"Curve Loop({100 + i}) = {{{300 + i}, {200 + i}, -{301 + i}, -{100 + i}}};")
        said.append(f"Plane Surface({100 + i}) = {{{100 + i}}}; Transfinite Surface{{{100 + i}}};")
        said.append(f'Recombine Surface{{{100 + i}}}; Physical Curve("in{i}") = {{{100 + i}}};')
    said.append(f'Physical Curve("bottom") = {{300}}; Physical Curve("left") = {{{300 + sectors}}};')
    said.append(f'Physical Surface("quarter") = {{100:{99 + sectors}}};')
    return "\n".join(said)


class Curve:
    """Pressure over C, and displacement of the outer side [m], step by step."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float]] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        self.rows.append((report.time, report.probes["outer"][0]))


def widened(folder: File, sectors: int, law: str, way: float, steps: int) -> tuple[RunResult, Curve]:
    """The ring, its inner side moved outwards by ``way`` [m]."""
    (folder / "ring.geo").write_text(drawing(sectors))
    record = material_record(law, cohesion=C, friction_angle=0.0)
    angles = (np.arange(sectors) + 0.5) * np.pi / 2 / sectors
    scene = Scene(
        dimension=2,
        fidelity="inelastic",
        materials={"m": Material(density=2000.0, young=YOUNG, poisson=POISSON, inelastic=record)},
        structures=(FileStructure(name="ring", material="m", path="ring.geo", trusted=True),),
        supports=(
            Support(on="ring.quarter/left", components=("x",)),
            Support(on="ring.quarter/bottom", components=("y",)),
        ),
        probes=(
            Probe(name="inner", block="ring.quarter", point=(INNER, 0.0)),
            Probe(name="outer", block="ring.quarter", point=(OUTER, 0.0)),
        ),
        loads=Loads(
            gravity=(0.0, 0.0),
            tractions=tuple(
                Traction(on=f"ring.quarter/in{i}", vector=(C * np.cos(angle), C * np.sin(angle)))
                for i, angle in enumerate(angles)
            ),
        ),
        analysis=Path(probe="inner", direction=(1.0, 0.0), distance=way, load_steps=steps),
    )
    curve = Curve()
    return solve_scene(check(scene, base=folder), base=folder, observers=[curve]), curve


@pytest.mark.slow
@pytest.mark.parametrize(("law", "strength"), [("mohr_coulomb", C), ("drucker_prager", 2 * C / np.sqrt(3))])
def test_the_limit_pressure_of_tresca_and_of_mises(tmp_path, law, strength):
    """From above, at second order, to 0.3 % on 8 by 8 elements."""
    limit = 2 * strength / C * np.log(OUTER / INNER)
    over = []
    for sectors in (4, 8):
        result, curve = widened(tmp_path, sectors, law, 1.2e-2, 10)
        assert result.outcome == "finished"
        assert result.march.ledger.imbalance <= 1e-9
        over.append(curve.rows[-1][0] / limit - 1)
    assert 0 < over[1] < 3e-3
    assert np.log2(over[0] / over[1]) > 1.8, over


@pytest.mark.slow
def test_the_elastic_plastic_ring(tmp_path):
    """Radius of the plastic zone, and displacement of the elastic one, at a pressure before the limit."""
    off = []
    for sectors in (4, 8):
        result, curve = widened(tmp_path, sectors, "mohr_coulomb", 4e-3, 6)
        pressure, outer = curve.rows[-1]
        radius = float(brentq(lambda c, p=pressure: 2 * np.log(c) + 1 - (c / OUTER) ** 2 - p, INNER, OUTER))
        off.append(outer / (2 * (1 - POISSON**2) * C * radius**2 / (YOUNG * OUTER)) - 1)
        group = result.march.model.groups[-1]
        points = group.constitution.strains
        plastic = group.material_state(result.march.state.bodies[-1])["plastic_strain"][0].max(axis=1) > 0
        centres = np.linalg.norm(points.mesh.points[points.mesh.cells].mean(axis=1), axis=1)
        size = (OUTER - INNER) / sectors
        assert plastic[centres < radius - size].all()
        assert not plastic[centres > radius + size].any()
        assert INNER + size < radius < OUTER - size
    assert abs(off[1]) < 1e-2
    assert np.log2(off[0] / off[1]) > 1.8, off
