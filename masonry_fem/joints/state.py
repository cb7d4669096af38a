"""JointState: what a joint law remembers of its contact points.

One class for all laws, so that a checkpoint, an output field or a mixture of laws needs no case
distinction. A state is replaced, never changed: the committed one stays as it was while trial ones
are made from it.

    arrays = state.arrays(); state = JointState(**arrays)
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

# what a step's iteration has to bring to rest; dry joints hand it on as it is
SETTLING = ("broken", "crushing", "adhesion", "obliquity", "opening", "dilation", "compacted", "own")

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class JointState:
    """What joints remember of their past: the state of c contact points in d dimensions.

    Attributes
    ----------
    adhesion : Intensity of adhesion β, 1 intact, 0 broken, shape (c,).
    broken : True where nothing of the cohesion is left, shape (c,).
    opening : Residual plastic opening [m], shape (c,).
    dilation : Opening that sliding forces on a rough joint [m], shape (c,).
    raised : ``dilation`` at the start of the step under way, shape (c,).
    elastic : Deformation of an elastic bed in series, part of the jump [m], shape (c, d).
    crushed : Part of a bed's deformation that stays, ≤ 0 [m], shape (c,).
    crushing : True where the bed crushes in the step under way, shape (c,).
    obliquity : Shear over pressure on a bed that crushes under both, shape (c,).
    pressed : Pressure on a bed that crushes [Pa], shape (c,).
    following : Shear that comes with more of that pressure, dτ/dσ, shape (c,).
    bedded : Deformation of the bed at the start of the step under way [m], shape (c, d).
    closing : Deformation of asperities that close, in series, part of the jump [m], shape (c, d).
    closed : The same at the start of the step under way [m], shape (c, d).
    settled : Part of ``closing`` that stays without a reaction [m], shape (c, d).
    compacted : Greatest pressure that these have borne [Pa], shape (c,).
    apart : How far the faces were from each other where the jump was 0 [m], shape (c,).
    jump : Displacement jump that the cohesion feels (without bed) [m], shape (c, d).
    slip : Length of the path slid over in frictional sliding [m], shape (c,).
    sliding : True where the contact slid at the end of the last committed step, shape (c,).
    slides : The same for the step under way, shape (c,).
    demand : Largest stress over strength, 1 at the law's threshold, shape (c,).
    dissipated : Energy lost to damage, viscosity and plastic opening so far [J], shape (c,).
    delayed : Part of it that the delay of viscous damage burned [J], shape (c,).
    rubbed : Energy lost to friction so far [J], shape (c,).
    own : What a law remembers beyond all that, shape (c, m); as wide as the law that needs most.
    """

    adhesion: FloatArray
    broken: Mask
    opening: FloatArray
    dilation: FloatArray
    raised: FloatArray
    elastic: FloatArray
    crushed: FloatArray
    crushing: Mask
    obliquity: FloatArray
    pressed: FloatArray
    following: FloatArray
    bedded: FloatArray
    closing: FloatArray
    closed: FloatArray
    settled: FloatArray
    compacted: FloatArray
    apart: FloatArray
    jump: FloatArray
    slip: FloatArray
    sliding: Mask
    slides: Mask
    demand: FloatArray
    dissipated: FloatArray
    delayed: FloatArray
    rubbed: FloatArray
    own: FloatArray

    @classmethod
    def intact(cls, count: int, dimension: int, memory: int = 0) -> JointState:
        """Fresh joints: full adhesion, nothing else; ``memory`` numbers a contact of the law's own, 0."""
        return cls(
            adhesion=np.ones(count),
            broken=np.zeros(count, dtype=bool),
            opening=np.zeros(count),
            dilation=np.zeros(count),
            raised=np.zeros(count),
            elastic=np.zeros((count, dimension)),
            crushed=np.zeros(count),
            crushing=np.zeros(count, dtype=bool),
            obliquity=np.zeros(count),
            pressed=np.zeros(count),
            following=np.zeros(count),
            bedded=np.zeros((count, dimension)),
            closing=np.zeros((count, dimension)),
            closed=np.zeros((count, dimension)),
            settled=np.zeros((count, dimension)),
            compacted=np.zeros(count),
            apart=np.zeros(count),
            jump=np.zeros((count, dimension)),
            slip=np.zeros(count),
            sliding=np.zeros(count, dtype=bool),
            slides=np.zeros(count, dtype=bool),
            demand=np.zeros(count),
            dissipated=np.zeros(count),
            delayed=np.zeros(count),
            rubbed=np.zeros(count),
            own=np.zeros((count, memory)),
        )

    @classmethod
    def dry(cls, count: int, dimension: int) -> JointState:
        """Joints without any cohesion from the start."""
        fresh = cls.intact(count, dimension)
        return replace(fresh, adhesion=np.zeros(count), broken=np.ones(count, dtype=bool))

    @property
    def count(self) -> int:
        """Number of contact points c."""
        return len(self.adhesion)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.jump.shape[1])

    @property
    def bed(self) -> FloatArray:
        """Deformation of an elastic bed, crushing included [m], shape (c, d)."""
        deformation = self.elastic.copy()
        deformation[:, 0] += self.crushed
        return deformation

    @property
    def given_way(self) -> FloatArray:
        """Deformation of all that lies in series with the faces, bed and asperities [m], shape (c, d)."""
        return self.bed + self.closing

    def committed(self) -> JointState:
        """The state at the start of the next step."""
        return replace(
            self,
            sliding=self.slides,
            bedded=self.bed,
            closed=self.closing,
            crushing=np.zeros(self.count, dtype=bool),
            raised=self.dilation,
        )

    def arrays(self) -> dict[str, Any]:
        """All arrays by name, for a checkpoint."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def take(self, contacts: NDArray[Any]) -> JointState:
        """The state of some of the contact points."""
        return JointState(**{name: values[contacts] for name, values in self.arrays().items()})

    def put(self, contacts: NDArray[Any], part: JointState) -> JointState:
        """The same with ``part`` in the place of some contact points."""
        merged = {name: values.copy() for name, values in self.arrays().items()}
        for name, values in part.arrays().items():
            if name == "own":
                merged[name][contacts, : values.shape[1]] = values
            else:
                merged[name][contacts] = values
        return JointState(**merged)

    def remember(self, *values: FloatArray) -> JointState:
        """The same with these in the first columns of ``own``, each of shape (c,)."""
        own = self.own.copy()
        own[:, : len(values)] = np.stack(values, axis=1)
        return replace(self, own=own)

    def distance(self, other: JointState) -> float:
        """Largest difference that a step's iteration has to bring down.

        Adhesion, rupture, crushing and its obliquity count as they are, openings relative to the largest
        jump, greatest pressures and a law's own numbers relative to the largest of their kind. What a layer
        in series gives way does not count: it follows from the reaction, no reduction hangs on it.
        """
        if not self.count or all(getattr(self, name) is getattr(other, name) for name in SETTLING):
            return 0.0
        return float(self.differences(other).max())

    def differences(self, other: JointState) -> FloatArray:
        """The difference of each contact that ``distance`` is the largest of, shape (c,)."""
        found = ((self.broken != other.broken) | (self.crushing != other.crushing)).astype(float)

        def see(name: str, size: float) -> None:
            if size > 0:
                change = np.abs(getattr(self, name) - getattr(other, name)) / size
                np.maximum(found, change, out=found)

        for name in ("adhesion", "obliquity"):
            see(name, 1.0)
        for name in ("opening", "dilation"):
            see(name, max(float(np.abs(part).max()) for part in (getattr(self, name), self.jump)))
        see("compacted", float(np.maximum(self.compacted, other.compacted).max()))
        largest = np.abs(self.own).max(axis=0)
        moved = np.abs(self.own - other.own)
        own = np.divide(moved, largest, out=moved.copy(), where=largest > 0)
        differences: FloatArray = np.maximum(found, own.max(axis=1, initial=0.0))
        return differences
