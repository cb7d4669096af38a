"""Loads: the sum of force patterns times their functions of time, by body group."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.march.model import FloatArray, Model


def external_forces(
    model: Model, time: float, bodies: tuple[Any, ...] | None = None
) -> tuple[FloatArray, ...]:
    """External force on each group, each group's own array (``Loaded`` in ``bodies/base.py``).

    Parameters
    ----------
    model : The structure with its loads.
    time : Time [s]; the load factor in statics.
    bodies : States of the groups, with which some loads turn; None: as in the reference.
    """
    return followed(model, dead_forces(model, time), following_forces(model, time), bodies)


def dead_forces(model: Model, time: float) -> tuple[FloatArray, ...]:
    """What loads that keep their directions give to each group.

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
        if load.follows:
            continue
        for index, pattern in enumerate(load.pattern(model.groups, time)):
            if pattern is not None:
                total[index] = total[index] + factor * pattern
    last.loads, last.groups, last.factors, last.forces = model.loads, model.groups, factors, tuple(total)
    return last.forces


def following_forces(model: Model, time: float) -> tuple[FloatArray | None, ...]:
    """What loads that turn with blocks give to each group in the reference, None where there are none.

    Parameters
    ----------
    model : The structure with its loads.
    time : Time [s]; the load factor in statics.
    """
    total: list[FloatArray | None] = [None] * len(model.groups)
    for load in model.loads:
        if load.follows:
            for index, pattern in enumerate(load.forces):
                if pattern is not None:
                    before = total[index]
                    force = load.factor(time) * pattern
                    total[index] = force if before is None else before + force
    return tuple(total)


def followed(
    model: Model,
    dead: tuple[FloatArray, ...],
    following: tuple[FloatArray | None, ...],
    bodies: tuple[Any, ...] | None,
) -> tuple[FloatArray, ...]:
    """Forces of both kinds on each group.

    Parameters
    ----------
    model : The structure.
    dead : Forces that keep their directions. following : Forces in the reference that turn with blocks.
    bodies : States of the groups; None: as in the reference.
    """
    if all(force is None for force in following):
        return dead
    states = (None,) * len(dead) if bodies is None else bodies
    return tuple(
        own if force is None else own + (force if state is None else group.following(force, state))
        for group, own, force, state in zip(model.groups, dead, following, states, strict=True)
    )


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


def blend_following(
    before: tuple[FloatArray | None, ...], after: tuple[FloatArray | None, ...], theta: float
) -> tuple[FloatArray | None, ...]:
    """The same of forces that turn with blocks, which act on the same groups at both times.

    Parameters
    ----------
    before, after : Forces in the reference at the start and the end of a step, None where there are none.
    theta : Weight θ of the end of the step.
    """
    return tuple(
        None if a is None or b is None else (1 - theta) * a + theta * b
        for a, b in zip(before, after, strict=True)
    )


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
