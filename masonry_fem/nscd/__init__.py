"""The contact solver (non-smooth contact dynamics): arrays only.

problem = ContactProblem.plain(W, q, mu)          # or in split form, see problem.py
solution = solve(problem, SolverSettings(tolerance=1e-8))
solution.outcome, solution.quality.error, solution.impulse
"""

from masonry_fem.nscd.files import load_problem, save_problem
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality, assess
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solve import solve

__all__ = [
    "ContactProblem",
    "Outcome",
    "Quality",
    "Solution",
    "SolverSettings",
    "Start",
    "assess",
    "load_problem",
    "save_problem",
    "solve",
]
