"""Non-local Frémond–Cangémi from the scene: blocks pulled apart and peeled."""

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene import check, specs
from masonry_fem.structures.block import BlockStructure

C, ENERGY = 1e10, 50.0
U0 = np.sqrt(ENERGY / C)
LOCAL = specs.law_record("fremond_cangemi", normal_stiffness=C, tangential_stiffness=C, energy=ENERGY)
GLUE = specs.law_record("elastic", normal_stiffness=1e14, tangential_stiffness=1e14)


def pulled(law, dimension, ends, *, order=(0, 1, 2), placement=None, density=1, length=0.4, **motion):
    """A block between a fixed one and one that moves up by ``ends``, glued to the latter."""
    size = (length, 0.2) if dimension == 2 else (length, 0.3, 0.2)
    up = (0.0,) * (dimension - 1)
    blocks = [
        BlockStructure(name=name, material="m", size=size, position=(*up, 0.2 * i), support=name != "mid")
        for i, name in enumerate(("low", "mid", "top"))
    ]
    move = specs.Motion(displacement=(*up, ends), **motion)
    scene = specs.Scene(
        dimension=dimension, fidelity="rigid", materials={"m": specs.Material(density=2400.0)},
        structures=tuple(blocks[i] for i in order),
        joints=(specs.Joint(law=law, placement=placement, density=density),
                specs.Joint(between=("top", "mid"), law=GLUE)),
        supports=(specs.Support(on="top", motion=move),),
        analysis=specs.Statics(load_steps=8), solver=specs.Solver(tolerance=1e-12),
    )  # fmt: skip
    result = solve_scene(check(scene))
    assert result.outcome == "equilibrium"
    return result


def lower(result):
    """Points of the joint under test, along it, and their state."""
    model, state = result.built.model, result.march.state
    names = [block.name for block in model.assembly.blocks]
    own = np.array([{names[b] for b in pair} == {"low", "mid"} for pair in model.contacts.blocks])
    x = model.contacts.points[own, 0, 0]
    order = np.lexsort(model.contacts.points[own, 0].T)
    return x[order], state.joints.adhesion[own][order], state.joints.dissipated[own][order]


def with_gradient(k):
    return msgspec.structs.replace(LOCAL, gradient=k)


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_even_opening_does_not_feel_its_neighbours(dimension):
    one, other = (lower(pulled(law, dimension, 2.5 * U0)) for law in (LOCAL, with_gradient(1.0)))
    assert 0 < one[1].max() < 0.3
    assert other[1] == pytest.approx(one[1], rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_numbering_of_blocks_changes_nothing(dimension):
    turn = 4e-4 if dimension == 2 else (0.0, 4e-4, 0.0)
    keys = {"placement": "gauss", "density": 4, "rotation": turn}
    one = lower(pulled(with_gradient(0.05), dimension, 2 * U0, **keys))
    other = lower(pulled(with_gradient(0.05), dimension, 2 * U0, order=(2, 0, 1), **keys))
    assert np.ptp(one[1]) > 0.05
    assert other[1] == pytest.approx(one[1], rel=1e-6)


def test_a_peeled_joint_is_damaged_more_evenly():
    """An opening that grows along the joint: the larger k, the smoother β."""
    keys = {"placement": "gauss", "density": 20, "rotation": 6e-4, "pivot": (0.0, 0.2)}
    spreads = []
    for k in (0.0, 1e-1, 1e1, 1e3):
        result = pulled(with_gradient(k), 2, 0.2 * U0, **keys)
        _, beta, dissipated = lower(result)
        assert (dissipated >= 0).all()
        spreads.append(np.ptp(beta))
        assert result.march.ledger.joint_dissipation >= 0
    assert (np.diff(spreads) < 0).all()
    assert spreads[0] > 0.5
    assert spreads[-1] < 0.01
    # in the limit the mean of Y counts: all points break together
    stretch = np.linspace(0.2, 0.2 + 6e-4 * 0.4 / U0, 1001)
    assert beta == pytest.approx(1 / np.trapezoid(stretch**2, dx=1e-3), rel=0.01)


def test_what_the_gradient_goes_with():
    with pytest.raises(
        SceneError, match=r"joints\.0\.law: .*gradient is 1, expected with a laplacian, degree 1"
    ):
        pulled(msgspec.structs.replace(LOCAL, gradient=1.0, degree=2), 2, U0)
