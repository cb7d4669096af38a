"""Joint laws: what a wall with cohesive joints costs, against the same wall dry.

python -m benchmarks.joint_laws
python -m benchmarks.joint_laws --walls 40x20 --laws dry,monerie_acary --loads 0.6

Rigid bricks march in time, elastic ones are loaded in static steps. Strengths are of two kinds: ``strong``
joints stay whole, ``weak`` ones are damaged by the load. CPU time of the march on one thread, without the
build; the bar is twice the dry wall's.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from benchmarks.cases import G, scene, wall
from masonry_fem.analyses.run import solve_scene
from masonry_fem.nscd.threads import one_thread
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Acceleration,
    AnyLaw,
    Dynamics,
    Joint,
    Loads,
    MeshSettings,
    Solver,
    Statics,
    law_record,
)

STRENGTH = {"strong": 0.35e6, "weak": 2e3}
STIFF = {"normal_stiffness": 8e10, "tangential_stiffness": 4e10}
STEPS = 20


def laws(strength: float) -> dict[str, AnyLaw | None]:
    """Laws of about the same strength [Pa]."""
    softening = {"normal_strength": strength, "tangential_strength": strength}
    energy = strength**2 / STIFF["tangential_stiffness"]
    return {
        "dry": None,
        "mohr_coulomb": law_record("mohr_coulomb", cohesion=strength),
        "elastic": law_record("elastic", **STIFF),
        "fremond_cangemi": law_record("fremond_cangemi", **STIFF, energy=energy),
        "monerie_acary": law_record("monerie_acary",
            **STIFF, **softening, normal_energy=20.0 * energy, tangential_energy=20.0 * energy
        ),
    }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Row:
    """One wall with one law."""

    wall: str
    bricks: str
    load: float
    law: str
    outcome: str
    steps: int
    damaged: float
    seconds: float

    @property
    def step(self) -> float:
        """CPU time of a step [s]."""
        return self.seconds / max(self.steps, 1)


def solved(columns: int, courses: int, bricks: str, load: float, law: AnyLaw | None, friction: float) -> Row:
    """March of a wall under its weight and ``load`` g along it."""
    elastic = bricks == "elastic"
    given = scene(
        wall(columns, courses),
        fidelity=bricks,
        mesh=MeshSettings(divisions=(4, 2, 2)),
        joints=(Joint(friction=friction, law=law),),
        loads=Loads(gravity=(0.0, 0.0, -G), accelerations=(Acceleration(vector=(G * load, 0.0, 0.0)),)),
        analysis=Statics(load_steps=STEPS) if elastic else Dynamics(step=1e-2, duration=STEPS * 1e-2),
        solver=Solver(tolerance=1e-8),
    )
    result = solve_scene(check(given))
    joints, spent = result.march.state.joints, result.march.seconds
    return Row(
        wall=f"{columns}x{courses}",
        bricks=bricks,
        load=load,
        law="dry" if law is None else str(law.__struct_config__.tag),
        outcome=result.outcome,
        steps=result.march.report.step,
        damaged=0.0 if law is None else float((joints.adhesion < 1).mean()),
        seconds=sum(spent.get(phase, 0.0) for phase in ("factorise", "solve", "step")),
    )


def rows(arguments: argparse.Namespace) -> Iterator[tuple[str, Row]]:
    """(strength, row) of every case; the dry wall first, which the others are measured by."""
    wanted = arguments.laws.split(",")
    for size in arguments.walls.split(","):
        columns, courses = (int(part) for part in size.split("x"))
        for bricks in arguments.bricks.split(","):
            for load in (float(part) for part in arguments.loads.split(",")):
                yield "", solved(columns, courses, bricks, load, None, arguments.friction)
                for name, strength in STRENGTH.items():
                    for kind, law in laws(strength).items():
                        if kind in wanted and law is not None:
                            yield name, solved(columns, courses, bricks, load, law, arguments.friction)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--walls", default="10x10,40x20")
    parser.add_argument("--bricks", default="rigid", help="rigid, elastic or both, with a comma")
    parser.add_argument("--loads", default="0.3,0.6", help="horizontal load over the weight")
    parser.add_argument("--friction", type=float, default=0.4)
    parser.add_argument("--laws", default=",".join(laws(1.0)))
    arguments = parser.parse_args()
    table = Table(
        "wall", "bricks", "load / g", "law", "strength", "outcome", "steps", "damaged", "ms a step", "× dry"
    )
    console, dry = Console(), math.nan
    with one_thread():
        solved(2, 2, "rigid", 0.1, laws(1e5)["monerie_acary"], 0.6)  # loads what is compiled
        for strength, row in rows(arguments):
            dry = row.step if row.law == "dry" else dry
            cells = (row.wall, row.bricks, f"{row.load:g}", row.law, strength, row.outcome, f"{row.steps}")
            table.add_row(*cells, f"{row.damaged:.0%}", f"{1e3 * row.step:.1f}", f"{row.step / dry:.2f}")
            console.print(*cells, f"{row.damaged:.0%} {1e3 * row.step:.1f} {row.step / dry:.2f}")
    console.print(table)


if __name__ == "__main__":
    main()
