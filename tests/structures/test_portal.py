"""Portals: piers flush with the intrados, joints of their own labels, forms of the arch."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene, Statics
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import build_structure
from masonry_fem.structures.portal import PortalStructure
from tests.meshing.test_meshing import volumes
from tests.structures.test_arches import exact_area

G, DENSITY = 9.81, 2000.0
FORMS = {"circular": None, "pointed": 1.5, "elliptical": 0.7}


def spec(form: str = "circular", **keys) -> PortalStructure:
    given = {"span": 2.0, "thickness": 0.2, "voussoirs": 11, "pier_width": 0.4, "pier_height": 1.2}
    keys = {"rise": FORMS[form]} | keys
    return PortalStructure(**({"name": "portal", "material": "stone", "form": form} | given | keys))


def portal(dimension: int = 2, **keys) -> Assembly:
    return build_structure(spec(**keys), dimension, Path(), MeshSettings())


def solid(made: Assembly, name: str):
    return made.solid([block.name for block in made.blocks].index(name))


@pytest.mark.parametrize("courses", [1, 3])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("form", FORMS)
def test_everything_touches_and_nothing_overlaps(form: str, dimension: int, courses: int) -> None:
    made = portal(dimension, form=form, courses=courses, depth=0.5)
    interfaces = detect(made)
    assert Counter(one.label for one in interfaces) == {"radial": 12, "bed": 2 * courses}
    assert max(np.abs(one.gap).max() for one in interfaces) < 1e-12
    assert overlapping(made) == []
    depth = 0.5 if dimension == 3 else 1.0
    areas = sorted(one.area for one in interfaces if one.label == "bed")
    assert areas == pytest.approx([0.4 * depth] * (2 * courses), rel=1e-12)
    shapes = {block.shape for block in made.blocks if ".c" in block.name}
    assert len(shapes) == min(courses, 2)


def test_piers_stand_where_the_intrados_ends() -> None:
    made = portal(centre=(10.0, 5.0), courses=2)
    left, right, crown = (solid(made, f"portal.{name}") for name in ("left.c2", "right.c1", "v06"))
    assert left.vertices.max(axis=0) == pytest.approx([9.1, 6.2], abs=1e-12)
    assert right.vertices.min(axis=0) == pytest.approx([10.9, 5.0], abs=1e-12)
    assert crown.vertices[:, 1].max() == pytest.approx(5 + 1.2 + 1.1, abs=1e-3)
    of_group = {
        group: [b.name for b in made.blocks if group in b.groups]
        for group in ("portal.left", "portal.keystone", "portal.springers")
    }
    assert of_group == {
        "portal.left": ["portal.left.c1", "portal.left.c2"],
        "portal.keystone": ["portal.v06"],
        "portal.springers": ["portal.v01", "portal.v11"],
    }


@pytest.mark.parametrize("form", ["circular", "pointed"])
def test_volume_is_that_of_arch_and_piers(form: str) -> None:
    made = portal(form=form)
    volume = sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
    arch = np.pi * 0.2 if form == "circular" else exact_area("pointed")
    assert volume == pytest.approx(arch + 2 * 0.4 * 1.2, rel=1e-10)


@pytest.mark.parametrize("form", FORMS)
def test_elastic_portals_stand_on_two_grounds(form: str) -> None:
    scene = Scene(
        fidelity="elastic",
        materials={"stone": Material(density=DENSITY, young=10e9)},
        structures=(spec(form, courses=2, depth=0.4, mesh=MeshSettings(divisions=(2, 1, 2))),),
        joints=(Joint(friction=0.7),),
        loads=Loads(gravity=(0.0, 0.0, -G)),
        analysis=Statics(),
    )
    result = solve_scene(scene)
    assert result.outcome == "equilibrium"
    made = result.built.model.assembly
    weight = G * sum(
        DENSITY * volumes(made.shapes[block.shape].mesh).sum() for block in made.blocks if not block.support
    )
    left, right = (
        np.array(result.summary.supports[f"portal.ground_{side}"].force) for side in ("left", "right")
    )
    assert left + right == pytest.approx([0.0, 0.0, weight], rel=1e-8, abs=1e-6 * weight)
    assert left == pytest.approx(right * [-1, 1, 1], rel=1e-6, abs=1e-6 * weight)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"rise": 1.2}, r"rise is 1.2.*half the span \(1 m\) in a circular portal"),
        ({"form": "pointed", "rise": None}, "a portal that is pointed has a rise"),
        ({"form": "pointed", "rise": 0.5}, r"at least half the span \(1 m\)"),
        ({"form": "elliptical", "thickness": 1.0}, r"least radius of curvature \(0.49 m\)"),
        ({"thickness": 2.0}, r"less than the span \(2 m\)"),
    ],
)
def test_what_cannot_be_built(keys: dict, words: str) -> None:
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=DENSITY)},
        structures=(spec(**keys),),
        joints=(Joint(friction=0.6),),
    )
    with pytest.raises(SceneError, match=words):
        check(scene, base=Path())
