"""The extremes that docs/stability.md maps: what is driven, how far, and what the answer should be.

The scenes and their known answers are those of ``tests/extremes``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from masonry_fem import Scene
from masonry_fem.analyses.run import RunResult
from tests.extremes import scenes, solids


@dataclass(frozen=True, slots=True)
class Extreme:
    """One quantity driven to its extremes in one kind of scene.

    Attributes
    ----------
    name : What it is, for a panel and a row of the table.
    quantity : Label of the axis, with its unit.
    values : From end to end; 0 is drawn at the left end of a logarithmic axis.
    scene : The scene for a value. error : How far a result is from the known answer, relative.
    answer : The known answer in words.
    good : Error up to which the answer counts as reached.
    right : Outcomes that are right.
    limit : What limits the range, or why it has no end here.
    log : Whether the axis is logarithmic.
    """

    name: str
    quantity: str
    values: Sequence[float]
    scene: Callable[[float], Scene]
    error: Callable[[RunResult, float], float]
    answer: str
    limit: str
    good: float = 1e-6
    right: tuple[str, ...] = ("equilibrium", "finished")
    log: bool = True


SLIDING = scenes.G * (math.sin(math.pi / 6) - 0.5 * math.cos(math.pi / 6))  # down 30° with μ = 1/2 [m/s²]


def decades(low: int, high: int, every: int = 1) -> list[float]:
    """Powers of ten from 10^low to 10^high."""
    return [10.0**power for power in range(low, high + 1, every)]


NUMERICS = (
    Extreme(
        "time step, rigid wall",
        "step h [s]",
        decades(-12, 3),
        scenes.standing_wall,
        lambda result, h: scenes.wall_error(result),
        "the ground gives weight and push from the first step on",
        "no limit found",
    ),
    Extreme(
        "time step, elastic column",
        "step h [s]",
        [*decades(-12, -4), *decades(0, 3)],
        scenes.settling_column,
        scenes.column_error,
        "free fall far below the first wave's period (17 ms), statics in one step far beyond it",
        "rounding of the fall beside the column's size at short steps",
        good=1e-3,
    ),
    Extreme(
        "time step, sliding cube",
        "step h [s]",
        decades(-12, 3),
        scenes.sliding_block,
        lambda result, h: abs(result.march.report.speed / (SLIDING * 5 * h) - 1),
        "its speed is g (sin α − μ cos α) t after 5 steps",
        "no limit found",
    ),
    Extreme(
        "θ, sliding cube",
        "θ",
        [0.5, 0.6, 0.7, 0.8, 0.9, 1.0],
        lambda theta: scenes.sliding_block(0.01, theta=theta),
        lambda result, theta: scenes.sliding_error(result, 0.01, theta=theta),
        "it slides a h² n (n − 1 + 2θ)/2 in n steps",
        "no limit found",
        log=False,
    ),
    Extreme(
        "time step, bouncing cube",
        "step h [s]",
        decades(-6, -1),
        scenes.bouncing,
        lambda result, h: max(scenes.bouncing_gain(result), 0.0),
        "energy never grows (e = 1, θ = ½, 200 steps)",
        "no limit found",
    ),
    Extreme(
        "friction, rigid wall",
        "coefficient μ",
        [0.2, 0.4, 0.6, *decades(0, 6)],
        scenes.pushed_wall,
        lambda result, mu: scenes.wall_error(result),
        "the ground gives weight and a push of 0.1 g",
        "no limit found",
    ),
    Extreme(
        "friction, elastic wall",
        "coefficient μ",
        [0.2, 0.4, 0.6, *decades(0, 6)],
        lambda mu: scenes.pushed_wall(mu, fidelity="elastic"),
        lambda result, mu: scenes.wall_error(result),
        "the same",
        "no limit found",
    ),
    Extreme(
        "solver's tolerance, rigid wall",
        "solver.tolerance",
        decades(-14, -2),
        lambda tolerance: scenes.pushed_wall(tolerance=tolerance),
        lambda result, tolerance: scenes.wall_error(result),
        "the ground gives weight and push",
        "below 1e-14 rounding",
        good=1e-2,
    ),
    Extreme(
        "solver's tolerance, elastic wall",
        "solver.tolerance",
        decades(-14, -2),
        lambda tolerance: scenes.pushed_wall(fidelity="elastic", tolerance=tolerance),
        lambda result, tolerance: scenes.wall_error(result),
        "the same",
        "below 1e-13 rounding",
        good=1e-2,
    ),
    Extreme(
        "stack of rigid cubes",
        "blocks",
        [1, 3, 10, 30, 100, 300, 1000],
        lambda count: scenes.stack(int(count)),
        lambda result, count: scenes.stack_error(result),
        "joint k carries what lies above it",
        "memory",
    ),
    Extreme(
        "stack of elastic cubes",
        "blocks",
        [1, 3, 10, 30, 100, 300, 1000],
        lambda count: scenes.stack(int(count), "elastic"),
        lambda result, count: scenes.stack_error(result),
        "the same, and the top sinks by ρ g L²/2E",
        "memory",
    ),
    Extreme(
        "voussoirs of a rigid arch",
        "voussoirs",
        [5, 9, 21, 51, 101, 201, 401],
        lambda count: scenes.arch(int(count)),
        lambda result, count: scenes.arch_error(result),
        "the springings carry the weight",
        "no limit found",
    ),
    Extreme(
        "mass on mass, rigid",
        "upper mass / lower mass",
        decades(-8, 8, 2),
        scenes.mass_ratio,
        scenes.mass_ratio_error,
        "both joints carry what lies above them",
        "no limit found",
    ),
    Extreme(
        "mass on mass, elastic",
        "upper mass / lower mass",
        decades(-8, 8, 2),
        lambda ratio: scenes.mass_ratio(ratio, "elastic"),
        scenes.mass_ratio_error,
        "the same",
        "no limit found",
    ),
)

SOLIDS = (
    Extreme(
        "stiffness of all blocks",
        "E [Pa]",
        decades(3, 18),
        lambda young: solids.column([young] * 3),
        lambda result, young: solids.column_error(result),
        "joints carry what lies above, the top sinks by Σ N L/EA",
        "no limit found; strains of more than 5 % are warned of",
    ),
    Extreme(
        "stiffness of neighbours, column",
        "E of every other cube / E",
        decades(-8, 8, 2),
        lambda ratio: solids.column([1e10, 1e10 * ratio] * 2),
        lambda result, ratio: solids.column_error(result),
        "joints carry what lies above, the top sinks by Σ N L/EA",
        "no limit found",
    ),
    Extreme(
        "stiffness of neighbours, patch test",
        "E of the upper block / E of the lower",
        decades(-8, 8, 2),
        lambda ratio: solids.patch(ratio=ratio),
        lambda result, ratio: solids.patch_error(result),
        "uniform stress in both, meshes that do not match",
        "errors are measured by the softer block's compliance: a tighter solver.tolerance goes further",
    ),
    Extreme(
        "density of neighbours, column",
        "ρ of every other cube / ρ",
        decades(-8, 8, 2),
        lambda ratio: solids.column([1e10], [2400.0, 2400.0 * ratio] * 2),
        lambda result, ratio: solids.column_error(result),
        "joints carry what lies above, the top sinks by Σ N L/EA",
        "no limit found",
    ),
    Extreme(
        "Poisson's ratio, Q1",
        "1/2 − ν",
        [0.5, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6],
        lambda short: solids.confined(0.5 - short),
        lambda result, short: solids.confined_error(result),
        "a confined cube sinks by p/M",
        "rounding by 1/(1 − 2ν)",
    ),
    Extreme(
        "bending and Poisson's ratio, Q1",
        "1/2 − ν",
        [0.5, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        lambda short: solids.cantilever(0.5 - short),
        lambda result, short: abs(solids.cantilever_error(result)),
        "Timoshenko's deflection",
        "linear elements lock",
        good=0.1,
    ),
    Extreme(
        "bending and Poisson's ratio, Q2",
        "1/2 − ν",
        [0.5, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        lambda short: solids.cantilever(0.5 - short, element="Q2", divisions=(20, 2)),
        lambda result, short: abs(solids.cantilever_error(result)),
        "the same",
        "the clamp's effect on the deflection",
        good=0.1,
    ),
    Extreme(
        "size of a structure",
        "radius of an elastic arch [m]",
        decades(-3, 4),
        lambda radius: solids.arch(radius=radius),
        lambda result, radius: solids.arch_error(result),
        "springings carry the weight, equal thrusts",
        "no limit found",
    ),
    Extreme(
        "distance from the origin",
        "distance [m]",
        [1.0, *decades(2, 8)],
        lambda far: solids.arch(at=(far, 0.0)),
        lambda result, far: solids.arch_error(result),
        "the same",
        "coordinates keep 16 digits",
    ),
    Extreme(
        "slenderness of blocks",
        "length / thickness",
        decades(0, 5),
        solids.slender,
        lambda result, aspect: solids.carried_error(result),
        "joints carry what lies above",
        "rounding of K u, with the square of the slenderness",
    ),
    Extreme(
        "sizes of neighbours",
        "edge / edge",
        decades(0, 5),
        solids.sizes_apart,
        lambda result, ratio: solids.carried_error(result),
        "joints carry what lies above",
        "no limit found",
    ),
    Extreme(
        "acute voussoir",
        "half angle [deg]",
        [1, 2, 5, 10, 20, 30],
        solids.keystone,
        solids.keystone_error,
        "N = W/(2 sin a), H = W/(2 tan a)",
        "no limit found",
    ),
    Extreme(
        "elements beside larger ones",
        "edge / edge",
        [1, 2, 5, 10, 20, 50, 100],
        lambda ratio: solids.patch(divisions=((1, 1), (int(ratio), int(ratio)))),
        lambda result, ratio: solids.patch_error(result),
        "uniform stress in both blocks",
        "no limit found",
    ),
    Extreme(
        "narrow joints",
        "width of a ledge / edge of its block",
        decades(-9, 0),
        solids.ledges,
        lambda result, width: solids.ledges_error(result),
        "ledges carry the block",
        "what is narrower than 1e-4 of a face is a sliver, no contact",
    ),
    Extreme(
        "overlap of a cube and its floor",
        "overlap [m]",
        decades(-12, -1),
        lambda overlap: solids.lifted(-overlap, reach=1.0),
        lambda result, overlap: solids.rest_error(result, -overlap),
        "it stays where it is",
        "half a block's thickness: more is refused",
    ),
    Extreme(
        "gap under a cube",
        "gap [m]",
        decades(-12, 0),
        lambda gap: solids.lifted(gap, reach=2.0),
        solids.rest_error,
        "it comes down by the gap, to the solver's tolerance of its edge of 1 m",
        "no limit found",
    ),
)

FIGURES = {"stability_numerics": NUMERICS, "stability_solids": SOLIDS}
EXTREMES = {extreme.name: extreme for figure in FIGURES.values() for extreme in figure}
