"""Lookout: where blocks have got into each other, looked for anew whenever something has moved.

    lookout = Lookout(model, bodies)
    lookout.look(bodies)                     # each step
    lookout.found                            # pairs and depths; None while nothing has moved
    lookout.known(model, state, pairs)       # of these at the start, and what beds give way

Whether two blocks were paired as contacts makes no difference. A scene that does not move pays for one
difference of its nodes' positions a step.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.contact.depth import ROUNDING, Overlaps, overlaps
from masonry_fem.contact.detection import REACH
from masonry_fem.contact.skin import Layout, Skin
from masonry_fem.march.deformation import second_order
from masonry_fem.march.model import Model
from masonry_fem.march.overhang import Ends
from masonry_fem.march.state import SystemState

SHARE = 0.25  # of the reach: how far something moves in dynamics until blocks are looked at anew
OVERLAP = 1e-3  # of the smaller block's least extent, as what a scene takes for touching is of a block's size
STILL = 5e-7  # of the model's length: what has moved no farther has not got into anything


class Lookout:
    """Overlaps of a model's blocks.

    Parameters
    ----------
    model : Of the start. bodies : Its states, from which on everything is looked at.

    Attributes
    ----------
    found : What the last look saw; None where nothing had moved far enough since the one before.
    looked : Where the nodes of all blocks were then, shape (n, d) [m].
    borne : Overlaps that are no strangers until they are deeper.
    """

    def __init__(self, model: Model, bodies: tuple[Any, ...]) -> None:
        self._model = model
        self._start = self.looked = self._positions(bodies)
        self._still = STILL * model.length
        self.borne = Overlaps(np.zeros((0, 2), dtype=np.int64), np.zeros(0))
        self.found: Overlaps | None = None

    def go_on(self, looked: FloatArray, borne: Overlaps) -> None:
        """Go on from the last look of another one.

        Parameters
        ----------
        looked : Where the nodes of all blocks were then, shape (n, d) [m].
        borne : Overlaps that are no strangers until they are deeper.
        """
        self.looked, self.borne = looked, Overlaps(borne.pairs, borne.depth.copy())

    def look(self, bodies: tuple[Any, ...], *, static: bool = False, always: bool = False) -> None:
        """Look at the blocks where something has moved by a share of the reach since the last look.

        In statics, where a step may be any way long, after each that has moved something; but not before
        blocks can have closed a gap that is no contact.
        """
        now = self._positions(bodies)
        moved = float(np.abs(now - self.looked).max(initial=0.0))
        if static:
            gone = float(np.abs(now - self._start).max(initial=0.0))
            due = moved > self._still and gone > max(0.25 * self._model.reach, self._still)
        else:
            due = moved > SHARE * REACH * self._model.length
        self.found = None
        if due or always:
            self.looked = now
            self.found = found = overlaps(self._skin, now)
            borne = _looked_up(self.keys(found.pairs), self.keys(self.borne.pairs), self.borne.depth)
            self.borne = Overlaps(found.pairs, np.minimum(borne, found.depth))

    def last_look(self, bodies: tuple[Any, ...]) -> None:
        """Look at the end at whatever has moved at all."""
        now = self._positions(bodies)
        self.look(bodies, always=float(np.abs(now - self.looked).max(initial=0.0)) > self._still)

    def strangers(self, model: Model, state: SystemState) -> IntArray:
        """Pairs among those found that contacts do not keep apart, shape (m, 2).

        Those that no contact pairs, and those that are in each other all the same, elsewhere than they touch.

        What lies on beds that give way is found no sooner than it counts as an overlap: blocks that slide
        past each other's corners are in each other before, as beds have no thickness here, and would catch.
        """
        if self.found is None or len(self.found.depth) == 0:
            return np.zeros((0, 2), dtype=np.int64)
        pairs = self.found.pairs
        borne = self.borne.depth
        touch = self._paired(model, pairs) | (self._beds(model, state)[pairs].min(axis=1) > 0) | (borne > 0)
        least = np.maximum(np.where(touch, OVERLAP, ROUNDING), second_order(model, state.bodies))
        beyond = self.found.depth - np.maximum(borne, self.known(model, state, pairs))
        strange: IntArray = pairs[beyond > least * self.sizes(pairs)]
        return strange

    @cached_property
    def ends(self) -> Ends:
        """Where the faces of the blocks end."""
        return Ends.of(self._model.assembly)

    def bear(self, pairs: IntArray) -> None:
        """Take pairs for strangers only once they are deeper in each other than the last look saw them."""
        if self.found is not None:
            deep = np.isin(self.keys(self.borne.pairs), self.keys(pairs))
            self.borne.depth[deep] = self.found.depth[deep]

    def _paired(self, model: Model, pairs: IntArray) -> np.ndarray:
        touching = model.contacts.blocks[~model.contacts.tied]
        return np.isin(self.keys(pairs), self.keys(np.sort(touching, axis=1)))

    def known(self, model: Model, state: SystemState, pairs: IntArray) -> FloatArray:
        """Overlap of pairs that is no fault: of the start, or what beds give way, shape (m,) [m]."""
        keys = self.keys(pairs)
        held = _looked_up(keys, self.keys(self._at_start.pairs), self._at_start.depth)
        # whoever slides off its own bed lies on a neighbour's, with which it has no contacts
        return held + self._beds(model, state)[pairs].min(axis=1)

    def sizes(self, pairs: IntArray) -> FloatArray:
        """Least extent of the smaller block of each pair, shape (m,) [m]."""
        least: FloatArray = self._skin.size[pairs].min(axis=1)
        return least

    def _beds(self, model: Model, state: SystemState) -> FloatArray:
        """Most that beds at each block give way, shape (b,) [m]."""
        most = np.zeros(len(model.assembly.blocks))
        given = -np.minimum(state.joints.given_way[:, 0] + state.joints.dilation, 0.0)
        given[model.contacts.tied] = 0.0
        np.maximum.at(most, model.contacts.blocks.ravel(), np.repeat(given, 2))
        return most

    @cached_property
    def _at_start(self) -> Overlaps:
        return overlaps(self._skin, self._start)

    @cached_property
    def _skin(self) -> Skin:
        return Skin.of(self._model.assembly, self._layouts())

    def _positions(self, bodies: tuple[Any, ...]) -> FloatArray:
        groups = self._model.groups
        return np.concatenate([group.positions(own) for group, own in zip(groups, bodies, strict=True)])

    def _layouts(self) -> list[Layout]:
        """Where the nodes of the blocks stand in the positions of all groups, one shape a layout."""
        shapes = self._model.assembly.blocks.shape
        layouts, start = [], 0
        for group in self._model.groups:
            meshed = group.cell is not None
            own = shapes[group.blocks]
            used = np.unique(own)
            solids = [self._model.assembly.shapes[shape] for shape in used]
            counts = [
                len(shape.mesh.points if meshed and shape.mesh is not None else shape.solid.vertices)
                for shape in solids
            ]
            count = np.array(counts)[np.searchsorted(used, own)]
            first = start + np.cumsum(count) - count
            start += int(count.sum())
            layouts += [
                Layout(int(shape), meshed, group.blocks[own == shape], first[own == shape]) for shape in used
            ]
        return layouts

    def keys(self, pairs: IntArray) -> IntArray:
        """A number for each pair."""
        keys: IntArray = pairs @ np.array([len(self._model.assembly.blocks), 1])
        return keys


def _looked_up(keys: IntArray, known: IntArray, values: FloatArray) -> FloatArray:
    """Values of keys among sorted known ones; 0 where they are not, shape (m,)."""
    if len(known) == 0:
        return np.zeros(len(keys))
    place = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.where(known[place] == keys, values[place], 0.0)
