"""Blocks that no contact pairs at the start and that meet on the way."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.march.witness import Written
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Equilibrium,
    Initial,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Override,
    Probe,
    Scatter,
    Scene,
    Statics,
    Support,
    Table,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import G, attempted, solved
from tests.validation.tape import taped

DENSITY, YOUNG, LENGTH, THICK = 2400.0, 1e9, 2.0, 0.2
BEAM = MeshSettings(element="Q2", divisions=(20, 4))


def written(result: RunResult) -> Written:
    return result.summary.certificate.written


def cantilever(gap: float, *, below: str = "support", **keys: Any) -> RunResult:
    """A clamped beam over a block at its tip, farther away than contact reaches."""
    arm = BlockStructure(name="arm", material="soft", size=(LENGTH, THICK), mesh=BEAM)
    rest = BlockStructure(
        name="below", material="soft", size=(0.5, 0.5), position=(1.5, -0.5 - gap), support=below == "support"
    )
    given = {
        "structures": (arm, rest),
        "supports": (
            Support(on="arm/left"),
            *((Support(on="below/bottom"),) if below == "elastic" else ()),
        ),
        "joints": (Joint(friction=0.0),),
        "analysis": Statics(),
    }
    return attempted(
        dimension=2,
        materials={"soft": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
        mesh=MeshSettings(divisions=(4, 4)),
        overrides=(Override(blocks="below", fidelity="rigid"),) if below != "elastic" else (),
        probes=(Probe(name="tip", block="arm", point=(LENGTH, 0.0)),),
        **given | keys,
    )


def prop(gap: float) -> float:
    """What a prop at the tip of a cantilever that sags by ``gap`` carries [N]: 3/8 q L − 3 E I gap / L³.

    With the shear of a Timoshenko beam, κ = 5/6.
    """
    q, bending, shear = DENSITY * G * THICK, YOUNG * THICK**3 / 12, 5 / 6 * YOUNG / 2 * THICK
    soft = LENGTH**3 / (3 * bending) + LENGTH / shear
    return (q * LENGTH**4 / (8 * bending) + q * LENGTH**2 / (2 * shear) - gap) / soft


@pytest.mark.parametrize("steps", [1, 4])
@pytest.mark.parametrize("below", ["support", "elastic"])
def test_a_cantilever_sags_onto_the_block_below(below: str, steps: int) -> None:
    gap = 3e-3
    result = cantilever(gap, below=below, analysis=Statics(load_steps=steps))
    assert result.outcome == "equilibrium"
    assert len(result.march.model.interfaces) == 1
    name = "below" if below == "support" else "below/bottom"
    carried = -result.summary.supports[name].force[1]
    own = DENSITY * G * 0.25 if below == "elastic" else 0.0
    # of which the block's own compression is a hundredth
    assert carried + own == pytest.approx(-prop(gap), rel=0.02)
    assert result.summary.probes["tip"][1] == pytest.approx(-gap, rel=1e-2)
    assert written(result).overlap.value < 1e-6
    assert written(result).balance.value < 1e-8


def test_fixed_contacts_stay_those_of_the_start_and_the_overlap_is_told() -> None:
    result = cantilever(3e-3, contact=Contact(update="fixed"))
    assert result.outcome == "no_convergence"
    told = written(result).overlap
    assert sorted(told.blocks) == ["arm", "below"]
    q, bending, shear = DENSITY * G * THICK, YOUNG * THICK**3 / 12, 5 / 6 * YOUNG / 2 * THICK
    sag = q * LENGTH**4 / (8 * bending) + q * LENGTH**2 / (2 * shear)
    assert told.value == pytest.approx(sag - 3e-3, rel=0.01)
    assert "'arm' and 'below' overlap" in result.message


def test_a_scene_that_does_not_move_far_looks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cantilever that stays above a block keeps its contacts; blocks are looked at once, at the end."""
    from masonry_fem.march import lookout

    looks: list[int] = []
    plain = lookout.overlaps
    monkeypatch.setattr(lookout, "overlaps", lambda *given: looks.append(1) or plain(*given))
    still = cantilever(0.05, analysis=Statics(load_steps=5), contact=Contact(reach=0.06))
    assert still.outcome == "equilibrium"
    assert len(looks) == 1
    assert still.march.model is still.built.model


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_pushed_block_meets_the_next_one(dimension: int, fidelity: str) -> None:
    """A support pushes a block by 30 mm over ground; the next stands 20 mm away, and goes 10 mm with it.

    The first step ends before they meet, the second goes through. Friction of both adds up at the support.
    """
    side = (1.0,) * (dimension - 2)
    zero = (0.0,) * (dimension - 2)

    def box(name: str, x: float, size: float = 1.0, z: float = 0.0, **keys: Any) -> BlockStructure:
        return BlockStructure(
            name=name, material="stone", size=(size, *side, 1.0), position=(x, *zero, z), **keys
        )

    push = Motion(displacement=(0.03, *zero, 0.0), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    result = solved(
        dimension=dimension,
        fidelity=fidelity,
        structures=(
            box("ground", -2.0, 8.0, -1.0, support=True),
            box("hand", -1.0),
            box("first", 0.0),
            box("second", 1.02),
        ),
        mesh=MeshSettings(divisions=(2,) * dimension),
        supports=(Support(on="hand", motion=push),),
        joints=(Joint(friction=0.0), Joint(friction=0.5, between=("ground", "*"))),
        probes=(Probe(name="second", block="second", point=(1.02, *zero, 0.0)),),
        analysis=Statics(load_steps=2),
    )
    assert result.outcome == "equilibrium"
    weight = 2400.0 * G
    assert result.summary.supports["hand"].force[0] == pytest.approx(2 * 0.5 * weight, rel=1e-5)
    assert result.summary.probes["second"][0] == pytest.approx(0.01, rel=1e-2)
    assert result.summary.contacts == sum(result.summary.status.values())  # those of the meeting, too
    assert written(result).overlap.value < 1e-6


@pytest.mark.parametrize("length", [None, 0.5])
def test_joints_of_the_start_keep_what_they_drew(length: float | None) -> None:
    """Where friction scatters the new joint draws its own, and the one that was there its own again."""
    scatter = Scatter(seed=7, variation={"friction": 0.2}, correlation_length=length)
    result = cantilever(
        2e-3,
        joints=(Joint(friction=0.5, scatter=scatter),),
        supports=(Support(on="arm/left"), Support(on="below/bottom")),
        structures=(
            BlockStructure(name="arm", material="soft", size=(LENGTH, THICK), mesh=BEAM),
            BlockStructure(name="top", material="soft", size=(0.2, 0.1), position=(0.1, THICK)),
            BlockStructure(name="below", material="soft", size=(0.5, 0.5), position=(1.5, -0.502)),
        ),
    )
    assert result.outcome == "equilibrium"
    start, end = result.built.model.scatter["friction"], result.march.model.scatter["friction"]
    assert len(end) > len(start) > 0
    assert end[: len(start)] == pytest.approx(start, rel=1e-12)
    assert abs(end[-1] - start[0]) > 1e-3


@pytest.mark.slow
def test_a_thrown_block_bounces_off_a_wall_that_it_did_not_know() -> None:
    """Velocity form: 1 m/s over 0.5 m of nothing, then back with half of that."""
    ball = BlockStructure(name="ball", material="stone", size=(0.2, 0.2))
    wall = BlockStructure(name="wall", material="stone", size=(0.5, 2.0), position=(0.7, -1.0), support=True)
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(ball, wall),
        loads=Loads(),
        initial=(Initial(blocks="ball", velocity=(1.0, 0.0)),),
        joints=(Joint(friction=0.0, form="velocity", restitution=0.5),),
        probes=(Probe(name="ball", block="ball", point=(0.2, 0.0)),),
        analysis=Dynamics(step=1e-3, duration=1.0, theta=0.5),
    )
    assert result.outcome == "finished"
    # met at 0.5 s, to a step or two
    assert result.summary.probes["ball"][0] == pytest.approx(0.25, abs=4e-3)


@pytest.mark.slow
def test_a_block_that_lands_on_a_corner_comes_down_on_the_next() -> None:
    """On an elastic beam: they touch at one corner when the other one gets there, 0.3 m away."""
    result = solved(
        dimension=2,
        structures=(
            BlockStructure(
                name="beam", material="stone", size=(1.6, 0.2), mesh=MeshSettings(divisions=(8, 1))
            ),
            BlockStructure(
                name="fall", material="stone", size=(0.3, 0.3), position=(0.65, 0.25), rotation=10.0,
                fidelity="rigid",
            ),
        ),
        supports=(Support(on="beam/bottom"),),
        joints=(Joint(friction=0.5),),
        analysis=Dynamics(step=1e-3, duration=0.2, theta=1.0),
    )  # fmt: skip
    assert result.outcome == "finished"
    model = result.march.model
    assert model.contacts.count > 2
    corners = model.contacts.points[:, 0, 0]
    assert corners.max() - corners.min() == pytest.approx(0.3, abs=0.05)
    assert written(result).overlap.value < 2e-3


def test_who_meets_whom_is_told(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="masonry_fem"):
        cantilever(3e-3, analysis=Equilibrium(strategy="large_step", step=1.0, max_steps=10))
    assert "'arm' and 'below' meet" in caplog.text


STONE = {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.2)}


def tilted(name: str, at: tuple[float, float], turn: float, **keys: Any) -> BlockStructure:
    """A stone of 0.3 m by 0.2 m."""
    return BlockStructure(
        name=name, material="stone", position=at, rotation=turn, **{"size": (0.3, 0.2)} | keys
    )


def marched(fidelity: str, **keys: Any) -> tuple[Any, Any]:
    """A plane march of stones, and energy less the work done on them, step by step [J]."""
    given = {
        "dimension": 2,
        "fidelity": fidelity,
        "materials": STONE,
        "mesh": MeshSettings(divisions=(2, 2)),
        "loads": Loads(gravity=(0.0, -G)),
        "joints": (Joint(friction=0.5),),
    }
    tape, made, _ = taped(**given | keys)
    work = np.cumsum([report.external_work + report.support_work for report in tape.reports])
    return made, tape.energy - work


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_stones_that_fall_in_a_heap_stay_out_of_each_other(fidelity: str) -> None:
    """Corners on faces and corners, at up to 3 m/s: 6 mm a step."""
    made, energy = marched(
        fidelity,
        structures=(
            BlockStructure(
                name="ground", material="stone", size=(4.0, 0.2), position=(-2.0, -0.2), support=True
            ),
            tilted("a", (-0.1, 0.02), 12.0),
            tilted("b", (0.05, 0.35), -25.0),
            tilted("c", (-0.15, 0.65), 40.0),
        ),
        analysis=Dynamics(step=2e-3, duration=0.5, theta=1.0),
    )
    assert made.outcome == "finished"
    assert made.witness.overlap.value < 0.01 * 0.2
    assert np.diff(energy).max() < 1e-9 * np.ptp(energy)


@pytest.mark.slow
def test_stones_that_slide_and_tilt_on_each_other_stay_out_of_each_other() -> None:
    """An arch whose springings part until it falls: corners slide, and hinges go from one to another."""
    way = Table(points=((0.0, 0.0), (0.5, 1.0)))
    made, energy = marched(
        "rigid",
        structures=(
            ArchStructure(
                name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=7, straight=True
            ),
        ),
        supports=tuple(
            Support(on=f"arch.springing_{side}", motion=Motion(displacement=(x, 0.0), time=way))
            for side, x in (("left", -0.1), ("right", 0.1))
        ),
        joints=(Joint(friction=0.6),),
        analysis=Dynamics(step=2e-3, duration=1.0, theta=1.0),
    )
    assert made.outcome == "finished"
    assert made.witness.overlap.value < 2e-3 * 0.15
    assert np.diff(energy).max() < 1e-9 * np.ptp(energy)


@pytest.mark.parametrize("spin", [0.0, 1.0])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_stone_of_arcs_stands_on_its_two_corners(fidelity: str, spin: float) -> None:
    """Dropped by 5 cm, also one corner first; between them its intrados stays 1.5 cm above the ground."""
    inner, half = 1.0 - 0.075, np.radians(10.0)
    made, energy = marched(
        fidelity,
        structures=(
            BlockStructure(
                name="ground", material="stone", size=(4.0, 0.2), position=(-2.0, -0.2), support=True
            ),
            ArchStructure(
                name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=1, embrace=20.0,
                springings=False, centre=(0.0, 0.05 - inner * np.cos(half)),
            ),
        ),
        initial=(Initial(blocks="arch.v01", spin=spin),),
        analysis=Dynamics(step=2e-3, duration=0.4, theta=1.0),
    )  # fmt: skip
    assert made.outcome == "finished"
    assert made.witness.overlap.value < 1e-3 * 0.15
    assert np.diff(energy).max() < 1e-9 * np.ptp(energy)
    both = zip(made.model.groups, made.state.bodies, strict=True)
    group, own = next(pair for pair in both if not pair[0].prescribed)
    points = group.positions(own).reshape(-1, 2)
    corners = np.argsort(points[:, 1])[:2]
    np.testing.assert_allclose(points[corners, 1], 0.0, atol=1e-4)
    assert np.ptp(points[corners, 0]) == pytest.approx(2 * inner * np.sin(half), rel=1e-3)


class Places:
    """Centre of each block and how far it has turned, step by step, shape (s, b, 3) [m, rad]."""

    def __init__(self) -> None:
        self.rows: list[np.ndarray] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        row = np.zeros((len(model.assembly.blocks), 3))
        for group, own in zip(model.groups, state.bodies, strict=True):
            row[group.blocks, :2] = group.positions(own).reshape(len(group.blocks), -1, 2).mean(axis=1)
            turn = group.motion(own)[0]
            row[group.blocks, 2] = np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
        self.rows.append(row)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_stones_that_hit_each_other_keep_their_angular_momentum(fidelity: str) -> None:
    """One flies at the other from 16 mm away, and rubs."""
    places, step = Places(), 4e-3
    scene = Scene(
        dimension=2,
        fidelity=fidelity,
        materials=STONE,
        structures=(tilted("rests", (0.0, 0.0), 12.0), tilted("flies", (0.05, 0.43), -25.0, size=(0.3, 0.3))),
        mesh=MeshSettings(divisions=(2, 2)),
        joints=(Joint(friction=0.8),),
        loads=Loads(),
        initial=(Initial(blocks="flies", velocity=(2.0, -5.0)),),
        analysis=Dynamics(step=step, duration=0.06, theta=1.0),
    )
    result = solve_scene(check(scene), observers=(places,))
    assert result.march.model.contacts.count > 0
    path = np.array(places.rows)
    speed = np.diff(path, axis=0) / step
    sides = np.array([[0.3, 0.2], [0.3, 0.3]])
    mass = DENSITY * sides.prod(axis=1)
    inertia = mass * (sides**2).sum(axis=1) / 12
    x, y = path[1:, :, 0], path[1:, :, 1]
    momentum = (mass * (x * speed[:, :, 1] - y * speed[:, :, 0]) + inertia * speed[:, :, 2]).sum(axis=1)
    assert abs(speed[-1, 0, 2]) > 1.0  # it turns
    assert momentum[-1] == pytest.approx(momentum[0], rel=1e-6)
