"""Structure: what every family of blocks has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from masonry_fem.records.mesh_settings import MeshSettings
from masonry_fem.records.record import Fidelity, Name, Spec


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


@dataclass(frozen=True, slots=True)
class ProblemFile:
    """A file that may say of blocks, besides their shapes, how they are held, loaded and joined.

    Attributes
    ----------
    path : Relative to the scene file.
    scale : Factor from its unit of length to the metre.
    """

    path: str
    scale: float


class Structure(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What every structure has; a structure that is read from a file names it by its key ``path``.

    Attributes
    ----------
    name : its name, with which names of its blocks begin
    material : name of a table in ``materials``
    fidelity : in place of the scene's
    mesh : in place of the scene's
    """

    endings: ClassVar[tuple[str, ...]] = ()  # of the files that it may be read from

    name: Name
    material: str
    fidelity: Fidelity | None = None
    mesh: MeshSettings | None = None

    @property
    def carries(self) -> bool:
        """True where it brings supports of its own, as with a key ``ground``."""
        return bool(getattr(self, "ground", False))

    @property
    def source(self) -> str | None:
        """The file that it is read from; None where its keys tell all."""
        return None

    @property
    def problem(self) -> ProblemFile | None:
        """The file whose supports, friction and loads complete the scene; None where there is none."""
        return None

    def blocks_alone(self) -> Self:
        """The same without a ``problem``."""
        return self

    def foreseen(self, dimension: int) -> Foreseen | None:
        """Expected number of blocks by its keys; None if a file decides."""
        return None
