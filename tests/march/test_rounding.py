"""What rounding makes of the balances of forces and energy: by hand, and of states that are no more exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.acting import acted, extents
from masonry_fem.march.coupling import connect
from masonry_fem.march.ledger import Ledger
from masonry_fem.march.measure import measure
from masonry_fem.march.rounding import force_rounding
from masonry_fem.march.step import initial_state, step
from masonry_fem.nscd import SolverSettings
from masonry_fem.scene import specs
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.march.test_march import G, stack
from tests.validation.scenes import rigid_arch, solved

UNIT = np.finfo(float).eps / 2
WEIGHT = 1000 * G  # of a cube [N], in the plane a metre deep
STONES = StackStructure(name="st", material="stone", size=(1.0, 0.5), count=3)
FINE = specs.MeshSettings(element="Q1", divisions=(4, 2))


def reported(inertia: float, theta: float = 1.0):
    """A step of 10 ms of two cubes on each other, as it is measured, the step, and the model."""
    model = stack(2, 2)
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    made = step(model, coupling, state, Scheme(0.01, theta, inertia), SolverSettings())
    made = acted(model, made, extents(model.assembly))
    return measure(model, coupling, made), made, model


def test_forces_balance_to_what_each_blocks_forces_do():
    """The lower of two cubes bears three weights at four points and has its own; the upper one at two."""
    _, made, model = reported(0.0)
    known = np.sqrt(3 + 2 * 4) * (1 + 3) + np.sqrt(3 + 2 * 2) * (1 + 1)
    told = force_rounding(model, made, made.after.acting)
    assert told == pytest.approx(UNIT * known * WEIGHT, rel=1e-9)


def test_energy_of_rigid_blocks_in_statics_is_known_as_places_are():
    """Three weights work over the size of the model's coordinates, 2 m at most, and nothing moves."""
    report, made, _ = reported(0.0)
    largest = float(np.abs(made.here.points).max())
    terms = 2 * len(made.impulse) + 2 * 3
    assert report.energy_rounding == pytest.approx(UNIT * np.sqrt(terms) * 3 * WEIGHT * largest, rel=1e-9)


def test_a_block_that_falls_is_known_as_its_momentum_and_energy_are():
    """After t from rest: m g t from its momentum before and after, 2 m g² t² from squares of its speed."""
    block = BlockStructure(name="b", material="stone", size=(1.0, 1.0))
    one, two = (
        solved(
            dimension=2, structures=(block,), fidelity="rigid", joints=(specs.Joint(friction=0.6),),
            analysis=specs.Dynamics(step=0.01, duration=time, theta=1.0),
        )
        for time in (0.01, 0.02)
    )  # fmt: skip
    weight, fallen = 2400.0 * G, 2400.0 * G**2
    force = weight * (1 + 3)  # its load, and its momentum before and after over the step
    told = two.summary.certificate.rounding.global_balance
    assert told == pytest.approx(UNIT * np.sqrt(3 + 3) * force / weight, rel=1e-6)
    # F (|q| + |q⁺|) and h |F| |v| with q = h² g, 3 h² g; and U U + U⁺ U⁺
    second = fallen * ((1e-4 + 3e-4) + 2e-4 + (1e-4 + 4e-4))
    given = two.march.ledger.rounding - one.march.ledger.rounding
    assert given == pytest.approx(UNIT * np.sqrt(3) * second, rel=1e-6)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize(
    "analysis",
    [
        specs.Statics(),
        specs.Dynamics(step=0.001, duration=0.05, theta=0.5),
        specs.Dynamics(step=0.001, duration=0.05, theta=1.0),
    ],
    ids=["statics", "theta=0.5", "theta=1"],
)
def test_solved_to_rounding_the_balances_leave_no_more_than_it_makes(fidelity, analysis):
    """And what it makes is small: no measure hides behind it."""
    told = solved(
        dimension=2, structures=(STONES,), fidelity=fidelity, mesh=FINE, analysis=analysis,
        joints=(specs.Joint(friction=0.6),), solver=specs.Solver(tolerance=1e-14),
    ).summary.certificate  # fmt: skip
    assert told.global_balance <= told.rounding.global_balance <= 1e-14
    assert told.energy_balance <= told.rounding.energy_balance <= 1e-11


def test_a_clamped_face_that_moves_far_is_known_to_the_rounding_of_its_stiffness():
    """Its forces are K times the whole way: the farther it goes, the less is known of them, and is left."""

    def told(way: float):
        block = BlockStructure(name="b", material="stone", size=(1.0, 0.5))
        pushed = specs.Support(on="b/left", motion=specs.Motion(displacement=(way, 0.0)))
        return solved(
            dimension=2, structures=(block,), supports=(pushed,), fidelity="elastic", mesh=FINE,
            joints=(specs.Joint(friction=0.6),), analysis=specs.Statics(),
        ).summary.certificate  # fmt: skip

    near, far = told(1e-3), told(1.0)
    assert far.rounding.global_balance == pytest.approx(1e3 * near.rounding.global_balance, rel=0.01)
    for one in (near, far):
        assert one.global_balance <= one.rounding.global_balance
        assert one.energy_balance <= one.rounding.energy_balance


def test_rounding_of_steps_adds_up_and_is_no_energy():
    """Neither it nor what it is a bound of counts among the largest terms."""
    report, *_ = reported(1.0)
    once = Ledger().add(report)
    twice = once.add(replace(report, energy_rounding=3 * report.energy_rounding))
    assert once.rounding == report.energy_rounding > 0
    assert twice.rounding == pytest.approx(4 * report.energy_rounding, rel=1e-14)
    half = once.largest / 2
    large = Ledger().add(replace(report, energy_rounding=half, energy_error=half / 2))
    assert large.largest == once.largest
    assert large.rounded == 0.5
    assert large.imbalance == 0.25


def test_energies_that_are_no_more_than_rounding_have_not_moved():
    """No share of them is missing, whatever the ledger leaves."""
    report, *_ = reported(1.0)
    largest = Ledger().add(report).largest
    still = Ledger().add(replace(report, energy_rounding=1.1 * largest, energy_error=0.3 * largest))
    assert still.largest == largest
    assert still.imbalance == still.rounded == 0.0


def test_an_arch_at_rest_is_not_told_to_miss_energy_that_is_rounding():
    """Rigid voussoirs at rest have no energies but rounding, of which a share of any size may be missing."""
    result = rigid_arch(thickness=0.15, voussoirs=15, friction=0.7)
    assert result.outcome == "equilibrium"
    assert "missing from its ledger" not in result.message
    told = result.summary.certificate
    assert told.energy_balance <= max(told.rounding.energy_balance, 1e-6)
