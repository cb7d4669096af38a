"""Reduction: what a joint law tells the contact solver, an affine cohesive reaction.

With the joint's own velocity v_c = v + shift + compliance · h r, the cohesive reaction is

    r_adh = offset + stiffness · v_c,    r̃ = r + r_adh

and (v_c,N + max(g̃ − closure, 0)/h, r̃_N) is on Signorini's graph, (v_c,T, r̃_T) on Coulomb's with
``friction``. ``shift``, ``compliance`` and ``closure`` are zero for most laws, and then v_c is the relative
velocity itself.

    W, free = reduction.fold(blocks, free_velocity, step)     # v_c = free + W h r̃
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import LawError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Reduction:
    """A law linearised for the contact solver: cohesion affine in the velocity v_c at c contact points.

    Vectors are in the local frames, component 0 normal.

    Attributes
    ----------
    offset : Cohesive reaction at v_c = 0 [N], shape (c, d).
    stiffness : B = h ∂r_adh/∂u, symmetric, shape (c, d, d) [N s/m].
    friction : Coulomb's coefficient for r̃, shape (c,).
    compliance : Diagonal of an elastic bed in series, to be added to the diagonal block of W,
        shape (c, d) [1/kg].
    shift : Velocity added to the free velocity [m/s], shape (c, d).
    closure : Gap at which the faces touch, 0 but for beds, rough and worn joints [m], shape (c,).

    Raises
    ------
    LawError : An array has another shape: NumPy might stretch it to one that fits, with other forces.
    """

    offset: FloatArray
    stiffness: FloatArray
    friction: FloatArray
    compliance: FloatArray
    shift: FloatArray
    closure: FloatArray

    def __post_init__(self) -> None:
        c, d = self.offset.shape
        shapes = (c, d), (c, d, d), (c,), (c, d), (c, d), (c,)
        for name, shape in zip(self.__slots__, shapes, strict=True):
            if (found := getattr(self, name).shape) != shape:
                raise LawError(
                    f"a joint law's Reduction has {name} of the shape {found}, expected {shape} for "
                    f"offset of the shape {(c, d)}; correct the law's reduce"
                )

    @classmethod
    def dry(cls, friction: FloatArray, dimension: int) -> Reduction:
        """No cohesion: Signorini and Coulomb alone."""
        c = len(friction)
        return cls(
            offset=np.zeros((c, dimension)),
            stiffness=np.zeros((c, dimension, dimension)),
            friction=friction,
            compliance=np.zeros((c, dimension)),
            shift=np.zeros((c, dimension)),
            closure=np.zeros(c),
        )

    @property
    def count(self) -> int:
        """Number of contact points c."""
        return len(self.friction)

    def take(self, contacts: NDArray[Any]) -> Reduction:
        """The part of some of the contact points."""
        return Reduction(
            self.offset[contacts], self.stiffness[contacts], self.friction[contacts],
            self.compliance[contacts], self.shift[contacts], self.closure[contacts],
        )  # fmt: skip

    def own_velocity(self, velocity: FloatArray, reaction: FloatArray, step: float) -> FloatArray:
        """v_c of a relative velocity and a physical reaction, shape (c, d) [m/s]."""
        return velocity + self.shift + self.compliance * step * reaction

    def adhesive_reaction(self, own_velocity: FloatArray) -> FloatArray:
        """r_adh, shape (c, d) [N]."""
        return self.offset + (self.stiffness @ own_velocity[:, :, None])[:, :, 0]

    def fold(
        self, blocks: FloatArray, free_velocity: FloatArray, step: float
    ) -> tuple[FloatArray, FloatArray]:
        """Each contact's own block with its law folded in, v_c = free + W h r̃.

        Parameters
        ----------
        blocks : Diagonal blocks w of the Delassus operator, shape (c, d, d) [1/kg].
        free_velocity : v_locfree, shape (c, d) [m/s]. step : h [s].

        Returns
        -------
        w' = (I + h w B)⁻¹ w and v' = (I + h w B)⁻¹ (v_locfree − h w a), with the bed's compliance
        added to w and the shift to v_locfree beforehand.
        """
        d = blocks.shape[1]
        w = blocks + self.compliance[:, :, None] * np.eye(d)
        free = free_velocity + self.shift - step * (w @ self.offset[:, :, None])[:, :, 0]
        system = np.eye(d) + step * w @ self.stiffness
        folded = np.linalg.solve(system, np.concatenate([w, free[:, :, None]], axis=2))
        return folded[:, :, :d], folded[:, :, d]
