"""Combinations: the envelope of the results of load combinations, and which of them governs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]
TOP = 5  # stones that a summary names


class CombinationTold(Told, frozen=True, kw_only=True):
    """A load combination.

    Attributes
    ----------
    name : Of the combination, and of the folder with its results.
    factors : By load case.
    outcome, message : Verdict, and the same as a sentence.
    """

    name: str
    factors: dict[str, float]
    outcome: str
    message: str


class Governed(Told, frozen=True, kw_only=True):
    """An extreme value.

    Attributes
    ----------
    value : In the unit of what it is of. combination : Name of the first that has it.
    """

    value: float
    combination: str


class StoneGoverned(Governed, frozen=True, kw_only=True):
    """An extreme value of a stone.

    Attributes
    ----------
    block : Its name.
    """

    block: str


class SupportEnvelope(Told, frozen=True, kw_only=True):
    """What a support gives to the blocks, by components of the force [N], then of the moment [N m].

    Attributes
    ----------
    least, greatest : Of each component, shape (3,) in 2D, (6,) in 3D.
    """

    least: tuple[Governed, ...]
    greatest: tuple[Governed, ...]


class Combinations(Told, frozen=True, kw_only=True):
    """Load combinations and their envelope, over those that came to a good end.

    Attributes
    ----------
    runs : The combinations, in the order of the scene.
    shown : Name of the one that all else in the summary is of.
    utilisation : Stones that use most of their strength; None where no stone has one.
    compression, tension : Least and greatest principal value of stones' mean stresses [Pa].
    supports : By name.
    """

    runs: tuple[CombinationTold, ...]
    shown: str
    utilisation: tuple[StoneGoverned, ...] | None = None
    compression: StoneGoverned | None = None
    tension: StoneGoverned | None = None
    supports: dict[str, SupportEnvelope]


@dataclass(frozen=True, slots=True)
class Effects:
    """What one combination does to b stones and to the supports.

    Attributes
    ----------
    combination : Its name.
    stones : Names of the stones.
    utilisation : Local, of rigid stones that of the mean stress; NaN where no strength is known, shape (b,).
    tension, compression : Greatest and least principal value of the mean stress, shape (b,) [Pa].
    supports : Force [N] and moment [N m] by name, in one vector, shape (3,) in 2D, (6,) in 3D.
    """

    combination: str
    stones: Sequence[str]
    utilisation: FloatArray
    tension: FloatArray
    compression: FloatArray
    supports: dict[str, FloatArray]


class EffectsTold(Told, frozen=True, kw_only=True):
    """The same of a combination as it is kept; what is not known is null.

    Attributes
    ----------
    stones, utilisation, tension, compression, supports : As in ``Effects``.
    """

    stones: list[str]
    utilisation: list[float | None]
    tension: list[float | None]
    compression: list[float | None]
    supports: dict[str, list[float]]

    @classmethod
    def from_effects(cls, effects: Effects) -> EffectsTold:
        """To be kept."""
        numbers = {key: getattr(effects, key).tolist() for key in ("utilisation", "tension", "compression")}
        return cls(
            stones=list(effects.stones),
            supports={name: np.asarray(force).tolist() for name, force in effects.supports.items()},
            **{key: [None if np.isnan(one) else one for one in own] for key, own in numbers.items()},
        )

    def of(self, combination: str) -> Effects:
        """What was kept, of a combination of that name."""
        utilisation, tension, compression = (
            np.array(own, dtype=float) for own in (self.utilisation, self.tension, self.compression)
        )
        supports = {name: np.array(force) for name, force in self.supports.items()}
        return Effects(combination, self.stones, utilisation, tension, compression, supports)


class CombinationEnd(Told, frozen=True, kw_only=True):
    """How a combination has ended.

    Attributes
    ----------
    outcome, message : Verdict, and the same as a sentence.
    effects : What it does; None where it came to no good end.
    """

    outcome: str
    message: str
    effects: EffectsTold | None


@dataclass(frozen=True, slots=True)
class Extremes:
    """Extreme values of several things and the combinations that have them.

    Attributes
    ----------
    names : What they are of. value : Of each; NaN where none is known.
    combination : Name of the first combination that has it.
    """

    names: Sequence[str]
    value: FloatArray
    combination: list[str]

    def told(self, number: int) -> Governed:
        """One of them."""
        return Governed(value=float(self.value[number]), combination=self.combination[number])

    def stone(self, number: int) -> StoneGoverned:
        """One of them, of a stone."""
        return StoneGoverned(
            value=float(self.value[number]), combination=self.combination[number], block=self.names[number]
        )


@dataclass(frozen=True, slots=True)
class Envelope:
    """Extremes over combinations, of stones and by components of each support.

    Attributes
    ----------
    utilisation, tension, compression : As of ``Effects``, of each stone.
    supports : Least and greatest of each component, by name.
    """

    utilisation: Extremes
    tension: Extremes
    compression: Extremes
    supports: dict[str, tuple[Extremes, Extremes]]


def envelope(effects: Sequence[Effects]) -> Envelope:
    """The extremes over at least one combination of the same stones and supports."""
    names, stones = [one.combination for one in effects], effects[0].stones

    def most(values: Sequence[FloatArray], of: Sequence[str], sign: float) -> Extremes:
        stacked = np.array(values)
        at = np.where(np.isnan(stacked), -np.inf, sign * stacked).argmax(axis=0)
        return Extremes(of, stacked[at, np.arange(stacked.shape[1])], [names[run] for run in at.tolist()])

    supports = {}
    for support, first in effects[0].supports.items():
        values, axes = [one.supports[support] for one in effects], components(len(first))
        supports[support] = (most(values, axes, -1.0), most(values, axes, 1.0))
    return Envelope(
        most([one.utilisation for one in effects], stones, 1.0),
        most([one.tension for one in effects], stones, 1.0),
        most([one.compression for one in effects], stones, -1.0),
        supports,
    )


def components(count: int) -> tuple[str, ...]:
    """Names of the components of a force and moment in one vector of so many numbers, with units."""
    if count == 3:  # a plane scene, per metre
        return ("force_x [N/m]", "force_y [N/m]", "moment [N]")
    return (*(f"force_{axis} [N]" for axis in "xyz"), *(f"moment_{axis} [N m]" for axis in "xyz"))


def combinations_told(runs: Sequence[CombinationTold], found: Envelope | None, shown: str) -> Combinations:
    """What ``summary.json`` says.

    Parameters
    ----------
    runs : All combinations. found : Their envelope; None where none came to a good end.
    shown : Name of the one that the summary is of.
    """
    if found is None:
        return Combinations(runs=tuple(runs), shown=shown, supports={})
    used = found.utilisation
    known = np.flatnonzero(~np.isnan(used.value))
    order = known[np.argsort(-used.value[known], kind="stable")][:TOP].tolist()
    stressed = np.flatnonzero(~np.isnan(found.tension.value))
    low = high = None
    if stressed.size:
        low = found.compression.stone(int(stressed[found.compression.value[stressed].argmin()]))
        high = found.tension.stone(int(stressed[found.tension.value[stressed].argmax()]))
    return Combinations(
        runs=tuple(runs),
        shown=shown,
        utilisation=tuple(map(used.stone, order)) or None,
        compression=low,
        tension=high,
        supports={
            name: SupportEnvelope(
                least=tuple(map(least.told, range(len(least.names)))),
                greatest=tuple(map(greatest.told, range(len(greatest.names)))),
            )
            for name, (least, greatest) in found.supports.items()
        },
    )


class AtPlace(Told, frozen=True, kw_only=True):
    """An extreme value over places.

    Attributes
    ----------
    value : In the unit of what it is of. place : Distance along the path where it is first met [m].
    of : The stone or joint; None where the value is of a support, which is named elsewhere.
    """

    value: float
    place: float
    of: str | None = None


class SupportOverPlaces(Told, frozen=True, kw_only=True):
    """What a support gives to the blocks, by components of the force [N], then of the moment [N m].

    Attributes
    ----------
    least, greatest : Of each component, shape (3,) in 2D, (6,) in 3D.
    """

    least: tuple[AtPlace, ...]
    greatest: tuple[AtPlace, ...]


class Places(Told, frozen=True, kw_only=True):
    """Places of the first load that moves, distances of its first axle along its path [m].

    Attributes
    ----------
    count : At how many it stood. first, last : The first and last of them; None where there are none.
    fell_at : Where there was no equilibrium; None: everywhere there was.
    utilisation : Greatest of a stone; None where none has a strength.
    compression, tension : Least and greatest principal value of stones' mean stresses [Pa].
    edge_share : Nearest that the thrust came to the edge of a joint, where it is 1, by label.
    friction_used : Greatest share of the friction of a joint, by label.
    supports : By name.
    """

    count: int
    first: float | None
    last: float | None
    fell_at: float | None = None
    utilisation: AtPlace | None = None
    compression: AtPlace | None = None
    tension: AtPlace | None = None
    edge_share: dict[str, AtPlace]
    friction_used: dict[str, AtPlace]
    supports: dict[str, SupportOverPlaces]
