"""Joints whose faces stay plane: the patch test, Navier's bending stiffness, and hinges at the edges."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.scene.specs import Mortar
from tests.validation.patch import pressed
from tests.validation.scenes import STONE, G, cube_on_slope, stands


@pytest.mark.parametrize("elements", [("Q1", "Q1"), ("P1", "Q2")])
@pytest.mark.parametrize("d", [2, 3])
def test_uniform_pressure_between_any_two_meshes(d: int, elements: tuple[str, str]) -> None:
    result, error = pressed(d, 2, 3, "navier", elements)
    assert error < 1e-9
    assert result.built.model.contacts.count == (3 if d == 2 else 5)


@pytest.mark.parametrize(("placement", "stiffness"), [("navier", 1.0), ("corners", 3.0)])
def test_a_rigid_block_tilts_on_mortar_as_a_section_bends(placement: str, stiffness: float) -> None:
    """θ = M / (k I), I = a⁴/12, as long as no edge opens; contacts at corners alone are thrice as stiff.

    Its weight leans over as it tilts, by 1.4e-4 of the moment.
    """
    k, angle = 1e9, 10.0
    bed = Mortar(normal_stiffness=k, tangential_stiffness=k)
    made = cube_on_slope(angle, 0.9, joint={"mortar": bed, "placement": placement})
    groups = zip(made.built.model.groups, made.march.state.bodies, strict=True)
    (state,) = (own for group, own in groups if not group.prescribed)
    moment = STONE.density * G * np.sin(np.radians(angle)) * 0.5
    assert (made.march.state.reaction[:, 0] > 0).all()
    assert state.rotation[0, 0, 2] == pytest.approx(moment / (k / 12) / stiffness, rel=5e-4)


@pytest.mark.parametrize(("angle", "holds"), [(14.0, True), (14.1, False)])
def test_a_slender_block_overturns_about_its_edge(angle: float, holds: bool) -> None:
    """At tan α = b / h: 14.04°."""
    made = cube_on_slope(angle, 0.9, size=(0.5, 0.5, 2.0), joint={"placement": "navier"})
    assert stands(made) is holds
