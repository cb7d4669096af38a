"""Coupling: body groups joined at contact points.

    coupling = connect(model)
    here = coupling.placement(state.bodies)            # frames, points and gaps now
    problem = coupling.problem(frees, here, scheme, ...)   # the contact problem in split form

It sorts the contact sides by group once; each step then runs over groups, never over contacts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.base import Attachment, FloatArray, Free, IntArray, Scheme, Sides, nonlinear
from masonry_fem.contact.contacts import local_frames
from masonry_fem.host.phases import counted
from masonry_fem.march.dealing import Dealing
from masonry_fem.march.model import Model
from masonry_fem.nscd.blocks import assemble_blocks, pattern_of
from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.modal import Modal, Modes
from masonry_fem.nscd.structure import Structure

ROUNDING = 16 * np.finfo(float).eps  # of the largest coordinate: a gap below it is none
# Numbers in W_el from which it is kept by kinds of stones: those of some 600 contacts of a wall. There a
# product takes .35 ms either way, for 100 contacts .12 and .03 ms, for 2600 1.9 and 3.1 ms.
MANY = 500_000
TOGETHER = 1e-6  # of the model's length: how far contacts of one point may part and still act at one
NEAR = 0.1  # of a unit vector: what is left of a tangent in the plane across a tie that has turned
SIGN = np.array([1.0, -1.0])  # candidate, antagonist: v = v_candidate − v_antagonist


@dataclass(frozen=True, slots=True)
class Placement:
    """Contact geometry in a state.

    Attributes
    ----------
    frame : Rows (n, t1[, t2]); they follow the antagonist, shape (c, d, d).
    points : Where the candidates' points are, shape (c, d) [m].
    arms : Where contacts act on candidates and antagonists, shape (c, 2, d) [m]: there, but on blocks that
        deform as far from it as faces that do not fit were apart at the start: their own points give way.
    gap : Signed distance to the antagonist's face, as round as contacts say, shape (c,) [m].
    offset : Candidate's point from the antagonist's, in the frames, shape (c, d) [m]: its derivative is
        the kinematic map G, however far blocks turn.
    seen : Frames at the k sides of each group as its blocks see them, turned back by what these have turned,
        shape (k, d, d); None where blocks do not deform.
    """

    frame: FloatArray
    points: FloatArray
    arms: FloatArray
    gap: FloatArray
    offset: FloatArray
    seen: tuple[FloatArray | None, ...]


@dataclass(slots=True)
class _Cached:
    """What was made last, with what it was made for: a step begins where the last one ended.

    Frames rarely turn, so that the compliance matrix is kept for longer.
    """

    states: tuple[Any, ...] | None = None
    placement: Placement | None = None
    rigid_map: FloatArray | None = None
    scheme: Scheme | None = None
    seen: tuple[FloatArray | None, ...] = ()
    tangents: tuple[Any, ...] = ()
    matrix: sparse.bsr_array | Shared | None = None
    members: tuple[IntArray, ...] = ()
    pattern: sparse.csr_array | None = None  # of the matrix, for these contacts of each block

    def pattern_of(self, count: int, members: tuple[IntArray, ...]) -> sparse.csr_array:
        """Which contacts share a block, made once for a set of contacts.

        Parameters
        ----------
        count : Contacts c. members : Contact numbers of each block.
        """
        if self.pattern is None or not _same(self.members, members):
            self.members, self.pattern = members, pattern_of(count, members)
        return self.pattern


@dataclass(frozen=True, slots=True)
class Coupling:
    """Groups seen through the contacts.

    Attributes
    ----------
    model : What is coupled.
    sides : Contact sides of each group.
    attachments : Each group attached to its sides.
    first_body : Number of each group's first rigid body among the solved ones; −1 for supports.
    bodies : Rigid bodies at the two sides of each contact, −1 for supports, shape (c, 2).
    soft : Contacts of which a side deforms, shape (c,).
    together : The first contact at the same point of the reference, itself between rigid blocks, shape (c,).
    structure : What the contact solver keeps from round to round and step to step.
    """

    model: Model
    sides: tuple[Sides, ...]
    attachments: tuple[Attachment, ...]
    first_body: tuple[int, ...]
    bodies: IntArray
    soft: NDArray[np.bool_]
    together: IntArray
    structure: Structure = field(default_factory=Structure, repr=False)
    _cached: _Cached = field(default_factory=_Cached, repr=False)

    def placement(self, states: tuple[Any, ...]) -> Placement:
        """Frames, points and gaps of all contacts in the given body states."""
        cached = self._cached
        if cached.placement is None or cached.states is not states:
            cached.states, cached.placement, cached.rigid_map = states, self._placed(states), None
        return cached.placement

    def _placed(self, states: tuple[Any, ...]) -> Placement:
        contacts = self.model.contacts
        d = contacts.dimension
        moved = np.empty((contacts.count, 2, d))
        turn = np.empty((contacts.count, d, d))
        turns = []
        for sides, attachment, state in zip(self.sides, self.attachments, states, strict=True):
            moved[sides.contact, sides.side] = attachment.displacements(state)
            turns.append(attachment.rotations(state))
            of_antagonist = sides.side == 1
            turn[sides.contact[of_antagonist]] = turns[-1][of_antagonist]
        frame = contacts.frame if self.model.fixed else contacts.frame @ turn.transpose(0, 2, 1)
        tied = None if self.model.fixed else contacts.ties
        # what elastic blocks move would be lost in places that lie far from the origin
        apart = contacts.points[:, 0] - contacts.points[:, 1]
        if tied is not None:
            frame = frame.copy()
            frame[tied] = _along((moved[:, 1] - moved[:, 0] - apart)[tied], contacts.frame[tied])
        offset = np.einsum("cia,ca->ci", frame, apart + (moved[:, 0] - moved[:, 1]))
        points = contacts.points[:, 0] + moved[:, 0]
        gap = offset[:, 0] - (0.0 if contacts.bulge is None else contacts.bulge)
        # The difference of two coordinates is rounding below this. As data it would be gaps that
        # contradict each other, 1e-10 of an elastic displacement: 24 linear solves instead of 4.
        gap[np.abs(gap) <= ROUNDING * np.abs(points).max(initial=0.0)] = 0.0
        seen = tuple(
            frame[sides.contact] @ own if group.deforms else None
            for sides, group, own in zip(self.sides, self.model.groups, turns, strict=True)
        )
        here = contacts.points[:, 0] if self.model.fixed else points
        arms = self._arms(here, frame)
        if tied is not None:
            arms[tied, 1] = contacts.points[tied, 1] + moved[tied, 1]
        return Placement(frame, here, arms, gap, offset, seen)

    def _arms(self, here: FloatArray, frame: FloatArray) -> FloatArray:
        """Where contacts between faces act on either block, shape (c, 2, d) [m]."""
        contacts, arms = self.model.contacts, np.stack([here, here], axis=1)
        # of contacts that are found on the way the distance of their points is how far blocks have gone
        misfit = contacts.gap + (0.0 if contacts.bulge is None else contacts.bulge)
        for sides, group in zip(self.sides, self.model.groups, strict=True):
            if group.deforms:
                second = sides.contact[sides.side == 1]
                arms[second, 1] -= misfit[second, None] * frame[second, 0]
        return arms

    def gathered(self, here: Placement) -> Placement:
        """The same where contacts of one point of the reference act at one, if they have parted little.

        Where three blocks meet, velocities at two contacts tell that at the third. These must not contradict
        each other by what points have parted as blocks turned: the solver would look for a slip as small.
        """
        to_first = here.points[self.together] - here.points
        apart = np.linalg.norm(to_first, axis=1)
        share = np.clip(2.0 - apart / (TOGETHER * self.model.length), 0.0, 1.0)
        share[apart <= ROUNDING * np.abs(here.points).max(initial=0.0)] = 0.0
        share[self.model.contacts.tied] = 0.0
        if not share.any():
            return here
        return replace(here, arms=here.arms + (share[:, None] * to_first)[:, None])

    def rigid_map(self, states: tuple[Any, ...], here: Placement) -> FloatArray:
        """B by contact and side, signs included, supports too, shape (c, 2, d, m)."""
        cached = self._cached
        if cached.placement is not here or cached.states is not states:
            return self._mapped(states, here)
        if cached.rigid_map is None:
            cached.rigid_map = self._mapped(states, here)
        return cached.rigid_map

    def _mapped(self, states: tuple[Any, ...], here: Placement) -> FloatArray:
        from masonry_fem.bodies.motions import put_maps  # noqa: PLC0415 - Numba is slow to import

        c, d = here.points.shape
        m = 3 if d == 2 else 6
        rigid_map = np.zeros((c, 2, d, m))
        if self.model.fixed:
            states = tuple(group.rest() for group in self.model.groups)
        for sides, attachment, state in zip(self.sides, self.attachments, states, strict=True):
            arms = here.arms[sides.contact, sides.side]
            local = attachment.rigid_map(state, arms, here.frame[sides.contact])
            put_maps(rigid_map, sides.contact, sides.side, local)
        return rigid_map

    def elastic_velocity(self, fields: tuple[FloatArray | None, ...], here: Placement) -> FloatArray:
        """Relative velocity of nodal fields (one a group) in the local frames, shape (c, d)."""
        from masonry_fem.bodies.motions import add_signed  # noqa: PLC0415 - Numba is slow to import

        velocity = np.zeros(here.points.shape)
        for sides, attachment, nodal, seen in zip(
            self.sides, self.attachments, fields, here.seen, strict=True
        ):
            if nodal is not None and seen is not None:
                local = attachment.elastic_velocity(nodal, seen)
                add_signed(velocity, sides.contact, sides.side, local)
        return velocity

    def rigid_velocity(self, rigid: tuple[FloatArray, ...], rigid_map: FloatArray) -> FloatArray:
        """Relative velocity of rigid velocities U (b, m), one array a group, shape (c, d)."""
        from masonry_fem.bodies.motions import add_velocities  # noqa: PLC0415 - Numba is slow to import

        velocity = np.zeros(rigid_map.shape[:3:2])
        for sides, given in zip(self.sides, rigid, strict=True):
            own = np.ascontiguousarray(given)
            add_velocities(velocity, sides.contact, sides.side, sides.body, rigid_map, own)
        return velocity

    def compliance(
        self, here: Placement, scheme: Scheme, guess: tuple[Any, ...] | None = None
    ) -> sparse.bsr_array | Shared:
        """W_el of all contacts; kept while scheme, frames and tangents do not change.

        Parameters
        ----------
        here : Contact geometry.
        scheme : Coefficients of the step.
        guess : States that nonlinear groups are linearised at, None for the others; None: all are elastic
            from the start of the step on.
        """
        guess = (None,) * len(self.attachments) if guess is None else guess
        tangents = tuple(
            nonlinear(group).tangents(at, scheme) if group.nonlinear else None
            for group, at in zip(self.model.groups, guess, strict=True)
        )
        cached = self._cached
        same = _same(cached.seen, here.seen) and cached.scheme == scheme and _same(cached.tangents, tangents)
        if cached.matrix is None or not same:
            # stones that yield without associated flow have no symmetric tangent
            symmetric = not any(tangents)
            many = self._numbers > MANY or self._modal
            cached.matrix = None  # two at a time would take twice the memory
            cached.matrix = (self._shared if many else self._condense)(here, scheme, guess, symmetric)
            cached.scheme, cached.seen, cached.tangents = scheme, here.seen, tangents
        return cached.matrix

    @property
    def _modal(self) -> bool:
        """Whether all blocks that deform do so by few modes."""
        deforming = [group.modal for group in self.model.groups if group.deforms]
        return bool(deforming) and all(deforming)

    @property
    def _numbers(self) -> int:
        """How many numbers W_el has at most."""
        groups = zip(self.sides, self.model.groups, strict=True)
        sizes = [np.bincount(sides.body) for sides, group in groups if group.deforms]
        of_stones = (self.model.contacts.dimension * np.concatenate([[0], *sizes])) ** 2
        return int(of_stones.sum())

    def _shared(self, here: Placement, scheme: Scheme, guess: tuple[Any, ...], symmetric: bool) -> Shared:
        """W_el by what stones share."""
        kinds = [
            Kinds.alike(sides.contact[rows], SIGN[sides.side[rows]][:, :, None, None] * turns, matrix)
            for sides, attachment, seen, at in self._factored(here, scheme, guess)
            if seen is not None
            for rows, turns, matrix in attachment.kinds(scheme, seen, at)
        ]
        c, d = here.points.shape
        if self._modal:
            return Modal(c, d, kinds, symmetric, self._modes(here, scheme))
        return Shared(c, d, kinds, symmetric)

    def _modes(self, here: Placement, scheme: Scheme) -> Modes:
        """Modes of all bodies at the contacts."""
        c, d = here.points.shape
        seen = [
            (sides, first, attachment.unit_motions(scheme, frames))
            for sides, first, attachment, frames in zip(
                self.sides, self.first_body, self.attachments, here.seen, strict=True
            )
            if frames is not None
        ]
        most = max(mass.shape[1] for _, _, (_, mass) in seen)
        bodies = sum(len(group.blocks) for group in self.model.groups if not group.prescribed)
        maps, masses = np.zeros((c, 2, d, most)), np.ones((bodies, most))
        for sides, first, (local, mass) in seen:
            count = mass.shape[1]
            maps[sides.contact, sides.side, :, :count] = SIGN[sides.side, None, None] * local
            masses[first : first + len(mass), :count] = mass
        return Modes(maps, masses)

    def _factored(self, here: Placement, scheme: Scheme, guess: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
        """What each group's part of W_el is made of: a factor each, where it has none yet."""
        parts = tuple(zip(self.sides, self.attachments, here.seen, guess, strict=True))
        dealing = Dealing(self.attachments, scheme)
        for number, part in enumerate(counted("factors of the stones", parts)):
            dealing.reach(number)
            yield part

    def _condense(
        self, here: Placement, scheme: Scheme, guess: tuple[Any, ...], symmetric: bool
    ) -> sparse.bsr_array:
        c, d = here.points.shape
        contributions: list[tuple[IntArray, FloatArray]] = []
        for sides, attachment, seen, at in self._factored(here, scheme, guess):
            if seen is None:
                continue
            for members, matrix in attachment.compliance(scheme, seen, at):
                sign = np.repeat(SIGN[sides.side[members]], d)
                signed = matrix
                if (sign != sign[0]).any():
                    signed = matrix * sign
                    signed *= sign[:, None]
                contributions.append((sides.contact[members], signed))
        pattern = self._cached.pattern_of(c, tuple(members for members, _ in contributions))
        return assemble_blocks(c, d, contributions, symmetric=symmetric, pattern=pattern)

    def nodal_impulses(self, impulse: FloatArray, here: Placement) -> tuple[FloatArray | None, ...]:
        """Gᵀ p on the nodes of each group (None for rigid ones)."""
        return tuple(
            None if seen is None else attachment.spread(SIGN[sides.side, None] * impulse[sides.contact], seen)
            for sides, attachment, seen in zip(self.sides, self.attachments, here.seen, strict=True)
        )

    def rigid_impulses(self, impulse: FloatArray, rigid_map: FloatArray) -> tuple[FloatArray, ...]:
        """Bᵀ p on the rigid modes of each group, supports too, each of shape (b, m)."""
        from masonry_fem.bodies.motions import given_impulses  # noqa: PLC0415 - Numba is slow to import

        return tuple(
            given_impulses(sides.contact, sides.side, sides.body, rigid_map, impulse, len(group.blocks))
            for sides, group in zip(self.sides, self.model.groups, strict=True)
        )

    def gather(self, frees: tuple[Free, ...], name: str) -> FloatArray:
        """One rigid array (``rigid_mass`` ...) of all solved bodies in their order, (b, m)."""
        parts = [
            getattr(free, name) for free, first in zip(frees, self.first_body, strict=True) if first >= 0
        ]
        m = 3 if self.model.assembly.dimension == 2 else 6
        return np.concatenate(parts) if parts else np.zeros((0, m))

    def scatter(self, solved: FloatArray, frees: tuple[Free, ...]) -> tuple[FloatArray, ...]:
        """U⁺ of each group: the solved ones, and the supports' own."""
        return tuple(
            free.rigid_velocity if first < 0 else solved[first : first + len(free.rigid_velocity)]
            for free, first in zip(frees, self.first_body, strict=True)
        )


def connect(model: Model) -> Coupling:
    """Attach every group of a model to the contacts of its blocks."""
    group_of, body_of = _owners(model)
    contacts = model.contacts
    sides, attachments, first_body, solved = [], [], [], 0
    bodies, soft = np.full((contacts.count, 2), -1), np.zeros(contacts.count, dtype=bool)
    for index, group in enumerate(model.groups):
        contact, side = np.nonzero(group_of[contacts.blocks] == index)
        body = body_of[contacts.blocks[contact, side]]
        own = Sides(
            contact=contact,
            side=side,
            body=body,
            point=contacts.points[contact, side],
            facet=contacts.facets[contact, side],
            frame=contacts.frame[contact],
            means=None if contacts.means is None else contacts.means[2 * contact + side],
        )
        soft[contact] |= group.deforms
        sides.append(own)
        attachments.append(group.attach(own))
        first_body.append(-1 if group.prescribed else solved)
        if not group.prescribed:
            bodies[contact, side] = solved + body
            solved += len(group.blocks)
    alone = np.arange(contacts.count)  # between rigid blocks impulses are not unique anyway
    together = np.where(soft, _together(contacts.points[:, 0], TOGETHER * model.length), alone)
    return Coupling(model, tuple(sides), tuple(attachments), tuple(first_body), bodies, soft, together)


def _together(points: FloatArray, near: float) -> IntArray:
    """The first of the points that are as near to each other, shape (c,); each alone where none is."""
    cells = np.round(points / near).astype(np.int64)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return first[cell.ravel()]


def _along(reach: FloatArray, before: FloatArray) -> FloatArray:
    """Frames of ties from their candidates' points to their antagonists', (k, d, d).

    Parameters
    ----------
    reach : From the one to the other, shape (k, d) [m].
    before : Frames in the reference, shape (k, d, d); the first tangents stay as near to theirs as can be.
    """
    normal = reach / np.linalg.norm(reach, axis=1)[:, None]
    frame = local_frames(normal)
    if frame.shape[1] == 3:
        tangent = before[:, 1] - np.einsum("ki,ki->k", before[:, 1], normal)[:, None] * normal
        size = np.linalg.norm(tangent, axis=1)
        near = size > NEAR
        frame[near, 1] = tangent[near] / size[near, None]
        frame[near, 2] = np.cross(normal[near], frame[near, 1])
    return frame


def _same(one: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Whether groups see their frames alike, or are linearised at the same states."""
    return len(one) == len(other) and all(
        a is b or (isinstance(a, np.ndarray) and np.array_equal(a, b))
        for a, b in zip(one, other, strict=True)
    )


def _owners(model: Model) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    count = len(model.assembly.blocks)
    group_of, body_of = np.full(count, -1), np.full(count, -1)
    for index, group in enumerate(model.groups):
        group_of[group.blocks] = index
        body_of[group.blocks] = np.arange(len(group.blocks))
    return group_of, body_of
