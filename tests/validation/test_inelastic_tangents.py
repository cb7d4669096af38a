"""Newton's method with the tangent of a step's first iteration: the same answer, in more iterations.

A step's tangents are condensed once, as long as each iteration leaves at most half of what the last one left
of balance.
"""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import Scene, Solver
from tests.validation.test_inelastic_column import squeezed
from tests.validation.test_inelastic_cracks import torn


class Rounds:
    """Iterations of each step, and stones that were condensed up to its end."""

    def __init__(self) -> None:
        self.rounds: list[int] = []
        self.condensed: list[int] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        self.rounds.append(report.rounds)
        self.condensed.append(sum(group.factorisations for group in model.groups))


def solved(scene: Scene, tangent: str) -> tuple[RunResult, Rounds]:
    """A scene with one of the tangents."""
    seen = Rounds()
    made = solve_scene(
        check(msgspec.structs.replace(scene, solver=Solver(tangent=tangent))), observers=[seen]
    )
    return made, seen


def one_answer(scene: Scene) -> tuple[Rounds, Rounds]:
    """What both take to the same displacements, reactions and losses, to the tolerance of the rounds."""
    (exact, newton), (kept, modified) = (solved(scene, tangent) for tangent in ("consistent", "initial"))
    assert kept.march.outcome == exact.march.outcome == "equilibrium"
    for name, given in exact.summary.supports.items():
        size = np.linalg.norm(given.force)
        np.testing.assert_allclose(kept.summary.supports[name].force, given.force, atol=1e-7 * size)
    own, other = (one.march.ledger.material_dissipation for one in (exact, kept))
    assert other == pytest.approx(own, rel=1e-7)
    assert own > 0
    assert kept.march.ledger.imbalance <= 1e-8
    for one, other in zip(exact.march.state.bodies, kept.march.state.bodies, strict=True):
        if hasattr(one, "displacement"):
            size = np.abs(one.displacement).max()
            np.testing.assert_allclose(other.displacement, one.displacement, atol=1e-6 * size)
    assert exact.summary.solver.rounds == newton.rounds[-1]
    return newton, modified


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cube_that_hardens_between_rough_platens(dimension):
    """More iterations and fewer tangents, one a step where the stone has yielded before."""
    scene = squeezed(dimension, steps=4, friction=0.6, cells=3, hardening=5e9, dilatancy_angle=10.0)
    newton, modified = one_answer(scene)
    assert sum(modified.rounds) > sum(newton.rounds)
    assert modified.condensed[-1] < newton.condensed[-1]


@pytest.mark.slow
def test_a_bar_that_cracks():
    """An elastic tangent never leads to where it softens: there the tangents are made anew."""
    newton, modified = one_answer(torn(4, steps=100))
    assert sum(modified.rounds) > sum(newton.rounds)
    assert modified.condensed[-1] < newton.condensed[-1]
