"""Page: what a results folder holds, put into the template of the report."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import shlex
import tomllib
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import OutputError
from masonry_fem.host import installation
from masonry_fem.host.atomic import write_atomic
from masonry_fem.host.phases import phase
from masonry_fem.output.components import greatest, in_words
from masonry_fem.output.extremes import combination_rows
from masonry_fem.output.refinement_table import refinement_rows
from masonry_fem.output.report.lights import doubts, lights, measures, worst
from masonry_fem.output.report.model3d import packed
from masonry_fem.output.report.plots import plots
from masonry_fem.output.report.scene_words import assumptions, settings
from masonry_fem.output.report.stages import stages
from masonry_fem.output.sheet import quantity
from masonry_fem.output.terminal import factor_words
from masonry_fem.output.told_words import joint_count, joint_words
from masonry_fem.records.remark import counted

NAME = "report.html"
MOST = 9_500_000  # bytes of the file: where pictures would make it larger they are packed
QUALITY = 90  # of packed pictures: a third of the size, lines and letters stay sharp
ZERO = 1e-9  # of a column's greatest value or the greatest energy: what is below is rounding
ROWS = 2_000  # of a table
PICTURES = {
    "overview.png": "Stress on the deformed shape, with the resultants of the joints",
    "utilisation.png": "What share of its strength the stone uses",
    "thrust.png": "Thrust: how forces pass through the stones",
    "mechanism.png": "How it falls",
    "places.png": "What the moving load leads to, place by place",
    "response.png": "How far probes went, and response spectra",
    "opening.png": "Cracks: how far joints have opened",
    "sliding.png": "How far joints have slid",
    "von_mises.png": "Von Mises stress",
    "principal_stresses.png": "Principal stresses",
    "damage.png": "Damage of the joints",
    "resultants.png": "Resultants of the joints",
    "stress_error.png": "Where the stress is least exact",
    "deformed.png": "Deformed shape",
}
STONES = {
    "block": "stone", "material": "material", "fidelity": "as", "utilisation [-]": "utilisation",
    "utilisation_error [-]": "± error", "utilisation_greatest [-]": "at a point",
    "utilisation_of_mean [-]": "of the mean stress", "governs": "governs",
    "contact_pressure [Pa]": "pressure of a joint [MPa]", "mean_sigma_1 [Pa]": "mean σ1 [MPa]",
    "mean_sigma_3 [Pa]": "mean σ3 [MPa]",
}  # fmt: skip
JOINTS = {
    "candidate": "stone", "antagonist": "other stone", "label": "label", "status": "status",
    "edge": "hinge at", "normal_force": "N [kN]", "shear_force": "T [kN]", "kern [-]": "e / kern",
    "edge_share [-]": "e / edge", "friction [-]": "μ", "friction_used [-]": "friction used",
    "sliding_margin [-]": "μ − T/N", "opening [m]": "opening [mm]", "greatest_sliding [m]": "sliding [mm]",
    "linear_pressure [Pa]": "linear pressure [MPa]",
}  # fmt: skip
ENERGIES = {
    "start": "before the first step", "external_work": "work of the loads",
    "support_work": "work of the supports",
    "heat_work": "work of temperature", "kinetic": "in motion at the end", "strain": "in stones at the end",
    "joints": "in joints at the end", "friction_dissipation": "lost to sliding",
    "impact_normal": "lost as faces meet", "impact_tangential": "lost as faces meet, along them",
    "joint_dissipation": "lost to damage of joints", "joint_viscosity": "lost to viscosity of joints",
    "material_dissipation": "lost as stones yield", "damping_dissipation": "lost to damping",
    "numerical_dissipation": "lost as steps are finite",
}  # fmt: skip
SCALES = {"[MPa]": 1e6, "[kN]": 1e3, "[mm]": 1e-3}


def write_report(directory: str | Path) -> Path:
    """Write ``report.html`` into a results folder.

    Parameters
    ----------
    directory : Where a run wrote ``summary.json``.

    Returns
    -------
    Path of the report.

    Raises
    ------
    OutputError : The folder has no summary of a run.
    """
    with phase("report"):
        return _written(Path(directory))


def _written(directory: Path) -> Path:
    """The same."""
    summary = _summary(directory)
    end = _end_of(directory, summary)
    content = _content(directory, end, summary)
    bare = _rendered(content | {"pictures": []})
    cuts = {path.name: "Stress in a section" for path in sorted(end.glob("cut_*.png"))}
    stones = {path.name: "State of the stones" for path in sorted(end.glob("stone_*.png"))}
    wanted = {name: words for name, words in (PICTURES | stones | cuts).items() if (end / name).is_file()}
    data = _pictures([end / name for name in wanted], MOST - len(bare.encode()))
    content["pictures"] = [(name, wanted[name], text) for name, text in data.items()]
    content["left_out"] = [name for name in wanted if name not in data]
    path = directory / NAME
    write_atomic(path, _rendered(content).encode())
    return path


def _pictures(paths: Sequence[Path], room: int) -> dict[str, str]:
    """Addresses that hold the pictures themselves, by name: as they are if all of them fit, else packed.

    Those that do not fit even so are missing, and so they are where what packs is not installed.

    Parameters
    ----------
    paths : Of the pictures. room : That is left for them [bytes].
    """
    size = sum(4 * -(-path.stat().st_size // 3) for path in paths)
    whole = size <= room or installation.lacking("pictures")
    told: dict[str, str] = {}
    for path in paths:
        text = b64encode(path.read_bytes() if whole else _packed(path)).decode()
        if len(text) <= room:
            told[path.name] = f"data:image/{'png' if whole else 'webp'};base64,{text}"
            room -= len(text)
    return told


def _packed(path: Path) -> bytes:
    """A picture in a third of its size, as WebP."""
    from PIL import Image  # noqa: PLC0415 - only where pictures are many

    data = io.BytesIO()
    with Image.open(path) as picture:
        picture.convert("RGB").save(data, "WEBP", quality=QUALITY)
    return data.getvalue()


def _summary(directory: Path) -> dict[str, Any]:
    path = directory / "summary.json"
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        told = None
    except ValueError as error:
        raise OutputError(
            f"{path} is no JSON ({error}), expected the summary of a run; run it again"
        ) from error
    if not isinstance(told, dict) or not str(told.get("schema", "run/")).startswith("run/"):
        raise OutputError(
            f"'{directory}' has no summary.json of a run, expected the results folder of 'masonry-fem run'; "
            "give that folder, or run the scene first"
        )
    return told


def _rendered(content: Mapping[str, Any]) -> str:
    """The page; whatever comes from a scene is escaped."""
    from jinja2 import Environment, PackageLoader  # noqa: PLC0415 - only where it is asked for

    loader = PackageLoader("masonry_fem.output.report", "template")
    made = Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    made.filters |= {"quantity": quantity, "number": _number, "vector": _vector, "greatest": greatest,
                     "joint_words": joint_words, "joint_count": joint_count, "counted": counted}  # fmt: skip
    return made.get_template("page.html").render(content)


def _end_of(directory: Path, summary: Mapping[str, Any]) -> Path:
    """Where tables and pictures of the end are: of a history in the folder of its last stage.

    Of load combinations they are in the folder of the one that the summary is of.
    """
    if combined := summary.get("combinations"):
        return directory / str(combined["shown"])
    stages = summary.get("stages")
    return directory / str(stages[-1]["name"]) if stages else directory


def _content(directory: Path, end: Path, summary: dict[str, Any]) -> dict[str, Any]:
    text, scene = _scene(end)
    command = f"masonry-fem run as_run.toml --out {shlex.quote(directory.resolve().name)}"
    found = lights(summary)
    dimension = len(_part(summary, "applied")) or int(scene.get("dimension", 3))
    stones, joints = _table(end / "stones.csv", STONES), _table(end / "interfaces.csv", JOINTS)
    _rank(stones, "utilisation", "of the mean stress", "pressure of a joint [MPa]")
    _rank(joints, "e / edge")
    supports = list(_supports(summary))
    whole = end if summary.get("combinations") else directory  # histories go through all stages
    return {
        "summary": summary,
        "title": summary.get("title") or directory.resolve().name,
        "colour": worst(found),
        "doubts": doubts(found),
        "lights": found,
        "measures": list(measures(summary)) if "certificate" in summary else [],
        "scene_text": text,
        "settings": settings(scene),
        "assumptions": assumptions(scene, summary) if scene else [],
        "force_unit": "N/m" if dimension == 2 else "N",
        "factors": factor_words(summary),
        "supports": supports,
        "greatest_force": greatest(force for _, force, _ in supports),
        "greatest_moment": greatest(moment for _, _, moment in supports),
        "stones": stones,
        "joints": joints,
        "rows": ROWS,
        "plots": plots(_history(whole / "history.csv"), dimension),
        "stages": stages(directory, summary.get("stages") or ()),
        "combinations": list(combination_rows(summary)),
        "refinement": list(refinement_rows(summary)),
        "model": packed(whole),
        "left_out": [],
        "energy": _energies(_part(summary, "energy")),
        "seconds": sum(_part(summary, "seconds").values()),
        "reproduce": command if end == directory else "",
        "digest": hashlib.sha256(text.encode()).hexdigest() if text else "",
    }


def _energies(energy: Mapping[str, float]) -> dict[str, float]:
    """Terms of the balance that are more than rounding, as the report calls them, and what is in none."""
    least = ZERO * energy.get("largest", 0.0)
    terms = {words: energy[key] for key, words in ENERGIES.items() if abs(energy.get(key, 0.0)) > least}
    return terms | ({"in none of these": energy["unaccounted"]} if terms else {})


def _part(summary: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Part of a summary; empty where the run did not come to it."""
    return summary.get(name) or {}


def _scene(directory: Path) -> tuple[str, dict[str, Any]]:
    """The scene's text and what it says; empty where the run did not leave it."""
    path = directory / "as_run.toml"
    if not path.is_file():
        return "", {}
    text = path.read_text(encoding="utf-8")
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return text, {}


def _supports(summary: Mapping[str, Any]) -> Iterator[tuple[str, list[float], list[float]]]:
    for name, wrench in _part(summary, "supports").items():
        yield name, wrench["force"], wrench["moment"]


def _table(path: Path, wanted: Mapping[str, str]) -> dict[str, Any] | None:
    """Columns of a table by what the report calls them; None where it is not there.

    Numbers are in the unit of the heading, those that are rounding beside the greatest of their column 0;
    cells without a value are None.
    """
    if not path.is_file():
        return None
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    chosen = list(_columns(rows[0], wanted))
    cells = ([_cell(row[place], scale) for row in rows[1:]] for _, place, scale in chosen)
    columns = [_without_rounding(column) for column in cells]
    kept = [i for i, column in enumerate(columns) if any(cell is not None for cell in column)]
    return {
        "heads": [chosen[i][0] for i in kept],
        "rows": [list(row) for row in zip(*(columns[i] for i in kept), strict=True)],
        "count": len(rows) - 1,
    }


def _without_rounding(column: list[Any]) -> list[Any]:
    """A column whose numbers are 0 where they are rounding beside its greatest."""
    least = ZERO * max((abs(cell) for cell in column if isinstance(cell, float)), default=0.0)
    return [0.0 if isinstance(cell, float) and abs(cell) <= least else cell for cell in column]


def _columns(heads: list[str], wanted: Mapping[str, str]) -> Iterator[tuple[str, int, float]]:
    """Of the wanted columns that are there: heading in the report, place, and what numbers are divided by."""
    for key, name in wanted.items():
        place = next((i for i, head in enumerate(heads) if head == key or head.startswith(f"{key} [N")), None)
        if place is not None:
            scale = next((factor for unit, factor in SCALES.items() if name.endswith(unit)), 1.0)
            own = name.replace("[kN]", "[kN/m]") if heads[place].endswith("[N/m]") else name
            yield own, place, scale


def _cell(text: str, scale: float) -> Any:
    try:
        number = float(text) / scale
    except ValueError:
        return text or None
    return float(f"{number:.5g}") if math.isfinite(number) else None


def _rank(table: dict[str, Any] | None, *keys: str) -> None:
    """Sort a table by the first of its columns that has a value, greatest first, and keep its first rows."""
    if table is None:
        return
    places = [table["heads"].index(key) for key in keys if key in table["heads"]]

    def used(row: list[Any]) -> float:
        return next((-row[i] for i in places if isinstance(row[i], float)), math.inf)

    table["rows"] = sorted(table["rows"], key=used)[:ROWS]


def _history(path: Path) -> dict[str, np.ndarray]:
    """Columns of numbers of ``history.csv``."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    if len(rows) < 3:
        return {}
    wanted = ("time", "speed", "kinetic_energy", "strain_energy")
    columns = {}
    for place, name in enumerate(rows[0]):
        if name in wanted or name.startswith(("probes.", "support_resultants.")):
            columns[name] = np.array([_float(row[place]) for row in rows[1:] if len(row) == len(rows[0])])
    if rows[0][0] == "stage":  # each begins at 0
        ends = np.concatenate([[0.0], columns["time"][:-1]])
        columns["time"] = columns["time"] + np.cumsum(np.where(_begins(rows), ends, 0.0))
    return columns


def _begins(rows: list[list[str]]) -> list[bool]:
    """Whether each row but the heading is the first of a stage."""
    names = [row[0] for row in rows[1:] if len(row) == len(rows[0])]
    return [name != before for name, before in zip(names, [None, *names[:-1]], strict=True)]


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _number(value: Any) -> str:
    """A number with four digits, a dash for none."""
    if value is None:
        return "–"
    return f"{value:.4g}".replace("-", "−") if isinstance(value, float | int) else str(value)


def _vector(values: Any, unit: str, beside: float = 0.0) -> str:
    """Components by axis; a moment in the plane has one."""
    return in_words(values, unit, "xyz" if np.size(values) > 1 else "z", 4, beside, ",  ")
