"""ContactProblem: one step's unilateral contact with friction, in split form.

Find the impulses p and the rigid velocities U with

    v = W_el p + q + B U,    K* ∋ v + μ‖v_T‖ n ⊥ p ∈ K,    Bᵀ p + f_r − M_r (U − U_0) = 0

A rigid block has no compliance W_el, a static one no rigid mass M_r; a plain
problem v = W p + q has all of W as compliance and no bodies.

A cohesive joint resists by p_adh = a + S v besides what presses and rubs. Then p stays what acts on
the blocks, and the second line holds for the *contact part* p̃ = p + p_adh.

    problem = ContactProblem.plain(W, q, mu)
    save_problem(problem, "step17.npz"); problem = load_problem("step17.npz")
    W, q = problem.delassus(), problem.plain_velocity()
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.compliance import Operator, Shared, only, operator
from masonry_fem.nscd.peers import Peers
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.structure import Structure

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Fields that dry problems do without.
COHESION = ("cohesion_offset", "cohesion_stiffness")


class Products(NamedTuple):
    """A problem's matrices times impulses p and rigid velocities U.

    Attributes
    ----------
    impulse, rigid_velocity : p and U, shapes (c, d) and (b, m).
    elastic : W_el p, shape (c, d) [m/s]. velocity : v, shape (c, d) [m/s]. given : Bᵀ p, shape (b, m).
    """

    impulse: FloatArray
    rigid_velocity: FloatArray
    elastic: FloatArray
    velocity: FloatArray
    given: FloatArray

    def are_of(self, impulse: FloatArray, rigid_velocity: FloatArray) -> bool:
        """True where these were multiplied: a form that makes others of them has others.

        Parameters
        ----------
        impulse, rigid_velocity : As above.
        """
        pairs = (self.rigid_velocity, rigid_velocity), (self.impulse, impulse)
        return all(one is other or np.array_equal(one, other) for one, other in pairs)


@dataclass(frozen=True, slots=True)
class ContactProblem:
    """The contact problem of one step: c contacts, d = 2 or 3, b rigid bodies of m velocities each.

    m is 3 in 2D and 6 in 3D, and more if bodies also have modes of deformation. Unknowns are the impulses p
    and the relative velocities v at the contacts in their local frames, component 0 normal, and the rigid
    velocities U; see the [theory](theory.md).

    Attributes
    ----------
    friction : Coulomb coefficients μ, shape (c,).
    free_velocity : Relative velocity without impulses and without rigid motion: elastic free velocity,
        prescribed motion of supports, and the gap term on the normal component [m/s], shape (c, d).
    compliance : Elastic part W_el of the Delassus operator, the velocity that impulses cause [1/kg], shape
        (c d, c d), block-sparse with (d, d) blocks and symmetric (problems from elsewhere may be slightly
        unsymmetric), or a ``Shared`` that stores it once for equal stones. Empty if all bodies are rigid.
    bodies : Rigid bodies on the two sides of each contact (candidate, antagonist), −1 where that
        side has no rigid freedom, shape (c, 2).
    rigid_map : Matrices B of the two sides of each contact, in its frame, signs included, so that rigid
        motion contributes Σ_s rigid_map[:, s] @ U[bodies[:, s]] to v, shape (c, 2, d, m).
    rigid_mass : Diagonal of M_r (1 in dynamics with mass-orthonormal modes, 0 in statics), shape (b, m).
    rigid_impulse : f_r, impulse of the loads on the rigid modes, shape (b, m).
    rigid_velocity : U_0, rigid velocities before the step, shape (b, m).
    cohesion_offset : Part of the cohesive impulse p_adh that is independent of the velocity [N s], shape
        (c, d), normal component positive where the joint pulls its sides together; None: no cohesion.
    cohesion_stiffness : Derivative S of p_adh with respect to the velocity [kg], shape (c, d, d), with a
        positive semidefinite symmetric part (laws that soften iterate instead); None: 0.
    structure : What solvers keep for further problems with the same contacts; neither compared nor written.
    peers : Ranks that have the other contacts, where this one has some contacts and all bodies; None: there
        are no others. With them Bᵀ p, ``norm``, ``any`` and their like are those of all contacts, which all
        ranks have to ask for together (as they do where they make a problem with cohesion); all that other
        modules measure is that of the contacts that are here.

    Raises
    ------
    ProblemError : Shapes do not fit, numbers are not finite, or a friction or mass is negative.

    Notes
    -----
    Cohesion that is zero everywhere becomes None, so that such a problem is solved exactly as a dry one.
    """

    friction: FloatArray
    free_velocity: FloatArray
    compliance: sparse.bsr_array | Shared
    bodies: IntArray
    rigid_map: FloatArray
    rigid_mass: FloatArray
    rigid_impulse: FloatArray
    rigid_velocity: FloatArray
    cohesion_offset: FloatArray | None = None
    cohesion_stiffness: FloatArray | None = None
    structure: Structure | None = field(default=None, compare=False, repr=False)
    peers: Peers | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        _check(self)
        for name in COHESION:
            values = getattr(self, name)
            if values is not None and not self.any(values):
                object.__setattr__(self, name, None)

    @classmethod
    def plain(cls, W: Any, q: ArrayLike, mu: ArrayLike, dimension: int | None = None) -> ContactProblem:
        """The problem v = W p + q without bodies.

        Parameters
        ----------
        W : Delassus operator, dense or sparse, shape (c d, c d), contact after contact [1/kg].
        q : Free velocity, shape (c d,) or (c, d) [m/s].
        mu : Friction coefficients, one for all or shape (c,).
        dimension : d; needed where ``q`` is flat and ``mu`` a single number.
        """
        free = np.array(q, dtype=float)
        if free.ndim != 2:
            d = dimension if dimension is not None else free.size // max(np.size(mu), 1)
            if d not in {2, 3} or free.size % d:
                raise ProblemError(
                    f"free velocity has {free.size} numbers for {np.size(mu)} friction coefficients; "
                    "expected 2 or 3 a contact: pass q with shape (c, d) or give dimension"
                )
            free = free.reshape(-1, d)
        c, d = free.shape
        compliance = (
            sparse.bsr_array((0, 0), blocksize=(1, 1)) if c == 0 else sparse.bsr_array(W, blocksize=(d, d))
        )
        m = 3 if d == 2 else 6
        return cls(
            friction=np.broadcast_to(np.asarray(mu, dtype=float), (c,)).copy(),
            free_velocity=free,
            compliance=compliance,
            bodies=np.full((c, 2), -1),
            rigid_map=np.zeros((c, 2, d, m)),
            rigid_mass=np.zeros((0, m)),
            rigid_impulse=np.zeros((0, m)),
            rigid_velocity=np.zeros((0, m)),
        )

    @property
    def count(self) -> int:
        """Number of contacts c."""
        return int(self.free_velocity.shape[0])

    @property
    def whole_count(self) -> int:
        """Contacts of all ranks."""
        return self.count if self.peers is None else self.peers.count

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.free_velocity.shape[1])

    @property
    def body_count(self) -> int:
        """Number of rigid bodies b."""
        return int(self.rigid_mass.shape[0])

    @property
    def rigid(self) -> bool:
        """True where no contact has elastic compliance."""
        return self.compliance.nnz == 0

    @property
    def cohesive(self) -> bool:
        """True where some contact has cohesion."""
        return self.cohesion_offset is not None or self.cohesion_stiffness is not None

    @property
    def operator(self) -> Operator:
        """W_el, whichever way it is held."""
        return operator(self.compliance)

    def without_compliance(self) -> ContactProblem:
        """The same of rigid bodies."""
        nothing = sparse.bsr_array(self.compliance.shape, blocksize=self.compliance.blocksize)
        return replace(self, compliance=nothing)

    def only(self, contacts: IntArray) -> ContactProblem:
        """The problem with some of its contacts alone; all bodies stay.

        Parameters
        ----------
        contacts : Numbers of the contacts to keep, ascending, shape (k,).
        """
        cohesion: dict[str, Any] = {name: getattr(self, name) for name in COHESION}
        return replace(
            self,
            friction=self.friction[contacts],
            free_velocity=self.free_velocity[contacts],
            compliance=only(self.compliance, contacts),
            bodies=self.bodies[contacts],
            rigid_map=self.rigid_map[contacts],
            **{name: values[contacts] for name, values in cohesion.items() if values is not None},
        )

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all contacts, from those over the contacts that are here."""
        return values if self.peers is None else self.peers.summed(values)

    def least(self, values: FloatArray) -> FloatArray:
        """Least values of all contacts, from those of the contacts that are here; nan where one is."""
        return values if self.peers is None else self.peers.least(values)

    def largest(self, values: FloatArray) -> float:
        """The largest of values at all contacts, at least 0; nan where one is."""
        here = np.array([values.max(initial=0.0)])
        return -float(self.least(-here)[0])

    def any(self, values: FloatArray | Mask) -> bool:
        """Whether some value at any contact is not 0."""
        here = bool(values.any())
        return here if self.peers is None else bool(self.peers.summed(np.array([float(here)]))[0] > 0)

    def norm(self, values: FloatArray) -> float:
        """Euclidean norm of values at all contacts."""
        return self.norm_of(float(np.linalg.norm(values)))

    def norm_of(self, here: float) -> float:
        """The same from that of the values that are here."""
        return here if self.peers is None else math.sqrt(float(self.summed(np.array([here * here]))[0]))

    def elastic_velocity(self, impulse: FloatArray) -> FloatArray:
        """W_el p, shape (c, d) [m/s]."""
        if self.rigid:
            return np.zeros(self.free_velocity.shape)
        return (self.operator @ impulse.ravel()).reshape(impulse.shape)

    def contact_velocity(self, rigid_velocity: FloatArray) -> FloatArray:
        """B U, shape (c, d) [m/s]."""
        if not self.body_count:
            return np.zeros_like(self.free_velocity)
        from masonry_fem.nscd.transfer import to_contacts  # noqa: PLC0415 - Numba is slow to import

        velocity: FloatArray = to_contacts(self.bodies, self.rigid_map, np.ascontiguousarray(rigid_velocity))
        return velocity

    def body_impulse(self, impulse: FloatArray) -> FloatArray:
        """Bᵀ p, shape (b, m)."""
        from masonry_fem.nscd.transfer import to_bodies  # noqa: PLC0415 - Numba is slow to import

        given: FloatArray = to_bodies(
            self.bodies, self.rigid_map, np.ascontiguousarray(impulse), self.body_count
        )
        return self.summed(given)

    def side_impulse(self, impulse: FloatArray) -> FloatArray:
        """What each contact gives to the rigid modes on its two sides, shape (c, 2, m)."""
        product: FloatArray = impulse[:, None, None, :] @ self.rigid_map
        return product[:, :, 0]

    def velocity(self, impulse: FloatArray, rigid_velocity: FloatArray) -> FloatArray:
        """V = W_el p + q + B U, shape (c, d) [m/s]."""
        return self._with_rest(self.elastic_velocity(impulse), rigid_velocity)

    def _with_rest(self, velocity: FloatArray, rigid_velocity: FloatArray) -> FloatArray:
        """The same with q + B U added."""
        velocity += self.free_velocity
        if self.body_count:
            from masonry_fem.nscd.transfer import add_moved  # noqa: PLC0415 - Numba is slow to import

            add_moved(self.bodies, self.rigid_map, np.ascontiguousarray(rigid_velocity), velocity)
        return velocity

    def products(self, impulse: FloatArray, rigid_velocity: FloatArray) -> Products:
        """W_el p, v and Bᵀ p."""
        elastic = self.elastic_velocity(impulse)
        velocity = self._with_rest(elastic.copy(), rigid_velocity)
        return Products(impulse, rigid_velocity, elastic, velocity, self.body_impulse(impulse))

    def contact_part(self, impulse: FloatArray, velocity: FloatArray) -> FloatArray:
        """P̃ = p + a + S v, which the laws of contact hold for; p itself where joints are dry, (c, d)."""
        if self.cohesion_offset is not None:
            impulse = impulse + self.cohesion_offset
        if self.cohesion_stiffness is not None:
            impulse = impulse + applied(self.cohesion_stiffness, velocity)
        return impulse

    def free_rigid_velocity(self) -> FloatArray:
        """U_0 + M_r⁻¹ f_r; U_0 where M_r = 0, shape (b, m)."""
        inverse = _inverse_mass(self.rigid_mass)
        return self.rigid_velocity + inverse * self.rigid_impulse

    def balanced_velocity(self, impulse: FloatArray) -> FloatArray:
        """U of balance under given impulses, U_0 + M_r⁻¹ (f_r + Bᵀ p); U_0 where M_r = 0, (b, m)."""
        inverse = _inverse_mass(self.rigid_mass)
        return self.rigid_velocity + inverse * (self.rigid_impulse + self.body_impulse(impulse))

    def rigid_matrix(self) -> sparse.bsr_array:
        """B as a block-sparse matrix of (d, m) blocks, shape (c d, b m)."""
        c, d, m = self.count, self.dimension, self.rigid_mass.shape[1]
        contact, side = np.nonzero(self.bodies >= 0)
        pointer = np.concatenate([[0], np.cumsum((self.bodies >= 0).sum(axis=1))])
        # SciPy's products read blocks of another memory order wrongly
        blocks = (np.ascontiguousarray(self.rigid_map[contact, side]), self.bodies[contact, side], pointer)
        matrix = sparse.bsr_array(blocks, shape=(c * d, self.body_count * m), blocksize=(d, m))
        matrix.sort_indices()
        return matrix

    def delassus(self) -> sparse.bsr_array:
        """W = W_el + B M_r⁻¹ Bᵀ on the directions that have mass, block-sparse, (c d, c d) [1/kg]."""
        if not (self.rigid_mass > 0).any() or not self.count:
            return self.operator.matrix()
        B = self.rigid_matrix()
        weighted = B.copy()
        inverse = _inverse_mass(self.rigid_mass)
        weighted.data = B.data * inverse[B.indices][:, None, :]
        d = self.dimension
        product = sparse.bsr_array(weighted @ B.T.tobsr((B.blocksize[1], d)), blocksize=(d, d))
        total = product
        if not self.rigid:
            total = sparse.bsr_array(self.operator.matrix() + product, blocksize=(d, d))
        total.sort_indices()
        return total

    def check_inertia(self, method: str) -> None:
        """Raise ProblemError where a body in contact has no inertia, for a method that needs it."""
        if (self.rigid_mass > 0).all():
            return
        touched = np.unique(self.bodies[self.bodies >= 0])
        still = touched[(self.rigid_mass[touched] <= 0).any(axis=1)]
        if len(still):
            raise ProblemError(
                f"method '{method}' got {len(still)} of {len(touched)} bodies without inertia (statics), "
                f"body {still[0]} first, expected none; use method 'auto' or 'newton', or a dynamic step"
            )

    def plain_velocity(self) -> FloatArray:
        """Free velocity with the rigid motion, q + B (U_0 + M_r⁻¹ f_r), shape (c, d) [m/s]."""
        return self.free_velocity + self.contact_velocity(self.free_rigid_velocity())


def _inverse_mass(mass: FloatArray) -> FloatArray:
    return np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0)


def _check(problem: ContactProblem) -> None:
    """Raise ProblemError where arrays do not fit together."""
    if problem.free_velocity.ndim != 2 or problem.free_velocity.shape[1] not in {2, 3}:
        raise ProblemError(
            f"free_velocity has shape {problem.free_velocity.shape}, expected (contacts, 2) or (contacts, 3)"
        )
    c, d = problem.free_velocity.shape
    b, m = problem.rigid_mass.shape[0], max(3 if d == 2 else 6, problem.rigid_mass.shape[-1])
    expected = {
        "friction": (c,),
        "bodies": (c, 2),
        "rigid_map": (c, 2, d, m),
        "rigid_mass": (b, m),
        "rigid_impulse": (b, m),
        "rigid_velocity": (b, m),
        "compliance": (c * d, c * d),
        "cohesion_offset": (c, d),
        "cohesion_stiffness": (c, d, d),
    }
    for name, shape in expected.items():
        values = getattr(problem, name)
        if values is None and name in COHESION:
            continue
        found = values.shape
        if found != shape:
            raise ProblemError(f"{name} has shape {found}, expected {shape} for {c} contacts and {b} bodies")
    if c and problem.compliance.blocksize != (d, d):
        raise ProblemError(f"compliance has blocks of {problem.compliance.blocksize}, expected {(d, d)}")
    _check_values(problem, b)


def _check_values(problem: ContactProblem, b: int) -> None:
    for name, owner in (
        ("friction", "contact"), ("free_velocity", "contact"), ("rigid_map", "contact"),
        ("rigid_mass", "body"), ("rigid_impulse", "body"), ("rigid_velocity", "body"),
        ("cohesion_offset", "contact"), ("cohesion_stiffness", "contact"),
    ):  # fmt: skip
        values = getattr(problem, name)
        if values is not None and not np.isfinite(values).all():
            first = np.argwhere(~np.isfinite(values))[0]
            raise ProblemError(
                f"{owner} {first[0]}: {name} is {values[tuple(first)]}, expected a finite number; "
                "check the loads, motions and joint laws that enter it"
            )
    faulty = problem.operator.faulty()
    if faulty is not None:
        raise ProblemError(
            f"contact {faulty[0]}: compliance to contact {faulty[1]} is not finite; "
            "check stiffness and mass of the blocks that touch there"
        )
    for name, owner in (("friction", "contact"), ("rigid_mass", "body")):
        values = getattr(problem, name)
        if (values < 0).any():
            first = np.argwhere(values < 0)[0]
            raise ProblemError(f"{owner} {first[0]}: {name} is {values[tuple(first)]}, expected >= 0")
    wrong = (problem.bodies < -1) | (problem.bodies >= b)
    if wrong.any():
        contact, side = np.argwhere(wrong)[0]
        raise ProblemError(
            f"contact {contact}: body {problem.bodies[contact, side]} does not exist, "
            f"expected 0 to {b - 1}, or -1 for a side without rigid freedom"
        )
