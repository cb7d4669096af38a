"""Errors, bounds and advice on made-up cells whose truth is known."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest

from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.analyses.study.comparison import compare, distance
from masonry_fem.analyses.study.notes import notes
from masonry_fem.analyses.study.pareto import gather
from masonry_fem.analyses.study.quantity import Quantity, pick, told
from masonry_fem.analyses.study.recommendation import recommend
from masonry_fem.analyses.study.reference import Reference
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.setting import fineness
from masonry_fem.analyses.study.target import targets
from masonry_fem.analyses.study.variation import variations
from masonry_fem.errors import MasonryError

SIZES = ["mesh.size=0.4,0.2,0.1,0.05", "solver.tolerance=1e-2,1e-6"]


def rows(
    vary, value: Callable[..., float | None], cost: Callable[..., float], name: str = "probes.top"
) -> list[Row]:
    """Cells whose one quantity is a function of their values; None: it was not solved."""
    made = []
    for places in itertools.product(*(range(len(one.values)) for one in vary)):
        values = [one.values[place] for one, place in zip(vary, places, strict=True)]
        settings = {one.key: one.text(place) for one, place in zip(vary, places, strict=True)}
        cell = Cell(places, settings, "", str(places))
        number = value(*values)
        if number is None:
            made.append(Row.unsolved(cell, "failed", "broke"))
            continue
        quantity = Quantity((number,), (), "m").told()
        row = {"outcome": "equilibrium", "message": "", "cpu": cost(*values), "quantities": {name: quantity}}
        made.append(Row.of(cell, row))
    return made


def advice(vary, made: list[Row], accuracy: float, reference=None):
    wanted = Reference.of(reference, vary)
    vary = wanted.gather(vary)
    cases: dict[tuple[int, ...], list[Row]] = {}
    for row in made:
        key = tuple(place for one, place in zip(vary, row.cell.places, strict=True) if one.is_case)
        cases.setdefault(key, []).append(row)
    comparisons = [compare(case, vary, wanted) for case in cases.values()]
    (aim,) = targets(comparisons, ())
    return recommend(aim, comparisons, vary, accuracy), comparisons, gather(comparisons, vary, aim.names)


def test_the_cheapest_setting_within_the_bound() -> None:
    """Error h/2 of the truth 1, cost 1/h: the finest is off by 2.5 %, half as much again is allowed for."""
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: 1 + 0.5 * h, lambda h, tol: 1 / h)
    found, comparisons, points = advice(vary, made, 0.2)
    assert found.settings["mesh.size"] == "0.2"
    assert found.cheaper == pytest.approx(4)
    assert found.bound >= 0.1 / 1.025
    assert "4 times cheaper" in found.words
    order = comparisons[0].orders["probes.top"]["mesh.size"]
    assert order.order == pytest.approx(1, abs=1e-3)
    # nothing is known to be within 2 %
    none, *_ = advice(vary, made, 0.02)
    assert none.settings is None
    assert "give a finer mesh.size, whose order is 1.00" in none.words
    # of the two tolerances, which make no difference, one is among the best
    assert sum(point.best for point in points) == 4


def test_a_setting_that_is_right_by_accident_is_not_trusted() -> None:
    """At 0.2 the error passes through zero; the finer 0.1 is off by 8 %."""
    off = {0.4: 0.5, 0.2: 0.0, 0.1: 0.08, 0.05: 0.0}
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: 1 + off[h], lambda h, tol: 1 / h)
    found, comparisons, _ = advice(vary, made, 0.01)
    assert found.settings is None
    number = next(i for i, row in enumerate(made) if row.cell.settings["mesh.size"] == "0.2")
    assert comparisons[0].error["probes.top"][number] == 0
    assert comparisons[0].bound["probes.top"][number] >= 0.08


def test_a_loose_tolerance_shows() -> None:
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: 1 + 1e-4 * h + tol, lambda h, tol: 1 / h)
    found, *_ = advice(vary, made, 0.005)
    # the difference of the two tolerances is all that is known of the finer one
    assert found.settings is None
    assert "give a finer solver.tolerance" in found.words


def test_cells_that_failed_leave_the_rest() -> None:
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: None if h < 0.1 else 1 + 0.1 * h * h, lambda h, tol: 1 / h)
    found, comparisons, _ = advice(vary, made, 0.05)
    assert comparisons[0].reference.cell.settings["mesh.size"] == "0.1"
    assert found.settings["mesh.size"] == "0.4"


def test_every_case_has_to_be_met() -> None:
    """With friction 0.9 the mesh matters ten times as much."""
    vary = variations([*SIZES, "joints.0.friction=0.3,0.9"])
    made = rows(
        vary, lambda h, tol, mu: 10 * mu + (0.05 if mu < 0.5 else 0.5) * h * mu, lambda h, tol, mu: 1 / h
    )
    found, comparisons, points = advice(vary, made, 0.015)
    assert len(comparisons) == 2
    assert found.settings == {"mesh.size": "0.2", "solver.tolerance": "0.01"}
    assert next(point for point in points if point.settings == found.settings).cpu == pytest.approx(10)


def test_numbers_from_outside_are_exact() -> None:
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: 1 + 0.5 * h, lambda h, tol: 1 / h)
    found, *_ = advice(vary, made, 0.03, reference={"probes.top": 1.0})
    assert found.settings["mesh.size"] == "0.05"
    assert found.bound == pytest.approx(0.025)
    none, comparisons, _ = advice(vary, made, 0.01, reference={"probes.top": 1.0})
    assert comparisons[0].orders["probes.top"]["mesh.size"].order == pytest.approx(1.0, abs=1e-3)
    assert none.words.endswith("is within 2.5 %; give a finer mesh.size, whose order is 1.00")
    found, *_ = advice(vary, made, 0.03, reference={"mesh.size": 0.1})
    # finer cells than the chosen reference tell what it is off at least
    assert found.settings is None


def test_the_greatest_stress_is_not_recommended_where_it_grows() -> None:
    vary = variations(SIZES)
    made = rows(vary, lambda h, tol: h**-0.5, lambda h, tol: 1 / h, name="stress.max")
    found, *_ = advice(vary, made, 0.5)
    assert found.settings is None
    assert "grows with every finer mesh" in found.words


def test_components_that_symmetry_makes_zero_do_no_harm() -> None:
    summary = {
        "probes": {"mid": [0.0, 1e-22, -1e-6], "still": [1e-13, 0, 0]},
        "supports": {"ground": {"force": [1e-9, -1e-10, 1000.0], "moment": [0, 0, 0]}},
        "energy": {"strain": 0.5, "external_work": 1.0, "kinetic": 1e-14},
    }
    found = told(summary)
    other = Quantity((1e-9, -3e-22, -1.01e-6), ("x", "y", "z"), "m")
    assert distance(other, found["probes.mid"]) == pytest.approx(0.01, rel=1e-2)
    small = [name for name, value in found.items() if value.size <= value.least]
    assert small == ["probes.still", "thrust.ground", "energy.kinetic"]
    assert pick(found, "probes.mid.z").values == (-1e-6,)
    assert pick(found, "probes.mid.w") is None


# --- what was not solved is not known ---------------------------------------------------------------


@pytest.mark.parametrize("solved", ["coarse", "fine"])
def test_a_single_solved_value_tells_nothing_of_its_error(solved: str) -> None:
    """The other cell failed or ran out of time: 'error less than 1e-06 %' was said of 15 %."""
    vary = variations(["mesh.divisions=[2,2],[24,24]"])
    only = [2, 2] if solved == "coarse" else [24, 24]
    made = rows(vary, lambda n: 1.0 if n == only else None, lambda n: 1.0)
    found, comparisons, _ = advice(vary, made, 0.5)
    assert found.settings is None
    assert comparisons[0].rest["probes.top"] == float("inf")
    assert "of mesh.divisions one value was solved: solve another" in found.words
    assert "inf" not in found.words


def test_rigid_blocks_are_not_advised_where_the_elastic_ones_failed() -> None:
    vary = variations(["fidelity=rigid,elastic"])
    made = rows(vary, lambda fidelity: 1.0 if fidelity == "rigid" else None, lambda fidelity: 1.0)
    found, _, _ = advice(vary, made, 0.5)
    assert found.settings is None
    assert "the best value of fidelity was not solved" in found.words


def test_failed_quadratic_elements_leave_the_orders_of_linear_ones() -> None:
    vary = variations(["mesh.size=0.4,0.2,0.1", "mesh.element=Q1,Q2"])
    made = rows(vary, lambda h, e: 1 + 0.1 * h if e == "Q1" else None, lambda h, e: 1 / h)
    found, _, _ = advice(vary, made, 0.1)
    assert found.settings is not None
    assert 0 < found.bound < 0.1


def test_the_reference_itself_has_an_unknown_error_where_no_mesh_is_varied() -> None:
    vary = variations(["fidelity=rigid,elastic"])
    made = rows(vary, lambda fidelity: 1.0 if fidelity == "elastic" else 2.0, lambda fidelity: 1.0)
    wanted = Reference.of(None, vary)
    comparisons = [compare(made, wanted.gather(vary), wanted)]
    (aim,) = targets(comparisons, ())
    words = recommend(aim, comparisons, vary, 0.01, ("the mesh",)).words
    assert "which is the reference; what the mesh leaves is not known" in words
    assert "less than" not in words


def test_one_value_is_no_choice() -> None:
    vary = variations(["joints.0.friction=0.6"])
    found, _, _ = advice(vary, rows(vary, lambda mu: 1.0, lambda mu: 1.0), 0.01)
    assert "use the only setting: nothing cheaper will do" in found.words


# --- names --------------------------------------------------------------------------------------------


def test_a_misspelt_quantity_is_told_those_that_are_there() -> None:
    vary = variations(["mesh.size=0.2,0.1"])
    made = rows(vary, lambda h: 1 + h, lambda h: 1.0, "thrust.left")
    wanted = Reference.of(None, vary)
    comparisons = [compare(made, vary, wanted, ["thurst"])]
    with pytest.raises(
        MasonryError,
        match=r"--quantity thurst: no such quantity; did you mean 'thrust'\?; known: 'thrust.left'",
    ):
        targets(comparisons, ["thurst"])


def test_a_quantity_that_the_reference_lacks_is_told_so() -> None:
    vary = variations(["mesh.size=0.2,0.1"])
    made = rows(vary, lambda h: 1 + h, lambda h: 1.0, "thrust.left")
    comparisons = [compare(made, vary, Reference.of({"probes.top": 3.0}, vary), ["thrust.left"])]
    with pytest.raises(MasonryError, match=r"--quantity thrust.left: the reference does not have it"):
        targets(comparisons, ["thrust.left"])


def test_numbers_for_what_no_cell_has_are_refused() -> None:
    vary = variations(["mesh.size=0.2,0.1"])
    made = rows(vary, lambda h: 1 + h, lambda h: 1.0)
    with pytest.raises(MasonryError, match=r"no quantity called 'probes.nix'; known: 'probes.top'"):
        Reference.of({"probes.nix": 3.0}, vary).check(made)
    Reference.of({"probes.top": 3.0}, vary).check(made)


def test_the_case_that_failed_is_named() -> None:
    vary = variations(["joints.0.friction=0.2,0.6"])
    made = rows(vary, lambda mu: 1.0 if mu > 0.5 else None, lambda mu: 1.0)
    wanted = Reference.of(None, vary)
    comparisons = [compare([row], vary, wanted) for row in made]
    said = notes(vary, made, comparisons, wanted)
    assert "no cell of joints.0.friction = 0.2 was solved: there is nothing to compare with" in said


def test_cells_side_by_side_are_told_to_cost_more() -> None:
    vary = variations(["mesh.size=0.2,0.1"])
    made = rows(vary, lambda h: 1 + h, lambda h: 1.0)
    wanted = Reference.of(None, vary)
    comparisons = [compare(made, vary, wanted)]
    for together in (True, False):
        said = notes(vary, made, comparisons, wanted, together=together)
        assert any("side by side" in note for note in said) is together


def test_a_misspelt_name_ranks_as_coarsest() -> None:
    """Its cell is a bad scene, whose message says what is expected."""
    ranks, _ = fineness("fidelity", ["rigid", "reducd"])
    assert ranks == [1, 0]
