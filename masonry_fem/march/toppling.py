"""Toppling: whether a stone has fallen over or down in a march in time, which itself only says "finished".

    march(model, dynamics, settings, observers=[Toppling(model, bodies, gravity)])   # raises ToppledError

A stone has fallen once it leans by more than 45° from how it stood, or has sunk by more than its height.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step_report import StepReport

FloatArray = NDArray[np.float64]

LEANS = math.radians(45.0)  # of a stone that no ground shakes back upright


class ToppledError(Exception):
    """A stone has fallen.

    Attributes
    ----------
    model, state : The structure then.
    """

    def __init__(self, what: str, model: Model, state: SystemState) -> None:
        super().__init__(what)
        self.model, self.state = model, state


class Toppling:
    """Observer of a march that ends it as soon as a stone has fallen.

    Parameters
    ----------
    model : The structure.
    bodies : States in which its stones stand, one a group.
    gravity : Acceleration of gravity, shape (d,) [m/s²]; without any the last axis points up.

    Raises
    ------
    ToppledError : From ``record``: a stone has fallen.
    """

    def __init__(self, model: Model, bodies: Sequence[Any], gravity: Sequence[float] | None) -> None:
        d = model.assembly.dimension
        pull = np.zeros(d) if gravity is None else np.array(gravity, dtype=float)
        size = float(np.linalg.norm(pull))
        self._up = -pull / size if size else np.eye(d)[-1]
        self._names = model.assembly.blocks.names
        self._free = [
            (index, _Posture(group, state, self._up))
            for index, (group, state) in enumerate(zip(model.groups, bodies, strict=True))
            if not group.prescribed
        ]
        self._most = [np.zeros(len(model.groups[index].blocks)) for index, _ in self._free]
        self._blocks = [model.groups[index].blocks for index, _ in self._free]

    @property
    def leans(self) -> dict[str, float]:
        """By how much each stone has leaned at most so far, by its name [rad]."""
        return {
            self._names[int(block)]: float(lean)
            for blocks, most in zip(self._blocks, self._most, strict=True)
            for block, lean in zip(blocks, most, strict=True)
        }

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Look at the stones after a step."""
        for place, (index, posture) in enumerate(self._free):
            lean, sunk = posture.seen(model.groups[index], state.bodies[index])
            self._most[place] = np.maximum(self._most[place], lean)
            for excess, how in ((lean / LEANS, "leans by more than 45°"), (sunk, "has sunk by its height")):
                worst = int(np.argmax(excess))
                if excess[worst] > 1.0:
                    name = self._names[int(model.groups[index].blocks[worst])]
                    raise ToppledError(f"{name} {how} after {report.time:.6g} s", model, state)


class _Posture:
    """How the b stones of a group stood: points about their middles, and heights."""

    def __init__(self, group: BodyGroup, state: Any, up: FloatArray) -> None:
        sizes = np.diff(group.first)
        self._starts, self._owner = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(sizes)), sizes)
        self._sizes, self._up = sizes[:, None], up
        points = group.positions(state)
        self._middle, self._arms = self._about(points)
        along = points @ up
        self._height = np.maximum.reduceat(along, self._starts) - np.minimum.reduceat(along, self._starts)

    def seen(self, group: BodyGroup, state: Any) -> tuple[FloatArray, FloatArray]:
        """By how much stones lean, [rad], and have sunk over their height, both of shape (b,)."""
        middle, arms = self._about(group.positions(state))
        # the rotation nearest to how the points have turned (Kabsch 1976)
        products = np.einsum("vi,vj->vij", arms, self._arms)
        left, _, right = np.linalg.svd(np.add.reduceat(products, self._starts))
        left[..., -1] *= np.linalg.det(left @ right)[:, None]
        upright = np.einsum("i,bij,j->b", self._up, left @ right, self._up)
        lean: FloatArray = np.arccos(np.clip(upright, -1.0, 1.0))
        return lean, ((self._middle - middle) @ self._up) / self._height

    def _about(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        middle = np.add.reduceat(points, self._starts) / self._sizes
        return middle, points - middle[self._owner]
