"""Arch bridge under a load on its road
====================================

Geometry and material
    Prestwood bridge: a segmental barrel of brick with a clear span of 6.55 m, a rise of 1.43 m and a
    thickness of 0.22 m, 3.8 m wide, with 0.165 m of fill over the crown; 20 kN/m³ both. The fill is one block
    of Mohr–Coulomb soil in plane strain, on 24 elastic voussoirs, with φ = 37°. Assumed are its cohesion
    (1 kPa), its stiffness (50 MPa), associated flow, μ = 0.7 in the joints and on the extrados, ends of the
    fill 2 m behind the springings that are smooth and do not move, and a barrel that is not crushed and was
    not distorted before.
Load
    A strip of 0.3 m at the quarter of the span is pressed down by 12 mm; the force for it has a peak.
What to look at
    ``deformed.png``: hinges below the load, right of the crown, near the left springing and in the right
    haunch. The right part of the barrel moves into the fill, whose passive pressure holds it: without the
    strength of the fill half the load is enough. ``stone_plastic_strain.png``: the soil is also pushed out
    beside the strip. ``von_mises.png``: the barrel's stress stays below 2.8 MPa.
Reference
    The test: 228 kN, a mechanism of four hinges (Page 1987, TRRL research report 110). Limit analysis with
    the fill as a load only, which spreads the strip's pressure by 1 in 2: 123 kN.
Cost
    20 seconds; with rigid voussoirs 40. Quadratic elements in the fill take 30 and give 225 kN, not 256:
    the linear ones are too stiff. The page "Fill over an arch" varies mesh and assumptions.

.. image:: /images/arch_bridge.png

.. image:: /images/arch_bridge_deformed.png

.. image:: /images/arch_bridge_plastic.png

.. literalinclude:: arch_bridge.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/arch_bridge_deformed.png"

from __future__ import annotations

import csv
import tempfile
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run
from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import RunResult
from masonry_fem.scene import specs
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch_bridge import ArchBridgeStructure

SCENE = Path(__file__).with_suffix(".toml")
WIDTH = 3.8  # of the bridge [m]
TEST = 228e3  # at failure [N]
SPREAD = 0.5  # of the load to either side, over the depth: without the strength of the fill
VARIANTS = {"elastic": (), "rigid": ("fidelity=rigid",)}
COLOURS = {"rigid": "#1f5fa8", "elastic": "#e07b1a"}


@dataclass(frozen=True, slots=True)
class Curve:
    """The load on the strip.

    Attributes
    ----------
    variant : What the voussoirs are. outcome : Of the run.
    sinking : Of the plate [m], shape (steps,). load : On the whole width [N], shape (steps,).
    hinges : Where joints of the barrel are open at one edge at the end, their x from left to right [m].
    """

    variant: str
    outcome: str
    sinking: np.ndarray
    load: np.ndarray
    hinges: tuple[float, ...]

    @property
    def peak(self) -> float:
        """The greatest load [N]."""
        return float(self.load.max())


@dataclass(frozen=True, slots=True)
class Bridge:
    """Loads at failure.

    Attributes
    ----------
    curves : With the strength of the fill. as_load : By limit analysis with the fill as load only [N].
    """

    curves: tuple[Curve, ...]
    as_load: float


def main(*, out: Path | None = None, variants: tuple[str, ...] = ("elastic",), steps: int = 8) -> Bridge:
    """Press the strip down in ``steps``, of which the first brings the weight."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        curves = tuple(pressed(variant, steps, folder / variant, out is not None) for variant in variants)
    scene = fill_as_load(load(SCENE))
    multiplier = analyse(scene, dead=("points.*",)).multiplier
    assert multiplier is not None
    found = Bridge(curves, WIDTH * multiplier)
    if out is not None:
        plot(found, out / "arch_bridge.png")
    return found


def pressed(variant: str, steps: int, folder: Path, pictures: bool) -> Curve:
    """One run, read from what it has written."""
    first = 1 / steps
    settings = (
        *VARIANTS[variant],
        f"analysis.load_steps={steps}",
        f"supports.2.motion.time.points=[[0.0, 0.0], [{first}, 0.0], [1.0, 1.0]]",
        f"loads.gravity_time.points=[[0.0, 0.0], [{first}, 1.0]]",
        f"output.pictures={str(pictures).lower()}",
    )
    scene = load(SCENE, overrides=settings)
    result = run(scene, folder)
    with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    time, force = (
        np.array([float(row[name]) for row in rows]) for name in ("time", "support_resultants.plate_fy")
    )
    sinking = 0.012 * np.maximum(time - first, 0.0) / (1 - first)
    return Curve(variant, result.outcome, sinking, -WIDTH * force, _hinges(result))


def _hinges(result: RunResult) -> tuple[float, ...]:
    """Joints of the barrel that are open more than their neighbours, by a fifth of the widest or more."""
    model, gap = result.built.model, result.march.state.gap
    radial = [k for k, one in enumerate(model.interfaces) if one.label == "radial"]
    radial.sort(key=lambda k: model.interfaces[k].polygon[:, 0].mean())
    widest = np.array([gap[model.contacts.interface == k].max() for k in radial])
    beside = np.concatenate([[0.0], widest, [0.0]])
    found = (widest > 0.2 * widest.max()) & (widest >= beside[:-2]) & (widest >= beside[2:])
    places = [model.interfaces[k].polygon[:, 0].mean() for k in np.array(radial)[found]]
    return tuple(float(place) for place in places)


def fill_as_load(scene: specs.Scene) -> specs.Scene:
    """The barrel alone, under the weight of the fill above each voussoir, and 1 N/m on the strip, spread."""
    bridge = scene.structures[0]
    assert isinstance(bridge, ArchBridgeStructure)
    assert bridge.strip is not None
    assert scene.loads.gravity is not None
    barrel = msgspec.structs.replace(bridge, filled=False, strip=None)
    made = build_structure(barrel, 2, Path(), scene.mesh)
    road = bridge.rise + bridge.thickness + bridge.cover
    weights, shares = [], []
    for number, block in enumerate(made.blocks):
        if block.support:
            continue
        solid = made.solid(number)
        (x1, y1), (x0, y0) = solid.face_points(solid.names.index("extrados"))
        deep = road - np.array([y0, y1])
        area = (x1 - x0) * deep.mean()
        middle = x0 + (x1 - x0) * (deep[0] + 2 * deep[1]) / (3 * deep.sum())
        weight = area * scene.materials["soil"].density * scene.loads.gravity[1]
        weights.append(
            specs.PointForce(block=block.name, vector=(0.0, weight), point=(middle, (y0 + y1) / 2))
        )
        low, high = np.array(bridge.strip) + SPREAD * deep.mean() * np.array([-1, 1])
        start, end = max(x0, low), min(x1, high)
        if start < end:
            shares.append((block.name, start, end, (y0 + y1) / 2, 1 / (high - low)))
    whole = sum((end - start) * pressure for _, start, end, _, pressure in shares)
    lines = [
        specs.LineForce(block=name, start=(start, y), end=(end, y), vector=(0.0, -pressure / whole))
        for name, start, end, y, pressure in shares
    ]
    return msgspec.structs.replace(
        scene,
        fidelity="rigid",
        structures=(barrel,),
        overrides=(),
        supports=(),
        joints=scene.joints[:1],
        loads=specs.Loads(gravity=scene.loads.gravity, points=tuple(weights), lines=tuple(lines)),
    )


def plot(found: Bridge, path: Path) -> Path:
    """Load against the sinking of the plate."""
    figure = Figure(figsize=(8, 4.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for one in found.curves:
        axes.plot(
            1e3 * one.sinking, one.load / 1e3, "o-", ms=3.5, color=COLOURS[one.variant], lw=1.8,
            label=f"fill of Mohr–Coulomb soil, {one.variant} voussoirs",
        )  # fmt: skip
    for value, name in ((TEST, "test"), (found.as_load, "limit analysis, fill as load only")):
        axes.axhline(value / 1e3, color="#22262b", lw=1.0, ls="--")
        text = f"{name}: {value / 1e3:.0f} kN"
        axes.annotate(text, (12.0, value / 1e3 - 3), color="#22262b", fontsize=9, ha="right", va="top")
    axes.set(xlabel="sinking of the plate [mm]", ylabel="load on the strip [kN]")
    axes.set_ylim(bottom=0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    bridge = main(out=Path("results/arch_bridge"), variants=tuple(VARIANTS))
    print(
        f"test {TEST / 1e3:.0f} kN; limit analysis with the fill as load only {bridge.as_load / 1e3:.1f} kN"
    )
    for one in bridge.curves:
        places = ", ".join(f"{place:.2f}" for place in one.hinges)
        print(f"{one.variant} voussoirs in soil: {one.peak / 1e3:.1f} kN; hinges at x = {places} m")
