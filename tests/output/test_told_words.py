"""Told words: numbers of joints, stones and supports, in sentences that are right for one and for many."""

from masonry_fem.output.told_words import (
    damping_words,
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


def test_damping_is_told_with_its_factors_and_what_it_took():
    none = {"theta": 0.5, "velocity_factor": 1.0, "rayleigh": {}}
    energy = {"damping_dissipation": 3.1, "numerical_dissipation": 1e-12, "largest": 10.0}
    assert damping_words({}) == ""
    plane = damping_words({"damping": none, "energy": energy, "applied": [0.0, 1.0]})
    assert plane.endswith("J/m")
    assert damping_words({"damping": none, "energy": energy}) == (
        "none of the stones; θ = 0.5, finite steps took 0 J"
    )
    stones = {"brick": {"mass": 0.2, "stiffness": 0.0003}, "oak": {"mass": 0.0, "stiffness": 0.01}}
    impacts = {"impact_normal": 1.0, "impact_tangential": 0.5}
    told = none | {"theta": 0.7, "velocity_factor": 0.9, "rayleigh": stones, "restitution": [0.0, 0.3]}
    assert damping_words({"damping": told, "energy": energy | impacts}) == (
        "Rayleigh in brick (α = 0.2 1/s, β = 0.0003 s), Kelvin–Voigt in oak (β = 0.01 s), "
        "velocities × 0.9 after each step took 3.1 J; θ = 0.7, finite steps took 0 J; "
        "impacts with e = 0 to 0.3 took 1.5 J"
    )
