"""Scenery: what a picture shows, as pyvista data: all blocks with their fields, and the contact points.

It is made from a model and a state, or read from the field files of a results folder, so that results can be
drawn again without their model. ``DeformedShape`` is its surface with amplified displacements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import without_ties
from masonry_fem.output import fields
from masonry_fem.output.grid import POLYHEDRON, Grid, grid_of, three
from masonry_fem.output.interface_fields import InterfaceFields
from masonry_fem.output.interfaces import interface_forces
from masonry_fem.output.sheet import quantity, round_down
from masonry_fem.output.strength import Strengths
from masonry_fem.output.vtu import tie_names

FloatArray = NDArray[np.float64]

ROUNDING = 1e-11  # of the size of a structure: stone strains by 1e-8 and more under its weight


@dataclass(frozen=True)
class Scenery:
    """What pictures show.

    Attributes
    ----------
    blocks : pyvista grid with the arrays of ``fields`` on points and cells.
    contacts : pyvista point cloud with theirs; None where nothing touches.
    ties : The same of ties, whose points are their ends at their candidates; None where there are none.
    dimension : 2 or 3.
    length : A typical block size [m].
    title : First line of each sheet.
    interfaces : pyvista grid of the joints' faces with the arrays of ``interface_fields``; None where
        they were not asked for, or nothing touches.
    """

    blocks: Any
    contacts: Any
    dimension: int
    length: float
    title: str
    interfaces: Any = None
    ties: Any = None

    @classmethod
    def of(
        cls, model: Model, state: SystemState, title: str = "", grid: Grid | None = None, *,
        joints: bool = False, strengths: Strengths | None = None,
    ) -> Scenery:  # fmt: skip
        """Scenery of a model in a state."""
        import pyvista as pv  # noqa: PLC0415  only where pictures are drawn

        grid = grid or grid_of(model)
        blocks = pyvista_grid(grid)
        blocks.point_data.update(fields.point_arrays(grid, model, state))
        blocks.cell_data.update(fields.cell_arrays(grid, model, state))
        for data, block in ((blocks.point_data, grid.point_block), (blocks.cell_data, grid.cell_block)):
            data.update(fields.utilisation_arrays(data, block, strengths))
        contacts = None
        if model.contacts.count:
            contacts = pv.PolyData(three(state.points))
            contacts.point_data.update(fields.contact_arrays(model, state))
            contacts.field_data.update(tie_names(model))
        contacts, ties = without_ends(contacts)
        faces = None
        if joints and contacts is not None:
            alone = without_ties(model, state)
            faces = pyvista_faces(InterfaceFields.of(alone[0], interface_forces(*alone)))
        return cls(blocks, contacts, grid.dimension, model.length, title, faces, ties)

    @property
    def joints(self) -> dict[str, NDArray[Any]]:
        """The arrays of ``interfaces``, a row a joint: facets of one have the same."""
        cells = self.interfaces.cell_data
        first = np.unique(np.asarray(cells[fields.INTERFACE]), return_index=True)[1]
        return {name: np.asarray(cells[name])[first] for name in cells}

    @property
    def force_unit(self) -> str:
        """Unit of reactions: a plane structure has a metre of depth."""
        return "N/m" if self.dimension == 2 else "N"


def without_ends(contacts: Any) -> tuple[Any, Any]:
    """A cloud of contacts parted in those of faces and the ends of ties; None where there are none."""
    if contacts is None or fields.TIE not in contacts.point_data:
        return contacts, None
    tied = np.asarray(contacts.point_data[fields.TIE], float).any(axis=1)
    return _some(contacts, ~tied), _some(contacts, tied)


def _some(cloud: Any, own: NDArray[np.bool_]) -> Any:
    """Some points of a cloud; None: there are none."""
    import pyvista as pv  # noqa: PLC0415

    if not own.any():
        return None
    part = pv.PolyData(np.asarray(cloud.points)[own])
    part.point_data.update({name: np.asarray(cloud.point_data[name])[own] for name in cloud.point_data})
    part.field_data.update(cloud.field_data)
    return part


class DeformedShape:
    """Surface and outline of the blocks, with amplified displacements.

    Parameters
    ----------
    scenery : The blocks.
    amplification : Of displacements; None to choose one.
    """

    def __init__(self, scenery: Scenery, amplification: float | None) -> None:
        grid = scenery.blocks.copy()
        for name in (fields.STRESS, fields.PRINCIPAL, *fields.DIRECTIONS):
            grid.cell_data.pop(name, None)
        self._grid, self.surface = grid, surface_of(grid)
        self.outline = outline_of(self.surface)
        displacement = np.asarray(scenery.blocks.point_data[fields.DISPLACEMENT], float)
        self._greatest = float(np.linalg.norm(displacement, axis=1).max(initial=0.0))
        # who asks for an amplification sees even rounding
        self.moves = amplification is not None or not at_rest(displacement, scenery.blocks.points)
        self.factor = amplification or amplification_of(displacement, np.asarray(scenery.blocks.points))

    def deformed(self) -> Any:
        """The surface, displaced."""
        return self._moved(self.surface)

    def deformed_outline(self) -> Any:
        """The blocks' edges, displaced."""
        return self._moved(self.outline)

    def deformed_elements(self) -> Any:
        """The elements' edges, displaced."""
        return self._moved(element_edges_of(self._grid))

    def extent(self) -> FloatArray:
        """Points before and after, for the view."""
        return np.concatenate([self.surface.points, self.deformed().points])

    def caption(self) -> str:
        """The amplification and the greatest displacement in words."""
        if not self.moves:
            return "No displacement beyond rounding"
        times = f"{self.factor:,.0f}".replace(",", " ") if self.factor >= 10 else f"{self.factor:g}"
        return f"Displacements × {times}; greatest displacement {quantity(self._greatest, 'm')}"

    def _moved(self, mesh: Any) -> Any:
        moved = mesh.copy()
        moved.points = mesh.points + self.factor * np.asarray(mesh.point_data[fields.DISPLACEMENT])
        return moved


def amplification_of(displacement: FloatArray, points: FloatArray) -> float:
    """Factor that shows the greatest displacement at about 5 % of the size: 1, 2 or 5 times a power of ten.

    Parameters
    ----------
    displacement : Of the nodes, shape (n, 3) [m].
    points : The nodes, shape (n, 3) [m].

    Returns
    -------
    The factor, at least 1.
    """
    if at_rest(displacement, points):
        return 1.0
    greatest = float(np.linalg.norm(displacement, axis=1).max(initial=0.0))
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    return max(1.0, round_down(0.07 * size / greatest))


def at_rest(displacement: FloatArray, points: FloatArray) -> bool:
    """Whether displacements are within the solver's rounding errors; amplified, they would show noise.

    Parameters
    ----------
    displacement : Of the nodes, shape (n, 3) [m].
    points : The nodes, shape (n, 3) [m].
    """
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    return float(np.linalg.norm(displacement, axis=1).max(initial=0.0)) <= ROUNDING * size


def pyvista_grid(grid: Grid) -> Any:
    """The grid as pyvista's."""
    import pyvista as pv  # noqa: PLC0415

    starts = np.concatenate([[0], grid.offsets[:-1]])
    cells = np.insert(grid.connectivity, starts, grid.offsets - starts)
    begins, ends = starts + np.arange(len(starts)), grid.offsets + np.arange(1, len(starts) + 1)
    pieces, done, last = [], 0, 0
    for cell in np.flatnonzero(grid.types == POLYHEDRON):  # their nodes give way to their face streams
        stream = grid.faces[last : grid.face_offsets[cell]]
        pieces += [cells[done : begins[cell]], [len(stream)], stream]
        done, last = ends[cell], grid.face_offsets[cell]
    return pv.UnstructuredGrid(np.concatenate([*pieces, cells[done:]]), grid.types, grid.points)


def pyvista_faces(faces: InterfaceFields) -> Any:
    """The faces of joints as a pyvista grid."""
    import pyvista as pv  # noqa: PLC0415

    starts = np.concatenate([[0], faces.offsets[:-1]])
    cells = np.insert(np.arange(len(faces.points)), starts, faces.offsets - starts)
    grid = pv.UnstructuredGrid(cells, faces.types, faces.points)
    grid.point_data.update(faces.corner_arrays)
    grid.cell_data.update(faces.face_arrays)
    return grid


def surface_of(grid: Any) -> Any:
    """Outer faces of a grid; by VTK itself, whose wrapper in pyvista changes from version to version."""
    import pyvista as pv  # noqa: PLC0415
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter  # noqa: PLC0415

    skin = vtkGeometryFilter()
    skin.SetInputData(grid)
    skin.MergingOff()  # blocks that touch stay apart
    skin.SetNonlinearSubdivisionLevel(1)
    skin.Update()
    return pv.wrap(skin.GetOutput())


def outline_of(surface: Any) -> Any:
    """Edges of blocks: where a surface ends or folds by more than 25°."""
    import pyvista as pv  # noqa: PLC0415
    from vtkmodules.vtkCommonDataModel import vtkNonMergingPointLocator  # noqa: PLC0415
    from vtkmodules.vtkFiltersCore import vtkFeatureEdges  # noqa: PLC0415

    edges = vtkFeatureEdges()
    edges.SetInputData(surface)
    edges.SetFeatureAngle(25.0)
    edges.BoundaryEdgesOn()
    edges.FeatureEdgesOn()
    edges.ManifoldEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.ColoringOff()
    edges.SetLocator(vtkNonMergingPointLocator())  # points of two blocks that touch move apart
    edges.Update()
    return pv.wrap(edges.GetOutput())


def element_edges_of(grid: Any) -> Any:
    """Edges of all cells, those of second order as two straight pieces."""
    import pyvista as pv  # noqa: PLC0415
    from vtkmodules.vtkFiltersCore import vtkExtractEdges  # noqa: PLC0415

    edges = vtkExtractEdges()
    edges.SetInputData(grid)
    edges.UseAllPointsOn()  # without merging those of blocks that touch
    edges.Update()
    return pv.wrap(edges.GetOutput())
