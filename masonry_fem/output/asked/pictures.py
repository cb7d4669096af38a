"""PNG sheets at the end."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.march.recognition import mechanism_of_step
from masonry_fem.output.cut import Plane, draw_cut
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.picture import draw_all
from masonry_fem.output.recorder import LastState, Request
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.output.strength import Strengths

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy
    from masonry_fem.march.march import March

JOINT_PICTURES = {"thrust", "opening", "sliding"}


def recorder(request: Request) -> Pictures:
    """Pictures of the end, and the cuts that are asked for."""
    asked = request.asked
    planes = [Plane(one.name, one.point, one.normal, one.show) for one in asked.cuts]
    only = None if asked.pictures is True else frozenset(asked.pictures)
    joints = asked.interfaces or bool(only and only & JOINT_PICTURES)
    return Pictures(
        request.folder, request.title, asked.amplification, joints=joints, cuts=planes,
        strengths=request.strengths, only=only,
    )  # fmt: skip


class Pictures(LastState):
    """Recorder that draws the last state when the run ends.

    Parameters
    ----------
    directory : Folder for them. title : First line of each.
    amplification : Of displacements; None to choose one.
    joints : Draw the thrust and the maps of openings and slides, too. cuts : Sections to draw.
    strengths : Of the stones, for their utilisation.
    only : Names of the wanted pictures; None for all.
    """

    draws = True

    def __init__(
        self, directory: Path, title: str = "", amplification: float | None = None, *,
        joints: bool = False, cuts: Sequence[Plane] = (), strengths: Strengths | None = None,
        only: Collection[str] | None = None,
    ) -> None:  # fmt: skip
        self._directory, self._title, self._amplification = Path(directory), title, amplification
        self._joints, self._cuts, self._strengths = joints, tuple(cuts), strengths
        self._only = only
        self._end: March | None = None

    def end(self, made: March, determinacy: ForceDeterminacy | None) -> None:
        """Keep how it ended."""
        self._end = made

    def close(self, summary: Any) -> list[Path]:
        """Draw, where this machine can."""
        last = self.taken()
        # who has pressed Ctrl-C does not want to wait for pictures
        if last is None or summary.outcome in ("interrupted", "failed") or not can_render():
            return []
        scenery = Scenery.of(*last, title=self._title, joints=self._joints, strengths=self._strengths)
        paths = draw_all(scenery, self._directory, self._amplification, self._only)
        for plane in self._cuts:
            paths += draw_cut(scenery, plane, self._directory, self._amplification)
        return paths + self._mechanism()

    def _mechanism(self) -> list[Path]:
        """Where there is no equilibrium: how it falls, from where it was when the last step began."""
        made = self._end
        wanted = self._only is None or "mechanism" in self._only
        if made is None or made.outcome != "no_equilibrium" or not wanted:
            return []
        found = mechanism_of_step(made.last, made.model)
        if not found.parts:
            return []
        scenery = Scenery.of(made.model, made.last.before, title=self._title)
        return [draw_mechanism(scenery, found, self._directory / "mechanism.png")]
