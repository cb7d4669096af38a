"""Model of a scene: stones, interfaces, contacts, groups, loads and probes put together."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from inspect import get_annotations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.bodies.support import SupportGroup
from masonry_fem.build.foresight import foresee_blocks, foresee_memory, foresee_meshes, memory_of_run
from masonry_fem.build.joints import contacts_and_joints, touching
from masonry_fem.build.loads import loads
from masonry_fem.build.material_law import material_law
from masonry_fem.build.meeting import Meeting
from masonry_fem.build.overlaps import refuse_overlaps
from masonry_fem.build.places import check_places
from masonry_fem.build.selection import select_blocks
from masonry_fem.build.shaking import shaken, shaking
from masonry_fem.build.stones import Stones, lay, meshed, present, typical_length
from masonry_fem.build.supports import last_change
from masonry_fem.build.temperature import Expansions, expansions
from masonry_fem.contact.detection import REACH, detect
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.errors import ExtensionError, MasonryError, SceneError
from masonry_fem.fidelities import Fidelity, Given, deforms, fidelities
from masonry_fem.host.memory import taken_up
from masonry_fem.host.phases import LOADING, phase
from masonry_fem.march.clock import Clock
from masonry_fem.march.model import Model, Probe
from masonry_fem.march.shaking import Shaking
from masonry_fem.records.remark import first_few, remark
from masonry_fem.scene import specs
from masonry_fem.scene.selector import only
from masonry_fem.solid.assembly import taken

if TYPE_CHECKING:
    from masonry_fem.build.redetection import Redetection

SHOWN = 5  # blocks or pairs of them that a message names
ROUNDING = 1e-9  # of a time
GAP = 1e-6  # of a block's size: smaller gaps are not reported

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Built:
    """A model, where it starts and what it took.

    Attributes
    ----------
    model : Ready to march. stones : What its blocks are.
    bodies : State of each group at the start. seconds : CPU time by phase [s].
    """

    model: Model
    stones: Stones
    bodies: tuple[Any, ...]
    seconds: dict[str, float]


def build(scene: specs.Scene, base: Path, before: Built | None = None, *, solved: bool = True) -> Built:
    """Compose the model of a scene.

    Parameters
    ----------
    scene : What to build. base : Folder its file paths are relative to.
    before : The same structures built with other meshes: meshes, matrices and factors are used again
        where they fit.
    solved : Whether it is going to be solved: then the memory of that is foreseen, too.

    Raises
    ------
    MasonryError : Contradictions, and scenes too large for this machine that do not say that they are.
    """
    clock = Clock()
    foresee_blocks(scene)
    scene = present(scene, base)
    stones = lay(scene, base)
    check_places(stones)
    foresee_meshes(scene, stones)
    clock.lap("build")
    with phase("meshes") as at:
        stones = meshed(stones, None if before is None else before.stones, at)
    clock.lap("mesh" if stones.deforming else "build")
    ground = shaking(scene, base)
    stones = shaken(stones, ground)
    reach = scene.contact.reach
    with phase("joints and their contact points") as at:
        refuse_overlaps(stones, reach)
        at(1, "no blocks overlap")
        interfaces = detect(stones.assembly, reach=reach, angle=scene.contact.angle)
        interfaces, chosen = touching(scene, stones, _between_free(stones, interfaces))
        at(2, f"joints found: {len(interfaces)}")
        _tell_gaps(stones, interfaces)
        interfaces, contacts, laws, scatter = contacts_and_joints(scene, stones, interfaces, chosen, base)
    chosen = [*chosen, *[-1] * (len(interfaces) - len(chosen))]
    _doubt_loose(stones, interfaces)
    clock.lap("detect")
    if solved:
        foresee_memory(scene, memory_of_run(stones, contacts))
    with phase(LOADING):
        for kind in _used(stones):
            kind.load()
    taken_up()
    clock.lap("import" if stones.deforming else "build")
    with phase("stiffness and mass of the stones"):
        groups = body_groups(scene, stones, base, () if before is None else before.model.groups)
    clock.lap("assemble" if stones.deforming else "build")
    model = Model(
        assembly=stones.assembly,
        groups=groups,
        interfaces=interfaces,
        contacts=contacts,
        laws=laws,
        scatter=scatter,
        loads=loads(scene, stones, groups, base, ground),
        probes=_probes(scene, stones, groups),
        length=typical_length(stones.assembly),
        expulsion=scene.contact.expulsion,
        update=_update(scene, stones, base),
        fixed=scene.contact.update == "fixed",
        changing=_changing(scene, base, ground),
        meet=_meet(scene, stones, base),
        reach=REACH * typical_length(stones.assembly) if reach is None else reach,
        keeps_tangents=scene.solver.tangent == "initial",
        joint_records=tuple(chosen),
        ground=ground,
    )
    scene.analysis.control(model.probes)  # refuses a name that no probe has
    bodies = _initial(scene, stones, groups)
    clock.lap("build")
    return Built(model, stones, bodies, clock.phases)


def _changing(scene: specs.Scene, base: Path, ground: Shaking | None) -> float:
    """Until when a march to equilibrium goes on, whether or not all is at rest in between [s]."""
    analysis = scene.analysis
    if not (analysis.inertia and analysis.seeks_equilibrium):
        return 0.0
    changing, end = last_change(scene, base, ground), analysis.end
    if changing > end * (1 + ROUNDING):
        remark(
            "march_too_short",
            f"loads or supports change until t = {changing:g} s, and the march ends at {end:g} s "
            "at the latest; expected more time: raise analysis.max_steps or analysis.step",
        )
    return changing


def _update(scene: specs.Scene, stones: Stones, base: Path) -> Redetection | None:
    """What finds contacts anew during the march; None where they stay."""
    if scene.contact.update != "redetect":
        return None
    if not stones.where(lambda own: own is not None and not deforms(own)).any():
        raise SceneError(
            "contact.update is 'redetect', expected rigid blocks in the scene: elastic ones keep their "
            "contacts; set fidelity = 'rigid', or leave contact.update out"
        )
    if any(joint.scatter is not None for joint in scene.joints):
        raise SceneError(
            "contact.update is 'redetect' beside a joint with scatter, whose draws belong to the joints of "
            "the start; leave one of them out"
        )
    from masonry_fem.build.redetection import Redetection  # noqa: PLC0415 - few scenes ask for it

    return Redetection.of(scene, stones, base)


def _meet(scene: specs.Scene, stones: Stones, base: Path) -> Meeting | None:
    """What makes contacts of blocks that meet on the way; None where the scene wants its contacts fixed."""
    return None if scene.contact.update == "fixed" else Meeting(scene, stones, base)


def body_groups(
    scene: specs.Scene,
    stones: Stones,
    base: Path = Path(),
    before: tuple[BodyGroup, ...] = (),
    left: Expansions | None = None,
) -> tuple[BodyGroup, ...]:
    """One group of supports, and those that the stones' fidelities make, the coarsest first.

    Parameters
    ----------
    scene : The scene. stones : Its blocks. base : Folder that its paths are relative to.
    before : Groups of which what fits is used again.
    left : Strains by temperature that blocks have beside those of the scene.
    """
    groups: list[BodyGroup] = []
    warming = expansions(scene, stones, base)
    for block, changes in (left or {}).items():
        warming.setdefault(block, []).extend(changes)
    if held := stones.of(None):
        groups.append(SupportGroup(stones.assembly, held, [stones.motion.get(block) for block in held]))
    for kind in _used(stones):
        own = stones.of(kind.name)
        given = Given(
            assembly=stones.assembly,
            materials=dict(
                zip(own, map(scene.materials.__getitem__, taken(stones.material, np.array(own))), strict=True)
            ),
            clamps=stones.clamps,
            plane=scene.plane,
            lumped=scene.mass == "lumped",
            turns=scene.contact.update != "fixed",
            law=lambda stone: material_law(stone, base),
            before=tuple(group for group in before if group.kind == kind.name),
            warming=warming,
        )
        groups.extend(_checked(kind, group) for group in kind.groups(given))
    return tuple(groups)


def _checked(fidelity: type[Fidelity], group: BodyGroup) -> BodyGroup:
    """A group that has all that is asked of one, and the name of its fidelity, by which results call it."""
    made = type(group).__name__
    owed = (name for base in BodyGroup.__mro__ for name in (*vars(base), *get_annotations(base)))
    if lacking := sorted(name for name in {*owed} if not name.startswith("_") and not hasattr(group, name)):
        raise ExtensionError(
            f"fidelity '{fidelity.name}' makes a {made} that lacks {', '.join(lacking)}, expected all that "
            "BodyGroup in masonry_fem/bodies/base.py asks for; write it, or derive the class from RigidGroup"
        )
    if group.kind != fidelity.name:
        raise ExtensionError(
            f"fidelity '{fidelity.name}' makes a {made} whose kind is '{group.kind}', expected "
            f"'{fidelity.name}', as results call its stones; derive a class of its own from {made} with "
            f"kind = '{fidelity.name}'"
        )
    return group


def _used(stones: Stones) -> list[type[Fidelity]]:
    """Fidelities that some stones have."""
    return [kind for name, kind in fidelities().items() if name in stones.fidelity]


def _tell_gaps(stones: Stones, interfaces: Interfaces) -> None:
    """Say how many joints are open at the start, and which is the widest."""
    nearest = interfaces.nearest
    opened = int((nearest > GAP * typical_length(stones.assembly)).sum()) if interfaces else 0
    if opened:
        widest = interfaces[int(nearest.argmax())]
        first, second = (stones.assembly.blocks.names[block] for block in widest.blocks)
        logger.info(
            "%d of %d joints are open at the start, by up to %.3g m ('%s' and '%s')",
            opened, len(interfaces), nearest.max(), first, second,
        )  # fmt: skip


def _doubt_loose(stones: Stones, interfaces: Interfaces) -> None:
    """Warn of blocks that no support holds, directly or through others; they may be meant to fly."""
    loose = loose_blocks(stones, interfaces)
    if loose:
        names = first_few((f"'{stones.assembly.blocks.names[block]}'" for block in loose), SHOWN)
        remark(
            "loose",
            f"no support holds {names}, neither directly nor through other blocks; expected "
            "faces that touch, or a contact.reach [m] as wide as the gaps",
            *(stones.assembly.blocks.names[block] for block in loose),
        )


def loose_blocks(stones: Stones, interfaces: Interfaces) -> list[int]:
    """Blocks whose chain of neighbours leads to no support and to no clamped face."""
    count = len(stones.assembly.blocks)
    links = sparse.coo_array((np.ones(len(interfaces)), tuple(interfaces.blocks.T)), shape=(count, count))
    _, part = sparse.csgraph.connected_components(links, directed=False)
    held = part[np.array([*stones.of(None), *stones.clamps], dtype=np.int64)]
    loose: list[int] = np.flatnonzero(~np.isin(part, held)).tolist()
    return loose


def _between_free(stones: Stones, interfaces: Interfaces) -> Interfaces:
    """Interfaces with at least one block that is free to move."""
    free = stones.where(lambda fidelity: fidelity is not None)
    return interfaces.only(free[interfaces.blocks].any(axis=1))


def _probes(scene: specs.Scene, stones: Stones, groups: tuple[BodyGroup, ...]) -> tuple[Probe, ...]:
    blocks = stones.assembly.blocks
    made = []
    for index, probe in enumerate(scene.probes):
        key = f"probes.{index}.block"
        group, body = _owner(
            groups, only(select_blocks(probe.block, blocks, key), probe.block, blocks.names, key)
        )
        point = np.array(probe.point, dtype=float)
        try:
            groups[group].displacement(groups[group].rest(), body, point)
        except MasonryError as error:
            raise SceneError(f"probes.{index} ('{probe.name}'): {error}") from error
        made.append(Probe(probe.name, group, body, point))
    return tuple(made)


def _owner(groups: tuple[BodyGroup, ...], block: int) -> tuple[int, int]:
    for index, group in enumerate(groups):
        found = np.flatnonzero(group.blocks == block)
        if len(found):
            return index, int(found[0])
    raise AssertionError(f"block {block} is in no group")  # every block has a role


def _initial(scene: specs.Scene, stones: Stones, groups: tuple[BodyGroup, ...]) -> tuple[Any, ...]:
    """Rest, with the initial velocities that the scene gives."""
    states = [group.rest() for group in groups]
    blocks, d = stones.assembly.blocks, scene.dimension
    for index, initial in enumerate(scene.initial):
        velocity = np.zeros(d) if initial.velocity is None else np.array(initial.velocity, dtype=float)
        spin = (
            np.zeros(1 if d == 2 else 3) if initial.spin is None else np.ravel(np.array(initial.spin, float))
        )
        for block in select_blocks(initial.blocks, blocks, f"initial.{index}.blocks"):
            group, body = _owner(groups, block)
            if not groups[group].prescribed:
                states[group] = groups[group].with_velocity(states[group], body, velocity, spin)
    return tuple(states)
