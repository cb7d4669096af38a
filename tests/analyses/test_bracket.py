"""The search for a bracket, on verdicts made to order."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.analyses.bracket import EARLY, MOST, Bracket


def verdicts(limit: float, doubt: tuple[float, float] = (0.0, 0.0)):
    """Stands below a limit, but nothing is decided in a range."""

    def attempt(multiplier: float) -> str:
        if doubt[0] < multiplier < doubt[1]:
            return "undecided"
        return "stands" if multiplier < limit else "falls"

    return attempt


@given(
    limit=st.floats(1e-3, 1e3),
    guess=st.one_of(st.none(), st.floats(1e-3, 1e3)),
    sharp=st.booleans(),
    tolerance=st.sampled_from([0.1, 0.01, 1e-4]),
)
def test_it_closes_in_on_the_limit(limit, guess, sharp, tolerance) -> None:
    bracket = Bracket(verdicts(limit), tolerance=tolerance, first=0.1)
    bracket.search(0.0, guess, sharp=sharp)
    assert bracket.ending == "bracketed"
    assert bracket.stands < limit <= bracket.falls
    assert bracket.falls - bracket.stands <= tolerance * bracket.falls
    assert bracket.trials <= MOST


def test_a_good_guess_takes_three_trials() -> None:
    bracket = Bracket(verdicts(0.29556), tolerance=0.01, first=0.1)
    bracket.search(0.0, 0.29556, sharp=True)
    assert bracket.trials == 3
    assert bracket.falls - bracket.stands <= 0.01 * bracket.falls


@given(low=st.floats(0.3, 0.6), width=st.floats(0.02, 0.3))
def test_undecided_trials_widen_the_bracket_and_never_count_as_a_fall(low: float, width: float) -> None:
    bracket = Bracket(verdicts(0.65, (low, low + width)), tolerance=0.01, first=0.1)
    bracket.search(0.0, None)
    assert bracket.falls >= 0.65
    assert bracket.stands < 0.65
    for value in bracket.doubtful:
        assert bracket.stands < value < bracket.falls
    # where the range holds the limit both its ends are found, else it is passed by or told
    if low < 0.65 < low + width:
        assert bracket.ending == "undecided"
        assert bracket.stands == pytest.approx(low, abs=0.0101 * bracket.falls)
        assert bracket.falls == pytest.approx(low + width, abs=0.0101 * bracket.falls)
    elif not bracket.doubtful:
        assert bracket.ending == "bracketed"


def test_what_never_falls_has_no_limit() -> None:
    bracket = Bracket(lambda _: "stands", tolerance=0.01, first=0.1)
    bracket.search(0.0, None)
    assert bracket.ending == "unlimited"
    assert bracket.falls is None


def test_it_must_not_fall_at_the_start() -> None:
    bracket = Bracket(lambda _: "falls", tolerance=0.01, first=0.1)
    bracket.search(0.0, 1.0, sharp=True)
    assert (bracket.ending, bracket.trials, bracket.stands) == ("falls at the start", 1, None)


def test_where_nothing_is_decided_the_search_ends_soon() -> None:
    bracket = Bracket(lambda _: "undecided", tolerance=0.01, first=0.1)
    bracket.search(0.0, 1.0, sharp=True)
    assert (bracket.ending, bracket.stands, bracket.falls) == ("undecided", None, None)
    assert bracket.trials <= EARLY


@pytest.mark.parametrize(("guess", "sharp"), [(0.65, True), (0.7, False), (None, False)])
def test_it_does_without_a_start_that_is_undecided(guess: float | None, sharp: bool) -> None:
    bracket = Bracket(verdicts(0.65, (-1e-9, 1e-9)), tolerance=0.01, first=0.1)
    bracket.search(0.0, guess, sharp=sharp)
    assert bracket.ending == "bracketed"
    assert bracket.stands < 0.65 <= bracket.falls
    assert bracket.falls - bracket.stands <= 0.01 * bracket.falls


def test_nothing_but_the_start_stands() -> None:
    """A ball on a table: the bracket shrinks to what counts as none."""
    bracket = Bracket(lambda m: "stands" if m == 0 else "falls", tolerance=0.01, first=0.1)
    bracket.search(0.0, None)
    assert bracket.stands == 0
    assert bracket.falls < 1e-9


def test_what_is_known_at_an_interruption_is_kept() -> None:
    seen: list[float] = []

    def attempt(multiplier: float) -> str:
        seen.append(multiplier)
        if len(seen) > 4:
            raise KeyboardInterrupt
        return "stands" if multiplier < 0.25 else "falls"

    bracket = Bracket(attempt, tolerance=1e-3, first=0.1)
    with pytest.raises(KeyboardInterrupt):
        bracket.search(0.0, None)
    assert bracket.ending == "interrupted"
    assert (bracket.stands, bracket.falls) == (0.2, pytest.approx(0.3))
