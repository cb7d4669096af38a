"""Staircase: stone steps built into a wall at one end, each resting on the one below."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Count, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure


class StaircaseStructure(Structure, frozen=True, kw_only=True, tag="staircase"):
    """Hanging (cantilevered) staircase of ``steps`` steps: masons' *escalier suspendu*, without a string.

    It rises along x. Each step is ``width`` wide in the clear, goes by ``bearing`` into a wall behind, and
    rests along its front edge on the ``lap`` of the one below. Wall stones above and below the built-in
    ends hold these; they are supports.
    """

    steps: Count
    going: Length
    rise: Length
    width: Length
    lap: Length
    bearing: Length
    position: Point | None = None
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Always: the stones of its wall."""
        return True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its steps, and the stones of the wall below and above each."""
        return Foreseen(3 * self.steps, ("steps",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A plane staircase, a lap as long as a step."""
        if dimension == 2:
            yield "width", "a scene of dimension 3: the wall stands behind the steps"
        if self.lap >= self.going:
            yield "lap", f"less than the going ({self.going:g} m)"
