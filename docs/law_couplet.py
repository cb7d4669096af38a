"""Couplet: the tests that a joint on a page of docs/laws is put through, at one contact point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from masonry_fem.joints import History, Law, probe, pull

MACHINE = 1e13  # stiffness of the testing machine, for joints that are rigid until they break [N/m³]
FIRST = 1e-9  # first move of a test: 0.01 MPa by the machine [m]
MICRO, MEGA = 1e-6, 1e6
FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Specimen:
    """What the joint of a page is put through.

    Attributes
    ----------
    panels : What is drawn. opening, slide : How far it is pulled open and sheared [m].
    pressures : Of the shear tests [Pa].
    rigid : Driven by a stiff machine; for a joint that is rigid until it breaks.
    """

    panels: tuple[Callable[[Axes, Law, Specimen], None], ...]
    opening: float = 150e-6
    slide: float = 700e-6
    pressures: tuple[float, ...] = (0.1e6, 0.3e6, 0.5e6)
    rigid: bool = False


def tension(law: Law, tests: Specimen, path: FloatArray) -> History:
    """A pull along openings [m], shape (n,)."""
    jumps = np.stack([path, 0 * path], axis=1)
    return pull(law, jumps, MACHINE) if tests.rigid else probe(law, jumps)


def shear(law: Law, tests: Specimen, path: FloatArray, pressure: float) -> History:
    """A shear test along slides [m], shape (n,), under a pressure [Pa]."""
    if tests.rigid:
        return pull(law, np.stack([0 * path - pressure / MACHINE, path], axis=1), MACHINE)
    return probe(law, np.stack([0 * path, path], axis=1), pressure=pressure)


def growing(end: float, steps: int = 250) -> FloatArray:
    """From nothing to ``end``, finest at the start, shape (steps,)."""
    return np.geomspace(min(end / 2000, FIRST), end, steps)


def loaded(test: Callable[[FloatArray], History], end: float, axis: int) -> History:
    """A monotonic test in fine steps about the greatest stress along ``axis``."""
    path = growing(end)
    peak = int(np.clip(test(path).stress[:, axis].argmax(), 1, len(path) - 2))
    about = np.linspace(path[peak - 1], path[peak + 1], 300)
    return test(np.concatenate([path[: peak - 1], about, path[peak + 2 :]]))


def turning(*ends: float, steps: int = 150) -> FloatArray:
    """To and fro between ends, from 0; finest where it turns."""
    ease = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, steps + 1)[1:]))
    return np.concatenate([growing(ends[0]), *(a + (b - a) * ease for a, b in pairwise(ends))])
