"""Elastic interface: springs that never break beside a unilateral contact.

For a joint that is also compliant in compression put it, or another law, on a ``Bed``.

    Elastic(normal_stiffness=82e9, tangential_stiffness=36e9, friction=0.75)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import FloatArray, Parameter, check_non_negative
from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class Elastic(Adhesive):
    """Linear springs in tension and in shear.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : c_N, c_T [N/m³].
    friction : Coulomb's coefficient.
    """

    normal_stiffness: Parameter
    tangential_stiffness: Parameter
    friction: Parameter = 0.6

    name: ClassVar[str] = "elastic"

    def __post_init__(self) -> None:
        check_non_negative(self, "normal_stiffness", "tangential_stiffness", "friction")

    @override
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        return Evolution(state.adhesion, np.zeros(state.count), np.zeros(state.count))
