"""Mesh settings: how elastic blocks are divided into elements."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.records.record import Divisions, Element, Length, Spec


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions.

    Attributes
    ----------
    element : Q are quadrangles and hexahedra, P triangles and tetrahedra; 1 is linear, 2 quadratic. Without
        it Q1, and for a ``.geo`` or ``.step`` file the order that the file asks for
    size : wanted length of an element's edge [m], whatever the unit of a file
    divisions : numbers of elements along the block's axes (arch: along the arc, depth, thickness; dome: along
        the parallel, the meridian, the thickness)
    """

    element: Element | None = None
    size: Length | None = None
    divisions: Divisions | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Both a size and numbers."""
        if self.size is not None and self.divisions is not None:
            yield "divisions", "none beside 'size': take one of them"

    @property
    def elements(self) -> Element:
        """The element that is asked for, Q1 where none is."""
        return self.element or "Q1"
