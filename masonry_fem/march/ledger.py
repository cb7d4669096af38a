"""Ledger: where the energy of a march went, summed over its steps.

    start + external + support + heat + unaccounted = stored at the end + everything lost

``summary.json`` has it as ``energy``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True)
class Ledger:
    """Energies since the start of a march [J].

    Attributes
    ----------
    start : Stored before the first step.
    kinetic, strain, joints : What is stored now, in motion, in stones and in cohesive joints.
    contact_work : Of the reactions on relative motion.
    external_work, support_work : Of loads, and of supports and clamped faces that move.
    heat_work : Of temperature, on stones that expand under stress.
    friction_dissipation : Lost by sliding. impact_normal, impact_tangential : Where points hit.
    joint_dissipation, joint_viscosity : Lost to the damage of joints and to its delay.
    material_dissipation : Lost as stones yield.
    damping_dissipation : By Rayleigh damping, and where velocities are scaled between steps.
    numerical_dissipation : By steps of a finite length (θ > ½; forces of the step's end in joints and
        in stones that yield).
    unaccounted : Sum of what the steps' balances leave, with signs.
    error : The same in absolute values. largest : Largest energy seen in any term.
    rounding : What rounding alone may make of ``error``.
    """

    start: float | None = None
    kinetic: float = 0.0
    strain: float = 0.0
    joints: float = 0.0
    contact_work: float = 0.0
    external_work: float = 0.0
    support_work: float = 0.0
    heat_work: float = 0.0
    friction_dissipation: float = 0.0
    impact_normal: float = 0.0
    impact_tangential: float = 0.0
    joint_dissipation: float = 0.0
    joint_viscosity: float = 0.0
    material_dissipation: float = 0.0
    damping_dissipation: float = 0.0
    numerical_dissipation: float = 0.0
    unaccounted: float = 0.0
    error: float = 0.0
    largest: float = 0.0
    rounding: float = 0.0

    def add(self, report: StepReport) -> Ledger:
        """The ledger after one more step."""
        first = self.start is None
        start = report.kinetic_before + report.strain_before + report.joint_energy_before
        # velocities are scaled between steps, and contacts found anew may have lost their joints
        still = 0.0 if first else self.kinetic - report.kinetic_before
        parted = 0.0 if first else self.joints - report.joint_energy_before
        added = Ledger(
            start=start if first else self.start,
            kinetic=report.kinetic_energy,
            strain=report.strain_energy,
            joints=report.joint_energy,
            contact_work=self.contact_work + report.contact_work,
            external_work=self.external_work + report.external_work,
            support_work=self.support_work + report.support_work,
            heat_work=self.heat_work + report.heat_work,
            friction_dissipation=self.friction_dissipation + report.friction_dissipation,
            impact_normal=self.impact_normal + report.impact_normal,
            impact_tangential=self.impact_tangential + report.impact_tangential,
            joint_dissipation=self.joint_dissipation + report.joint_dissipation + parted,
            joint_viscosity=self.joint_viscosity + report.joint_viscosity,
            material_dissipation=self.material_dissipation + report.material_dissipation,
            damping_dissipation=self.damping_dissipation + report.damping_dissipation + still,
            numerical_dissipation=self.numerical_dissipation + report.numerical_dissipation,
            unaccounted=self.unaccounted + report.energy_error,
            error=self.error + abs(report.energy_error),
            rounding=self.rounding + report.energy_rounding,
        )
        return replace(added, largest=max(self.largest, *(abs(getattr(added, name)) for name in TERMS)))

    @property
    def imbalance(self) -> float:
        """Error relative to the largest term; 0 where no term is more than rounding: no energy moved."""
        return self.error / self.largest if self.largest > self.rounding else 0.0

    @property
    def rounded(self) -> float:
        """What rounding alone may make of the imbalance."""
        return self.rounding / self.largest if self.largest > self.rounding else 0.0


NO_TERMS = ("contact_work", "unaccounted", "error", "largest", "rounding")
TERMS = tuple(field.name for field in fields(Ledger) if field.name not in NO_TERMS)
