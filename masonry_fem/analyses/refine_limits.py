"""Refinement limits: where a refinement ends, and what is said then.

limits = Limits(target=0.05, rounds=10, unknowns=1_000_000)
limits.why_last(rounds, march, 0.07, True, unknowns=4389, growth=3.4)      # "": there is another round
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import psutil

from masonry_fem.host.memory import peak_memory
from masonry_fem.march.march import March
from masonry_fem.results.discretisation import Round

STALLED = 0.9  # two rounds that each leave more of the error, with twice the unknowns, get nowhere
MEMORY = 0.8  # of the machine's that is free may be used
GROWTH = 4 / 3  # of memory with unknowns: what factors of solids take


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a refinement ends: at its target, or after too many rounds or unknowns.

    Attributes
    ----------
    target : Relative error in the energy norm. rounds, unknowns : Most of them.
    idle : Memory that the program had before it solved anything [MB].
    """

    target: float
    rounds: int
    unknowns: int
    idle: float = field(default_factory=peak_memory)

    def reached(self, march: March, error: float, believed: bool) -> bool:
        """Whether a solution is as exact as asked for; ``believed``: its estimate judges all blocks."""
        return march.outcome in ("equilibrium", "finished") and believed and error <= self.target

    def why_last(
        self,
        before: Sequence[Round],
        march: March,
        error: float,
        believed: bool,
        unknowns: int,
        growth: float,
        fixed: float = 0.0,
    ) -> str:
        """Why a solution is the last, as a sentence; "" where there is to be another round.

        ``growth`` is how many times the unknowns the next round would have, ``fixed`` the error that blocks
        have whose elements stay.
        """
        if march.outcome not in ("equilibrium", "finished"):
            return f"Not refined: {march.message}"
        said = f"The error of the stress is estimated at {_percent(error)}"
        if self.reached(march, error, believed):
            return f"{said}; {_percent(self.target)} was asked for."
        missed = f", not {_percent(self.target)}" if error > self.target else ""
        missed += "" if believed else ", and does not show that of blocks one linear element thick"
        why = self._obstacle(before, error, unknowns, growth, fixed)
        return f"{said}{missed}: {why}" if why else ""

    def _obstacle(
        self, before: Sequence[Round], error: float, unknowns: int, growth: float, fixed: float
    ) -> str:
        """Why there can be no further round; "" where there can."""
        if stay := self._staying(growth, fixed):
            return stay
        if _stalls(before, error, unknowns):
            return (
                "it hardly falls as elements become finer, as under point forces and at sharp corners under "
                "load. Spread such forces over faces, and read stresses away from them."
            )
        if len(before) + 1 >= self.rounds:
            return f"{self.rounds} rounds are made. Allow more, or begin with finer elements."
        if unknowns * growth > self.unknowns:
            return (
                f"the next round would have about {unknowns * growth:.2g} unknowns, and {self.unknowns:.2g} "
                "are allowed. Allow more, or take elements of order 2."
            )
        needed = self.idle + (peak_memory() - self.idle) * growth**GROWTH
        free = psutil.virtual_memory().available + psutil.Process().memory_info().rss
        there = MEMORY * free / 1024**2
        if needed <= there:
            return ""
        return (
            f"the next round would need about {needed:.0f} MB of memory, and {there:.0f} MB are free. Take a "
            "larger machine, elements of order 2, or fewer elastic blocks."
        )

    def _staying(self, growth: float, fixed: float) -> str:
        """Whether blocks whose elements stay have too much of the error, as a sentence."""
        advice = "Give a file with finer ones, or with ones of order 2; make reduced blocks elastic."
        if growth == 1.0:
            return f"all blocks are reduced, or came with their elements, which stay. {advice}"
        if fixed > self.target:
            alone = f"which stay, bring {_percent(fixed)} alone. {advice}"
            return f"blocks that are reduced, or came with their elements, {alone}"
        return ""


def _stalls(before: Sequence[Round], error: float, unknowns: int) -> bool:
    if len(before) < 2:
        return False
    older, newer = before[-2:]
    slow = error > STALLED * newer.error and newer.error > STALLED * older.error
    return slow and unknowns > 2 * older.unknowns


def _percent(error: float) -> str:
    return f"{100 * error:.3g} %"
