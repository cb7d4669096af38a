"""Recorder: something that is told of every step of a march and leaves files or a display.

    recorders = Recorders([History(out), FieldFiles(out), Pictures(out)], every=10)
    recorders.start(model)
    recorders.record(model, state, report)      # each step
    paths = recorders.close(summary)            # also after Ctrl-C: the files are readable

A march calls nothing else. ``close`` may come at any time, even before the first step.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from masonry_fem.errors import MasonryError
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy
    from masonry_fem.march.march import March
    from masonry_fem.output.strength import Strengths

logger = logging.getLogger(__name__)


class StepReport(Protocol):
    """What recorders ask of a step's report; any further field of it goes to ``history.csv`` too."""

    @property
    def time(self) -> float:
        """End of the step [s] (load factor in statics)."""
        ...

    @property
    def step(self) -> int:
        """Number of the step, 0 for the starting state."""
        ...


@dataclass(frozen=True, slots=True)
class Request:
    """What a recorder is made for.

    Attributes
    ----------
    folder : Where its files go. title : Of the scene.
    asked : The scene's ``[output]``. statics : Whether the analysis is one.
    materials : Of the blocks, by their numbers.
    strengths : Of the blocks; None where no stone has one.
    """

    folder: Path
    title: str
    asked: Any
    statics: bool
    materials: Sequence[str]
    strengths: Strengths | None = None


class Recorder(Protocol):
    """One output: it is called at the start, after each step and at the end, and writes its files.

    Further methods are optional. ``end(march, determinacy)`` is called after the last step with the outcome.
    ``finish()`` returns the files that are written after all others, including the summary. An output that
    remembers steps has ``saved()``, which returns texts and numbers for a checkpoint, and
    ``go_on(model, saved)``, which is called instead of ``start`` if a run continues from one.
    """

    dense: bool
    """Whether it is called after every step (a history), or only every ``output.every`` steps."""

    def start(self, model: Model) -> None:
        """Called once before the first step."""
        ...

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Called after a step; the state is not changed later, so it may be kept."""
        ...

    def close(self, summary: Any) -> list[Path]:
        """Finish the files and return their paths; it may be called at any time, and more than once.

        ``summary`` has what ``summary.json`` will hold as far as it is known, at least an ``outcome``.
        """
        ...


class LastState:
    """What recorders share that write of the last state only: they keep it, which costs nothing."""

    dense = True
    amendable = True
    last: tuple[Model, SystemState] | None = None

    def start(self, model: Model) -> None:
        """Nothing is written before the end."""

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Keep the state."""
        self.last = model, state

    def taken(self) -> tuple[Model, SystemState] | None:
        """The state, which is written once."""
        last, self.last = self.last, None
        return last


@dataclass(frozen=True, slots=True)
class _Moment:
    model: Model
    state: SystemState
    report: StepReport


class Recorders:
    """Several recorders as one, which get the first step, each ``every``-th and the last.

    A recorder that fails loses only its own output: the failure is logged once, the march and the other
    recorders go on. Errors that a user can remedy (``MasonryError``) and interruptions are raised.

    Parameters
    ----------
    members : The recorders.
    every : Steps between two records; a recorder that is ``dense`` gets all of them.

    Raises
    ------
    ValueError : ``every`` is below 1.
    """

    dense = True

    def __init__(self, members: Sequence[Recorder], every: int = 1) -> None:
        if every < 1:
            raise ValueError(f"every is {every}, expected >= 1")
        self._members = list(members)
        self._every = every
        self._count = 0
        self._pending: _Moment | None = None

    def start(self, model: Model) -> None:
        """Start all members."""
        for member in list(self._members):
            self._guard(member, "start", model)

    def saved(self) -> dict[str, Any]:
        """What the members remember, for a checkpoint."""
        members = {type(member).__name__: self._guard(member, "saved") for member in self._saving}
        return {"count": self._count, "members": members}

    def go_on(self, model: Model, saved: dict[str, Any]) -> None:
        """Start all members, those that remember steps from where these were saved."""
        known = saved["members"]
        self._count = saved["count"]
        for member in list(self._members):
            own = known.get(type(member).__name__)
            if own is None or member not in self._saving:
                self._guard(member, "start", model)
            else:
                self._guard(member, "go_on", model, own)

    @property
    def _saving(self) -> list[Any]:
        """Members that remember steps."""
        return [member for member in self._members if hasattr(member, "saved")]

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Pass the step to the dense members, and to the others when their turn has come."""
        due = self._count % self._every == 0
        self._count += 1
        self._pending = None if due else _Moment(model, state, report)
        for member in list(self._members):
            if due or member.dense:
                self._guard(member, "record", model, state, report)

    def end(self, made: March, told: ForceDeterminacy | None) -> None:
        """Tell those who ask how the march ended, and what forces are determined, where that is known.

        The state with these forces takes the place of the last one, for the members that can (``amendable``).
        """
        if told is not None and self._pending is not None:
            self._pending = _Moment(made.model, told.state, made.report)
        for member in list(self._members):
            amends = getattr(member, "amendable", False) and (member.dense or self._pending is None)
            if told is not None and amends:
                self._guard(member, "record", made.model, told.state, made.report)
            if hasattr(member, "end"):
                self._guard(member, "end", made, told)

    def undrawn(self) -> None:
        """Leave out the members that draw (``draws``)."""
        self._members = [member for member in self._members if not getattr(member, "draws", False)]

    def close(self, summary: Any) -> list[Path]:
        """Give the thinned members the last step if they have not seen it, then close all."""
        last, self._pending = self._pending, None
        if last is not None:
            for member in list(self._members):
                if not member.dense:
                    self._guard(member, "record", last.model, last.state, last.report)
        paths: list[Path] = []
        for member in list(self._members):
            made = self._guard(member, "close", summary) or []
            if isinstance(made, list | tuple):
                paths.extend(map(Path, made))
            else:
                logger.error(
                    "%s gives %r in close, expected a list of its files", type(member).__name__, made
                )
        return paths

    def finish(self) -> list[Path]:
        """What those write who need the files of all others."""
        finishing = [member for member in self._members if hasattr(member, "finish")]
        return [path for member in finishing for path in self._guard(member, "finish") or []]

    def _guard(self, member: Recorder, method: str, *arguments: Any) -> Any:
        try:
            return getattr(member, method)(*arguments)
        except MasonryError:
            raise
        except Exception:
            logger.exception("%s failed in %s and is left out from here on", type(member).__name__, method)
            self._members.remove(member)
            return None
