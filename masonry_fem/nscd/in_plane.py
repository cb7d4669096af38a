"""InPlane: a method that solves a problem in space in the plane that its blocks move in.

form = plane_form(problem)
solution = iterate(problem, InPlane(InteriorPoint(), form), settings)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from masonry_fem.nscd.iterate import Iterate, Method, Run
from masonry_fem.nscd.plane import PlaneForm
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start


@dataclass(frozen=True, slots=True)
class InPlane:
    """A method that solves a problem in space in its plane.

    Attributes
    ----------
    inner : The method in the plane.
    form : The problem's form there.
    """

    inner: Method
    form: PlaneForm

    @property
    def name(self) -> str:
        """The inner method's."""
        return self.inner.name

    @property
    def iterations(self) -> int:
        """The inner method's own limit."""
        return self.inner.iterations

    def init(self, problem: ContactProblem, start: Start | None) -> InPlaneRun:
        """A run on the problem that the form was made of."""
        if start is not None:
            given, velocity = start.impulse, start.rigid_velocity
            start = Start(
                None if given is None else self.form.flat_impulse(given),
                None if velocity is None else self.form.flat_velocity(velocity),
            )
        return InPlaneRun(self.inner.init(self.form.problem, start), self.form)


class InPlaneRun:
    """A run in the plane, its offers those in space."""

    def __init__(self, run: Run, form: PlaneForm) -> None:
        self._run, self._form = run, form

    def guess(self) -> Iterate:
        """Where it starts."""
        return self._in_space(self._run.guess())

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """The inner run's next offer; ``quality`` is in space."""
        return self._in_space(self._run.step(quality, settings))

    def _in_space(self, offer: Iterate) -> Iterate:
        impulse, velocity = self._form.impulse(offer.impulse), self._form.velocity(offer.rigid_velocity)
        return replace(offer, impulse=impulse, rigid_velocity=velocity)
