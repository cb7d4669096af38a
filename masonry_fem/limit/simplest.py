"""Simplest: of all motions that prove an optimum, the one that opens least.

A collapse often has many mechanisms, and an interior point ends at the middle of them, where every joint
opens a little. Here the sum of the openings is made as small as it can be, as sums of absolute values make
many of their terms zero: what need not move rests, and what can move as one does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from masonry_fem.limit.conic import settings_of
from masonry_fem.limit.program import SMALL, FloatArray, Optimum, Program, judged

SLACK = 1e-11  # of the value: how much worse the motion may prove it, beyond what is known of it
LARGE = 10_000  # contact points: beyond them it takes longer than the question itself
WORSE = 1e-6  # error that such a motion may have


def simplest(program: Program, found: Optimum) -> FloatArray:
    """Velocities of least opening that prove the same value, (n,); those found if there are none better."""
    strength = program.strength
    if strength.cut.any() or not np.isfinite(found.gap) or program.count > LARGE:
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
