"""Told words: what a summary says of joints, stones and supports, as sentences of the console and the report.

joint_words(summary["joints"])         # '10 cracked, 3 hinges; 1 slides'
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from masonry_fem.output.sheet import quantity

OF_A_STAGE = 4  # supports that are shown
ROUNDING = 1e-9  # of the largest energy: less is none
MOSTLY = 0.5  # share of the square of an error
STATES = {
    "closed": ("closed without a section", "closed without a section"),
    "middle_third": ("within the middle third", "within the middle third"),
    "cracked": ("cracked", "cracked"),
    "hinge": ("hinge", "hinges"),
    "open": ("open", "open"),
    "held": ("held by cohesion", "held by cohesion"),
}  # one, more: docs/results.md#interfacescsv explains them
STONES = {
    "over": "{uses} more than all of {its} design strength",
    "rigid": "{is_} rigid: only {its} mean stress is known",
    "one_sided": "{has} one strength only; the other is not checked",
    "unchecked": "{has} no strength and {is_} not checked",
}
ONE = {"uses": "uses", "its": "its", "is_": "is", "has": "has"}
MANY = {"uses": "use", "its": "their", "is_": "are", "has": "have"}


def joint_words(told: Mapping[str, Any]) -> str:
    """How many joints are in which state: ``3 within the middle third, 10 cracked, 1 hinge; 2 slide``.

    Parameters
    ----------
    told : What a summary says of joints.
    """
    words = ", ".join(f"{count(told[key])} {STATES[key][told[key] != 1]}" for key in STATES if told[key])
    slide = told["slide"]
    return words + (f"; {count(slide)} {'slides' if slide == 1 else 'slide'}" if slide else "")


def joint_count(told: Mapping[str, Any]) -> str:
    """How many joints there are, in whichever state: ``1 joint``, ``1 200 joints``.

    Parameters
    ----------
    told : What a summary says of joints.
    """
    number = sum(told[key] for key in STATES)
    return f"{count(number)} joint{'' if number == 1 else 's'}"


def stone_words(told: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What has to be known of how stones were checked: key, and ``1 stone has no strength and ...``.

    Parameters
    ----------
    told : What a summary says of the utilisation.
    """
    for key, words in STONES.items():
        if number := told[key]:
            stones = "stone" if number == 1 else "stones"
            yield key, f"{count(number)} {stones} {words.format(**(ONE if number == 1 else MANY))}"


def damping_words(told: Mapping[str, Any]) -> str:
    """Which damping acted, and what it took: ``Rayleigh in stone (α = 0.2 1/s) took 3.1 J; ...``.

    Parameters
    ----------
    told : What a summary says; empty where it says nothing of damping.
    """
    damping = told.get("damping")
    if not damping:
        return ""
    parts = [
        f"{'Rayleigh' if one['mass'] else 'Kelvin–Voigt'} in {name} ({_factors(one)})"
        for name, one in damping["rayleigh"].items()
    ]
    if damping["velocity_factor"] != 1:
        parts.append(f"velocities × {damping['velocity_factor']:g} after each step")
    lost = f"{', '.join(parts)} took {_taken(told, 'damping_dissipation')}"
    said = [lost if parts else "none of the stones"]
    said.append(f"θ = {damping['theta']:g}, finite steps took {_taken(told, 'numerical_dissipation')}")
    if rebound := damping.get("restitution"):
        ends = " to ".join(dict.fromkeys(f"{value:g}" for value in rebound))
        said.append(f"impacts with e = {ends} took {_taken(told, 'impact_normal', 'impact_tangential')}")
    return "; ".join(said)


def _factors(one: Mapping[str, float]) -> str:
    """Factors of Rayleigh damping that are not 0."""
    words = {"mass": f"α = {one['mass']:g} 1/s", "stiffness": f"β = {one['stiffness']:g} s"}
    return ", ".join(words[key] for key in words if one[key])


def _taken(told: Mapping[str, Any], *terms: str) -> str:
    """Energy that some terms of the ledger have lost, of which rounding is none."""
    energy = told.get("energy") or {}
    lost = sum(energy.get(term) or 0.0 for term in terms)
    unit = "J/m" if len(told.get("applied", ())) == 2 else "J"
    return quantity(lost if abs(lost) > ROUNDING * (energy.get("largest") or 0.0) else 0.0, unit)


def finer_elements(told: Mapping[str, Any]) -> str:
    """What makes the error of stresses smaller. Refinement by itself is of one run with one structure.

    Parameters
    ----------
    told : What a summary says.
    """
    if ((told.get("stress") or {}).get("error") or {}).get("reduced", 0.0) > MOSTLY:
        return "a higher materials.NAME.degree of the reduced stones, or fidelity = 'elastic'"
    alone = not any(told.get(key) for key in ("stages", "combinations", "places"))
    words = "finer elements, in [mesh] or in the file that brings them"
    return words + (", or masonry-fem run with --refine-to 10%" if alone else "")


def greatest_supports(supports: Mapping[str, Any], most: int = OF_A_STAGE) -> tuple[list[str], int]:
    """Names of the supports with the greatest forces, in their order, and how many others there are.

    Parameters
    ----------
    supports : What a summary says of them. most : Of them that are named.
    """
    ranked = sorted(supports, key=lambda name: -_squared(supports[name]))
    chosen = set(ranked[:most])
    return [name for name in supports if name in chosen], max(len(ranked) - most, 0)


def _squared(wrench: Any) -> float:
    """Square of a force, which is given with its moment, or as one list of six."""
    force = wrench["force"] if isinstance(wrench, Mapping) else wrench[:3]
    return sum(float(part) ** 2 for part in force)


def count(number: Any) -> str:
    """A number of things, thousands apart."""
    return f"{number:,}".replace(",", " ") if isinstance(number, int) else str(number)
