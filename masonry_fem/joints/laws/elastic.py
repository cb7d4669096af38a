"""Elastic interface: springs that never break beside a unilateral contact.

For a joint that is also compliant in compression put it, or another law, on a ``Bed``.

    Elastic(normal_stiffness=82e9, tangential_stiffness=36e9, friction=0.75)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution
from masonry_fem.joints.parameters import FloatArray, Friction, Stiffness
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class Elastic(Adhesive):
    """Springs in tension and in shear, contact in compression.

    Attributes
    ----------
    normal_stiffness : c_N of the springs
    tangential_stiffness : c_T of the springs

    Examples
    --------
    kind = "elastic"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    """

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    friction: Friction = 0.6

    name: ClassVar[str] = "elastic"

    @override
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        return Evolution(state.adhesion, np.zeros(state.count), np.zeros(state.count))
