"""Window bay from a survey
========================

Geometry and material
    ``meshes/window_bay.csv``: the measured faces of 284 ashlars of a façade 7.2 m wide and 8 m high, as
    stereophotogrammetry gives them, made by a script with 2 mm of noise on each corner. A window of 1.6 m
    under a segmental arch of nine voussoirs, a relieving course above it, and a crack that runs from the
    arch to the top. Stones are extruded to 50 cm: 12 GPa, 2200 kg/m³, friction 0.6, dry, all elastic.
Load
    Its weight, and 43 kPa on top for two metres of wall above.
What to look at
    Corners are moved by 7 mm at most to make 762 joints that fit; three joints of the crack, 13 to 17 mm
    wide, stay open. The load flows around the window into the piers: stones above the arch and below the
    sill are nearly free of stress. Contact points are at the corners of the joints' polygons, where they
    concentrate stress: 5 % of the volume has more than 322 kPa. With ``placement = "nodes"`` it is 229 kPa,
    at four times the cost.
Reference
    By hand: the ground carries the stones' weight and the load, 724 kN; the bed joints of the piers half-way
    up the window carry everything above them, 498 kN, half on each side to 1 %. The weight of the stones
    agrees with that before the noise to 0.2 %. Below the sill the mean pressure is a third of that in the
    piers.
Cost
    20 seconds and 0.5 GB to solve, 20 to draw.

.. image:: /images/window_bay.png

.. image:: /images/window_bay_resultants.png

.. literalinclude:: window_bay.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/window_bay.png"

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run, solve
from masonry_fem.analyses.run import RunResult
from masonry_fem.output.interfaces import interface_forces
from masonry_fem.results.summary import Certificate

SCENE = Path(__file__).with_suffix(".toml")
BED = 10  # courses below the bed half-way up the window
DENSITY, GRAVITY, PRESSURE = 2200.0, 9.81, 43e3  # as in the scene


@dataclass(frozen=True, slots=True)
class WindowBay:
    """What the bay carries.

    Attributes
    ----------
    outcome : ``equilibrium``. stones, joints : How many there are.
    load, ground : Weight and load by hand from the stones, and what the ground bears [N].
    above, piers : Load above the bed half-way up the window by hand; its part on the left and on the right
        pier, shape (2,) [N].
    shares : Mean pressure under the sill, and two courses over the arch, over that in the piers, shape (2,).
    thrust : Horizontal force at the keystone's left joint [N].
    open : Widest opening that the load made in a joint [m].
    certificate : Error measures. seconds : CPU time.
    """

    outcome: str
    stones: int
    joints: int
    load: float
    ground: float
    above: float
    piers: np.ndarray
    shares: np.ndarray
    thrust: float
    open: float
    certificate: Certificate
    seconds: float


def main(*, out: Path | None = None, fidelity: str = "elastic") -> WindowBay:
    """Bring the bay to equilibrium; pictures go to ``out``."""
    scene = load(SCENE, overrides=(f"fidelity='{fidelity}'",))
    base = SCENE.parent
    result = solve(scene, base) if out is None else run(scene, out, base=base)
    return _read(result)


def _read(result: RunResult) -> WindowBay:
    model = result.built.model
    names = [block.name.removeprefix("bay.") for block in model.assembly.blocks]
    solids = [model.assembly.solid(number) for number in range(len(names))]
    weight = np.array([DENSITY * GRAVITY * one.mass_properties().volume for one in solids])
    for number, (name, solid) in enumerate(zip(names, solids, strict=True)):
        if name.startswith("c25"):
            weight[number] += PRESSURE * np.linalg.norm(solid.area_vector(solid.names.index("top")))
    weight[names.index("ground")] = 0.0
    told = interface_forces(model, result.march.state)
    pairs = np.array([one.blocks for one in model.interfaces])
    upper = np.array([_course(name) for name in names])
    bed = upper[pairs].min(axis=1) == BED
    bed &= upper[pairs].max(axis=1) == BED + 1
    x = np.array([one.polygon[:, 0].mean() for one in model.interfaces])
    area = np.array([one.area for one in model.interfaces])
    pier = np.abs(told.force[:, 2])
    sill = (upper[pairs].max(axis=1) == 6) & (upper[pairs].min(axis=1) == 5) & (np.abs(x - 3.6) < 0.8)
    crown = (upper[pairs].max(axis=1) == 20) & (upper[pairs].min(axis=1) == 19) & (np.abs(x - 3.6) < 0.8)
    mean = pier[bed].sum() / area[bed].sum()
    keystone = [{names[a], names[b]} == {"arch4", "arch5"} for a, b in pairs]
    return WindowBay(
        outcome=result.outcome,
        stones=len(names) - 1,
        joints=len(pairs),
        load=float(weight.sum()),
        ground=float(result.summary.supports["bay.ground"].force[2]),
        above=float(weight[upper > BED].sum()),
        piers=np.array([pier[bed & (x < 3.6)].sum(), pier[bed & (x > 3.6)].sum()]),
        shares=np.array([pier[one].sum() / area[one].sum() / mean for one in (sill, crown)]),
        thrust=float(np.abs(told.force[keystone, 0]).sum()),
        open=float(told.opening.max()),
        certificate=result.summary.certificate,
        seconds=sum(result.summary.seconds.values()),
    )


def _course(name: str) -> int:
    """Number of the course of a stone from below; those of the arch and over it stand for theirs."""
    found = re.match(r"c(\d+)s", name)
    return int(found[1]) if found else {"ground": 0, "arch": 16, "relief": 18}[name.rstrip("0123456789")]


if __name__ == "__main__":
    bay = main(out=Path("results/window_bay"))
    left, right = bay.piers / 1e3
    print(f"{bay.outcome}; natural map {bay.certificate.natural_map:.1e}, {bay.seconds:.0f} s of CPU time")
    print(f"{bay.stones} stones, {bay.joints} joints")
    print(f"ground carries        {bay.ground / 1e3:8.2f} kN, load by hand {bay.load / 1e3:.2f} kN")
    print(f"piers carry           {left:8.2f} and {right:.2f} kN of {bay.above / 1e3:.2f} kN above")
    print(
        f"pressure under sill   {bay.shares[0]:8.2f} of that in the piers, over the arch {bay.shares[1]:.2f}"
    )
    print(f"thrust at keystone    {bay.thrust / 1e3:8.2f} kN")
    print(f"widest new opening    {bay.open * 1e6:8.1f} um")
