"""Trimming: overlaps that remain between outlines of stones are cut off along a neighbour's side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.contact.boxes import near_pairs
from masonry_fem.contact.clipping import clip, polygon_area
from masonry_fem.errors import GeometryError
from masonry_fem.importing.triangles import ears
from masonry_fem.solid.pose import FloatArray

ROUNDS = 4  # a cut may make a stone overlap with a third one
NOTHING = 1e-9  # of a stone's size: smaller depths are rounding errors
DEEP = 2.0  # tolerances: stones that overlap more were measured wrongly
LARGE = 3.0  # largest area that a cut takes from a stone, over the overlap's depth times the side's length


def trimmed(
    outlines: Sequence[FloatArray | None], names: Sequence[str], tolerance: float, title: str
) -> tuple[list[FloatArray | None], tuple[tuple[str, str, float], ...]]:
    """Outlines without overlaps, and which pairs overlapped by how much: names and depth [m].

    Parameters
    ----------
    outlines : Of the stones in the wall's plane, each of shape (k, 2) [m]; None for stones that were dropped.
    names : Of the stones.
    tolerance : Of the survey [m].
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : An overlap is deeper than two tolerances, or no cut along one side removes it.
    """
    made = list(outlines)
    cut: dict[tuple[int, int], float] = {}
    for _ in range(ROUNDS):
        found = _overlaps(made)
        if not found:
            break
        for one, two in found:
            a, b = made[one], made[two]
            assert a is not None  # what is dropped overlaps nothing
            assert b is not None
            common = _common(a, b)
            if not len(common):
                continue
            depth = _width(common)
            if depth > DEEP * tolerance:
                raise GeometryError(
                    f"{title}: stones '{names[one]}' and '{names[two]}' overlap by {depth:.3g} m, expected "
                    f"no more than two tolerances ({DEEP * tolerance:.3g} m); delete the stone that was "
                    "measured twice, or correct its corners"
                )
            cut[one, two] = max(depth, cut.get((one, two), 0.0))
            made[one], made[two] = _parted(a, b, common)
    rest = _overlaps(made)
    if rest:
        raise GeometryError(
            f"{title}: stones '{names[rest[0][0]]}' and '{names[rest[0][1]]}' overlap in a way that no cut "
            "along a side removes; correct their corners"
        )
    pairs = sorted(((names[a], names[b], depth) for (a, b), depth in cut.items()), key=lambda one: -one[2])
    return made, tuple(pairs)


def _overlaps(made: Sequence[FloatArray | None]) -> list[tuple[int, int]]:
    rows = [row for row, one in enumerate(made) if one is not None]
    low = np.array([np.min(one, axis=0) for one in made if one is not None])
    high = np.array([np.max(one, axis=0) for one in made if one is not None])
    found = []
    for i, j in near_pairs(low, high, 0.0).tolist() if rows else []:
        one, two = made[rows[i]], made[rows[j]]
        if one is not None and two is not None and len(_common(one, two)):
            found.append((rows[i], rows[j]))
    return found


def _common(one: FloatArray, two: FloatArray) -> FloatArray:
    """Corners of all that two outlines have in common and that is no mere line, shape (k, 2)."""
    size = float(max(np.ptp(one, axis=0).max(), np.ptp(two, axis=0).max()))
    parts = []
    for a in ears(one):
        for b in ears(two):
            part = clip(
                np.ascontiguousarray(one[list(a)]), np.ascontiguousarray(two[list(b)]), NOTHING * size
            )
            if len(part) and _width(part) > NOTHING * size:
                parts.append(part)
    return np.concatenate(parts) if parts else np.zeros((0, 2))


def _width(corners: FloatArray) -> float:
    """Least extent of a set of corners along the normals of lines through two of them [m]."""
    arms = corners[:, None] - corners[None]
    length = np.linalg.norm(arms, axis=2)
    normals = np.stack([-arms[..., 1], arms[..., 0]], axis=2)[length > 0] / length[length > 0][:, None]
    return float(np.ptp(corners @ normals.T, axis=0).min()) if len(normals) else 0.0


def _parted(one: FloatArray, two: FloatArray, common: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The two outlines, one cut along the side of the other behind which the overlap is shallowest."""
    best, shallowest = (one, two), np.inf
    for cut, by, swap in ((one, two, False), (two, one, True)):
        size = float(np.ptp(by, axis=0).max())
        for corner, end in zip(by, np.roll(by, -1, axis=0), strict=True):
            along = (end - corner) / np.linalg.norm(end - corner)
            outward = np.array([along[1], -along[0]])
            away = (common - corner) @ outward
            if away.max() > NOTHING * size or -away.min() >= shallowest:
                continue  # it does not remove the whole overlap, or another cut is better
            left = outside(cut, corner, outward)
            taken = polygon_area(cut) - (polygon_area(left) if len(left) > 2 else 0.0)
            if taken <= LARGE * -away.min() * size:
                best, shallowest = ((by, left) if swap else (left, by)), -float(away.min())
    return best


def outside(outline: FloatArray, corner: FloatArray, outward: FloatArray) -> FloatArray:
    """The part of an outline on one side of a line, shape (k, 2) [m].

    Parameters
    ----------
    outline : Corners in order, shape (n, 2) [m].
    corner : A point of the line, shape (2,) [m].
    outward : Normal of the line towards the part that is kept, shape (2,).
    """
    size = float(np.ptp(outline, axis=0).max())
    away = (outline - corner) @ outward
    away[np.abs(away) < NOTHING * size] = 0.0
    made: list[FloatArray] = []
    for at in range(len(outline)):
        following = (at + 1) % len(outline)
        if away[at] >= 0:
            made.append(outline[at])
        if away[at] * away[following] < 0:
            share = away[at] / (away[at] - away[following])
            made.append(outline[at] + share * (outline[following] - outline[at]))
    kept = [
        p for p, q in zip(made, [*made[1:], *made[:1]], strict=True) if np.abs(p - q).max() > NOTHING * size
    ]
    return np.array(kept).reshape(-1, 2)
