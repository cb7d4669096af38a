"""Steps that are halved as their contacts are not solved."""

from __future__ import annotations

from dataclasses import replace

import pytest
from msgspec.structs import replace as replaced

import masonry_fem.march.increments as dividing
from masonry_fem.analyses.run import solve_scene
from masonry_fem.nscd import Outcome
from masonry_fem.scene.specs import Dynamics
from tests.extremes.solids import lifted

STATICS, TIME = None, Dynamics(step=0.02, duration=0.04)


@pytest.mark.parametrize(
    ("fidelity", "analysis", "longest", "steps"),
    [("elastic", STATICS, 0.25, 4), ("rigid", STATICS, 0.25, None), ("elastic", TIME, 0.01, 4)],
)
def test_contacts_that_are_not_solved_halve_a_step_of_blocks_that_deform(
    fidelity, analysis, longest, steps, monkeypatch
):
    """The solver is made to find nothing in more than a quarter of the load, or a hundredth of a second."""
    solved = dividing.meeting_step

    def found(coupling, state, scheme, *rest, **keys):
        met, made = solved(coupling, state, scheme, *rest, **keys)
        if scheme.step > longest:
            far = replace(made.solution.quality, natural_map=0.1)
            made = replace(made, solution=replace(made.solution, outcome=Outcome.UNDECIDED, quality=far))
        return met, made

    monkeypatch.setattr(dividing, "meeting_step", found)
    scene = lifted(0.0, fidelity=fidelity)
    result = solve_scene(scene if analysis is None else replaced(scene, analysis=analysis))
    assert (
        result.outcome == {STATICS: "equilibrium", TIME: "finished"}[analysis] if steps else "no_convergence"
    )
    if steps is not None:
        assert result.march.state.index == steps


def test_a_step_in_time_of_which_no_part_is_solved_ends_the_march(monkeypatch):
    """Six parts are tried, each half as long as the one before, and no second halves."""
    solved, tried = dividing.meeting_step, []

    def lost(coupling, state, scheme, *rest, **keys):
        met, made = solved(coupling, state, scheme, *rest, **keys)
        tried.append(scheme.step)
        far = replace(made.solution.quality, natural_map=0.1)
        return met, replace(made, solution=replace(made.solution, outcome=Outcome.UNDECIDED, quality=far))

    monkeypatch.setattr(dividing, "meeting_step", lost)
    result = solve_scene(replaced(lifted(0.0, fidelity="elastic"), analysis=TIME))
    assert result.outcome == "no_convergence"
    assert tried == [0.02 / 2**halved for halved in range(6)]
