"""Scenes at the extremes of numerics, each with a known answer.

    result = solve_scene(stack(1000, "elastic"))
    stack_error(result)

A builder takes what makes its scene extreme and returns the scene; its known answer stands in its docstring,
and the function ``..._error`` of its result returns the distance to it, relative to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Analysis,
    Contact,
    Dynamics,
    Equilibrium,
    Fidelity,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Override,
    Probe,
    Scene,
    Solver,
    Statics,
    Support,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

G = 9.81
DENSITY = 2400.0
YOUNG = 10e9
STONE = Material(density=DENSITY, young=YOUNG, poisson=0.2)
NO_RESTRAINT = Material(density=DENSITY, young=YOUNG, poisson=0.0)
WEIGHT = DENSITY * G  # of a cubic metre [N]
MOST_ROUNDING = 1e-6  # met by μ = 1e8; else 1e-7
DEFAULT = 1e-10  # tolerance of a scene that names none

LARGE_STEP = Equilibrium(strategy="large_step", step=1.0, max_steps=5)
Dimension = Literal[2, 3]
Friction = float | Literal["no slip"]


def down(dimension: int) -> tuple[float, ...]:
    """Gravity."""
    return (0.0,) * (dimension - 1) + (-G,)


def leaning(angle: float, dimension: int) -> tuple[float, ...]:
    """Gravity on a slope of ``angle`` [deg] that goes down along x: it is turned, not the ground."""
    a = np.radians(angle)
    return (float(G * np.sin(a)), *(0.0,) * (dimension - 2), float(-G * np.cos(a)))


def certificate(result: RunResult) -> dict[str, float]:
    """What the certificate says of contact, of balance and of energy; all are relative.

    Of the natural map only what is more than rounding makes of it, which is told beside it.
    """
    told = result.summary.certificate
    balances = {key: getattr(told, key) for key in ("block_balance", "global_balance", "energy_balance")}
    known = min(told.rounding.natural_map, MOST_ROUNDING)
    return {"natural_map": told.natural_map if told.natural_map > known else 0.0, **balances}


def arrived(scene: Scene) -> str:
    """Outcome of a run that succeeds: dynamics lasts for its duration, all else ends at rest."""
    return "finished" if isinstance(scene.analysis, Dynamics) else "equilibrium"


def finite(result: RunResult) -> bool:
    """Whether all numbers of the last state and of the summary are."""
    state = result.march.state
    parts = [state.reaction, state.velocity, state.gap, state.points]
    parts += list(result.march.report.support_resultants.values())
    parts += [np.array(list(certificate(result).values())), np.array(astuple(result.summary.energy))]
    return all(bool(np.isfinite(part).all()) for part in parts)


def base_force(result: RunResult) -> NDArray[np.float64]:
    """Sum of what all supports give [N], shape (d,)."""
    return np.sum([told.force for told in result.summary.supports.values()], axis=0)


# --- many blocks and unequal ones --------------------------------------------------------------------


def stack(
    count: int, fidelity: Fidelity = "rigid", analysis: Analysis | None = None, divisions: int = 1,
    tolerance: float = DEFAULT, friction: float = 0.6, **solver: Any,
) -> Scene:  # fmt: skip
    """A9.1: cubes of 1 m one on another, ν = 0.

    Joint k (from 0) carries (count − k) W; where elastic, the top sinks by ρ g L²/2E (``stack_error``).
    """
    return Scene(
        fidelity=fidelity,
        materials={"stone": NO_RESTRAINT},
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=count),),
        mesh=MeshSettings(divisions=(divisions,) * 3),
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=down(3)),
        probes=(Probe(name="top", block=f"stack.b{count}", point=(0.5, 0.5, float(count))),),
        analysis=analysis or Statics(),
        solver=Solver(tolerance=tolerance, **solver),
    )


def joint_forces(result: RunResult) -> NDArray[np.float64]:
    """Sum of the normal reactions of each level joint, from the ground up [N]."""
    state, joint = result.march.state, result.built.model.contacts.interface
    force, height = (np.bincount(joint, values) for values in (state.reaction[:, 0], state.points[:, -1]))
    return force[np.argsort(height / np.bincount(joint))]


def stack_error(result: RunResult) -> float:
    """Worst of the joints' forces, relative to each, and of the settlement where blocks are elastic."""
    forces = joint_forces(result)
    count = len(forces)
    error = np.abs(forces / (np.arange(count, 0, -1) * WEIGHT) - 1).max()
    if result.built.stones.deforming:
        settlement = WEIGHT * count**2 / 2 / YOUNG
        error = max(error, abs(result.summary.probes["top"][2] / -settlement - 1))
    return float(error)


def mass_ratio(
    ratio: float, fidelity: Fidelity = "rigid", analysis: Analysis | None = None,
    tolerance: float = DEFAULT,
) -> Scene:  # fmt: skip
    """A9.2: a cube ``ratio`` times as heavy as the cube below it, of which a cubic metre weighs 1 kg.

    The joints carry (1 + ratio) g and ratio · g (``mass_ratio_error``).
    """
    light, heavy = (Material(density=density, young=10e9, poisson=0.2) for density in (1.0, ratio))
    return Scene(
        fidelity=fidelity,
        materials={"light": light, "heavy": heavy},
        structures=(StackStructure(name="pair", material="light", size=(1, 1, 1), count=2),),
        overrides=(Override(blocks="pair.b2", material="heavy"),),
        loads=Loads(gravity=down(3)),
        analysis=analysis or Statics(),
        solver=Solver(tolerance=tolerance),
    )


def mass_ratio_error(result: RunResult, ratio: float) -> float:
    """Worst of the two joints' forces, relative to each."""
    expected = np.array([1.0 + ratio, ratio]) * G
    return float(np.abs(joint_forces(result) / expected - 1).max())


# --- friction ----------------------------------------------------------------------------------------


def block_on_slope(
    friction: Friction = 0.6, angle: float = 20.0, fidelity: Fidelity = "rigid", dimension: Dimension = 3,
    analysis: Analysis | None = None, edge: float = 1.0, **solver: Any,
) -> Scene:  # fmt: skip
    """A1.1, A9.6: a cube on a slope. It rests iff tan(angle) ≤ μ, and tips from 45° on.

    At rest the ground gives (−W sin, W cos) (``slope_error``).
    """
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(StackStructure(name="cube", material="stone", size=(edge,) * dimension, count=1),),
        mesh=MeshSettings(divisions=(2,) * dimension),
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=leaning(angle, dimension)),
        probes=(Probe(name="cube", block="cube.b1", point=(0.5 * edge,) * dimension),),
        analysis=analysis or Statics(),
        solver=Solver(**solver),
    )


def slope_error(result: RunResult, angle: float = 20.0) -> float:
    """What the ground gives against the weight."""
    force = base_force(result)
    return float(np.linalg.norm(force + DENSITY * np.array(leaning(angle, len(force))))) / WEIGHT


def arch(
    voussoirs: int = 9, thickness: float = 0.2, friction: Friction = 0.6, fidelity: Fidelity = "rigid",
    dimension: Dimension = 2, analysis: Analysis | None = None, divisions: int = 2, **solver: Any,
) -> Scene:  # fmt: skip
    """A3: semicircular arch of mean radius 1 m.

    With ``friction`` ≥ 0.4 it stands iff it is thicker than A3.2 says (0.10748 for many voussoirs), and with
    no friction it never does (A9.6). The springings carry its weight, π R t ρ g (``arch_error``); what each
    of them carries is not unique where voussoirs are rigid.
    """
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(
            ArchStructure(
                name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs
            ),
        ),
        mesh=MeshSettings(divisions=(divisions,) * dimension),
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=down(dimension)),
        analysis=analysis or Statics(),
        solver=Solver(**solver),
    )


def arch_weight(result: RunResult) -> float:
    """Of its blocks as they are built: elements of curved voussoirs have chords for arcs [N]."""
    groups = result.built.model.groups
    return G * sum(float(group.mass.sum()) for group in groups if not group.prescribed)


def arch_error(result: RunResult) -> float:
    """What the springings give together against the weight."""
    weight, force = arch_weight(result), base_force(result)
    force[-1] -= weight
    return float(np.linalg.norm(force) / weight)


def thrust(result: RunResult) -> float:
    """Horizontal force of the left springing over γ R² (R = 1 m, a metre deep)."""
    return float(abs(result.summary.supports["arch.springing_left"].force[0])) / WEIGHT


def pushed_wall(
    friction: Friction = 0.6, push: float = 0.1, fidelity: Fidelity = "rigid", dimension: Dimension = 2,
    analysis: Analysis | None = None, columns: int = 3, courses: int = 4, **solver: Any,
) -> Scene:  # fmt: skip
    """A4: a wall in running bond under gravity and a horizontal acceleration of ``push`` g.

    It slides for certain where μ < push; where it stands its ground gives its whole weight and the push
    (``wall_error``).
    """
    brick = (0.4, 0.2) if dimension == 2 else (0.4, 0.2, 0.2)
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(
            WallStructure(name="wall", material="stone", brick=brick, columns=columns, courses=courses),
        ),
        mesh=MeshSettings(divisions=(2,) * dimension),
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=(push * G, *down(dimension)[1:])),
        analysis=analysis or Statics(),
        solver=Solver(**solver),
    )


def wall_error(result: RunResult, push: float = 0.1) -> float:
    """What the ground gives against weight and push."""
    force = base_force(result)
    mass = arch_weight(result) / G
    load = mass * np.array([push * G, *down(len(force))[1:]])
    return float(np.linalg.norm(force + load) / np.linalg.norm(load))


# --- time --------------------------------------------------------------------------------------------


def settling_column(step: float, theta: float = 1.0, steps: int = 1) -> Scene:
    """A2.4: gravity at once on a bar of 3 m at rest, E = 1 GPa, ν = 0.

    θ = 1 and a step far beyond its first wave's period (17 ms) make one step statics: the base carries
    ρ g L and the top sinks by ρ g L²/2E. A step far below it lets the top fall freely, by
    g h² n (n − 1 + 2θ)/2 (``column_error``).
    """
    return Scene(
        dimension=2,
        materials={"stone": Material(density=2000.0, young=1e9, poisson=0.0)},
        structures=(StackStructure(name="column", material="stone", size=(1.0, 3.0), count=1),),
        mesh=MeshSettings(divisions=(1, 12)),
        joints=(Joint(friction=0.0),),
        loads=Loads(gravity=down(2)),
        analysis=Dynamics(step=step, duration=steps * step, theta=theta),
        probes=(Probe(name="top", block="column.b1", point=(0.5, 3.0)),),
    )


COLUMN_PERIOD = float(4 * 3.0 / np.sqrt(1e9 / 2000.0))  # of the first wave [s]


def column_error(result: RunResult, step: float, theta: float = 1.0, steps: int = 1) -> float:
    """Of the base's force and the top's fall far beyond a period; of the fall alone far below it."""
    top = -result.summary.probes["top"][1]
    if step < COLUMN_PERIOD:
        return float(abs(top / (G * step**2 * steps * (steps - 1 + 2 * theta) / 2) - 1))
    weight = 2000.0 * G * 3.0
    return float(max(abs(base_force(result)[1] / weight - 1), abs(top / (weight * 3.0 / 2e9) - 1)))


def sliding_block(
    step: float, steps: int = 5, theta: float = 1.0, fidelity: Fidelity = "rigid", angle: float = 30.0,
    friction: float = 0.5,
) -> Scene:  # fmt: skip
    """A1.2: a cube slides down a slope with a = g (sin − μ cos).

    It goes a h² n (n − 1 + 2θ)/2 in n steps, by algebra, whatever the step (``sliding_error``).
    """
    scene = block_on_slope(
        friction, angle, fidelity, 2, Dynamics(step=step, duration=steps * step, theta=theta)
    )
    return scene


def sliding_error(
    result: RunResult, step: float, steps: int = 5, theta: float = 1.0, angle: float = 30.0,
    friction: float = 0.5,
) -> float:  # fmt: skip
    """Of the way down."""
    a = np.radians(angle)
    gone = G * (np.sin(a) - friction * np.cos(a)) * step**2 * steps * (steps - 1 + 2 * theta) / 2
    return float(abs(result.summary.probes["cube"][0] / gone - 1))


def standing_wall(
    step: float, steps: int = 3, theta: float = 1.0, fidelity: Fidelity = "rigid", **solver: Any
) -> Scene:
    """The wall of ``pushed_wall`` under dynamics from rest: it stays where it is, and its ground gives the
    load from the first step on (``wall_error``; elastic blocks only after steps beyond their waves)."""
    march = Dynamics(step=step, duration=steps * step, theta=theta)
    return pushed_wall(fidelity=fidelity, analysis=march, **solver)


def bouncing(step: float, restitution: float = 1.0, steps: int = 200, drop: float = 0.01) -> Scene:
    """A1.5: a cube falls by ``drop`` on the ground and bounces, with θ = ½ and the velocity form.

    Its energy never grows, and at e = 1 is kept (``bouncing_gain``).
    """
    return Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": STONE},
        structures=(StackStructure(name="cube", material="stone", size=(0.5, 0.5), count=1, gap=drop),),
        contact=Contact(reach=2 * drop),
        joints=(Joint(friction=0.5, restitution=restitution, form="velocity"),),
        loads=Loads(gravity=down(2)),
        analysis=Dynamics(step=step, duration=steps * step, theta=0.5),
        probes=(Probe(name="cube", block="cube.b1", point=(0.25, drop)),),
    )


def bouncing_gain(result: RunResult, drop: float = 0.01) -> float:
    """Energy gained since the start over what the drop has [J/J]; negative where energy was lost."""
    mass = DENSITY * 0.25
    rise = result.summary.probes["cube"][1]
    return float((result.march.report.kinetic_energy + mass * G * rise) / (mass * G * drop))


# --- nothing much ------------------------------------------------------------------------------------


def weightless(fidelity: Fidelity = "rigid", analysis: Analysis | None = None) -> Scene:
    """A stack of three cubes without gravity: no force anywhere, nothing moves, in any analysis."""
    return Scene(
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=3),),
        mesh=MeshSettings(divisions=(1, 1, 1)),
        analysis=analysis or Statics(),
    )


def lonely(
    kind: Literal["held", "free", "clamped"], fidelity: Fidelity = "rigid", analysis: Analysis | None = None,
    dimension: Dimension = 3,
) -> Scene:  # fmt: skip
    """A single cube and no contact at all.

    ``held`` as a whole, it carries nothing and stays; ``free``, it falls by g t²/2, and has no equilibrium;
    ``clamped`` at its base (elastic), that base gives its weight.
    """
    supports = {
        "held": (Support(on="cube"),),
        "free": (),
        "clamped": (Support(on="cube/bottom"),),
    }
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(BlockStructure(name="cube", material="stone", size=(1.0,) * dimension),),
        mesh=MeshSettings(divisions=(2,) * dimension),
        supports=supports[kind],
        loads=Loads(gravity=down(dimension)),
        probes=(Probe(name="cube", block="cube", point=(0.5,) * dimension),),
        analysis=analysis or Statics(),
    )


def scattered(
    gaps: Sequence[float] = (1.0, 1.0), fidelity: Fidelity = "rigid", analysis: Analysis | None = None
) -> Scene:
    """Cubes in the air over a ground, too far apart to touch: each falls by g t²/2 (θ = ½)."""
    heights = np.cumsum([*gaps]) + np.arange(len(gaps))
    cubes = tuple(
        BlockStructure(name=f"c{k}", material="stone", size=(1, 1, 1), position=(0, 0, float(z)))
        for k, z in enumerate(heights)
    )
    ground = BlockStructure(
        name="ground", material="stone", size=(1, 1, 1), position=(0, 0, -1), support=True
    )
    return Scene(
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(ground, *cubes),
        mesh=MeshSettings(divisions=(1, 1, 1)),
        loads=Loads(gravity=down(3)),
        probes=tuple(
            Probe(name=cube.name, block=cube.name, point=(0.5, 0.5, float(z)))
            for cube, z in zip(cubes, heights, strict=True)
        ),
        analysis=analysis or Dynamics(step=0.01, duration=0.1, theta=0.5),
    )
