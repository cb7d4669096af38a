"""Portfolio: what each part of the contact solver is worth, found by taking it away.

python -m benchmarks.portfolio --cache DIR                        # the table, as Markdown
python -m benchmarks.portfolio --cache DIR --data DIR --json FILE # and the problems (.npz) of a folder
python -m benchmarks.portfolio --cache DIR --only none            # nothing off: is each verdict right?
python -m benchmarks.portfolio --cache DIR --only path,polish

"auto" solves each problem of the trial set to its tolerance (1e-8, of some 1e-10). Then one turn, part
or constant after the other is switched off, here in this process alone, and the problem is solved again where
it had been at work: else it would go exactly as before. A problem is lost where its verdict was right and no
longer is. All that is compared is solved one after the other, and limits are CPU time: other programs that
run change little.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from importlib import import_module
from itertools import compress
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
from rich.progress import track

from benchmarks.trial_set import Size, Trial, trials
from masonry_fem.nscd import ContactProblem, SolverSettings, solve, turns
from masonry_fem.nscd import iterate as looping
from masonry_fem.nscd.iterate import Method
from masonry_fem.nscd.methods import newton
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.solvers import body_solver
from masonry_fem.nscd.solvers.escape import Escape
from masonry_fem.nscd.solvers.flips import Flips
from masonry_fem.nscd.turns import Turn

# the package's name for it is the function
solving = import_module("masonry_fem.nscd.portfolio")

DECIDED = {"converged", "no_equilibrium", "at_limit", "unstressed"}
LIMIT = 60.0  # CPU seconds a problem
CPU = SimpleNamespace(monotonic=time.process_time, process_time=time.process_time)  # the clock of limits
LED = "problems after others"
FEW, MANY = "few contacts", "many contacts"
MOVES = 1e-3  # of the greatest speed: contacts that are slower do not move


@dataclass(frozen=True, slots=True)
class Switch:
    """A part of the solver that can be taken away.

    Attributes
    ----------
    name, kind : What it is called in the table: a turn, a part, a constant.
    owner, attribute : Where it is found; None for turns.
    off : What stands there instead.
    matters : Of what the part gave when it was called, and of its arguments: whether it did anything; None:
        the switch is no function that can be watched, and ``where`` tells the turn that it is a part of ("":
        of all).
    """

    name: str
    kind: str
    owner: Any = None
    attribute: str = ""
    off: Any = None
    matters: Callable[..., bool] | None = None
    where: str = ""


@dataclass(slots=True)
class Row:
    """What was found of a problem: outcome, error and CPU seconds, and what was at work."""

    name: str
    contacts: int
    outcome: str
    error: float
    seconds: float
    method: str
    right: bool
    touched: set[str] = field(default_factory=set)


@dataclass(slots=True)
class Worth:
    """What became of the set without a part; CPU seconds of all problems."""

    name: str
    kind: str
    at_work: int = 0
    lost: list[str] = field(default_factory=list)
    won: list[str] = field(default_factory=list)
    seconds: float = 0.0


# --- what can be taken away ------------------------------------------------------------------------


def switches() -> list[Switch]:
    """All that can be taken away one at a time."""
    names = dict.fromkeys(turn.name for turn in turns.TURNS)
    return [Switch(name, "turn") for name in names] + _parts() + _constants()


def _always(*_: Any) -> bool:
    return True


def _some(made: Any, *_: Any) -> bool:
    return bool(np.any(made))


def _found(made: Any, *_: Any) -> bool:
    return made is not None


def _changed(made: Any, problem: Any, before: Any, *_: Any) -> bool:
    return made is not before


def _parts() -> list[Switch]:
    def nothing(*_: Any, **__: Any) -> None:
        return None

    def as_made(_: Any, made: Any, *rest: Any) -> Any:
        return made

    def no_swing(self: Any, line: Any, *, settled: bool) -> Any:
        return np.zeros_like(self.rough)

    def never(*_: Any, **__: Any) -> bool:
        return False

    kind = "part"
    return [
        Switch("plane form", kind, turns, "plane_form", nothing, _found),
        Switch("flips of rough contacts", kind, Flips, "swinging", no_swing, _some),
        Switch("escape", kind, Escape, "watch", never, _some),
        Switch("krylov iterations", kind, body_solver.BodySolver, "iterates", never, _some),
        Switch("brought to rest", kind, solving, "brought_to_rest", as_made, _changed),
        Switch("fall of closed contacts", kind, solving, "falling", nothing, _found),
        Switch("limit of elastic blocks", kind, turns, "at_limit", never, _some),
    ]


def _constants() -> list[Switch]:
    def made(method: Method) -> tuple[Turn, ...]:
        """The turns with this interior point."""
        return tuple(
            replace(turn, make=lambda _: method) if turn.name == "interior point" else turn
            for turn in turns.TURNS
        )

    kind = "constant"
    return [
        Switch("few contacts as many", kind, turns, "MANY", 0, where=FEW),
        Switch("many contacts as few", kind, turns, "MANY", 10**9, where=MANY),
        Switch("newton's crawl", kind, newton, "_CRAWL", 10**9),
        Switch("later rounds as brief as first ones", kind, turns, "LED_STEPS", turns.BRIEF, where=LED),
        Switch("interior point slides at once", kind, turns, "TURNS",
               made(InteriorPoint(align=0.0, sliding=0.0)), where="interior point"),
        Switch("interior point's shorter steps", kind, turns, "TURNS",
               made(InteriorPoint(align=0.0, to_boundary=0.9999)), where="interior point"),
    ]  # fmt: skip


# --- runs ------------------------------------------------------------------------------------------


def solved(trial: Trial, limit: float, method: str = "auto") -> Row:
    """What the solver makes of a problem within CPU seconds."""
    settings = SolverSettings(method=method, tolerance=trial.tolerance, time_limit=limit)
    before = time.process_time()
    with patch.object(looping, "time", CPU), patch.object(solving, "time", CPU):
        made = solve(trial.problem, settings, trial.start)
    seconds = time.process_time() - before
    told = made.outcome.value
    right = trial.right is None or told in trial.right
    if trial.joints is not None:
        right = right and moving_joints(trial.problem, made.velocity) == trial.joints
    return Row(trial.name, trial.problem.count, told, made.quality.error, seconds, made.method, right)


def moving_joints(problem: ContactProblem, velocity: np.ndarray) -> int:
    """How many joints open or slide, with velocities (c, d) at the contacts."""
    speed = np.linalg.norm(velocity, axis=1)
    return len(np.unique(problem.bodies[speed > MOVES * speed.max(initial=0.0)], axis=0))


def measured(
    given: Sequence[Trial],
    parts: Sequence[Switch],
    limit: float,
    keep: Callable[[list[Row], list[Worth]], None] = lambda base, worths: None,
) -> tuple[list[Row], list[Worth]]:
    """The set as it is, and without each part; ``keep`` gets what is known after each problem."""
    base: list[Row] = []
    worths = [Worth(part.name, part.kind) for part in parts]
    for trial in track(given, description="solving"):
        row = as_it_is(trial, limit)
        base.append(row)
        works = [_works(part, row) for part in parts]
        for part, worth in compress(zip(parts, worths, strict=True), works):
            without(part, trial, row, worth, limit)
        if any(works):  # the machine may have become slower
            row.seconds = 0.5 * (row.seconds + solved(trial, limit).seconds)
        for worth, at_work in zip(worths, works, strict=True):
            worth.seconds += 0.0 if at_work else row.seconds
        keep(base, worths)
    return base, worths


def as_it_is(trial: Trial, limit: float) -> Row:
    """A problem with all parts, and the names of those that were at work."""
    seen: set[str] = set()
    with _watched(switches(), seen):
        row = solved(trial, limit)
    seen.add(FEW if trial.problem.count < turns.MANY else MANY)
    if trial.start is not None and trial.start.velocity is not None:
        seen.add(LED)
    if trial.right is None:  # nobody knows better
        row.right = row.outcome in DECIDED
    row.touched = seen
    return row


def without(part: Switch, trial: Trial, row: Row, worth: Worth, limit: float) -> None:
    """Add a problem, solved without a part, to what that is worth."""
    with switched_off(part):
        made = solved(trial, limit)
    right = made.right
    if trial.right is None:  # what all parts together say, if they decide
        right = made.outcome == row.outcome if row.right else made.outcome in DECIDED
    worth.at_work += 1
    worth.seconds += made.seconds
    if row.right and not right:
        worth.lost.append(f"{trial.name}: {made.outcome}, {made.error:.0e}")
    elif right and not row.right:
        worth.won.append(trial.name)


def _works(part: Switch, row: Row) -> bool:
    if part.kind == "turn" or part.matters is not None:
        return part.name in row.touched
    return not part.where or part.where in row.touched


@contextmanager
def switched_off(part: Switch) -> Iterator[None]:
    """The solver without a part; a problem always keeps its first turn where it would have none."""
    if part.kind != "turn":
        with patch.object(part.owner, part.attribute, part.off):
            yield
        return
    original = turns.turns

    def fewer(*given: Any) -> Iterator[Turn]:
        kept = 0
        for turn in original(*given):
            if turn.name != part.name:
                kept += 1
                yield turn
        if not kept:
            yield from original(*given)

    with patch.object(solving, "turns", fewer):
        yield


@contextmanager
def _watched(parts: Sequence[Switch], seen: set[str]) -> Iterator[None]:
    """The solver as it is; names of turns and parts that are at work go to ``seen``."""
    original = turns.turns

    def watched(*given: Any) -> Iterator[Turn]:
        for turn in original(*given):
            seen.add(turn.name)
            yield turn

    with ExitStack() as stack:
        stack.enter_context(patch.object(solving, "turns", watched))
        for part in parts:
            if part.matters is not None:
                spy = _spy(part, getattr(part.owner, part.attribute), seen)
                stack.enter_context(patch.object(part.owner, part.attribute, spy))
        yield


def _spy(part: Switch, original: Callable[..., Any], seen: set[str]) -> Callable[..., Any]:
    matters = part.matters
    assert matters is not None

    def spy(*given: Any, **keys: Any) -> Any:
        made = original(*given, **keys)
        if matters(made, *given):
            seen.add(part.name)
        return made

    return spy


# --- the table -------------------------------------------------------------------------------------


def told(base: Sequence[Row], worths: Sequence[Worth]) -> str:
    """The table, as Markdown."""
    seconds, right = sum(row.seconds for row in base), sum(row.right for row in base)
    verdicts = [row.outcome for row in base]
    counted = ", ".join(f"{verdicts.count(name)} {name}" for name in sorted(set(verdicts)))
    lines = [
        f"{len(base)} problems, {min(r.contacts for r in base)} to {max(r.contacts for r in base)} contacts, "
        f"{right} right verdicts ({counted}), {seconds:.0f} s of CPU.",
        "",
        "| off | kind | at work in | lost | won | CPU |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {w.name} | {w.kind} | {w.at_work} | {len(w.lost)} | {len(w.won)} | {w.seconds / seconds:.2f} |"
        for w in worths
    ]
    wrong = [f"- {row.name}: {row.outcome}, error {row.error:.0e}" for row in base if not row.right]
    return "\n".join(lines + (["", "Not right with all parts:", "", *wrong] if wrong else []))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--cache", type=Path, required=True, help="folder that the set's problems are kept in"
    )
    parser.add_argument("--size", choices=("tiny", "default"), default="default")
    parser.add_argument("--data", type=Path, action="append", default=[], help="folder of further problems")
    parser.add_argument(
        "--only", default="", help="names of parts, with commas; none: nothing is switched off"
    )
    parser.add_argument("--limit", type=float, default=LIMIT, help="CPU seconds a problem")
    parser.add_argument("--json", type=Path, help="write what was found of each problem to this file")
    given = parser.parse_args()
    table(given.cache, given.size, tuple(given.data), given.only, given.limit, given.json)


def table(cache: Path, size: Size, more: tuple[Path, ...], only: str, limit: float, out: Path | None) -> None:
    """Run and print; ``only`` names the parts to be switched off, "" all."""
    parts = [part for part in switches() if not only or part.name in only.split(",")]
    problems = list(trials(cache, size, more))
    for trial in problems[:: max(len(problems) // 8, 1)]:  # compiled code is loaded, not timed
        solved(trial, limit)
    print(told(*measured(problems, parts, limit, partial(save, out))))


def save(out: Path | None, base: Sequence[Row], worths: Sequence[Worth]) -> None:
    """What is known so far, as JSON: a run of half an hour may be cut off."""
    if out is None:
        return
    rows = [asdict(row) | {"touched": sorted(row.touched)} for row in base]
    out.write_text(json.dumps({"rows": rows, "worths": [asdict(one) for one in worths]}, indent=1))


if __name__ == "__main__":
    main()
