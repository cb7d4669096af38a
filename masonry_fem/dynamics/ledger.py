"""Ledger: where the energy of a march went, summed over its steps."""

from __future__ import annotations

from dataclasses import dataclass

from masonry_fem.dynamics.report import StepReport


@dataclass(frozen=True, slots=True)
class Ledger:
    """Energies since the start of a march [J].

    Attributes
    ----------
    external, support : Work of loads and of moving supports.
    contact : Work of the reactions on relative motion (−friction, ± gaps that close).
    friction, damping, numerical : Dissipated by sliding, Rayleigh damping and θ > ½.
    joints, viscous : Dissipated by the damage of joints and by its delay.
    error : Sum of the steps' imbalances. largest : Largest energy seen in any of these.
    """

    external: float = 0.0
    support: float = 0.0
    contact: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    numerical: float = 0.0
    error: float = 0.0
    largest: float = 0.0
    joints: float = 0.0
    viscous: float = 0.0

    def add(self, report: StepReport, inertia: float) -> Ledger:
        """The ledger after one more step."""
        external = self.external + report.external_work
        support = self.support + report.support_work
        numerical = self.numerical + report.numerical_dissipation
        damping = self.damping + report.damping_dissipation
        largest = max(
            self.largest,
            inertia * report.kinetic_energy,
            report.strain_energy,
            abs(external),
            abs(support),
            numerical,
            damping,
        )
        return Ledger(
            external=external,
            support=support,
            contact=self.contact + report.contact_work,
            friction=self.friction + report.friction_dissipation,
            damping=damping,
            numerical=numerical,
            error=self.error + abs(report.energy_error),
            largest=largest,
            joints=self.joints + report.joint_dissipation,
            viscous=self.viscous + report.joint_viscosity,
        )

    @property
    def imbalance(self) -> float:
        """Error relative to the largest term; 0 where no energy moved."""
        return self.error / self.largest if self.largest > 0 else 0.0
