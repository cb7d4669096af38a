"""Result: what a run leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from msgspec import structs

from masonry_fem.build import Built
from masonry_fem.build.strengths import strengths_of
from masonry_fem.march.march import March
from masonry_fem.results.summary import Summary
from masonry_fem.results.tables import table_of

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy
    from masonry_fem.output.notebook import Picture
    from masonry_fem.scene.specs import Scene


@dataclass(frozen=True, slots=True)
class RunResult:
    """Results of a run.

    Attributes
    ----------
    summary : What ``summary.json`` holds, as attributes.
    files : Paths of the files written.
    built : The model, for further work in Python.
    march : The last step, with its state and the sums of the energies.
    determinacy : Which forces are determined, that is, equal in all solutions, if the scene asks for it.
    scene : What was solved.
    """

    summary: Summary
    files: list[Path]
    built: Built
    march: March
    determinacy: ForceDeterminacy | None = None
    scene: Scene | None = None

    @property
    def outcome(self) -> str:
        """``equilibrium``, ``finished``, ``no_convergence`` or ``no_equilibrium``."""
        return self.summary.outcome

    @property
    def message(self) -> str:
        """The outcome as a sentence."""
        return self.summary.message

    def table(self, name: str, *, frame: bool = False) -> Any:
        """A table that the run wrote, as a dict from heading to array.

        Parameters
        ----------
        name : Name of the file without ``.csv``, such as ``stones``, ``interfaces`` or ``history``.
        frame : Whether to return a pandas ``DataFrame`` instead.

        Raises
        ------
        OutputError : There is no such table, or pandas is not installed.
        """
        return table_of(self.files, name, frame=frame)

    def plot(self, name: str | None = None, *, amplification: float | None = None) -> Picture:
        """A picture of the last state, which a notebook shows and whose ``save(path)`` writes a PNG file.

        Parameters
        ----------
        name : A name that ``output.pictures`` takes, such as ``deformed``, ``von_mises`` or ``thrust``;
            None: ``overview`` where stones have stresses, else ``deformed``.
        amplification : Factor of the displacements; None: chosen by their size.

        Raises
        ------
        OutputError : The results have no data for this picture, or PyVista is not installed.
        """
        from masonry_fem.output.notebook import picture_of  # noqa: PLC0415 - only who asks needs it

        strengths = None if self.scene is None else strengths_of(self.scene, self.built.stones)
        return picture_of(
            self.march, self.determinacy, self.summary, name, amplification=amplification, strengths=strengths
        )

    def telling(self, **keys: Any) -> Self:
        """The same with other values in its summary."""
        return replace(self, summary=structs.replace(self.summary, **keys))

    def _repr_html_(self) -> str:
        """The console's table, for notebooks."""
        from masonry_fem.output.notebook import summary_html  # noqa: PLC0415 - only notebooks need it

        return summary_html(self.summary)

    def __repr__(self) -> str:
        """A short table."""
        return repr(self.summary)
