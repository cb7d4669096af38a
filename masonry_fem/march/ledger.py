"""Ledger: where the energy of a march went, summed over its steps.

    start + external + support + unaccounted = stored at the end + everything lost

``told()`` has all terms by the names of ``summary.json``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True)
class Ledger:
    """Energies since the start of a march [J].

    Attributes
    ----------
    start : Stored before the first step.
    kinetic, strain, stored : What is stored now, in motion, in stones and in cohesive joints.
    external, support : Work of loads, and of supports and clamped faces that move.
    contact : Work of the reactions on relative motion.
    friction, impact_normal, impact_tangential : Lost at contacts, by sliding and where points hit.
    damping : By Rayleigh damping, and where velocities are scaled between steps.
    numerical : By steps of a finite length (θ > ½; forces of the step's end in joints).
    joints, viscous : Dissipated by the damage of joints and by its delay.
    unaccounted : Sum of what the steps' balances leave, with signs.
    error : The same in absolute values. largest : Largest energy seen in any term.
    """

    start: float | None = None
    kinetic: float = 0.0
    strain: float = 0.0
    stored: float = 0.0
    external: float = 0.0
    support: float = 0.0
    contact: float = 0.0
    friction: float = 0.0
    impact_normal: float = 0.0
    impact_tangential: float = 0.0
    damping: float = 0.0
    numerical: float = 0.0
    joints: float = 0.0
    viscous: float = 0.0
    unaccounted: float = 0.0
    error: float = 0.0
    largest: float = 0.0

    def add(self, report: StepReport) -> Ledger:
        """The ledger after one more step."""
        first = self.start is None
        start = report.kinetic_before + report.strain_before + report.joint_energy_before
        # velocities are scaled between steps, and contacts found anew may have lost their joints
        still = 0.0 if first else self.kinetic - report.kinetic_before
        parted = 0.0 if first else self.stored - report.joint_energy_before
        added = replace(
            self,
            start=start if first else self.start,
            kinetic=report.kinetic_energy,
            strain=report.strain_energy,
            stored=report.joint_energy,
            external=self.external + report.external_work,
            support=self.support + report.support_work,
            contact=self.contact + report.contact_work,
            friction=self.friction + report.friction_dissipation,
            impact_normal=self.impact_normal + report.impact_normal,
            impact_tangential=self.impact_tangential + report.impact_tangential,
            damping=self.damping + report.damping_dissipation + still,
            numerical=self.numerical + report.numerical_dissipation,
            joints=self.joints + report.joint_dissipation + parted,
            viscous=self.viscous + report.joint_viscosity,
            unaccounted=self.unaccounted + report.energy_error,
            error=self.error + abs(report.energy_error),
        )
        terms = (value for name, value in added.told().items() if name != "unaccounted")
        return replace(added, largest=max(self.largest, *map(abs, terms)))

    def told(self) -> dict[str, float]:
        """All terms by their names in ``summary.json`` [J]; nothing before the first step but zeros."""
        return {
            "start": self.start or 0.0,
            "external_work": self.external,
            "support_work": self.support,
            "kinetic": self.kinetic,
            "strain": self.strain,
            "joints": self.stored,
            "friction_dissipation": self.friction,
            "impact_normal": self.impact_normal,
            "impact_tangential": self.impact_tangential,
            "joint_dissipation": self.joints,
            "joint_viscosity": self.viscous,
            "damping_dissipation": self.damping,
            "numerical_dissipation": self.numerical,
            "unaccounted": self.unaccounted,
        }

    @property
    def imbalance(self) -> float:
        """Error relative to the largest term; 0 where no energy moved."""
        return self.error / self.largest if self.largest > 0 else 0.0
