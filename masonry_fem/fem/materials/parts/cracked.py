"""Cracked: principal stresses of stone whose compliance is damaged across the axes of tension.

stiff = cracked(elastic, opened, pulled=1)          # ω = ``opened`` across the first axis
sliding(stiff, n, m)                                # and with planes that slip
crossing(before, after)                             # how many cracks grow in a step
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from masonry_fem.fem.material_law import BoolArray, FloatArray, Isotropic

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Held:
    """Stresses of q points whose damage stays as it is.

    Attributes
    ----------
    stress, flow : Principal stresses and plastic strains of the step, shapes (q, 3) [Pa].
    moduli : Derivatives of stresses by principal strains, shape (q, 3, 3) [Pa].
    outside : How far from sound they are, relative to the stress, shape (q,).
    end : Which of the law's ends it is, shape (q,).
    """

    stress: FloatArray
    flow: FloatArray
    moduli: FloatArray
    outside: FloatArray
    end: IntArray

    @classmethod
    def none(cls, count: int) -> Held:
        """Nothing found yet."""
        flat = np.zeros((count, 3))
        return cls(
            flat, flat, np.zeros((count, 3, 3)), np.full(count, np.inf), np.zeros(count, dtype=np.int64)
        )

    def of(self, points: IntArray | BoolArray) -> Held:
        """Those of some points."""
        return Held(*(getattr(self, one.name)[points] for one in fields(self)))

    def replaced(self, points: IntArray | BoolArray, new: Held) -> Held:
        """With some points from elsewhere."""
        made = {one.name: getattr(self, one.name).copy() for one in fields(self)}
        for name, values in made.items():
            values[points] = getattr(new, name)
        return Held(**made)


def cracked(elastic: Isotropic, opened: FloatArray, pulled: int) -> FloatArray:
    """Principal stresses by strains of cracked stone, shape (q, 3, 3) [Pa].

    The inverse of [diag(1 + ν + ω_i) − ν]/E by Sherman and Morrison, which keeps its digits for any ω.

    Parameters
    ----------
    elastic : Of the intact material.
    opened : Damage ω, shape (q,). pulled : How many axes are in tension: cracks are across these, the first.
    """
    poisson = elastic.poisson
    share = 1 / (1 + poisson + opened[:, None] * (np.arange(3) < pulled))
    together = poisson / (1 - poisson * share.sum(axis=1))
    stiff: FloatArray = together[:, None, None] * share[:, :, None] * share[:, None, :]
    stiff[:, [0, 1, 2], [0, 1, 2]] += share
    return elastic.young * stiff


def crossing(before: FloatArray, after: FloatArray) -> FloatArray:
    """How many cracks grow in a step, one for each axis of tension, Σ⟨σ_i⟩²/σ1², shape (q,).

    The mean of its start and its end, each weighted by σ1, so that what cracks take is of second order in
    the step: beside the tip of a crack stresses turn from tension along two axes to tension along one.

    Parameters
    ----------
    before, after : Principal stresses at the start and the end of the step, shapes (q, 3) [Pa].
    """
    pulled = np.maximum(np.stack([before, after]), 0.0)
    first = pulled[:, :, 0]
    weighted = (pulled**2).sum(axis=2) / np.where(first > 0, first, 1.0)
    mean: FloatArray = weighted.sum(axis=0) / np.maximum(first.sum(axis=0), np.finfo(float).tiny)
    return mean


def softening(elastic: Isotropic, stiff: FloatArray, stress: FloatArray, growth: FloatArray) -> FloatArray:
    """Derivatives of principal stresses by strains as ω grows, shape (q, 3, 3) [Pa].

    Parameters
    ----------
    elastic : Of the intact material.
    stiff : The same while ω stays, shape (q, 3, 3) [Pa]. stress : Principal stresses, shape (q, 3) [Pa].
    growth : dω/dσ1, shape (q,) [1/Pa].
    """
    by_first = growth[:, None] * np.maximum(stress, 0.0) / elastic.young
    taken = np.matmul(stiff, by_first[:, :, None])
    softer: FloatArray = stiff - taken @ stiff[:, :1] / (1 + taken[:, :1])
    return softer


def sliding(stiff: FloatArray, n: FloatArray, m: FloatArray) -> FloatArray:
    """Principal stresses by strains where r planes slip, shape (q, 3, 3) [Pa].

    Parameters
    ----------
    stiff : The same without slip, shape (q, 3, 3) [Pa].
    n, m : Normals of the planes, and directions of their flow, each of shape (r, 3).
    """
    if not len(n):
        return stiff
    sliding: FloatArray = stiff - stiff @ m.T @ np.linalg.inv(n @ stiff @ m.T) @ n @ stiff
    return sliding
