"""Probe: a joint law at one contact point, for tests and for pictures of its graphs.

``probe`` prescribes the jump, or the tangential jump under a given pressure; ``pull`` prescribes the
far end of a spring in series. Both take the very steps that a structure takes: reduce, solve the
contact exactly, update, until the trial state stays.

    history = probe(law, np.linspace([0, 0], [1e-4, 0], 101))
    history.jump[:, 0], history.stress[:, 0]          # tension and shear positive
    history = probe(law, shear_path, pressure=0.5e6)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Law
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.joints.tangent import linearise
from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]

SETTLED = 1e-13  # change of the trial state that ends a step's iteration
LIMIT = 500  # turns of reduce, solve, update in one step


@dataclass(frozen=True, slots=True)
class History:
    """A path of n steps at c contact points; without the axis (c,) where one point was asked for.

    Attributes
    ----------
    jump : Displacement jump [m], shape (n, c, d).
    reaction : Physical reaction on the candidate side, cohesion included [N], shape (n, c, d).
    area : Tributary area [m²].
    adhesion, demand : β and load over threshold, shape (n, c).
    stored, dissipated, rubbed : Energy of the joint, lost to damage and to friction [J], shape (n, c).
    turns : Turns of the iteration in each step, shape (n,).
    settled : Whether it ended, shape (n,).
    state : Committed state at the end.
    """

    jump: FloatArray
    reaction: FloatArray
    area: float
    adhesion: FloatArray
    demand: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    rubbed: FloatArray
    turns: NDArray[np.int64]
    settled: NDArray[np.bool_]
    state: JointState

    @property
    def stress(self) -> FloatArray:
        """What the joint bears, tension and shear along the jump positive [Pa], shape (n, c, d)."""
        return -self.reaction / self.area

    def work(self) -> FloatArray:
        """Work put into a joint that began at rest, by the trapezoidal rule [J], shape (n, c)."""
        rest = np.zeros_like(self.jump[:1])
        jump, force = np.concatenate([rest, self.jump]), np.concatenate([rest, -self.reaction])
        steps = 0.5 * ((force[1:] + force[:-1]) * np.diff(jump, axis=0)).sum(axis=-1)
        total: FloatArray = np.cumsum(steps, axis=0)
        return total


@dataclass(frozen=True, slots=True)
class _Turn:
    """One solve of the contact: graph reaction, physical reaction, relative velocity."""

    graph: FloatArray
    reaction: FloatArray
    velocity: FloatArray


def probe(
    law: Law,
    jumps: ArrayLike,
    pressure: ArrayLike | None = None,
    area: float = 1.0,
    step: float = 1.0,
    state: JointState | None = None,
    start: ArrayLike | None = None,
) -> History:
    """Drive a joint along prescribed jumps.

    Parameters
    ----------
    jumps : Jump at the end of each step [m], shape (n, d), or (n, c, d) for c points at once; the
        normal one is free under ``pressure``.
    pressure : Normal pressure [Pa], one or shape (n,); None: the normal jump is prescribed.
    area : Tributary area [m²]. step : h [s].
    state, start : Committed state and jump to go on from; None: a fresh joint at zero.

    Raises
    ------
    LawError : A path into compression without a bed or a pressure that could bear it.
    """
    path = np.asarray(jumps, dtype=float)
    pressures = None if pressure is None else np.broadcast_to(np.asarray(pressure, float), (len(path),))

    def solve(
        target: FloatArray, index: int, reduction: Reduction, at: FloatArray, held: FloatArray
    ) -> _Turn:
        push = None if pressures is None else float(pressures[index]) * area
        return _prescribed(reduction, at, (target - at) / step, push, held, step)

    return _march(law, path, solve, area, step, state, start)


def pull(
    law: Law,
    ends: ArrayLike,
    stiffness: ArrayLike,
    area: float = 1.0,
    step: float = 1.0,
    state: JointState | None = None,
    start: ArrayLike | None = None,
    newton: bool = False,
) -> History:
    """Drive a joint by the far end of springs in series, without inertia.

    Parameters
    ----------
    ends : Displacement of the far end [m], shape (n, d) or (n, c, d).
    stiffness : Of the springs, one or shape (d,) [N/m³]. newton : Take the law's tangent instead of
        its secant after the first turn of a step. Others as for ``probe``.
    """
    from masonry_fem.nscd.local import solve_contact  # noqa: PLC0415 - Numba is slow to import

    path = np.asarray(ends, dtype=float)
    d = path.shape[-1]
    block = np.diag(1.0 / (step**2 * area * np.broadcast_to(np.asarray(stiffness, float), d)))

    def solve(
        target: FloatArray, index: int, reduction: Reduction, at: FloatArray, held: FloatArray
    ) -> _Turn:
        blocks = np.broadcast_to(block, (len(at), d, d))
        W, free = reduction.fold(blocks, (target - at) / step, step)
        gap = np.zeros_like(free)
        gap[:, 0] = np.maximum(at[:, 0] - reduction.closure, 0.0) / step
        each = zip(W, free + gap, reduction.friction, strict=True)
        graph = np.array([solve_contact(*contact) for contact in each]) / step
        own = free + step * (W @ graph[:, :, None])[:, :, 0]
        reaction = graph - reduction.adhesive_reaction(own)
        return _Turn(graph, reaction, own - reduction.shift - reduction.compliance * step * reaction)

    return _march(law, path, solve, area, step, state, start, newton)


def _march(
    law: Law,
    path: FloatArray,
    solve: Callable[..., _Turn],
    area: float,
    step: float,
    state: JointState | None,
    start: ArrayLike | None,
    newton: bool = False,
) -> History:
    """All steps of a path with a given way to solve the contacts."""
    n, d = len(path), path.shape[-1]
    targets = path.reshape(n, -1, d)
    c = targets.shape[1]
    committed = law.initial(c, d) if state is None else state
    jump = np.zeros((c, d)) if start is None else np.array(start, dtype=float).reshape(c, d)
    graph, areas = np.zeros((c, d)), np.full(c, area)
    found = {name: np.zeros((n, c, d)) for name in ("jump", "reaction")}
    found |= {name: np.zeros((n, c)) for name in ("adhesion", "demand", "stored", "dissipated", "rubbed")}
    turns, settled = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=bool)
    for index, target in enumerate(targets):
        trial = committed
        turn: Any = None
        for _ in range(LIMIT):
            if turn is None or not newton:
                reduction = law.reduce(trial, jump, areas, step)
            else:
                reduction = linearise(law, committed, trial, jump, turn.reaction, turn.velocity, areas, step)
            turn = solve(target, index, reduction, jump, graph)
            last = trial
            trial = law.update(committed, last, jump, turn.reaction, turn.velocity, areas, step)
            turns[index] += 1
            settled[index] = trial.distance(last) <= SETTLED
            if settled[index]:
                break
        committed, graph, jump = trial.committed(), turn.graph, jump + step * turn.velocity
        found["jump"][index], found["reaction"][index] = jump, turn.reaction
        found["stored"][index] = law.stored(committed, areas)
        for name in ("adhesion", "demand", "dissipated", "rubbed"):
            found[name][index] = getattr(committed, name)
    shaped = {name: values.reshape(*path.shape[:-1], *values.shape[2:]) for name, values in found.items()}
    return History(area=area, turns=turns, settled=settled, state=committed, **shaped)


def _prescribed(
    reduction: Reduction,
    start: FloatArray,
    velocity: FloatArray,
    push: float | None,
    held: FloatArray,
    step: float,
) -> _Turn:
    """Graph and physical reaction at a prescribed relative velocity.

    Only a bed makes the joint yield, W = its compliance; without one the reaction follows from the
    graphs, and a contact that rests keeps what it ``held`` as far as friction lets it.
    """
    B = np.einsum("cii->ci", reduction.stiffness)
    softening = 1.0 / (1.0 + step * reduction.compliance * B)
    W = softening * reduction.compliance
    free = softening * (velocity + reduction.shift - step * reduction.compliance * reduction.offset)
    gap = np.maximum(start[:, 0] - reduction.closure, 0.0) / step
    own, graph = free.copy(), np.zeros_like(free)
    if push is None:
        graph[:, 0] = _normal_reaction(free[:, 0] + gap, W[:, 0], start, velocity, step)
        # debris may hold a joint further open than prescribed
        own[:, 0] = np.maximum(free[:, 0] + W[:, 0] * step * graph[:, 0], -gap)
    else:
        own[:, 0] = -gap
        graph[:, 0] = push + reduction.offset[:, 0] + B[:, 0] * own[:, 0]
    limit = reduction.friction * np.maximum(graph[:, 0], 0.0)
    speed = lengths(free[:, 1:])
    yields = W[:, 1:].max(axis=1) > 0
    stick = np.divide(-free[:, 1:], step * W[:, 1:], out=held[:, 1:].copy(), where=W[:, 1:] > 0)
    force = lengths(stick)
    within = np.where(yields, force <= limit, speed == 0)
    scale = np.where(within, np.minimum(1.0, _ratio(limit, force)), 0.0)
    along = np.where(within, 0.0, _ratio(limit, speed))
    graph[:, 1:] = scale[:, None] * stick - along[:, None] * free[:, 1:]
    own[:, 1:] = free[:, 1:] + W[:, 1:] * step * graph[:, 1:]
    own[within & yields, 1:] = 0.0
    reaction = graph - reduction.adhesive_reaction(own)
    if push is not None or (own[:, 0] != free[:, 0]).any():
        normal = own[:, 0] - reduction.shift[:, 0] - reduction.compliance[:, 0] * step * reaction[:, 0]
        velocity = np.concatenate([normal[:, None], velocity[:, 1:]], axis=1)
    return _Turn(graph, reaction, velocity)


def _normal_reaction(
    approach: FloatArray, W: FloatArray, start: FloatArray, velocity: FloatArray, step: float
) -> FloatArray:
    """Signorini's reaction for a prescribed normal velocity."""
    end = start[:, 0] + step * velocity[:, 0]
    tiny = 1e-12 * (np.abs(start[:, 0]) + np.abs(step * velocity[:, 0]))
    if ((end < -tiny) & (W == 0)).any():
        raise LawError(
            f"normal jump {end.min():g} m closes a joint that is rigid in compression; "
            "prescribe a pressure instead, or put the law on a Bed"
        )
    return np.divide(np.maximum(-approach, 0.0), step * W, out=np.zeros_like(W), where=W > 0)


def _ratio(top: FloatArray, bottom: FloatArray) -> FloatArray:
    return np.divide(top, bottom, out=np.ones_like(top), where=bottom > 0)
