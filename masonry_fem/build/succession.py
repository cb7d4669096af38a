"""Succession: a structure that begins in the state that another one was left in.

    left = Left(scene, stones, model, state)           # the other structure, and where its march ended
    model, start = succeeded(scene, built, base, left)

Stones are told by their names, contacts by their stones and places. What loads and contacts held the stones
and do so no more is a load of its own, ``released``, that statics takes away evenly over its steps: so a
centring is struck, and loads come and go, without a jump. In a march in time it is gone at once. What
temperature has strained stones by beside what this scene says goes in any analysis as its own comes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.build.ageing import Ageing, changed
from masonry_fem.build.joints import joint_of_interfaces, joints_at, touching
from masonry_fem.build.model import Built, body_groups
from masonry_fem.build.seating import seated
from masonry_fem.build.stones import Stones
from masonry_fem.build.supports import fade
from masonry_fem.build.temperature import Expansions
from masonry_fem.build.ties import stretched_from
from masonry_fem.contact.posed import corners
from masonry_fem.contact.update import chosen, joined, partners
from masonry_fem.errors import MasonryError
from masonry_fem.joints.law import layers_of
from masonry_fem.march.coupling import SIGN, Coupling, connect
from masonry_fem.march.loads import external_forces
from masonry_fem.march.model import FloatArray, Load, Model
from masonry_fem.march.renewal import carried
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import initial_state
from masonry_fem.records.remark import first_few, remark
from masonry_fem.scene import specs
from masonry_fem.solid.mesh import IntArray, Mesh

RELEASED = "released"
NEAR = 0.25  # of the model's length: how far a contact goes on from an old one of the same stones
ALIKE = 1e-9  # of a mass: what may be rounding
SHOWN = 3  # differences that a message names
SUPPORT = "a support"


@dataclass(frozen=True, slots=True)
class Left:
    """A structure as a march left it.

    Attributes
    ----------
    stones : Its blocks. model : With the contacts of the end. state : Of the end.
    warmed : Strains by temperature of the blocks of each group there, shape (b,); None: none.
    materials : By name.
    """

    stones: Stones
    model: Model
    state: SystemState
    warmed: tuple[FloatArray | None, ...]
    materials: Mapping[str, specs.Material]


def succeeded(scene: specs.Scene, built: Built, base: Path, left: Left) -> tuple[Model, SystemState]:
    """The model of a scene with its contacts and loads where another structure was left, and its state there.

    Parameters
    ----------
    scene : The scene. built : Made of it, stones in their reference places.
    base : Folder that the scene's paths are relative to.
    left : The other structure; stones that it has not begin without stress, where the analysis says.

    Raises
    ------
    MasonryError : A stone is another one than there, or is computed otherwise; the differences are told.
    """
    old = _numbers(built, left)
    _refuse_others(built, left, old)
    _tell_let_go(built, left, old)
    model = _standing(_as_left(scene, built, base, left, old), left, old)
    model, origin = _with_contacts(scene, built, base, model, left, old)
    bodies = tuple(
        _taken(group, rest, left, old) for group, rest in zip(model.groups, built.bodies, strict=True)
    )
    if scene.analysis.new_stones == "moved":
        bodies = seated(model, bodies, old >= 0)
    groups: tuple[Any, ...] = model.groups
    clamped = (one.clamped_at(own) if one.deforms else one for one, own in zip(groups, bodies, strict=True))
    model = replace(model, groups=tuple(clamped))
    if not scene.analysis.inertia:  # no velocity goes into statics
        bodies = tuple(
            group.scale_velocity(own, 0.0) for group, own in zip(model.groups, bodies, strict=True)
        )
    if scene.ties:
        model = _with_ties(scene, built, base, model, bodies, left, origin)
    coupling = connect(model)
    begun = initial_state(model, coupling, bodies)
    known = replace(left.state, bodies=bodies)
    state = carried(
        _renumbered(left.model, old, len(built.stones.assembly.blocks)),
        model, coupling, coupling.placement(bodies), known, origin,
    )  # fmt: skip
    state = replace(
        begun, reaction=state.reaction, status=state.status, **_joints(model, begun, left, state, origin)
    )
    if not scene.analysis.inertia:
        forces = _released(model, coupling, state, left, old, origin)
        if any(force is not None and force.any() for force in forces):
            model = replace(model, loads=(*model.loads, Load(RELEASED, forces, _fading)))
    return model, state


def _fading(factor: float) -> float:
    """What is left of the forces that statics takes away."""
    return max(1.0 - factor, 0.0)


def _numbers(built: Built, left: Left) -> IntArray:
    """Number in the structure that was left of each block, −1 of those that it has not, shape (b,)."""
    before = left.stones.assembly.blocks.names
    known = dict(zip(before, range(len(before)), strict=True))
    return np.fromiter(map(known.get, built.stones.assembly.blocks.names, repeat(-1)), np.int64)


def _kinds(stones: Stones) -> np.ndarray:
    """As what each block is computed, in words, shape (b,)."""
    words = {own: own or SUPPORT for own in set(stones.fidelity)}
    return np.array(list(map(words.__getitem__, stones.fidelity)))


def _refuse_others(built: Built, left: Left, old: IntArray) -> None:
    """Refuse stones that are not those of the same name that were left."""
    here = np.flatnonzero(old >= 0)
    if not len(here):
        known = [f"'{name}'" for name in left.stones.assembly.blocks.names]
        raise MasonryError(
            "the scene cannot start from the state that was left: it has none of the stones there, "
            f"{first_few(known, SHOWN)}. Expected stones of the same names; correct these, or leave it out"
        )
    there = old[here]
    was, now = _kinds(left.stones)[there], _kinds(built.stones)[here]
    before, mass = _mass_of(left.model)[there], _mass_of(built.model)[here]
    let_go, stops = was == SUPPORT, (was == "rigid") & (now == SUPPORT)
    other = (was != now) & ~let_go & ~stops
    heavier = ~other & ~let_go & ~stops & (np.abs(mass - before) > ALIKE * before)
    gone = _elsewhere(built, left, here, there)
    names = [built.stones.assembly.blocks.names[block] for block in here]
    told = [f"'{names[k]}' was {was[k]}, and is {now[k]}" for k in np.flatnonzero(other)]
    told += [f"'{names[k]}' had another shape or place" for k in np.flatnonzero(gone)]
    told += [
        f"'{names[k]}' had a mass of {before[k]:g}, and has {mass[k]:g}" for k in np.flatnonzero(heavier)
    ]
    told += [] if told else _remeshed(built.model, left.model, here, there)
    holdable = [names[k] for k in np.flatnonzero(other & (now == SUPPORT))]
    if told:
        cure = (
            f"hold the faces of a stone that deforms, supports with on = '{holdable[0]}/*'"
            if holdable
            else "give others other names"
        )
        raise MasonryError(
            f"the scene cannot start from the state that was left: {first_few(told, SHOWN, separator='; ')}. "
            f"Expected stones of the same names as they were; {cure}"
        )


def _tell_let_go(built: Built, left: Left, old: IntArray) -> None:
    """Tell which blocks were supports and are none: one may have been forgotten."""
    here = np.flatnonzero(old >= 0)
    free = (_kinds(left.stones)[old[here]] == SUPPORT) & (_kinds(built.stones)[here] != SUPPORT)
    freed = [f"'{built.stones.assembly.blocks.names[block]}'" for block in here[free]]
    if freed:
        were = "was a support and is" if len(freed) == 1 else "were supports and are"
        remark(
            "let_go",
            f"{first_few(freed, SHOWN)} {were} none now; supports of a stage take the place of all before: "
            "name again what is still held",
        )


def _elsewhere(built: Built, left: Left, here: IntArray, there: IntArray) -> np.ndarray:
    """Whether corners of blocks ``here`` are others than those of blocks ``there`` that were left."""
    own, count = corners(built.stones.assembly)
    its, before = corners(left.stones.assembly)
    width = min(own.shape[1], its.shape[1])  # what is beyond repeats the last corner
    away = np.abs(own[here, :width] - its[there, :width]).max(axis=(1, 2), initial=0.0)
    found: np.ndarray = (count[here] != before[there]) | (away > 1e-9 * built.model.length)
    return found


def _remeshed(model: Model, left: Model, here: IntArray, there: IntArray) -> list[str]:
    """Which blocks ``here`` have other elements than blocks ``there`` that were left, in words."""
    (owner, _), (before, _) = _places(model), _places(left)
    told: list[str] = []
    alike: dict[tuple[int, int], bool] = {}
    for block, old in zip(here.tolist(), there.tolist(), strict=True):
        group: Any = model.groups[owner[block]]
        other: Any = left.groups[before[old]]
        if not (group.deforms and other.deforms):
            continue
        pair = (int(owner[block]), int(before[old]))
        if pair not in alike:
            alike[pair] = _same_elements(group.mesh, other.mesh)
        if not alike[pair]:
            was, now = (
                f"{len(one.cells)} elements with {len(one.points)} nodes" for one in (other.mesh, group.mesh)
            )
            name = model.assembly.blocks.names[block]
            told.append(f"'{name}' had {was}" + (f", and has {now}" if was != now else " in other places"))
    return told


def _same_elements(one: Mesh, other: Mesh) -> bool:
    """Whether two meshes of a shape have the same elements."""
    if one.cell != other.cell or not np.array_equal(one.cells, other.cells):
        return False
    return bool(np.abs(one.points - other.points).max() <= 1e-9 * np.ptp(one.points, axis=0).max())


def _mass_of(model: Model) -> FloatArray:
    """Mass of each block, 0 of supports, shape (b,) [kg]."""
    mass = np.zeros(len(model.assembly.blocks))
    for group in model.groups:
        mass[group.blocks] = group.mass
    return mass


# --- bodies -----------------------------------------------------------------------------------------


def _places(model: Model) -> tuple[IntArray, IntArray]:
    """Group of each block and its row there, shape (b,)."""
    count = len(model.assembly.blocks)
    group_of, row_of = np.full(count, -1), np.full(count, -1)
    for number, group in enumerate(model.groups):
        group_of[group.blocks], row_of[group.blocks] = number, np.arange(len(group.blocks))
    return group_of, row_of


def _standing(model: Model, left: Left, old: IntArray) -> Model:
    """The model with supports whose motions go on from where they were left."""
    groups = []
    owner, row = _places(left.model)
    group: Any  # of those that are prescribed, what they are is known
    for group in model.groups:
        before = old[group.blocks]
        if not group.prescribed or not (before >= 0).any():
            groups.append(group)
            continue
        d = group.dimension
        shift, turned = np.zeros((group.count, d)), np.zeros((group.count, d, d))
        for number in np.unique(owner[before[before >= 0]]).tolist():
            here = np.flatnonzero((before >= 0) & (owner[before] == number))
            was: Any = left.model.groups[number]
            state, rows = left.state.bodies[number], row[before[here]]
            turned[here] = state.turned[rows]
            apart = group.centres[here] - was.centres[rows]  # the pivot may be another one
            shift[here] = state.shift[rows] + np.einsum("bij,bj->bi", turned[here], apart)
        moved = shift.any() or turned.any()
        groups.append(group.starting_at(shift, turned) if moved else group)
    return replace(model, groups=tuple(groups))


def _as_left(scene: specs.Scene, built: Built, base: Path, left: Left, old: IntArray) -> Model:
    """The model whose stones begin as warm as they were left, and of the materials that they were of."""
    was = _warmth(left.model, left.warmed)
    warmed = [group.warmed(rest) for group, rest in zip(built.model.groups, built.bodies, strict=True)]
    now = _warmth(built.model, warmed)
    known = np.flatnonzero(old >= 0)
    known = known[was[old[known]] != now[known]]
    stones = left.stones
    materials = map(left.materials.__getitem__, stones.material)
    were = dict(zip(stones.assembly.blocks.names, materials, strict=True))
    ages = changed(scene, built.stones, were)
    if not len(known) and not ages:
        return built.model
    fading, more = fade(scene), was[old[known]] - now[known]
    strains: Expansions = {
        block: [(own, fading)] for block, own in zip(known.tolist(), more.tolist(), strict=True)
    }
    groups = (
        body_groups(scene, built.stones, base, built.model.groups, strains) if strains else built.model.groups
    )
    ageing = Ageing(scene, built.stones, base, ages, strains) if ages else None
    waits = scene.analysis.inertia and scene.analysis.seeks_equilibrium
    changing = max(built.model.changing, scene.analysis.ramp) if waits else built.model.changing
    return replace(built.model, groups=groups, changing=changing, ageing=ageing)


def _warmth(model: Model, strains: Sequence[FloatArray | None]) -> FloatArray:
    """Thermal strain of each block, shape (b,), of those of the groups; None: a group has none."""
    found = np.zeros(len(model.assembly.blocks))
    for group, strain in zip(model.groups, strains, strict=True):
        found[group.blocks] = 0.0 if strain is None else strain
    return found


def _taken(group: BodyGroup, rest: Any, left: Left, old: IntArray) -> Any:
    """The state of a group, from where its blocks were left."""
    before, (owner, row) = old[group.blocks], _places(left.model)
    if group.prescribed:
        return group.rest()
    state = rest
    for number in np.unique(owner[before[before >= 0]]).tolist():
        rows = np.flatnonzero((before >= 0) & (owner[before] == number))
        there, kept, others = left.model.groups[number], left.state.bodies[number], row[before[rows]]
        other = _without_other_law(group, there, kept, others)
        whole = other is kept and len(rows) == len(group.blocks) == len(there.blocks)
        if there.prescribed:  # it is let go where it is
            turn, shift = there.motion(other)
            state = group.set_down(state, rows, turn[others], shift[others])
        elif _clamped_otherwise(group, there):
            state = _held_anew(group, state, rows, there, other, others)
        elif whole and (others == np.arange(len(rows))).all():
            state = other
        else:
            state = _put(state, rows, other, others)
    return replace(state, time=0.0) if hasattr(state, "time") else state


def _without_other_law(group: Any, there: Any, other: Any, others: IntArray) -> Any:
    """The state of a group that was left, without what its law remembers where blocks have another now."""
    if not (group.deforms and there.deforms) or group.material_name == there.material_name:
        return other
    if other.memory is not None:
        changed = other.memory.internal[others] != there.rest().memory.internal[others]
        if changed.any():
            body = int(changed.reshape(len(others), -1).any(axis=1).argmax())
            raise MasonryError(
                f"'{there.names[others[body]]}' has yielded by the law {there.material_name}, whose memory "
                f"is none of {group.material_name}: leave the kind of law as it was, and change its numbers"
            )
    return replace(other, memory=None)


def _clamped_otherwise(group: Any, there: Any) -> bool:
    """Whether blocks that deform have clamps now that they had not, or the reverse."""
    both = group.deforms and there.deforms
    return both and not np.array_equal(group.free_dofs, there.free_dofs)


def _held_anew(group: Any, state: Any, rows: IntArray, there: Any, other: Any, others: IntArray) -> Any:
    """A state with rows of another one whose blocks have other clamps: nodes, and what the material knows."""
    displacement, velocity = there.nodal_motion(other)
    state = group.moved_by(state, rows, displacement[others], velocity[others])
    return (
        state
        if state.memory is None or other.memory is None
        else replace(state, memory=_put(state.memory, rows, other.memory, others))
    )


def _put(state: Any, rows: IntArray, other: Any, others: IntArray) -> Any:
    """A state with rows of another one of the same kind in the place of its own."""
    if type(state) is not type(other):
        raise MasonryError(
            f"stones were computed as {type(other).__name__}, and are as {type(state).__name__}: leave "
            "fidelity, degree and contact.update as they were"
        )
    changes: dict[str, Any] = {}
    for field in fields(state):
        own, new = getattr(state, field.name), getattr(other, field.name)
        if field.name in ("yielding", "moduli"):  # tangents are a first guess only
            changes[field.name] = own[:0]
        elif is_dataclass(new):
            changes[field.name] = _put(own, rows, new, others)
        elif isinstance(new, np.ndarray):
            whole = np.zeros((len(_rows_of(state)), *new.shape[1:])) if own is None else own.copy()
            whole[rows] = new[others]
            changes[field.name] = whole
    return replace(state, **changes)


def _rows_of(state: Any) -> FloatArray:
    """Some array of a state with a row a block."""
    found = next(
        value for field in fields(state) if isinstance(value := getattr(state, field.name), np.ndarray)
    )
    return np.asarray(found)


# --- contacts ---------------------------------------------------------------------------------------


def _renumbered(model: Model, old: IntArray, count: int) -> Model:
    """A model whose contacts' blocks have the numbers of the succeeding one; the others from ``count`` on."""
    new = count + np.arange(len(model.assembly.blocks))
    new[old[old >= 0]] = np.flatnonzero(old >= 0)
    interfaces = replace(model.interfaces, blocks=new[model.interfaces.blocks])
    return replace(
        model, interfaces=interfaces, contacts=replace(model.contacts, blocks=new[model.contacts.blocks])
    )


def _with_contacts(
    scene: specs.Scene, built: Built, base: Path, model: Model, left: Left, old: IntArray
) -> tuple[Model, IntArray]:
    """The model with its contacts, and which one that was left each goes on from, −1: none, shape (c,)."""
    count = len(built.stones.assembly.blocks)
    before = _renumbered(left.model, old, count)
    if left.model.found:
        model = _with_found(scene, built, base, model, before, old)
    return model, partners(
        before.contacts, before.contacts.points[:, 0], model.contacts, model.contacts.points[:, 0],
        NEAR * model.length,
    )  # fmt: skip


def _with_found(
    scene: specs.Scene, built: Built, base: Path, model: Model, before: Model, old: IntArray
) -> Model:
    """The model with contacts that were found where stones have gone, and its own of stones that are new."""
    count = len(built.stones.assembly.blocks)
    stays = (before.interfaces.blocks < count).all(axis=1) & ~before.interfaces.tie
    kept = chosen(before.interfaces, before.contacts, stays)
    anew = model.interfaces.tie | (old[model.interfaces.blocks] < 0).any(axis=1)
    interfaces, contacts = joined(kept, chosen(model.interfaces, model.contacts, anew))
    touch, records = touching(scene, built.stones, interfaces, tell=False)
    if len(touch) < len(interfaces):
        chosen_ones = joint_of_interfaces(scene, built.stones, interfaces, tell=False)
        keep = np.array(
            [record < 0 or scene.joints[record].contact != "none" for record in chosen_ones], dtype=bool
        )
        interfaces, contacts = chosen(interfaces, contacts, keep)
    closed = replace(contacts, gap=np.zeros(contacts.count))
    laws, scatter = joints_at(scene, built.stones, interfaces, closed, records, base)
    return replace(
        model, interfaces=interfaces, contacts=contacts, laws=laws, scatter=scatter,
        joint_records=tuple(records), found=True,
    )  # fmt: skip


def _with_ties(
    scene: specs.Scene, built: Built, base: Path, model: Model, bodies: tuple[Any, ...], left: Left,
    origin: IntArray,
) -> Model:  # fmt: skip
    """The model with ties that are as long as they were, new ones as their points are apart now."""
    contacts = model.contacts
    assert contacts.bulge is not None
    known, fresh = contacts.tied & (origin >= 0), contacts.tied & (origin < 0)
    if known.any():
        assert left.model.contacts.bulge is not None
        # built again, ties have the lengths that their own scene gives them; what they had is in the gaps
        there = connect(left.model).placement(left.state.bodies)
        were = left.model.contacts.bulge + (there.gap - left.state.gap)
        bulge, gap = contacts.bulge.copy(), contacts.gap.copy()
        bulge[known] = were[origin[known]]
        gap[known] += contacts.bulge[known] - bulge[known]
        contacts = replace(contacts, bulge=bulge, gap=gap)
    here = connect(model).placement(bodies)
    assert model.contacts.bulge is not None
    length = np.where(fresh, -(here.gap + model.contacts.bulge), np.nan)
    contacts = stretched_from(scene, model.interfaces, contacts, length)
    closed = replace(contacts, gap=np.zeros(contacts.count))
    laws, scatter = joints_at(scene, built.stones, model.interfaces, closed, list(model.joint_records), base)
    return replace(model, contacts=contacts, laws=laws, scatter=scatter)


def _joints(
    model: Model, begun: SystemState, left: Left, state: SystemState, origin: IntArray
) -> dict[str, Any]:
    """Memory and jumps of the joints that go on with the same kind of law; the others begin anew."""
    now, then = _laws(model), _laws(left.model)
    goes_on = origin >= 0
    goes_on[goes_on] = now[goes_on] == then[origin[goes_on]]
    known = np.flatnonzero(goes_on)
    fresh, memory = begun.joints, left.state.joints.take(origin[known])
    width = max(fresh.own.shape[1], memory.own.shape[1])
    fresh = replace(fresh, own=np.pad(fresh.own, ((0, 0), (0, width - fresh.own.shape[1]))))
    jump = begun.jump.copy()
    jump[known] = state.jump[known]
    return {"joints": fresh.put(known, memory), "jump": jump}


def _laws(model: Model) -> np.ndarray:
    """Names of the layers of each contact's law, shape (c,)."""
    names = np.full(model.contacts.count, "", dtype=object)
    for law, contacts in model.laws.parts:
        names[contacts] = " ".join(layer.name for layer in layers_of(law))
    return names


# --- loads ------------------------------------------------------------------------------------------


def _released(
    model: Model, coupling: Coupling, state: SystemState, left: Left, old: IntArray, origin: IntArray
) -> tuple[FloatArray | None, ...]:
    """What held each stone in its place and no longer does, by group: loads, contacts, clamps, supports."""
    gone = np.ones(left.model.contacts.count, dtype=bool)
    gone[origin[origin >= 0]] = False
    loads, was = external_forces(left.model, left.state.time, left.state.bodies), connect(left.model)
    lost = _pushed(was, left.state, np.where(gone[:, None], left.state.reaction, 0.0))
    pushed = _pushed(was, left.state, left.state.reaction)
    kept = _pushed(coupling, state, state.reaction)
    now, (owner, row) = external_forces(model, 0.0, state.bodies), _places(left.model)
    total: list[FloatArray | None] = []
    group: Any
    for group, own, stays in zip(model.groups, now, kept, strict=True):
        if group.prescribed:
            total.append(None)
            continue
        before = old[group.blocks]
        force = -own
        for number in np.unique(owner[before[before >= 0]]).tolist():
            rows = np.flatnonzero((before >= 0) & (owner[before] == number))
            others, there = row[before[rows]], left.model.groups[number]
            if there.prescribed:
                force[rows] -= stays[rows]
                continue
            force[rows] += (loads[number] + lost[number])[others]
            if group.deforms:
                clamped = there.clamp_forces(left.state.bodies[number], loads[number], pushed[number])
                force[np.ix_(rows, group.free_dofs)] += clamped[np.ix_(others, group.free_dofs)]
        force[before < 0] = 0.0  # what is new is loaded over the steps, as in any statics
        total.append(force)
    return tuple(total)


def _pushed(coupling: Coupling, state: SystemState, reaction: FloatArray) -> list[FloatArray]:
    """Reactions (c, d) in their frames as forces on each group, the group's own array."""
    found, world = [], np.einsum("cij,ci->cj", state.reaction_frame, reaction)
    for group, sides, attachment, own in zip(
        coupling.model.groups, coupling.sides, coupling.attachments, state.bodies, strict=True
    ):
        force = SIGN[sides.side, None] * world[sides.contact]
        if group.deforms:
            axes = np.tile(np.eye(force.shape[1]), (len(force), 1, 1))
            nodal = attachment.spread(force, axes)
            assert nodal is not None  # of what deforms
            found.append(nodal)
            continue
        d, body, centres = force.shape[1], sides.body, vars(group)["centres"]
        rotation, translation = group.motion(own)
        places = state.points[sides.contact] - translation[body]
        arms = np.einsum("kji,kj->ki", rotation[body], places) - centres[body]
        total = group.acceleration_force(np.zeros(d))
        np.add.at(
            total, body, np.concatenate([force, (arms[:, :, None] * force[:, None]).reshape(-1, d * d)], 1)
        )
        found.append(total)
    return found
