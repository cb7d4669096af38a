"""Law: the behaviour of a joint, one contact point at a time, by the change of variable r̃ = r + r_adh.

A law is its parameters, in units per area; its memory is a ``JointState``. Within a step of length h
the solver and the law take turns until the trial state stays:

    trial = committed
    repeat:
        reduction = law.reduce(trial, jump, area, h)          # affine r_adh, friction
        ... solve the contact problem: r̃, v, then r = r̃ − r_adh ...
        trial = law.update(committed, trial, jump, r, v, area, h)
    committed = trial.committed()

``jump`` is the displacement jump at the start, ũ_i = u_i + h(1 − θ) v_i, since bonding.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self, override

import numpy as np
from numpy.typing import NDArray

from masonry_fem.joints.parameters import FloatArray, Parameter, check_ranges
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.nscd.graphs import lengths

if TYPE_CHECKING:
    from scipy import sparse

# a sliding contact's ‖r̃_T‖ falls short of μ r̃_N by the solver's tolerance
ON_CONE = 1e-6
ROUNDING = 1e-9  # of two reactions whose difference would be a pressure


@dataclass(frozen=True, slots=True)
class Place:
    """The joint that a law is made for.

    Attributes
    ----------
    key : Key of the law in the scene, for messages.
    laplacian : Makes the matrix of −Δ over the joint's contact points, shape (c, c) [1/m²].
    """

    key: str
    laplacian: Callable[[], sparse.csr_array]


class Pull(Protocol):
    """What a law of ties offers: it bears tension between two points, not contact of faces. k ties.

    Attributes
    ----------
    length : Length without force, shape (k,) [m].
    strength : Stress at which it begins to yield, shape (k,) [Pa].
    """

    @property
    def length(self) -> FloatArray: ...  # noqa: D102
    @property
    def strength(self) -> FloatArray: ...  # noqa: D102

    def force(self, state: JointState, area: FloatArray) -> FloatArray:
        """What it bears in a state, shape (k,) [N].

        Parameters
        ----------
        state : Of the k ties. area : Their sections, shape (k,) [m²].
        """
        ...

    def capacity(self, state: JointState, area: FloatArray) -> FloatArray:
        """The force at which it yields further, shape (k,) [N].

        Parameters
        ----------
        state : Of the k ties. area : Their sections, shape (k,) [m²].
        """
        ...

    def snapped(self, state: JointState) -> NDArray[np.bool_]:
        """Which of the ties have snapped, shape (k,)."""
        ...


class Law(ABC):
    """Base class of joint laws, whose fields are the parameters of the law.

    It relates the force at a contact point to the *jump*, the displacement of the candidate relative to the
    antagonist since the faces were bonded. Vectors are in the local frames, component 0 normal; c is the
    number of contact points, d = 2 or 3. The *physical* reaction is r = r̃ − r_adh: the contact solver gives
    r̃, which obeys contact and Coulomb friction, the law the cohesive reaction r_adh. Reactions are positive
    in compression.
    """

    __slots__ = ()

    name: ClassVar[str]
    memory: ClassVar[int] = 0  # numbers a contact that the law keeps in ``JointState.own``
    plain: ClassVar[bool] = False  # of this layer: adds nothing to contact with friction
    cone: ClassVar[bool] = False  # friction shapes what it holds intact: 'no slip' has no meaning
    softens: ClassVar[bool] = False  # its cohesion gets lost: no path of loads follows that

    def __post_init__(self) -> None:
        """Refuse parameters out of their range."""
        check_ranges(self)

    @property
    def pull(self) -> Pull | None:
        """The law as one of ties; None: it is a law of faces."""
        return None

    @classmethod
    def made(cls, told: Mapping[str, Any], drawn: Mapping[str, Any], place: Place) -> Self:
        """The law of a joint.

        Parameters
        ----------
        told : Parameters as the scene gives them.
        drawn : The same, with an array where a parameter scatters from joint to joint.
        place : The joint.
        """
        return cls(**drawn)

    def initial(self, count: int, dimension: int) -> JointState:
        """State of ``count`` contact points of new joints in ``dimension`` dimensions."""
        return JointState.intact(count, dimension, self.memory)

    def rebound(self, count: int) -> FloatArray | None:
        """Newton's coefficients of restitution, normal and tangential, shape (count, 2).

        Contact is then an impact law in velocities. None: contact is a condition on gaps, without rebound.
        """
        return None

    @abstractmethod
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        """The law linearised for the contact solver, with the adhesion of ``state``.

        Parameters
        ----------
        state : Trial state.
        jump : Jump at the start of the step [m], shape (c, d).
        area : Tributary areas [m²], shape (c,).
        step : Length h of the step [s].
        """

    @abstractmethod
    def update(
        self,
        state: JointState,
        trial: JointState,
        jump: FloatArray,
        reaction: FloatArray,
        velocity: FloatArray,
        area: FloatArray,
        step: float,
    ) -> JointState:
        """Next trial state at the end of a step.

        Parameters
        ----------
        state : Committed state, at the start of the step.
        trial : The state with which the contact was solved; what broke in it stays broken.
        jump : Jump at the start of the step [m], shape (c, d).
        reaction : Physical reaction r = r̃ − r_adh [N], shape (c, d).
        velocity : Relative velocity at the end, without gap term [m/s], shape (c, d).
        area : Tributary areas [m²], shape (c,).
        step : Length h of the step [s].
        """

    @abstractmethod
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        """Cohesive reaction r_adh at the jump that ``state`` holds [N], shape (c, d)."""

    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        """The part of r_adh that grows with the jump [N], shape (c, d); of rigid laws there is none."""
        return self.adhesive_reaction(state, area)

    def work_at_start(self, before: JointState, after: JointState, area: FloatArray) -> FloatArray:
        """Work, on what this layer alone gives way in a step, of what it bears before, shape (c,) [J].

        Its deformation tells what it bears, as its stiffness may be another than in the step before.

        Parameters
        ----------
        before, after : States at both ends of the step. area : Tributary areas [m²], shape (c,).
        """
        return np.zeros(before.count)

    @abstractmethod
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        """Elastic energy stored in the joint [J], shape (c,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Layer(Law):
    """What lies on another law, on which it falls back, such as a bed or the roughness of faces.

    Attributes
    ----------
    law : What holds the faces together.
    """

    law: Law

    @override
    def initial(self, count: int, dimension: int) -> JointState:
        return self.law.initial(count, dimension)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.adhesive_reaction(state, area)

    @override
    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.spring_reaction(state, area)

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.stored(state, area)


def rub(
    law: Law,
    before: JointState,
    after: JointState,
    friction: FloatArray,
    reaction: FloatArray,
    velocity: FloatArray,
    area: FloatArray,
    step: float,
    **changed: Any,
) -> JointState:
    """``after`` with what friction did in the step: whether points slide, how far, and the heat.

    Parameters
    ----------
    law : The law of the c contact points.
    before, after : Their states at the start and the end of the step.
    friction : Coefficient in force during the step, shape (c,).
    reaction : Force r on the candidates, local frame, shape (c, d) [N].
    velocity : Relative velocity v, local frame, shape (c, d) [m/s].
    area : Of the points, shape (c,) [m²; m in 2D].
    step : Length of the step [s].
    changed : What else changes, on which cohesion does not depend.
    """
    adhesive = law.adhesive_reaction(after, area)
    pushed = reaction + adhesive
    speed = lengths(velocity[:, 1:])
    limit = friction * pressure(reaction, adhesive)
    tangent = lengths(pushed[:, 1:])
    slides = (speed > 0) & (limit > 0) & (tangent >= limit * (1 - ON_CONE))
    heat = -step * np.einsum("ci,ci->c", pushed[:, 1:], velocity[:, 1:])
    return replace(
        after,
        slides=slides,
        slip=before.slip + np.where(slides, step * speed, 0.0),
        rubbed=before.rubbed + np.maximum(heat, 0.0),
        **changed,
    )


def pressure(reaction: FloatArray, adhesive: FloatArray) -> FloatArray:
    """Normal force r̃_N ≥ 0 between the faces, shape (c,) [N].

    Parameters
    ----------
    reaction : Force r on the candidates, local frame, shape (c, d) [N].
    adhesive : Cohesive force r_adh of r̃ = r + r_adh, shape (c, d) [N].
    """
    pushed = reaction[:, 0] + adhesive[:, 0]
    # of an open joint whose springs pull the two differ by rounding: that is no pressure to slide under
    noise = ROUNDING * (np.abs(reaction[:, 0]) + np.abs(adhesive[:, 0]))
    return np.where(pushed > noise, pushed, 0.0)


def layers_of(law: Law) -> Iterator[Law]:
    """A law and those inside it, such as a bed, the roughness on it and the cohesion of its faces."""
    yield law
    inner = getattr(law, "law", None)
    if isinstance(inner, Law):
        yield from layers_of(inner)


def spread(value: Parameter, count: int) -> FloatArray:
    """A parameter as one number a contact point, shape (c,).

    Parameters
    ----------
    value : One number for all points, or an array, shape (c,).
    count : Number c of contact points.
    """
    numbers = np.empty(count)
    numbers[:] = value
    return numbers
