"""Ties against closed forms: rafters, a portal, a ring round a cone, yield and rupture, oscillation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    PointForce,
    Probe,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    Tie,
    TiePoint,
)
from masonry_fem.structures.block import BlockStructure

G = 9.81
DENSITY = 2000.0
STONE = Material(density=DENSITY, young=1e9, poisson=0.2)
RISING = Table(points=((0.0, 0.0), (1.0, 1.0)))


def block(name, size, position, **keys):
    return BlockStructure(name=name, material="stone", size=size, position=position, **keys)


def solved(dimension, **keys):
    down = (0.0, -G) if dimension == 2 else (0.0, 0.0, -G)
    given = {
        "fidelity": "rigid",
        "materials": {"stone": STONE},
        "loads": Loads(gravity=down),
        "solver": Solver(tolerance=1e-12),
    } | keys
    return solve_scene(Scene(dimension=dimension, **given))


def tie(*points, name="tie", section=1.0, **keys):
    ends = tuple(TiePoint(block=block, point=point) for block, point in points)
    return Tie(name=name, points=ends, section=section, **keys)


def at_end(result, name="tie"):
    return result.summary.ties[name]


# --- statics ----------------------------------------------------------------------------------

LENGTH, THICK, SLOPE, LIFT = 4.0, 0.2, np.radians(35.0), 0.05


def test_two_rafters_and_a_tie():
    """They stand on smooth ground on a corner each and meet in one point; pinned there, all is determined."""
    along, across = np.array([np.cos(SLOPE), np.sin(SLOPE)]), np.array([-np.sin(SLOPE), np.cos(SLOPE)])
    down = along * [1.0, -1.0]
    crown = LENGTH * along
    # the lower end of the right one's end face lies below the left one's corner, which rests within that face
    top = crown - LIFT * np.array([np.sin(SLOPE), np.cos(SLOPE)])
    longer = top[1] / np.sin(SLOPE)
    foot = top + longer * down
    left = block("left", (LENGTH, THICK), (0.0, 0.0), rotation=np.degrees(SLOPE))
    right = block("right", (longer, THICK), tuple(top), rotation=-np.degrees(SLOPE))
    ground = block("ground", (12.0, 0.5), (-2.0, -0.5), support=True)
    result = solved(
        2,
        structures=(ground, left, right),
        joints=(Joint(friction=3.0), Joint(friction=0.0, between=("ground", "*"))),
        ties=(tie(("left", (0.0, 0.0)), ("right", tuple(foot)), young=200e9),),
    )
    assert result.outcome == "equilibrium"
    weights = DENSITY * G * THICK * np.array([LENGTH, longer])
    outwards = np.array([np.sin(SLOPE), np.cos(SLOPE)])
    middles = np.array(
        [0.5 * (LENGTH * along + THICK * across), top + 0.5 * (longer * down + THICK * outwards)]
    )
    # of the whole about the left foot; of the left one about the crown
    lift_right = weights @ middles[:, 0] / foot[0]
    lift_left = weights.sum() - lift_right
    thrust = (lift_left * crown[0] - weights[0] * (crown[0] - middles[0, 0])) / crown[1]
    assert at_end(result).force == pytest.approx(thrust, rel=1e-6)


HEIGHT, WIDTH, PUSH, AT, TIED = 3.0, 0.5, 20e3, 2.0, 2.5


@pytest.mark.parametrize("pretension", [0.0, 5e3])
def test_tied_portal(pretension):
    """A column that is pushed about its outer corner until the tie to the other, held one bears the rest."""
    weight, young, section = DENSITY * G * HEIGHT * WIDTH, 200e9, 1e-4
    structures = (
        block("ground", (6.0, 0.5), (-1.0, -0.5), support=True),
        block("left", (WIDTH, HEIGHT), (0.0, 0.0)),
        block("right", (WIDTH, HEIGHT), (3.0, 0.0), support=True),
    )
    result = solved(
        2,
        structures=structures,
        joints=(Joint(friction=0.9),),
        loads=Loads(
            gravity=(0.0, -G), points=(PointForce(block="left", vector=(-PUSH, 0.0), point=(0.0, AT)),)
        ),
        ties=(
            tie(
                ("left", (WIDTH, TIED)), ("right", (3.0, TIED)), section=section, young=young,
                pretension=pretension,
            ),
        ),
    )  # fmt: skip
    start = np.array([3.0 - WIDTH, 0.0])
    rest = start[0] / (1.0 + pretension / (young * section))

    def drawn(turn):
        """Where the tie begins, how long it is, and its force."""
        point = Rotation.from_euler("z", turn).apply([WIDTH, TIED, 0.0])[:2]
        reach = np.array([3.0, TIED]) - point
        size = np.linalg.norm(reach)
        return point, reach / size, young * section * (size - rest) / rest

    def moment(turn):
        turned = Rotation.from_euler("z", turn)
        middle, pushed = turned.apply([[WIDTH / 2, HEIGHT / 2, 0.0], [0.0, AT, 0.0]])
        point, direction, force = drawn(turn)
        pulled = force * (point[0] * direction[1] - point[1] * direction[0])
        return -weight * middle[0] + PUSH * pushed[1] + pulled

    turn = brentq(moment, 0.0, 0.1, xtol=1e-15)
    told = at_end(result)
    assert told.force == pytest.approx(drawn(turn)[2], rel=1e-6)
    assert told.stress == pytest.approx(told.force / section, rel=1e-12)
    assert told.elongation == pytest.approx(told.force * rest / (young * section), rel=1e-6)
    assert result.summary.certificate.energy_balance < 1e-6


SIZE, LEAN = np.array([0.5, 0.4, 0.3]), np.radians(25.0)


def cone(count):
    """Stones on smooth faces that fall outwards."""
    for number in range(count):
        azimuth = 2 * np.pi * number / count
        turned = Rotation.from_euler("z", azimuth) * Rotation.from_euler("y", LEAN)
        centre = 3.0 * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        vector = turned.as_rotvec()
        angle = np.linalg.norm(vector)
        about = {"rotation": float(np.degrees(angle)), "axis": tuple(vector / angle)}
        below = centre - turned.apply([0.0, 0.0, SIZE[2]])
        for name, own, middle in (("stone", SIZE, centre), ("face", SIZE * [3.0, 2.0, 1.0], below)):
            corner = middle - turned.apply(0.5 * own)
            yield block(f"{name}{number}", tuple(own), tuple(corner), support=name == "face", **about)


def chain(count, **keys):
    """Through the centroids of the stones."""
    points = tuple(TiePoint(block=f"stone{number}") for number in range(count))
    return Tie(name="chain", points=points, closed=True, **keys)


def chain_force(count):
    return DENSITY * G * SIZE.prod() * np.tan(LEAN) / (2 * np.sin(np.pi / count))


@pytest.mark.parametrize("count", [6, 9])
def test_ring_round_a_cone(count):
    result = solved(
        3,
        structures=tuple(cone(count)),
        joints=(Joint(friction=0.0),),
        ties=(chain(count, section=1e-3),),
    )
    assert result.outcome == "equilibrium"
    told = result.summary.ties
    assert sorted(told) == sorted(f"chain.{k}" for k in range(1, count + 1))
    expected = [chain_force(count)] * count
    assert [part.force for part in told.values()] == pytest.approx(expected, rel=1e-6)


# --- yield and rupture ------------------------------------------------------------------------

YOUNG, YIELD, HARDENING, SECTION, SPAN = 100e9, 200e6, 2e9, 1e-4, 2.0
HOLDING = YIELD * SECTION


def pulled(loads, steps, supports=(), moves=False, beside=(), **keys):
    """A block on smooth ground, tied to a wall; or the wall is drawn away, and friction holds the block."""
    structures = (
        block("ground", (8.0, 0.5), (-4.0, -0.5), support=True),
        block("wall", (0.5, 1.0), (-SPAN - 0.5, 0.1), support=True),
        block("stone", (2.0, 1.0), (0.0, 0.0)),
    )
    return solved(
        2,
        structures=structures,
        joints=(Joint(friction=0.9 if moves else 0.0),),
        loads=Loads(gravity=(0.0, -G), gravity_time=Table(points=((0.0, 0.0), (0.01, 1.0))), points=loads),
        supports=supports,
        ties=(
            tie(
                ("wall", (-SPAN, 0.5)), ("stone", (0.0, 0.5)), section=SECTION, young=YOUNG,
                yield_stress=YIELD, hardening=HARDENING, **keys,
            ),
            *beside,
        ),
        analysis=Statics(load_steps=steps),
    )  # fmt: skip


def force_to(factor, time=None):
    return (PointForce(block="stone", vector=(factor * HOLDING, 0.0), point=(1.0, 0.5), time=time),)


def test_yield():
    told = at_end(result := pulled(force_to(1.1), 20))
    plastic = 0.1 * YIELD / HARDENING
    assert told.force == pytest.approx(1.1 * HOLDING, rel=1e-6)
    assert told.plastic_strain == pytest.approx(plastic, rel=1e-6)
    assert told.strain == pytest.approx(1.1 * YIELD / YOUNG + plastic, rel=1e-6)
    assert told.utilisation == pytest.approx(1.0, rel=1e-6)
    spent = SECTION * SPAN * plastic * (YIELD + 0.5 * HARDENING * plastic)
    assert result.summary.energy.joint_dissipation == pytest.approx(spent, rel=1e-6)
    stored = 0.5 * (1.1 * YIELD) ** 2 / YOUNG * SECTION * SPAN
    assert result.march.report.joint_energy == pytest.approx(stored, rel=1e-6)
    assert result.summary.certificate.energy_balance < 1e-3


def test_unloading_is_elastic_and_yield_is_kept():
    to_and_fro = Table(points=((0.0, 0.0), (0.4, 1.0), (0.7, 0.0), (1.0, 0.6)))
    told = at_end(pulled(force_to(1.1, to_and_fro), 10))
    plastic = 0.1 * YIELD / HARDENING
    assert told.plastic_strain == pytest.approx(plastic, rel=1e-6)
    assert told.strain == pytest.approx(0.66 * YIELD / YOUNG + plastic, rel=1e-6)
    assert told.utilisation == pytest.approx(0.6, rel=1e-6)


def test_rupture():
    """Drawn by a wall that moves: what it took until it snapped is lost, and it bears nothing then."""
    limit, steps, end = 0.0202, 50, 0.025
    drawn = (Support(on="wall", motion=Motion(displacement=(-end * SPAN, 0.0), time=RISING)),)
    result = pulled((), steps, drawn, moves=True, rupture_strain=limit)
    told = at_end(result)
    assert told.snapped
    assert told.force == 0
    assert result.outcome == "equilibrium"
    last = np.floor(limit / end * steps * (1 + 1e-12)) * end / steps  # strain of the last step before
    stress = (last + YIELD / HARDENING) / (1 / YOUNG + 1 / HARDENING)
    plastic = last - stress / YOUNG
    work = SECTION * SPAN * (plastic * 0.5 * (YIELD + stress) + 0.5 * stress**2 / YOUNG)
    assert result.summary.energy.joint_dissipation == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("steps", [1, 20])
def test_without_what_has_snapped_nothing_stands(steps):
    """In the very step in which it snaps, which may be the last one."""
    limit = 0.5 * (1.1 * YIELD / YOUNG + 0.1 * YIELD / HARDENING)
    result = pulled(force_to(1.1), steps, rupture_strain=limit)
    assert result.outcome == "no_equilibrium"
    stress = (limit + YIELD / HARDENING) / (1 / YOUNG + 1 / HARDENING)
    assert result.march.state.index == np.ceil(stress / (1.1 * YIELD) * steps)


def test_what_has_snapped_leaves_all_to_its_neighbour():
    """Both would share the load; the one snaps, and the other bears all at the end of the same step."""
    other = tie(("wall", (-SPAN, 0.5)), ("stone", (0.0, 0.5)), name="other", section=SECTION, young=YOUNG)
    result = pulled(force_to(1.5), 1, beside=(other,), rupture_strain=0.6 * YIELD / YOUNG)
    assert result.outcome == "equilibrium"
    assert at_end(result).snapped
    assert at_end(result).force == 0
    told = at_end(result, "other")
    assert told.force == pytest.approx(1.5 * HOLDING, rel=1e-6)
    assert told.strain == pytest.approx(1.5 * YIELD / YOUNG, rel=1e-6)


def test_limit_analysis_knows_the_yield():
    structures = (
        block("ground", (8.0, 0.5), (-4.0, -0.5), support=True),
        block("wall", (0.5, 1.0), (-SPAN - 0.5, 0.1), support=True),
        block("stone", (2.0, 1.0), (0.0, 0.0)),
    )
    keys = {
        "dimension": 2, "fidelity": "rigid", "materials": {"stone": STONE}, "structures": structures,
        "joints": (Joint(friction=0.0),),
        "loads": Loads(gravity=(0.0, -G), points=(PointForce(block="stone", vector=(1e3, 0.0)),)),
    }  # fmt: skip
    ends = ("wall", (-SPAN, 0.5)), ("stone", (0.0, 0.5))
    yields = analyse(Scene(**keys, ties=(tie(*ends, section=SECTION, yield_stress=YIELD),)))
    assert yields.multiplier == pytest.approx(HOLDING / 1e3, rel=1e-9)
    unbounded = analyse(Scene(**keys, ties=(tie(*ends, section=SECTION),)))
    assert unbounded.unlimited
    assert analyse(Scene(**keys)).multiplier == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("share", "holds"), [(0.99, False), (1.01, True)])
def test_limit_analysis_in_space(share, holds):
    section, count = 1e-5, 6
    scene = Scene(
        dimension=3,
        fidelity="rigid",
        materials={"stone": STONE},
        structures=tuple(cone(count)),
        joints=(Joint(friction=0.0),),
        ties=(chain(count, section=section, yield_stress=share * chain_force(count) / section),),
        loads=Loads(gravity=(0.0, 0.0, -G)),
    )
    told = analyse(scene)
    assert told.admissible is holds
    assert told.share == pytest.approx(min(share, 1.0), rel=1e-6)


# --- dynamics and elastic stones --------------------------------------------------------------


@pytest.mark.parametrize("pretension", [0.0, 1e3])
def test_a_stone_on_a_tie(pretension):
    """Half a swing on a spring, to first order in the step; then it flies back, the tie being slack."""
    section, young, mass, speed = 1e-4, 1e9, DENSITY * 2.0, 0.05
    omega = np.sqrt(young * section / SPAN / mass * (1 + pretension / (young * section)))
    rest = pretension / (mass * omega**2)  # beyond its length without force
    energy = 0.5 * mass * (speed**2 + (rest * omega) ** 2)
    misses = []
    for steps in (200, 400):
        duration = (np.pi - np.arctan2(rest * omega, speed)) / omega
        result = solved(
            2,
            structures=(
                block("ground", (8.0, 0.5), (-4.0, -0.5), support=True),
                block("wall", (0.5, 1.0), (-SPAN - 0.5, 0.1), support=True),
                block("stone", (2.0, 1.0), (0.0, 0.0)),
            ),
            joints=(Joint(friction=0.0),),
            ties=(
                tie(
                    ("wall", (-SPAN, 0.5)), ("stone", (0.0, 0.5)), section=section, young=young,
                    pretension=pretension,
                ),
            ),
            initial=(Initial(blocks="stone", velocity=(speed, 0.0)),),
            analysis=Dynamics(step=duration / steps, duration=duration, theta=0.5),
        )  # fmt: skip
        assert result.outcome == "finished"
        assert result.summary.certificate.energy_balance < 1e-6
        misses.append(1.0 - result.march.report.kinetic_energy / energy)
    assert 0 < misses[1] < 0.05
    assert misses[1] == pytest.approx(0.5 * misses[0], rel=0.05)


def test_a_slack_tie_bears_nothing():
    """A stone that moves towards the wall."""
    result = solved(
        2,
        structures=(
            block("ground", (8.0, 0.5), (-4.0, -0.5), support=True),
            block("wall", (0.5, 1.0), (-SPAN - 0.5, 0.1), support=True),
            block("stone", (2.0, 1.0), (0.0, 0.0)),
        ),
        joints=(Joint(friction=0.0),),
        ties=(tie(("wall", (-SPAN, 0.5)), ("stone", (0.0, 0.5)), section=1e-4, young=1e9),),
        initial=(Initial(blocks="stone", velocity=(-0.5, 0.0)),),
        probes=(Probe(name="end", block="stone", point=(0.0, 0.5)),),
        analysis=Dynamics(step=0.01, duration=1.0),
    )
    assert result.summary.probes["end"][0] == pytest.approx(-0.5, rel=1e-9)
    assert at_end(result).force == 0
    assert at_end(result).elongation == pytest.approx(-0.5, rel=1e-9)


@pytest.mark.parametrize("update", ["fixed", "moving"])
def test_an_elastic_column_under_a_tie(update):
    """The mean stress of a stone between two ends is that of their force alone, whatever its elements."""
    pretension, size = 500e3, (1.0, 2.0)
    result = solved(
        2,
        fidelity="elastic",
        mesh=MeshSettings(element="Q2", size=0.25),
        structures=(
            block("ground", (3.0, 0.5), (-1.0, -0.5), support=True),
            block("column", size, (0.0, 0.0)),
            block("plate", (1.0, 0.25), (0.0, 2.0)),
        ),
        joints=(Joint(friction=0.6),),
        ties=(tie(("ground", (0.5, -0.25)), ("plate", (0.5, 2.25)), section=1e-3, pretension=pretension),),
        probes=(Probe(name="top", block="plate", point=(0.5, 2.25)),),
        contact=Contact(update=update),
    )
    assert result.outcome == "equilibrium"
    told = at_end(result)
    assert 0 < told.force < pretension
    rest = 2.5 / (1 + pretension / (200e9 * 1e-3))
    shorter = pretension / (200e9 * 1e-3) * rest - told.elongation
    assert result.summary.probes["top"][1] == pytest.approx(-shorter, rel=1e-6)
    weight = DENSITY * G * (0.5 * size[1] + 0.25) * size[0]
    (stress,) = (one.stress for one in result.summary.stress.blocks if one.block == "column")
    assert stress[1] * size[0] == pytest.approx(-told.force - weight, rel=1e-6)
