"""Fidelities: as what stones are computed, one file each: rigid, reduced, elastic, inelastic.

    fidelity("elastic").groups(given)

A file has one class derived from ``Fidelity``; ``fidelities()`` finds it, nothing else lists it. What it
needs beyond NumPy it imports when it makes bodies: scenes that do not ask for it never load it.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, ClassVar, Literal

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.bodies.support import Clamp
from masonry_fem.errors import SceneError
from masonry_fem.records.discovery import discovered
from masonry_fem.solid.assembly import Assembly

if TYPE_CHECKING:
    from masonry_fem.fem.material_law import MaterialLaw
    from masonry_fem.scene.specs import Material


@dataclass(frozen=True, slots=True)
class Given:
    """The stones of one fidelity, and what the scene says of them.

    Attributes
    ----------
    assembly : Blocks and shapes; shapes of stones that deform are meshed.
    materials : Of each block, by its number, ascending: these stones and no others.
    clamps : Held faces of blocks that deform, by block.
    plane : What 2D means. lumped : Diagonal instead of consistent mass.
    turns : Whether equations are to follow stones that turn; else they are those of the reference.
    law : Makes the law by which the stone of a material yields, of those that have one.
    warming : Strains by temperature, each with its factor in time, by block; of blocks that deform only.
    before : Groups that the same fidelity made of the same scene with other meshes, to use again what fits.
    """

    assembly: Assembly
    materials: Mapping[int, Material]
    clamps: Mapping[int, Sequence[Clamp]]
    plane: Literal["strain", "stress"] | None
    lumped: bool
    turns: bool
    law: Callable[[Material], MaterialLaw]
    before: tuple[BodyGroup, ...] = ()
    warming: Mapping[int, Sequence[tuple[float, Callable[[float], float]]]] = field(default_factory=dict)


class Fidelity:
    """As what stones are computed.

    Attributes
    ----------
    name : What scene files call it, and ``kind`` of its groups.
    rank : Place among the others, the coarsest first; a study goes from coarse to fine.
    deforms : Whether stones are meshed, need Young's modulus, and may be held by single faces.
    yields : Whether their materials need an ``inelastic`` law.
    """

    name: ClassVar[str | None] = None
    rank: ClassVar[float]
    deforms: ClassVar[bool]
    yields: ClassVar[bool] = False

    @classmethod
    def skin(cls, material: Material) -> float:
        """Thickness of the layer of themselves that stones have in series with their joints.

        It stands for what their own motions leave out near a contact, in widths of the common face.
        """
        return 0.0

    @classmethod
    def load(cls) -> None:
        """Import what ``groups`` needs; an InstallationError says what is missing."""

    @classmethod
    @abstractmethod
    def groups(cls, given: Given) -> Sequence[BodyGroup]:
        """The bodies of all stones of this fidelity."""


@cache
def fidelities() -> Mapping[str, type[Fidelity]]:
    """Every fidelity by its name in scene files, the coarsest first."""
    naming = 'write name = "..." into {kind}'
    found = discovered(__name__, __path__, Fidelity, "fidelity", lambda kind: kind.name, naming)
    return {name: one.kind for name, one in sorted(found.items(), key=lambda pair: pair[1].kind.rank)}


def names() -> list[str]:
    """What scene files may say."""
    return sorted(fidelities())


def fidelity(name: str) -> type[Fidelity]:
    """The fidelity of a name.

    Raises
    ------
    SceneError : There is none of this name.
    """
    if name not in fidelities():
        expected = ", ".join(map(repr, names()))
        raise SceneError(f"fidelity is {name!r}, expected one of {expected}; files of masonry_fem/fidelities")
    return fidelities()[name]


def deforms(name: str | None) -> bool:
    """Whether stones of a fidelity deform; None is that of supports, which do not."""
    return name is not None and fidelity(name).deforms
