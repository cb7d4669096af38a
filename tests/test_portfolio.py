"""The trial set and the portfolio's table, on a handful of small problems; ``benchmarks`` has the whole."""

from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import portfolio, trial_set
from benchmarks.portfolio import Switch, measured, solved, solving, told
from benchmarks.trial_set import Recipe, Trial, recipes, trials
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.turns import Turn

SMALL = (
    "plane walls 4x12 mu 0.5 at 1.1",
    "plane arches 11 mu 0.7 at 0.5",
    "moving walls 5x8 mu 0.6 at 1.1 step 10",
)


@pytest.fixture(scope="module")
def few() -> list[Recipe]:
    found = {f"{recipe.family} {recipe.name}": recipe for recipe in recipes()}
    return [found[name] for name in SMALL]


@pytest.fixture(scope="module")
def given(few: list[Recipe], tmp_path_factory: pytest.TempPathFactory) -> list[Trial]:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trial_set, "recipes", lambda size: few)
        return list(trials(tmp_path_factory.mktemp("set")))


def test_every_problem_of_the_set_has_a_file_of_its_own() -> None:
    every = recipes()
    assert len(every) >= 200
    assert len({recipe.path for recipe in every}) == len(every)
    assert {recipe.family for recipe in recipes("tiny")} == {r.family for r in every} - {"large walls"}


@pytest.mark.slow
def test_a_kept_problem_is_read_as_it_was_made(
    few: list[Recipe], given: list[Trial], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial_set, "recipes", lambda size: few)
    made, read = list(trials(tmp_path)), list(trials(tmp_path))
    for one, other, before in zip(made, read, given, strict=True):
        assert one.right == other.right == before.right
        assert (one.start is None) == (other.start is None)
        np.testing.assert_array_equal(one.problem.rigid_impulse, other.problem.rigid_impulse)
        np.testing.assert_allclose(one.problem.rigid_impulse, before.problem.rigid_impulse, rtol=1e-6)
    assert [trial.start is None for trial in read] == [True, True, False]


@pytest.mark.slow
def test_what_is_not_at_work_costs_nothing_and_what_all_hangs_on_loses_all(given: list[Trial]) -> None:
    def one_step(*_: object) -> list[Turn]:
        return [Turn("lame", lambda _: True, lambda _: InteriorPoint(), iterations=1)]

    parts = [Switch("path", "turn"), Switch("all", "part", solving, "turns", one_step)]
    base, (path, lame) = measured(given, parts, 20.0)
    assert [row.right for row in base] == [True, True, True]
    assert base[0].outcome == "no_equilibrium"
    assert (path.at_work, path.lost) == (0, [])
    # a proof alone tells that the first one falls
    assert (lame.at_work, len(lame.lost)) == (3, 2)
    table = told(base, [path, lame])
    assert "3 problems" in table
    assert "| path | turn | 0 | 0 | 0 | 1.00 |" in table


@pytest.mark.slow
def test_the_limit_is_one_of_cpu_time(given: list[Trial], monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = count(0.0, 30.0)
    monkeypatch.setattr(portfolio, "CPU", SimpleNamespace(monotonic=ticks.__next__, process_time=float))
    assert solved(given[1], 20.0).outcome == "time_limit"
