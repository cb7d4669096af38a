"""One contact: v = W p + b with a (d, d) block W, solved exactly.

With the normal impulse eliminated (v_N = 0), what is left is tangential:

    v_T = A p_T + c,    A = W_TT − W_TN W_NT / W_NN,    c = b_T − W_TN b_N / W_NN

Three states are tried in turn: open (b_N ≥ 0), stick (v_T = 0 inside the cone), slip. In slip
v_T = −λ p_T with λ > 0, so p_T(λ) = −(A + λ I)⁻¹ c, and λ is the root of ‖p_T‖ = μ p_N. At λ = 0
the stick impulse lies outside the cone; as λ grows p_T vanishes and p_N → −b_N/W_NN > 0: a root
always exists. It is found by Newton's method on μ p_N/‖p_T‖ − 1, which is nearly linear in λ, inside a
bracket that halves whenever Newton would leave it, so that the search always ends. In a plane the direction
of slip is known, and p_N (1 + μ W_NT sign(p_T)/W_NN) = −b_N/W_NN.

Cohesion with a stiffness S folds into the block, w' = (I + w S)⁻¹ w and b' = (I + w S)⁻¹ b: what is
solved for is p̃, and p = p̃ − S v (``answer``).

Numba kernels; ``reduce_blocks`` prepares them, ``solve_contact`` is one contact by itself. They are one
source for the plane and for space. Which of them it is they see by the length of a tuple, ``axes``, which
Numba knows when it compiles: each has its own machine code, without what it does not need. Of plane vectors
the third component is 0.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]
# As many numbers as there are dimensions: a type of its own for the plane and for space.
Axes = tuple[int, ...]
# Of all contacts: (I + w S)⁻¹, w' and S, each (c, d, d); None where joints are dry.
Law = tuple[FloatArray, FloatArray, FloatArray] | None

# A's stiffness in any direction is kept above this fraction of ‖W_ii‖: below it is rounding
FLOOR = 1e-15
# relative accuracy of ‖p_T‖ = μ p_N, a few roundings
ACCURACY = 2e-15
# bracket halvings reach rounding from any start long before
LIMIT = 200


def reduce_blocks(blocks: FloatArray) -> FloatArray:
    """What the kernels need of diagonal blocks (c, d, d).

    Returns
    -------
    Shape (c, 9): 1/W_NN, W_NT/W_NN (2), W_TN (2), A (4, by rows); in a plane (c, 4), one each.
    1/W_NN is 0 where an impulse moves nothing: it stays 0 there.
    """
    normal = blocks[:, 0, 0]
    size = np.abs(blocks).max(axis=(1, 2), initial=0.0)
    moves = normal > FLOOR * size
    inverse = np.divide(1.0, normal, out=np.zeros_like(normal), where=moves)
    right = blocks[:, 0, 1:] * inverse[:, None]
    down = blocks[:, 1:, 0]
    tangential = blocks[:, 1:, 1:] - down[:, :, None] * right[:, None, :]
    small = FLOOR * np.where(size > 0, size, 1.0)
    if blocks.shape[1] == 2:
        tangential = np.maximum(tangential, small[:, None, None])
    else:
        # lift the symmetric part's least eigenvalue to the floor
        a11, a12 = tangential[:, 0, 0], tangential[:, 0, 1]
        a21, a22 = tangential[:, 1, 0], tangential[:, 1, 1]
        least = 0.5 * (a11 + a22) - 0.5 * np.hypot(a11 - a22, a12 + a21)
        tangential = tangential + np.maximum(small - least, 0.0)[:, None, None] * np.eye(2)
    return np.ascontiguousarray(
        np.concatenate([inverse[:, None], right, down, tangential.reshape(len(blocks), -1)], axis=1)
    )


@compiled
def slip(
    local: FloatArray, friction: float, alone: float, c1: float, c2: float, guess: float
) -> tuple[float, float, float, float]:
    """Impulse (p_N, p_1, p_2) of a slipping contact in 3D, and λ = ‖v_T‖/‖p_T‖.

    Parameters
    ----------
    local : The contact's row of ``reduce_blocks``.
    friction : Coefficient μ.
    alone : Normal impulse without friction, −b_N/W_NN [N s].
    c1, c2 : Tangential velocity c with v_N = 0 [m/s].
    guess : First guess of λ; none if it is not positive.
    """
    k1, k2 = local[1], local[2]
    a11, a12, a21, a22 = local[5], local[6], local[7], local[8]
    low, high = 0.0, math.inf
    lam = _first_slip(local, friction, alone, c1, c2, guess)
    pn, p1, p2, size = alone, 0.0, 0.0, 0.0
    for _ in range(LIMIT):
        m11, m22 = a11 + lam, a22 + lam
        inverse = 1.0 / (m11 * m22 - a12 * a21)
        p1 = (a12 * c2 - m22 * c1) * inverse
        p2 = (a21 * c1 - m11 * c2) * inverse
        size = math.sqrt(p1 * p1 + p2 * p2)
        pn = alone - k1 * p1 - k2 * p2
        if size == 0.0:  # beside a slip so fast that the impulse is lost in its square
            break
        miss = friction * pn - size
        if miss < 0.0:
            low = lam
        else:
            high = lam
        if abs(miss) <= ACCURACY * size or high - low <= ACCURACY * low:
            break
        d1 = (a12 * p2 - m22 * p1) * inverse
        d2 = (a21 * p1 - m11 * p2) * inverse
        rise = -friction * (k1 * d1 + k2 * d2) - friction * (pn / size) * (p1 / size * d1 + p2 / size * d2)
        new = lam - miss / rise if rise > 0.0 else -1.0
        if not (low < new < high):
            new = 4.0 * lam if high == math.inf else 0.5 * (low + high)
        if new == lam:
            break
        lam = new
    pn, p1, p2 = _onto_cone(pn, p1, p2, size, friction)
    return pn, p1, p2, lam


@compiled(inline="always")
def _first_slip(
    local: FloatArray, friction: float, alone: float, c1: float, c2: float, guess: float
) -> float:
    """λ to begin with: the guess, or where A is isotropic the exact one."""
    a11, a12, a21, a22 = local[5], local[6], local[7], local[8]
    if guess > 0.0 and not (a12 == a21 and a12 == 0.0 and a11 == a22):
        return guess
    mean = 0.5 * (a11 + a22)
    across = math.sqrt(c1 * c1 + c2 * c2) - friction * (local[1] * c1 + local[2] * c2)
    first: float = max(across / (friction * alone) - mean, 1e-3 * mean)
    return first


@compiled(inline="always")
def _onto_cone(pn: float, p1: float, p2: float, size: float, friction: float) -> tuple[float, float, float]:
    """An impulse whose p_T of size ``size`` is near the edge of the cone, put there."""
    if pn <= 0.0 or size == 0.0:
        return max(pn, 0.0), 0.0, 0.0
    if friction > 1.0:  # p_N is the small one
        return size / friction, p1, p2
    onto = friction * pn / size
    return pn, p1 * onto, p2 * onto


@compiled(inline="always")
def solve_local(
    local: FloatArray, friction: float, bn: float, b1: float, b2: float, guess: float, axes: Axes
) -> tuple[float, float, float, float]:
    """Impulse (p_N, p_T1, p_T2) of one contact, and λ (0 but for slip in space), next time's guess."""
    if bn >= 0.0 or local[0] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    alone = -bn * local[0]
    if len(axes) == 2:
        c1 = b1 + local[2] * alone
        p1 = -c1 / local[3]
        pn = alone - local[1] * p1
        along = -friction if c1 > 0.0 else friction
        divisor = 1.0 + along * local[1]
        # where stick is outside the cone the divisor is positive, but for rounding
        if (pn >= 0.0 and abs(p1) <= friction * pn) or divisor <= 0.0:
            return pn, p1, 0.0, 0.0
        pn = alone / divisor
        return pn, along * pn, 0.0, 0.0
    c1 = b1 + local[3] * alone
    c2 = b2 + local[4] * alone
    a11, a12, a21, a22 = local[5], local[6], local[7], local[8]
    inverse = 1.0 / (a11 * a22 - a12 * a21)
    p1 = (a12 * c2 - a22 * c1) * inverse
    p2 = (a21 * c1 - a11 * c2) * inverse
    pn = alone - local[1] * p1 - local[2] * p2
    if pn >= 0.0 and p1 * p1 + p2 * p2 <= friction * friction * pn * pn:
        return pn, p1, p2, 0.0
    if friction * alone == 0.0:
        return alone, 0.0, 0.0, 0.0
    slipping: tuple[float, float, float, float] = slip(local, friction, alone, c1, c2, guess)
    return slipping


@compiled(inline="always")
def times(blocks: FloatArray, i: int, xn: float, x1: float, x2: float, axes: Axes) -> Vector:
    """Product of a block and a vector.

    Parameters
    ----------
    blocks : Of all contacts, shape (c, d, d).
    i : Number of the block.
    xn, x1, x2 : The vector; x2 is left out in the plane.
    axes : As many numbers as there are dimensions, 2 or 3.
    """
    yn = blocks[i, 0, 0] * xn + blocks[i, 0, 1] * x1
    y1 = blocks[i, 1, 0] * xn + blocks[i, 1, 1] * x1
    y2 = 0.0
    if len(axes) == 3:
        yn += blocks[i, 0, 2] * x2
        y1 += blocks[i, 1, 2] * x2
        y2 = blocks[i, 2, 0] * xn + blocks[i, 2, 1] * x1 + blocks[i, 2, 2] * x2
    return yn, y1, y2


@compiled(forceinline=True)
def answer(
    local: FloatArray, friction: float, bn: float, b1: float, b2: float, guess: float, law: Law, i: int,
    axes: Axes,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Impulse (p_N, p_1, p_2) of one contact, cohesion included, and λ.

    Parameters
    ----------
    local : The contact's row of ``reduce_blocks``.
    friction : Coefficient μ.
    bn, b1, b2 : Velocity without the contact's own impulse [m/s].
    guess : First guess of λ.
    law : Folded blocks of contacts with cohesion; None where all joints are dry.
    i : Number of the contact.
    axes : As many numbers as there are dimensions, 2 or 3.
    """
    if law is None:  # compiled without the rest where joints are dry
        dry: tuple[float, float, float, float] = solve_local(local, friction, bn, b1, b2, guess, axes)
        return dry
    turn, block, stiffness = law
    cn, c1, c2 = times(turn, i, bn, b1, b2, axes)
    pn, p1, p2, lam = solve_local(local, friction, cn, c1, c2, guess, axes)
    vn, v1, v2 = times(block, i, pn, p1, p2, axes)
    sn, s1, s2 = times(stiffness, i, cn + vn, c1 + v1, c2 + v2, axes)
    return pn - sn, p1 - s1, p2 - s2, lam


@compiled(forceinline=True)
def pressed(
    pn: float, p1: float, p2: float, vn: float, v1: float, v2: float, law: Law, i: int, axes: Axes
) -> Vector:
    """Contact part p̃ = p + S v of one contact's impulse.

    Parameters
    ----------
    pn, p1, p2 : Impulse p [N s].
    vn, v1, v2 : Velocity v [m/s].
    law : Folded blocks of contacts with cohesion; None where all joints are dry.
    i : Number of the contact.
    axes : As many numbers as there are dimensions, 2 or 3.
    """
    if law is None:
        return pn, p1, p2
    sn, s1, s2 = times(law[2], i, vn, v1, v2, axes)
    return pn + sn, p1 + s1, p2 + s2


def solve_contact(block: ArrayLike, free_velocity: ArrayLike, friction: float) -> FloatArray:
    """Impulse of a single contact, shape (d,).

    Parameters
    ----------
    block : W, shape (d, d) [1/kg]; its symmetric part positive semi-definite.
    free_velocity : b, shape (d,) [m/s]. friction : μ ≥ 0.
    """
    W, b = np.asarray(block, dtype=float), np.asarray(free_velocity, dtype=float)
    local = reduce_blocks(W[None])[0]
    found = solve_local(local, float(friction), *b, *(0.0,) * (4 - len(b)), tuple(range(len(b))))
    return np.array(found[: len(b)])
