"""Stress error: what the estimates of the blocks' stresses say, by block and in all.

errors = block_errors(model, state)
errors.relative                       # 0.12: the stress is 12 % off, in the energy norm
told(errors, model)                   # for summary.json
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

TOP = 5


@dataclass(frozen=True, slots=True)
class BlockErrors:
    """Estimated errors of k blocks that have stresses, as squares of energy norms.

    Attributes
    ----------
    block : Their numbers in the assembly, shape (k,).
    square : e², estimated error of the stress [J], shape (k,).
    norm : ‖u_h‖², twice the strain energy [J], shape (k,).
    volume : Of the blocks [m³; m² in 2D], shape (k,).
    """

    block: IntArray
    square: FloatArray
    norm: FloatArray
    volume: FloatArray

    @property
    def total(self) -> float:
        """‖u_h‖² + e² of all blocks: what the exact solution's energy norm is about, squared [J]."""
        return float(self.norm.sum() + self.square.sum())

    @property
    def relative(self) -> float:
        """√(e² / (‖u_h‖² + e²)) of all blocks; 0 where nothing is strained."""
        return float(np.sqrt(self.square.sum() / self.total)) if self.total > 0 else 0.0

    @property
    def share(self) -> FloatArray:
        """Part of e² that each block has, shape (k,)."""
        return _ratio(self.square, float(self.square.sum()))

    @property
    def of_whole(self) -> FloatArray:
        """Error of each block relative to the energy norm of all, shape (k,)."""
        return np.sqrt(_ratio(self.square, self.total))

    @property
    def of_mean(self) -> FloatArray:
        """Error density of each block relative to the mean density of all, in norms, shape (k,)."""
        return np.sqrt(_ratio(self.square / self.volume, self.total / float(self.volume.sum())))


def block_errors(model: Model, state: SystemState) -> BlockErrors | None:
    """Estimated errors of the blocks that have stresses; None where none has.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    found = []
    for group, moved in zip(model.groups, state.bodies, strict=True):
        error = group.stress_error(moved)
        if error is not None:
            volume = np.full(len(group.blocks), error.volume.sum())
            found.append((group.blocks, error.squares.sum(axis=1), error.norm, volume))
    if not found:
        return None
    return BlockErrors(*(np.concatenate(part) for part in zip(*found, strict=True)))


def unjudged(errors: BlockErrors, model: Model) -> Mask:
    """Blocks one linear element thick, shape (k,): nothing in them shows how wrong their elements are.

    Parameters
    ----------
    errors : Of k blocks.
    model : The structure.
    """
    thin = np.array([
        shape.mesh is not None
        and shape.mesh.order == 1
        and len(np.unique(shape.mesh.facets)) == len(shape.mesh.points)
        for shape in model.assembly.shapes
    ])  # fmt: skip
    told: Mask = thin[model.assembly.blocks.shape[errors.block]]
    return told


def by_modes(errors: BlockErrors, model: Model) -> Mask:
    """Blocks that deform by a few modes, shape (k,): finer elements change nothing of them.

    Parameters
    ----------
    errors : Of k blocks.
    model : The structure.
    """
    reduced = [group.blocks for group in model.groups if group.deforms and group.modal]
    found: Mask = np.isin(errors.block, np.concatenate([np.zeros(0, np.int64), *reduced]))
    return found


class BlockError(Told, frozen=True, kw_only=True):
    """``share`` of e², error ``relative`` to the norm of all, ``density`` relative to the mean one."""

    block: str
    share: float
    relative: float
    density: float


class StressError(Told, frozen=True, kw_only=True):
    """Estimated error of the stress.

    Attributes
    ----------
    relative : Of all blocks, in the energy norm, relative to the norm of the exact stress.
    unjudged : Number of blocks one linear element thick, whose error cannot be estimated.
    reduced : Share of its square that reduced blocks have.
    worst : Blocks with the largest errors.
    """

    relative: float
    unjudged: int
    reduced: float
    worst: tuple[BlockError, ...]


def told(errors: BlockErrors, model: Model) -> StressError:
    """What ``summary.json`` says of the errors.

    Parameters
    ----------
    errors : Of the blocks that have stresses.
    model : The structure, which has the blocks' names.
    """
    names = model.assembly.blocks.names
    share, whole, mean = (values.tolist() for values in (errors.share, errors.of_whole, errors.of_mean))
    worst = np.argsort(-errors.share, kind="stable")[:TOP].tolist()
    return StressError(
        relative=errors.relative,
        unjudged=int(unjudged(errors, model).sum()),
        reduced=float(errors.share[by_modes(errors, model)].sum()),
        worst=tuple(
            BlockError(block=names[errors.block[i]], share=share[i], relative=whole[i], density=mean[i])
            for i in worst
        ),
    )


def _ratio(part: FloatArray, whole: float) -> FloatArray:
    ratio: FloatArray = part / whole if whole > 0 else np.zeros_like(part)
    return ratio
