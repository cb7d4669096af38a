"""The energy ledger closes from the summary alone, and each term is what the mechanics says."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict

import pytest

from masonry_fem import run
from masonry_fem.march.ledger import Ledger
from masonry_fem.scene import loads, specs
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.portal import PortalStructure
from masonry_fem.structures.stack import StackStructure
from tests.validation.scenes import G, solved

LOST = ("dissipation", "viscosity", "impact_normal", "impact_tangential")


def ledger(result) -> Ledger:
    """The energy terms of a summary, once they have been found to add up."""
    told = result.summary.energy
    given = told.start + told.external_work + told.support_work + told.unaccounted
    kept = told.kinetic + told.strain + told.joints
    lost = sum(value for name, value in asdict(told).items() if name.endswith(LOST))
    largest = told.largest
    assert given == pytest.approx(kept + lost, abs=1e-12 * largest)
    assert abs(told.unaccounted) <= result.summary.certificate.energy_balance * largest * (1 + 1e-12)
    return told


def brick(**keys):
    """A stone in the plane, of 4 × 4 linear elements where it is elastic."""
    given = {
        "dimension": 2,
        "mesh": specs.MeshSettings(element="Q1", divisions=(4, 4)),
        "joints": (specs.Joint(friction=0.6),),
        "analysis": specs.Statics(),
    }
    return solved(**(given | keys))


def moved(on: str, vector: tuple[float, float], components=None) -> specs.Support:
    return specs.Support(on=on, components=components, motion=specs.Motion(displacement=vector))


def test_a_moved_face_whose_nodes_are_contacts_gives_the_work_that_is_spent():
    """The face's lower node lies on the ground: its friction is overcome by the face, and by nothing else."""
    stone = StackStructure(name="st", material="stone", size=(1.0, 0.5), count=1)
    push = moved("st.b1/left", (1e-4, 0.0), components=("x",))
    result = brick(fidelity="elastic", structures=(stone,), supports=(push,))
    told = ledger(result)
    assert result.summary.certificate.energy_balance < 1e-9
    force = result.summary.supports["st.b1/left"].force[0]
    assert told.support_work == pytest.approx(force * 1e-4, rel=1e-9)
    assert told.friction_dissipation > 0.5 * told.support_work


def test_work_of_a_clamped_face_is_that_of_its_support():
    """A block pressed by δ between its faces stores half of the end force times δ."""
    stone = BlockStructure(name="b", material="stone", size=(1.0, 1.0))
    supports = (specs.Support(on="b/bottom"), moved("b/top", (0.0, -1e-4)))
    result = brick(
        fidelity="elastic", structures=(stone,), supports=supports, loads=specs.Loads(gravity=(0.0, 0.0))
    )
    told = ledger(result)
    force = -result.summary.supports["b/top"].force[1]
    assert told.support_work == pytest.approx(force * 1e-4, rel=1e-12)
    assert told.strain == pytest.approx(0.5 * force * 1e-4, rel=1e-12)
    assert told.external_work == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_what_an_impact_takes_is_told_by_direction(restitution):
    """A plate thrown aside onto a floor that it sticks to: what it loses is told across and along the floor.

    In one step of the velocity form the fall is stopped, or turned into e times its speed, and the cube held.
    """
    height, speed = 0.05, 2.0
    stone = BlockStructure(name="b", material="stone", size=(1.0, 0.02), position=(0.0, height))
    floor = BlockStructure(
        name="floor", material="stone", size=(9.0, 1.0), position=(-4.0, -1.0), support=True
    )
    result = brick(
        fidelity="rigid",
        structures=(floor, stone),
        contact=specs.Contact(reach=0.06),
        joints=(specs.Joint(friction=50.0, form="velocity", restitution=restitution),),
        initial=(specs.Initial(blocks="b", velocity=(speed, 0.0)),),
        analysis=specs.Dynamics(step=1e-4, duration=0.1035, theta=0.5),
    )
    told, mass = ledger(result), 2400.0 * 0.02
    assert told.start == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    fall = mass * G * height
    assert told.impact_normal == pytest.approx((1 - restitution**2) * fall, rel=5e-3)
    # it sticks, so that its run becomes a turn about its edge as far as the thin plate can
    assert told.impact_tangential + told.kinetic - restitution**2 * fall == pytest.approx(
        told.start, rel=5e-2
    )
    assert told.impact_tangential > 0.9 * told.start
    assert abs(told.friction_dissipation) < 1e-3 * told.start


def test_velocities_that_are_set_to_zero_between_steps_are_damping():
    """Of two stones the upper one is shoved, in a march that takes velocities away: all is lost."""
    stone = StackStructure(name="st", material="stone", size=(1.0, 0.5), count=2)
    result = brick(
        fidelity="rigid",
        structures=(stone,),
        loads=specs.Loads(gravity=(0.0, -G)),
        initial=(specs.Initial(blocks="st.b2", velocity=(1.0, 0.0)),),
        analysis=specs.Equilibrium(strategy="brutal_damping", step=1e-2),
    )
    told = ledger(result)
    assert result.outcome == "equilibrium"
    assert told.start == pytest.approx(600.0, rel=1e-12)
    assert told.kinetic < 1e-9
    assert told.friction_dissipation > 0.0
    assert told.friction_dissipation + told.damping_dissipation + told.numerical_dissipation == (
        pytest.approx(600.0, rel=1e-9)
    )


@pytest.mark.slow
def test_a_rocking_block_loses_what_housner_says_in_its_first_impact():
    """Let go at half its critical tilt: the fall of its centroid less (1 − r²) of it, r = 1 − 3/2 sin² α."""
    slope, half_diagonal = math.atan(0.25), math.hypot(0.25, 1.0)
    result = brick(
        fidelity="rigid",
        structures=(
            BlockStructure(
                name="ground", material="stone", size=(4.0, 0.5), position=(-2.0, -0.5), support=True
            ),
            BlockStructure(
                name="post", material="stone", size=(0.5, 2.0), rotation=math.degrees(0.5 * slope)
            ),
        ),
        contact=specs.Contact(reach=0.3, angle=15.0),
        joints=(specs.Joint(friction=5.0, form="velocity"),),
        analysis=specs.Dynamics(step=5e-4, duration=0.55, theta=0.5),
    )
    told, weight = ledger(result), 2400.0 * G
    fall = weight * half_diagonal * (math.cos(0.5 * slope) - math.cos(slope))
    loss = 1 - (1 - 1.5 * math.sin(slope) ** 2) ** 2
    assert told.impact_normal + told.impact_tangential == pytest.approx(loss * fall, rel=2e-2)
    assert told.start == 0.0
    assert abs(told.numerical_dissipation) < 1e-3 * fall
    assert abs(told.friction_dissipation) < 1e-3 * fall


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_shaken_stack_takes_the_work_that_its_support_gives(dimension: int):
    """A support that swings: its way in a step is not what its velocities at both ends say, to (ωh)²/12."""
    swing = specs.Motion(displacement=(0.08, *(0.0,) * (dimension - 1)), time=specs.Sine(frequency=2.0))
    stack = StackStructure(name="s", material="stone", size=(0.3,) * (dimension - 1) + (0.5,), count=3)
    result = solved(
        dimension=dimension,
        fidelity="rigid",
        structures=(stack,),
        joints=(specs.Joint(friction=0.6),),
        supports=(specs.Support(on="s.ground", motion=swing),),
        analysis=specs.Dynamics(step=5e-3, duration=0.3, theta=0.5),
    )
    assert ledger(result).support_work > 10.0
    assert result.summary.certificate.energy_balance < 1e-10


SPRINGS = specs.law_record(
    "fremond_cangemi", normal_stiffness=1e8, tangential_stiffness=1e8, energy=1e-3, viscosity=0.0
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("keys", "gap"),
    [
        ({"dilatancy": specs.Dilatancy(tangent=0.1, bound=1e-3)}, 0.0),
        ({"dilatancy": specs.Dilatancy(tangent=0.1, bound=1e-3), "law": SPRINGS}, 0.0),
        ({"mortar": specs.Mortar(normal_stiffness=1e9, tangential_stiffness=1e9)}, 0.0),
        ({}, 1e-4),
        ({"law": specs.law_record("mohr_coulomb", cohesion=1.0)}, 1e-4),
    ],
    ids=["rough", "rough springs", "mortar", "dry, open", "brittle, open"],
)
def test_the_way_of_the_faces_is_booked_once(keys, gap):
    """Blocks that slide on a joint of whatever law: pressure takes work of gaps that close, and no other.

    What asperities lift is friction's; gaps that were open at the start close once.
    """
    stack = StackStructure(name="s", material="stone", size=(1.0, 0.5), count=2, gap=gap)
    push = specs.Acceleration(vector=(0.8 * G, 0.0))
    result = brick(
        fidelity="rigid",
        structures=(stack,),
        joints=(specs.Joint(friction=0.3, **keys),),
        loads=specs.Loads(gravity=(0.0, -G), accelerations=(push,)),
        analysis=specs.Dynamics(step=1e-4, duration=0.01, theta=1.0),
    )
    told = ledger(result)
    assert result.summary.certificate.energy_balance < 1e-4
    assert told.friction_dissipation > 0.1 * told.external_work
    assert abs(told.impact_normal) <= (0.2 if gap else 1e-6) * told.external_work


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_what_brittle_joints_hold_and_lose_is_booked(fidelity: str) -> None:
    """Of a portal whose cohesion holds some joints and breaks in others, within one step."""
    portal = PortalStructure(
        name="s", material="stone", span=2.0, thickness=0.4, voussoirs=7, pier_width=0.6, pier_height=1.5
    )
    result = brick(
        fidelity=fidelity,
        structures=(portal,),
        joints=(specs.Joint(friction=0.6, law=specs.law_record("mohr_coulomb", cohesion=8e3)),),
        analysis=specs.Dynamics(step=0.02, duration=0.02, theta=1.0),
    )
    assert result.summary.abrupt is not None
    assert result.summary.certificate.energy_balance < 1e-8


@pytest.mark.parametrize("steps", [1, 4])
def test_a_weight_that_grows_in_steps_works_more_than_mortar_stores(steps: int) -> None:
    """A block settles by δ = W/(k A): the end force of each of n steps works W δ (n + 1)/(2 n) in all."""
    stone = StackStructure(name="s", material="stone", size=(1.0, 0.5), count=1)
    mortar = specs.Mortar(normal_stiffness=1e9, tangential_stiffness=1e9)
    result = brick(
        fidelity="rigid",
        structures=(stone,),
        joints=(specs.Joint(friction=0.6, mortar=mortar),),
        analysis=specs.Statics(load_steps=steps),
    )
    told, weight = ledger(result), 0.5 * 2400 * G
    half = 0.5 * weight**2 / 1e9
    assert told.external_work == pytest.approx(half * (1 + 1 / steps), rel=1e-9)
    assert told.joints == pytest.approx(half, rel=1e-9)
    assert told.numerical_dissipation == pytest.approx(half / steps, rel=1e-9)


def test_what_rough_joints_raise_is_no_impact() -> None:
    """A block slides up its asperities as the floor is drawn away; a stop without friction holds it back."""
    sizes = {"floor": (3.0, 0.2), "stone": (1.0, 0.5), "stop": (0.2, 0.5)}
    corners = {"floor": (-1.0, -0.2), "stone": (0.0, 0.0), "stop": (1.0, 0.0)}
    rough = specs.Dilatancy(tangent=0.3, bound=0.01)
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=tuple(
            BlockStructure(
                name=name, material="stone", size=size, position=corners[name], support=name != "stone"
            )
            for name, size in sizes.items()
        ),
        supports=(specs.Support(on="floor", motion=specs.Motion(displacement=(0.01, 0.0))),),
        joints=(
            specs.Joint(friction=0.0),
            specs.Joint(between=("stone", "floor"), friction=0.6, dilatancy=rough),
        ),
        analysis=specs.Statics(load_steps=10),
    )
    told = result.summary.energy
    lift = [0.01 * (1 - math.exp(-0.3 * step / 10)) for step in range(11)]
    raised = sum(step / 10 * (lift[step] - lift[step - 1]) for step in range(1, 11))  # loads grow, too
    assert told.external_work == pytest.approx(-0.5 * 2400 * G * raised, rel=1e-6)
    assert told.friction_dissipation == pytest.approx(told.support_work + told.external_work, rel=1e-6)
    assert abs(told.impact_normal) < 1e-6 * told.friction_dissipation


@pytest.mark.parametrize("fidelity", ["rigid", "elastic", "reduced"])
def test_friction_takes_in_each_step_also_where_sliding_turns_round(fidelity, tmp_path):
    """A brick that is shaken to and fro: what friction drove at the start of a step is no loss of it."""
    scene = f"""
    dimension = 2
    fidelity = "{fidelity}"
    materials.stone = {{ density = 2000.0, young = 1e8 }}
    mesh.divisions = [2, 2]
    structures = [{{ kind = "stack", name = "st", material = "stone", size = [1.0, 0.2], count = 2 }}]
    joints = [{{ friction = 0.3 }}]
    loads.gravity = [0.0, -9.81]
    [[loads.accelerations]]
    vector = [8.0, 0.0]
    [loads.accelerations.time]
    kind = "table"
    points = [[0.0, 1.0], [0.02, 1.0], [0.021, -1.0], [0.041, -1.0], [0.042, 1.0]]
    repeats = true
    [analysis]
    kind = "dynamics"
    step = 1e-3
    duration = 0.1
    theta = 0.6
    [output]
    pictures = false
    fields = false
    every = 1
    """
    result = run(loads(scene), tmp_path)
    told = ledger(result)
    with (tmp_path / "history.csv").open(encoding="utf-8", newline="") as file:
        friction = [float(row["friction_dissipation"]) for row in csv.DictReader(file)]
    assert len(friction) == 100
    assert min(friction) >= -1e-12 * told.largest
    assert sum(friction) == pytest.approx(told.friction_dissipation, rel=1e-9)
    assert told.friction_dissipation > 0.3 * told.largest
