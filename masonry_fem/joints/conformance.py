"""Conformance: what every joint law owes, asked of one law along wandering paths.

For laws of one's own; the laws of this package are asked more in their tests.

    for sentence in violations(Cork(stiffness=1e9)):
        print(sentence)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from masonry_fem.joints.law import Law
from masonry_fem.joints.parameters import FloatArray
from masonry_fem.joints.probe import History, probe

TINY = 1e-9  # of a quantity's greatest value: what rounding may do
POINTS, KNOTS = 10, 8
FINER = 10  # steps between two knots, where energy is counted


@dataclass(frozen=True, slots=True)
class _Test:
    """A law on its way: paths of jumps [m], shape (n, c, 3), under a pressure [Pa] or none."""

    law: Law
    path: FloatArray
    pressure: float | None

    def along(self, path: FloatArray, area: float = 1.0) -> History:
        return probe(self.law, path, pressure=self.pressure, area=area)


def violations(law: Law, size: float = 5e-5, pressure: float = 2e5, seed: int = 0) -> list[str]:
    """What the law does that no joint does, a sentence each; empty where nothing was found.

    Parameters
    ----------
    size : Length of the paths' jumps [m]; choose it so that the joint breaks in some of them.
    pressure : For half of the tests [Pa]. seed : Of the paths.

    Raises
    ------
    LawError : Where the law cannot be driven along the paths at all.
    """
    rng = np.random.default_rng(seed)
    found: list[str] = []
    for push in (None, pressure):
        steps = rng.normal(size=(KNOTS, POINTS, 3)) * rng.uniform(0.1, 1.0, (1, POINTS, 1))
        path = size * np.cumsum(steps, axis=0)
        path[:, :, 0] = np.maximum(path[:, :, 0], 0.0)
        test = _Test(law, path, push)
        whole = test.along(path)
        state = "under pressure" if push else "without pressure"
        asked = (
            _bounds(whole),
            _energy(test),
            _frames(test, whole),
            _areas(test, whole),
            _restart(test, whole),
        )
        found += [f"{sentence} ({state})" for part in asked for sentence in part]
    return found + list(_untouched(law))


def _bounds(whole: History) -> Iterator[str]:
    """Signs, limits and what may only grow or fall."""
    if not whole.settled.all():
        yield f"step {int(whole.settled.argmin())} does not settle: the trial state keeps changing"
    for name in ("dissipated", "rubbed"):
        values = getattr(whole, name)
        lost = np.diff(values, axis=0, prepend=0.0).min()
        if not lost >= -TINY * max(values.max(), 1e-300):
            yield f"{name} shrinks by {-lost:g} J in a step, expected losses never to be given back"
    heals = np.diff(whole.adhesion, axis=0, prepend=1.0).max()
    if not heals <= 0:
        yield f"adhesion grows by {heals:g} in a step, expected never"
    if not whole.adhesion.min() >= 0:
        yield f"adhesion is {whole.adhesion.min():g}, expected 0 to 1"
    for name in ("stored", "demand"):
        least = getattr(whole, name).min()
        if not least >= 0:
            yield f"{name} is {least:g}, expected >= 0"
    if not np.isfinite(whole.reaction).all():
        yield "a reaction is not finite"


def _energy(test: _Test) -> Iterator[str]:
    """Work put in = stored + lost, but for what the trapezoids miss where the force jumps."""
    knots = np.concatenate([np.zeros_like(test.path[:1]), test.path])
    share = (np.arange(1, FINER + 1) / FINER)[None, :, None, None]
    path = (knots[:-1, None] + share * np.diff(knots, axis=0)[:, None]).reshape(-1, POINTS, 3)
    history = test.along(path)
    jump = np.concatenate([np.zeros_like(path[:1]), history.jump])
    longest = np.linalg.norm(np.diff(jump, axis=0), axis=-1).max(axis=0)
    allowed = 3 * np.linalg.norm(history.reaction, axis=-1).max(axis=0) * longest
    missing = history.work() - (history.stored + history.dissipated + history.rubbed)
    worst = np.unravel_index((np.abs(missing) - allowed).argmax(), missing.shape)
    if not np.abs(missing[worst]) <= allowed[worst[1]] + 1e-12:
        yield (
            f"energy {'vanishes' if missing[worst] > 0 else 'appears'}: work and what is stored, dissipated "
            f"and rubbed differ by {abs(missing[worst]):g} J; the steps explain {allowed[worst[1]]:g} J"
        )


def _frames(test: _Test, whole: History) -> Iterator[str]:
    """The same in a tangent frame that is turned, and in the plane."""
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turn = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    if _differ(test.along(test.path @ turn.T).reaction, whole.reaction @ turn.T):
        yield "the reaction depends on how the tangent frame is turned"
    flat = test.path * [1, 1, 0]
    if _differ(test.along(flat[:, :, :2]).reaction, test.along(flat).reaction[:, :, :2]):
        yield "the plane is not space with one direction"


def _areas(test: _Test, whole: History) -> Iterator[str]:
    """Forces and energies in proportion to the area."""
    part = test.along(test.path, area=0.05)
    force = float(np.abs(whole.reaction).max())
    sizes = {"reaction": force} | dict.fromkeys(("stored", "dissipated", "rubbed"), force * test.path.max())
    for name, size in sizes.items():
        if _differ(getattr(part, name), 0.05 * getattr(whole, name), 0.05 * size):
            yield f"{name} is not proportional to the area"


def _restart(test: _Test, whole: History) -> Iterator[str]:
    """The same bits from a state in the middle, and no pull where it is broken."""
    first = test.along(test.path[: KNOTS // 2])
    rest = probe(
        test.law, test.path[KNOTS // 2 :], test.pressure, state=first.state, start=first.jump[-1]
    )  # fmt: skip
    if (rest.reaction != whole.reaction[KNOTS // 2 :]).any():
        yield "a path that goes on from its state in the middle differs: something is remembered elsewhere"
    broken = whole.state.broken
    if broken.any() and test.pressure is None:
        wider = whole.jump[-1] + [1e-5, 0.0, 0.0]
        pulled = probe(test.law, wider[None], state=whole.state, start=whole.jump[-1])
        pull = -pulled.reaction[0, broken, 0].min()
        if pull > TINY * np.abs(whole.reaction).max():
            yield f"a broken joint pulls with {pull:g} Pa, expected none"


def _untouched(law: Law) -> Iterator[str]:
    """A committed state is left alone by a step."""
    state = law.initial(POINTS, 3)
    kept = {name: values.copy() for name, values in state.arrays().items()}
    jump, area = np.zeros((POINTS, 3)), np.ones(POINTS)
    velocity = np.resize([[1e-3, 0, 0], [0, 1e-3, 0]], (POINTS, 3))
    reaction = np.resize([[1e5, -1e6, 0], [-1e7, 0, 0]], (POINTS, 3))
    law.reduce(state, jump, area, 0.1)
    law.update(state, state, jump, reaction, velocity, area, 0.1)
    for name, values in kept.items():
        if (getattr(state, name) != values).any():
            yield f"reduce or update changes {name} of the committed state in place; make a new array"
    if jump.any():
        yield "reduce or update changes the jump in place; make a new array"


def _differ(one: FloatArray, other: FloatArray, size: float | None = None) -> bool:
    """Beyond rounding of the greatest value, or of ``size``."""
    largest = float(np.abs(other).max(initial=0.0)) if size is None else size
    return not np.allclose(one, other, rtol=1e-8, atol=TINY * largest)
