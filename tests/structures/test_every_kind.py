"""Every kind of structure, by the example in its docstring: a new file in the folder is tested here, too."""

from pathlib import Path

import pytest

from masonry_fem.records.docstring import example, meanings
from masonry_fem.scene import dumps, loads
from masonry_fem.structures import build_structure, kinds

SCENE = """
fidelity = "rigid"
materials.stone.density = 2400.0
loads.gravity = [0.0, 0.0, -9.81]
[[structures]]
"""
KINDS = kinds()
MADE = [name for name, kind in KINDS.items() if not kind.record.endings]  # others are read from files


def scene_of(name):
    """The example of a kind in a scene."""
    kind = KINDS[name]
    lines = example(kind.record)
    assert lines, f"{kind.file}: add a table of a scene file under Examples to {kind.record.__name__}"
    return loads(SCENE + lines)


@pytest.fixture(params=MADE)
def structure(request):
    """The structure of each example."""
    (structure,) = scene_of(request.param).structures
    assert structure.__struct_config__.tag == request.param
    return structure


@pytest.mark.parametrize("name", MADE)
def test_the_example_is_saved_as_it_was_read(name):
    scene = scene_of(name)
    assert loads(dumps(scene)) == scene


def test_its_blocks_are_foreseen(structure):
    """A record says how many blocks its keys ask for, at least roughly."""
    made = len(build_structure(structure, 3, Path(), None).blocks)
    foreseen = structure.foreseen(3)
    assert made / 1.5 <= foreseen.blocks <= 1.5 * made
    assert all(hasattr(structure, key) for key in foreseen.keys)


def test_its_blocks_are_solids_of_its_name(structure):
    assembly = build_structure(structure, 3, Path(), None)
    names = [block.name for block in assembly.blocks]
    assert len(set(names)) == len(names)
    assert all(name == structure.name or name.startswith(f"{structure.name}.") for name in names)
    assert all(structure.name in block.groups for block in assembly.blocks if not block.support)
    assert any(block.support for block in assembly.blocks) == structure.carries
    assert all(shape.solid.mass_properties().volume > 0 for shape in assembly.shapes)


@pytest.mark.parametrize("name", KINDS)
def test_its_keys_are_explained(name):
    record = KINDS[name].record
    assert set(meanings(record)) == set(record.__struct_fields__), KINDS[name].file
