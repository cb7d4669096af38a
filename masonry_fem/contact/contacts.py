"""Contacts: where blocks touch, as arrays, whose rows stay the same from step to step.

The rows of a contact's frame are (n, t1[, t2]), right-handed, n from the antagonist to the candidate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy import sparse


FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Interface:
    """Common part of the faces of two blocks; its two sides are called candidate and antagonist.

    Attributes
    ----------
    blocks : Candidate and antagonist block numbers; the candidate is the later block of the
        assembly, except that a support, or a face that carries a tilted one, is the antagonist.
    faces : Their polytope faces.
    normal : Unit normal from the antagonist to the candidate, shape (d,).
    polygon : Intersection of the two faces projected onto the common plane, counter-clockwise about
        the normal (two end points in 2D), shape (k, d) [m]; one point, or two in 3D, where a
        corner or an edge stands on a face (area 0).
    gap : Signed distance of the two faces at the polygon's corners, > 0 open, shape (k,) [m].
    area : Area of the polygon [m²; m in 2D].
    label : Joint label of the faces ("" where they have none or differ); name of a tie.
    tie : Whether it is no common face, but a tie between two points of the blocks (faces −1).
    """

    blocks: tuple[int, int]
    faces: tuple[int, int]
    normal: FloatArray
    polygon: FloatArray
    gap: FloatArray
    area: float
    label: str
    tie: bool = False


@dataclass(frozen=True, slots=True)
class Contacts:
    """c contact points in the reference configuration, world coordinates.

    A *mean* contact (placement ``weighted``) stands for a part of the interface, at the mean of its points.

    Attributes
    ----------
    blocks : Candidate and antagonist block of each contact, shape (c, 2); exchanged against the
        interface's where the placement rule needs the finer mesh on the candidate.
    interface : Index of the interface each belongs to, shape (c,).
    points : Material point on the candidate and on the antagonist [m], shape (c, 2, d); they
        differ by ``gap`` along the normal, on round faces by ``gap + bulge`` and, by less, across it.
    facets : Mesh facet of the shape of each side that carries the point, −1 where that shape has
        no mesh, shape (c, 2).
    frame : Local frames, rows (n, t1[, t2]), right-handed, n towards the candidate, (c, d, d).
    gap : Signed distance [m], shape (c,).
    area : Tributary area [m²; m in 2D]; sums to the interface's area, shape (c,).
    means : Weights of the mesh nodes on each side of mean contacts, rows 2 i + side, shape (2c, nodes of the
        largest mesh); other rows are empty. None: there are no mean contacts.
    bulge : By how much nearer two round faces are than their flat facets, at mean contacts: the distance of
        the points along the normal, less ``gap``, shape (c,) [m]; None: 0. Of a tie it is minus its length
        without force.
    ties : True for contacts that are ties, whose normals always lead from the candidate's point to the
        antagonist's, shape (c,); None: there are none.
    """

    blocks: IntArray
    interface: IntArray
    points: FloatArray
    facets: IntArray
    frame: FloatArray
    gap: FloatArray
    area: FloatArray
    means: sparse.csr_array | None = None
    bulge: FloatArray | None = None
    ties: NDArray[np.bool_] | None = None

    @property
    def count(self) -> int:
        """Number of contacts."""
        return int(self.gap.shape[0])

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.frame.shape[1])

    @property
    def tied(self) -> NDArray[np.bool_]:
        """Which of them are ties, shape (c,)."""
        return np.zeros(self.count, dtype=bool) if self.ties is None else self.ties


def local_frames(normals: FloatArray) -> FloatArray:
    """Right-handed frames (n, t1[, t2]) on unit normals (c, d), shape (c, d, d).

    In 3D t1 is the projection of the world axis that is most across n, the first of them where
    several are (compared to six digits, so that rounding does not choose).
    """
    count, d = normals.shape
    frames = np.empty((count, d, d))
    frames[:, 0] = normals
    if d == 2:
        frames[:, 1, 0], frames[:, 1, 1] = -normals[:, 1], normals[:, 0]
        return frames
    axis = np.eye(3)[np.round(np.abs(normals), 6).argmin(axis=1)]
    across = axis - np.einsum("ci,ci->c", axis, normals)[:, None] * normals
    frames[:, 1] = across / np.linalg.norm(across, axis=1)[:, None]
    frames[:, 2] = np.cross(frames[:, 0], frames[:, 1])
    return frames


def height(points: FloatArray, normals: FloatArray, on_plane: FloatArray, plane: FloatArray) -> FloatArray:
    """How far points are from planes, measured along given directions [m].

    Parameters
    ----------
    points : Shape (..., d) [m].
    normals : Unit vectors to measure along, shape (..., d).
    on_plane : A point of each plane, shape (..., d) [m].
    plane : Normal of each plane, shape (..., d).

    Returns
    -------
    Shape (...,); positive where the plane lies ahead in the direction of ``normals``.
    """
    ahead = np.einsum("...a,...a->...", on_plane - points, plane)
    result: FloatArray = ahead / np.einsum("...a,...a->...", normals, plane)
    return result
