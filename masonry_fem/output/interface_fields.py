"""Interface fields: the faces of joints as cells, with their forces, openings and slides.

The field files ``interfaces_*.vtu`` store these named arrays and the pictures of joints read them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.output.fields import ANTAGONIST, CANDIDATE, DISPLACEMENT, INTERFACE, STATUS, Arrays
from masonry_fem.output.grid import POLYGON, VERTEX, three
from masonry_fem.output.interfaces import InterfaceForces

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LINE = 3  # VTK's
FORCE, CENTRE, ECCENTRICITY = "force", "centre_of_pressure", "eccentricity_ratio"
OPENING, SLIDING, SLIDES, KERN, PRESSURE = "opening", "sliding", "slides", "kern", "pressure"
LABEL = "label"


def labels_of(model: Model) -> list[str]:
    """Label of each joint; their numbers are those of the sorted labels."""
    return model.interfaces.label_of_each


@dataclass(frozen=True, slots=True)
class InterfaceFields:
    """Facets as cells over corners of their own; those of a round joint have what it has in common.

    Attributes
    ----------
    points : Corners in the reference configuration, shape (n, 3) [m].
    offsets : End of each face in them, shape (i,). types : VTK cell types, shape (i,).
    corner_arrays : Displacement, opening and sliding [m], shape (n, ...).
    face_arrays : Forces [N], centres of pressure [m] (NaN where none), states, greatest opening and
        sliding [m], shape (i, ...).
    """

    points: FloatArray
    offsets: IntArray
    types: NDArray[np.uint8]
    corner_arrays: Arrays
    face_arrays: Arrays

    @classmethod
    def of(cls, model: Model, told: InterfaceForces) -> InterfaceFields:
        """Those of a model's joints."""
        faces = told.faces
        polygon, of = faces.facets.polygon, faces.facets.joint
        real = np.arange(polygon.shape[1]) < faces.facets.corners[:, None]
        points = three(told.corner_reference[real])
        blocks = model.interfaces.blocks
        size = np.where(faces.size > 0, faces.size, np.inf)
        types = np.where(faces.facets.corners > 2, POLYGON, np.where(faces.facets.corners == 2, LINE, VERTEX))
        return cls(
            points,
            np.cumsum(faces.facets.corners),
            types.astype(np.uint8),
            {
                DISPLACEMENT: three(polygon[real]) - points,
                OPENING: told.corner_opening[real],
                SLIDING: told.corner_sliding[real],
            },
            {
                INTERFACE: faces.first[of],
                LABEL: np.unique(labels_of(model), return_inverse=True)[1],
                CANDIDATE: blocks[:, 0],
                ANTAGONIST: blocks[:, 1],
                STATUS: told.status[of],
                SLIDES: told.slides[of].astype(np.int64),
                FORCE: three(told.force[of]),
                CENTRE: three(told.centre[of]),
                ECCENTRICITY: (told.eccentricity / size)[of],
                KERN: told.kern[of],
                OPENING: told.opening[of],
                SLIDING: told.sliding[of, 1],
                PRESSURE: told.linear.pressure[of],
            },
        )


def interface_name(model: Model, number: int) -> str:
    """Names of candidate and antagonist, and the joint's label.

    Parameters
    ----------
    model : The model.
    number : Of the interface.
    """
    interface = model.interfaces[number]
    candidate, antagonist = (model.assembly.blocks.names[block] for block in interface.blocks)
    label = f" ({interface.label})" if interface.label else ""
    return f"{candidate} / {antagonist}{label}"
