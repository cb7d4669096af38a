"""Joints of every law in a structure that is turned: reactions turn with it, losses stay."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import check, specs
from masonry_fem.scene import laws as records
from masonry_fem.structures.block import BlockStructure

SIZE = (0.3, 0.2)
STIFFNESS = {"normal_stiffness": 2e9, "tangential_stiffness": 1e9}
FRACTURE = STIFFNESS | {"normal_strength": 1e5, "tangential_strength": 1.5e5,
                        "normal_energy": 20.0, "tangential_energy": 60.0}  # fmt: skip
JOINTS = {
    "dry": specs.Joint(),
    "mohr_coulomb": specs.Joint(law=specs.law_record("mohr_coulomb", cohesion=1e5, critical_slip=1e-4)),
    "elastic": specs.Joint(law=specs.law_record("elastic", **STIFFNESS)),
    "fremond_cangemi": specs.Joint(
        law=specs.law_record("fremond_cangemi", **STIFFNESS, energy=5.0, gradient=1e-3)
    ),
    "monerie_acary": specs.Joint(law=records.law_record("monerie_acary", **FRACTURE, residual=0.2)),
    "bilinear": specs.Joint(law=specs.law_record("bilinear", **FRACTURE, friction_mode="damage")),
    "exponential": specs.Joint(law=records.law_record("exponential", **FRACTURE), dynamic_friction=0.4),
    "mortar": specs.Joint(
        law=records.law_record("bilinear", **FRACTURE),
        mortar=specs.Mortar(**STIFFNESS, crushing=4e4, hardening=1e9),
    ),
    "dilatancy": specs.Joint(dilatancy=specs.Dilatancy(tangent=0.2, bound=1e-4)),
}


def sheared(joint, angle):
    """A block on a fixed one, pressed and pushed by the motion of a third one glued on it, all turned."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))

    def turned(x, y):
        return (float(cosine * x - sine * y), float(sine * x + cosine * y))

    blocks = tuple(
        BlockStructure(
            name=name,
            material="stone",
            size=SIZE,
            position=turned(0.0, i * SIZE[1]),
            rotation=float(angle),
            support=name != "mid",
        )
        for i, name in enumerate(("low", "mid", "top"))
    )
    motion = specs.Motion(displacement=turned(4e-4, -3e-5))
    scene = specs.Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": specs.Material(density=2000.0)},
        structures=blocks,
        joints=(joint, specs.Joint(between=("top", "mid"), law=specs.law_record("elastic", **STIFFNESS),
                                   mortar=specs.Mortar(**STIFFNESS), friction=1.5)),
        supports=(specs.Support(on="top", motion=motion),),
        loads=specs.Loads(gravity=turned(0.0, -10.0)),
        analysis=specs.Statics(load_steps=4),
    )  # fmt: skip
    march = solve_scene(check(scene)).march
    reaction = march.state.reaction
    return reaction, march.state.joints.dissipated + march.state.joints.rubbed


@cache
def upright(name):
    return sheared(JOINTS[name], 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", JOINTS)
@settings(max_examples=2, deadline=None)
@given(angle=st.floats(-170.0, 170.0).map(lambda angle: round(angle, 9)))
def test_reactions_turn_with_the_structure(name, angle):
    """In the frames of the contacts they are the same."""
    (one, lost), (other, lost_too) = upright(name), sheared(JOINTS[name], angle)
    size = np.abs(one).max()
    assert np.abs(one).max() > 1e3
    np.testing.assert_allclose(np.abs(other), np.abs(one), atol=1e-6 * size)
    np.testing.assert_allclose(lost_too, lost, rtol=1e-5, atol=1e-6)
