"""Steps of statics that are halved as their contacts are not solved."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest

import masonry_fem.march.increments as dividing
from masonry_fem.analyses.run import solve_scene
from masonry_fem.joints import fold
from masonry_fem.nscd import Outcome, solve
from masonry_fem.scene.specs import Solver
from tests.extremes.solids import lifted


@pytest.mark.parametrize(("fidelity", "steps"), [("elastic", 4), ("rigid", None)])
def test_contacts_that_are_not_solved_halve_a_step_of_blocks_that_deform(fidelity, steps, monkeypatch):
    """The solver is made to find nothing in more than a quarter of the load."""
    solved = dividing.meeting_step

    def found(coupling, state, scheme, *rest, **keys):
        met, made = solved(coupling, state, scheme, *rest, **keys)
        if scheme.step > 0.25:
            far = replace(made.solution.quality, natural_map=1e-3)
            made = replace(made, solution=replace(made.solution, outcome=Outcome.UNDECIDED, quality=far))
        return met, made

    monkeypatch.setattr(dividing, "meeting_step", found)
    result = solve_scene(lifted(0.0, fidelity=fidelity))
    assert result.outcome == ("no_convergence" if steps is None else "equilibrium")
    if steps is not None:
        assert result.march.state.index == steps


@pytest.mark.parametrize("fidelity", ["elastic", "rigid"])
def test_a_step_ends_where_its_time_is_up(fidelity, monkeypatch):
    """Neither other rounds nor halves of it begin, which would have the same limit each."""
    asked = []

    def late(problem, settings, start):
        asked.append(settings.time_limit)
        return replace(solve(problem, settings, start), outcome=Outcome.TIME_LIMIT)

    monkeypatch.setattr(fold, "solve", late)
    given = msgspec.structs.replace(lifted(0.0, fidelity=fidelity), solver=Solver(time_limit=5.0))
    result = solve_scene(given)
    assert result.outcome == "no_convergence"
    assert "time limit" in result.message
    assert asked == [5.0]
