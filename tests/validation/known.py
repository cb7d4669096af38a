"""Known answers: cases from books and formulas, computed; docs/validation.md is made of them.

for case in CASES: case.compute(), case.expected, case.bound
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from math import atan, cos, pi, radians, sin, sqrt
from pathlib import Path

import masonry_fem as mf
from masonry_fem.analyses.limit import analyse

DEMOS = Path(__file__).parents[2] / "demos"
G = 9.81


@dataclass(frozen=True, slots=True)
class Case:
    """A case with a known answer.

    Attributes
    ----------
    name : What is computed. unit : Of the answer. source : Of the answer.
    expected : The answer. bound : Relative error that is allowed.
    compute : What the program makes of it.
    """

    name: str
    unit: str
    source: str
    expected: float
    bound: float
    compute: Callable[[], float]

    def error(self, obtained: float) -> float:
        """Relative error."""
        return abs(obtained / self.expected - 1)


STONE = {"density": 2400, "young": "10 GPa", "poisson": 0.0}


def stack(size, *, count=1, friction=0.6, **more):
    """A plane stack of rigid blocks under its weight."""
    block = {"kind": "stack", "name": "s", "material": "stone", "size": size, "count": count}
    given = {"dimension": 2, "fidelity": "rigid", "joints": [{"friction": friction}]}
    given |= {"materials": {"stone": STONE}, "structures": [block], "loads": {"gravity": [0, -G]}}
    return mf.check(mf.Scene(**given | more))


def arch(thickness, *, friction=0.9, voussoirs=61):
    """A plane semicircular arch of mean radius 1 m."""
    given = {"kind": "arch", "name": "a", "material": "stone", "radius": 1.0, "thickness": thickness}
    return stack([1, 1], structures=[given | {"voussoirs": voussoirs}], friction=friction)


def halved(stands: Callable[[float], bool], low: float, high: float) -> float:
    """Where ``stands`` begins to hold between two values."""
    for _ in range(16):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(middle) else (middle, high)
    return 0.5 * (low + high)


def slid() -> float:
    """How far the cube of ``demos/slope.toml`` slides in a second."""
    moved = mf.solve(mf.load(DEMOS / "slope.toml")).summary.probes["cube"]
    return sqrt(float(moved @ moved))


def rising() -> float:
    """How high a block rises again."""
    heights = []

    def see(model, state, report):
        heights.append((report.time, report.probes["block"][2]))

    mf.solve(mf.load(DEMOS / "bouncing.toml", ["analysis.duration=1.4"]), observers=[see])
    hit = next(time for time, height in heights if height < -0.99)
    return 1.0 + max(height for time, height in heights if time > hit + 0.02)


def hanging(order: int, quantity: str) -> float:
    """A column of an elastic stone on the ground: how much its top sinks, or its mean stress."""
    column = stack(
        [1, 4], fidelity="elastic", mesh={"element": f"Q{order}", "divisions": [1, 4]},
        probes=[{"name": "top", "block": "s.b1", "point": [0.5, 4.0]}],
    )  # fmt: skip
    made = mf.solve(column)
    if quantity == "top":
        return -float(made.summary.probes["top"][1])
    return float(made.summary.supports["s.ground"].force[1])


def multiplier(scene: mf.Scene) -> float:
    """Of a horizontal acceleration, over g, by limit analysis."""
    return float(analyse(scene, tilt="x").multiplier)


def simulated(scene: mf.Scene) -> float:
    """The same by simulation."""
    found = mf.collapse(scene, acceleration="x", tolerance=1e-3).summary
    return 0.5 * (found.stands + found.falls)


@cache
def least_angle() -> float:
    """Angle at which a squat block begins to slide [deg]."""

    def slides(angle: float) -> bool:
        gravity = [G * sin(radians(angle)), -G * cos(radians(angle))]
        outcome = mf.solve(stack([2, 1], friction=0.5, loads={"gravity": gravity})).outcome
        assert outcome in {"equilibrium", "no_equilibrium"}
        return outcome == "no_equilibrium"

    return halved(slides, 20.0, 35.0)


CASES = (
    Case("block on a slope of 30°, μ = 0.5: way in 1 s", "m", "s = g (sin α − μ cos α) t²/2",
         0.5 * G * (sin(radians(30)) - 0.5 * cos(radians(30))), 1e-6, slid),
    Case("block on a slope, μ = 0.5: angle at which it slides", "°", "atan μ",
         atan(0.5) * 180 / pi, 1e-4, least_angle),
    Case("block dropped from 1 m, restitution 0.8: next apex", "m", "e² H", 0.64, 5e-3, rising),
    Case("column 0.6 × 3 m: acceleration at which it tips, limit analysis", "g", "width over height",
         0.2, 1e-6, lambda: multiplier(stack([0.6, 1.0], count=3))),
    Case("the same by simulation", "g", "width over height", 0.2, 2e-3,
         lambda: simulated(stack([0.6, 1.0], count=3))),
    Case("squat block, μ = 0.4: acceleration at which it slides", "g", "μ", 0.4, 1e-6,
         lambda: multiplier(stack([2, 1], friction=0.4))),
    Case("semicircular arch: least thickness over radius", "–",
         "Milankovitch 1907, 0.1075 (Cocchetti, Colasante and Rizzi 2011)", 0.1075, 4e-3,
         lambda: halved(lambda t: bool(analyse(arch(t)).admissible), 0.09, 0.13)),
    Case("column of 4 m on the ground: its top sinks", "m", "ρ g h²/(2 E)", 2400 * G * 16 / 2e10, 1e-9,
         lambda: hanging(2, "top")),
    Case("the same: force on the ground", "N/m", "ρ g h b", 2400 * G * 4, 1e-9,
         lambda: hanging(1, "force")),
)  # fmt: skip

HEAD = """# Known answers

<!-- made by docs/make_validation.py from tests/validation/known.py; do not edit -->

Cases whose answer is known from a book or a formula, and what the program obtains. This page is made from
`tests/validation/known.py`; a test computes each case anew and compares it with its bound and with this page.

| case | expected | obtained | error | allowed | source |
|---|---|---|---|---|---|
"""
TAIL = """
## More

Pages with more comparisons, each checked by tests:

| what | page |
|---|---|
| limit analysis of arches, walls and domes beside independent ones | [Limit analysis](limit_analysis.md) |
| peeling cracks, bars with snap-back, cyclic shear of joints | [Joints with cohesion](joints.md) |
| Hertz, Cattaneo and Mindlin, the patch test of oblique cuts | [How contacts are found](detection.md) |
| estimated against true errors of stress | [How accurate it is](errors.md) |
| Navier's column, plates in two directions | [Strength check](strength.md) |
| Duhamel's integral, Housner's block under pulses, spectra | [Shaking](shaking.md#known-answers) |
| least thickness, friction and spread of arches | [Thresholds](thresholds.md) |
| rafters, portals and rings with ties | [Ties](ties.md) |
| laws of stone, limit loads, cracks, rotations | [Stones that turn, yield and crack](stones_shown.md) |
| real walls and bridges beside tests | [Real walls and bridges](real_structures.md) |
"""


def row(case: Case, obtained: float) -> str:
    """The page's line of a case."""
    error = case.error(obtained)
    told = "< 1e-9" if error < 1e-9 else f"{error:.0e}"
    figures = f"{case.expected:.5g} {case.unit} | {obtained:.5g} {case.unit}".replace(" –", "")
    return f"| {case.name} | {figures} | {told} | {case.bound:.0e} | {case.source} |\n"


def page(obtained: Mapping[Case, float]) -> str:
    """The whole page."""
    return HEAD + "".join(row(case, value) for case, value in obtained.items()) + TAIL
