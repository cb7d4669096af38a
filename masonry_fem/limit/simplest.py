"""Simplest: of all motions that prove an optimum, the one with the smallest sum of openings.

Often a collapse has many mechanisms. An interior-point solver ends in the middle of them, where every joint
opens a little. Minimising a sum of absolute values makes many of its terms zero: blocks that need not move
stay at rest, and blocks that can move as one do.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from masonry_fem.limit.conic import settings_of
from masonry_fem.limit.program import SMALL, FloatArray, Optimum, Program, judged

SLACK = 1e-11  # of the value: how much weaker the motion's bound may be, besides the optimum's own gap
LARGE = 10_000  # contact points: with more, this takes longer than the question itself
WORSE = 1e-6  # largest error of such a motion


def simplest(program: Program, found: Optimum) -> FloatArray:
    """Velocities of smallest opening that prove the same value, shape (n,).

    Parameters
    ----------
    program : What was solved.
    found : Its optimum; its own velocities are returned if no better ones are found.
    """
    strength = program.strength
    if strength.cut.any() or strength.bounded.any() or not np.isfinite(found.gap) or program.count > LARGE:
        return found.velocity
    import clarabel  # noqa: PLC0415 - only mechanisms need it

    c, d, n = program.count, program.dimension, len(program.fixed)
    opening = sparse.csr_array(program.matrix.T)[: c * d]
    held = sparse.csr_array(program.matrix.T)[c * d :]
    normal = opening[::d]
    scale = np.repeat(strength.friction[:, None], d, axis=1)
    scale[:, 0] = 1.0
    power = strength.apex @ normal - program.fixed
    rows: list[Any] = [
        sparse.csr_array(program.growing[None]),
        held,
        sparse.csr_array(power[None]),
        -sparse.diags_array(scale.ravel()) @ opening,
    ]
    limit = found.value + (SLACK + found.gap) * max(abs(found.value), SMALL)
    right = np.concatenate([[1.0], np.zeros(held.shape[0]), [limit], np.zeros(c * d)])
    kinds = [clarabel.ZeroConeT(1 + held.shape[0]), clarabel.NonnegativeConeT(1)]
    kinds += [clarabel.SecondOrderConeT(d)] * c
    nothing = sparse.csc_matrix((n, n))
    cost = np.asarray(normal.sum(axis=0)).ravel()
    matrix = sparse.csc_matrix(sparse.vstack(rows))
    velocity = np.array(
        clarabel.DefaultSolver(nothing, cost, matrix, right, kinds, settings_of(clarabel)).solve().x
    )
    made = judged(program, found.value, found.force, velocity)
    good = made.closing <= max(WORSE, found.closing) and made.gap <= max(WORSE, 10 * found.gap)
    return velocity if good else found.velocity
