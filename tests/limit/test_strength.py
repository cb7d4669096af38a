"""What joints bear: cones with apex and tension cut-off, which laws have a constant strength."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_fem.build import build
from masonry_fem.errors import LawError
from masonry_fem.limit import admissible, collapse_multiplier
from masonry_fem.limit.strength import strength_of
from masonry_fem.scene.specs import Dilatancy, Joint, Loads, Mortar, Scene, law_record
from masonry_fem.structures.stack import StackStructure
from tests.limit.scenes import GAMMA, accelerated, problem, pushed, scene, weight

SIZE = {2: (1.0, 2.0), 3: (1.0, 1.0, 2.0)}
COHESION, MU = 0.3 * GAMMA, 0.6


def glued(dimension: int = 2, **joint: Any) -> Scene:
    """A block of 1 × 2 m glued to its ground."""
    stone = StackStructure(name="p", material="stone", size=SIZE[dimension], count=1)
    return scene(stone, dimension=dimension, joints=(Joint(**({"friction": MU} | joint)),))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("cut", [None, 0.2 * GAMMA, 1e-3])
def test_pull_takes_weight_and_tension(dimension: int, cut: float | None) -> None:
    law = law_record("mohr_coulomb", cohesion=COHESION, tensile_strength=cut)
    up = (0.0,) * (dimension - 1) + (1.0,)
    made = problem(glued(dimension, law=law), pushed("p.b1", up))
    strength = COHESION / MU if cut is None else cut
    assert collapse_multiplier(made).multiplier == pytest.approx(weight(made) + strength, rel=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("cut", [None, 0.2 * GAMMA])
def test_shear_takes_cohesion_and_friction(dimension: int, cut: float | None) -> None:
    """Pushed at the foot, so low that it cannot tip: c A + μ W."""
    law = law_record("mohr_coulomb", cohesion=COHESION, tensile_strength=cut)
    along = (1.0,) + (0.0,) * (dimension - 1)
    foot = (0.0,) + (0.5,) * (dimension - 2) + (0.0,)
    made = problem(glued(dimension, law=law), pushed("p.b1", along, foot))
    found = collapse_multiplier(made)
    assert found.multiplier == pytest.approx(COHESION + MU * weight(made), rel=1e-7)
    assert found.gap < 1e-6


def test_tipping_takes_tension_at_the_heel() -> None:
    """Points at both ends of the joint with half of its area each: F·2 = W/2 + t/2 (b = 1, h = 2)."""
    tension = 0.1 * GAMMA
    law = law_record("mohr_coulomb", cohesion=GAMMA, tensile_strength=tension)
    made = problem(glued(law=law, friction=5.0), pushed("p.b1", (1.0, 0.0), (0.0, 2.0)))
    found = collapse_multiplier(made)
    assert found.multiplier == pytest.approx((weight(made) + tension) / 4, rel=1e-8)


def test_a_hanging_block_shows_the_share_that_glue_carries() -> None:
    law = law_record("constant_threshold", strength=0.5 * GAMMA)
    lifted = glued(law=law, friction=1.0)
    upwards = Loads(gravity=(0.0, 9.81))  # as if it hung from its ground
    made = problem(scene(*lifted.structures, joints=lifted.joints, loads=upwards))
    found = admissible(made)
    assert not found.holds
    assert found.share == pytest.approx(0.25, rel=1e-8)
    assert found.mechanism is not None


def test_cohesion_does_not_bear_without_limit() -> None:
    """Growing without limit is what friction alone carries; glue carries a little."""
    made = problem(glued(law=law_record("mohr_coulomb", cohesion=COHESION)), accelerated(1.0, 0.0))
    assert np.isfinite(collapse_multiplier(made).multiplier)


@pytest.mark.parametrize(
    "joint",
    [
        {"mortar": Mortar(normal_stiffness=1e10, tangential_stiffness=4e9)},
        {"dilatancy": Dilatancy(tangent=0.1, bound=1e-3)},
        {"law": law_record("mohr_coulomb", cohesion=0.0), "dynamic_friction": 0.5},
    ],
)
def test_what_stands_around_a_law_changes_nothing(joint: dict[str, Any]) -> None:
    bare = strength_of(build(glued(), Path()).model)
    around = strength_of(build(glued(**joint), Path()).model)
    np.testing.assert_allclose(around.friction, bare.friction)
    np.testing.assert_allclose(around.apex, 0.0)


@pytest.mark.parametrize(
    ("joint", "named"),
    [
        ({"law": law_record("elastic", normal_stiffness=1e10, tangential_stiffness=1e10)}, "elastic"),
        (
            {"law": law_record("bilinear",
                             normal_stiffness=1e11, tangential_stiffness=1e11, normal_strength=1e5,
                             tangential_strength=1e5, normal_energy=50.0, tangential_energy=50.0)},
            "bilinear",
        ),
        ({"mortar": Mortar(normal_stiffness=1e10, tangential_stiffness=4e9, crushing=5e6)}, "crushing"),
    ],
)  # fmt: skip
def test_laws_without_a_constant_strength_are_refused(joint: dict[str, Any], named: str) -> None:
    with pytest.raises(LawError, match=named):
        problem(glued(**joint))
