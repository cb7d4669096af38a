"""Inelastic blocks: elastic ones that yield, by a material law at each Gauss point.

    (stones,) = elastic_groups(assembly, materials, made=InelasticGroup)      # of materials with a law
    made = stones.advance(state, stones.free(state, None, force, scheme), rigid, nodal, scheme)
    made = stones.advance(state, stones.free(state, made, force, scheme), rigid, nodal, scheme)   # and so on

A step is Newton-Raphson on the blocks. The first round is elastic from the start of the step on. Each further
one is linearised at the end that the round before came to, its guess, whose stresses σ(q⁺) and tangents are
those of the law in a step from the committed state:

    u_el⁺ = u_el,guess + (M̂_t⁻¹)_el [Gᵀ p − ℛ(u_guess)],       M̂_t = M̂ + h²θ² (K_t − K)

Rigid motions strain nothing, so that they are as of elastic blocks. Only blocks that yield in the guess have
factors of their own (``tangent``); the others share the elastic one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, override

import numpy as np

from masonry_fem.bodies.base import (
    FloatArray,
    Free,
    IntArray,
    Scheme,
    Sides,
    StepEnergy,
    StressError,
    StressField,
)
from masonry_fem.errors import LawError, SceneError
from masonry_fem.fem.attachment import SmallAttachment
from masonry_fem.fem.balance import dot
from masonry_fem.fem.condense import coefficients
from masonry_fem.fem.deformable import Deformable
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.material_law import Isotropic, MaterialLaw
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.strains import Strains
from masonry_fem.fem.tangent import TangentCompliance


@dataclass(frozen=True, slots=True)
class InelasticState(ElasticState):
    """How b inelastic blocks have moved and move, and what their material remembers: m cells of p points.

    Attributes
    ----------
    internal : Internal variables of the law, k a point, shape (b, m, p, k).
    stress : Shape axes, shape (b, m, p, 6) [Pa].
    stored : Energy that the blocks can give back, shape (b,) [J].
    dissipated, excess : Of the step that led here: what was lost, and what stresses of its end work more
        than they would have on the way (``Response``), shape (b,) [J].
    yielding : Blocks of which some point yields in that step, shape (y,).
    moduli : Their tangents, shape (y, m, p, 6, 6) [Pa].
    """

    internal: FloatArray
    stress: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    excess: FloatArray
    yielding: IntArray
    moduli: FloatArray


@dataclass(slots=True)
class _Linearised:
    """Factors of the blocks that yield in a guess, for a scheme."""

    guess: InelasticState
    key: tuple[float, float]
    factors: dict[int, TangentCompliance]


class InelasticGroup(ElasticGroup):
    """All blocks of one mesh, material with a law, and clamping."""

    kind = "inelastic"
    nonlinear = True

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        material = self.operators.material
        assert material.law is not None  # the fidelity sees to it
        self.law: MaterialLaw = material.law
        self._elastic = Isotropic.of(material.young, material.poisson)
        self._last: _Linearised | None = None
        try:
            self.law.refuse(self._elastic, self.strains.band.ravel())
        except LawError as error:
            raise SceneError(f"block '{self.names[0]}': {error}") from error

    @property
    def material_name(self) -> str:
        """The law by which they yield, for reports."""
        return self.law.name

    @cached_property
    def strains(self) -> Strains:
        """Gradients of the mesh."""
        return Strains.of(self.mesh)

    @override
    def share(self, other: Deformable[Any]) -> None:
        super().share(other)
        if other.mesh is self.mesh and "strains" in other.__dict__:
            self.__dict__["strains"] = other.__dict__["strains"]

    @override
    def attach(self, sides: Sides) -> InelasticAttachment:
        """The blocks seen through contact sides."""
        return InelasticAttachment.of(self, sides)

    def factors(self, guess: InelasticState | None, scheme: Scheme) -> dict[int, TangentCompliance]:
        """Those of the blocks that yield in ``guess``; {} where it is None, or none does.

        Parameters
        ----------
        guess : What the blocks are linearised at; None: they are elastic from the start of the step on.
        scheme : Coefficients of the step.
        """
        if guess is None or not len(guess.yielding):
            return {}
        key, last = coefficients(self.operators, scheme), self._last
        if last is None or last.guess is not guess or last.key != key:
            made = {}
            for body, moduli in zip(guess.yielding.tolist(), guess.moduli, strict=True):
                tangent = self.strains.stiffness(moduli)
                made[body] = TangentCompliance(self.operators, tangent, self.modes, self.holds.free, scheme)
            self.factorisations += len(made)
            last = self._last = _Linearised(guess, key, made)
        return last.factors

    # --- states -----------------------------------------------------------------------------------

    @override
    def rest(self) -> InelasticState:
        """Undeformed, in place, at rest, of fresh material; clamps that move have their first velocity."""
        own = super().rest()
        (m, p), b = self.strains.weight.shape, self.count
        internal = self.law.initial(b * m * p).reshape(b, m, p, -1)
        none = np.zeros(b)
        return InelasticState(
            own.time, own.rigid_displacement, own.displacement, own.rigid_velocity, own.velocity, internal,
            np.zeros((b, m, p, 6)), none, none, none, np.zeros(0, dtype=np.int64), np.zeros((0, m, p, 6, 6)),
        )  # fmt: skip

    # --- the step ---------------------------------------------------------------------------------

    @override
    def free(
        self, state: ElasticState, guess: ElasticState | None, force: FloatArray, scheme: Scheme
    ) -> Free:
        """The step without contact impulses, linearised at ``guess``; None or ``state``: elastic."""
        assert isinstance(state, InelasticState)
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        operators, material, held = self.operators, self.operators.material, self.holds.dofs
        alpha, beta = material.mass_damping, material.stiffness_damping
        start = state.velocity if inertia else np.zeros_like(state.velocity)
        c_m, c_k = coefficients(operators, scheme)
        before = state.displacement[:, held], start[:, held]
        change = self.clamping.velocity(state.time, *before, scheme) - start[:, held]
        if guess is None or guess is state:
            guess = None
            right = h * (force - self.strains.forces(state.stress))
            right -= h * (h * theta + inertia * beta) * (start @ operators.stiffness)
            if inertia and alpha:
                right -= inertia * h * alpha * (start @ operators.mass)
            if change.any():
                lifted = np.zeros_like(start)
                lifted[:, held] = change
                right -= c_m * (lifted @ operators.mass) + c_k * (lifted @ operators.stiffness)
            elastic = start + self.factor(scheme).apply(right)
        else:
            assert isinstance(guess, InelasticState)
            left = self._residual(state, guess, force, scheme)
            elastic = guess.velocity - self._compliant(left, guess, scheme)
        elastic[:, held] = start[:, held] + change
        momentum = state.rigid_velocity + start[:, held] @ self._pull
        impulse = (
            h * (force @ self.modes.modes) - inertia * h * alpha * momentum - c_m * (change @ self._pull)
        )
        mass = np.full_like(state.rigid_velocity, c_m)
        mass[:, self.modes.count :] = 1.0  # modes that clamps forbid are placeholders that stay at rest
        return Free(state.rigid_velocity, impulse, mass, elastic, guess=guess)

    def _compliant(self, nodal: FloatArray, guess: InelasticState | None, scheme: Scheme) -> FloatArray:
        """(M̂_t⁻¹)_el of nodal impulses (b, n) [N s], shape (b, n) [m/s]."""
        answer = self.factor(scheme).apply(nodal)
        for body, factor in self.factors(guess, scheme).items():
            answer[body] = factor.apply(nodal[body : body + 1])[0]
        return answer

    @override
    def advance(
        self,
        state: ElasticState,
        free: Free,
        rigid_velocity: FloatArray,
        nodal: FloatArray | None,
        scheme: Scheme,
    ) -> InelasticState:
        """The state at the end of the step, its material by the law from the state at the start on."""
        assert isinstance(state, InelasticState)
        assert free.elastic is not None
        velocity = free.elastic
        if nodal is not None:
            velocity = velocity + self._compliant(nodal, free.guess, scheme)
        return self._reached(state, rigid_velocity, velocity, scheme)

    def between(
        self, state: InelasticState, start: InelasticState, end: InelasticState, share: float, scheme: Scheme
    ) -> InelasticState:
        """The state at the end of a step from ``state`` with velocities between those of two others.

        Parameters
        ----------
        state : Where the step begins. start, end : Two guesses of where it ends.
        share : Of the way from the first to the second. scheme : Coefficients of the step.
        """
        rigid = start.rigid_velocity + share * (end.rigid_velocity - start.rigid_velocity)
        return self._reached(state, rigid, start.velocity + share * (end.velocity - start.velocity), scheme)

    def _reached(
        self, state: InelasticState, rigid_velocity: FloatArray, velocity: FloatArray, scheme: Scheme
    ) -> InelasticState:
        """The state at the end of a step, its velocities given."""
        h, theta = scheme.step, scheme.theta
        displacement = state.displacement + h * ((1 - theta) * state.velocity + theta * velocity)
        b, (m, p) = self.count, self.strains.weight.shape
        start, end = (
            self.strains.at_points(field).reshape(-1, 6) for field in (state.displacement, displacement)
        )
        committed = state.internal.reshape(b * m * p, -1)
        made = self.law.update(self._elastic, start, end, committed, np.tile(self.strains.band.ravel(), b))

        def summed(density: FloatArray) -> FloatArray:
            return self.strains.integral(density.reshape(b, m, p))

        yielding = np.flatnonzero(made.changed.reshape(b, -1).any(axis=1))
        return InelasticState(
            state.time + h,
            state.rigid_displacement + h * ((1 - theta) * state.rigid_velocity + theta * rigid_velocity),
            displacement,
            rigid_velocity,
            velocity,
            made.internal.reshape(b, m, p, -1),
            made.stress.reshape(b, m, p, 6),
            summed(made.stored),
            summed(made.dissipation),
            summed(made.excess),
            yielding,
            made.tangent.reshape(b, m, p, 6, 6)[yielding],
        )

    # --- measures of the step -----------------------------------------------------------------------

    def _residual(
        self, state: InelasticState, after: InelasticState, force: FloatArray, scheme: Scheme
    ) -> FloatArray:
        """M (u⁺ − u) + h C u_θ + h ∫Bᵀσ_θ − h F_θ of all nodes, shape (b, n) [N s]."""
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        total = h * (self.strains.forces((1 - theta) * state.stress + theta * after.stress) - force)
        if inertia:
            total += self.balance.inertia(state, after, scheme)
            total += h * self.balance.viscous(state, after, scheme)
        return total

    @override
    def nodal_residual(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """M (u⁺ − u) + h C u_θ + h ∫Bᵀσ_θ − h F_θ − Gᵀ p of all nodes, shape (b, n) [N s]."""
        assert isinstance(state, InelasticState)
        assert isinstance(after, InelasticState)
        residual = self._residual(state, after, force, scheme)
        return residual if nodal is None else residual - nodal

    @override
    def imbalance(
        self, state: ElasticState, guess: ElasticState, after: ElasticState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step, rigid and nodal [N s], shape (b,)."""
        whole = self.nodal_residual(state, after, force, None, scheme)
        return self.balance.imbalance(whole, impulse, nodal)

    def effort(self, after: InelasticState, scheme: Scheme) -> FloatArray:
        """Size of the impulses that a block's stresses have on its nodes, shape (b,) [N s].

        Parameters
        ----------
        after : State at the end of a step. scheme : Its coefficients.
        """
        size: FloatArray = scheme.step * np.linalg.norm(self.strains.forces(after.stress), axis=1)
        return size

    @override
    def step_energy(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ and of moving clamps, and what damping, yielding and the θ-scheme took, exactly.

        The θ-scheme's share: stresses of the end work ``excess`` more than is stored and dissipated, those of
        σ_θ work (1 − θ) Δσ : Δε less than these.
        """
        assert isinstance(state, InelasticState)
        assert isinstance(after, InelasticState)
        given = None
        if self.clamping.moving:
            given = self.nodal_residual(state, after, force, nodal, scheme)
        made = self.balance.energy(state, after, force, given, scheme)
        theta, stretch = scheme.theta, after.displacement - state.displacement
        elastic = (theta - 0.5) * dot(stretch @ self.operators.stiffness, stretch)
        grown = dot(self.strains.forces(after.stress - state.stress), stretch)
        numerical = made.numerical - elastic + after.excess - (1 - theta) * grown
        return replace(made, numerical=numerical, dissipation=after.dissipated)

    @override
    def strain_energy(self, state: ElasticState) -> FloatArray:
        """What the material can give back, shape (b,) [J]."""
        assert isinstance(state, InelasticState)
        return state.stored

    @override
    def stress(self, state: ElasticState) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes."""
        assert isinstance(state, InelasticState)
        return self._recovery.smoothed(state.stress, self.rotation)

    @override
    def stress_error(self, state: ElasticState) -> StressError:
        """Zienkiewicz and Zhu's estimate of the error of these stresses, in the elastic norm."""
        assert isinstance(state, InelasticState)
        squares = self._estimate.squares(state.stress)
        return StressError(squares, 2.0 * state.stored, self._estimate.volume.sum(axis=1))

    @override
    def material_state(self, state: ElasticState) -> Mapping[str, FloatArray]:
        """What the law shows of its internal variables at Gauss points, each of shape (b, m, p)."""
        assert isinstance(state, InelasticState)
        flat = state.internal.reshape(-1, state.internal.shape[-1])
        shape = state.internal.shape[:-1]
        return {name: values.reshape(shape) for name, values in self.law.measures(flat).items()}


class InelasticAttachment(SmallAttachment):
    """Inelastic blocks seen through contact sides: those that yield in a guess have a W_el of their own."""

    __slots__ = ()

    @override
    def own_surfaces(self, scheme: Scheme, guess: Any) -> dict[int, FloatArray]:
        """(M̂_t⁻¹)_el on the dofs that carry contacts, of each block that yields."""
        group, d = self.group, self.group.dimension
        assert isinstance(group, InelasticGroup)
        dofs = (self.carriers[:, None] * d + np.arange(d)).ravel()
        touched = set(self.bodies.tolist())
        factors = group.factors(guess, scheme)
        return {body: factor.block(dofs) for body, factor in factors.items() if body in touched}
