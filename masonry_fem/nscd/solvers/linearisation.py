"""Linearisation: the contact function of a Newton step and its derivatives, contact by contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.products import multiplied

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Linearisation:
    """The contact function at a point.

    Attributes
    ----------
    residual : F, shape (c, d).
    by_impulse : A = ∂F/∂p, shape (c, d, d).
    by_velocity : (∂F/∂v + A S) / ρ with the stiffness S of cohesion, shape (c, d, d).
    open : Contacts where F = p, shape (c,); not those with stiffness, where p follows v.
    plain : Contacts whose ``by_velocity`` is the identity, shape (c,).
    rho : ρ, shape (c,).
    """

    residual: FloatArray
    by_impulse: FloatArray
    by_velocity: FloatArray
    open: Mask
    plain: Mask
    rho: FloatArray


def bonded_contacts(velocity: FloatArray, rho: FloatArray) -> Linearisation:
    """All contacts closed and sticking: F = ρ v.

    Parameters
    ----------
    velocity : v, shape (c, d) [m/s].
    rho : ρ of each contact, shape (c,) [kg].
    """
    c, d = velocity.shape
    return Linearisation(
        residual=rho[:, None] * velocity,
        by_impulse=np.zeros((c, d, d)),
        by_velocity=np.tile(np.eye(d), (c, 1, 1)),
        open=np.zeros(c, dtype=bool),
        plain=np.ones(c, dtype=bool),
        rho=rho,
    )


def parted_contacts(bonded: Linearisation, impulse: FloatArray, apart: Mask) -> Linearisation:
    """The same, but some contacts are open: F = p.

    Parameters
    ----------
    bonded : With all contacts closed.
    impulse : p, shape (c, d) [N s].
    apart : Contacts that are open, shape (c,).
    """
    d = impulse.shape[1]
    free = np.where(apart[:, None, None], np.eye(d), 0.0)
    return replace(
        bonded,
        residual=np.where(apart[:, None], impulse, bonded.residual),
        by_impulse=free,
        by_velocity=np.eye(d) - free,
        open=apart,
        plain=~apart,
    )


def linearise(
    pressed: FloatArray,
    velocity: FloatArray,
    friction: FloatArray,
    rho: FloatArray,
    stiffness: FloatArray | None = None,
) -> Linearisation:
    """The Alart–Curnier function at (p̃, v).

    Parameters
    ----------
    pressed : Contact parts p̃ of the impulses, shape (c, d) [N s].
    velocity : v, shape (c, d) [m/s].
    friction : Coefficients μ, shape (c,).
    rho : ρ of each contact, shape (c,) [kg].
    stiffness : S of cohesion, shape (c, d, d) [kg]; None: there is none.

    References
    ----------
    P. Alart and A. Curnier, "A mixed formulation for frictional contact problems prone to Newton like
    solution methods", Computer Methods in Applied Mechanics and Engineering 92 (1991).
    """
    from masonry_fem.nscd.contact_measures import curnier  # noqa: PLC0415 - Numba is slow to import

    over = rho if stiffness is None else np.ones_like(rho)
    given = (np.ascontiguousarray(part) for part in (pressed, velocity, friction, rho, over))
    residual, by_impulse, by_velocity, is_open, plain = curnier(*given)
    if stiffness is not None:
        by_velocity = (by_velocity + multiplied(by_impulse, stiffness)) / rho[:, None, None]
        is_open &= ~stiffness.any(axis=(1, 2))
    return Linearisation(residual, by_impulse, by_velocity, is_open, plain, rho)


def held_back(line: Linearisation, travelled: FloatArray, share: float) -> Linearisation:
    """The same, with a spring that holds slip back: F_T + κ ρ (v_T − v_T,k) at contacts that slide.

    Parameters
    ----------
    line : Of all contacts.
    travelled : v − v_k, shape (c, d).
    share : κ, the spring's share of a contact's own stiffness.
    """
    at = np.flatnonzero(~line.open & ~line.plain)
    by_velocity, residual = line.by_velocity.copy(), line.residual.copy()
    tangents = np.arange(1, residual.shape[1])
    by_velocity[at[:, None], tangents, tangents] += share
    residual[at, 1:] += share * line.rho[at, None] * travelled[at, 1:]
    return replace(line, by_velocity=by_velocity, residual=residual)


def slipping(
    line: Linearisation,
    chosen: Mask,
    pressed: FloatArray,
    velocity: FloatArray,
    friction: FloatArray,
    stiffness: FloatArray | None = None,
) -> Linearisation:
    """The same, with some contacts taken for closed and slipping, wherever they are.

    They slip against the way x_T = p̃_T − ρ v_T points: v_N = 0 and p̃_T = μ x_N x_T/‖x_T‖.

    Parameters
    ----------
    line : Of all contacts.
    chosen : Contacts that slip, shape (c,).
    pressed, velocity, friction, stiffness : As ``linearise`` takes them.
    """
    trial = pressed[chosen] - line.rho[chosen, None] * velocity[chosen]
    size = graphs.tangential_norm(trial)
    direction = trial[:, 1:] / np.where(size > 0, size, 1.0)[:, None]
    radius = friction[chosen] * trial[:, 0]
    identity = np.eye(pressed.shape[1])
    slope = np.zeros((len(trial), *identity.shape))  # of the projection, by the trial point
    slope[:, 0, 0] = 1.0
    slope[:, 1:, 0] = friction[chosen, None] * direction
    ratio = np.clip(radius / np.where(size > 0, size, 1.0), 0.0, 1.0)
    across = identity[1:, 1:] - direction[:, :, None] * direction[:, None, :]
    slope[:, 1:, 1:] = ratio[:, None, None] * across
    projected = np.concatenate([trial[:, :1], radius[:, None] * direction], axis=1)
    residual, by_impulse = line.residual.copy(), line.by_impulse.copy()
    by_velocity = line.by_velocity.copy()
    residual[chosen], by_impulse[chosen] = pressed[chosen] - projected, identity - slope
    by_velocity[chosen] = slope
    if stiffness is not None:
        by_velocity[chosen] += multiplied(identity - slope, stiffness[chosen]) / line.rho[chosen, None, None]
    return replace(
        line,
        residual=residual,
        by_impulse=by_impulse,
        by_velocity=by_velocity,
        open=line.open & ~chosen,
        plain=line.plain & ~chosen,
    )
