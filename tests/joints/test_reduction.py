"""Folding a law into the contact's own block, among several contacts that share blocks."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Assignment, Bed, MohrCoulomb, Reduction
from masonry_fem.nscd import graphs
from masonry_fem.nscd.local import solve_contact
from tests.joints.samples import SAMPLES

STEP = 0.02


def sweep(W, q, gap, reduction, sweeps=4000):
    """Gauss–Seidel with folded laws: off-diagonal sums keep the physical reaction."""
    c, d = q.shape
    blocks = np.array([W[i * d : i * d + d, i * d : i * d + d] for i in range(c)])
    r, v = np.zeros((c, d)), np.zeros((c, d))
    graph = np.zeros((c, d))
    for _ in range(sweeps):
        old = r.copy()
        for i in range(c):
            rows = slice(i * d, i * d + d)
            others = q[i] + STEP * (W[rows] @ r.ravel() - blocks[i] @ r[i])
            own = reduction.take(np.array([i]))
            w, free = own.fold(blocks[i : i + 1], others[None], STEP)
            p = solve_contact(w[0], free[0] + gap[i], float(own.friction[0]))
            graph[i], v[i] = p / STEP, free[0] + w[0] @ p
            r[i] = graph[i] - own.adhesive_reaction(v[i : i + 1])[0]
        if np.abs(r - old).max() <= 1e-14 * np.abs(r).max():
            break
    return r, v, graph


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", SAMPLES[::3], ids=lambda law: law.name)
def test_folded_sweeps_solve_the_unfolded_problem(law, dimension):
    rng = np.random.default_rng(7)
    c, d = 5, dimension
    root = rng.normal(size=(c * d, c * d))
    W = 1e-4 * (root @ root.T / (c * d) + 0.5 * np.eye(c * d))
    q = rng.normal(size=(c, d)) * 1e-5 / STEP
    state, area, jump = law.initial(c, d), rng.uniform(0.01, 0.1, c), np.zeros((c, d))
    jump[:, 0] = rng.choice([0.0, 2e-6], c)
    reduction = law.reduce(state, jump, area, STEP)
    gap = np.zeros((c, d))
    gap[:, 0] = np.maximum(jump[:, 0] - reduction.closure, 0.0) / STEP
    r, own, graph = sweep(W, q, gap, reduction)
    # the relative velocity by the physical reaction, then the joint's own velocity, then the graphs
    v = q + STEP * (W @ r.ravel()).reshape(c, d)
    assert reduction.own_velocity(v, r, STEP) == pytest.approx(own, rel=1e-9, abs=1e-12)
    assert r + reduction.adhesive_reaction(own) == pytest.approx(graph, rel=1e-9, abs=1e-6)
    scale = np.full(c, 1e-4)
    error = graphs.natural_map(graph * STEP, own + gap, reduction.friction, scale)
    assert np.abs(error).max() <= 1e-9 * np.abs(graph * STEP).max() + 1e-15
    # and the law's state agrees with what the solver was told, where nothing evolved
    trial = law.update(state, state, jump, r, v, area, STEP)
    untouched = (trial.adhesion == state.adhesion) & (trial.dilation == 0)
    assert law.adhesive_reaction(trial, area)[untouched] == pytest.approx(
        reduction.adhesive_reaction(own)[untouched], rel=1e-9, abs=1e-6
    )


def test_dense_fold_is_the_local_one_for_a_single_contact():
    """(I + h W B)⁻¹ W of all contacts at once, for solvers that fold globally."""
    law = Bed(MohrCoulomb(cohesion=0.2e6, friction=0.7), 2e10, 1e10)
    joints = Assignment(((law, np.arange(1)),))
    state = joints.initial(1, 3)
    reduction = joints.reduce(state, np.zeros((1, 3)), np.array([0.1]), STEP)
    W = np.diag([1e-4, 2e-4, 3e-4])[None]
    folded, _ = reduction.fold(W, np.zeros((1, 3)), STEP)
    full = W[0] + np.diag(reduction.compliance[0])
    assert folded[0] == pytest.approx(np.linalg.inv(np.linalg.inv(full) + STEP * reduction.stiffness[0]))


def test_an_array_that_numpy_would_stretch_is_refused():
    dry = Reduction.dry(np.zeros(2), 2)
    with pytest.raises(LawError, match=r"stiffness of the shape \(2, 2\), expected \(2, 2, 2\).*reduce"):
        replace(dry, stiffness=np.ones((2, 2)))
