"""Meeting: contacts of blocks that were found in each other after a step, where they were before it.

    meeting = Meeting(scene, stones, base)
    model, kept = meeting(model, before, after, pairs, held)

Blocks of any kind: where elastic ones are deformed, faces are looked for on the solids that come nearest to
them, and gaps are those of the deformed meshes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.build.joints import joint_of_interfaces, joints_at, rules_of, touching
from masonry_fem.build.stones import Stones
from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.detection import default_reach, detect
from masonry_fem.contact.interfaces import Interfaces, among
from masonry_fem.contact.place import place
from masonry_fem.contact.surface import Surface, surfaces_of
from masonry_fem.contact.update import chosen, joined, moved, partners, returned, returned_faces
from masonry_fem.march.model import FloatArray, Model
from masonry_fem.march.motion import nearest_motions
from masonry_fem.march.renewal import NEAR
from masonry_fem.scene import specs
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray

STEEPEST = 40.0  # largest angle between faces that may come into contact [degrees]
DEEP = 5e-2  # of a block's size: largest overlap of blocks that bear on each other as they are found anew
AHEAD = 2.0  # times the blocks' displacement in the step: distance within which blocks are examined


@dataclass(frozen=True)
class Meeting:
    """How blocks that meet during a march become contacts.

    Attributes
    ----------
    scene, stones, base : What the model was built from.
    """

    scene: specs.Scene
    stones: Stones
    base: Path

    def __call__(
        self,
        model: Model,
        before: tuple[Any, ...],
        after: tuple[Any, ...],
        pairs: IntArray,
        held: np.ndarray,
        *,
        slid: bool = False,
    ) -> tuple[Model, IntArray]:
        """The model with the contacts of ``pairs`` (m, 2) of blocks found anew, and which old ones it keeps.

        The old contacts of a pair make way, unless one of them is among the ``held`` (c,), or properties
        scatter: then those found far from them are added. The same model where nothing changes.

        Parameters
        ----------
        model : With the contacts so far.
        before, after : Body states at the start of a step, where contacts are looked for, and at its end.
        pairs : Blocks that are in each other at its end.
        held : Contacts that stay.
        slid : Whether the pairs bear past the ends of their faces: they lose their contacts also where none
            are found.

        Returns
        -------
        The model, and the numbers of the old contacts with which its contacts begin, (k,).
        """
        every = np.arange(model.contacts.count)
        if slid and self._scatters:
            return model, every
        motion, later = nearest_motions(model, before), nearest_motions(model, after)
        used = np.unique(pairs)
        trace = np.einsum("bij,bij->b", motion[0][used], later[0][used])  # 1 + 2 cos φ, in 2D 2 cos φ
        cosine = np.clip(0.5 * (trace - (model.assembly.dimension - 2)), -1.0, 1.0)
        angle = math.degrees(math.acos(float(cosine.min())))
        way = np.concatenate(
            [
                group.positions(end) - group.positions(start)
                for group, start, end in zip(model.groups, before, after, strict=True)
            ]
        )
        far = default_reach(self.stones.assembly) + AHEAD * float(
            np.linalg.norm(way, axis=1).max(initial=0.0)
        )
        placed = _moved(self.stones.assembly, motion, used)
        stones = replace(self.stones, assembly=placed)
        deep = max(far, DEEP * model.length) if slid else far
        found = self._faces(placed, used, pairs, (far, deep), angle)
        fresh, records = touching(self.scene, stones, found, tell=False)
        if not fresh and not slid:
            return model, every
        contacts = place(placed, fresh, rules_of(self.scene, stones, fresh, records), self._surfaces)
        gone = pairs if slid else fresh.pairs
        keep, new = self._parted(model, motion, fresh, contacts, held, gone)
        if not new.any() and keep.all():
            return model, every
        fresh, contacts = chosen(fresh, contacts, new)
        turned = np.zeros(len(placed.blocks), dtype=bool)
        for group in model.groups:
            turned[group.blocks] = group.turns
        back = _unturned(returned(contacts, *motion), contacts, turned)
        back = replace(back, gap=np.zeros(back.count))  # forces act on both blocks in one point
        old = chosen(model.interfaces, model.contacts, keep)
        interfaces, contacts = joined(old, (returned_faces(fresh, *motion), back))
        # no warnings of gaps: those that arise during the march do not come from the scene
        closed = replace(contacts, gap=np.zeros(contacts.count))
        joints = joint_of_interfaces(self.scene, self.stones, old[0], tell=False)
        joints += [records[number] for number in np.flatnonzero(new)]
        laws, scatter = joints_at(self.scene, self.stones, interfaces, closed, joints, self.base)
        made = replace(
            model,
            interfaces=interfaces,
            contacts=contacts,
            laws=laws,
            scatter=scatter,
            joint_records=tuple(joints),
            found=True,
        )
        return made, every[keep[model.contacts.interface]]

    @property
    def angle(self) -> float:
        """Largest angle between faces that are in contact [degrees]."""
        return self.scene.contact.angle

    def _parted(
        self, model: Model, motion: tuple[FloatArray, FloatArray], fresh: Interfaces,
        contacts: Contacts, held: np.ndarray, gone: IntArray,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Which interfaces of the model stay, and which fresh ones are taken; those of pairs ``gone`` go."""
        known, ties = model.interfaces.pairs, model.interfaces.tie
        tied = known[~ties] if self._scatters else known[model.contacts.interface[held]]
        block, point = model.contacts.blocks[:, 0], model.contacts.points[:, 0]
        now = np.einsum("cij,cj->ci", motion[0][block], point) + motion[1][block]
        near = partners(model.contacts, now, contacts, contacts.points[:, 0], NEAR * model.length)
        far = np.bincount(contacts.interface[near < 0], minlength=len(fresh)) > 0
        return ~among(known, gone) | among(known, tied) | ties, far | ~among(fresh.pairs, tied)

    @property
    def _scatters(self) -> bool:
        """Whether properties belong to joints one by one, in their order."""
        return any(joint.scatter is not None for joint in self.scene.joints)

    @cached_property
    def _surfaces(self) -> tuple[Surface, ...]:
        return surfaces_of(self.stones.assembly)

    def _faces(
        self, placed: Assembly, used: IntArray, pairs: IntArray, within: tuple[float, float], turned: float
    ) -> Interfaces:
        """Common faces of the pairs among the blocks in use, ``within`` a gap and an overlap."""
        angle = self.scene.contact.angle
        few = replace(placed, blocks=placed.blocks.only(used))
        found = detect(
            few, reach=within[0], overlap=within[1], angle=max(angle, min(STEEPEST, angle + turned)),
            surfaces=self._surfaces, tell=False, corners=True,
        )  # fmt: skip
        named = replace(found, blocks=used[found.blocks])
        return named.only(among(named.pairs, np.sort(pairs, axis=1)))


def _moved(assembly: Assembly, motion: tuple[FloatArray, FloatArray], used: IntArray) -> Assembly:
    """The assembly with the blocks in use where they are."""
    turn, shift = np.zeros_like(motion[0]), np.zeros_like(motion[1])
    turn[:] = np.eye(assembly.dimension)
    turn[used], shift[used] = motion[0][used], motion[1][used]
    return moved(assembly, turn, shift)


def _unturned(back: Contacts, found: Contacts, turned: np.ndarray) -> Contacts:
    """Contacts in the reference with the frames as found on antagonists that do not turn."""
    keeps = turned[found.blocks[:, 1]]
    return replace(back, frame=np.where(keeps[:, None, None], back.frame, found.frame))
