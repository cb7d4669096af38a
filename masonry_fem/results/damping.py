"""Damping: what takes energy out of a march in time, besides sliding, yielding and fracture."""

from __future__ import annotations

from masonry_fem.build import Built
from masonry_fem.fidelities import deforms
from masonry_fem.march.march import March
from masonry_fem.records.told import Told
from masonry_fem.scene import specs


class RayleighTold(Told, frozen=True, kw_only=True):
    """Rayleigh damping C = α M + β K of the stones of a material.

    Attributes
    ----------
    mass : α [1/s].
    stiffness : β [s]; alone the viscosity of Kelvin and Voigt's solid. 0 if these stones are rigid.
    """

    mass: float
    stiffness: float


class DampingTold(Told, frozen=True, kw_only=True):
    """Damping that acts in a march in time; ``energy`` tells how much it took.

    Attributes
    ----------
    theta : θ of the scheme, which takes energy where it is greater than 0.5.
    velocity_factor : What velocities are multiplied by after each step; 1 leaves them.
    rayleigh : By name of the material; empty where there is none.
    restitution : Least and greatest normal coefficient of the contacts that have impacts; None: none has.
    """

    theta: float
    velocity_factor: float
    rayleigh: dict[str, RayleighTold]
    restitution: tuple[float, float] | None = None


def damping_told(scene: specs.Scene, built: Built, made: March) -> DampingTold | None:
    """What ``summary.json`` says of damping; None in statics, which has no rates.

    Parameters
    ----------
    scene : What was run. built : The model made of it. made : How its march ended.
    """
    if not scene.analysis.inertia:
        return None
    laws, stones = made.model.laws, built.stones
    hits = laws.restitution[laws.in_velocities, 0]
    pairs = set(zip(stones.material, stones.fidelity, strict=True))
    used = sorted({(name, deforms(own)) for name, own in pairs if own is not None})
    # of a material with rigid stones and others the latter come last, and count
    found = {
        name: RayleighTold(mass=own.mass, stiffness=own.stiffness if soft else 0.0)
        for name, soft in used
        for own in [scene.materials[name].damping]
    }
    return DampingTold(
        theta=made.last.scheme.theta,
        velocity_factor=scene.analysis.kept,
        rayleigh={name: one for name, one in found.items() if one.mass or one.stiffness},
        restitution=(float(hits.min()), float(hits.max())) if len(hits) else None,
    )
