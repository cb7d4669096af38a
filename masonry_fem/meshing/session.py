"""Session: gmsh for as long as it is needed, and its elements as arrays in VTK's order."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_fem.errors import GeometryError, InstallationError
from masonry_fem.host import installation
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

# gmsh's element types: name here, and gmsh's node numbers in VTK's order
KINDS: dict[int, tuple[str, tuple[int, ...]]] = {
    1: ("line", (0, 1)),
    2: ("triangle", (0, 1, 2)),
    3: ("quad", (0, 1, 2, 3)),
    4: ("tetra", (0, 1, 2, 3)),
    5: ("hexahedron", tuple(range(8))),
    8: ("line3", (0, 1, 2)),
    9: ("triangle6", tuple(range(6))),
    10: ("quad9", tuple(range(9))),
    11: ("tetra10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    12: (
        "hexahedron27",
        (*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26),
    ),
}


@contextmanager
def session(title: str) -> Iterator[Any]:
    """The gmsh module with an empty quiet model.

    Parameters
    ----------
    title : Names what is being read or meshed, for messages.

    Raises
    ------
    GeometryError : gmsh has failed; errors of other kinds pass unchanged.
    """
    gmsh = _loaded(title)
    gmsh.initialize(argv=[], readConfigFiles=False, run=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)  # makes meshes reproducible
        gmsh.logger.start()
        yield gmsh
    except UnicodeDecodeError as error:  # names that the module hands over
        raise GeometryError(
            f"{title} holds a name that is not in UTF-8 ({error}), expected names in it; save the file so"
        ) from error
    except Exception as error:
        if type(error) is not Exception:  # gmsh raises plain Exception; anything else is a defect of our own
            raise
        said = [line.split(":", 1)[-1].strip() for line in gmsh.logger.get() if line.startswith("Error")]
        words = [one for one in (*said, str(error)) if one]
        raise GeometryError(
            f"{title}: gmsh stopped with: {words[0]}; open the geometry in gmsh and correct it there"
            if words
            else f"{title}: gmsh stopped without a word, mostly for want of memory; give it more "
            "(reading.memory), or make the file smaller"
        ) from error
    finally:
        gmsh.logger.stop()  # otherwise the errors of one file are reported for the next one, too
        gmsh.finalize()


def _loaded(title: str) -> Any:
    """The gmsh module, or an error that says what to install."""
    installation.require_extra("gmsh", f"{title} cannot be read or meshed")
    try:
        import gmsh  # noqa: PLC0415  loaded by scenes that mesh or import only
    except OSError as error:  # the libraries that gmsh draws with are not in its wheel
        raise InstallationError(
            f"{title} cannot be read or meshed: gmsh cannot be loaded ({error}); {installation.GMSH_CURE}"
        ) from error
    return gmsh


@dataclass(frozen=True, slots=True)
class Elements:
    """Elements of some gmsh entities.

    Attributes
    ----------
    kind : Their kind, as in ``solid.mesh``. nodes : gmsh's node tags in VTK's order, shape (m, k).
    """

    kind: str
    nodes: IntArray


def elements_of(gmsh: Any, dimension: int, entities: list[int], what: str) -> Elements | None:
    """Elements of all given entities, of one kind; None where there are none.

    Parameters
    ----------
    gmsh : The module, within a ``session``.
    dimension : Of the entities: 3 for volumes, 2 for surfaces, 1 for curves.
    entities : Their tags.
    what : What is being read or meshed, for error messages.

    Raises
    ------
    GeometryError : Elements are mixed, incomplete (serendipity), or of order above 2.
    """
    found: dict[int, list[IntArray]] = {}
    for entity in entities:
        kinds, _, nodes = gmsh.model.mesh.getElements(dimension, entity)
        for kind, flat in zip(kinds, nodes, strict=True):
            if kind not in KINDS:
                name = gmsh.model.mesh.getElementProperties(int(kind))[0]
                raise GeometryError(
                    f"{what} has elements '{name}', expected triangles, quadrangles, tetrahedra or "
                    "hexahedra of order 1, or complete ones of order 2; mesh it again "
                    "(Mesh.SecondOrderIncomplete = 0)"
                )
            count = len(KINDS[kind][1])
            found.setdefault(int(kind), []).append(np.array(flat, dtype=np.int64).reshape(-1, count))
    if not found:
        return None
    if len(found) > 1:
        names = ", ".join(KINDS[kind][0] for kind in sorted(found))
        raise GeometryError(
            f"{what} mixes elements ({names}), expected one kind in a block; mesh it with one kind"
        )
    ((kind, parts),) = found.items()
    name, order = KINDS[kind]
    return Elements(name, np.concatenate(parts)[:, list(order)])


def node_positions(gmsh: Any) -> tuple[IntArray, FloatArray]:
    """All node tags, ascending, and their positions, shape (n, 3)."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    return np.array(tags, dtype=np.int64)[order], np.array(coordinates).reshape(-1, 3)[order]
