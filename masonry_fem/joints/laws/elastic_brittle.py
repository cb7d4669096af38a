"""Elastic–brittle joint: r_adh = C u up to a strength, then nothing for good (slides 4.3).

Tension and shear act together by (c_N u_N/s_N)² + (c_T ‖u_T‖/s_T)² = 1.

    ElasticBrittle(normal_stiffness=1e10, tangential_stiffness=1e10,
                   normal_strength=0.25e6, tangential_strength=0.35e6)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import FloatArray, Parameter, check_non_negative, check_positive
from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution, load
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class ElasticBrittle(Adhesive):
    """Springs that break.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : c_N, c_T [N/m³].
    normal_strength, tangential_strength : s_N, s_T [Pa].
    friction : Coulomb's coefficient.
    """

    normal_stiffness: Parameter
    tangential_stiffness: Parameter
    normal_strength: Parameter
    tangential_strength: Parameter
    friction: Parameter = 0.6

    name: ClassVar[str] = "elastic_brittle"

    def __post_init__(self) -> None:
        check_positive(self, "normal_stiffness", "tangential_stiffness")
        check_positive(self, "normal_strength", "tangential_strength")
        check_non_negative(self, "friction")

    @override
    def factors(self, state: JointState) -> FloatArray:
        return np.repeat(state.adhesion[:, None], state.dimension, axis=1)

    @override
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        springs = self.springs(state)
        critical = np.empty_like(springs)  # opening of rupture in each direction alone
        critical[:, 0] = np.asarray(self.normal_strength) / springs[:, 0]
        critical[:, 1:] = (np.asarray(self.tangential_strength) / springs[:, 1])[:, None]
        opened = jump.copy()
        opened[:, 0] = np.maximum(jump[:, 0], 0.0)
        demand = np.sqrt(((opened / critical) ** 2).sum(axis=1))
        breaks = (demand > 1.0) & (state.adhesion > 0)
        at_threshold = 0.5 * load(springs, jump) / np.maximum(demand, 1.0) ** 2
        return Evolution(
            adhesion=np.where(breaks, 0.0, state.adhesion),
            dissipated=np.where(breaks, at_threshold, 0.0),
            demand=np.where(state.adhesion > 0, demand, 0.0),
        )
