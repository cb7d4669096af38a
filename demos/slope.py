"""Block on a slope
================

Geometry and material
    A rigid cube of 1 m and 2400 kg/m³ on an inclined plane, at rest at t = 0.
Load
    Its weight.
What to look at
    It sticks up to the slope tan α = μ and slides above. With the exact Coulomb cone there is no creep below
    the limit, and above it the θ-scheme reproduces the parabola.
Reference
    tan α = μ (26.565° for μ = 0.5). At α = 30° the acceleration is a = g (sin α − μ cos α) = 0.657 m/s²
    and s(1 s) = a/2 = 0.328573 m; for any θ exactly s_n = a h² n (n − 1 + 2θ)/2.
Cost
    A second.

.. image:: /images/slope.png
   :width: 70%

.. literalinclude:: slope.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/slope.png"

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, run, solve
from masonry_fem.analyses.run import RunResult

SCENE = Path(__file__).with_suffix(".toml")
G = 9.81


@dataclass(frozen=True, slots=True)
class Slope:
    """What the block does.

    Attributes
    ----------
    critical : Angle of friction atan μ [deg].
    speed_below, speed_above : Speed at the end, 0.05° below and above it [m/s].
    distance, exact : Slide at ``angle``, computed and by the formula of the scheme [m].
    """

    critical: float
    speed_below: float
    speed_above: float
    distance: float
    exact: float


def main(
    *,
    out: Path | None = None,
    angle: float = 30.0,
    friction: float = 0.5,
    step: float = 0.01,
    theta: float = 0.5,
) -> Slope:
    """Try the block below and above the angle of friction, then let it slide for 1 s at ``angle`` [deg]."""
    settings = (f"joints.0.friction={friction}", f"analysis.step={step}", f"analysis.theta={theta}")
    critical = math.degrees(math.atan(friction))
    below = solved(critical - 0.05, settings)
    above = solved(critical + 0.05, settings)
    slide = solved(angle, settings, out)
    a, alpha = G, math.radians(angle)
    a *= max(0.0, math.sin(alpha) - friction * math.cos(alpha))
    n = round(1.0 / step)
    return Slope(
        critical=critical,
        speed_below=below.march.report.speed,
        speed_above=above.march.report.speed,
        distance=math.hypot(*slide.summary.probes["cube"]),
        exact=a * step**2 * n * (n - 1 + 2 * theta) / 2,
    )


def solved(angle: float, settings: tuple[str, ...], out: Path | None = None) -> RunResult:
    """The scene at a slope of ``angle`` [deg], its results written where ``out`` is given."""
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y, z = 0.3, 0.3, 0.2  # corner of the cube in the frame of the plane
    corner = [x * cosine + z * sine, y, z * cosine - x * sine]
    turned = (
        f"structures.plane.rotation={angle}",
        f"structures.cube.rotation={angle}",
        f"structures.cube.position={corner}",
        f"probes.cube.point={corner}",
    )
    scene = load(SCENE, overrides=settings + turned)
    return solve(scene) if out is None else run(scene, out)


if __name__ == "__main__":
    found = main(out=Path("results/slope"))
    print(f"angle of friction        {found.critical:10.5f} deg")
    print(f"speed 0.05 deg below it  {found.speed_below:10.2e} m/s after 1 s")
    print(f"speed 0.05 deg above it  {found.speed_above:10.2e} m/s after 1 s")
    print(f"slide in 1 s at 30 deg   {found.distance:10.6f} m, exact {found.exact:.6f} m")
