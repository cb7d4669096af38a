"""Target: one or several quantities that share a recommendation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from masonry_fem.analyses.study.comparison import Comparison, matches
from masonry_fem.analyses.study.quantity import group_of
from masonry_fem.errors import MasonryError
from masonry_fem.scene.misfit import listed, nearest

WORDS = {
    "probes": "the displacements of the probes",
    "supports": "the forces of the supports",
    "moments": "the moments of the supports",
    "thrust": "the thrust",
    "stress.means": "the mean stresses of the blocks",
    "stress.p95": "the stress that 95 % of the volume is under",
    "stress.max": "the greatest von Mises stress",
    "energy": "the energies",
    "peak": "the peaks",
}


@dataclass(frozen=True, slots=True)
class Target:
    """What a recommendation is for.

    Attributes
    ----------
    label : For tables.
    words : For sentences.
    names : Of its quantities.
    """

    label: str
    words: str
    names: tuple[str, ...]


def targets(comparisons: Sequence[Comparison], asked: Sequence[str]) -> list[Target]:
    """One target per group of quantities, or per pattern.

    Parameters
    ----------
    comparisons : One per case.
    asked : Names, groups or patterns of quantities; empty for all groups.

    Raises
    ------
    MasonryError : A pattern selects nothing.
    """
    names = next(([*made.values] for made in comparisons if made.values), [])
    if not asked:
        return _by_group(names)
    made = []
    for pattern in asked:
        own = [name for name in names if matches(name, pattern)]
        if own:
            made.append(_target(pattern, own))
        elif not any(matches(name, pattern) for one in comparisons for name in one.left_out):
            raise _unknown(pattern, comparisons)
    return made


def _by_group(names: Sequence[str]) -> list[Target]:
    """One target per group, in the order of ``WORDS``, groups that it does not have last."""
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(group_of(name), []).append(name)
    return [_target(group, groups[group]) for group in dict.fromkeys([*WORDS, *groups]) if group in groups]


def _unknown(pattern: str, comparisons: Sequence[Comparison]) -> MasonryError:
    """The error of a pattern that selects nothing, with what there is."""
    rows = (row for one in comparisons for row in one.rows)
    present = list(dict.fromkeys(name for row in rows for name in row.quantities))
    if any(matches(name, pattern) for name in present):
        return MasonryError(
            f"--quantity {pattern}: the reference does not have it, so that nothing can be compared; "
            "take one of the cells as the reference, or another quantity"
        )
    near = nearest(pattern, [*present, *(name.split(".")[0] for name in present)])
    known = listed(present) or "none, as no cell was solved"
    return MasonryError(f"--quantity {pattern}: no such quantity{near}; known: {known}")


def _target(label: str, names: list[str]) -> Target:
    return Target(label, WORDS.get(label, label), tuple(names))
