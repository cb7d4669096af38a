"""Limit analysis: rigid blocks, associated joints; what loads they can carry, by linear and conic programs.

    problem = limit_problem(model, dead, live)
    admissible(problem).holds
    collapse_multiplier(problem).multiplier
    interval(problem, support_resultant(problem, block, axis=0))

Read problem -> program -> questions.
"""

from masonry_fem.limit.problem import Hold, LimitProblem, group_forces, limit_problem
from masonry_fem.limit.questions import (
    Admissible,
    Collapse,
    Interval,
    admissible,
    collapse_multiplier,
    hold_resultant,
    interface_resultant,
    interval,
    support_resultant,
)
from masonry_fem.march.mechanism import Mechanism

__all__ = [
    "Admissible",
    "Collapse",
    "Hold",
    "Interval",
    "LimitProblem",
    "Mechanism",
    "admissible",
    "collapse_multiplier",
    "group_forces",
    "hold_resultant",
    "interface_resultant",
    "interval",
    "limit_problem",
    "support_resultant",
]
