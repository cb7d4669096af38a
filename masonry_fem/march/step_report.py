"""StepReport: what one step did, in numbers that do not take the solver's word for it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from masonry_fem.nscd import Outcome, Quality

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class StepReport:
    """Numbers of one step; forces and moments are in world axes, moments about the origin.

    Attributes
    ----------
    step, time : Number of the step and time at its end [s] (load factor in statics).
    kinetic_energy, strain_energy : At the end of the step [J]; no kinetic energy in statics.
    kinetic_before, strain_before, joint_energy_before : What the step began with [J].
    external_work, support_work : Work of the loads, and of moving supports and clamped faces in the step [J].
    heat_work : Work of temperature on stones that expand under stress in the step [J].
    contact_work : Work of the reactions on the relative motion [J].
    friction_dissipation : Energy spent by sliding in the step [J].
    impact_normal, impact_tangential : What points that hit lost across the faces and along them [J]; in
        statics the loads' work on gaps that close.
    material_dissipation : Lost as stones yield in the step [J].
    damping_dissipation, numerical_dissipation : By Rayleigh damping, and by steps of a finite length [J]:
        θ > ½ in bodies, forces of the step's end in joints and in stones that yield.
    energy_error : Energy that appears in the step from nowhere, < 0 where it is lost without a name [J].
    energy_rounding : What rounding alone may make of that [J].
    iterations, linear_solves : Of the contact solver.
    rounds : Iterations of Newton's method on stones that yield; 0 where all are linear.
    method : Contact solver that ran.
    outcome : Its outcome.
    quality : Its error measures. rounding : The error that rounding alone may make; 0 where the tolerance
        was met, and nobody asked.
    natural_map, max_penetration, block_balance : Worst relative natural map, worst penetration
        [m], worst residual of a block's momentum relative to weight times step.
    static_balance : The same with inertia left out: distance to a static equilibrium.
    global_balance : Loads and supports against the change of momentum over the step, relative to the
        largest of these forces.
    support_resultants : Force and moment about the origin that each support gives, [N], [N m].
    applied : Resultant of the loads on the free blocks, force and moment [N], [N m].
    probes : Displacement of the named points [m].
    open, stick, slip : Numbers of contacts. bonded : Those held by cohesion alone.
    joint_energy : Stored in cohesive joints at the end of the step [J].
    joint_dissipation, joint_viscosity : Lost to the damage of joints in the step and to its delay [J].
    adhesion_loss : Greatest loss of adhesion β of a contact in the step.
    joint_change : What the joint laws' turns left open of the joints' state; 0 where they settled.
    unsettled : Which stone is not in balance with its own stresses, and what it is made of; "" where all are.
    speed : Root mean square speed of the mass [m/s].
    load_acceleration : Loads on the blocks, or where there are none what clamps give, or contacts have given
        in a step so far, over their mass [m/s²].
    tie_forces : Of each tie [N].
    """

    step: int
    time: float
    kinetic_energy: float
    strain_energy: float
    external_work: float
    support_work: float
    contact_work: float
    friction_dissipation: float
    damping_dissipation: float
    numerical_dissipation: float
    energy_error: float
    energy_rounding: float
    iterations: int
    linear_solves: int
    method: str
    outcome: Outcome
    quality: Quality
    rounding: float
    natural_map: float
    max_penetration: float
    block_balance: float
    static_balance: float
    global_balance: float
    support_resultants: dict[str, FloatArray]
    applied: FloatArray
    probes: dict[str, FloatArray]
    open: int
    stick: int
    slip: int
    speed: float
    load_acceleration: float
    kinetic_before: float = 0.0
    strain_before: float = 0.0
    joint_energy_before: float = 0.0
    impact_normal: float = 0.0
    impact_tangential: float = 0.0
    bonded: int = 0
    joint_energy: float = 0.0
    joint_dissipation: float = 0.0
    joint_viscosity: float = 0.0
    adhesion_loss: float = 0.0
    joint_change: float = 0.0
    material_dissipation: float = 0.0
    heat_work: float = 0.0
    unsettled: str = ""
    rounds: int = 0
    tie_forces: dict[str, float] = field(default_factory=dict)

    def inertial_share(self, step: float) -> float:
        """Speed relative to what the loads give in one step from rest: 1 in free fall."""
        if self.speed == 0:
            return 0.0
        gained = self.load_acceleration * step
        return self.speed / gained if gained > 0 else float("inf")

    @property
    def so_far(self) -> str:
        """The number of steps with this one, in words."""
        return "1 step" if self.step == 1 else f"{self.step} steps"
