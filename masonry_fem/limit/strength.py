"""Strength: the reactions that each contact point can bear, a cone cut off by the tension it stands.

    ‖r_T‖ ≤ μ (r_N + apex),    −tension ≤ r_N ≤ most

Dry joints have neither apex nor tension, and bear any pressure; ties that yield bear the most that they do.
Only laws whose strength is a constant have such a set:
limit analysis knows nothing of the deformation by which others lose theirs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import LawError
from masonry_fem.joints.assignment import Assignment
from masonry_fem.joints.law import Law, layers_of
from masonry_fem.joints.laws.parts.bed import Bed
from masonry_fem.joints.laws.parts.closure import Closure
from masonry_fem.joints.laws.parts.dry import Dry
from masonry_fem.joints.laws.parts.kinetic import Kinetic
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.laws.parts.rough import Rough
from masonry_fem.march.model import Model
from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]

LAYERS = (Bed, Closure, Rough, Kinetic)  # laws around another law that do not change its strength


@dataclass(frozen=True, slots=True)
class Strength:
    """What c contact points can bear.

    Attributes
    ----------
    friction : Coulomb's μ, shape (c,).
    apex : Tension at the tip of the cone [N], shape (c,).
    tension : Greatest tension [N], at most the apex, shape (c,).
    most : Greatest normal force [N], infinite but for ties that yield, shape (c,).
    """

    friction: FloatArray
    apex: FloatArray
    tension: FloatArray
    most: FloatArray

    @property
    def cohesive(self) -> bool:
        """True where some joint stands tension or shear without pressure."""
        return bool(self.apex.any())

    @property
    def cut(self) -> NDArray[np.bool_]:
        """Points whose cone is cut off below its tip, shape (c,)."""
        cut: NDArray[np.bool_] = self.tension < self.apex
        return cut

    @property
    def bounded(self) -> NDArray[np.bool_]:
        """Points whose normal force has a greatest value, shape (c,)."""
        return np.isfinite(self.most)

    def scaled(self, force: float) -> Strength:
        """The same with ``force`` [N] as unit of forces."""
        return replace(self, apex=self.apex / force, tension=self.tension / force, most=self.most / force)

    def without_cohesion(self) -> Strength:
        """The friction alone, which remains of the set far from its tip; nothing where it is bounded."""
        none = np.zeros_like(self.apex)
        return replace(self, apex=none, tension=none, most=np.where(self.bounded, 0.0, np.inf))

    def dissipation(self, velocity: FloatArray) -> FloatArray:
        """Power that the points can take at a relative velocity, in the dual cone where unbounded, (c,).

        The greatest −r·v over the set; it is reached on the rim of the cut (at the tip where none is), and at
        the greatest normal force where the velocity lies outside of the dual cone.
        """
        slip = lengths(velocity[:, 1:])
        rim = self.friction * (self.apex - self.tension)
        power: FloatArray = self.tension * velocity[:, 0] + rim * slip
        beyond = np.maximum(self.friction * slip - velocity[:, 0], 0.0)
        power += np.where(self.bounded, self.most + self.tension, 0.0) * beyond
        return power


def strength_of(model: Model) -> Strength:
    """What the contact points of a model can bear while their joints are whole.

    Raises
    ------
    LawError : A joint's law has no constant strength.
    """
    count = model.contacts.count
    strength = Strength(np.zeros(count), np.zeros(count), np.zeros(count), np.full(count, np.inf))
    for law, points in _parts(model.laws):
        own = _strength(law, len(points), _where(model, points))
        area = model.contacts.area[points]
        strength.friction[points] = own.friction
        strength.apex[points] = area * own.apex
        strength.tension[points] = area * own.tension
        strength.most[points] = np.where(np.isfinite(own.most), area, 1.0) * own.most
    return strength


def _parts(laws: Assignment) -> Iterator[tuple[Law, NDArray[np.int64]]]:
    for law, points in laws.parts:
        if len(points):
            yield law, points


def _where(model: Model, points: NDArray[np.int64]) -> str:
    """The first of the joints that have a law, for messages."""
    first, second = (model.assembly.blocks.names[block] for block in model.contacts.blocks[points[0]])
    return f"the joint of '{first}' and '{second}'"


def _strength(law: Law, count: int, where: str) -> Strength:
    """The strength of a law in stresses [Pa]."""
    none, any_force = np.zeros(count), np.full(count, np.inf)
    if law.pull is not None:
        return Strength(none, none, none, law.pull.strength)
    layers = list(layers_of(law))
    crushing = next((one for one in layers if isinstance(one, Bed) and one.crushing is not None), None)
    if crushing is not None:
        raise LawError(
            f"limit analysis knows joints that bear any pressure, and the mortar of {where} has a crushing "
            "strength; leave 'crushing' out for it"
        )
    core = layers[-1]
    around = [one for one in layers[:-1] if not isinstance(one, LAYERS)]
    if not around and isinstance(core, Dry):
        friction = np.broadcast_to(np.asarray(core.friction, float), count).copy()
        return Strength(friction, none, none, any_force)
    if not around and isinstance(core, RigidBrittle):
        apex, tension = core.apex(count), core.tension(count)
        return Strength(core.frictions(count)[0], apex, np.minimum(tension, apex), any_force)
    raise LawError(
        f"limit analysis knows joints of constant strength, and the law '{core.name}' of {where} gives way "
        "as it opens or slides; take a dry joint with the friction that is left, 'mohr_coulomb' or "
        "'constant_threshold'"
    )
