"""Stages in the report: what changes in each part of a history, and how each has ended."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_fem.output.components import in_words
from masonry_fem.output.report.scene_words import settings
from masonry_fem.output.sheet import quantity
from masonry_fem.output.told_words import greatest_supports


def stages(directory: Path, told: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """One entry a stage: name, start, outcome, message, changes and figures.

    Parameters
    ----------
    directory : Results folder of the history.
    told : What its summary says of the stages.
    """
    made, before = [], dict[str, dict[tuple[str, str], str]]()
    for stage in told:
        own = _settings(directory / stage["name"])
        # a first stage begins where the scene does: it is told in full further down
        old = before.get(str(stage.get("after"))) if stage.get("after") else None
        before[stage["name"]] = own
        figures = _figures(directory / stage["name"])
        made.append(dict(stage) | {"changes": _changes(old, own), "figures": figures})
    return made


def _settings(folder: Path) -> dict[tuple[str, str], str]:
    """Values by table and key; empty where the stage left no scene."""
    try:
        scene = tomllib.loads((folder / "as_run.toml").read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError):
        return {}
    analysis = scene.setdefault("analysis", {"kind": "statics"})  # unless the scene says otherwise
    analysis.pop("start", None)  # said by ``after``
    found = {(table, key): value for table, rows in settings(scene) for key, value in rows}
    if gone := scene.get("without"):
        found["blocks that are not there", ""] = ", ".join(gone)
    return found


def _changes(old: Mapping[tuple[str, str], str] | None, new: Mapping[tuple[str, str], str]) -> list[str]:
    """What differs from the stage before, one line a key."""
    if not old:
        return []
    lines = []
    for table, key in dict.fromkeys((*old, *new)):
        was, now = old.get((table, key)), new.get((table, key))
        if was != now:
            said = f"{now}, was {was}" if was and now else now or f"no longer {was}"
            lines.append(f"{table} {key}: {said}" if key else f"{table}: {said}")
    return lines


# Tables of a summary, their greatest values, words, unit, and where these are.
GREATEST = (
    ("stress", "min_principal", "greatest compression", "Pa", "in", "block"),
    ("stress", "max_principal", "greatest tension", "Pa", "in", "block"),
    ("joints", "greatest_opening", "greatest opening", "m", "between", "interface"),
    ("joints", "greatest_sliding", "greatest slide", "m", "between", "interface"),
)


def _figures(folder: Path) -> list[tuple[str, str]]:
    """The figures that tell most of where a stage has ended."""
    try:
        end = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    figures = _supports(end.get("supports") or {})
    for table, key, words, unit, where, place in GREATEST:
        if one := (end.get(table) or {}).get(key):
            figures.append((words, f"{quantity(one['value'], unit)} {where} {one[place]}"))
    if hinges := (end.get("joints") or {}).get("hinge"):
        figures.append(("hinges", str(hinges)))
    for name, moved in (end.get("probes") or {}).items():
        figures.append((f"{name} has moved", quantity(math.hypot(*moved), "m")))
    return figures


def _supports(forces: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Forces of the supports with the greatest ones."""
    shown, others = greatest_supports(forces)
    figures = []
    for name in shown:
        force = forces[name]["force"]
        unit = "N/m" if len(force) == 2 else "N"
        figures.append((f"support {name}", in_words(force, unit, "xyz", 4, mark=", ")))
    if others:
        figures.append((f"{others} other supports", "with smaller forces, see its summary.json"))
    return figures
