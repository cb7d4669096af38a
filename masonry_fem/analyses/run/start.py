"""Start: whether a run's equilibrium is reached from a start without stress, or stands only if pre-stressed.

    told = started(made)
    told.reached, told.thrust, told.sentence()

Rigid blocks alone are asked: elastic ones take their stress from what moves (``nscd.unstressed``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_fem.errors import MasonryError
from masonry_fem.march.coupling import connect
from masonry_fem.march.loads import external_forces
from masonry_fem.march.march import March
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.motion import FloatArray
from masonry_fem.march.recognition import mechanism_of_step
from masonry_fem.march.ties import without_ties
from masonry_fem.nscd import Outcome
from masonry_fem.nscd.unstressed import from_no_stress
from masonry_fem.output.sheet import quantity
from masonry_fem.records.remark import first_few
from masonry_fem.results.summary import StartTold

CLOSED = 1e-6  # of a block's size: a gap that is none
DIGITS = 4
SHOWN = 4  # joints that are named

COHESIVE = "joints with a law of their own may hold blocks without any thrust, so this is not examined"
TIED = "ties may hold blocks that would fall without, so this is not examined"
MIXED = "as rigid stones it would not be, and how elastic ones brace the others is not examined"
UNTOLD = "no state from a start without stress was found, nor that there is none"


@dataclass(frozen=True, slots=True)
class Start:
    """What is known of how an equilibrium may come about.

    Attributes
    ----------
    reached : From a start without stress; False: it stands only if it is pre-stressed; None: not known.
    note : Why it is not known.
    thrust : Least pre-stress of a joint with which the loads are carried [N]; None: not known.
    joints : Between which blocks it is needed.
    mechanism : How blocks move without it, where the march does not say so itself.
    plane : A plane scene, whose forces are per metre.
    """

    reached: bool | None
    note: str = ""
    thrust: float | None = None
    joints: tuple[tuple[str, str], ...] = ()
    mechanism: Mechanism | None = None
    plane: bool = False

    def sentence(self) -> str:
        """The same in words."""
        if self.reached:
            return "Reached from a start without stress."
        if self.reached is None:
            return f"Whether it is reached from a start without stress is not known: {self.note}."
        words = "It stands only if it is pre-stressed"
        if self.thrust is not None:
            words += f" by at least {quantity(self.thrust, 'N/m' if self.plane else 'N', DIGITS)}"
        if self.joints:
            words += f" between {first_few((' / '.join(pair) for pair in self.joints), SHOWN)}"
        if self.mechanism is not None:
            words += f"; from a start without stress it falls: {self.mechanism.sentence()}"
        return f"{words}."

    def told(self) -> StartTold:
        """What ``summary.json`` holds."""
        if self.reached is not False:
            return StartTold(reached=self.reached, note=self.note or None)
        return StartTold(
            reached=False,
            message=self.sentence(),
            least_thrust=self.thrust,
            joints=self.joints,
            mechanism=None if self.mechanism is None else self.mechanism.told(),
        )


def started(made: March) -> Start | None:
    """How an equilibrium may come about; None where a march ended without and none is thinkable."""
    problem = made.last.problem
    if made.last.solution.outcome is Outcome.UNSTRESSED:
        return _needing(made, mechanism_of_step(made.last, made.model), made.last.solution.impulse)
    if made.outcome != "equilibrium":
        return None
    soft = problem.operator.elastic()
    if soft.all():  # stresses come from deformation, or there are no contacts
        return Start(True)
    if not made.model.laws.all_plain:
        tied = made.model.contacts.ties is not None
        return Start(
            None, TIED if tied and without_ties(made.model, made.state)[0].laws.all_plain else COHESIVE
        )
    step = made.last
    closed = step.after.gap[step.contacts] <= CLOSED * made.model.length
    closed |= step.solution.impulse[:, 0] > 0
    found = from_no_stress(problem.without_compliance(), closed)
    if found.reached is None or (soft.any() and not found.reached):
        return Start(None, MIXED if soft.any() else UNTOLD)
    return Start(True) if found.reached else _needing(made, _mechanism(made, found.motion), found.impulse)


def said(made: March, start: Start | None) -> March:
    """The march, with what its equilibrium needs to stand added to the message.

    Parameters
    ----------
    made : How the march ended.
    start : How its equilibrium may come about; None where there is nothing to say.
    """
    if start is None or start.reached:
        return made
    return replace(made, message=f"{made.message} {start.sentence()}")


def _needing(made: March, motion: Mechanism, impulse: FloatArray) -> Start:
    """What a structure needs that stands only if it is pre-stressed.

    ``motion`` is how it falls without, ``impulse`` what the loads alone press its joints by, (k, d).
    """
    plane = made.model.assembly.dimension == 2
    falls = motion if made.outcome == "equilibrium" else None  # else it is the march's own
    joints = [joint.facets for joint in motion.joints]
    pressed = np.zeros(made.model.contacts.count)
    pressed[made.last.contacts] = impulse[:, 0] / made.last.scheme.step
    from masonry_fem.limit import limit_problem  # noqa: PLC0415 - what is reached needs no program
    from masonry_fem.limit.prestress import least_prestress  # noqa: PLC0415

    try:
        forces = external_forces(made.model, made.state.time, made.state.bodies)
        # what runs off is looked at where it was
        bodies = made.state.bodies if made.outcome == "equilibrium" else made.last.before.bodies
        problem = limit_problem(made.model, forces, bodies=bodies)
        least = least_prestress(problem, joints, pressed)
    except MasonryError:
        least = None
    if least is None:
        return Start(False, mechanism=falls, plane=plane)
    pressed_on = least.rises > 1e-3 * least.thrust
    between = tuple(joint.between for joint, needed in zip(motion.joints, pressed_on, strict=True) if needed)
    return Start(False, thrust=least.thrust, joints=between, mechanism=falls, plane=plane)


def _mechanism(made: March, velocity: FloatArray) -> Mechanism:
    """The motion by which blocks run off."""
    step, model = made.last, made.model
    coupling = connect(model)
    rigid = coupling.scatter(velocity / np.abs(velocity).max(), step.free)
    before = tuple(
        own if free.origin is None else free.origin
        for own, free in zip(step.before.bodies, step.free, strict=True)
    )
    bodies = tuple(
        group.advance(own, replace(free, origin=None), motion, None, step.scheme)
        for group, own, free, motion in zip(model.groups, before, step.free, rigid, strict=True)
    )
    start, end = replace(step.before, bodies=before), replace(step.after, bodies=bodies)
    return mechanism_of_step(replace(step, before=start, after=end), model)
