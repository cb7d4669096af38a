"""Fidelities: how stones are modelled, one file for each way: rigid, reduced, elastic, inelastic.

    fidelity("elastic").groups(given)       # the bodies of all stones of this fidelity

A file has one class derived from ``Fidelity``; they are listed nowhere. A file imports what it needs when it
makes bodies, so that other scenes never load it.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, ClassVar, Literal

from masonry_fem.errors import SceneError
from masonry_fem.records import discovery

if TYPE_CHECKING:
    from masonry_fem.bodies.base import BodyGroup
    from masonry_fem.bodies.support import Clamp
    from masonry_fem.fem.material_law import MaterialLaw
    from masonry_fem.scene.specs import Material
    from masonry_fem.solid.assembly import Assembly
    from masonry_fem.solid.mesh import IntArray


@dataclass(frozen=True, slots=True)
class Given:
    """What a fidelity makes its bodies from: its stones, and what the scene says of them.

    Attributes
    ----------
    assembly : Blocks and shapes; shapes of stones that deform are meshed.
    materials : Material of each block of this fidelity, by block number, ascending.
    clamps : Held faces, by block; only of blocks that deform.
    plane : Plane strain or plane stress; None in 3D.
    lumped : Whether the mass matrix is diagonal instead of consistent.
    turns : Whether rotations are finite; if not, equations are those of the undeformed structure.
    law : Makes the inelastic law of a material that has one.
    before : Groups of this fidelity from the same scene with other meshes; parts that fit are used again.
    warming : Thermal strains, each with its factor as a function of time, by block that deforms.
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
    """Base class of fidelities, the ways in which stones are modelled.

    Attributes
    ----------
    name : Its name in scene files, and ``kind`` of its groups.
    rank : Its place in the order from coarse to fine, in which a study runs them.
    deforms : Whether its stones are meshed, need Young's modulus, and can be held by single faces.
    yields : Whether its materials need an ``inelastic`` law.
    """

    name: ClassVar[str | None] = None
    rank: ClassVar[float]
    deforms: ClassVar[bool]
    yields: ClassVar[bool] = False

    @classmethod
    def skin(cls, material: Material) -> float:
        """Thickness of an elastic layer in series with the joints, in widths of the common face.

        It stands for the deformation near a contact that the stones' own modes of deformation leave out.
        """
        return 0.0

    @classmethod
    def placement(cls, material: Material) -> str:
        """The rule that places contact points between its stones where the scene names none."""
        return "auto"

    @classmethod
    def load(cls) -> None:
        """Import what ``groups`` needs; raise InstallationError if a library is missing."""

    @classmethod
    @abstractmethod
    def groups(cls, given: Given) -> Sequence[BodyGroup]:
        """The bodies of all stones of this fidelity."""


def names() -> tuple[str, ...]:
    """Names of all fidelities in scene files, in alphabetical order; none is loaded."""
    return discovery.names(__path__)


@cache
def fidelity(name: str) -> type[Fidelity]:
    """The fidelity with a name.

    Raises
    ------
    SceneError : There is none with this name.
    """
    if name not in names():
        expected = ", ".join(map(repr, names()))
        raise SceneError(f"fidelity is {name!r}, expected one of {expected}; files of masonry_fem/fidelities")
    naming = 'write name = "{name}" into {kind}'
    kind: type[Fidelity] = discovery.discovered(
        __name__, name, Fidelity, "fidelity", lambda kind: kind.name, naming
    ).kind
    return kind


def fidelities() -> Mapping[str, type[Fidelity]]:
    """Every fidelity by its name in scene files, the coarsest first."""
    return {name: fidelity(name) for name in sorted(names(), key=lambda name: fidelity(name).rank)}


def distinct(given: Given) -> tuple[list[Material], IntArray]:
    """The materials of b stones, each once, and the number of each stone's among them, shape (b,).

    Parameters
    ----------
    given : The stones.
    """
    import numpy as np  # noqa: PLC0415 - a scene is read without it

    stones = given.materials.values()
    kinds = dict(zip(map(id, stones), stones, strict=True))
    number = {key: at for at, key in enumerate(kinds)}
    return list(kinds.values()), np.fromiter(map(number.__getitem__, map(id, stones)), np.int64)


def deforms(name: str | None) -> bool:
    """Whether stones of a fidelity deform; None stands for supports, which do not."""
    return name is not None and fidelity(name).deforms
