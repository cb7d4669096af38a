"""Fields: displacement, velocity and stress of all blocks at one instant, and the forces of contacts.

Field files store these named arrays and pictures read them. Vectors are in world axes; tensors have the
components (xx, yy, zz, xy, yz, xz), which is ParaView's order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.joints.law import layers_of
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import tie_forces
from masonry_fem.output.grid import Grid, three
from masonry_fem.output.strength import Strengths, principal, utilisation, von_mises

FloatArray = NDArray[np.float64]
Arrays = dict[str, NDArray[np.generic]]

DISPLACEMENT, VELOCITY = "displacement", "velocity"
STRESS, VON_MISES, PRINCIPAL = "stress", "von_mises", "principal_stress"
STRESS_ERROR, UTILISATION = "stress_error", "utilisation"
DIRECTIONS = ("principal_direction_1", "principal_direction_2", "principal_direction_3")
BLOCK, GROUP, FIDELITY, MATERIAL = "block", "group", "fidelity", "material"
REACTION, TRACTION, NORMAL, STATUS = "reaction", "traction", "normal", "status"
GAP, SLIP, INTERFACE, AREA = "gap", "relative_velocity", "interface", "area"
ADHESION, JUMP = "adhesion", "jump"
BED, CRUSHED, DILATION, CLOSURE = "bed", "crushed", "dilation", "closure"
TIE, TIE_ELONGATION, TIE_UTILISATION = "tie", "tie_elongation", "tie_utilisation"
SCATTER = "scatter_"  # and the parameter
CANDIDATE, ANTAGONIST = "candidate", "antagonist"
TANGENTS, LOCAL, ARMS = ("tangent_1", "tangent_2"), "reaction_local", ("arm_candidate", "arm_antagonist")
PROMOTED = "inelastic"  # of fidelity ``auto``: whether a stone has its law by now
# of cells; what else they have is what material laws measure
CELLS = (
    BLOCK,
    GROUP,
    FIDELITY,
    MATERIAL,
    STRESS,
    VON_MISES,
    PRINCIPAL,
    *DIRECTIONS,
    STRESS_ERROR,
    UTILISATION,
    PROMOTED,
)


def point_arrays(grid: Grid, model: Model, state: SystemState) -> Arrays:
    """Nodal fields: displacement [m], velocity [m/s] and, for blocks that have them, stresses [Pa].

    Parameters
    ----------
    grid : Grid of the model.
    model, state : Of which instant.
    """
    displacement, velocity = np.zeros_like(grid.points), np.zeros_like(grid.points)
    for (start, stop), group, moved in zip(grid.group_points, model.groups, state.bodies, strict=True):
        displacement[start:stop, : grid.dimension] = group.displacements(moved)
        velocity[start:stop, : grid.dimension] = group.velocities(moved)
    arrays: Arrays = {DISPLACEMENT: displacement, VELOCITY: velocity, BLOCK: grid.point_block}
    stress = np.full((len(grid.points), 6), np.nan)
    for (start, stop), group, moved in zip(grid.group_points, model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is not None:
            stress[start:stop] = field.nodal.reshape(-1, 6)
    return arrays | stress_arrays(stress)


def cell_arrays(grid: Grid, model: Model, state: SystemState) -> Arrays:
    """Cell fields: block and group numbers and, for blocks that have them, mean stresses [Pa].

    Parameters
    ----------
    grid : Grid of the model.
    model, state : Of which instant.
    """
    stress = np.full((len(grid.types), 6), np.nan)
    for (start, stop), group, moved in zip(grid.group_cells, model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is not None:
            mean = np.einsum("bcgs,cg->bcs", field.gauss, field.weight) / field.weight.sum(axis=1)[:, None]
            stress[start:stop] = mean.reshape(-1, 6)
    numbers: Arrays = {BLOCK: grid.cell_block, GROUP: grid.cell_group, FIDELITY: grid.cell_fidelity}
    measures = _material_state(grid, model, state)
    return numbers | stress_arrays(stress) | _stress_error(grid, model, state) | measures


def _material_state(grid: Grid, model: Model, state: SystemState) -> Arrays:
    """Cell means of what material laws remember, NaN in other blocks; {} where there are no such laws."""
    arrays: dict[str, FloatArray] = {}
    for (start, stop), group, moved in zip(grid.group_cells, model.groups, state.bodies, strict=True):
        kept = group.material_state(moved)
        if not kept:
            continue
        field = group.stress(moved)
        assert field is not None  # what yields has stresses
        share = field.weight / field.weight.sum(axis=1)[:, None]
        for name, values in kept.items():
            whole = arrays.setdefault(name, np.full(len(grid.types), np.nan))
            whole[start:stop] = (values * share).sum(axis=2).ravel()
    return {**arrays}


def _stress_error(grid: Grid, model: Model, state: SystemState) -> Arrays:
    """Estimated error of the stress as density e²/V [J/m³ = Pa], NaN in rigid blocks; {} where all are."""
    density, known = np.full(len(grid.types), np.nan), False
    for (start, stop), group, moved in zip(grid.group_cells, model.groups, state.bodies, strict=True):
        error = group.stress_error(moved)
        if error is not None:
            density[start:stop], known = (error.squares / error.volume).ravel(), True
    return {STRESS_ERROR: density} if known else {}


def stress_arrays(stress: FloatArray) -> Arrays:
    """Stress, von Mises, principal values (largest first) and directions; {} where no row has a value.

    Rows without stress (rigid blocks) hold NaN throughout.
    """
    known = ~np.isnan(stress[:, 0])
    if not known.any():
        return {}
    values = np.full((len(stress), 3), np.nan)
    directions = np.full((len(stress), 3, 3), np.nan)
    mises = np.full(len(stress), np.nan)
    values[known], directions[known] = principal(stress[known])
    mises[known] = von_mises(stress[known])
    named = {name: directions[:, i] for i, name in enumerate(DIRECTIONS)}
    return {STRESS: stress, VON_MISES: mises, PRINCIPAL: values, **named}


def utilisation_arrays(arrays: Arrays, block: NDArray[np.int64], strengths: Strengths | None) -> Arrays:
    """Utilisation of the stresses of points or cells (``strength``); {} where there is none.

    Parameters
    ----------
    arrays : With the principal stresses of n points or cells.
    block : Block of each, shape (n,).
    strengths : Of the blocks; None where no stone has one.
    """
    if strengths is None or PRINCIPAL not in arrays:
        return {}
    values = np.asarray(arrays[PRINCIPAL], dtype=float)
    tension, compression = strengths.tension_design[block], strengths.compression_design[block]
    return {UTILISATION: utilisation(values, tension, compression)}


def joint_arrays(model: Model, state: SystemState) -> Arrays:
    """States of joint laws, in world axes; {} if all joints are dry.

    The intensity of adhesion β (NaN in dry joints) and the jump [m]; with mortar what its bed gives way and
    the part of it that is crushed [m], ≤ 0; with closure by how much asperities have closed [m]; with
    dilatancy the opening by sliding [m].
    """
    joints = state.joints
    if all(law.plain for part, _ in model.laws.parts for law in layers_of(part) if law.pull is None):
        return {}

    def world(vectors: FloatArray) -> FloatArray:
        return three(np.einsum("cai,ca->ci", state.frame, vectors))

    bonded = model.laws.initial(*state.jump.shape).adhesion > 0
    arrays: Arrays = {ADHESION: np.where(bonded, joints.adhesion, np.nan), JUMP: world(state.jump)}
    layers = {law.name for part, _ in model.laws.parts for law in layers_of(part)}
    if "bed" in layers:
        arrays |= {BED: world(joints.bed), CRUSHED: joints.crushed}
    if "closure" in layers:
        arrays |= {CLOSURE: -joints.closing[:, 0]}
    return arrays | ({DILATION: joints.dilation} if "rough" in layers else {})


def _arms(state: SystemState) -> Arrays:
    """Where reactions act on the two blocks as these balance [m]; {} where no march has said it."""
    if state.acting is None:
        return {}
    return {name: three(state.acting.arms[:, side]) for side, name in enumerate(ARMS)}


def contact_arrays(model: Model, state: SystemState) -> Arrays:
    """What contact points carry, in world axes; reactions [N] act on the candidate.

    ``reaction_local`` has their components along the normal and the tangents. ``arm_candidate`` and
    ``arm_antagonist`` are the points where reactions act in the balance of the two blocks
    (``march.acting``). The states of joint laws are added where there are any, and properties that scatter
    as factors on the scene's values, such as ``scatter_cohesion``; where there are ties ``tie`` leads from
    the point of one to its other end, and is nought elsewhere [m]; ``tie_elongation`` [m] and
    ``tie_utilisation`` are those of the results, NaN elsewhere and where a tie never yields.

    Parameters
    ----------
    model, state : Of which instant.
    """
    contacts, frame = model.contacts, state.reaction_frame
    reaction = three(np.einsum("cai,ca->ci", frame, state.reaction))
    area = contacts.area[:, None]  # nothing belongs to the corner nodes of quadratic triangles
    cohesion = joint_arrays(model, state)
    ties: Arrays = {}
    if (told := tie_forces(model, state)) is not None:
        reach = np.zeros_like(state.points)
        reach[told.contacts] = told.ends[:, 1] - told.ends[:, 0]
        elongation, used = np.full((2, contacts.count), np.nan)
        elongation[told.contacts] = told.elongation
        used[told.contacts] = np.where(told.yields, told.utilisation, np.nan)
        ties = {TIE: three(reach), TIE_ELONGATION: elongation, TIE_UTILISATION: used}
    scatter: Arrays = {SCATTER + name.replace(".", "_"): values for name, values in model.scatter.items()}
    return (
        cohesion
        | ties
        | scatter
        | {
            REACTION: reaction,
            TRACTION: np.divide(reaction, area, out=np.zeros_like(reaction), where=area > 0),
            LOCAL: three(state.reaction),
            NORMAL: three(frame[:, 0]),
            **{name: three(frame[:, 1 + i]) for i, name in enumerate(TANGENTS[: frame.shape[1] - 1])},
            **_arms(state),
            SLIP: three(np.einsum("cai,ca->ci", frame, state.velocity)),
            GAP: state.gap,
            STATUS: state.status.astype(np.int64),
            AREA: contacts.area,
            INTERFACE: contacts.interface,
            CANDIDATE: contacts.blocks[:, 0],
            ANTAGONIST: contacts.blocks[:, 1],
        }
    )
