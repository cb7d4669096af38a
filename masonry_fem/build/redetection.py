"""Redetection: the contacts of rigid blocks that have moved far, found anew during a march.

    update = Redetection(scene, stones, base, every=10)
    model = update(model, state.bodies, state.time, scheme, held)

Pairs of rigid blocks (supports among them) are detected where the blocks are now. Pairs with an
elastic block keep the contacts that they have, and so do those that cohesion still holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.bodies.base import Scheme
from masonry_fem.build.joints import joint_of_interfaces, joints_at, rules_of, touching
from masonry_fem.build.meeting import DEEP
from masonry_fem.build.stones import Stones, typical_length
from masonry_fem.contact.detection import default_reach, detect
from masonry_fem.contact.interfaces import Interfaces, among
from masonry_fem.contact.place import place
from masonry_fem.contact.surface import Surface, surfaces_of
from masonry_fem.contact.update import chosen, joined, moved, returned, returned_faces
from masonry_fem.march.loads import external_forces
from masonry_fem.march.model import FloatArray, Model
from masonry_fem.march.motion import BlockMotion, nearest_motions
from masonry_fem.scene import specs
from masonry_fem.solid.mesh import IntArray

AHEAD = 2.0  # times the blocks' expected displacement until the next detection: reach of this one
STEEPEST = 40.0  # largest angle between faces that may come into contact [degrees]


@dataclass(frozen=True, slots=True)
class Redetection:
    """How a model's contacts follow blocks that move far.

    Attributes
    ----------
    scene, stones, base : What the model was built from. every : Steps between detections.
    surfaces : Those of the shapes. reach : Gap that is a contact of blocks at rest [m].
    length : A typical block size [m]. extent : Diagonals of the blocks' boxes, shape (b,) [m].
    """

    scene: specs.Scene
    stones: Stones
    base: Path
    every: int
    surfaces: tuple[Surface, ...]
    reach: float
    length: float
    extent: FloatArray

    @classmethod
    def of(cls, scene: specs.Scene, stones: Stones, base: Path) -> Redetection:
        """As a scene wants it."""
        assembly, reach = stones.assembly, scene.contact.reach
        extent = [float(np.linalg.norm(np.ptp(shape.solid.vertices, axis=0))) for shape in assembly.shapes]
        return cls(
            scene,
            stones,
            base,
            scene.contact.every,
            surfaces_of(assembly),
            default_reach(assembly) if reach is None else reach,
            typical_length(assembly),
            np.array(extent)[assembly.blocks.shape],
        )

    def __call__(
        self, model: Model, bodies: tuple[Any, ...], time: float, scheme: Scheme, held: np.ndarray
    ) -> Model:
        """The model with the contacts of the given states, which are to last for ``every`` steps.

        ``held`` are the contacts that cohesion holds, shape (c,).
        """
        rotation, translation = nearest_motions(model, bodies)
        rigid = np.ones(len(rotation), dtype=bool)
        for group in model.groups:
            rigid[group.blocks] = not group.deforms
        stones = replace(self.stones, assembly=moved(self.stones.assembly, rotation, translation))
        keep = _kept(model, held, rigid)
        bound = model.interfaces.only(keep & ~model.interfaces.tie)
        found = self._found(stones, self._paths(model, bodies, time, scheme))
        found = found.only(self._fresh(found, rigid, bound))
        fresh, records = touching(self.scene, stones, found, tell=False)
        contacts = place(stones.assembly, fresh, rules_of(self.scene, stones, fresh, records), self.surfaces)
        old = chosen(model.interfaces, model.contacts, keep)
        records = joint_of_interfaces(self.scene, self.stones, old[0], tell=False) + records
        faces = returned_faces(fresh, rotation, translation)
        interfaces, contacts = joined(old, (faces, returned(contacts, rotation, translation)))
        # no warnings of gaps: those that arise during the march do not come from the scene
        closed = replace(contacts, gap=np.zeros(contacts.count))
        laws, scatter = joints_at(self.scene, self.stones, interfaces, closed, records, self.base)
        return replace(
            model,
            interfaces=interfaces,
            contacts=contacts,
            laws=laws,
            scatter=scatter,
            joint_records=tuple(records),
            found=True,
        )

    def _found(self, stones: Stones, paths: _Paths) -> Interfaces:
        """Interfaces of the blocks where they are, those among them that may close on the way."""
        angle = self.scene.contact.angle
        turned = AHEAD * math.degrees(float(paths.turn.max(initial=0.0)))
        found = detect(
            stones.assembly,
            reach=self.reach + paths.longest,
            overlap=max(self.reach, DEEP * self.length),
            angle=max(angle, min(STEEPEST, angle + turned)),
            surfaces=self.surfaces,
            tell=False,
        )
        return found.only(found.nearest <= self.reach + paths.between(*found.blocks.T))

    def _paths(self, model: Model, bodies: tuple[Any, ...], time: float, scheme: Scheme) -> _Paths:
        interval, assembly = self.every * scheme.step, model.assembly
        pulled, motion = 0.0, BlockMotion.of(model, bodies, bodies)
        for group, force in zip(model.groups, external_forces(model, time, bodies), strict=True):
            if not group.prescribed and scheme.inertia > 0:
                push = np.linalg.norm(group.resultant(force)[:, : assembly.dimension], axis=1) / group.mass
                pulled = max(pulled, 0.5 * interval**2 * float(push.max(initial=0.0)))
        turn = interval * np.linalg.norm(motion.spin, axis=1)
        return _Paths(interval * motion.velocity, turn, self.extent, pulled)

    def _fresh(self, found: Interfaces, rigid: np.ndarray, bound: Interfaces) -> np.ndarray:
        """Those between rigid blocks of which one can move, of pairs that are not bound, shape (i,)."""
        free = self.stones.where(lambda fidelity: fidelity is not None)
        moves = free[found.blocks].any(axis=1) & rigid[found.blocks].all(axis=1)
        fresh: np.ndarray = moves & ~among(found.pairs, bound.pairs)
        return fresh


def _kept(model: Model, held: np.ndarray, rigid: np.ndarray) -> np.ndarray:
    """Interfaces that stay: with an elastic block, of blocks that cohesion still holds, and ties, (i,)."""
    if not model.interfaces:
        return np.zeros(0, dtype=bool)
    pairs = model.interfaces.pairs
    _, number = np.unique(pairs, axis=0, return_inverse=True)
    tied = np.zeros(len(pairs), dtype=bool)
    tied[model.contacts.interface[held]] = True
    together = np.zeros(len(pairs), dtype=bool)
    together[number[tied]] = True
    kept: np.ndarray = together[number] | ~rigid[pairs].all(axis=1) | model.interfaces.tie
    return kept


@dataclass(frozen=True, slots=True)
class _Paths:
    """How far blocks go until the next detection.

    Attributes
    ----------
    shift : Of their centres, shape (b, d) [m]. turn : Angles, shape (b,) [rad].
    size : The blocks' extents, shape (b,) [m]. pulled : What loads may add [m].
    """

    shift: FloatArray
    turn: FloatArray
    size: FloatArray
    pulled: float

    def between(self, first: IntArray, second: IntArray) -> FloatArray:
        """How much nearer two blocks can come, pair by pair [m]."""
        nearer: FloatArray = np.linalg.norm(self.shift[first] - self.shift[second], axis=-1) + sum(
            self.turn[one] * self.size[one] for one in (first, second)
        )
        return AHEAD * (nearer + 2 * self.pulled)

    @property
    def longest(self) -> float:
        """The most that any two come nearer [m]."""
        own = np.linalg.norm(self.shift, axis=1) + self.turn * self.size
        return 2 * AHEAD * float(own.max(initial=0.0) + self.pulled)
