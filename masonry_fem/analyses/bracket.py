"""Bracket: the greatest multiplier that stands and the least that falls, closed in by trials.

    bracket = Bracket(attempt, tolerance=0.01, first=0.1)
    bracket.search(start=0.0, guess=None)
    bracket.stands, bracket.falls, bracket.doubtful, bracket.ending

``between`` does the same where a multiplier that stands and one that falls are known from the start.

A trial may be undecided. Then the gaps to what stands and to what falls are halved, until either end is
as near to the doubtful range as the tolerance says: that range is told, and never counts as a fall.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

Verdict = Literal["stands", "falls", "undecided"]
Ending = Literal["bracketed", "undecided", "unlimited", "falls at the start", "interrupted"]

GREATEST = 1e4  # times the first stride: what grows so far has no limit
MOST = 60  # trials
EARLY = 4  # trials after which a search ends in which none has stood
NEAR = 0.4  # of the tolerance: how near to a guess the first trials are
SMALLEST = 1e-9  # of the first stride: a bracket that narrow is none


class Bracket:
    """What is known of a collapse multiplier.

    Parameters
    ----------
    attempt : Multiplier → verdict.
    tolerance : Greatest width of the bracket over its larger end. first : First stride without a guess.
    least : Width of a bracket that is not narrowed, even near 0; None: next to nothing of the first stride.
    whole : Whether multipliers are whole numbers.

    Attributes
    ----------
    stands, falls : Greatest multiplier that stood and least that fell; None: none did.
    ending : How the search ended; ``interrupted`` as long as it has not.
    trials : Number of them.
    """

    def __init__(
        self,
        attempt: Callable[[float], Verdict],
        *,
        tolerance: float,
        first: float,
        least: float | None = None,
        whole: bool = False,
    ) -> None:
        self._attempt, self._tolerance, self._first = attempt, tolerance, first
        self._least, self._whole = SMALLEST * first if least is None else least, whole
        self._undecided: list[float] = []
        self.stands: float | None = None
        self.falls: float | None = None
        self.ending: Ending = "interrupted"
        self.trials = 0

    @property
    def doubtful(self) -> list[float]:
        """Undecided multipliers between what stands and what falls, from the least on."""
        low = -math.inf if self.stands is None else self.stands
        high = math.inf if self.falls is None else self.falls
        return sorted(value for value in self._undecided if low < value < high)

    def search(self, start: float, guess: float | None, *, sharp: bool = False) -> None:
        """Try ``start``, then the ``guess`` (both sides of it, if it is ``sharp``), and close in.

        A start that is undecided does not end it: what grows may be what lets a structure be solved.
        """
        if self.attempt(start) == "falls":
            self.ending = "falls at the start"
            return
        self._expand(start, guess, sharp)
        if self.falls is None and not self.doubtful:
            self.ending = "unlimited"
            return
        self._close_in()

    def between(self, start: float, end: float, guess: float | None) -> None:
        """Try ``start`` and ``end``, of which the larger falls, both sides of the ``guess``, and close in."""
        for multiplier in (start, end):
            self.attempt(multiplier)
        margin = 0.0 if guess is None else NEAR * max(self._tolerance * abs(guess), self._least)
        for side in () if guess is None else (guess - margin, guess + margin):
            if start < side < end:
                self.attempt(side)
        self._close_in()

    def _close_in(self) -> None:
        """Halve the widest gap until all are narrow."""
        while self.trials < MOST and (gaps := self._gaps()):
            below, above = max(gaps, key=lambda gap: gap[1] - gap[0])
            self.attempt(0.5 * (below + above))
        self.ending = "bracketed" if not self.doubtful and not self._gaps() else "undecided"

    def attempt(self, multiplier: float) -> Verdict:
        """One trial."""
        multiplier = round(multiplier) if self._whole else multiplier
        verdict = self._attempt(multiplier)
        self.trials += 1
        if verdict == "undecided":
            self._undecided.append(multiplier)
        elif verdict == "stands":
            self.stands = multiplier if self.stands is None else max(self.stands, multiplier)
        else:
            self.falls = multiplier if self.falls is None else min(self.falls, multiplier)
        return verdict

    def _expand(self, start: float, guess: float | None, sharp: bool) -> None:
        """Multipliers that grow until one falls."""
        here, stride = start, self._first
        if guess is not None and guess > start:
            margin = 1 + NEAR * self._tolerance if sharp else 1.0
            here, stride = margin * guess, 4 * self._tolerance * guess
            if self.attempt(here) == "falls":
                if sharp and guess / margin > start:
                    self.attempt(guess / margin)
                return
        end = here + GREATEST * max(stride, self._first)
        most = MOST if self.stands is not None else EARLY
        while self.falls is None and here < end and self.trials < most:
            here, stride = here + stride, 2 * stride
            most = MOST if self.attempt(here) == "stands" else most

    def _gaps(self) -> list[tuple[float, float]]:
        """Ranges of multipliers, wider than the tolerance, that nothing is known of."""
        ends = [*([] if self.stands is None else [self.stands]), *self.doubtful]
        ends += [] if self.falls is None else [self.falls]
        if len(ends) < 2:
            return []
        # between two undecided ones nothing would be gained
        found = {(ends[0], ends[1])} if self.stands is not None else set()
        if self.falls is not None:
            found.add((ends[-2], ends[-1]))
        least = max(self._tolerance * max(abs(ends[0]), abs(ends[-1])), self._least)
        return [gap for gap in found if gap[1] - gap[0] > least]
