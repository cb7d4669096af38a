"""Rigid: stones that keep their shape. They give forces and mechanisms, and mean stresses only."""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.fidelities import Fidelity, Given


class Rigid(Fidelity):
    """All rigid stones of a model in one group."""

    name = RigidGroup.kind
    rank = 1
    deforms = False

    @classmethod
    def groups(cls, given: Given) -> list[RigidGroup]:
        """One group."""
        blocks, materials = list(given.materials), given.materials.values()
        density = np.array([material.density for material in materials])
        damping = np.array([material.damping.mass for material in materials])
        return [RigidGroup(given.assembly, blocks, density, damping, turns=given.turns)]
