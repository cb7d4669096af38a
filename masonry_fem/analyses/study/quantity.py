"""Quantity: a number or vector of a run that a study compares, and the least its errors are relative to.

    measured(result)["probes.crown"].values        # displacement [m]
    told(summary)                                  # the same from summary.json, as far as it goes

Names begin with the group: ``probes.NAME``, ``supports.NAME`` (force), ``moments.NAME`` (about the middle of
the support's joints), ``thrust.NAME`` (horizontal part of the force), ``stress.max``, ``stress.p95``,
``stress.means`` (of all blocks), ``energy.strain``, ``energy.work``, ``energy.kinetic``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from masonry_fem.analyses.run import RunResult

FloatArray = NDArray[np.float64]

GROUPS = ("probes", "supports", "moments", "thrust", "stress", "energy", "peak")
AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
TURNS = {1: ("z",), 3: ("x", "y", "z")}
SMALL = {
    "probes": 1e-3,  # of the greatest displacement of a probe: a point that symmetry holds is not compared
    "thrust": 1e-4,  # of the support's force: rounding and the solver's tolerance are no thrust
    "energy": 1e-6,  # of the greatest energy
}
SHEAR = math.sqrt(2.0)  # shear stands twice in the norm of a tensor


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number or vector.

    Attributes
    ----------
    values : Components. axes : Their names; empty for a number. unit : Of the values.
    scale : What errors are relative to at least. least : At or below it the quantity is not compared.
    """

    values: tuple[float, ...]
    axes: tuple[str, ...] = ()
    unit: str = ""
    scale: float = 0.0
    least: float = 0.0

    @property
    def size(self) -> float:
        """Norm."""
        return math.hypot(*self.values)

    def component(self, axis: str) -> Quantity | None:
        """One component of a vector by its name."""
        if axis not in self.axes or len(self.axes) != len(self.values):
            return None
        return Quantity((self.values[self.axes.index(axis)],), (), self.unit, 0.0, self.least)

    def told(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> Quantity:
        """From JSON."""
        return cls(
            tuple(told["values"]),
            tuple(told["axes"]),
            told["unit"],
            float(told["scale"]),
            float(told["least"]),
        )


Quantities = dict[str, Quantity]


def measured(result: RunResult) -> Quantities:
    """All quantities of a run."""
    model, scene_gravity = result.built.model, _down(result)
    summary = plain(result.summary)
    found = told(summary, down=scene_gravity)
    found |= dict(_moments(model, summary["supports"]))
    means = _block_means(model, result.march.state)
    if means is not None:
        found["stress.means"] = means
    return found


def told(summary: Mapping[str, Any], *, down: int | None = None) -> Quantities:
    """Quantities that stand in a summary.

    Parameters
    ----------
    summary : What ``summary.json`` holds.
    down : Number of the axis along which gravity acts; the last one by default.
    """
    probes = {name: np.ravel(value) for name, value in (summary.get("probes") or {}).items()}
    greatest = max((float(np.linalg.norm(value)) for value in probes.values()), default=0.0)
    found = {
        f"probes.{name}": _vector(value, "m", least=SMALL["probes"] * greatest)
        for name, value in probes.items()
    }
    found |= dict(_forces(summary.get("supports") or {}, down))
    found |= dict(_stresses(summary.get("stress") or {}))
    found |= dict(_energies(summary.get("energy") or {}))
    return found


def group_of(name: str) -> str:
    """The group that a quantity is told in: its first word, of stresses the first two."""
    first, _, rest = name.partition(".")
    return f"{first}.{rest.partition('.')[0]}" if first == "stress" else first


def pick(quantities: Quantities, name: str) -> Quantity | None:
    """A quantity by its name, or a component of it (``probes.crown.z``); None where there is none.

    Parameters
    ----------
    quantities : By name.
    name : Of the quantity, with ``.`` and an axis for a component.
    """
    if name in quantities:
        return quantities[name]
    owner, _, axis = name.rpartition(".")
    return quantities[owner].component(axis) if owner in quantities else None


def _vector(value: FloatArray, unit: str, *, scale: float = 0.0, least: float = 0.0) -> Quantity:
    axes = AXES.get(len(value), ())
    return Quantity(tuple(map(float, value)), axes, unit, scale, least)


def _number(value: float, unit: str, *, least: float = 0.0) -> Quantity:
    return Quantity((float(value),), (), unit, 0.0, least)


def _forces(supports: Mapping[str, Any], down: int | None) -> Iterator[tuple[str, Quantity]]:
    forces = {name: np.ravel(wrench["force"]) for name, wrench in supports.items()}
    most = max((float(np.linalg.norm(force)) for force in forces.values()), default=0.0)
    for name, force in forces.items():
        size = float(np.linalg.norm(force))
        unit = "N" if len(force) == 3 else "N/m"
        yield f"supports.{name}", _vector(force, unit, least=SMALL["thrust"] * most)
        vertical = len(force) - 1 if down is None else down
        level = [i for i in range(len(force)) if i != vertical]
        axes = tuple(AXES[len(force)][i] for i in level)
        yield (
            f"thrust.{name}",
            Quantity(tuple(float(force[i]) for i in level), axes, unit, 0.0, SMALL["thrust"] * size),
        )


def _stresses(stress: Mapping[str, Any]) -> Iterator[tuple[str, Quantity]]:
    if stress:
        yield "stress.max", _number(stress["max_von_mises"]["value"], "Pa")
        yield "stress.p95", _number(stress["p95_von_mises"], "Pa")


def _energies(energy: Mapping[str, Any]) -> Iterator[tuple[str, Quantity]]:
    names = {"strain": "strain", "work": "external_work", "kinetic": "kinetic"}
    values = {name: float(energy.get(key) or 0.0) for name, key in names.items()}
    least = SMALL["energy"] * max(abs(value) for value in values.values())
    for name, value in values.items():
        if energy:
            yield f"energy.{name}", _number(value, "J", least=least)


def _moments(model: Any, supports: Mapping[str, Any]) -> Iterator[tuple[str, Quantity]]:
    """Moment of each support about the middle of its contacts, and force times their spread as its scale."""
    contacts = model.contacts
    for number, block in enumerate(model.assembly.blocks):
        held = (contacts.blocks == number).any(axis=1)
        if block.name not in supports or not held.any():
            continue
        weight = contacts.area[held]
        weight = weight if weight.sum() > 0 else np.ones(len(weight))
        points = contacts.points[held].mean(axis=1)
        middle = np.average(points, axis=0, weights=weight)
        spread = math.sqrt(np.average(((points - middle) ** 2).sum(axis=1), weights=weight))
        force = np.ravel(supports[block.name]["force"])
        moment = np.ravel(supports[block.name]["moment"]) - _turn(middle, force)
        unit = "N m" if len(force) == 3 else "N"
        scale = float(np.linalg.norm(force)) * spread
        yield (
            f"moments.{block.name}",
            Quantity(tuple(map(float, moment)), TURNS[len(moment)], unit, scale, 0.0),
        )


def _turn(arm: FloatArray, force: FloatArray) -> FloatArray:
    if len(force) == 3:
        return np.cross(arm, force)
    return np.array([arm[0] * force[1] - arm[1] * force[0]])


def _down(result: RunResult) -> int | None:
    """Axis along which the loads are greatest, which is what thrusts stand across."""
    applied = np.abs(np.ravel(result.summary.applied))
    last = len(applied) - 1
    return last if applied[last] > 0 or not applied.any() else int(applied.argmax())


def _block_means(model: Any, state: Any) -> Quantity | None:
    """Mean stresses of all blocks, weighted so that the norm is their L2 norm; None where there are none."""
    names: list[str] = []
    rows: list[FloatArray] = []
    for group, moved in zip(model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is None:
            continue
        bodies, cells, points, _ = field.gauss.shape
        weight = np.broadcast_to(field.weight, (bodies, cells, points))
        volume = weight.sum(axis=(1, 2))
        mean = np.einsum("bcp,bcpi->bi", weight, field.gauss) / volume[:, None]
        mean[:, 3:] *= SHEAR
        rows.extend(np.sqrt(volume)[:, None] * mean)
        names.extend(model.assembly.blocks.names[int(block)] for block in group.blocks)
    if not rows:
        return None
    order = sorted(range(len(names)), key=names.__getitem__)
    total = math.sqrt(sum(float((row**2).sum()) for row in rows)) or 1.0
    stacked: Sequence[float] = np.concatenate([rows[i] for i in order]).tolist()
    return Quantity(tuple(stacked), tuple(names[i] for i in order), "Pa m^1.5", 0.0, 1e-12 * total)
