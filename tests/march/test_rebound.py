"""Elastic walls whose weight acts at once, with θ = ½: they rebound, and joints open and hit in most steps.

What impulses go round where stones meet, and move next to nothing, is not followed to its end unless a
tolerance asks for it.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.analyses.run import solve_scene
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.settings import ACCEPTABLE
from masonry_fem.nscd.solvers.elastic_krylov import Preconditioned
from masonry_fem.scene import loads

SCENE = """
fidelity = "elastic"
materials.stone = { density = 2400.0, young = 10e9, poisson = 0.2 }
mesh.divisions = [4, 2, 2]
joints = [{ friction = 0.6 }]
loads.gravity = [0.0, 0.0, -9.81]
analysis = { kind = "dynamics", step = 2e-3, duration = 0.04, theta = 0.5 }
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = 5
courses = 5
"""


class Steps(list):
    """The reports of all steps."""

    def record(self, model, state, report):
        self.append(report)


def rebounding(*keys):
    """The run of the wall, and the reports of its steps."""
    steps = Steps()
    return solve_scene(loads(SCENE, list(keys)), observers=(steps,)), steps


def moved(made):
    """Displacements of all nodes of the stones [m]."""
    bodies = zip(made.built.model.groups, made.march.state.bodies, strict=True)
    return np.concatenate([group.displacements(own).ravel() for group, own in bodies if not group.prescribed])


def test_a_step_takes_few_newton_steps():
    """One took 237 of them; energy and forces balance to rounding all the same."""
    made, steps = rebounding()
    assert made.outcome == "finished"
    assert max(step.iterations for step in steps) <= 60
    assert max(step.quality.error for step in steps) <= ACCEPTABLE
    assert max(abs(step.energy_error) for step in steps) <= 1e-12 * max(s.kinetic_energy for s in steps)
    assert max(step.block_balance for step in steps) <= 1e-12


def test_what_is_left_moves_nothing():
    """With a tolerance, which is met, nodes come to within 1e-7 of how far they go from where they are."""
    end = "analysis.duration=0.024"  # after two steps of that kind
    (near, steps), (exact, same) = rebounding(end), rebounding(end, "solver.tolerance=1e-10")
    assert max(step.quality.error for step in same) <= 1e-10 < max(step.quality.error for step in steps)
    far = moved(exact)
    assert np.abs(moved(near) - far).max() <= 1e-7 * np.abs(far).max()


def test_iterations_are_tried_again_in_each_step(monkeypatch):
    """What made them fail in one passes: factors take over to the end of the step."""
    failed, tried = [], []

    def solved(iteration, rhs):
        tried.append(len(rhs))
        if len(failed) < 2:
            failed.append(len(tried))
            raise StagnationError("for a test")
        return solve(iteration, rhs)

    solve = Preconditioned.__call__
    monkeypatch.setattr(Preconditioned, "__call__", solved)
    made, steps = rebounding("analysis.duration=0.008")
    assert made.outcome == "finished"
    assert len(steps) == 4
    assert failed == [1, 2]  # once in each of the first two steps
    assert len(tried) > 2
