"""A material point driven along a path of strains, with stresses prescribed where that is asked for."""

from dataclasses import dataclass

import numpy as np

from masonry_fem.fem.material_law import Isotropic, MaterialLaw

STONE = Isotropic.of(10e9, 0.2)
SIZE = np.array([0.05])  # of elements [m]


@dataclass
class Point:
    """One point of a material; every step is committed."""

    law: MaterialLaw
    elastic: Isotropic = STONE

    def __post_init__(self):
        self.strain, self.internal = np.zeros((1, 6)), self.law.initial(1)
        self.stress = np.zeros(6)
        self.dissipated = self.work = self.stored = self.excess = 0.0

    def to(self, strain):
        """A step to a strain (6,); the response."""
        strain = np.asarray(strain, dtype=float)[None]
        made = self.law.update(self.elastic, self.strain, strain, self.internal, SIZE)
        self.work += float(made.stress[0] @ (strain - self.strain)[0])
        self.dissipated += float(made.dissipation[0])
        self.excess += float(made.excess[0])
        self.strain, self.internal, self.stress = strain, made.internal, made.stress[0]
        self.stored = float(made.stored[0])
        return made

    def squeezed(self, axial, lateral_stress=0.0):
        """A step to an axial strain zz, with the stresses xx and yy prescribed [Pa]; the axial stress."""
        side = self.strain[0, 0]
        for _ in range(60):
            trial = np.array([side, side, axial, 0.0, 0.0, 0.0])
            made = self.law.update(self.elastic, self.strain, trial[None], self.internal, SIZE)
            left = made.stress[0, 0] - lateral_stress
            slope = made.tangent[0, 0, 0] + made.tangent[0, 0, 1]
            if abs(left) <= 1e-13 * self.elastic.shear * 1e-3:
                break
            side -= left / slope
        self.to(trial)
        return self.stress[2]


def turned(tensors, rotation, *, shears):
    """Components (q, 6) in turned axes; ``shears`` is 2 for strains by angles, 1 for stresses."""
    place = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
    scale = np.array([1.0, 1.0, 1.0, shears, shears, shears])
    full = rotation @ (tensors / scale)[:, place] @ rotation.T
    return full[:, (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)] * scale
