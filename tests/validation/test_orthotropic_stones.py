"""Stones with axes of their own in scenes: pulled along each, turned, heated."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Orthotropy,
    Probe,
    Scene,
    Statics,
    Support,
    Temperature,
    Traction,
    material_record,
)
from masonry_fem.structures.block import BlockStructure

YOUNG, POISSON, SHEAR = (12e9, 1.5e9, 0.8e9), (0.4, 0.5, 0.35), (0.9e9, 0.1e9, 0.7e9)
PULL = 1e6


def pulled(d: int = 2, rotation: float = 0.0, **keys: Any) -> RunResult:
    """A bar along x, or turned by 90°, that slides along its left and lower face; its right end is pulled."""
    keys = {"young": YOUNG, "poisson": POISSON, "shear": SHEAR} | keys
    upright = rotation == 90.0
    size, mesh = (2.0, 0.5, 0.5)[:d], MeshSettings(divisions=(2,) * d)
    axis = (0.0, 0.0, 1.0) if d == 3 and upright else None
    block = BlockStructure(name="bar", material="m", size=size, mesh=mesh, rotation=rotation, axis=axis)
    pull = (0.0, PULL, 0.0) if upright else (PULL, 0.0, 0.0)
    held = [("left", "y" if upright else "x"), ("bottom" if d == 2 else "front", "x" if upright else "y")]
    held += [("bottom", "z")] if d == 3 else []
    end = (-0.5, 2.0, 0.5) if upright else (2.0, 0.5, 0.5)
    return solve_scene(
        check(
            Scene(
                dimension=d, plane="stress" if d == 2 else "strain", fidelity="elastic",
                materials={"m": Material(density=600.0, orthotropic=Orthotropy(**keys))}, structures=(block,),
                supports=tuple(Support(on=f"bar/{face}", components=(one,)) for face, one in held),
                loads=Loads(tractions=(Traction(on="bar/right", vector=pull[:d]),)),
                probes=(Probe(name="end", block="bar", point=end[:d]),), analysis=Statics(),
            )
        )
    )  # fmt: skip


# along which of its axes the bar is pulled, and which are beside it: in the plane, and across
ALONG = {0.0: (0, 1, 2), 90.0: (1, 0, 2)}


def strains(along: tuple[int, int, int]) -> np.ndarray:
    """Of the bar, along and beside it."""
    one, *beside = along
    narrow = {(0, 1): POISSON[0] / YOUNG[0], (1, 2): POISSON[1] / YOUNG[1], (0, 2): POISSON[2] / YOUNG[0]}
    return PULL * np.array([1 / YOUNG[one], *(-narrow[min(one, two), max(one, two)] for two in beside)])


@pytest.mark.parametrize("angle", ALONG)
@pytest.mark.parametrize("d", [2, 3])
def test_a_bar_along_its_axes(d, angle):
    result = pulled(d, angle=angle)
    expected = strains(ALONG[angle])[:d] * np.array([2.0, 0.5, 0.5])[:d]
    np.testing.assert_allclose(result.march.report.probes["end"], expected, rtol=1e-8)
    (group,), (state,) = result.march.model.groups, result.march.state.bodies
    stress = group.stress(state).gauss.reshape(-1, 6)
    np.testing.assert_allclose(stress, [[PULL, 0, 0, 0, 0, 0]] * len(stress), atol=1e-8 * PULL)
    assert group.stress_error(state).squares.sum() <= 1e-12 * group.strain_energy(state).sum()


def test_its_third_axis():
    """Turned by 90° about y: 3 is along x, 1 across."""
    result = pulled(3, angle=90.0, axis=(0.0, 1.0, 0.0))
    expected = strains((2, 1, 0)) * [2.0, 0.5, 0.5]
    np.testing.assert_allclose(result.march.report.probes["end"], expected, rtol=1e-8)


@pytest.mark.parametrize(("frame", "angle"), [("stone", 0.0), ("world", 90.0)])
@pytest.mark.parametrize("d", [2, 3])
def test_axes_are_those_of_the_stone_or_of_the_world(d, frame, angle):
    """A bar that stands turned by 90°: axis 1 of the stone is along it, that of the world beside it."""
    found = pulled(d, rotation=90.0, frame=frame).march.report.probes["end"]
    along, beside, *across = strains(ALONG[angle])[:d] * np.array([2.0, 0.5, 0.5])[:d]
    np.testing.assert_allclose(found, [-beside, along, *across], rtol=1e-8)


def test_between_walls_heat_is_borne_by_the_modulus_along_them():
    """σ = −E_1 α ΔT where the other sides are free."""
    stone = Material(
        density=600.0,
        thermal_expansion=5e-6,
        orthotropic=Orthotropy(young=YOUNG, poisson=POISSON, shear=SHEAR),
    )
    held, mesh = (("left", "x"), ("right", "x"), ("bottom", "y")), MeshSettings(divisions=(2, 1))
    result = solve_scene(
        check(
            Scene(
                dimension=2, plane="stress", fidelity="elastic", materials={"m": stone},
                structures=(BlockStructure(name="bar", material="m", size=(2, 1), mesh=mesh),),
                supports=tuple(Support(on=f"bar/{face}", components=(axis,)) for face, axis in held),
                joints=(Joint(),), loads=Loads(temperatures=(Temperature(on="*", change=10.0),)),
                analysis=Statics(),
            )
        )
    )  # fmt: skip
    force = result.march.report.support_resultants["bar/right"][0]
    assert force == pytest.approx(-YOUNG[0] * 5e-5, rel=1e-9)
    assert result.march.ledger.imbalance <= 1e-9


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"poisson": (3.0, 0.3, 0.3)},
            r"materials\.m\.orthotropic\.poisson .* ν_12 is 3, expected less than",
        ),
        ({"axis": (0.0, 0.0, 1.0)}, r"materials\.m\.orthotropic\.axis .* no axis in a 2D scene"),
    ],
)
def test_what_is_no_material_is_refused(keys, message):
    with pytest.raises(SceneError, match=message):
        pulled(**keys)


@pytest.mark.parametrize("key", ["young", "inelastic"])
def test_two_elasticities_are_one_too_many(key):
    law = material_record("drucker_prager", cohesion=1e6, friction_angle=30.0)
    other: dict[str, Any] = {"young": 1e9} if key == "young" else {"inelastic": law}
    stone = Material(
        density=600.0, orthotropic=Orthotropy(young=YOUNG, poisson=POISSON, shear=SHEAR), **other
    )
    block = BlockStructure(name="b", material="m", size=(1, 1))
    with pytest.raises(SceneError, match=rf"materials\.m\.{key} .* none beside 'orthotropic'"):
        check(Scene(dimension=2, materials={"m": stone}, structures=(block,), analysis=Statics()))
