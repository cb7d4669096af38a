"""Which joint record holds where: by the joint's inclination to the horizontal."""

import logging
from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.limit.strength import strength_of
from masonry_fem.scene import check, load, loads, specs
from masonry_fem.structures.wall import WallStructure

BY_ANGLE = (
    specs.Joint(friction=0.1),
    specs.Joint(friction=0.2, inclination=(0.0, 30.0)),
    specs.Joint(friction=0.3, inclination=(60.0, 90.0)),
)


def wall(dimension, **keys):
    brick = (0.4, 0.2) if dimension == 2 else (0.4, 0.2, 0.2)
    structure = WallStructure(name="w", material="m", brick=brick, columns=2, courses=2)
    given = {
        "dimension": dimension,
        "fidelity": "rigid",
        "materials": {"m": specs.Material(density=2000.0)},
        "structures": (structure,),
        "joints": BY_ANGLE,
    }
    return specs.Scene(**(given | keys))


@pytest.mark.parametrize("dimension", [2, 3])
def test_beds_lie_and_heads_stand(dimension):
    model = build(check(wall(dimension)), Path()).model
    label = np.array([interface.label for interface in model.interfaces])[model.contacts.interface]
    assert set(label) == {"bed", "head"}
    np.testing.assert_array_equal(strength_of(model).friction, np.where(label == "bed", 0.2, 0.3))


def test_joints_of_a_file_whose_labels_tell_nothing(repository):
    folder = repository / "demos"
    scene = msgspec.structs.replace(load(folder / "keystone.toml"), joints=BY_ANGLE, fidelity="rigid")
    model = build(check(scene, base=folder), folder).model
    angle = np.degrees(np.arccos(np.abs([one.normal[-1] for one in model.interfaces])))
    expected = np.select([angle <= 30, angle >= 60], [0.2, 0.3], 0.1)
    np.testing.assert_array_equal(strength_of(model).friction, expected[model.contacts.interface])
    assert set(expected) == {0.1, 0.2, 0.3}
    assert len({one.label for one in model.interfaces}) == 1


def test_the_last_that_matches_holds():
    """By label and by angle; a law by angle."""
    law = specs.law_record("mohr_coulomb", cohesion=1e5)
    ground = specs.Joint(friction=0.5, inclination=(0.0, 0.0), between=("w.ground", "*"), law=law)
    joints = (*BY_ANGLE, specs.Joint(friction=0.4, interface="bed"), ground)
    model = build(check(wall(2, joints=joints)), Path()).model
    below = [
        "ground" in "".join(model.assembly.blocks[block].name for block in one.blocks)
        for one in model.interfaces
    ]
    expected = [
        0.5 if down else 0.4 if one.label == "bed" else 0.3
        for down, one in zip(below, model.interfaces, strict=True)
    ]
    np.testing.assert_array_equal(strength_of(model).friction, np.array(expected)[model.contacts.interface])
    assert [len(points) for part, points in model.laws.parts if part.name == "mohr_coulomb"] == [4]


def test_a_joint_for_which_nothing_holds_is_named_with_its_angle():
    with pytest.raises(SceneError, match=r"none matches the interface 'head'.*90 degrees to the horizontal"):
        build(check(wall(2, joints=BY_ANGLE[1:2])), Path())


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("[30, 10]", r"joints\.0\.inclination is \[30\.0, 10\.0\], expected the smaller angle first"),
        ("[0, 91]", r"joints\.0\.inclination\.1 is 91, expected an angle >= 0 and <= 90 in deg"),
        ("[0]", r"joints\.0\.inclination is \[0\], expected a list of 2"),
    ],
)
def test_angles_that_are_none(value, words):
    text = f"""
    fidelity = "rigid"
    [materials.m]
    density = 2000.0
    [[structures]]
    kind = "stack"
    name = "s"
    material = "m"
    size = [1, 1, 1]
    count = 1
    [[joints]]
    inclination = {value}
    """
    with pytest.raises(SceneError, match=words):
        loads(text)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        (
            {"interface": "beds"},
            r"joints.3 (interface = 'beds') matches none of the joints, whose labels are 'bed', 'head'; "
            r"did you mean 'bed'?",
        ),
        ({"between": ("tower.*", "*")}, "joints.3 (between = ('tower.*', '*')) matches none"),
        ({"inclination": (40.0, 50.0)}, "joints.3 (inclination = (40.0, 50.0)) matches none"),
    ],
)
def test_a_record_that_holds_nowhere_is_told(keys, told, caplog):
    joints = (*BY_ANGLE, specs.Joint(friction=0.4, **keys))
    with caplog.at_level(logging.WARNING):
        build(check(wall(2)), Path())
        assert "matches none" not in caplog.text  # overruled by later ones is no reason
        build(check(wall(2, joints=joints)), Path())
    assert told in caplog.text


@pytest.mark.parametrize("inset", [0.5, 0.6])
def test_plane_faces_need_contacts_far_from_the_centroid(inset):
    """With an inset below 1/√3 no areas have the second moment of the face."""
    given = check(wall(3, joints=(specs.Joint(placement="navier", inset=inset),)))
    if inset < 1 / np.sqrt(3):
        with pytest.raises(SceneError, match=r"joints\.0\.inset is 0\.5 with placement 'navier', expected"):
            build(given, Path())
    else:
        model = build(given, Path()).model
        assert (model.contacts.area > 0).all()
