"""``errors`` of the summary: what elements, contact points and time steps leave open."""

import io

import pytest
from rich.console import Console

from masonry_fem.analyses.run import solve_scene
from masonry_fem.analyses.run.discretisation import other
from masonry_fem.contact.placement import Rule
from masonry_fem.output.terminal import print_summary
from masonry_fem.records.told import plain
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Joint,
    Loads,
    MeshSettings,
    Output,
    Override,
    Probe,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.analyses.test_refine import wall
from tests.validation.scenes import solved

ASK = Output(contact_error=True)


def cubes(n, shear):
    """A10.1 and A10.2: one cube on another, pushed."""
    return solved(
        structures=(
            BlockStructure(name="lower", material="stone", size=(1, 1, 1)),
            BlockStructure(name="upper", material="stone", size=(1, 1, 1), position=(0, 0, 1)),
        ),
        mesh=MeshSettings(divisions=(n, n, n)),
        supports=(Support(on="lower/bottom"),),
        loads=Loads(gravity=(0, 0, -9.81), tractions=(Traction(on="upper/top", vector=(shear, 0.0, -1e6)),)),
        probes=(Probe(name="edge", block="upper", point=(1, 0.5, 2)),),
        output=ASK,
    ).summary.errors


@pytest.mark.slow
def test_a_joint_that_sticks_is_the_same_by_any_points():
    """Equal linear meshes: nodes that touch everywhere make all Gauss points touch."""
    found = cubes(3, 0.1e6).contact
    assert found.points_again > found.points
    for name in ("supports", "probes", "stress", "block_stress"):
        assert getattr(found, name) <= 1e-9


@pytest.mark.slow
def test_an_opening_heel_changes_less_the_finer_the_mesh():
    """Where it ends lies between nodes; the forces of the only support follow from the loads."""
    coarse, fine = cubes(2, 0.3e6).contact, cubes(4, 0.3e6).contact
    assert 1e-3 < coarse.stress < 0.1
    assert fine.stress < 0.5 * coarse.stress
    assert fine.probes < 0.5 * coarse.probes
    assert coarse.supports <= 1e-9


@pytest.mark.slow
def test_meshes_that_do_not_match_are_compared_too():
    finer = Override(blocks="wall.c4.b2", mesh=MeshSettings(size=0.0625))
    found = solve_scene(wall(overrides=(finer,), output=ASK)).summary.errors
    assert 0 < found.contact.stress < 0.1 * found.stress


def test_rigid_faces():
    gauss = (Joint(friction=0.6, placement="gauss", density=2),)
    found = solve_scene(wall(fidelity="rigid", joints=gauss, output=ASK)).summary.errors
    assert found.stress is None
    assert found.contact.points_again == pytest.approx(1.5 * found.contact.points)
    top = (Probe(name="top", block="wall.c4.b2", point=(0.25, 1.0)),)
    still = solve_scene(wall(fidelity="rigid", joints=gauss, probes=top, output=ASK)).summary.errors
    assert still.contact.probes is None  # it moves by rounding, whose changes say nothing
    told = solve_scene(wall(fidelity="rigid", output=ASK)).summary.errors
    assert set(plain(told.contact)) == {"note"}


def test_contacts_that_are_found_anew_have_no_second_set():
    scene = wall(
        fidelity="rigid", output=ASK, contact=Contact(update="redetect"),
        analysis=Dynamics(step=1e-3, duration=2e-3),
    )  # fmt: skip
    assert "anew" in solve_scene(scene).summary.errors.contact.note


def test_a_block_alone_has_no_contact_points_to_place_otherwise():
    alone = BlockStructure(name="beam", material="stone", size=(1, 1, 1))
    scene = {"mesh": MeshSettings(divisions=(2, 2, 2)), "supports": (Support(on="beam/left"),), "output": ASK}
    found = solved(structures=(alone,), **scene).summary.errors
    assert plain(found.contact) == {"note": "nothing touches: there are no contact points to place otherwise"}


def test_another_outcome_is_told():
    """Gauss points stand in from the edge: a block that nodes just hold tips over."""
    corners, gauss = Rule("corners"), Rule("gauss")
    assert other(corners, meshed=False) == corners
    assert other(gauss, meshed=False).density == 2
    assert other(gauss, meshed=True).name == "nodes"
    result = solved(
        dimension=2,
        structures=(StackStructure(name="s", material="stone", size=(1.0, 2.0), count=1),),
        mesh=MeshSettings(divisions=(1, 2)),
        loads=Loads(gravity=(0.48 * 9.81, -9.81)),
        joints=(Joint(friction=1.0),),
        output=ASK,
    )
    found = result.summary.errors.contact
    assert result.outcome == "equilibrium"
    assert found.outcome_again == "no_equilibrium"
    assert found.supports is None
    assert "With" not in found.note


@pytest.mark.slow
def test_time():
    """The ledger tells what θ > ½ takes; θ = ½ takes nothing, which is said, where no sliding turns round."""
    lossy, keeping, turning = (
        solve_scene(
            wall(
                analysis=Dynamics(step=1e-4, duration=2e-3, theta=theta),
                contact=Contact(update=update),
                joints=(Joint(friction=friction),),
            )
        ).summary
        for theta, update, friction in ((0.6, "moving", 0.6), (0.5, "fixed", 0.0), (0.5, "moving", 0.0))
    )
    largest = lossy.energy.numerical_dissipation / lossy.errors.time.dissipated
    assert 0.05 < lossy.errors.time.dissipated < 0.5
    assert largest >= lossy.energy.strain
    assert abs(keeping.errors.time.dissipated) < 1e-15
    assert abs(turning.errors.time.dissipated) < 1e-5
    assert "halve" in keeping.errors.time.note
    assert solve_scene(wall()).summary.errors.time is None


def test_console_tells_them():
    summary = solve_scene(wall(output=ASK, analysis=Dynamics(step=1e-4, duration=4e-4, theta=0.6))).summary
    page = io.StringIO()
    print_summary(summary, Console(file=page, width=200))
    text = page.getvalue()
    assert f"{100 * summary.errors.stress:.2g} % (most in wall." in text
    assert "by other contact points" in text
    assert "lost to the scheme" in text
