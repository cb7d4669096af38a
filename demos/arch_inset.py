"""Where the contact points lie
============================

Geometry and material
    Plane semicircular arch of 11 rigid voussoirs, mean radius 1 m, thickness 0.18 m, no sliding.
Load
    Its weight.
What to look at
    Each joint has two contact points at ξ times the half-thickness from the mean line. The thrust line
    must pass between them, so that moving them inwards has the effect of a thinner arch of the same weight:
    it stands for ξ = 0.95 and 0.75 and collapses for ξ = 0.50.
Reference
    Limit analysis: critical ξ = 0.5833. The thrust over γR² lies in [0.0920, 0.1354] for ξ = 0.95 and in
    [0.1017, 0.1234] for ξ = 0.75; for ξ = 0.50 there is none.
Cost
    A few seconds.

.. image:: /images/arch_inset.png

.. literalinclude:: arch_inset.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/arch_inset.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from masonry_fem import load, solve
from masonry_fem.analyses.run import RunResult
from masonry_fem.bodies.base import by_block

SCENE = Path(__file__).with_suffix(".toml")
SPECIFIC_WEIGHT = 2400 * 9.81  # [N/m³]
INTERVALS = {0.95: (0.092031, 0.135356), 0.75: (0.101671, 0.123372)}
STONE, HELD, INK, FORCE = "#ebe5d8", "#a9adb2", "#33383f", "#c8352b"


@dataclass(frozen=True, slots=True)
class Inset:
    """One placement of the contact points.

    Attributes
    ----------
    inset : ξ. outcome : ``equilibrium`` or ``no_equilibrium``.
    thrust : Horizontal reaction over γR².
    crown : Displacement of the keystone [m] at the time of the picture, 0 where none was asked for.
    moving : Blocks that the program says to move.
    """

    inset: float
    outcome: str
    thrust: float
    crown: float
    moving: tuple[str, ...]


def main(
    *, out: Path | None = None, insets: tuple[float, ...] = (0.95, 0.75, 0.50), duration: float = 0.4
) -> list[Inset]:
    """Try each ξ; where ``out`` is given, picture what becomes of the arches after ``duration`` [s]."""
    figure = Figure(figsize=(5.2 * len(insets), 4.2), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    found = []
    for axes, inset in zip(figure.subplots(1, len(insets), squeeze=False)[0], insets, strict=True):
        settings = (f"joints.0.inset={inset}",)
        result = solve(load(SCENE, overrides=settings))
        force = result.summary.supports["arch.springing_left"].force
        thrust = abs(float(force[0])) / SPECIFIC_WEIGHT
        moving = tuple(one.block for one in result.summary.moving)
        crown = 0.0
        if out is not None:
            plan = f"analysis={{kind='dynamics', step=5e-3, duration={duration}, theta=1.0}}"
            crown = draw(axes, solve(load(SCENE, overrides=(*settings, plan))))
            stands = result.outcome == "equilibrium"
            word = f"stands, thrust {thrust:.3f} γR²" if stands else f"falls, after {duration:g} s"
            axes.set_title(f"ξ = {inset:g}: {word}", fontsize=15)
        found.append(Inset(inset, result.outcome, thrust, crown, moving))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        figure.savefig(out / "arch_inset.png")
    return found


def draw(axes: Axes, result: RunResult) -> float:
    """Draw blocks, contact points and reactions of a plane model; returns the keystone's displacement [m]."""
    model, state = result.built.model, result.march.state
    keystone = 0.0
    for group, own in zip(model.groups, state.bodies, strict=True):
        fields = by_block(group, group.displacements(own))
        for body, (block, moved) in enumerate(zip(group.blocks, fields, strict=True)):
            axes.add_patch(
                Polygon(
                    in_circle(group.nodes(body) + moved),
                    facecolor=HELD if group.prescribed else STONE,
                    edgecolor=INK,
                    lw=1.0,
                )
            )
            if model.assembly.blocks[block].name == "arch.v06":
                keystone = float(np.linalg.norm(moved.mean(axis=0)))
    loaded = state.reaction[:, 0] > 1e-9 * SPECIFIC_WEIGHT
    axes.plot(*state.points[~loaded].T, "o", ms=5, mfc="white", mec=INK, mew=0.9, label="open")
    axes.plot(*state.points[loaded].T, "o", ms=5, color=FORCE, label="pressed")
    axes.set_aspect("equal")
    axes.set(xlim=(-1.35, 1.35), ylim=(-0.35, 1.25))
    axes.axis("off")
    axes.legend(loc="lower center", frameon=False, fontsize=13, ncols=2)
    return keystone


def in_circle(points: Any) -> np.ndarray:
    """Corners of a convex polygon in the order of their angle about its middle, shape (n, 2)."""
    points = np.asarray(points)
    x, y = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(y, x))]


if __name__ == "__main__":
    for one in main(out=Path("results/arch_inset")):
        name = f"{len(one.moving)} blocks move" if one.moving else f"thrust {one.thrust:.4f} gamma R^2"
        print(f"inset {one.inset:4.2f}  {one.outcome:15} {name}")
