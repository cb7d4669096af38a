"""Selectors of blocks and faces."""

import pytest

from masonry_fem.errors import SceneError
from masonry_fem.scene.selector import matches, select, split_face

NAMES = [("wall.c0.b0", "wall"), ("wall.c0.b1", "wall"), ("wall.c1.b0", "wall"), ("arch.v0", "arch")]


@pytest.mark.parametrize(
    ("selector", "chosen"),
    [
        ("*", [0, 1, 2, 3]),
        ("wall", [0, 1, 2]),
        ("wall.c0.*", [0, 1]),
        ("*.v?", [3]),
        ("wall.c[01].b0", [0, 2]),
    ],
)
def test_patterns_select_by_name_or_group(selector, chosen):
    assert select(selector, NAMES, "joints.0.between") == chosen


def test_capital_letters_count():
    assert not matches("Wall", ("wall",))


def test_faces_are_split_off():
    assert split_face("wall.*/top") == ("wall.*", "top")
    assert split_face("wall.*") == ("wall.*", None)


def test_selecting_nothing_names_the_nearest():
    with pytest.raises(SceneError) as caught:
        select("wal.c0.b1", NAMES, "supports.0.on")
    assert str(caught.value) == (
        "supports.0.on = 'wal.c0.b1' selects no block; did you mean 'wall.c0.b1'?; "
        "there are 'wall.c0.b0', 'wall', 'wall.c0.b1', 'wall.c1.b0', 'arch.v0', 'arch'"
    )


def test_faces_without_names_are_told_with_what_to_do():
    with pytest.raises(
        SceneError, match=r"'bottom' selects no face of block 'p'; .*physical groups of surfaces"
    ):
        select("bottom", [()], "supports.0.on", "face of block 'p'")
