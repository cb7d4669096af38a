"""Elastic–brittle joint: r_adh = C u up to a strength, then nothing for good.

Tension and shear act together by (c_N u_N/s_N)² + (c_T ‖u_T‖/s_T)² = 1.

    ElasticBrittle(normal_stiffness=1e10, tangential_stiffness=1e10,
                   normal_strength=0.25e6, tangential_strength=0.35e6)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution, load
from masonry_fem.joints.parameters import FloatArray, Friction, Stiffness, Strength
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class ElasticBrittle(Adhesive):
    """Springs up to their strength, then nothing.

    Attributes
    ----------
    normal_stiffness : c_N of the springs
    tangential_stiffness : c_T of the springs
    normal_strength : tensile strength s_N
    tangential_strength : shear strength s_T without pressure

    Examples
    --------
    kind = "elastic_brittle"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    normal_strength = 0.25e6
    tangential_strength = 0.35e6
    """

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    normal_strength: Strength
    tangential_strength: Strength
    friction: Friction = 0.6

    name: ClassVar[str] = "elastic_brittle"
    softens: ClassVar[bool] = True

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
