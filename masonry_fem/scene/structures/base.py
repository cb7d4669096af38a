"""Structure: what every family of blocks has, and how its elastic blocks are meshed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from masonry_fem.scene.record import Divisions, Element, Fidelity, Length, Name, Spec


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions."""

    element: Element | None = None
    size: Length | None = None
    divisions: Divisions | None = None

    @property
    def elements(self) -> Element:
        """The element that is asked for, Q1 where none is."""
        return self.element or "Q1"


@dataclass(frozen=True, slots=True)
class Foreseen:
    """What a structure will be made of, told from its keys before anything is built.

    Attributes
    ----------
    blocks : How many, supports among them; exact, or within half as much again where bricks are cut.
    keys : The keys that this number grows with.
    sides : Faces of a block, those that most of them have; 0: six, in 2D four.
    """

    blocks: float
    keys: tuple[str, ...]
    sides: float = 0


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

    def foreseen(self, dimension: int) -> Foreseen | None:
        """How many blocks its keys ask for; None where a file tells."""
        return None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Keys whose values do not go together, or not with the dimension: (key, what was expected).

        What a single value must be stands in its annotation. A key within a table is ``openings.0.size``.
        """
        return iter(())
