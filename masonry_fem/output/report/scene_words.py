"""Scene in words: what a run was asked, and what it takes for granted, told from its scene file."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from masonry_fem.output.sheet import quantity
from masonry_fem.output.told_words import damping_words

SHOWN = (
    "materials", "structures", "overrides", "joints", "supports", "loads", "design", "initial", "analysis",
    "solver", "contact", "mesh",
)  # fmt: skip
STRESSES = ("young", "compressive_strength", "tensile_strength", "cohesion")


def settings(scene: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Tables of the scene by name, each with its keys and values.

    Parameters
    ----------
    scene : What ``as_run.toml`` says.
    """
    made = []
    for key in SHOWN:
        if key in scene:
            made += [(name, rows) for name, rows in _tables(key, scene[key]) if rows]
    return made


def _tables(name: str, value: Any) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    if isinstance(value, dict) and _are_tables(value.values()):
        for key, part in value.items():
            yield from _tables(f"{name}.{key}", part)
    elif isinstance(value, list) and _are_tables(value):
        for called, part in zip(_called(value), value, strict=True):
            yield f"{name} {called}".rstrip(), list(_rows(part))
    elif isinstance(value, dict):
        yield name, list(_rows(value))
    else:
        yield name, [("", _words("", value))]


def _called(parts: Sequence[Mapping[str, Any]]) -> list[str]:
    """What each of several tables is called: its name or what it is on, whatever others come and go."""
    names = [str(part.get("name") or part.get("on") or "") for part in parts]
    if all(names) and len(set(names)) == len(names):
        return names
    return [str(number + 1) if len(parts) > 1 else "" for number in range(len(parts))]


def _are_tables(values: Collection[Any]) -> bool:
    return bool(values) and all(isinstance(value, dict) for value in values)


def _rows(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _rows(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", _words(key, value)


def _words(key: str, value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        if key in STRESSES:
            return quantity(float(value), "Pa", 4)
        return f"{value:g} kg/m³" if key == "density" else f"{value:g}"
    if isinstance(value, list):
        words = ", ".join(_words("", part) for part in value[:20])
        return f"{words}{', …' if len(value) > 20 else ''}"
    if isinstance(value, dict):
        return ", ".join(f"{name} {_words(name, part)}" for name, part in value.items())
    return str(value)


def assumptions(scene: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    """What the run takes for granted, one sentence each.

    Parameters
    ----------
    scene : What ``as_run.toml`` says. summary : What ``summary.json`` says.
    """
    return list(_assumed(scene, summary))


def _assumed(scene: Mapping[str, Any], summary: Mapping[str, Any]) -> Iterator[str]:
    flat = scene.get("dimension", 3) == 2
    if flat:
        plane = scene.get("plane", "strain")
        yield f"The structure is plane, in plane {plane}; forces are for a metre of depth."
    own = {one.get("fidelity") for one in (*scene.get("structures", ()), *scene.get("overrides", ()))}
    fidelities = {scene.get("fidelity", "elastic"), *own} - {None}
    words = {
        "rigid": "Rigid stones do not deform; forces between them may not be unique.",
        "elastic": "Elastic stones are linear and isotropic unless their material says otherwise; strains "
        "are small, rotations may be large. They do not crack, whatever tension is computed in them.",
        "reduced": "Reduced stones are elastic and deform by a few modes.",
        "inelastic": "Inelastic stones yield or crack by the law of their material.",
        "auto": "Stones are elastic until their stress comes near to their strength, inelastic from then on.",
    }
    yield from (words[name] for name in sorted(fidelities) if name in words)
    yield _assumed_of_joints(scene.get("joints", [{}]))
    yield "Loads keep their direction and their material point."
    kind = scene.get("analysis", {}).get("kind", "statics")
    if kind == "statics":
        yield "Statics: no inertia; the time is the load factor, and loads act from a start without stress."
    if damping := damping_words(summary):
        yield f"Damping: {damping}."
    if "utilisation" in summary:
        yield (
            "Utilisation is ⟨σ1⟩/f_t + ⟨−σ3⟩/f_c of the principal stresses: pressure from the sides adds no "
            f"strength. Of each stone it is the mean over the most utilised "
            f"{100 * summary['utilisation']['share']:g} % of its volume."
        )


def _assumed_of_joints(joints: Sequence[Mapping[str, Any]]) -> str:
    cohesive = any("law" in joint or "mortar" in joint for joint in joints)
    coefficients = [joint["friction"] for joint in joints if "friction" in joint]
    friction = sorted({f"{one:g}" if isinstance(one, float | int) else str(one) for one in coefficients})
    told = f" with μ = {', '.join(friction)}" if friction else ""
    held = " beyond their cohesion" if cohesive else ""
    return f"Joints press and never pull{held}, and slide by Coulomb's law{told}."
