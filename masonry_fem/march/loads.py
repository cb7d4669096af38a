"""Loads: the sum of force patterns times their functions of time, by body group."""

from __future__ import annotations

import numpy as np

from masonry_fem.march.model import FloatArray, Model


def external_forces(model: Model, time: float) -> tuple[FloatArray, ...]:
    """External force on each group, each group's own array (``Loaded`` in ``bodies/base.py``).

    Parameters
    ----------
    model : The structure with its loads.
    time : Time [s]; the load factor in statics.
    """
    last, factors = (
        model.last_forces,
        tuple(
            (load.factor(time), 0.0 if load.travel is None else load.travel.place(time))
            for load in model.loads
        ),
    )
    same = last.loads is model.loads and last.groups is model.groups and last.factors == factors
    if last.forces is not None and same:
        return last.forces
    dimension = model.assembly.dimension
    total = [group.acceleration_force(np.zeros(dimension)) for group in model.groups]
    for load, (factor, _) in zip(model.loads, factors, strict=True):
        for index, pattern in enumerate(load.pattern(model.groups, time)):
            if pattern is not None:
                total[index] = total[index] + factor * pattern
    last.loads, last.groups, last.factors, last.forces = model.loads, model.groups, factors, tuple(total)
    return last.forces


def blend(
    before: tuple[FloatArray, ...], after: tuple[FloatArray, ...], theta: float
) -> tuple[FloatArray, ...]:
    """F_θ = (1−θ) F_i + θ F_{i+1} for each group.

    Parameters
    ----------
    before, after : Forces F_i and F_{i+1} at the start and the end of a step, one array a group.
    theta : Weight θ of the end of the step.
    """
    return tuple(a if a is b else (1 - theta) * a + theta * b for a, b in zip(before, after, strict=True))


def resultant(model: Model, forces: tuple[FloatArray, ...]) -> FloatArray:
    """Force and moment about the origin on the blocks that are free to move, shape (3,) or (6,) [N, N m].

    Parameters
    ----------
    model : The structure.
    forces : External force on each group, each group's own array.
    """
    size = 3 if model.assembly.dimension == 2 else 6
    total = np.zeros(size)
    for group, force in zip(model.groups, forces, strict=True):
        if not group.prescribed:
            total += group.resultant(force).sum(axis=0)
    return total
