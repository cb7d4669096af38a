"""Assignment: which law each contact point of a model has. It acts as one law on all of them.

joints = Assignment(((bed_joint, beds), (Dry(0.6), others)))
state = joints.initial(count, dimension)
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from typing import ClassVar, override

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import LawError, MasonryError
from masonry_fem.joints.law import Law, layers_of
from masonry_fem.joints.parameters import FloatArray
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState, Mask

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Assignment(Law):
    """Laws and the contact points that have them.

    Attributes
    ----------
    parts : Pairs of a law and its contact points; each point belongs to exactly one. Parameters that
        scatter are given for the part's points in their order.
    restitution : Newton's coefficients of each contact, normal and tangential, shape (c, 2).
    in_velocities : Contacts that are written in velocities (impacts), not in gaps, shape (c,).
    """

    parts: tuple[tuple[Law, IntArray], ...]
    restitution: FloatArray = field(init=False, repr=False)
    in_velocities: Mask = field(init=False, repr=False)
    # the law of all contacts in their order, where there is but one: it needs no arrays of parts
    _alone: Law | None = field(init=False, repr=False)

    name: ClassVar[str] = "assignment"

    def __post_init__(self) -> None:
        points = [np.asarray(contacts) for _, contacts in self.parts]
        numbers = np.concatenate(points) if points else np.zeros(0, dtype=np.int64)
        found, times = np.unique(numbers, return_counts=True)
        if (times > 1).any():
            raise LawError(f"contact {found[times > 1][0]} has {times.max()} laws, expected one")
        if (found != np.arange(len(found))).any():
            missing = int(np.flatnonzero(found != np.arange(len(found)))[0])
            raise LawError(f"contact {missing} has no law; assign one, or Dry")
        restitution, in_velocities = np.zeros((len(numbers), 2)), np.zeros(len(numbers), dtype=bool)
        for law, contacts in self.parts:
            for layer in layers_of(law):
                if (rebound := layer.rebound(len(contacts))) is not None:
                    restitution[contacts], in_velocities[contacts] = rebound, True
        object.__setattr__(self, "restitution", restitution)
        object.__setattr__(self, "in_velocities", in_velocities)
        alone = len(self.parts) == 1 and bool((points[0] == np.arange(len(numbers))).all())
        object.__setattr__(self, "_alone", self.parts[0][0] if alone else None)

    @classmethod
    def of(cls, law: Law, count: int) -> Assignment:
        """The same law at all of ``count`` contact points."""
        return cls(((law, np.arange(count)),))

    @property
    def all_plain(self) -> bool:
        """Whether all layers of all laws are plain: contact with friction, and nothing that it remembers."""
        return all(layer.plain for law, _ in self.parts for layer in layers_of(law))

    @property
    def count(self) -> int:
        """Number of contact points c."""
        return len(self.in_velocities)

    @override
    def initial(self, count: int, dimension: int) -> JointState:
        if count != self.count:
            raise LawError(f"laws are assigned to {self.count} contacts, the model has {count}; assign all")
        fresh = [(law.initial(len(contacts), dimension), contacts) for law, contacts in self.parts]
        state = JointState.intact(count, dimension, max((part.own.shape[1] for part, _ in fresh), default=0))
        for part, contacts in fresh:
            state = state.put(contacts, part)
        return state

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        if (alone := self._alone) is not None:
            with _blamed(alone, "reduce"):
                return alone.reduce(state, jump, area, step)
        total = Reduction.dry(np.zeros(state.count), state.dimension)
        for law, contacts in self.parts:
            with _blamed(law, "reduce"):
                part = law.reduce(state.take(contacts), jump[contacts], area[contacts], step)
            for one in fields(Reduction):
                getattr(total, one.name)[contacts] = getattr(part, one.name)
        return total

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        if (alone := self._alone) is not None:
            with _blamed(alone, "update"):
                return alone.update(state, trial, jump, reaction, velocity, area, step)
        after = JointState(**{name: values.copy() for name, values in state.arrays().items()})
        for law, contacts in self.parts:
            with _blamed(law, "update"):
                part = law.update(
                    state.take(contacts), trial.take(contacts), jump[contacts], reaction[contacts],
                    velocity[contacts], area[contacts], step,
                )  # fmt: skip
            for name, values in part.arrays().items():
                getattr(after, name)[contacts] = values
        return after

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self._gather(np.zeros(state.jump.shape), state, area, "adhesive_reaction")

    @override
    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self._gather(np.zeros(state.jump.shape), state, area, "spring_reaction")

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        return self._gather(np.zeros(state.count), state, area, "stored")

    def _gather(self, total: FloatArray, state: JointState, area: FloatArray, method: str) -> FloatArray:
        if (alone := self._alone) is not None:
            with _blamed(alone, method):
                total[...] = getattr(alone, method)(state, area)
            return total
        for law, contacts in self.parts:
            with _blamed(law, method):
                total[contacts] = getattr(law, method)(state.take(contacts), area[contacts])
        return total


@contextmanager
def _blamed(law: Law, method: str) -> Iterator[None]:
    """What goes wrong in a law from outside this package is told as its own."""
    try:
        yield
    except MasonryError:
        raise
    except Exception as error:
        foreign = next((one for one in layers_of(law) if _foreign(one)), None)
        if foreign is None:
            raise
        raise LawError(
            f"joint law '{type(foreign).__name__}': {method} failed with {type(error).__name__}: "
            f"{error}; correct it (masonry_fem.joints.probe drives one point, --debug shows where)"
        ) from error


def _foreign(law: Law) -> bool:
    return not type(law).__module__.startswith("masonry_fem.")
