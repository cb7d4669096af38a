"""The contact solver (non-smooth contact dynamics): arrays only.

problem = ContactProblem.plain(W, q, mu)          # or in split form, see problem.py
solution = solve(problem, SolverSettings(tolerance=1e-8))
solution.outcome, solution.quality.error, solution.impulse

Each name is fetched where it is first used: joint laws take functions of this room, and scenes that are only
read shall not wait for SciPy and Numba.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from masonry_fem.nscd.files import load_problem, save_problem
    from masonry_fem.nscd.outcome import Outcome, Solution
    from masonry_fem.nscd.portfolio import solve
    from masonry_fem.nscd.problem import ContactProblem
    from masonry_fem.nscd.residuals import Quality, assess, rounding
    from masonry_fem.nscd.settings import SolverSettings, Start

__all__ = [
    "ContactProblem",
    "Outcome",
    "Quality",
    "Solution",
    "SolverSettings",
    "Start",
    "assess",
    "load_problem",
    "rounding",
    "save_problem",
    "solve",
]

_HOMES = {
    "ContactProblem": "problem",
    "Outcome": "outcome",
    "Quality": "residuals",
    "Solution": "outcome",
    "SolverSettings": "settings",
    "Start": "settings",
    "assess": "residuals",
    "load_problem": "files",
    "rounding": "residuals",
    "save_problem": "files",
    "solve": "portfolio",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'masonry_fem.nscd' has no '{name}'; its names are {', '.join(__all__)}")
    return getattr(import_module(f"masonry_fem.nscd.{_HOMES[name]}"), name)
