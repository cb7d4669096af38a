"""Path: statics whose loads follow from a displacement that grows, through peaks and snap-backs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.bodies.base import Scheme
from masonry_fem.errors import SceneError
from masonry_fem.march.equilibrium.parts.quasistatic import Quasistatic, equal_parts
from masonry_fem.march.model import Control, Probe
from masonry_fem.records.record import Count, Length, Name, Point


class Path(Quasistatic, frozen=True, kw_only=True, tag="path"):
    """True statics of loads whose factor is an unknown: in each step a displacement grows by the same amount.

    So the curve of load against displacement is followed beyond its peak, also where load and displacement
    both go back (snap-back): let the control be the opening of the crack, or another displacement that only
    grows. Loads without a function of time are multiplied by the load factor; those that are to stay get a
    table that is constant. Time in results is the load factor. Supports stay at rest.

    Attributes
    ----------
    probe : name of the probe whose displacement grows
    against : name of another probe; then the displacement of the first relative to this one grows
    direction : direction of the displacement
    distance : displacement at the end
    load_steps : number of equal parts of the distance

    Examples
    --------
    kind = "path"
    probe = "crown"
    direction = [0.0, -1.0]
    distance = "1 mm"
    load_steps = 20
    """

    probe: Name
    direction: Point
    distance: Length
    against: Name | None = None
    load_steps: Count = 1

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.load_steps

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """Equal parts of the distance, each with the share of it that is reached."""
        return equal_parts(self.load_steps)

    def control(self, probes: tuple[Probe, ...]) -> Control:
        """The displacement that grows."""
        known = {probe.name: probe for probe in probes}
        for key in ("probe", "against"):
            name = getattr(self, key)
            if name is not None and name not in known:
                given = ", ".join(f"'{one}'" for one in known) or "there is none"
                raise SceneError(
                    f"analysis.{key} is '{name}', expected the name of a probe ({given}); correct it, or add "
                    "[[probes]] with this name"
                )
        direction = np.array(self.direction)
        against = None if self.against is None else known[self.against]
        return Control(known[self.probe], against, direction / np.linalg.norm(direction), self.distance)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """No direction."""
        if not any(self.direction):
            yield "direction", "a vector that is not zero"
