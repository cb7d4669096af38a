"""Overrides: ``--set key=value``."""

import pytest

from masonry_fem.errors import SceneError
from masonry_fem.scene import loads
from masonry_fem.scene.specs import Dynamics


def test_values_are_toml_or_else_texts(arch):
    scene = loads(
        arch,
        (
            "title=An arch = a line that stands",
            "structures.0.voussoirs=21",
            "structures.arch.thickness=40 cm",
            "structures.arch.mesh.divisions=[2, 3]",
            "materials.stone.poisson=0.3",
            "output.pictures=false",
            'loads.gravity=[0, "-1 m/s^2"]',
        ),
    )
    assert scene.title == "An arch = a line that stands"
    assert scene.structures[0].voussoirs == 21
    assert scene.structures[0].thickness == 0.4
    assert scene.structures[0].mesh.divisions == (2, 3)
    assert scene.materials["stone"].poisson == 0.3
    assert scene.output.pictures is False
    assert scene.loads.gravity == (0.0, -1.0)


def test_tables_and_list_items_that_lack_are_made(arch):
    changes = ("analysis.kind=dynamics", "analysis.step=1e-3", "analysis.duration=1", "joints.0.friction=0.3")
    scene = loads(arch, changes)
    assert scene.analysis == Dynamics(step=1e-3, duration=1.0)
    assert [joint.friction for joint in scene.joints] == [0.3]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("structures.arch", "--set structures.arch: expected key=value, for example analysis.step=1e-3"),
        ("=3", "--set =3: expected key=value, for example analysis.step=1e-3"),
        (
            "structures.arhc.voussoirs=1",
            "--set structures.arhc.voussoirs=1: 'structures' has no item named 'arhc'; did you mean 'arch'?",
        ),
        (
            "structures.7.voussoirs=1",
            "--set structures.7.voussoirs=1: 'structures' has 1 items, expected an index up to that",
        ),
        (
            "dimension.x=1",
            "--set dimension.x=1: 'dimension' is a value, it has no key 'x'",
        ),
        (
            "structures.arch.thickness=-1",
            "scene with --set structures.arch.thickness=-1: "
            "structures.arch.thickness is -1, expected a length > 0 in m",
        ),
        (
            "structures.arch.thickness=30 deg",
            "scene with --set structures.arch.thickness=30 deg: "
            "structures.arch.thickness is '30 deg', expected a length > 0 in m",
        ),
        (
            "structures.arch.thicknes=1",
            "scene with --set structures.arch.thicknes=1: "
            "unknown key 'thicknes' in structures.arch; did you mean 'thickness'?",
        ),
    ],
)
def test_a_bad_override_is_named(arch, change, expected):
    with pytest.raises(SceneError) as caught:
        loads(arch, (change,))
    assert str(caught.value) == expected


def test_a_star_is_all_items_that_have_the_rest_of_the_key(arch):
    more = ("materials.brick.density=1800", "materials.brick.young=2 GPa", "materials.sand.density=1600")
    scene = loads(arch, (*more, "materials.*.young=3 GPa", "structures.*.thickness=0.5"))
    young = {name: material.young for name, material in scene.materials.items()}
    assert young["brick"] == young["stone"] == 3e9
    assert young["sand"] is None
    assert [one.thickness for one in scene.structures] == [0.5]
    with pytest.raises(SceneError, match="nothing has such a key, expected that an item"):
        loads(arch, ("materials.*.yuong=3 GPa",))
