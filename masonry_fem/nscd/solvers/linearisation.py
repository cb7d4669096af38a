"""Linearisation: the contact function of a Newton step and its derivatives, contact by contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.products import multiplied

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Linearisation:
    """The contact function at a point, and its derivatives once they are asked for.

    Attributes
    ----------
    residual : F, shape (c, d).
    open : Contacts where F = p, shape (c,); not those with stiffness, where p follows v.
    plain : Contacts whose ``by_velocity`` is the identity, shape (c,).
    rho : ρ, shape (c,).
    derivatives : Makes ``by_impulse`` and ``by_velocity``, in new arrays. Most points are only looked at.
    """

    residual: FloatArray
    open: Mask
    plain: Mask
    rho: FloatArray
    derivatives: Callable[[], tuple[FloatArray, FloatArray]]

    @property
    def by_impulse(self) -> FloatArray:
        """A = ∂F/∂p, shape (c, d, d)."""
        return self._made[0]

    @property
    def by_velocity(self) -> FloatArray:
        """(∂F/∂v + A S) / ρ with the stiffness S of cohesion, shape (c, d, d)."""
        return self._made[1]

    @cached_property
    def _made(self) -> tuple[FloatArray, FloatArray]:
        return self.derivatives()


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
        open=np.zeros(c, dtype=bool),
        plain=np.ones(c, dtype=bool),
        rho=rho,
        derivatives=lambda: (np.zeros((c, d, d)), np.tile(np.eye(d), (c, 1, 1))),
    )


def parted_contacts(bonded: Linearisation, impulse: FloatArray, apart: Mask) -> Linearisation:
    """The same, but some contacts are open: F = p.

    Parameters
    ----------
    bonded : With all contacts closed.
    impulse : p, shape (c, d) [N s].
    apart : Contacts that are open, shape (c,).
    """

    def derivatives() -> tuple[FloatArray, FloatArray]:
        identity = np.eye(impulse.shape[1])
        free = np.where(apart[:, None, None], identity, 0.0)
        return free, identity - free

    residual = np.where(apart[:, None], impulse, bonded.residual)
    return replace(bonded, residual=residual, open=apart, plain=~apart, derivatives=derivatives)


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
    from masonry_fem.nscd.contact_measures import (  # noqa: PLC0415 - Numba is slow to import
        curnier,
        curnier_derivatives,
    )

    given = [np.ascontiguousarray(part) for part in (pressed, velocity, friction, rho)]
    residual, is_open, plain = curnier(*given)
    if stiffness is not None:
        is_open &= ~stiffness.any(axis=(1, 2))

    def derivatives() -> tuple[FloatArray, FloatArray]:
        by_impulse, by_velocity = curnier_derivatives(*given, rho if stiffness is None else np.ones_like(rho))
        if stiffness is not None:
            by_velocity = (by_velocity + multiplied(by_impulse, stiffness)) / rho[:, None, None]
        return by_impulse, by_velocity

    return Linearisation(residual, is_open, plain, rho, derivatives)


def held_back(line: Linearisation, travelled: FloatArray, share: float) -> Linearisation:
    """The same, with a spring that holds slip back: F_T + κ ρ (v_T − v_T,k) at contacts that slide.

    Parameters
    ----------
    line : Of all contacts.
    travelled : v − v_k, shape (c, d).
    share : κ, the spring's share of a contact's own stiffness.
    """
    at, residual = np.flatnonzero(~line.open & ~line.plain), line.residual.copy()
    residual[at, 1:] += share * line.rho[at, None] * travelled[at, 1:]

    def derivatives() -> tuple[FloatArray, FloatArray]:
        by_impulse, by_velocity = line.derivatives()
        tangents = np.arange(1, residual.shape[1])
        by_velocity[at[:, None], tangents, tangents] += share
        return by_impulse, by_velocity

    return replace(line, residual=residual, derivatives=derivatives)


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
    residual = line.residual.copy()
    residual[chosen] = pressed[chosen] - projected

    def derivatives() -> tuple[FloatArray, FloatArray]:
        by_impulse, by_velocity = line.derivatives()
        by_impulse[chosen], by_velocity[chosen] = identity - slope, slope
        if stiffness is not None:
            bonds = multiplied(identity - slope, stiffness[chosen])
            by_velocity[chosen] += bonds / line.rho[chosen, None, None]
        return by_impulse, by_velocity

    still_open, still_plain = line.open & ~chosen, line.plain & ~chosen
    return replace(line, residual=residual, open=still_open, plain=still_plain, derivatives=derivatives)
