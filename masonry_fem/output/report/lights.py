"""Lights: whether a result can be relied on, one question each, with the figures that decide.

    for light in lights(summary): light.colour, light.question, light.answer

Each answer names its figure and the bound that it is compared with, so that a reader can judge for himself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from masonry_fem.output.told_words import finer_elements, stone_words

GREEN, AMBER, RED, GREY = "green", "amber", "red", "grey"
ORDER = (GREY, GREEN, AMBER, RED)
EXACT, POOR = 1e-9, 1e-6  # errors of the equations, relative
OVERLAP = 1e-6  # of two stones, relative to the smaller
SUNK = 1e-3  # of a block: overlap from which a state is no equilibrium
FINE, COARSE = 0.1, 0.3  # estimated errors of the stress
UNSURE = 0.5  # of a utilisation: with a larger error it is not known


@dataclass(frozen=True, slots=True)
class Light:
    """An answer.

    Attributes
    ----------
    colour : ``green``, ``amber``, ``red``, or ``grey``: not asked.
    question, answer : In words.
    """

    colour: str
    question: str
    answer: str


def lights(summary: Mapping[str, Any]) -> list[Light]:
    """The answers for a run.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    found = [_verdict(summary)]
    if "certificate" in summary:
        found += [_equations(summary), _elements(summary), _strength(summary), _remarks(summary)]
    return found


def worst(found: Sequence[Light]) -> str:
    """The colour of all of them together.

    Parameters
    ----------
    found : Some lights.
    """
    return max((light.colour for light in found), key=ORDER.index)


def doubts(found: Sequence[Light]) -> list[str]:
    """The questions that make the whole worse than its verdict, which is the first of the lights.

    Parameters
    ----------
    found : Lights of a run.
    """
    colour = worst(found)
    return [light.question for light in found if light.colour == colour] if found[0].colour != colour else []


def _verdict(summary: Mapping[str, Any]) -> Light:
    outcome, message = str(summary.get("outcome")), str(summary.get("message", ""))
    colour = GREEN if outcome in ("equilibrium", "finished") else RED
    start = summary.get("start") or {}
    if colour == GREEN and start.get("reached") is False:
        colour, message = (
            AMBER,
            f"{message} {start.get('message') or 'It stands only if it is pre-stressed.'}",
        )
    return Light(colour, "Does it stand?" if outcome != "finished" else "Did it end?", message)


def measures(summary: Mapping[str, Any]) -> Iterator[tuple[str, float, float, float]]:
    """Errors of the equations: what, how much, up to what it is good, up to what it may pass.

    What rounding alone makes of an error is good: of a structure at rest all energies are rounding.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    told = summary["certificate"]
    rounding = told.get("rounding") or {}
    words = {
        "natural_map": "Laws of contact and friction: worst violation",
        "cone_violation": "Friction: worst excess over its limit",
        "block_balance": "Balance of forces and moments of the worst stone",
        "global_balance": "Balance of the whole structure",
        "energy_balance": "Balance of energy",
    }
    for key, what in words.items():
        if told.get(key) is not None:
            least = max(EXACT, rounding.get(key) or 0.0)
            yield what, float(told[key]), least, max(POOR, least)
    written = told.get("written") or {}
    if "balance" in written:
        yield (
            "Balance of the worst stone, from the written files alone",
            written["balance"]["value"],
            EXACT,
            POOR,
        )
    if "overlap" in written:
        what = "Deepest overlap of two stones, relative to the smaller one"
        yield what, written["overlap"]["share"], OVERLAP, SUNK


def _equations(summary: Mapping[str, Any]) -> Light:
    found = list(measures(summary))
    bad = [one for one in found if not one[1] <= one[3]]
    poor = [one for one in found if not one[1] <= one[2]]
    question = "Are the equations of mechanics fulfilled?"
    if not poor:
        most = max((one[1] for one in found if one[1] <= EXACT), default=0.0)
        answer = (
            f"Yes: the largest of {len(found)} independent error measures is {most:.1e} (good: up to 1e-9)."
        )
        for what, value, good, _ in found:
            if value > EXACT:
                why = "" if good == OVERLAP else ", as rounding alone makes it"
                answer += f" {what} is {value:.1e}{why} (good: up to {good:.0e})."
        return Light(GREEN, question, answer)
    what, value, good, *_ = max(poor, key=lambda one: one[1] / one[2])
    return Light(
        RED if bad else AMBER,
        question,
        f"Not exactly: {what.lower()} is {value:.1e} (good: up to {good:.0e}).",
    )


def _elements(summary: Mapping[str, Any]) -> Light:
    question = "Are the elements fine enough?"
    error = (summary.get("stress") or {}).get("error")
    if not error:
        return Light(GREY, question, "Stones are rigid: they have forces, and no stress within.")
    share = float(error["relative"])
    colour = GREEN if share <= FINE else AMBER if share <= COARSE else RED
    answer = (
        f"The estimated error of the stress is {100 * share:.2g} % (good: up to 10 %, doubtful from 30 % on)."
    )
    if share > FINE:
        answer += f" It is less with {finer_elements(summary)}."
    if error.get("unjudged"):
        colour = max(colour, AMBER, key=ORDER.index)
        answer += f" It cannot be estimated in {error['unjudged']} stones that are one element thick."
    return Light(colour, question, answer)


def _strength(summary: Mapping[str, Any]) -> Light:
    question, told = "Is the stone strong enough?", summary.get("utilisation")
    if not told or not told["worst"]:
        return Light(GREY, question, "Not checked: the materials of the scene have no strengths.")
    stone = told["worst"][0]
    used, error = stone.get("local", stone["of_mean"]), stone.get("error") or 0.0
    colour = RED if used > 1 else AMBER if used + error > 1 else GREEN
    answer = (
        f"{stone['block']} uses most: {used:.2g}{f' ± {error:.1g}' if error else ''} of its design strength, "
        f"by {stone['governs']} (1 is all of it)."
    )
    if error > UNSURE * used:
        colour = max(colour, AMBER, key=ORDER.index)
        answer += " With an error as large, finer elements have to confirm it."
    for _, words in stone_words(told):
        answer += f" {words[0].upper()}{words[1:]}."
        colour = max(colour, AMBER, key=ORDER.index)
    return Light(colour, question, answer)


def _remarks(summary: Mapping[str, Any]) -> Light:
    count = len(summary.get("remarks") or ())
    question = "Did the program have doubts?"
    if not count:
        return Light(GREEN, question, "No: there was no warning.")
    return Light(AMBER, question, f"Yes: {count} warning{'s' if count > 1 else ''}, see below.")
