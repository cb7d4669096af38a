"""Single run: whether a scene as it is stands or falls, and how it falls.

    ended = run_once(scene, Path("."))
    ended.verdict, ended.message, ended.fall

An analysis that seeks equilibrium says it by its outcome. A march in time stands where no stone has fallen
until its end: one that leans by more than 45° or has sunk by its height.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from msgspec import structs

from masonry_fem.analyses.bracket import Verdict
from masonry_fem.analyses.limit import posed
from masonry_fem.analyses.run.reopening import begun
from masonry_fem.analyses.trials import VERDICTS
from masonry_fem.build import build
from masonry_fem.limit import admissible
from masonry_fem.march.march import Observer, march
from masonry_fem.march.mechanism import Falling
from masonry_fem.march.recognition import mechanism_of_state
from masonry_fem.march.toppling import ToppledError, Toppling
from masonry_fem.results.limit import motion_told
from masonry_fem.results.search import Fall
from masonry_fem.scene import specs


@dataclass(frozen=True, slots=True)
class RunEnd:
    """How a run ended.

    Attributes
    ----------
    verdict : Whether the scene stands.
    outcome, message : Of the run, ``toppled`` where a stone has fallen in time; the same as a sentence.
    steps : Made. mechanism : How it falls; None: it does not.
    fall : The same with the structure, for pictures; None: limit analysis, or it does not.
    leans : By how much each stone has leaned at most, by its name [rad]; empty but in time.
    """

    verdict: Verdict
    outcome: str
    message: str
    steps: int
    mechanism: Falling | None = None
    fall: Fall | None = None
    leans: Mapping[str, float] = field(default_factory=dict)


def run_once(
    scene: specs.Scene, base: Path, observers: Sequence[Observer] = (), *, probed: bool = False
) -> RunEnd:
    """Run a scene without writing anything, until it stands, has ended or has fallen.

    Parameters
    ----------
    scene : What to run. base : Folder that the paths in it are relative to.
    observers : Told of every step. probed : Whether they look at the scene's probes.

    Raises
    ------
    MasonryError : The scene cannot be built.
    """
    scene = scene if probed else _unprobed(scene)
    built = build(scene, base)
    built, start = begun(scene, built, base)
    settings, strategy = scene.solver.settings, scene.analysis
    watchers: list[Observer] = list(observers)
    toppling = None
    if strategy.seeks_equilibrium:  # an error of 1e-6 is more than what lies between standing and falling
        settings = replace(settings, acceptable=0.0)
    else:
        toppling = Toppling(built.model, built.bodies, scene.loads.gravity)
        watchers.append(toppling)
    try:
        ended = march(built.model, strategy, settings, bodies=built.bodies, observers=watchers, start=start)
    except ToppledError as toppled:
        mechanism = mechanism_of_state(toppled.model, toppled.state)
        fall = Fall(mechanism, toppled.model, toppled.state)
        leans = {} if toppling is None else toppling.leans
        return RunEnd("falls", "toppled", f"{toppled}.", toppled.state.index, mechanism.told(), fall, leans)
    verdict: Verdict = "stands" if ended.outcome == "finished" else VERDICTS.get(ended.outcome, "undecided")
    if verdict != "falls":
        leans = {} if toppling is None else toppling.leans
        return RunEnd(verdict, ended.outcome, ended.message, ended.state.index, leans=leans)
    fall = Fall.of(ended)
    return RunEnd(verdict, ended.outcome, ended.message, ended.state.index, fall.mechanism.told(), fall)


def ask_limit_analysis(scene: specs.Scene, base: Path) -> RunEnd:
    """Whether rigid blocks in their reference places can carry all loads of a scene.

    Parameters
    ----------
    scene : What to ask of. base : Folder that the paths in it are relative to.

    Raises
    ------
    MasonryError : The scene cannot be built, or a joint has no constant strength.
    """
    scene = _unprobed(scene)
    built = build(scene, base, solved=False)
    problem, _ = posed(scene, built, dead=("*",) if built.model.loads else ())
    found = admissible(problem)
    if found.holds:
        return RunEnd("stands", "carried", "The loads can be carried.", 0)
    mechanism = None if found.mechanism is None else motion_told(problem, found.mechanism)
    return RunEnd("falls", "not carried", "The loads cannot be carried.", 0, mechanism)


def _unprobed(scene: specs.Scene) -> specs.Scene:
    """A scene without its probes: nobody reads them here, and a stone that gets thinner may leave them."""
    return structs.replace(scene, probes=())
