"""Faceted: a curved shape with the facets that its elements have.

Solids have arcs and other curves in flat facets, as many as rigid blocks need. A mesh has others: contacts
lie on faces, and need each face of a meshed block to be a whole number of facets of its mesh.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from masonry_fem.meshing.mesher import along_curves, divisions_along, is_curved
from masonry_fem.records.structure import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

type Loop = tuple[int, ...]


def faceted(shape: Shape, settings: MeshSettings) -> tuple[Shape, IntArray]:
    """The shape with one facet for each element along its curves, where elements do not divide its facets.

    Parameters
    ----------
    shape : A shape that has not been meshed.
    settings : Element, and size or divisions.

    Returns
    -------
    The shape, and which of the old faces each of its faces comes from: those of one curved side all come from
    the first that it had.
    """
    same = np.arange(len(shape.solid.faces))
    if not is_curved(shape):
        return shape, same
    count = divisions_along(shape, settings)
    bent = _undivided(shape, count)
    if not bent:
        return shape, same
    at = along_curves(shape, np.linspace(0.0, 1.0, count + 1))
    inner = {chain: at[curve][1:-1] for chain, curve in bent.items()}
    points, number, of = _vertices(shape.solid.vertices, inner)
    faces = _Faces(bent, number, of, count)
    for old in same.tolist():
        faces.take(shape.solid, old)
    made = Polytope(points, tuple(faces.loops), tuple(faces.names), tuple(faces.labels))
    arcs = tuple((number[a], number[b], centre) for a, b, centre in shape.arcs)
    rails = tuple(of[rail] if rail in of else tuple(number[v] for v in rail) for rail in shape.rails)
    return replace(shape, solid=made, arcs=arcs, rails=rails), np.array(faces.origin)


def _undivided(shape: Shape, count: int) -> dict[Loop, int]:
    """Vertices of the curves whose facets ``count`` elements do not divide, and the curves' numbers."""
    chains = shape.rails or tuple(tuple(range(a, b + 1)) for a, b, _ in shape.arcs)
    return {chain: curve for curve, chain in enumerate(chains) if count % (len(chain) - 1)}


def _vertices(
    old: FloatArray, inner: dict[Loop, FloatArray]
) -> tuple[FloatArray, dict[int, int], dict[Loop, Loop]]:
    """New vertices in the old order, new numbers of the old ones that stay, and the new chains by the old."""
    within = {vertex: chain for chain in inner for vertex in chain[1:-1]}
    points: list[FloatArray] = []
    number: dict[int, int] = {}
    middle: dict[Loop, list[int]] = {}
    for vertex, point in enumerate(old):
        chain = within.get(vertex)
        if chain is None:
            number[vertex] = len(points)
            points.append(point)
        elif chain not in middle:
            fresh = range(len(points), len(points) + len(inner[chain]))
            forward = chain[0] < chain[-1]
            points.extend(inner[chain] if forward else inner[chain][::-1])
            middle[chain] = list(fresh if forward else reversed(fresh))
    of = {chain: (number[chain[0]], *own, number[chain[-1]]) for chain, own in middle.items()}
    return np.array(points), number, of


class _Faces:
    """Faces of the new solid: strips between its curves, and the others with their curves replaced."""

    def __init__(
        self, bent: Iterable[Loop], number: dict[int, int], of: dict[Loop, Loop], count: int
    ) -> None:
        self.loops: list[Loop] = []
        self.names: list[str] = []
        self.labels: list[str] = []
        self.origin: list[int] = []
        self._number, self._of, self._count = number, of, count
        self._place = {vertex: (chain, k) for chain in bent for k, vertex in enumerate(chain)}

    def take(self, solid: Polytope, old: int) -> None:
        """Add what becomes of an old face."""
        loops = self._loops(solid.faces[old])
        self.loops += loops
        self.names += [solid.names[old]] * len(loops)
        self.labels += [solid.labels[old]] * len(loops)
        self.origin += [old] * len(loops)

    def _loops(self, face: Loop) -> list[Loop]:
        """What becomes of a face; of the facets of one curved side the first makes all."""
        known = [self._place[vertex] for vertex in face if vertex in self._place]
        lowest = {chain: min(k for own, k in known if own == chain) for chain, _ in known}
        strip = len(known) == len(face) == 2 * len(lowest) and all(
            k - lowest[chain] <= 1 for chain, k in known
        )
        if not strip:
            return [self._replaced(face)]
        if any(lowest.values()):
            return []
        return [tuple(self._of[chain][k + own] for chain, own in known) for k in range(self._count)]

    def _replaced(self, face: Loop) -> Loop:
        """A loop with the new chains in place of those that it follows."""
        found: list[int] = []
        for vertex, after in zip(face, (*face[1:], face[0]), strict=True):
            if vertex not in self._number:
                continue
            found.append(self._number[vertex])
            chain, k = self._place.get(after, ((), 0))
            if vertex in chain and after not in self._number:
                own = self._of[chain]
                found += own[1:-1] if k == 1 else own[-2:0:-1]
        return tuple(found)
