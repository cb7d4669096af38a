"""Steps of statics that are halved as their contacts are not solved."""

from __future__ import annotations

from dataclasses import replace

import pytest

import masonry_fem.march.increments as dividing
from masonry_fem.analyses.run import solve_scene
from masonry_fem.nscd import Outcome
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
