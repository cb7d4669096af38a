"""Places: what a load that moves leads to, over all places where it stood."""

from __future__ import annotations

from masonry_fem.records.told import Told


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
