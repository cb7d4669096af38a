"""Structure: what every family of blocks has, and how its elastic blocks are meshed."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Divisions, Element, Fidelity, Length, Name, Spec


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions."""

    element: Element = "Q1"
    size: Length | None = None
    divisions: Divisions | None = None


class Structure(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What every structure has."""

    name: Name
    material: str
    fidelity: Fidelity | None = None
    mesh: MeshSettings | None = None

    @property
    def carries(self) -> bool:
        """True where it brings supports of its own."""
        return False

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Keys whose values do not go together, or not with the dimension: (key, what was expected).

        What a single value must be stands in its annotation. A key within a table is ``openings.0.size``.
        """
        return iter(())
