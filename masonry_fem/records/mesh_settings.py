"""Mesh settings: how elastic blocks are divided into elements."""

from __future__ import annotations

from masonry_fem.records.record import Divisions, Element, Length, Spec


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions."""

    element: Element | None = None
    size: Length | None = None
    divisions: Divisions | None = None

    @property
    def elements(self) -> Element:
        """The element that is asked for, Q1 where none is."""
        return self.element or "Q1"
