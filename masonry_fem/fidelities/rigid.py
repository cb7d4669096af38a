"""Rigid: stones that keep their shape. They give forces and mechanisms, and mean stresses only."""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.fidelities import Fidelity, Given, distinct


class Rigid(Fidelity):
    """All rigid stones of a model in one group."""

    name = RigidGroup.kind
    rank = 1
    deforms = False

    @classmethod
    def groups(cls, given: Given) -> list[RigidGroup]:
        """One group."""
        blocks = list(given.materials)
        kinds, of = distinct(given)
        density = np.array([material.density for material in kinds])[of]
        damping = np.array([material.damping.mass for material in kinds])[of]
        return [RigidGroup(given.assembly, blocks, density, damping, turns=given.turns)]
