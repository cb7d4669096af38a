"""Modal: W_el of stones that deform by few modes, and contact problems in which these are velocities.

    v = (D + F M_η⁻¹ Fᵀ) p + q + B U    is    v = D p + q + B U + F η,    Fᵀ p − M_η η = 0

D is what contacts give way by themselves, F what unit velocities of the modes are at the contacts, and M_η
the modes' effective mass. In the second form no contact gives way under the impulse of another: contacts are
eliminated one by one, and a matrix of the bodies is left that has their modes beside their rigid velocities.
It is much smaller than one of all contacts, and its pattern does not change with what is closed.

    form = modal_form(problem)              # None: it has no modes, or so few contacts that it does not pay
    run = ModalRun(method.init(form, modal_start(problem, start)), ...)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import override

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.iterate import Iterate, Run
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Contacts from which the form pays, and modes of a body up to which it does: with fewer contacts a factor of
# all is as cheap. With 54 modes iterations on all contacts (``elastic_krylov``) take a tenth of the time,
# with 24 they fail.
CONTACTS = 2_000
MOST = 24


@dataclass(frozen=True, slots=True)
class Modes:
    """How the modes of bodies are seen at c contacts, K of each of b bodies.

    Attributes
    ----------
    maps : F by contact and side, in the contact's frame, signs included, shape (c, 2, d, K).
    mass : Effective mass of the modes; 1 where a body has fewer, shape (b, K).
    """

    maps: FloatArray
    mass: FloatArray


class Modal(Shared):
    """W_el of stones of which each deforms by modes.

    Parameters
    ----------
    modes : Of all bodies that deform.
    others : As for ``Shared``, which holds the same by kinds of stones.
    """

    def __init__(
        self,
        count: int,
        dimension: int,
        kinds: Sequence[Kinds],
        symmetric: bool,
        modes: Modes,
        bed: FloatArray | None = None,
    ) -> None:
        super().__init__(count, dimension, kinds, symmetric, bed)
        self.modes = modes

    @override
    def only(self, contacts: IntArray) -> Modal:
        part = super().only(contacts)
        modes = replace(self.modes, maps=self.modes.maps[contacts])
        return Modal(part.count, part.dimension, part.kinds, self.symmetric, modes, part.bed)

    @override
    def plus(self, bed: FloatArray) -> Modal:
        both = super().plus(bed)
        return Modal(both.count, both.dimension, both.kinds, self.symmetric, self.modes, both.bed)


class Bed(Shared):
    """What contacts give way by themselves, beside bodies whose modes are among their velocities.

    Parameters
    ----------
    bed : Diagonal of D, all of it above 0, shape (c, d) [1/kg].
    giving : Blocks by which contacts give way with the modes, shape (c, d, d). norms : Of these, shape (c,).
    """

    def __init__(self, bed: FloatArray, giving: FloatArray, norms: FloatArray) -> None:
        count, dimension = bed.shape
        super().__init__(count, dimension, (), bed=bed)
        self._giving, self._norms = giving, norms

    @override
    def giving(self) -> FloatArray:
        return self._giving.copy()

    @override
    def only(self, contacts: IntArray) -> Bed:
        assert self.bed is not None
        assert self._norms is not None
        return Bed(self.bed[contacts], self._giving[contacts], self._norms[contacts])


def has_form(problem: ContactProblem) -> bool:
    """Whether the modes of a problem become velocities of its bodies: it has some, and that pays.

    Contacts need to give way by themselves, or their impulses would not be unique.

    Parameters
    ----------
    problem : The contact problem.
    """
    compliance = problem.compliance
    if not isinstance(compliance, Modal) or problem.count < CONTACTS or compliance.bed is None:
        return False
    return compliance.modes.mass.shape[1] <= MOST and bool(compliance.bed.all())


def modal_form(problem: ContactProblem) -> ContactProblem | None:
    """The problem with the modes among the velocities of its bodies; None where ``has_form`` is false.

    Parameters
    ----------
    problem : The contact problem.
    """
    compliance = problem.compliance
    if not has_form(problem) or not isinstance(compliance, Modal) or compliance.bed is None:
        return None
    modes, still = compliance.modes, np.zeros_like(compliance.modes.mass)
    return replace(
        problem,
        compliance=Bed(compliance.bed, compliance.diagonal(), compliance.norms()),
        rigid_map=np.concatenate([problem.rigid_map, modes.maps], axis=3),
        rigid_mass=np.concatenate([problem.rigid_mass, modes.mass], axis=1),
        rigid_impulse=np.concatenate([problem.rigid_impulse, still], axis=1),
        rigid_velocity=np.concatenate([problem.rigid_velocity, still], axis=1),
    )


def modal_start(form: ContactProblem, start: Start | None) -> Start | None:
    """A first guess of a problem as one of its form.

    Parameters
    ----------
    form : The problem's form. start : What the problem itself would start from.
    """
    if start is None or start.rigid_velocity is None:
        return start
    m = start.rigid_velocity.shape[1]
    moved = np.zeros_like(form.rigid_mass)
    if start.impulse is not None:
        moved[:, m:] = form.body_impulse(start.impulse)[:, m:] / form.rigid_mass[:, m:]
    moved[:, :m] = start.rigid_velocity
    return replace(start, rigid_velocity=moved)


class ModalRun:
    """A run on the form of a problem, its offers those of the problem.

    Parameters
    ----------
    run : On the form.
    size : Rigid velocities m of a body.
    """

    def __init__(self, run: Run, size: int) -> None:
        self._run, self._size = run, size

    def guess(self) -> Iterate:
        """Where it starts."""
        return self._without_modes(self._run.guess())

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """The run's next offer; ``quality`` is that of the problem."""
        return self._without_modes(self._run.step(quality, settings))

    def _without_modes(self, offer: Iterate) -> Iterate:
        return replace(offer, rigid_velocity=offer.rigid_velocity[:, : self._size])
