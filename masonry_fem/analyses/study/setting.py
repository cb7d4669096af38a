"""Setting: the meaning of a key for accuracy, and which of its values is the finest.

``mesh.size`` is a width: the error is proportional to a power of it. ``fidelity`` has an order without
widths. For keys without an order (a strategy, a placement rule) the value given last counts as the best.
Any other
key (friction, the number of voussoirs) defines another problem, a *case*: a setting is to be accurate in
each
of them.
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from masonry_fem.fidelities import fidelities
from masonry_fem.scene.quantity import si_value

Role = Literal["width", "tolerance", "ordered", "given", "case"]


@dataclass(frozen=True, slots=True)
class Setting:
    """What a key is.

    Attributes
    ----------
    role : ``width`` where errors fall by a power of the value's width; ``tolerance`` where they fall with
        it; ``ordered`` where values have an order only; ``given`` where it is the order they are given in;
        ``case`` where the key changes the problem.
    width : Width of a value, smaller is finer; None: values have none.
    of : What is discretised: ``mesh``, ``time``, ``contact``, ``load``, else ``""``.
    """

    role: Role
    width: Callable[[Any], float] | None = None
    of: str = ""


def setting_of(key: str) -> Setting:
    """What a dotted key is to accuracy."""
    return next((one for pattern, one in KNOWN if fnmatch.fnmatchcase(key, pattern)), Setting("case"))


def fineness(key: str, values: Sequence[Any]) -> tuple[list[int], list[float | None]]:
    """Rank of each value, 0 for the coarsest, and its width, None if the key has none.

    Values without a known width make no valid scene; they rank as coarsest.

    Parameters
    ----------
    key : Dotted key of the scene.
    values : Its values in the study.
    """
    setting = setting_of(key)
    if setting.width is None:
        return list(range(len(values))), [None] * len(values)
    widths = [_attempt(setting.width, value) for value in values]
    # equal widths (Q1 beside P1) rank as they are given
    order = sorted(range(len(values)), key=lambda i: (-widths[i], i))
    ranks = [order.index(i) for i in range(len(values))]
    finite = [width if math.isfinite(width) else None for width in widths]
    return ranks, finite if setting.role in ("width", "tolerance") else [None] * len(values)


def _attempt(width: Callable[[Any], float], value: Any) -> float:
    try:
        found = float(width(value))
    except (TypeError, ValueError, ArithmeticError, LookupError):
        return math.inf
    return found if found > 0 else math.inf


def _number(unit: str | None) -> Callable[[Any], float]:
    return lambda value: si_value(value, unit) if isinstance(value, str) else float(value)


def _share(value: Any) -> float:
    """Width of one part of many."""
    return 1.0 / float(value)


def _cell(value: Any) -> float:
    """Width of the cells of a block that is divided so along its axes."""
    return math.prod(float(count) for count in value) ** (-1.0 / len(value))


def _listed(*names: str) -> Callable[[Any], float]:
    """Width of a name by its place; names joined by | are as fine as each other."""
    widths = {name: float(len(names) - i) for i, group in enumerate(names) for name in group.split("|")}
    return lambda value: widths[value]


KNOWN: tuple[tuple[str, Setting], ...] = (
    ("*mesh.size", Setting("width", _number("m"), "mesh")),
    ("*mesh.divisions", Setting("width", _cell, "mesh")),
    ("*mesh.element", Setting("ordered", _listed("P1|Q1", "P2|Q2"), "mesh")),
    ("analysis.step", Setting("width", _number("s"), "time")),
    ("analysis.theta", Setting("ordered", _number(None), "time")),
    ("analysis.load_steps", Setting("width", _share, "load")),
    ("analysis.substeps", Setting("ordered", _share, "load")),
    ("analysis.max_steps", Setting("ordered", _share)),
    ("analysis.tolerance", Setting("tolerance", _number(None))),
    ("solver.tolerance", Setting("tolerance", _number(None))),
    ("joints.*.density", Setting("width", _share, "contact")),
    ("joints.*.placement", Setting("given", None, "contact")),
    ("joints.*.inset", Setting("given", None, "contact")),
    ("joints.*.form", Setting("given")),
    ("fidelity", Setting("ordered", _listed(*fidelities()))),
    ("*.fidelity", Setting("ordered", _listed(*fidelities()))),
    ("materials.*.degree", Setting("ordered", _share)),
    ("analysis.kind", Setting("given")),
    ("analysis.strategy", Setting("given")),
    ("analysis.velocity_factor", Setting("given")),
    ("solver.max_iterations", Setting("ordered", _share)),
    ("solver.*", Setting("given")),
    ("contact.update", Setting("given")),
    ("contact.every", Setting("ordered", _number(None))),
    ("mass", Setting("given")),
)
