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
from masonry_fem.contact.contacts import Contacts, Interface
from masonry_fem.contact.detection import default_reach, detect
from masonry_fem.contact.place import place
from masonry_fem.contact.surface import Surface, surfaces_of
from masonry_fem.contact.update import chosen, joined, partners, returned, returned_faces
from masonry_fem.march.model import FloatArray, Model
from masonry_fem.march.renewal import NEAR
from masonry_fem.scene import specs
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import Pose

STEEPEST = 40.0  # largest angle between faces that may come into contact [degrees]
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
    ) -> tuple[Model, IntArray]:
        """The model with the contacts of ``pairs`` (m, 2) of blocks found anew, and which old ones it keeps.

        The old contacts of a pair make way, unless one of them is among the ``held`` (c,), or properties
        scatter: then those found far from them are added. The same model where nothing is found.

        Parameters
        ----------
        model : With the contacts so far.
        before, after : Body states at the start of a step, where contacts are looked for, and at its end.
        pairs : Blocks that are in each other at its end.
        held : Contacts that stay.

        Returns
        -------
        The model, and the numbers of the old contacts with which its contacts begin, (k,).
        """
        every = np.arange(model.contacts.count)
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
        found = self._faces(placed, used, pairs, far, angle)
        fresh, records = touching(self.scene, stones, found, tell=False)
        if not fresh:
            return model, every
        contacts = place(placed, fresh, rules_of(self.scene, stones, fresh, records), self._surfaces)
        keep, new = self._parted(model, motion, fresh, contacts, held)
        if not new.any():
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

    def _parted(
        self, model: Model, motion: tuple[FloatArray, FloatArray], fresh: tuple[Interface, ...],
        contacts: Contacts, held: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Which interfaces of the model stay, and which fresh ones are taken."""
        keys = np.array([len(model.assembly.blocks), 1])
        known, anew = (
            np.sort(np.array([one.blocks for one in each], dtype=np.int64).reshape(-1, 2), axis=1) @ keys
            for each in (model.interfaces, fresh)
        )
        ties = np.array([one.tie for one in model.interfaces], dtype=bool)
        tied = known[~ties] if self._scatters else known[model.contacts.interface[held]]
        block, point = model.contacts.blocks[:, 0], model.contacts.points[:, 0]
        now = np.einsum("cij,cj->ci", motion[0][block], point) + motion[1][block]
        near = partners(model.contacts, now, contacts, contacts.points[:, 0], NEAR * model.length)
        far = np.bincount(contacts.interface[near < 0], minlength=len(fresh)) > 0
        return ~np.isin(known, anew) | np.isin(known, tied) | ties, far | ~np.isin(anew, tied)

    @property
    def _scatters(self) -> bool:
        """Whether properties belong to joints one by one, in their order."""
        return any(joint.scatter is not None for joint in self.scene.joints)

    @cached_property
    def _surfaces(self) -> tuple[Surface, ...]:
        return surfaces_of(self.stones.assembly)

    def _faces(
        self, placed: Assembly, used: IntArray, pairs: IntArray, far: float, turned: float
    ) -> tuple[Interface, ...]:
        """Common faces of the pairs among the blocks in use."""
        angle = self.scene.contact.angle
        few = replace(placed, blocks=tuple(placed.blocks[block] for block in used))
        found = detect(
            few, reach=far, overlap=far, angle=max(angle, min(STEEPEST, angle + turned)),
            surfaces=self._surfaces, tell=False, corners=True,
        )  # fmt: skip
        wanted = {tuple(pair) for pair in pairs.tolist()}
        named = [replace(one, blocks=(int(used[one.blocks[0]]), int(used[one.blocks[1]]))) for one in found]
        return tuple(one for one in named if tuple(sorted(one.blocks)) in wanted)


def nearest_motions(model: Model, bodies: tuple[Any, ...]) -> tuple[FloatArray, FloatArray]:
    """The rigid motions x = R X + t that come nearest to what blocks have done, (b, d, d), (b, d) [m].

    Parameters
    ----------
    model : The structure of b blocks.
    bodies : Body states, one a group.
    """
    count, d = len(model.assembly.blocks), model.assembly.dimension
    rotation, translation = np.tile(np.eye(d), (count, 1, 1)), np.zeros((count, d))
    for group, state in zip(model.groups, bodies, strict=True):
        rotation[group.blocks], translation[group.blocks] = group.motion(state)
    return rotation, translation


def _moved(assembly: Assembly, motion: tuple[FloatArray, FloatArray], used: IntArray) -> Assembly:
    """The assembly with the blocks in use where they are."""
    blocks = list(assembly.blocks)
    for number in used.tolist():
        pose, turn = blocks[number].pose, motion[0][number]
        moved = Pose(turn @ pose.rotation, turn @ pose.translation + motion[1][number])
        blocks[number] = replace(blocks[number], pose=moved)
    return replace(assembly, blocks=tuple(blocks))


def _unturned(back: Contacts, found: Contacts, turned: np.ndarray) -> Contacts:
    """Contacts in the reference with the frames as found on antagonists that do not turn."""
    keeps = turned[found.blocks[:, 1]]
    return replace(back, frame=np.where(keeps[:, None, None], back.frame, found.frame))
