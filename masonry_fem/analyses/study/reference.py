"""Reference: what the cells of a study are compared with.

The finest cell that was solved, a chosen cell, the results of another run, or given numbers:

    Reference.parse([], vary)                                    # the finest cell
    Reference.parse(["mesh.size=0.05,fidelity=elastic"], vary)   # that cell, the finest in all else
    Reference.parse(["results/arch"], vary)                      # a folder with summary.json
    Reference.parse(["probes.crown.z=-1.77e-6"], vary)           # numbers, or a TOML or JSON file of such
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.study.quantity import AXES, GROUPS, Quantities, Quantity, pick, told
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.variation import Variation, split, written
from masonry_fem.errors import MasonryError
from masonry_fem.output.folder import unfinished
from masonry_fem.scene.misfit import listed
from masonry_fem.scene.overrides import parsed


@dataclass(frozen=True, slots=True)
class Reference:
    """What to compare with.

    Attributes
    ----------
    words : The same in words.
    places : Place of the value in each variation that a chosen cell has; None: the finest.
    given : Quantities from outside; None: the reference is a cell.
    """

    words: str
    places: tuple[int | None, ...] = ()
    given: Quantities | None = field(default=None)

    @classmethod
    def parse(cls, texts: Sequence[str], vary: Sequence[Variation]) -> Reference:
        """Read what a user gave.

        Raises
        ------
        MasonryError : Where it is neither a cell of the study, nor a file, nor numbers.
        """
        parts = [part for text in texts for part in split(text) if part]
        if not parts:
            return cls("the finest cell", (None,) * len(vary))
        if len(parts) == 1 and "=" not in parts[0]:
            return cls(parts[0], given=_from_file(Path(parts[0])))
        pairs = list(map(_pair, parts))
        asked = dict(pairs)
        if asked.keys() <= {one.key for one in vary}:
            places = tuple(_place(one, asked) for one in vary)
            return cls("the cell of " + ", ".join(f"{key} = {text}" for key, text in pairs), places)
        return cls(
            "the given numbers", given=dict(_numbers({key: parsed(text) for key, text in asked.items()}))
        )

    @classmethod
    def of(cls, given: Any, vary: Sequence[Variation]) -> Reference:
        """Read what Python gave: None, a text, a folder or file, or a table of settings or numbers."""
        if given is None:
            return cls.parse([], vary)
        if isinstance(given, Mapping):
            return cls.parse([f"{key}={written(value)}" for key, value in given.items()], vary)
        if isinstance(given, str | Path):
            return cls.parse([str(given)], vary)
        return cls.parse([str(one) for one in given], vary)

    def check(self, rows: Sequence[Row]) -> None:
        """Refuse numbers from outside of which no solved cell knows one.

        Raises
        ------
        MasonryError : None of the names is a quantity of the cells, or a component of one.
        """
        known = list(dict.fromkeys(name for row in rows for name in row.quantities))
        if self.given is None or not known:
            return
        if not any(pick(row.quantities, name) for row in rows for name in self.given):
            raise MasonryError(
                f"--reference: the cells have no quantity called {listed(self.given)}; known: {listed(known)}"
            )

    def gather(self, vary: Sequence[Variation]) -> tuple[Variation, ...]:
        """The variations, those marked that this one reference is for: all, if it comes from outside."""
        if self.given is not None:
            return tuple(replace(one, compared=True) for one in vary)
        pairs = zip(vary, self.places, strict=True)
        return tuple(replace(one, compared=place is not None) for one, place in pairs)

    def among(self, rows: Sequence[Row], vary: Sequence[Variation]) -> Row | None:
        """The row of the reference among those of a case: of the solved ones the finest."""
        if self.given is not None:
            return None
        return finest_of([row for row in rows if self._fits(row)], vary)

    def _fits(self, row: Row) -> bool:
        pairs = zip(self.places, row.cell.places, strict=True)
        return all(place is None or place == own for place, own in pairs)


def finest_of(rows: Sequence[Row], vary: Sequence[Variation]) -> Row | None:
    """The finest of the rows that were solved; of equally fine ones the most expensive.

    Parameters
    ----------
    rows : Cells with their results.
    vary : Keys and their values.
    """
    solved = [row for row in rows if row.solved]
    return max(solved, key=lambda row: (share_of_finest(row, vary), row.cpu), default=None)


def share_of_finest(row: Row, vary: Sequence[Variation]) -> float:
    """1 where all values of a cell are the finest, 0 where all are the coarsest."""
    graded = [
        (one.ranks[place], len(one.values) - 1) for one, place in zip(vary, row.cell.places, strict=True)
    ]
    shares = [rank / last for rank, last in graded if last]
    return sum(shares) / len(shares) if shares else 1.0


def _pair(part: str) -> tuple[str, str]:
    key, equals, value = part.partition("=")
    if not equals or not key.strip() or not value.strip():
        raise MasonryError(
            f"--reference {part}: expected settings of the study (mesh.size=0.05), a results folder, a TOML "
            "or JSON file of numbers, or numbers (probes.top.z=-1.77e-6)"
        )
    return key.strip(), value.strip()


def _place(one: Variation, asked: Mapping[str, str]) -> int | None:
    if one.key not in asked:
        return None
    value = parsed(asked[one.key])
    for place, own in enumerate(one.values):
        if own == value or one.text(place) == asked[one.key]:
            return place
    known = ", ".join(one.text(place) for place in range(len(one.values)))
    raise MasonryError(f"--reference {one.key}={asked[one.key]}: expected one of the values varied, {known}")


def _from_file(path: Path) -> Quantities:
    """Quantities of a results folder, or of a file of numbers."""
    path = path / "summary.json" if path.is_dir() else path
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise MasonryError(
            f"--reference {path}: cannot be read ({error.strerror}); expected a results folder, a TOML or "
            "JSON file, settings of the study, or numbers such as probes.top.z=-1.77e-6"
        ) from error
    try:
        tree = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    except ValueError as error:
        raise MasonryError(f"--reference {path}: not valid: {error}") from error
    if isinstance(tree, dict) and "outcome" in tree:
        if said := unfinished(path.parent, path.name):
            raise MasonryError(f"--reference {said}")
        if tree["outcome"] not in ("equilibrium", "finished"):
            raise MasonryError(
                f"--reference {path}: its outcome is '{tree['outcome']}', expected a run that was solved"
            )
        return told(tree)
    found = dict(_numbers(tree)) if isinstance(tree, dict) else {}
    if not found:
        raise MasonryError(
            f"--reference {path}: holds no numbers, expected such as probes.top = [0, 0, -1e-6]"
        )
    return found


def _numbers(tree: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Quantity]]:
    for key, value in tree.items():
        name = f"{path}.{key}" if path else str(key)
        if name.partition(".")[0] not in GROUPS:
            raise MasonryError(
                f"--reference {name}: expected a key that is varied, or a quantity that begins with one of "
                f"{listed(GROUPS)}"
            )
        if isinstance(value, Mapping):
            yield from _numbers(value, name)
            continue
        try:
            numbers = np.atleast_1d(np.array(value, dtype=float)).ravel()
        except (TypeError, ValueError):
            numbers = np.array([np.nan])
        if not np.isfinite(numbers).all() or isinstance(value, bool):
            raise MasonryError(f"--reference {name}={value}: expected a number or a list of numbers")
        axes = AXES.get(len(numbers), ()) if isinstance(value, list | tuple) else ()
        yield name, Quantity(tuple(map(float, numbers)), axes)
