"""Told words: numbers of joints, stones and supports, in sentences that are right for one and for many."""

from masonry_fem.output.told_words import (
    finer_elements,
    greatest_supports,
    joint_count,
    joint_words,
    stone_words,
)

JOINTS = dict.fromkeys(("open", "closed", "middle_third", "cracked", "hinge", "held", "slide"), 0)


def test_joints_are_counted_by_state():
    assert joint_words(JOINTS | {"middle_third": 3, "cracked": 1200, "hinge": 1, "slide": 1}) == (
        "3 within the middle third, 1 200 cracked, 1 hinge; 1 slides"
    )
    assert joint_words(JOINTS | {"hinge": 2, "open": 1, "slide": 2}) == "2 hinges, 1 open; 2 slide"


def test_joints_of_all_states_are_counted():
    assert joint_count(JOINTS | {"hinge": 1, "slide": 1}) == "1 joint"
    assert joint_count(JOINTS | {"hinge": 200, "cracked": 1000, "slide": 3}) == "1 200 joints"


def test_one_stone_is_one_stone():
    told = {"over": 1, "rigid": 2, "one_sided": 1, "unchecked": 0}
    assert list(stone_words(told)) == [
        ("over", "1 stone uses more than all of its design strength"),
        ("rigid", "2 stones are rigid: only their mean stress is known"),
        ("one_sided", "1 stone has one strength only; the other is not checked"),
    ]


def test_of_many_supports_those_with_the_greatest_forces_are_named_in_their_order():
    supports = {name: {"force": [0.0, force]} for name, force in zip("abcde", (3, -9, 1, 5, 4), strict=True)}
    assert greatest_supports(supports) == (["a", "b", "d", "e"], 1)
    assert greatest_supports(supports, 2) == (["b", "d"], 3)
    assert greatest_supports({}) == ([], 0)


def test_refinement_is_named_where_it_can_be_had():
    assert "--refine-to" in finer_elements({})
    assert "--refine-to" not in finer_elements({"stages": [{"name": "built"}]})
