"""Compatibility: the one file that knows which DOLFINx is installed (0.9 to 0.11).

The PyPI wheel ``dolfinx-solver-real`` keeps PETSc and MPI in a package of its own, whose loader
must be imported before DOLFINx; the DOLFINx packages of apt and conda have no such package.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import InstallationError

__all__ = [
    "assemble", "basix", "create_mesh", "dolfinx", "geometry_dofmap", "lagrange_element", "ufl",
]  # fmt: skip

try:
    if importlib.util.find_spec("dolfinx_solver") is not None:
        importlib.import_module("dolfinx_solver")
    import basix
    import basix.ufl
    import dolfinx
    import dolfinx.fem
    import dolfinx.mesh
    import ufl
    from mpi4py import MPI
except (ImportError, RuntimeError) as missing:  # mpi4py without an MPI library is a RuntimeError
    reason = str(missing).partition("\n")[0]
    raise InstallationError(
        f"DOLFINx cannot be imported ({reason}); elastic blocks need DOLFINx 0.9 or later: "
        "pip install 'masonry-fem[fenicsx]', or apt install python3-dolfinx on Debian 13"
    ) from missing

VERSION: tuple[int, ...] = tuple(int(number) for number in re.findall(r"\d+", dolfinx.__version__)[:2])
if VERSION < (0, 9):
    raise InstallationError(
        f"DOLFINx is {dolfinx.__version__}, expected 0.9 or later; install the wheel with "
        "pip install 'masonry-fem[fenicsx]', or use Debian 13's python3-dolfinx"
    )


def lagrange_element(cell: str, order: int, dimension: int) -> Any:
    """Vector Lagrange element, for coordinates and displacements alike.

    Parameters
    ----------
    cell : Name of the cell in DOLFINx (``quadrilateral``, not ``quad``).
    order : 1 or 2.
    dimension : Number of components.
    """
    return basix.ufl.element("Lagrange", cell, order, shape=(dimension,))


def create_mesh(cells: NDArray[np.int64], points: NDArray[np.float64], element: Any) -> Any:
    """DOLFINx mesh of this process alone.

    Parameters
    ----------
    cells : Node numbers in DOLFINx's order, shape (m, nodes of a cell).
    points : Coordinates, shape (n, d) [m].
    element : Element of the coordinates, as ``lagrange_element`` makes it.
    """
    # 0.10 swapped e and x; their names stayed
    return dolfinx.mesh.create_mesh(MPI.COMM_SELF, cells=cells, e=ufl.Mesh(element), x=points)


def geometry_dofmap(mesh: Any) -> NDArray[np.int64]:
    """Geometry node numbers by cell, shape (cells, nodes)."""
    geometry = mesh.geometry
    if not hasattr(geometry, "dofmaps"):
        return np.asarray(geometry.dofmap, dtype=np.int64)
    maps = geometry.dofmaps  # a method of a cell type's index, or a property, by version
    return np.asarray(maps(0) if callable(maps) else maps[0], dtype=np.int64)


def assemble(form: Any) -> Any:
    """Assembled bilinear form as SciPy CSR, all entries of the sparsity pattern stored."""
    matrix = dolfinx.fem.assemble_matrix(dolfinx.fem.form(form))
    matrix.scatter_reverse()
    return matrix.to_scipy().tocsr()
