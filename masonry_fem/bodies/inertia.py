"""Inertia: masses, centroids, principal moments and axes of blocks, as arrays.

Exact for flat-faced solids, and computed once for each distinct shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.bodies.rotation import spin_count
from masonry_fem.errors import GeometryError
from masonry_fem.solid.assembly import Assembly


@dataclass(frozen=True, slots=True)
class Inertia:
    """Inertia of b blocks in the reference configuration, world axes.

    Attributes
    ----------
    mass : Masses, shape (b,) [kg; kg per metre of depth in 2D].
    centroid : Centroids, shape (b, d) [m].
    moments : Principal moments about the centroids, shape (b, 1 or 3) [kg m²].
    axes : Principal axes as columns, shape (b, 3, 3); in 2D the normal of the plane, (b, 1, 1).
    """

    mass: FloatArray
    centroid: FloatArray
    moments: FloatArray
    axes: FloatArray


def inertia_of(assembly: Assembly, blocks: IntArray, density: float | FloatArray) -> Inertia:
    """Inertia of blocks of an assembly.

    Parameters
    ----------
    assembly : The structure.
    blocks : Numbers of the blocks, shape (b,).
    density : One for all, or one a block, shape (b,) [kg/m³].

    Raises
    ------
    GeometryError
        If a shape has no volume (its faces are turned inside out), or a density is not positive.
    """
    densities = np.broadcast_to(np.asarray(density, dtype=float), blocks.shape)
    _check_densities(assembly, blocks, densities)
    spins = spin_count(assembly.dimension)
    shapes, of = np.unique(assembly.blocks.shape[blocks], return_inverse=True)
    principal = [_principal(assembly, shape) for shape in shapes.tolist()]
    volume, middle, moments, axes = (np.array(part)[of] for part in zip(*principal, strict=True))
    rotation = assembly.blocks.rotation[blocks]
    centroid = np.einsum("bij,bj->bi", rotation, middle) + assembly.blocks.translation[blocks]
    if spins > 1:
        axes = rotation @ axes
    return Inertia(volume * densities, centroid, moments * densities[:, None], axes)


def _principal(assembly: Assembly, shape: int) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Volume, centroid, principal second moments and axes of one shape, in its own frame."""
    properties = assembly.shapes[shape].solid.mass_properties()
    if not properties.volume > 0:
        raise GeometryError(
            f"shape '{assembly.shapes[shape].name}': volume is {properties.volume:g}, expected > 0; "
            "order each face counter-clockwise seen from outside (2D: outline counter-clockwise)"
        )
    moments, axes = np.linalg.eigh(properties.inertia)
    return properties.volume, properties.centroid, moments, axes


def _check_densities(assembly: Assembly, blocks: IntArray, densities: FloatArray) -> None:
    """Refuse densities that are not positive."""
    wrong = np.flatnonzero(~(densities > 0))
    if wrong.size:
        name = assembly.blocks.names[blocks[wrong[0]]]
        raise GeometryError(
            f"block '{name}': density is {densities[wrong[0]]:g} kg/m³, expected > 0; "
            "give its material a density"
        )
