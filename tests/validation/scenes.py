"""Scenes that several validation families share, in SI units, and how to solve them."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene, Solver, Statics
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

G = 9.81
STONE = Material(density=2400.0, young=10e9, poisson=0.2)


def solved(**keys: Any) -> RunResult:
    """Solve a scene given by its fields; one stone and downward gravity unless said.

    It comes to its end, to rest, or to a proof that there is none; a solve that gave up fails the test.
    """
    result = attempted(**keys)
    assert result.outcome in {"finished", "equilibrium", "no_equilibrium"}, result.message
    return result


def attempted(**keys: Any) -> RunResult:
    """As ``solved``, whatever comes of it."""
    dimension = keys.get("dimension", 3)
    down = (0.0, -G) if dimension == 2 else (0.0, 0.0, -G)
    given = {
        "materials": {"stone": STONE},
        "loads": Loads(gravity=down),
        # gates on rigid blocks are in m/s: 1e-10 where a step of free fall gives 1
        "solver": Solver(tolerance=1e-12) if keys.get("fidelity") == "rigid" else Solver(),
    } | keys
    return solve_scene(Scene(**given))


def stands(result: RunResult) -> bool:
    """Whether a run came to rest, or found that nothing does."""
    return {"equilibrium": True, "no_equilibrium": False}[result.outcome]


def cube_on_slope(angle: float, friction: float, **keys: Any) -> RunResult:
    """Rigid 1 m cube on a plane at ``angle`` [deg]; gravity is turned, not the plane."""
    a = np.radians(angle)
    size = keys.pop("size", (1.0, 1.0, 1.0))
    return solved(
        fidelity="rigid",
        structures=(StackStructure(name="cube", material="stone", size=size, count=1),),
        joints=(Joint(friction=friction, **keys.pop("joint", {})),),
        loads=Loads(gravity=(G * np.sin(a), 0.0, -G * np.cos(a))),
        **keys,
    )


def rigid_arch(
    *,
    thickness: float,
    voussoirs: int,
    friction: float,
    inset: float = 1.0,
    embrace: float = 180.0,
    **keys: Any,
) -> RunResult:
    """Plane semicircular arch of mean radius 1 m, rigid voussoirs, contact at the joints' ends."""
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(
            ArchStructure(
                name="arch",
                material="stone",
                radius=1.0,
                thickness=thickness,
                voussoirs=voussoirs,
                embrace=embrace,
            ),
        ),
        joints=(Joint(friction=friction, inset=inset),),
        **keys,
    )


def low_wall(size: float = 0.125, **keys: Any) -> RunResult:
    """A10.4: five courses of 0.5 × 0.25 × 0.25 m bricks, 2 m long, on a rigid floor."""
    return solved(
        structures=(
            WallStructure(name="wall", material="stone", brick=(0.5, 0.25, 0.25), columns=4, courses=5),
        ),
        mesh=MeshSettings(size=size),
        joints=(Joint(friction=0.6),),
        analysis=keys.pop("analysis", Statics()),
        **keys,
    )
