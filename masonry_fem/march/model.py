"""Model: everything a march needs, composed from a scene; nothing in it changes in time.

Where blocks move far ``update`` makes another model of it, with the contacts that there are then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import BodyGroup, Scheme
from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.joints.assignment import Assignment
from masonry_fem.march.moving import Travel
from masonry_fem.march.shaking import Shaking
from masonry_fem.solid.assembly import Assembly

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Load:
    """A force pattern times a function of time.

    Attributes
    ----------
    name : As in the scene.
    forces : Pattern on each body group, the group's own array; None where it does not act. Of a load that
        moves, where it begins.
    factor : Function of time [s], or of the load factor in statics.
    travel : How it moves; None: it stays.
    follows : Whether its directions turn with the blocks; the pattern is that of the reference.
    """

    name: str
    forces: tuple[FloatArray | None, ...]
    factor: Callable[[float], float]
    travel: Travel | None = None
    follows: bool = False

    def pattern(self, groups: tuple[BodyGroup, ...], time: float) -> tuple[FloatArray | None, ...]:
        """The forces where the load is at a time.

        Parameters
        ----------
        groups : Body groups. time : In [s], or the load factor.
        """
        travel = self.travel
        return self.forces if travel is None else travel.forces(groups, travel.place(time))


@dataclass(slots=True)
class LastForces:
    """Forces that loads gave when they were asked for last, with what they were for."""

    loads: tuple[Load, ...] = ()
    groups: tuple[BodyGroup, ...] = ()
    factors: tuple[tuple[float, float], ...] = ()
    forces: tuple[FloatArray, ...] | None = None


@dataclass(frozen=True, slots=True)
class Probe:
    """A named material point whose displacement is reported.

    Attributes
    ----------
    name : As in the scene.
    group : Number of the body group. body : Block within it.
    point : Where the point is in the reference, shape (d,) [m].
    """

    name: str
    group: int
    body: int
    point: FloatArray


@dataclass(frozen=True, slots=True)
class Control:
    """A displacement that a march prescribes in place of the load factor.

    Attributes
    ----------
    probe : The point that goes.
    against : The point that it goes away from; None: where it was.
    direction : Unit vector, shape (d,).
    distance : How far it goes in all [m].
    """

    probe: Probe
    against: Probe | None
    direction: FloatArray
    distance: float


class Update(Protocol):
    """How contacts follow blocks that move far."""

    @property
    def every(self) -> int:
        """Steps between two detections."""
        ...

    def __call__(
        self,
        model: Model,
        bodies: tuple[Any, ...],
        time: float,
        scheme: Scheme,
        held: NDArray[np.bool_],
    ) -> Model:
        """The model with the contacts of given states, which are to last for ``every`` steps.

        ``held`` are the contacts that cohesion holds, shape (c,).
        """
        ...


class Meet(Protocol):
    """How blocks that meet become contacts."""

    @property
    def angle(self) -> float:
        """Largest angle between faces that are in contact [degrees]."""
        ...

    def __call__(
        self,
        model: Model,
        before: tuple[Any, ...],
        after: tuple[Any, ...],
        pairs: NDArray[np.int64],
        held: NDArray[np.bool_],
        *,
        slid: bool = False,
    ) -> tuple[Model, NDArray[np.int64]]:
        """The model with the contacts of ``pairs`` (m, 2) of blocks found anew, and which old ones it keeps.

        They met between two states. The old contacts of a pair make way unless one of them is ``held`` (c,);
        of pairs that ``slid`` off each other also where none are found. The kept ones, (k,), come first.
        """
        ...


type Ageing = Callable[[Model, float], Model]


@dataclass(frozen=True, slots=True)
class Model:
    """Blocks, contacts and loads, ready to march.

    Attributes
    ----------
    assembly : Blocks and shapes, geometry.
    groups : Body groups; together they hold each block once.
    interfaces : Common faces of blocks.
    contacts : Contact points on them.
    laws : What joints do there.
    loads : What acts, by group.
    probes : Named points.
    length : A typical block size [m], for tolerances and pictures.
    scatter : Factors by which joint properties differ from place to place, by parameter, shape (c,).
    expulsion : Speed at which overlaps are driven apart in the gap form [m/s]; 0 holds them.
    update : What finds the contacts anew during a march; None: they stay.
    meet : What makes contacts of blocks that meet on the way; None: they go through each other.
    reach : Gap that is a contact at the start [m].
    control : What the load factor follows from; None: it is given.
    keeps_tangents : Whether stones that yield keep the tangents of a step's first round in the further ones.
    changing : Time until which loads or supports change: rest before that is no end of a march [s].
    fixed : Whether frames and lever arms stay those of the start, too (small kinematics).
    joint_records : Number of the scene's joint record of each interface.
    ground : What shakes the ground; None: nothing.
    found : Whether contacts were found on the way, where blocks had gone.
    ageing : Makes the model whose materials have changed by a time [s] or load factor; None: none change.
    last_forces : What ``external_forces`` keeps, as loads seldom change.
    """

    assembly: Assembly
    groups: tuple[BodyGroup, ...]
    interfaces: Interfaces
    contacts: Contacts
    laws: Assignment
    loads: tuple[Load, ...]
    probes: tuple[Probe, ...]
    length: float
    scatter: Mapping[str, FloatArray] = field(default_factory=dict)
    expulsion: float = 0.0
    update: Update | None = None
    changing: float = 0.0
    fixed: bool = False
    meet: Meet | None = None
    reach: float = 0.0
    control: Control | None = None
    keeps_tangents: bool = False
    joint_records: tuple[int, ...] = ()
    ground: Shaking | None = None
    found: bool = False
    ageing: Ageing | None = None
    last_forces: LastForces = field(default_factory=LastForces, compare=False, repr=False)
