"""Faces: for each contact, the part of its friction cone that an impulse may lie in.

The whole cone where the contact sticks, a ray of it where the contact slides, its tip where it is
open. Each is a small second-order cone through a linear map p = T x, so that one algebra serves all.

    faces = Faces.of_velocity(velocity, friction, threshold)
    nearest, slope = faces.project(vector)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.products import applied

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

TIP, RAY, CONE = 0, 1, 2


@dataclass(frozen=True, slots=True)
class Faces:
    """Faces of c friction cones.

    Attributes
    ----------
    kind : TIP (no impulse), RAY (along ``direction``) or CONE, shape (c,).
    direction : (1, …) along the ray; anything elsewhere, shape (c, d).
    friction : μ, shape (c,); a CONE has μ > 0.
    """

    kind: NDArray[np.int8]
    direction: FloatArray
    friction: FloatArray

    @classmethod
    def of_solution(
        cls, impulse: FloatArray, velocity: FloatArray, friction: FloatArray, threshold: FloatArray
    ) -> Faces:
        """Faces that Signorini and Coulomb leave to impulses at the velocities of a solution.

        Parameters
        ----------
        impulse, velocity : p and v of the solution, gap term included, shape (c, d).
        friction : μ, shape (c,).
        threshold : Speed of each contact below which it is rest, shape (c,) [m/s].
        """
        slip = graphs.tangential_norm(velocity)
        kind = np.full(len(velocity), CONE, dtype=np.int8)
        slides = slip > threshold
        kind[slides | (friction <= 0)] = RAY
        kind[velocity[:, 0] > threshold] = TIP
        direction = np.zeros_like(velocity)
        direction[:, 0] = 1.0
        # slow sliding has its direction in the impulse, in the velocity only as far as that is exact
        by_impulse = slides & ((impulse[:, 1:] * velocity[:, 1:]).sum(axis=1) < 0)
        tangent = np.where(by_impulse[:, None], impulse[:, 1:], -velocity[:, 1:])[slides]
        size = np.linalg.norm(tangent, axis=1)[:, None]
        direction[slides, 1:] = friction[slides, None] * tangent / size
        return cls(kind, direction, friction)

    def shrunk(self, impulse: FloatArray, least: float) -> Faces:
        """The least faces that hold given impulses; what is within ``least`` of an edge lies on it [N s]."""
        kind, direction = self.kind.copy(), self.direction.copy()
        inside = self.friction * impulse[:, 0] - graphs.tangential_norm(impulse)
        edge = (kind == CONE) & (inside <= least * np.minimum(self.friction, 1.0))
        kind[edge] = RAY
        pressed = impulse[:, 0] > least
        along = edge & pressed
        tangent = impulse[along, 1:]
        size = graphs.tangential_norm(impulse)[along]
        direction[along, 1:] = self.friction[along, None] * tangent / np.where(size > 0, size, 1.0)[:, None]
        kind[(kind == RAY) & ~pressed] = TIP
        return Faces(kind, direction, self.friction)

    @property
    def closed(self) -> Mask:
        """Contacts that may carry something, shape (c,)."""
        closed: Mask = self.kind != TIP
        return closed

    def maps(self) -> tuple[FloatArray, FloatArray]:
        """T and its pseudo-inverse: p = T x with x in the cone {‖x_T‖ ≤ x_N}, both (c, d, d)."""
        c, d = self.direction.shape
        T, inverse = np.zeros((c, d, d)), np.zeros((c, d, d))
        cone, ray = self.kind == CONE, self.kind == RAY
        tangents = np.arange(1, d)
        T[np.ix_(cone, tangents, tangents)] = np.eye(d - 1)
        inverse[np.ix_(cone, tangents, tangents)] = np.eye(d - 1)
        T[cone, 0, 0], inverse[cone, 0, 0] = 1.0 / self.friction[cone], self.friction[cone]
        along = self.direction[ray]
        T[ray, :, 0] = along
        inverse[ray, 0, :] = along / (along**2).sum(axis=1)[:, None]
        return T, inverse

    def spans(self) -> FloatArray:
        """Orthogonal projectors on the spans of the faces, shape (c, d, d)."""
        c, d = self.direction.shape
        projector = np.zeros((c, d, d))
        projector[self.kind == CONE] = np.eye(d)
        ray = self.kind == RAY
        along = self.direction[ray]
        projector[ray] = along[:, :, None] * along[:, None, :] / (along**2).sum(axis=1)[:, None, None]
        return projector

    def project(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of the faces, shape (c, d), and a generalised Jacobian, (c, d, d)."""
        d = vector.shape[1]
        slope = self.spans()
        nearest = applied(slope, vector)
        behind = (self.kind == RAY) & (nearest[:, 0] < 0)
        nearest[behind], slope[behind] = 0.0, 0.0
        cone = self.kind == CONE
        nearest[cone] = graphs.project_cone(vector[cone], self.friction[cone])
        mu, size = self.friction, graphs.tangential_norm(vector)
        outside = cone & (size > mu * vector[:, 0])
        polar = outside & (mu * size <= -vector[:, 0])
        slope[polar] = 0.0
        surface = np.flatnonzero(outside & ~polar)
        unit = vector[surface, 1:] / size[surface, None]
        along = np.concatenate([np.ones((len(surface), 1)), mu[surface, None] * unit], axis=1)
        scale = 1.0 + mu[surface] ** 2
        slope[surface] = along[:, :, None] * along[:, None, :] / scale[:, None, None]
        ratio = np.linalg.norm(nearest[surface, 1:], axis=1) / size[surface]
        across = np.eye(d - 1) - unit[:, :, None] * unit[:, None, :]
        slope[surface, 1:, 1:] += ratio[:, None, None] * across
        return nearest, slope
