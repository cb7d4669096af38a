"""Structure: what every family of blocks has; elements of those that are elastic; limits on reading files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from msgspec import Meta

from masonry_fem.records.record import Divisions, Element, Fidelity, Length, Memory, Name, Spec


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


@dataclass(frozen=True, slots=True)
class Foreseen:
    """The expected size of a structure, by which one that is too large is refused before it is built.

    Attributes
    ----------
    blocks : Number of blocks, supports included; where bricks are cut it may be up to half as much again.
    keys : Keys on which this number depends, for the message.
    sides : Number of faces that most blocks have; 0: six, in 2D four.
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
    """Base class of structures: a record of their keys, which ``build`` of the same file turns into blocks.

    A structure that is read from a file has the file's path in its key ``path``.

    Attributes
    ----------
    name : its name; the names of its blocks begin with it
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
        """Whether it brings supports of its own; by default the value of its key ``ground``."""
        return bool(getattr(self, "ground", False))

    @property
    def source(self) -> str | None:
        """The file that it is read from; None: there is none."""
        return None

    @property
    def problem(self) -> ProblemFile | None:
        """A file that also has supports, friction and loads for the scene; None: there is none."""
        return None

    def blocks_alone(self) -> Self:
        """The structure without its ``problem``: the blocks only."""
        return self

    def foreseen(self, dimension: int) -> Foreseen | None:
        """Its expected size, computed from its keys; None if a file decides."""
        return None


class Reading(Spec, frozen=True, kw_only=True):
    """Limits on time and memory for reading the files of all structures, and for meshing geometry files.

    Files are read in a process of its own, which is ended when it exceeds a limit.

    Attributes
    ----------
    time : wall-clock time for all files together
    memory : memory beyond what an idle process needs
    """

    time: Annotated[float, Meta(gt=0, le=1e6, extra={"unit": "s"})] = 120.0  # longer waits overflow
    memory: Memory = 4e9
