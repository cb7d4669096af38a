"""Curve: the mean line of an arch, and the faces that run beside it at an offset.

    line = Ellipse(2.0, 1.0)
    extrados = Offset(line, 0.1)
    extrados.at(np.array([0.0]))        # the crown, [[0, 1.1]]

Curves lie in the arch's plane (x right, y up), run from left to right and have a parameter p each. ``at``
gives points and ``along`` derivatives with respect to p, both of shape (n, 2), ``bend`` the curvature (n,)
[1/m].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from masonry_fem.solid.pose import FloatArray

LEAST = 4 * float(np.finfo(float).eps)  # smallest relative tolerance that SciPy accepts
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


class Line(Protocol):
    """A smooth line by its parameter p, array of shape (n,)."""

    def at(self, p: FloatArray) -> FloatArray:
        """Points, shape (n, 2) [m]."""
        ...

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives by p, shape (n, 2)."""
        ...

    def bend(self, p: FloatArray) -> FloatArray:
        """Curvature, positive where the line turns to the right, shape (n,) [1/m]."""
        ...


@dataclass(frozen=True, slots=True)
class Segment:
    """Straight line through the origin that rises to the right by ``slope`` [rad]; p is its length."""

    slope: float = 0.0

    def at(self, p: FloatArray) -> FloatArray:
        """Points."""
        return p[:, None] * self.along(p)

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives."""
        return np.tile([np.cos(self.slope), np.sin(self.slope)], (len(p), 1))

    def bend(self, p: FloatArray) -> FloatArray:
        """None."""
        return np.zeros(len(p))


@dataclass(frozen=True, slots=True)
class Circle:
    """Circle; p is the angle from the vertical, positive to the right [rad].

    Attributes
    ----------
    radius : [m].
    x, y : Centre [m].
    """

    radius: float
    x: float = 0.0
    y: float = 0.0

    def at(self, p: FloatArray) -> FloatArray:
        """Points."""
        return np.array([self.x, self.y]) + self.radius * np.column_stack([np.sin(p), np.cos(p)])

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives."""
        return self.radius * np.column_stack([np.cos(p), -np.sin(p)])

    def bend(self, p: FloatArray) -> FloatArray:
        """Curvature."""
        return np.full(len(p), 1 / self.radius)


@dataclass(frozen=True, slots=True)
class Ellipse:
    """Ellipse about the origin, the image of a circle whose angle from the vertical is p [rad].

    Attributes
    ----------
    a, b : Half axes along x and y [m].
    """

    a: float
    b: float

    def at(self, p: FloatArray) -> FloatArray:
        """Points."""
        return np.column_stack([self.a * np.sin(p), self.b * np.cos(p)])

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives."""
        return np.column_stack([self.a * np.cos(p), -self.b * np.sin(p)])

    def bend(self, p: FloatArray) -> FloatArray:
        """Curvature."""
        return np.asarray(self.a * self.b / np.linalg.norm(self.along(p), axis=1) ** 3)


@dataclass(frozen=True, slots=True)
class Catenary:
    """Catenary turned upside down, y = top + scale (1 − cosh(x / scale)); p is x [m].

    Attributes
    ----------
    scale : Radius of curvature at the crown [m].
    top : Height of the crown [m].
    """

    scale: float
    top: float

    @classmethod
    def through(cls, span: float, rise: float) -> Catenary:
        """The chain of that span and rise."""
        # with k = span / 2 scale: rise / span = (cosh k − 1) / 2k, more than k / 4

        def excess(k: float) -> float:
            return float(np.sinh(k / 2) ** 2 / k - rise / span)

        k = _root(excess, 1e-9 * min(1.0, rise / span), 4 * rise / span, 1e-15, 1e-15)
        return cls(span / (2 * k), rise)

    def at(self, p: FloatArray) -> FloatArray:
        """Points."""
        return np.column_stack([p, self.top - 2 * self.scale * np.sinh(p / (2 * self.scale)) ** 2])

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives."""
        return np.column_stack([np.ones(len(p)), -np.sinh(p / self.scale)])

    def bend(self, p: FloatArray) -> FloatArray:
        """Curvature."""
        return np.asarray(1 / (self.scale * np.cosh(p / self.scale) ** 2))


@dataclass(frozen=True, slots=True)
class Offset:
    """The line at a constant distance from another.

    Attributes
    ----------
    line : The other line.
    by : Distance to the left of its direction, that is, above an arch [m].
    """

    line: Line
    by: float

    def at(self, p: FloatArray) -> FloatArray:
        """Points."""
        return self.line.at(p) + self.by * self.normal(p)

    def along(self, p: FloatArray) -> FloatArray:
        """Derivatives."""
        return self.line.along(p) * (1 + self.by * self.line.bend(p))[:, None]

    def bend(self, p: FloatArray) -> FloatArray:
        """Curvature."""
        own = self.line.bend(p)
        return np.asarray(own / (1 + self.by * own))

    def normal(self, p: FloatArray) -> FloatArray:
        """Unit normals to the left, shape (n, 2)."""
        along = self.line.along(p)
        unit = along / np.linalg.norm(along, axis=1, keepdims=True)
        return np.column_stack([-unit[:, 1], unit[:, 0]])


def swept(line: Line, start: float, end: float, pieces: int) -> float:
    """Area between a part of a line and the origin, positive where the line runs counter-clockwise [m²].

    Parameters
    ----------
    line : The line.
    start, end : Parameters at the ends of the part.
    pieces : Number of pieces for Gauss quadrature.
    """
    p, weight = _gauss(start, end, pieces)
    point, along = line.at(p), line.along(p)
    return float((weight * (point[:, 0] * along[:, 1] - point[:, 1] * along[:, 0])).sum() / 2)


def length(line: Line, start: float, end: float, pieces: int = 16) -> float:
    """Length of a part of a line [m].

    Parameters
    ----------
    line : The line.
    start, end : Parameters at the ends of the part.
    pieces : Number of pieces for Gauss quadrature.
    """
    p, weight = _gauss(start, end, pieces)
    return float((weight * np.linalg.norm(line.along(p), axis=1)).sum())


def _gauss(start: float, end: float, pieces: int) -> tuple[FloatArray, FloatArray]:
    edges = np.linspace(start, end, pieces + 1)
    half = (edges[1:] - edges[:-1]) / 2
    middle = (edges[1:] + edges[:-1]) / 2
    return (middle[:, None] + half[:, None] * NODES).ravel(), (half[:, None] * WEIGHTS).ravel()


def equal_parts(line: Line, start: float, end: float, count: int) -> FloatArray:
    """Parameters that divide a part of a line into parts of equal length, shape (count + 1,).

    Parameters
    ----------
    line : The line.
    start, end : Parameters at the ends of the part.
    count : Number of parts.
    """
    if isinstance(line, Circle | Segment):
        return np.linspace(start, end, count + 1)
    whole = length(line, start, end)

    def excess(k: int, p: float) -> float:
        return length(line, start, p) - whole * k / count

    inner = [_root(partial(excess, k), start, end, 1e-14) for k in range(1, count)]
    return np.array([start, *inner, end])


def crossing(line: Line, start: float, end: float, point: FloatArray, normal: FloatArray) -> float:
    """Parameter at which a part of a line crosses a straight line.

    Parameters
    ----------
    line : The line.
    start, end : Parameters at the ends of the part, which lie on different sides of the straight line.
    point : A point of the straight line, shape (2,) [m].
    normal : Its normal, shape (2,).
    """

    def height(p: float) -> float:
        return float((line.at(np.array([p]))[0] - point) @ normal)

    return _root(height, start, end, 1e-15)


def _root(
    function: Callable[[float], float], low: float, high: float, close: float, relative: float = LEAST
) -> float:
    """Where a function of one number is 0 between two of unlike signs, to within ``close``."""
    from scipy.optimize import brentq  # noqa: PLC0415  slow to load, and few structures are curved

    return float(brentq(function, low, high, xtol=close, rtol=relative))
