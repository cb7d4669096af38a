"""Step: one θ-step of all blocks with contact, written as Newton-Raphson on the blocks.

Each iteration linearises the blocks at the last guess, condenses them to the contacts, solves the
contact problem and feeds the impulses back (formulation 3). Linear blocks end after one iteration.
Statics is the same step with inertia 0 (formulation 2b).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.base import FloatArray, Free, Scheme
from masonry_fem.dynamics.clock import Clock
from masonry_fem.dynamics.cohesion import JointStep, solve_with_laws
from masonry_fem.dynamics.coupling import ROUNDING as COORDINATES
from masonry_fem.dynamics.coupling import Coupling, Placement
from masonry_fem.dynamics.loads import blend, external_forces
from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.state import BONDED, OPEN, SLIP, STICK, SystemState
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, solve
from masonry_fem.nscd.laws.state import JointState

NEWTON_LIMIT = 20
NEWTON_TOLERANCE = 1e-9  # of a block's impulse, on the volume residual
PATIENCE = 4  # rounds of statics that bring impulses no nearer to balance where blocks have gone
ROUNDING = 1e-12  # of the model's length: a gap that is none
SLIGHT = 1e-6  # of the model's length: an overlap that is not driven apart
DRIFT = 1e-6  # of the model's length: how far a pressed contact of the velocity form may drift


@dataclass(frozen=True, slots=True)
class Increment:
    """Everything that one step computed, for reports and checks.

    Attributes
    ----------
    before, after : System states at both ends.
    problem : The contact problem of the last iteration.
    solution : Its solution.
    contacts : Numbers of the contacts that took part in it, shape (k,).
    impulse : Contact impulses of all contacts, local frames [N s], shape (c, d).
    forces : F_θ by group. scheme : Its coefficients.
    free : Steps of the groups without contact. rigid : U⁺ by group.
    rigid_impulse, nodal_impulse : Bᵀ p and Gᵀ p by group.
    here : Contact geometry that the impulses balance in: of the end in statics, of the start where
        there is inertia (or a mechanism). rigid_map : B there, of all contacts, supports too.
    joint_change : What the joint laws' turns left open of the joints' state; 0 where they settled.
    jammed : Overlaps were held that ``expulsion`` was to drive apart, as no motion does that.
    """

    before: SystemState
    after: SystemState
    problem: ContactProblem
    solution: Solution
    contacts: NDArray[np.int64]
    impulse: FloatArray
    forces: tuple[FloatArray, ...]
    scheme: Scheme
    free: tuple[Free, ...]
    rigid: tuple[FloatArray, ...]
    rigid_impulse: tuple[FloatArray, ...]
    nodal_impulse: tuple[FloatArray | None, ...]
    here: Placement
    rigid_map: FloatArray
    joint_change: float = 0.0
    jammed: bool = False

    @property
    def adhesion_loss(self) -> float:
        """Greatest loss of adhesion of a contact; 0 where joints are dry."""
        before, after = self.before.joints, self.after.joints
        if before is None or after is None:
            return 0.0
        return float((before.adhesion - after.adhesion).max(initial=0.0))


def initial_state(model: Model, coupling: Coupling, bodies: tuple[Any, ...], at: float = 0.0) -> SystemState:
    """The system in given body states, before any step: no reactions yet."""
    here, laws = coupling.placement(bodies), model.laws
    return SystemState(
        time=at,
        index=0,
        bodies=bodies,
        reaction=np.zeros_like(here.points),
        velocity=relative_velocity(model, coupling, bodies, here, coupling.rigid_map(bodies, here)),
        gap=here.gap,
        status=np.full(model.contacts.count, STICK, dtype=np.int8),
        frame=here.frame,
        points=here.points,
        acting_frame=here.frame,
        acting_points=coupling.arms(here),
        jump=None if laws is None else np.zeros_like(here.points),
        joints=None if laws is None else laws.initial(*here.points.shape),
    )


def relative_velocity(
    model: Model, coupling: Coupling, bodies: tuple[Any, ...], here: Placement, rigid_map: FloatArray
) -> FloatArray:
    """Relative velocity of the contact points in the local frames, shape (c, d) [m/s]."""
    parts = [group.velocity_parts(state) for group, state in zip(model.groups, bodies, strict=True)]
    rigid = coupling.rigid_velocity(tuple(part[0] for part in parts), rigid_map)
    return rigid + coupling.elastic_velocity(tuple(part[1] for part in parts), here)


def step(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float | None = None,
    clock: Clock | None = None,
) -> Increment:
    """Advance ``state`` by one step of ``scheme``.

    ``until`` is the time at the end (default: time + h; statics gives the load factor); ``clock``
    gathers the CPU time of the phases.
    """
    end = state.time + scheme.step if until is None else until
    clock = Clock() if clock is None else clock
    before, after = external_forces(model, state.time), external_forces(model, end)
    forces = blend(before, after, scheme.theta)
    start = here = coupling.placement(state.bodies)
    rigid_map = coupling.rigid_map(state.bodies, here)
    static, least, idle = scheme.inertia == 0, np.inf, 0
    clock.lap("step")
    guess, joints = state.bodies, state.joints
    bend = np.zeros_like(here.points)
    solved: Solution | None = None
    change = 0.0
    for _ in range(NEWTON_LIMIT):
        compliance = coupling.compliance(here, scheme)
        clock.lap("factorise" if compliance.nnz else "step")  # rigid blocks have no compliance
        free = tuple(
            group.free(own, at, force, scheme)
            for group, own, at, force in zip(model.groups, state.bodies, guess, forces, strict=True)
        )
        problem, active = _contact_problem(
            model, coupling, state, scheme, free, (start, here), rigid_map, compliance, bend
        )
        clock.lap("step")
        first = _start(state, scheme, active)
        if solved is not None:  # blocks that are linear after all keep it as it is
            first = Start(solved.impulse, solved.rigid_velocity)
        if model.laws is None or state.joints is None or joints is None:
            solution = solve(problem, settings, first)
        else:
            taken = solve_with_laws(
                model.laws, state.joints, _joint_step(model, state, scheme, start, active, joints), problem,
                settings, first,
            )  # fmt: skip
            solution, problem, joints, change = taken.solution, taken.problem, taken.joints, taken.change
        clock.lap("solve")
        solution = solved = solution if solved is None else _summed(solved, solution)
        impulse = np.zeros_like(here.points)
        impulse[active] = solution.impulse
        rigid = coupling.scatter(solution.rigid_velocity, free)
        nodal = coupling.nodal_impulses(impulse, here)
        bodies = tuple(
            group.advance(own, part, velocity, push, scheme)
            for group, own, part, velocity, push in zip(
                model.groups, state.bodies, free, rigid, nodal, strict=True
            )
        )
        elastic = tuple(
            group.velocity_parts(moved)[1] for group, moved in zip(model.groups, bodies, strict=True)
        )
        velocity = bend + coupling.rigid_velocity(rigid, rigid_map) + coupling.elastic_velocity(elastic, here)
        there = coupling.placement(bodies)
        if solution.outcome.moves:
            break
        if static and solution.converged:  # the impulses are to balance where the step ends
            map_there = coupling.rigid_map(bodies, there)
            left = _turning(
                model, coupling, state.bodies, bodies, free, forces, scheme, impulse, map_there - rigid_map
            )
            way = there.offset - start.offset - scheme.step * velocity
            missed = float(np.abs(way).max(initial=0.0)) / model.length
            holds = left <= settings.tolerance and missed <= ROUNDING
            left = max(left, missed)
            guess, here, rigid_map = bodies, there, map_there
        elif guess is not state.bodies:
            break
        else:
            rigid_impulse = coupling.rigid_impulses(impulse, rigid_map)
            left = _volume_residual(model, state.bodies, bodies, forces, rigid_impulse, nodal, scheme)
            holds = left <= NEWTON_TOLERANCE
        clock.lap("step")
        idle = 0 if left <= 0.5 * least else idle + 1
        least = min(left, least)
        if holds or idle > PATIENCE * static:
            break  # holds, or as far as rounding lets it go
        if static and solution.converged:
            bend = _bend(model, coupling, scheme, (start, here), bodies, rigid_map)
    rigid_impulse = coupling.rigid_impulses(impulse, rigid_map)
    if static:
        nodal = coupling.nodal_impulses(impulse, here)
    pressed = np.zeros_like(impulse)  # what Signorini and Coulomb hold for
    pressed[active] = problem.contact_part(solution.impulse, solution.velocity)
    friction = _friction(model, state)
    friction[active] = problem.friction
    reached = SystemState(
        time=end,
        index=state.index + 1,
        bodies=bodies,
        reaction=impulse / scheme.step,
        velocity=velocity,
        gap=there.gap,
        status=contact_status(pressed, friction, impulse),
        frame=there.frame,
        points=there.points,
        acting_frame=here.frame,
        acting_points=coupling.arms(here),
        jump=None if state.jump is None else _jump(state, scheme) + scheme.step * scheme.theta * velocity,
        joints=None if joints is None else joints.committed(),
        rigid_velocity=solution.rigid_velocity,
    )
    clock.lap("step")
    return Increment(
        state, reached, problem, solution, active, impulse, forces, scheme, free, rigid, rigid_impulse,
        nodal, here, rigid_map, change,
    )  # fmt: skip


def _turning(
    model: Model,
    coupling: Coupling,
    before: tuple[Any, ...],
    after: tuple[Any, ...],
    free: tuple[Free, ...],
    forces: tuple[FloatArray, ...],
    scheme: Scheme,
    impulse: FloatArray,
    change: FloatArray,
) -> float:
    """What blocks that went on to ``after`` leave of a balance, relative to the largest load of any.

    ``change`` is that of B. Loads on blocks that turn change their moments, too.
    """
    worst, scale, d = 0.0, 0.0, model.assembly.dimension
    for group, old, new, part, force, push in zip(
        model.groups, before, after, free, forces, coupling.rigid_impulses(impulse, change), strict=True
    ):
        if group.prescribed:
            continue
        moments = np.zeros_like(push)
        if part.elastic is None:
            moments = group.free(old, new, force, scheme).rigid_impulse - part.rigid_impulse
        size = np.sqrt(group.mass) * np.linalg.norm(push + moments, axis=1)
        worst = max(worst, float(size.max(initial=0.0)))
        given = scheme.step * np.linalg.norm(group.resultant(force)[:, :d], axis=1)
        scale = max(scale, float(given.max(initial=0.0)))
    return worst / scale if scale > 0 else worst


def _summed(first: Solution, second: Solution) -> Solution:
    """The second of two rounds, with the efforts of both."""
    return replace(
        second,
        iterations=first.iterations + second.iterations,
        linear_solves=first.linear_solves + second.linear_solves,
        seconds=first.seconds + second.seconds,
    )


def _bend(
    model: Model,
    coupling: Coupling,
    scheme: Scheme,
    ends: tuple[Placement, Placement],
    bodies: tuple[Any, ...],
    rigid_map: FloatArray,
) -> FloatArray:
    """What velocities miss of the way between two placements, as points that turn go on arcs, (c, d) [m/s].

    With it the velocity at the contacts is exact at ``bodies``, and its derivative is G there.
    """
    start, here = ends
    bend = here.offset - start.offset
    bend -= scheme.step * relative_velocity(model, coupling, bodies, here, rigid_map)
    bend[np.abs(bend) <= COORDINATES * np.abs(here.points).max(initial=0.0)] = 0.0
    return bend / scheme.step


def _contact_problem(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    free: tuple[Free, ...],
    ends: tuple[Placement, Placement],
    rigid_map: FloatArray,
    compliance: sparse.bsr_array,
    bend: FloatArray,
) -> tuple[ContactProblem, NDArray[np.int64]]:
    """The step's contact problem on the contacts that take part, and their numbers.

    ``ends`` are where the step begins, and where it is linearised.
    """
    start, here = ends
    q = coupling.elastic_velocity(tuple(part.elastic for part in free), here)
    q += coupling.rigid_velocity(
        tuple(
            part.rigid_velocity if group.prescribed else np.zeros_like(part.rigid_velocity)
            for group, part in zip(model.groups, free, strict=True)
        ),
        rigid_map,
    )
    q += _gap_term(model, state, scheme, start) + bend
    takes_part = ~model.joints.velocity_form | _closed(model, state, scheme, start)
    if state.joints is not None:
        takes_part |= ~state.joints.broken  # cohesion acts across a gap, too
    active = np.flatnonzero(takes_part)
    if len(active) < len(q):
        d = q.shape[1]
        dofs = (active[:, None] * d + np.arange(d)).ravel()
        compliance = sparse.bsr_array(compliance.tocsr()[dofs][:, dofs], blocksize=(d, d))
    problem = ContactProblem(
        friction=_friction(model, state)[active],
        free_velocity=q[active],
        compliance=compliance,
        bodies=coupling.bodies[active],
        rigid_map=np.where(coupling.bodies[active][:, :, None, None] >= 0, rigid_map[active], 0.0),
        rigid_mass=coupling.gather(free, "rigid_mass"),
        rigid_impulse=coupling.gather(free, "rigid_impulse"),
        rigid_velocity=coupling.gather(free, "rigid_velocity"),
    )
    return problem, active


def _closed(model: Model, state: SystemState, scheme: Scheme, here: Placement) -> NDArray[np.bool_]:
    """Contacts that the velocity form takes for closed, shape (c,).

    A gap of rounding size is closed, and so is what was pressed to rest: the solver's tolerance lets its
    gap drift, and a step without the contact would end in a second impact.
    """
    shifted = here.gap + scheme.step * (1 - scheme.theta) * state.velocity[:, 0]
    pressed = (state.reaction[:, 0] > 0) & (state.status != OPEN) & (model.joints.restitution == 0)
    closed: NDArray[np.bool_] = shifted <= np.where(pressed, DRIFT, ROUNDING) * model.length
    return closed


def _gap_term(
    model: Model, state: SystemState, scheme: Scheme, here: Placement, closure: FloatArray | float = 0.0
) -> FloatArray:
    """What gaps and impacts add to the free velocity, shape (c, d) [m/s].

    ``closure`` is the gap at which the faces touch [m].
    """
    joints, h = model.joints, scheme.step
    shifted = here.gap + h * (1 - scheme.theta) * state.velocity[:, 0] - closure
    impact = joints.velocity_form & _closed(model, state, scheme, here)
    term = np.empty_like(state.velocity)
    # an overlap is held, or driven apart slowly; one that is all but rounding is no overlap
    driven = np.where(shifted < -SLIGHT * model.length, model.expulsion, 0.0)
    approach = np.maximum(shifted / h, -driven)
    # cohesion across a gap in the velocity form: contact is for the step that finds it closed
    approach += np.where(joints.velocity_form & ~impact, 2.0 * np.abs(state.velocity[:, 0]), 0.0)
    term[:, 0] = np.where(impact, joints.restitution * state.velocity[:, 0], approach)
    slides_back = np.where(impact, joints.tangential_restitution, 0.0)
    term[:, 1:] = slides_back[:, None] * state.velocity[:, 1:]
    return term


def _jump(state: SystemState, scheme: Scheme) -> FloatArray:
    """ũ, the jump shifted as gaps are, shape (c, d) [m]."""
    assert state.jump is not None  # the model has laws
    shifted: FloatArray = state.jump + scheme.step * (1 - scheme.theta) * state.velocity
    return shifted


def _joint_step(
    model: Model,
    state: SystemState,
    scheme: Scheme,
    here: Placement,
    active: NDArray[np.int64],
    trial: JointState,
) -> JointStep:
    return JointStep(
        active=active,
        trial=trial,
        jump=_jump(state, scheme),
        area=model.contacts.area,
        gap_term=lambda closure: _gap_term(model, state, scheme, here, closure),
        length=scheme.step,
    )


def _start(state: SystemState, scheme: Scheme, active: NDArray[np.int64]) -> Start | None:
    """Last step's reactions as a first guess; none before the first step.

    Statics goes on as it went: its velocities are displacements per load factor, whatever the step.
    """
    if not state.reaction.any():
        return None
    goes_on = state.rigid_velocity if scheme.inertia == 0 else None
    return Start(impulse=scheme.step * state.reaction[active], rigid_velocity=goes_on)


def _friction(model: Model, state: SystemState) -> FloatArray:
    joints = model.joints
    return np.where(state.status == SLIP, joints.dynamic_friction, joints.friction)


def contact_status(
    pressed: FloatArray, friction: FloatArray, impulse: FloatArray | None = None
) -> NDArray[np.int8]:
    """Open, stick, slip or bonded, to 1e-8 of the largest.

    ``pressed`` is what contact and friction carry; with cohesion ``impulse`` is what acts on the blocks.
    """
    normal, tangent = pressed[:, 0], np.linalg.norm(pressed[:, 1:], axis=1)
    small = 1e-8 * np.abs(normal).max(initial=0.0)
    status = np.full(len(pressed), STICK, dtype=np.int8)
    status[tangent >= friction * normal * (1 - 1e-8)] = SLIP
    status[normal <= small] = OPEN
    if impulse is not None:
        held = np.linalg.norm(impulse, axis=1)
        status[(status == OPEN) & (held > 1e-8 * held.max(initial=0.0))] = BONDED
    return status


def _volume_residual(
    model: Model,
    before: tuple[Any, ...],
    after: tuple[Any, ...],
    forces: tuple[FloatArray, ...],
    rigid_impulse: tuple[FloatArray, ...],
    nodal: tuple[FloatArray | None, ...],
    scheme: Scheme,
) -> float:
    """Largest momentum residual of a block relative to the largest impulse on any."""
    worst, scale = 0.0, 0.0
    for group, old, new, force, push, field in zip(
        model.groups, before, after, forces, rigid_impulse, nodal, strict=True
    ):
        if group.prescribed:
            continue
        residual = group.imbalance(old, new, force, push, field, scheme)
        worst = max(worst, float(np.abs(residual).max(initial=0.0)))
        given = scheme.step * np.linalg.norm(group.resultant(force)[:, : model.assembly.dimension], axis=1)
        scale = max(scale, float(given.max(initial=0.0)))
    return worst / scale if scale > 0 else worst
