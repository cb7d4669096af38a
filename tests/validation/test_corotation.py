"""Stones that turn and are elastic: mechanisms of rigid stones, and shapes that bend far."""

from __future__ import annotations

import logging
from functools import cache
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchmarks.cases import falling_arch
from masonry_fem.analyses.run import RunResult
from masonry_fem.build import build
from masonry_fem.march.march import march
from masonry_fem.nscd import SolverSettings
from masonry_fem.records.law import MaterialRecord
from masonry_fem.scene import check
from masonry_fem.scene.actions import PointForce
from masonry_fem.scene.laws import law_record, material_record
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Probe,
    Scene,
    Statics,
    Support,
    Table,
    Traction,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import G, solved
from tests.validation.tape import Tape, taped


def stiff(young: float) -> Material:
    return Material(density=2400.0, young=young, poisson=0.2)


def crushed(cohesion: float) -> MaterialRecord:
    return material_record("drucker_prager", cohesion=cohesion, friction_angle=30.0, dilatancy_angle=5.0)


# A1.6: rocking

ALPHA = float(np.arctan(0.25))
STEP = 1e-3


@cache
def rocking(young: float | None) -> tuple[float, float]:
    """A post of 0.5 × 2 m let go at α/2, half of what it stands: when it is upright [s], its next tilt/α."""
    scene = Scene(
        dimension=2,
        fidelity="rigid" if young is None else "elastic",
        materials={"stone": stiff(young or 1e10)},
        mesh=MeshSettings(divisions=(2, 4)),
        structures=(
            BlockStructure(
                name="ground", material="stone", size=(4.0, 0.5), position=(-2.0, -0.5), support=True
            ),
            BlockStructure(
                name="post", material="stone", size=(0.5, 2.0), rotation=float(np.degrees(0.5 * ALPHA))
            ),
        ),
        contact=Contact(reach=0.3, angle=15.0),
        joints=(Joint(friction=5.0, form="velocity"),),
        loads=Loads(gravity=(0, -G)),
        analysis=Dynamics(step=STEP, duration=1.1, theta=1.0),
    )
    tilts = []

    class Watch:
        def record(self, model, state, report) -> None:
            for group, own in zip(model.groups, state.bodies, strict=True):
                if not group.prescribed:
                    turn = group.motion(own)[0][0]
                    tilts.append(0.5 * ALPHA + np.arctan2(turn[1, 0], turn[0, 0]))

    checked = check(scene)
    march(build(checked, Path()).model, checked.analysis, SolverSettings(), observers=(Watch(),))
    upright = int(np.argmax(np.array(tilts) <= 0))
    return STEP * (upright + 1), float(np.abs(tilts[upright:]).max()) / ALPHA


@pytest.mark.slow
def test_a1_6_elastic_posts_rock_as_rigid_ones() -> None:
    """Housner: 0.493803 s, 0.386714 (θ = 1 and h = 1 ms add half a per cent); the stiffer, the nearer."""
    time, rise = rocking(None)
    assert (time, rise) == pytest.approx((0.493803, 0.386714), rel=6e-3)
    away = [abs(rocking(young)[1] / rise - 1) for young in (1e9, 1e10, 1e11, 1e12)]
    assert away == sorted(away, reverse=True)
    assert away[0] < 0.03
    assert away[-1] < 1e-4
    assert all(abs(rocking(young)[0] - time) <= 2 * STEP for young in (1e9, 1e10, 1e11, 1e12))


# A3.7: supports that part until the arch falls


def parted(
    share: float, material: Material, divisions: tuple[int, int] = (1, 1), fidelity: str = "elastic"
) -> RunResult:
    """A semicircle of 20 voussoirs, t = 0.15 R, whose springings part by ``share`` of 0.1079 R."""
    slowly = Table(points=((0.0, 0.0), (0.5, share - 0.1), (1.0, share)))
    supports = tuple(
        Support(
            on=f"arch.springing_{side}", motion=Motion(displacement=(sign * 0.1079 / 2, 0.0), time=slowly)
        )
        for side, sign in (("left", -1.0), ("right", 1.0))
    )
    return solved(
        dimension=2,
        materials={"stone": material},
        structures=(ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=20),),
        mesh=MeshSettings(divisions=divisions),
        fidelity=fidelity,
        joints=(Joint(friction=5.0),),
        analysis=Statics(load_steps=20),
        loads=Loads(gravity=(0.0, -G), gravity_time=Table(points=((0.0, 1.0),))),
        supports=supports,
    )


@pytest.mark.slow
def test_a3_7_elastic_arch_falls_where_the_rigid_one_does() -> None:
    assert parted(0.98, stiff(1e12)).outcome == "equilibrium"
    assert parted(1.02, stiff(1e12)).outcome == "no_equilibrium"


@pytest.mark.slow
def test_a3_7_stones_that_yield_turn_as_elastic_ones_do() -> None:
    """Half the way to the fall: strong stones bear what elastic ones do, edges of weak ones are crushed."""
    stone, cells = stiff(1e9), (2, 4)
    strong, weak = (msgspec.structs.replace(stone, inelastic=crushed(cohesion)) for cohesion in (1e9, 4e4))
    results = [parted(0.5, stone, cells)]
    results += [parted(0.5, yields, cells, "inelastic") for yields in (strong, weak)]
    assert [one.outcome for one in results] == ["equilibrium"] * 3
    thrust, same, less = (abs(one.summary.supports["arch.springing_left"].force[0]) for one in results)
    assert same == pytest.approx(thrust, rel=1e-9)
    assert 0.99 * thrust < less < 0.9999 * thrust
    assert {"arch.v04", "arch.v17"} <= {one.block for one in results[2].summary.stress.yielded}
    assert max(one.summary.certificate.energy_balance for one in results) <= 1e-9


def test_newton_finds_the_steps_of_an_elastic_arch_that_falls() -> None:
    """It is too thin to stand. Its stones hinge and fly: what masses decide, all of W scales."""
    scene = Scene(
        dimension=2,
        fidelity="elastic",
        materials={"stone": stiff(1e10)},
        mesh=MeshSettings(divisions=(2, 2)),
        structures=(
            ArchStructure(
                name="arch", material="stone", radius=1.0, thickness=0.06, voussoirs=9, straight=True
            ),
        ),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0, -G)),
        analysis=Dynamics(step=2e-3, duration=0.12, theta=1.0),
    )
    methods, speeds = [], []

    class Watch:
        def record(self, model, state, report) -> None:
            methods.append(report.method)
            speeds.append(report.speed)

    checked = check(scene)
    march(build(checked, Path()).model, checked.analysis, SolverSettings(), observers=(Watch(),))
    assert speeds[-1] > 0.2  # it falls
    assert set(methods) <= {"newton", "newton+newton"}


@pytest.mark.slow
def test_an_elastic_arch_falls_to_the_ground() -> None:
    """All of 800 steps end, with stones that are far apart and others that knock on each other."""
    fall = falling_arch()
    assert fall["outcome"] == "finished"
    assert fall["fallen"] > 1.2  # of 1.3 m


# A6.6: a springing that sinks


@pytest.mark.parametrize("amount", [1e-4, 1e-3])
def test_a6_6_elastic_springing_that_sinks_is_relieved(amount: float) -> None:
    """0.488294 of the weight, as with rigid stones."""
    result = solved(
        dimension=2,
        materials={"stone": stiff(1e12)},
        structures=(ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=20),),
        mesh=MeshSettings(divisions=(1, 1)),
        joints=(Joint(friction=5.0),),
        supports=(Support(on="arch.springing_right", motion=Motion(displacement=(0.0, -amount))),),
        analysis=Statics(load_steps=2),
    )
    assert result.outcome == "equilibrium"
    forces = {name: float(value.force[1]) for name, value in result.summary.supports.items()}
    share = forces["arch.springing_right"] / sum(forces.values())
    assert share == pytest.approx(0.488294, rel=2e-3)


def test_each_round_says_what_it_leaves_of_balance(caplog: pytest.LogCaptureFixture) -> None:
    """``--verbose``; stones are stiff, so that rounds leave little of what the one before did."""
    with caplog.at_level(logging.INFO, logger="masonry_fem.march.turning"):
        test_a6_6_elastic_springing_that_sinks_is_relieved(1e-3)
    lines = [record.getMessage() for record in caplog.records if record.name == "masonry_fem.march.turning"]
    told = [(int(line.split("round ")[1].split(":")[0]), float(line.split()[-5])) for line in lines]
    assert [number for number, _ in told].count(1) == 2  # load steps
    assert len(told) >= 4
    for (_, before), (number, left) in pairwise(told):
        assert number == 1 or left < 0.1 * before


# stones glued to a cantilever that bends far


def elastica(force: np.ndarray) -> np.ndarray:
    """Turn of the tip of a unit cantilever, EI = 1, and how far it goes.

    θ″ = Fₓ sin θ − F_y cos θ, θ(0) = θ′(1) = 0.
    """

    def end(curvature: float) -> np.ndarray:
        def rates(_: float, y: np.ndarray) -> list[float]:
            return [y[1], force[0] * np.sin(y[0]) - force[1] * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(rates, (0.0, 1.0), [0.0, curvature, 0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]

    most = 1.001 * float(np.linalg.norm(force))
    turn, _, x, y = end(brentq(lambda curvature: end(curvature)[1], -most, 0.0))
    return np.array([turn, x - 1.0, y])


def bent(end_forces: dict[float, np.ndarray], count: int = 20) -> RunResult:
    """A cantilever of 1 × 0.01 m, its stones glued by joints that do not give way, two cells in each.

    ``end_forces`` are by height on its end, over EI/L².
    """
    height, young = 0.01, 10e9
    stiffness = young * height**3 / 12
    stones = tuple(
        BlockStructure(name=f"s{i}", material="stone", size=(1 / count, height), position=(i / count, 0.0))
        for i in range(count)
    )
    wall = BlockStructure(
        name="wall", material="stone", size=(0.1, height), position=(-0.1, 0.0), support=True
    )
    last = f"s{count - 1}"
    points = tuple(
        PointForce(block=last, point=(1.0, at * height), vector=tuple(stiffness * force))
        for at, force in end_forces.items()
    )
    return solved(
        dimension=2,
        plane="stress",
        structures=(wall, *stones),
        mesh=MeshSettings(element="Q2", divisions=(2, 1)),
        materials={"stone": Material(density=2400.0, young=young, poisson=0.0)},
        joints=(Joint(friction=1.0, law=law_record("mohr_coulomb", cohesion=1e9, tensile_strength=1e9)),),
        loads=Loads(points=points),
        probes=(Probe(name="tip", block=last, point=(1.0, height / 2)),),
        analysis=Statics(load_steps=5),
    )


@pytest.mark.slow
def test_force_that_bends_glued_stones_to_a_right_angle() -> None:
    """It is dead, and points down and back by 45 degrees; P L²/EI = 3.848."""
    direction = np.array([-1.0, -1.0]) / np.sqrt(2)
    load = brentq(lambda load: elastica(load * direction)[0] + np.pi / 2, 1.0, 5.0)
    assert load == pytest.approx(3.848, rel=1e-3)
    result = bent({0.5: load * direction})
    assert result.outcome == "equilibrium"
    np.testing.assert_allclose(result.summary.probes["tip"], elastica(load * direction)[1:], rtol=1e-2)


def test_couple_that_bends_glued_stones_to_a_quarter_of_a_circle() -> None:
    """Dead forces at both edges, at 45 degrees to the arm that joins them both before and after."""
    force = np.array([-1.0, -1.0]) * (np.pi / 2) / 0.01
    result = bent({0.0: -force, 1.0: force})
    assert result.outcome == "equilibrium"
    np.testing.assert_allclose(result.summary.probes["tip"], [2 / np.pi - 1, 2 / np.pi], rtol=1e-2)


def pressed(contact: Contact) -> Tape:
    """A wall of 3×3 bricks that 2 MPa suddenly press on, in time."""
    tape, made, _ = taped(
        materials={"stone": stiff(1e9)},
        structures=(
            WallStructure(name="wall", material="stone", brick=(0.4, 0.2, 0.2), columns=3, courses=3),
        ),
        joints=(Joint(friction=0.6),),
        mesh=MeshSettings(divisions=(2, 2, 1)),
        contact=contact,
        loads=Loads(
            gravity=(0.0, 0.0, -G), tractions=(Traction(on="wall.c3.*/top", vector=(0.0, 0.0, -2e6)),)
        ),
        analysis=Dynamics(step=1e-3, duration=6e-3, theta=1.0),
    )
    assert made.outcome == "finished"
    return tape


def test_contacts_where_three_bricks_meet_do_not_contradict_each_other() -> None:
    """As bricks turn their points part by the square of it: 3 or 4 systems a step, and not 26 to 376."""
    solves = [report.linear_solves for report in pressed(Contact()).reports]
    assert max(solves) <= 1 + max(report.linear_solves for report in pressed(Contact(update="fixed")).reports)
