"""Model in three dimensions: the skin of all stones with its fields, packed for the report's viewer.

It is read from the field files, in numbers of sixteen bits: places to 1/65000 of the structure. Skins of more
than ``LARGEST`` triangles are made coarser.
"""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host import installation
from masonry_fem.output import fields
from masonry_fem.output.scenery import amplification_of, at_rest, outline_of, surface_of
from masonry_fem.output.view import read_scenery

LARGEST = 250_000  # triangles
FULL = 65_534  # of sixteen bits; one more says that there is no value
SHOWN = {  # arrays of nodes by what they are called, with their unit
    "utilisation": (fields.UTILISATION, None, ""),
    "von Mises stress": (fields.VON_MISES, None, "Pa"),
    "greatest principal stress": (fields.PRINCIPAL, 0, "Pa"),
    "least principal stress": (fields.PRINCIPAL, 2, "Pa"),
}


def packed(directory: Path) -> dict[str, Any] | None:
    """The skin of a results folder as JSON's types; None without field files, or what can read them.

    Parameters
    ----------
    directory : The folder.
    """
    if not (directory / "blocks.pvd").exists() or installation.lacking("pictures"):
        return None
    scenery = read_scenery(directory)
    blocks = scenery.blocks
    skin = surface_of(blocks).triangulate()
    outline = outline_of(skin)
    if skin.n_cells > LARGEST:
        coarse = skin.decimate_pro(1.0 - LARGEST / skin.n_cells, preserve_topology=True)
        skin = coarse if coarse.n_cells else skin
    moved = np.asarray(blocks.point_data[fields.DISPLACEMENT], float)
    low, high = blocks.points.min(axis=0), blocks.points.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    most = float(np.abs(moved).max(initial=0.0)) or 1.0
    still = at_rest(moved, np.asarray(blocks.points))

    def mesh(part: Any, connectivity: NDArray[np.int64]) -> dict[str, Any]:
        points = np.asarray(part.points, float)
        shift = np.asarray(part.point_data[fields.DISPLACEMENT], float)
        return {
            "points": _text(np.rint((points - low) / span * 65535).astype("<u2")),
            "moves": _text(np.rint(shift / most * 32767).astype("<i2")),
            "cells": _text(connectivity.astype("<u4")),
        }

    edges = np.asarray(outline.lines).reshape(-1, 3)[:, 1:] if outline.n_lines else np.zeros((0, 2), int)
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    return {
        "dimension": scenery.dimension,
        "low": low.tolist(),
        "span": span.tolist(),
        "most": most,
        "factor": 0.0 if still else amplification_of(moved, np.asarray(blocks.points)),
        "skin": mesh(skin, np.asarray(skin.faces).reshape(-1, 4)[:, 1:]),
        "outline": mesh(outline, edges),
        "block": _text(np.asarray(skin.point_data[fields.BLOCK]).astype("<u4")),
        "names": names,
        "fields": _fields(skin),
    }


def _fields(skin: Any) -> list[dict[str, Any]]:
    """The fields that there are, and how far each point has gone."""
    made = []
    for name, (key, component, unit) in SHOWN.items():
        if key in skin.point_data:
            values = np.asarray(skin.point_data[key], float)
            values = values if component is None else values.reshape(-1, 3)[:, component]
            if np.isfinite(values).any():
                made.append(_field(name, unit, values))
    distance = np.linalg.norm(np.asarray(skin.point_data[fields.DISPLACEMENT], float), axis=1)
    return [*made, _field("displacement", "m", distance)]


def _field(name: str, unit: str, values: NDArray[np.float64]) -> dict[str, Any]:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    # corners in contact are singular: colours end where hardly any point has more
    bottom, top = (float(end) for end in np.nanquantile(values, (0.005, 0.995)))
    scaled = (values - low) / ((high - low) or 1.0) * FULL
    numbers = np.where(np.isnan(values), FULL + 1, np.rint(np.nan_to_num(scaled)))
    return {
        "name": name, "unit": unit, "low": low, "high": high, "values": _text(numbers.astype("<u2")),
        "from": low if low >= 0 else bottom, "to": top if top > bottom else high,
    }  # fmt: skip


def _text(values: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(values).tobytes()).decode()
