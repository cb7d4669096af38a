"""Rule: how contact points are placed on an interface, and what a rule gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_fem.contact.placement.parts.patch import Patch
    from masonry_fem.solid.mesh import IntArray
    from masonry_fem.solid.pose import FloatArray


@dataclass(frozen=True, slots=True)
class Rule:
    """How contact points are placed on an interface.

    Attributes
    ----------
    name : Name of a file in ``contact/placement``, such as ``corners``.
    inset : Of ``corners`` and ``navier``: distance of the points from the centroid over that of the corners,
        above 0 and at most 1.
    density : Of ``gauss``: subdivisions along each edge of the face where neither block is meshed.
    """

    name: str = "corners"
    inset: float = 1.0
    density: int = 1


@dataclass(frozen=True, slots=True)
class Means:
    """Weights of mesh nodes whose mean motion is that of a contact, one entry a row; equal ones add.

    Attributes
    ----------
    row : 2 i + side for contact i, side 0 being the candidate, shape (k,).
    node : Node of that side's mesh, shape (k,).
    weight : Its weight; those of a row sum to one, shape (k,).
    """

    row: IntArray
    node: IntArray
    weight: FloatArray


@dataclass(frozen=True, slots=True)
class Round:
    """What m contacts on a round face have of their own, where others have it of the plane of their patch.

    Attributes
    ----------
    patch : The patch, among those that the two faces have in common, that each has most of its area in, (m,).
    frame : Rows (n, t1[, t2]), n being the mean normal, shape (m, d, d).
    points : Mean points of candidate and antagonist, world coordinates, shape (m, 2, d) [m].
    bulge : By how much nearer the faces are in the mean than their facets, shape (m,) [m].
    rise : The largest such distance at a point [m].
    """

    patch: IntArray
    frame: FloatArray
    points: FloatArray
    bulge: FloatArray
    rise: float


@dataclass(frozen=True, slots=True)
class Spots:
    """Contact points that a rule placed on a patch (m of them).

    Attributes
    ----------
    patch : The patch they lie on: the given one, or the same with its sides exchanged.
    points : Coordinates in the common plane, shape (m, d - 1) [m].
    area : Tributary areas, shape (m,) [m²; m in 2D].
    facets : Mesh facets of candidate and antagonist that carry them, −1 where a side is unmeshed,
        shape (m, 2).
    means : For contacts that are no points: how meshed sides carry them, instead of a facet.
    round : For contacts on all patches that two round faces have in common; ``patch`` is the first of these.
    """

    patch: Patch
    points: FloatArray
    area: FloatArray
    facets: IntArray
    means: Means | None = None
    round: Round | None = None
